//! The native evaluator against the plain stages, and the rasteriser against cast rays.

use glam::{DMat4, DVec3, Vec3};
use klieg::cpu::{self, visibility};
use klieg::evaluate::Evaluator;
use klieg::lighting::Population;
use klieg::scene::view::{Projection, View};
use klieg::scene::{Material, Scene, Texture, TextureLevel, TextureRef, Wrap};
use klieg_support::{shapes, surfaces};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use shapes::{camera, matt, orthographic, rectangle, scene, sphere, view};
use surfaces::{Bench, TOLERANCE, rig, surface, worst};

#[test]
fn the_fast_evaluator_agrees_with_the_plain_stages() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let disc = |x: u32, y: u32| x.abs_diff(60).pow(2) + y.abs_diff(50).pow(2) < 45 * 45;
    let surfaces = [
        surface(1, 1, |_, _| true),
        surface(7, 5, |x, y| (x, y) == (3, 2)),
        surface(1, 300, |_, y| y % 7 != 0),
        surface(300, 2, |_, _| true),
        surface(131, 97, disc),
        surface(65, 33, |x, y| (x + y) % 2 == 0),
        surface(251, 203, |_, _| true),
    ];
    let mut largest = 0.0f32;
    for surface in surfaces {
        let maps = cpu::maps(surface, &bench.objective);
        for lights in [1, 2, 3, 4, 9, 16] {
            for strength in [0.0, 0.3, 2.0, 1000.0] {
                let rig = rig(&mut random, lights, strength / lights as f32);
                let difference = bench.difference(&maps, &rig);
                largest = largest.max(difference);
                assert!(
                    difference < TOLERANCE,
                    "{difference}: {}x{}, {lights} lights of {strength}",
                    maps.surface.width,
                    maps.surface.height
                );
            }
        }
    }
    println!("largest difference of a term: {largest:e}");
}

#[test]
fn the_comparison_sees_one_changed_pixel_and_one_changed_light() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let maps = cpu::maps(surface(31, 17, |_, _| true), &bench.objective);
    let rig = rig(&mut random, 4, 0.5);
    assert!(bench.difference(&maps, &rig) < TOLERANCE);
    let plain = bench.plain(&maps, &rig);

    let mut pixel = maps.clone();
    pixel.surface.emissive[9 * 31 + 15] = [1.0; 3];
    let changed = bench.evaluator(&pixel).inspect(&rig).expect("a rig").terms;
    assert!(worst(&changed, &plain) > TOLERANCE);

    let mut light = rig.clone();
    light[2].elevation += 0.01;
    let changed = bench.evaluator(&maps).inspect(&light).expect("a rig").terms;
    assert!(worst(&changed, &plain) > TOLERANCE);
}

#[test]
fn scores_have_the_same_bits_for_any_number_of_threads() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let maps = cpu::maps(surface(301, 203, |x, y| x > 3 && y > 90 / (x + 1)), &bench.objective);
    let rigs: Vec<_> = (0..7).map(|_| rig(&mut random, 3, 0.7)).collect();
    let population = Population::of(rigs.iter().map(Vec::as_slice)).expect("rigs of 3 lights");
    let scores = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut scores = vec![0.0; rigs.len()];
        let mut evaluator = bench.evaluator(&maps);
        pool.install(|| evaluator.evaluate(&population, &mut scores)).expect("7 scores");
        scores
    };
    let one = scores(1);
    assert_eq!(one, scores(2));
    assert_eq!(one, scores(5));
    let mut evaluator = bench.evaluator(&maps);
    let qualities = evaluator.qualities(&population).expect("7 qualities");
    for ((rig, &score), quality) in rigs.iter().zip(&one).zip(qualities) {
        assert_eq!(evaluator.inspect(rig).expect("a rig").quality(), quality);
        assert_eq!(quality.score, score);
    }
    assert!(one.iter().any(|&score| score != one[0]));
}

#[test]
fn a_large_population_has_the_scores_of_its_rigs() {
    let bench = Bench::new();
    let maps = cpu::maps(surface(7, 5, |x, _| x > 0), &bench.objective);
    let mut evaluator = bench.evaluator(&maps);
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let rigs: Vec<_> = (0..2500).map(|_| rig(&mut random, 2, 1.0)).collect();
    let population = Population::of(rigs.iter().map(Vec::as_slice)).expect("rigs of two");
    let mut scores = vec![f32::NAN; rigs.len()];
    evaluator.evaluate(&population, &mut scores).expect("scores");
    for at in [0, 1, 1023, 1024, 2047, 2048, 2499] {
        assert_eq!(scores[at], evaluator.inspect(&rigs[at]).expect("two lights").score, "{at}");
    }
    assert_ne!(scores[1023], scores[1024]);
}

