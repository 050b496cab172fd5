//! The example engine on ash: what it says, and the pictures that it leaves.

use image::RgbImage;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Cargo builds the examples beside the folder of the tests, unless it is asked for one test alone.
fn example() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let profile = test.ancestors().nth(2).unwrap();
    let name = format!("engine_ash{}", std::env::consts::EXE_SUFFIX);
    let example = profile.join("examples").join(name);
    assert!(example.exists(), "there is none: cargo build --example engine_ash");
    example
}

fn picture(path: &Path) -> RgbImage {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgb8()
}

/// Mean brightness, share of pixels whose every channel is full, both 0..=1.
fn exposure(picture: &RgbImage) -> (f64, f64) {
    let sum: f64 = picture.as_raw().iter().map(|&byte| f64::from(byte) / 255.0).sum();
    let full = picture.pixels().filter(|pixel| pixel.0 == [255; 3]).count();
    (sum / picture.as_raw().len() as f64, full as f64 / picture.pixels().len() as f64)
}

/// Share of pixels that are clearly different.
fn changed(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let far = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
        std::iter::zip(a.0, b.0).any(|(a, b)| a.abs_diff(b) > 16)
    };
    let count = a.pixels().zip(b.pixels()).filter(|&pair| far(pair)).count();
    count as f64 / a.pixels().len() as f64
}

fn well_exposed(picture: &RgbImage) -> bool {
    let (mean, full) = exposure(picture);
    (0.15..0.7).contains(&mean) && full < 0.03
}

#[test]
fn an_engine_designs_its_lights_at_levels_1_and_2() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(example()).arg(folder.path()).output().unwrap();
    let [said, faults] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success() && faults.is_empty(), "{said}{faults}");
    for expected in [
        "12160 triangles",
        "level 1 alone: the same bits in 23 generations",
        "levels 1 and 2: scores differ by ",
        "level 1: F 0.",
        "level 2: F 0.",
        "level 2, 20 ms a frame: F 0.",
    ] {
        assert!(said.contains(expected), "{expected:?} is not in\n{said}");
    }

    let [before, first, second] =
        ["before.png", "level_1.png", "level_2.png"].map(|name| picture(&folder.path().join(name)));
    assert_eq!(before.dimensions(), (192, 144));
    for (picture, name) in [(&before, "before"), (&first, "level 1"), (&second, "level 2")] {
        assert!(well_exposed(picture), "{name}: {:?}", exposure(picture));
    }
    for (after, name) in [(&first, "level 1"), (&second, "level 2")] {
        assert!(changed(&before, after) > 0.2, "{name}: {}", changed(&before, after));
    }

    // Pictures that are black, white or the same are noticed.
    let even = |byte| RgbImage::from_pixel(192, 144, image::Rgb([byte; 3]));
    assert!(!well_exposed(&even(0)) && !well_exposed(&even(255)));
    assert_eq!(changed(&before, &before), 0.0);
}

#[test]
fn without_a_folder_it_says_how_it_is_called() {
    let output = Command::new(example()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("usage: engine_ash FOLDER"));
}
