//! How near the shadow table comes to the shadows of soft lights.

use glam::Vec3;
use klieg::cpu;
use klieg::objective::maps::Surface;
use klieg::objective::shadows::{ShadowSettings, Shadows};
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load::load;
use klieg::scene::occluders::Occluders;
use klieg::scene::view::View;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::sync::Arc;

const SIZE: u32 = 192;
/// Every so many object pixels are looked at.
const STEP: usize = 61;
/// Lights for each of them.
const LIGHTS: usize = 24;
/// Rays to each light.
const RAYS: usize = 16;
/// Half of the angle that a light covers: 2°.
const HALF_ANGLE: f32 = 2.0 * std::f32::consts::PI / 180.0;

/// Mean absolute differences of visibilities.
struct Errors {
    /// Over all pixels and lights in all directions; a light below a pixel's horizon makes none.
    all: f64,
    /// Over those lights that stand above the pixel's horizon.
    facing: f64,
}

fn seen(scene: &Path) -> (Surface, Arc<Occluders>) {
    let scene = load(scene).unwrap();
    let camera = match scene.cameras.first() {
        Some(camera) => camera.clone(),
        None => frame(&scene, &Framing::default(), 1.0).unwrap(),
    };
    let view = View::new(&scene, camera, SIZE, SIZE).unwrap();
    let occluders = Arc::new(Occluders::new(&scene, &view).unwrap());
    (cpu::visibility::draw(&scene, &view), occluders)
}

/// Share of a round light around `d` that a point sees.
fn exact(shadows: &Shadows, d: Vec3, p: Vec3, face: Vec3) -> f32 {
    let (right, up) = d.any_orthonormal_pair();
    let ray = |k: usize| {
        // Evenly spread over the disc (Vogel 1979).
        let radius = HALF_ANGLE.tan() * ((k as f32 + 0.5) / RAYS as f32).sqrt();
        let (sine, cosine) = (2.399_963 * k as f32).sin_cos();
        let towards = (d + (right * cosine + up * sine) * radius).normalize();
        shadows.sees(towards * 1e6, p, face)
    };
    (0..RAYS).filter(|&k| ray(k)).count() as f32 / RAYS as f32
}

fn errors(surface: &Surface, shadows: &Shadows) -> Errors {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let (mut sum, mut all, mut facing) = (0.0, 0u32, 0u32);
    let object = (0..surface.code.len()).filter(|&at| surface.code[at] != 0);
    for at in object.step_by(STEP) {
        let (p, face) = (Vec3::from(surface.position[at]), Vec3::from(surface.face[at]));
        let number = shadows.number(at).unwrap();
        for _ in 0..LIGHTS {
            let z: f32 = random.random_range(-1.0..1.0);
            let turn: f32 = random.random_range(0.0..std::f32::consts::TAU);
            let d = Vec3::new(turn.cos(), turn.sin(), 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z;
            all += 1;
            if face.dot(d) > 0.0 {
                facing += 1;
                sum += f64::from((shadows.towards(number, d) - exact(shadows, d, p, face)).abs());
            }
        }
    }
    Errors { all: sum / f64::from(all), facing: sum / f64::from(facing) }
}

/// Errors at a side of the table, of a scene of the project or any other.
fn errors_of(scene: &Path, side: u32) -> Errors {
    let (surface, occluders) = seen(scene);
    let settings = ShadowSettings { on: true, side, ..ShadowSettings::default() };
    errors(&surface, &cpu::shadows::table(&surface, occluders, &settings))
}

#[test]
fn tables_come_near_to_soft_lights_and_nearer_the_finer_they_are() {
    for name in ["elephant", "pair", "still-life"] {
        let scene = Path::new("scenes").join(name).with_extension("glb");
        let [coarse, usual] = [15, 31].map(|side| errors_of(&scene, side));
        println!("{name}: {:.4}, facing {:.4}", usual.all, usual.facing);
        assert!(usual.all < 0.02, "{name}: {}", usual.all);
        assert!(usual.facing < 0.045, "{name}: {}", usual.facing);
        assert!(coarse.all > 1.5 * usual.all, "{name}: {} and {}", coarse.all, usual.all);
    }
}

/// The figures of `docs/METHOD.md`: `KLIEG_SCENES=a.glb:b.glb cargo test --test shadow_table -- --ignored`.
#[test]
#[ignore = "a table of figures for the documentation, of scenes that the caller names"]
fn figures_of_scenes() {
    let scenes = std::env::var("KLIEG_SCENES").expect("KLIEG_SCENES names the scenes");
    for scene in scenes.split(':') {
        for side in [15, 23, 31, 63] {
            let Errors { all, facing } = errors_of(Path::new(scene), side);
            println!("{scene} {side}: {all:.4}, facing {facing:.4}");
        }
    }
}
