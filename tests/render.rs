//! Final pictures against what geometry says of them.

use glam::{DMat4, DQuat, DVec3};
use image::RgbaImage;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, LightRecord};
use klieg::math::color::{srgb_decode, srgb_encode};
use klieg::render::{self, Background, Picture, Settings, Stage, ToneMapping};
use klieg::scene::Scene;
use klieg::scene::occluders::Occluders;
use klieg::scene::view::View;
use klieg_support::shapes::{matt, orthographic, rectangle, scene, sphere};

/// A ball of radius 0.5 before a wall: it stands at (0, 0, 1), the wall in the plane z = 0.
fn ball_and_wall() -> Scene {
    let ball = DMat4::from_translation(DVec3::Z) * DMat4::from_scale(DVec3::splat(0.5));
    scene([(rectangle(3.0, 3.0), matt(0.8), DMat4::IDENTITY), (sphere(12), matt(0.8), ball)])
}

/// Directional light from the right, 45 degrees from the wall's normal.
fn from_the_right(size: f32) -> LightRecord {
    let azimuth = std::f32::consts::FRAC_PI_4;
    Light { kind: LightKind::DIRECTIONAL, azimuth, size, specular: 0.0, ..Light::default() }
        .record()
}

struct Shown {
    scene: Scene,
    view: View,
    shading: Shading,
    occluders: Occluders,
}

impl Shown {
    fn new(scene: Scene, half_height: f64, width: u32, height: u32) -> Self {
        let view = orthographic(&scene, half_height, width, height);
        let occluders = Occluders::new(&scene, &view).expect("occluders");
        Self { scene, view, shading: Shading::default(), occluders }
    }

    fn draw(&self, light: LightRecord, settings: &Settings, shadows: bool) -> Picture {
        let Self { scene, view, shading, occluders } = self;
        let occluders = shadows.then_some(occluders);
        let stage = Stage { scene, view, shading, occluders };
        render::draw(&stage, &[light], settings).expect("a picture")
    }

    /// The pixel that shows the point (x, y) of the wall, whose picture is `2·half` high.
    fn at(&self, image: &RgbaImage, half: f64, x: f64, y: f64) -> [u8; 4] {
        let (width, height) = (f64::from(self.view.width), f64::from(self.view.height));
        let scale = height / (2.0 * half);
        let (column, row) = (width / 2.0 + x * scale, height / 2.0 - y * scale);
        image.get_pixel(column as u32, row as u32).0
    }
}

#[test]
fn a_ball_has_its_shadow_where_it_must_be() {
    let shown = Shown::new(ball_and_wall(), 2.5, 80, 80);
    let settings = Settings { samples: 4, ..Settings::default() };
    let picture = shown.draw(from_the_right(0.0), &settings, true);
    // Light falls along (-1, 0, -1): the shadow is an ellipse around (-1, 0), √2/2 wide to either side.
    let brightness = |x: f64, y: f64| shown.at(&picture.image, 2.5, x, y)[0];
    let lit = brightness(2.0, 1.5);
    for (x, y, shadow) in [
        (-1.0, 0.0, true),
        (-1.6, 0.0, true),
        (-1.85, 0.0, false),
        (-1.0, 0.4, true),
        (-1.0, 0.6, false),
        (-1.0, -0.4, true),
        (1.0, 0.0, false),
        (-2.2, 0.0, false),
    ] {
        assert_eq!(brightness(x, y) < lit / 2, shadow, "{x} {y}: {}", brightness(x, y));
    }
    let free = shown.draw(from_the_right(0.0), &settings, false);
    let brightness = |x: f64, y: f64| shown.at(&free.image, 2.5, x, y)[0];
    assert_eq!(brightness(-1.0, 0.4), brightness(2.0, 1.5));
    assert!(picture.unlit > free.unlit + 0.02, "{} {}", picture.unlit, free.unlit);
}

#[test]
fn light_from_below_a_polygon_s_horizon_is_shadowed_by_what_stands_there() {
    // Normals are bent to the right, where a light stands a little behind the wall, and a ball before it.
    let mut wall = rectangle(1.0, 1.0);
    wall.vertices.iter_mut().for_each(|vertex| vertex.normal = [0.9, 0.0, 0.435_89]);
    let place = DVec3::new(1.6, 0.0, 0.0);
    let ball = DMat4::from_translation(place) * DMat4::from_scale(DVec3::splat(0.3));
    let parts = [(wall, matt(0.8), DMat4::IDENTITY), (sphere(12), matt(0.8), ball)];
    let shown = Shown::new(scene(parts), 1.0, 64, 32);
    let azimuth = 95f32.to_radians();
    let kind = LightKind::DIRECTIONAL;
    let light = Light { kind, azimuth, specular: 0.0, ..Light::default() }.record();
    let settings = Settings { samples: 1, ..Settings::default() };
    let image = shown.draw(light, &settings, true).image;
    // The picture's middle is that of the view: the eye stands on the z axis.
    let [behind, beside] = [0.0, 0.7].map(|y| shown.at(&image, 1.0, 0.0, y)[0]);
    assert!(behind < 60 && beside > 150, "{behind} {beside}");
}

