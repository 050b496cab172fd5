//! Small pictures of the project's scenes against stored ones, `tests/pictures/`. A failed comparison
//! leaves what it got in `tests/failed/`; `KLIEG_BLESS=1 cargo test --test pictures` stores it instead.

use image::RgbImage;
use klieg::cpu;
use klieg::lighting::Light;
use klieg::lighting::presets::Preset;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::scene::view::View;

const SIZE: u32 = 96;
/// Mean difference of a channel that rounding may make, of 255.
const TOLERANCE: f64 = 0.05;

/// The scene through its own camera under the three-point rig.
fn picture(name: &str, turn: f32) -> RgbImage {
    let path = klieg_support::root().join(format!("scenes/{name}.glb"));
    let scene = klieg::scene::load::load(&path).unwrap();
    let view = View::new(&scene, scene.cameras[0].clone(), SIZE, SIZE).unwrap();
    let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &Objective::default());
    let turned = |light: Light| Light { azimuth: light.azimuth + turn, ..light }.record();
    let records: Vec<_> = Preset::ThreePoint.rig().into_iter().map(turned).collect();
    cpu::population::color_picture(&maps, &view, &Shading::default(), &records, [60; 3])
}

fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let all = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    all.sum::<f64>() / a.as_raw().len() as f64
}

#[test]
fn the_scenes_look_as_they_did() {
    let tests = klieg_support::root().join("tests");
    let mut failed = Vec::new();
    for name in ["elephant", "pair", "still-life"] {
        let made = picture(name, 0.0);
        let stored = tests.join(format!("pictures/{name}.png"));
        if std::env::var_os("KLIEG_BLESS").is_some() {
            made.save(&stored).unwrap();
        }
        let expected = image::open(&stored).unwrap().into_rgb8();
        if difference(&made, &expected) > TOLERANCE {
            std::fs::create_dir_all(tests.join("failed")).unwrap();
            let left = tests.join(format!("failed/{name}.png"));
            made.save(&left).unwrap();
            failed.push(format!("{} differs from {}", left.display(), stored.display()));
        }
        let planted = difference(&picture(name, 0.02), &expected);
        assert!(planted > TOLERANCE, "{name}: a light moved by a degree makes {planted}");
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