#[test]
fn places_and_rigs_must_match() {
    let bench = Bench::new();
    let maps = cpu::maps(surface(3, 3, |_, _| true), &bench.objective);
    let mut evaluator = bench.evaluator(&maps);
    let rig = rig(&mut ChaCha8Rng::seed_from_u64(4), 1, 1.0);
    let population = Population::of([rig.as_slice()]).expect("one rig");
    assert!(evaluator.evaluate(&population, &mut [0.0; 2]).is_err());
    assert!(evaluator.inspect(&[]).is_err());
}

#[test]
fn a_view_of_nothing_has_terms() {
    let bench = Bench::new();
    let maps = cpu::maps(surface(9, 9, |_, _| false), &bench.objective);
    let rig = rig(&mut ChaCha8Rng::seed_from_u64(5), 2, 1.0);
    assert_eq!(bench.difference(&maps, &rig), 0.0);
}

/// Colour code and light-frame position where the ray through a pixel's centre first meets a front
/// face, in double precision.
fn cast(scene: &Scene, view: &View, x: u32, y: u32) -> (u32, DVec3) {
    let from_world = view.frame.from_world();
    let inverse = view.clip_from_frame.as_dmat4().inverse();
    let at = |depth| {
        let x = 2.0 * (f64::from(x) + 0.5) / f64::from(view.width) - 1.0;
        let y = 2.0 * (f64::from(y) + 0.5) / f64::from(view.height) - 1.0;
        inverse.project_point3(DVec3::new(x, y, depth))
    };
    let start = at(1.0);
    let direction = (at(0.5) - start).normalize();
    let mut nearest = (0, DVec3::INFINITY);
    let mut reach = f64::INFINITY;
    for code in 1..=scene.polygons() {
        let (instance, triangle) = scene.polygon(code).expect("a polygon of the scene");
        let [a, b, c] = scene.corners(instance, triangle).map(|p| from_world.transform_point3(p));
        let normal = (b - a).cross(c - a);
        let distance = (a - start).dot(normal) / direction.dot(normal);
        let hit = start + direction * distance;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (to - from).cross(hit - from).dot(normal) >= 0.0);
        if inside && direction.dot(normal) < 0.0 && distance > 0.0 && distance < reach {
            (nearest, reach) = ((code, hit), distance);
        }
    }
    nearest
}

#[test]
fn the_rasteriser_sees_what_rays_meet() {
    let squeezed = DMat4::from_scale_rotation_translation(
        DVec3::new(0.4, -0.7, 0.5),
        glam::DQuat::from_rotation_y(0.5),
        DVec3::new(0.9, 0.2, 0.6),
    );
    let scene = scene([
        (sphere(12), matt(0.5), DMat4::IDENTITY),
        (sphere(7), matt(0.5), squeezed),
        (rectangle(3.0, 3.0), matt(0.5), DMat4::from_rotation_x(-1.2)),
    ]);
    let perspective = camera(DVec3::new(0.3, 0.53, 5.0), Projection::Perspective { yfov: 0.7 });
    let inside = camera(DVec3::new(0.3, 0.4, 2.0), Projection::Perspective { yfov: 1.8 });
    for view in [
        view(&scene, perspective, 97, 71),
        view(&scene, inside, 64, 64),
        orthographic(&scene, 1.5, 80, 60),
    ] {
        let surface = visibility::draw(&scene, &view);
        let (mut other, mut object) = (0, 0);
        for at in 0..surface.code.len() {
            let (code, hit) = cast(&scene, &view, at as u32 % view.width, at as u32 / view.width);
            object += u32::from(code != 0);
            if surface.code[at] != code {
                other += 1; // at outlines, where the subpixel grid decides
            } else if code != 0 {
                let position = Vec3::from(surface.position[at]).as_dvec3();
                assert!(position.distance(hit) < 1e-4, "{position} {hit}");
                let depth = f64::from(view.eye.z) - hit.z;
                assert!((f64::from(surface.depth[at]) - depth).abs() < 1e-4);
                let normal = Vec3::from(surface.normal[at]);
                assert!((normal.length() - 1.0).abs() < 1e-5);
                assert!(normal.dot(view.towards_viewer(position.as_vec3())) >= 0.0);
            }
        }
        assert!(object > 1000);
        assert!(f64::from(other) <= 0.005 * f64::from(object), "{other} of {object}");
    }
}

#[test]
fn triangles_that_meet_cover_each_pixel_once() {
    // Translucency would show a pixel drawn twice; here two layers of the same plane do: the first
    // wins everywhere, also along the diagonal and where two rectangles meet on pixel centres.
    let at = |x, z| DMat4::from_translation(DVec3::new(x, 0.0, z));
    let scene = scene([
        (rectangle(1.0, 1.0), matt(0.1), at(-1.0, 0.0)),
        (rectangle(1.0, 1.0), matt(0.2), at(1.0, 0.0)),
        (rectangle(2.0, 1.0), matt(0.3), at(0.0, 0.0)),
    ]);
    let surface = visibility::draw(&scene, &orthographic(&scene, 1.0, 33, 17));
    let seen = |x: usize| surface.code[8 * 33 + x];
    assert!(surface.code.iter().all(|&code| code != 0));
    assert!((0..16).all(|x| seen(x) <= 2), "left");
    // Column 16's centres lie on the common edge, which is the right rectangle's left one.
    assert!((16..33).all(|x| (3..=4).contains(&seen(x))), "right");
}