#[test]
fn a_light_with_a_size_has_a_soft_shadow_of_the_same_middle() {
    let shown = Shown::new(ball_and_wall(), 2.5, 80, 80);
    let settings = Settings { samples: 4, ..Settings::default() };
    let grey = |size: f32| {
        let image = shown.draw(from_the_right(size), &settings, true).image;
        let lit = shown.at(&image, 2.5, 2.0, 1.5)[0];
        let dark = shown.at(&image, 2.5, -1.0, 0.0)[0];
        let row = (0..80).map(|y| shown.at(&image, 2.5, -1.0, 2.4 - f64::from(y) * 0.06)[0]);
        let between = row.filter(|&v| v > dark + 12 && v + 12 < lit).count();
        (between, dark, lit)
    };
    let (hard, dark, lit) = grey(0.0);
    let (soft, dark_soft, lit_soft) = grey(0.15);
    assert!(hard <= 2 && soft >= 6, "{hard} {soft}");
    assert!(dark.abs_diff(dark_soft) <= 4 && lit == lit_soft);
}

#[test]
fn edges_are_smooth_in_linear_light() {
    // A white square, turned: half of a pixel on its edge is half of the light.
    let turned = DMat4::from_quat(DQuat::from_rotation_z(0.3));
    let shown = Shown::new(scene([(rectangle(1.0, 1.0), matt(1.0), turned)]), 2.0, 64, 64);
    let light = Light { kind: LightKind::DIRECTIONAL, specular: 0.0, ..Light::default() }.record();
    let black = Settings { background: Some(Background::Color([0; 3])), ..Settings::default() };
    let image = shown.draw(light, &black, true).image;
    let mut levels: Vec<u8> = image.pixels().map(|pixel| pixel.0[0]).collect();
    // Mean radiance is the covered area's, which holds only if averages are of linear light.
    let linear = |v: &u8| f64::from(srgb_decode(f32::from(*v) / 255.0));
    let mean = levels.iter().map(linear).sum::<f64>() / (64.0 * 64.0);
    let covered = 4.0 / 16.0;
    assert!((mean - covered).abs() < 0.002, "{mean}");
    levels.sort_unstable();
    levels.dedup();
    assert!(levels.len() > 8, "{levels:?}");
    assert!(levels.contains(&0) && levels.contains(&255));
    let single = Settings { samples: 1, ..black };
    let image = shown.draw(light, &single, true).image;
    assert!(image.pixels().all(|pixel| [0, 255].contains(&pixel.0[0])));
}

#[test]
fn a_transparent_background_has_straight_alpha() {
    let turned = DMat4::from_quat(DQuat::from_rotation_z(0.3));
    let shown = Shown::new(scene([(rectangle(1.0, 1.0), matt(0.5), turned)]), 2.0, 64, 64);
    let light = Light { kind: LightKind::DIRECTIONAL, specular: 0.0, ..Light::default() }.record();
    let clear = Settings { background: Some(Background::Transparent), ..Settings::default() };
    let image = shown.draw(light, &clear, true).image;
    let alpha: f64 = image.pixels().map(|pixel| f64::from(pixel.0[3]) / 255.0).sum();
    assert!((alpha / (64.0 * 64.0) - 0.25).abs() < 0.002, "{alpha}");
    let seen: Vec<_> = image.pixels().filter(|pixel| pixel.0[3] > 0).collect();
    assert!(seen.iter().any(|pixel| (1..255).contains(&pixel.0[3])));
    // The object's own colour, at its edges too.
    assert!(seen.iter().all(|pixel| pixel.0[0] == seen[0].0[0] && pixel.0[0] > 100));
    // Over a colour it is the picture with that colour.
    let over = Settings { background: Some(Background::Color([200, 40, 90])), ..clear };
    let opaque = shown.draw(light, &over, true).image;
    for (clear, opaque) in image.pixels().zip(opaque.pixels()) {
        let share = f32::from(clear.0[3]) / 255.0;
        for (channel, background) in [200u8, 40, 90].into_iter().enumerate() {
            let decode = |byte: u8| srgb_decode(f32::from(byte) / 255.0);
            let mixed = decode(clear.0[channel]) * share + decode(background) * (1.0 - share);
            let expected = srgb_encode(mixed) * 255.0;
            assert!((expected - f32::from(opaque.0[channel])).abs() < 1.6);
        }
        assert_eq!(opaque.0[3], 255);
    }
}

