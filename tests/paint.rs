//! Lights that make a given picture, natively: what made it is found again.

use klieg::cpu;
use klieg::design::paint::{Canvas, paint, places};
use klieg::design::profile::NATURAL;
use klieg::lighting::genome::Genome;
use klieg::lighting::{Color, Light, LightKind, LightRecord, Rig, Role};
use klieg::objective::maps::{Maps, PixelType};
use klieg::objective::shadows::ShadowSettings;
use klieg::optimize::{self, GeneticSettings, Settings, Setup};
use klieg::scene::TextureLevel;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load;
use klieg::scene::view::View;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::path::Path;

/// The elephant, with shadows.
fn elephant() -> (Maps, View) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/elephant.glb");
    let scene = load::load(&path).unwrap();
    let camera = frame(&scene, &Framing::default(), 1.0).unwrap();
    let view = View::new(&scene, camera, 72, 72).unwrap();
    let shadows = ShadowSettings { on: true, side: 15, ..ShadowSettings::default() };
    let maps = cpu::draw(&scene, &view, &(NATURAL.objective)(), (&shadows, None)).unwrap();
    (maps, view)
}

fn light(role: Role, elevation: f32, azimuth: f32, intensity: f32, kelvin: f32) -> Light {
    Light {
        role,
        kind: LightKind::DIRECTIONAL,
        elevation: elevation.to_radians(),
        azimuth: azimuth.to_radians(),
        diffuse: intensity,
        specular: intensity,
        color: Color::of_kelvin(kelvin).unwrap(),
        ..Light::default()
    }
}

fn rig() -> Rig {
    vec![light(Role::Key, 38.0, 47.0, 0.9, 4500.0), light(Role::Fill, 12.0, -31.0, 0.3, 9000.0)]
}

/// The picture of a rig, transparent where no object is.
fn picture((maps, view): &(Maps, View), rig: &[Light]) -> TextureLevel {
    let records: Vec<LightRecord> = rig.iter().map(Light::record).collect();
    let picture =
        cpu::population::color_picture(maps, view, &(NATURAL.shading)(), &records, [9, 9, 9]);
    let texel = |(pixel, kind): (&image::Rgb<u8>, &PixelType)| {
        let [r, g, b] = pixel.0;
        [r, g, b, if *kind == PixelType::Background { 0 } else { 255 }]
    };
    let texels = picture.pixels().zip(&maps.types).map(texel).collect();
    TextureLevel { width: picture.width(), height: picture.height(), texels }
}

/// Angle between two lights, degrees.
fn apart(a: &Light, b: &Light) -> f32 {
    a.direction().dot(b.direction()).clamp(-1.0, 1.0).acos().to_degrees()
}

fn same(found: &Light, made: &Light, angle: f32, share: f32) -> bool {
    let tint = |light: &Light| light.color.linear()[0] / light.color.linear()[2];
    apart(found, made) <= angle
        && (found.diffuse / made.diffuse - 1.0).abs() <= share
        && (tint(found) / tint(made) - 1.0).abs() <= 2.0 * share
}

#[test]
fn intensities_and_colours_of_lights_in_their_places_are_exact() {
    let scene = elephant();
    let (shading, made) = ((NATURAL.shading)(), rig());
    let target = picture(&scene, &made);
    let canvas = Canvas::new((&scene.0, &scene.1, &shading), &target, &[]).unwrap();
    // Whatever they shine like, and a third that the picture has not.
    let third = light(Role::Rim, 20.0, 170.0, 5.0, 3000.0);
    let given = [&made[..], &[third]].concat().into_iter();
    let given: Rig = given.map(|light| Light { diffuse: 3.0, ..light }).collect();
    let (found, distance) = canvas.solve(&given);
    assert!(distance < 2e-3, "{distance}");
    assert!(std::iter::zip(&found, &made).all(|(a, b)| same(a, b, 0.1, 0.01)), "{found:?}");
    assert!(found[2].diffuse < 0.02, "{found:?}");
    // A light that shines besides is no part of what is solved for.
    let canvas = Canvas::new((&scene.0, &scene.1, &shading), &target, &made[..1]).unwrap();
    let (found, _) = canvas.solve(&made[1..]);
    assert!(same(&found[0], &made[1], 0.1, 0.01), "{found:?}");
}

#[test]
fn the_rig_that_made_a_picture_is_found() {
    let scene = elephant();
    let (shading, made) = ((NATURAL.shading)(), rig());
    let target = picture(&scene, &made);
    let canvas = Canvas::new((&scene.0, &scene.1, &shading), &target, &[]).unwrap();
    let roles = [Role::Key, Role::Fill];
    let genome = Genome::new(&roles, LightKind::DIRECTIONAL, &(NATURAL.boxes)()).unwrap();
    let genome = places(genome).unwrap();
    assert_eq!(genome.bounds().len(), 4);
    let genetic = GeneticSettings { population: 20, generations: 45, ..GeneticSettings::default() };
    let settings = Settings { genetic, ..Settings::default() };
    let first = genome.bounds().iter().map(|range| range.middle()).collect();
    let rng = ChaCha8Rng::seed_from_u64(3);
    let setup = Setup { bounds: genome.bounds(), first, settings: &settings, rng };
    let mut search = optimize::create("shade", setup).unwrap();
    let mut observe = |_: &_| ControlFlow::Continue(());
    let found = paint(&canvas, &genome, &mut *search, &mut observe).unwrap();
    assert!(std::iter::zip(&found.rig, &made).all(|(a, b)| same(a, b, 2.0, 0.02)), "{found:?}");
    assert_eq!(found.score, found.history.last().unwrap().best);
}

#[test]
fn pictures_that_tell_nothing_are_refused() {
    let scene = elephant();
    let shading = (NATURAL.shading)();
    let target = picture(&scene, &rig());
    let refused = |target: &TextureLevel| {
        let canvas = Canvas::new((&scene.0, &scene.1, &shading), target, &[]);
        canvas.err().map(|fault| fault.to_string()).unwrap_or_default()
    };
    let texels = target.texels.iter().map(|&[r, g, b, _]| [r, g, b, 254]).collect();
    assert!(refused(&TextureLevel { texels, ..target.clone() }).contains("tells no pixel"));
    let size = (target.width / 2, target.height * 2);
    let wrong = TextureLevel { width: size.0, height: size.1, ..target };
    assert!(refused(&wrong).contains("36x144 pixels, and the view 72x72"));
}