#[test]
fn back_faces_show_only_where_they_should() {
    let turned = DMat4::from_rotation_y(std::f64::consts::PI);
    let mirrored = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let two_sided = Material { double_sided: true, ..matt(0.5) };
    for (material, world, shown) in [
        (matt(0.5), DMat4::IDENTITY, true),
        (matt(0.5), turned, false),
        (matt(0.5), mirrored, true),
        (matt(0.5), mirrored * turned, false),
        (two_sided, turned, true),
    ] {
        let scene = scene([(rectangle(1.0, 1.0), material, world)]);
        let surface = visibility::draw(&scene, &orthographic(&scene, 0.9, 8, 8));
        assert!(surface.code.iter().all(|&code| (code != 0) == shown));
        if shown {
            assert!(surface.normal.iter().all(|n| n[2] > 0.999));
        }
    }
}

#[test]
fn a_floor_reaches_from_behind_the_viewer_to_the_horizon() {
    let floor = DMat4::from_scale_rotation_translation(
        DVec3::splat(1e6),
        glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        DVec3::new(0.0, -1.0, 0.0),
    );
    let scene = scene([(rectangle(1.0, 1.0), matt(0.5), floor)]);
    let mut camera = camera(DVec3::ZERO, Projection::Perspective { yfov: 1.0 });
    let count = |camera| {
        let surface = visibility::draw(&scene, &view(&scene, camera, 32, 32));
        let below = surface.code[17 * 32..].iter().all(|&code| code != 0);
        let above = surface.code[..16 * 32].iter().all(|&code| code == 0);
        assert!(above);
        (below, surface.code.iter().filter(|&&code| code != 0).count())
    };
    assert!(count(camera.clone()).0);
    camera.far = Some(4.0);
    let (below, near) = count(camera.clone());
    assert!(!below && near > 0);
    camera.near = 3.0;
    assert!((1..near).contains(&count(camera).1));
}

#[test]
fn textures_mask_and_colour() {
    let texels: Vec<[u8; 4]> =
        vec![[255, 0, 0, 255], [0, 255, 0, 0], [0, 0, 255, 255], [255, 255, 255, 255]];
    let texture = Texture {
        name: String::new(),
        srgb: true,
        wrap: [Wrap::Clamp; 2],
        levels: vec![TextureLevel { width: 2, height: 2, texels }],
    };
    let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
    let material = Material { base_color_texture, alpha_cutoff: 0.5, ..matt(1.0) };
    let behind = DMat4::from_translation(DVec3::new(0.0, 0.0, -0.5));
    let mut scene = scene([
        (rectangle(1.0, 1.0), material, DMat4::IDENTITY),
        (rectangle(1.0, 1.0), matt(0.5), behind),
    ]);
    scene.textures.push(texture);
    let surface = visibility::draw(&scene, &orthographic(&scene, 1.0, 32, 32));
    let at = |x: usize, y: usize| (surface.code[y * 32 + x], surface.base_color[y * 32 + x]);
    assert_eq!(at(2, 2).1, [1.0, 0.0, 0.0]);
    assert_eq!(at(2, 29).1, [0.0, 0.0, 1.0]);
    assert!(at(29, 2).0 > 2, "the mask shows what is behind");
    assert_eq!(at(29, 29).1, [1.0, 1.0, 1.0]);
}

#[test]
fn normal_maps_turn_the_normal_alike_in_every_size() {
    let texel = [255, 128, 218, 255]; // (1, 0, 0.71)
    for size in [0.01, 1.0, 300.0] {
        let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let normal_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
        let material = Material { normal_texture, ..matt(0.5) };
        let world = DMat4::from_scale(DVec3::splat(size));
        let mut scene = scene([(rectangle(1.0, 1.0), material, world)]);
        scene.textures.push(Texture {
            name: String::new(),
            srgb: false,
            wrap: [Wrap::Repeat; 2],
            levels: vec![TextureLevel { width: 1, height: 1, texels: vec![texel] }],
        });
        let surface = visibility::draw(&scene, &orthographic(&scene, 0.5 * size, 4, 4));
        let expected = Vec3::new(1.0, 1.0 / 255.0, 2.0 * 218.0 / 255.0 - 1.0).normalize();
        assert!(Vec3::from(surface.normal[5]).distance(expected) < 1e-5, "{:?}", surface.normal);
    }
}