#[test]
fn tiles_show_what_the_whole_shows() {
    // 300 pixels at 16 samples are two tiles a side; at one sample, one tile.
    let shown = Shown::new(ball_and_wall(), 2.5, 300, 290);
    let settings = |samples| Settings { samples, ..Settings::default() };
    let light = from_the_right(0.0);
    let one = shown.draw(light, &settings(1), true).image;
    let many = shown.draw(light, &settings(16), true).image;
    let far = one.pixels().zip(many.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 90).count();
    assert!(far < 300, "{far}");
    // Along the border between two tiles nothing is seen of it.
    let step = |x: u32| {
        let differences = (0..40).map(|y| {
            let [a, b] = [x, x + 1].map(|x| many.get_pixel(x, y).0[0]);
            u32::from(a.abs_diff(b))
        });
        differences.max().unwrap_or(0)
    };
    assert!(step(255) <= step(200) + 1 && step(255) <= 2, "{} {}", step(255), step(200));
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let shown = Shown::new(ball_and_wall(), 2.5, 70, 50);
    let settings = Settings { samples: 4, ..Settings::default() };
    let draw = || shown.draw(from_the_right(0.1), &settings, true);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(draw)
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(one, shown.draw(from_the_right(0.0), &settings, true));
}

#[test]
fn rigs_that_are_drawn_together_have_pictures_of_their_own() {
    // More than one tile.
    let shown = Shown::new(ball_and_wall(), 2.5, 270, 40);
    let settings = Settings { samples: 16, ..Settings::default() };
    let lights = [from_the_right(0.1), from_the_right(0.0)];
    let Shown { scene, view, shading, occluders } = &shown;
    let stage = Stage { scene, view, shading, occluders: Some(occluders) };
    let rigs = [&lights[..1], &lights, &[]];
    let each = render::draw_each(&stage, &rigs, &settings).expect("pictures");
    let alone = rigs.map(|rig| render::draw(&stage, rig, &settings).expect("a picture"));
    assert_eq!(each, alone);
    assert!(each[0] != each[1] && each[2].unlit == 1.0);
    assert_eq!(render::draw_each(&stage, &[], &settings).expect("no pictures"), []);
}

#[test]
fn tone_mapping_keeps_highlights_that_clamping_burns() {
    let shown = Shown::new(scene([(rectangle(1.0, 1.0), matt(0.8), DMat4::IDENTITY)]), 0.9, 8, 8);
    let light = |diffuse| {
        let kind = LightKind::DIRECTIONAL;
        Light { kind, diffuse, specular: 0.0, ..Light::default() }.record()
    };
    let value = |diffuse, tone_mapping| {
        let settings = Settings { tone_mapping, samples: 1, ..Settings::default() };
        let picture = shown.draw(light(diffuse), &settings, false);
        (picture.image.get_pixel(4, 4).0[0], picture.burnt)
    };
    assert_eq!(value(2.0, ToneMapping::None), (255, 1.0));
    let (bright, burnt) = value(2.0, ToneMapping::Neutral);
    let (brighter, _) = value(4.0, ToneMapping::Neutral);
    assert!(bright < brighter && brighter < 255 && burnt == 1.0, "{bright} {brighter}");
    // Below the shoulder a colour of 0.08 or more is less by 0.04.
    let (plain, _) = value(0.7, ToneMapping::None);
    let (mapped, _) = value(0.7, ToneMapping::Neutral);
    let linear = |byte: u8| srgb_decode(f32::from(byte) / 255.0);
    assert!((linear(plain) - linear(mapped) - 0.04).abs() < 0.01, "{plain} {mapped}");
}

#[test]
fn settings_out_of_their_range_are_refused() {
    for samples in [0, 2, 15, 81, u32::MAX] {
        let fault = Settings { samples, ..Settings::default() }.check().expect_err("a fault");
        assert!(fault.is_input() && fault.to_string().contains("picture.samples"), "{fault}");
    }
    for samples in [1, 4, 9, 16, 64] {
        Settings { samples, ..Settings::default() }.check().expect("samples");
    }
}
