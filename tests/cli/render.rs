//! `klieg render` and `klieg thumbnail`, and the final pictures of a design.

use common::Folder;
use image::{DynamicImage, RgbaImage};
use klieg_support::common;

/// A folder with `shadows.toml`.
fn place() -> Folder {
    let place = Folder::new();
    std::fs::write(place.path("shadows.toml"), "[shadows]\non = true\n").unwrap();
    place
}

fn picture(place: &Folder, name: &str) -> DynamicImage {
    image::open(place.path(name)).unwrap()
}

/// Largest mean and single difference of two pictures' channels, of 255.
fn difference(a: &DynamicImage, b: &DynamicImage) -> (f64, u8) {
    let (a, b) = (a.to_rgba8(), b.to_rgba8());
    assert_eq!(a.dimensions(), b.dimensions());
    let differences = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| a.abs_diff(*b));
    let mean = differences.clone().map(f64::from).sum::<f64>() / a.as_raw().len() as f64;
    (mean, differences.max().unwrap_or(0))
}

fn render(place: &Folder, arguments: &[&str]) {
    place.klieg(&[&["render"], arguments].concat()).assert().success();
}

#[test]
fn a_lit_scene_is_drawn_as_it_was_designed() {
    let place = place();
    let shadows = ["--config", "shadows.toml"];
    place.design("out", &shadows).assert().success();
    let best = picture(&place, "out/best.png");
    assert_eq!((best.width(), best.height()), (48, 40));
    assert_eq!(best.color(), image::ColorType::Rgb8);
    let close = |name: &str| {
        let (mean, _) = difference(&picture(&place, name), &best);
        assert!(mean < 0.05, "{name}: {mean}");
    };
    render(&place, &[&["out/lit.glb", "--out", "new/lit.png"], &shadows[..]].concat());
    close("new/lit.png");
    assert_eq!(place.list("new"), ["lit.png"]);
    let rig = ["ball.gltf", "--out", "rig.png", "--rig", "out/result.json", "--size", "48x40"];
    render(&place, &[&rig, &shadows[..]].concat());
    close("rig.png");
    // The lights alone are a rig too.
    let lights = place.read_json("out/result.json")["lights"].to_string();
    std::fs::write(place.path("rig.json"), lights).unwrap();
    let rig = ["ball.gltf", "--out", "alone.png", "--rig", "rig.json", "--size", "48x40"];
    render(&place, &[&rig, &shadows[..]].concat());
    assert_eq!(picture(&place, "alone.png"), picture(&place, "rig.png"));

    let preset = ["ball.gltf", "--preset", "headlight", "--out", "head.png", "--size", "48x40"];
    render(&place, &[&preset, &shadows[..]].concat());
    assert_eq!(picture(&place, "head.png"), picture(&place, "out/headlight.png"));
    assert!(difference(&picture(&place, "head.png"), &best).0 > 1.0, "the comparison cannot fail");
    // Without shadows it is another picture.
    for (name, shadows) in [("shadowed.png", "on"), ("free.png", "off")] {
        let rig = ["ball.gltf", "--preset", "three-point", "--out", name, "--shadows", shadows];
        render(&place, &rig);
    }
    assert_ne!(picture(&place, "free.png"), picture(&place, "shadowed.png"));
}

#[test]
fn a_picture_has_any_size_and_background() {
    let place = place();
    let draw = |name: &str, more: &[&str]| {
        let base = ["ball.gltf", "--preset", "three-point", "--out", name];
        render(&place, &[&base, more].concat());
        picture(&place, name)
    };
    let plain = draw("plain.png", &["--size", "300x60"]);
    assert_eq!((plain.width(), plain.height()), (300, 60));
    assert_eq!(plain.to_rgb8().get_pixel(0, 0).0, [58, 60, 66]);
    let green = draw("green.png", &["--size", "300x60", "--background", "#12a034"]).to_rgb8();
    assert_eq!(green.get_pixel(0, 0).0, [0x12, 0xa0, 0x34]);
    let clear = draw("clear.png", &["--size", "90x60", "--background", "transparent"]);
    assert_eq!(clear.color(), image::ColorType::Rgba8);
    let alphas = |image: RgbaImage| image.pixels().map(|pixel| pixel.0[3]).collect::<Vec<_>>();
    let alphas = alphas(clear.to_rgba8());
    assert!(alphas.contains(&0) && alphas.contains(&255));
    assert!(alphas.iter().any(|alpha| (1..255).contains(alpha)));
    let mapped = draw("mapped.png", &["--size", "300x60", "--tone-mapping", "neutral"]);
    assert!(difference(&mapped, &plain).0 > 0.1);

    std::fs::write(place.path("one.toml"), "[picture]\nsamples = 1\nbackground = \"#000000\"\n")
        .unwrap();
    let sharp = draw("sharp.png", &["--size", "90x60", "--config", "one.toml"]).to_rgb8();
    assert_eq!(sharp.get_pixel(0, 0).0, [0; 3]);
    let levels = |image: &image::RgbImage| {
        let edge = image.pixels().filter(|pixel| (1..12).contains(&pixel.0[0]));
        edge.count()
    };
    let smooth = draw("smooth.png", &["--size", "90x60", "--background", "#000000"]).to_rgb8();
    assert!(levels(&smooth) > levels(&sharp), "{} {}", levels(&smooth), levels(&sharp));
}

#[test]
fn a_design_has_the_pictures_that_its_settings_ask_for() {
    let place = Folder::new();
    place.design("clear", &["--background", "transparent"]).assert().success();
    place.design("plain", &[]).assert().success();
    for name in ["best.png", "headlight.png"] {
        let clear = picture(&place, &format!("clear/{name}"));
        let plain = picture(&place, &format!("plain/{name}"));
        assert_eq!(clear.to_rgba8().get_pixel(0, 0).0[3], 0);
        assert_eq!(plain.color(), image::ColorType::Rgb8);
    }
    // The search does not see it.
    let score = |out: &str| place.read_json(&format!("{out}/result.json"))["score"].clone();
    assert_eq!(score("clear"), score("plain"));
}

#[test]
fn a_thumbnail_is_one_picture_and_always_the_same() {
    let place = place();
    let draw = |name: &str, more: &[&str]| {
        let mut command = place.klieg(&["thumbnail", "ball.gltf", name]);
        command.args(more).assert().success();
        std::fs::read(place.path(name)).unwrap()
    };
    let first = draw("thumbs/a.png", &["--size", "64x48"]);
    assert_eq!(place.list("thumbs"), ["a.png"]);
    assert!(first == draw("b.png", &["--size", "64x48"]));
    let image = image::load_from_memory(&first).unwrap().to_rgb8();
    assert_eq!(image.dimensions(), (64, 48));
    let object = image.pixels().filter(|pixel| pixel.0 != [58, 60, 66]).count();
    assert!(object > 64 * 48 / 5, "{object}");
    let brightest = image.pixels().map(|pixel| pixel.0[0]).max();
    assert!(brightest > Some(180), "{brightest:?}");
    let free = draw("c.png", &["--size", "64x48", "--shadows", "off"]);
    assert!(free != first);
    let clear = draw("d.png", &["--background", "transparent"]);
    let clear = image::load_from_memory(&clear).unwrap();
    assert_eq!((clear.width(), clear.color()), (256, image::ColorType::Rgba8));
}

#[test]
fn what_is_wrong_is_named_and_nothing_is_written() {
    let place = Folder::new();
    let light = r#""elevation_deg": 30, "azimuth_deg": 20, "diffuse": 1"#;
    for (name, text) in [
        ("text.json", "lights".to_owned()),
        ("none.json", "[]".to_owned()),
        ("far.json", format!("[{{{light}}}]")),
        ("dark.json", format!("[{{{light}, \"distance\": 2, \"specular\": -1}}]")),
        ("kind.json", format!("[{{{light}, \"kind\": \"candle\"}}]")),
        ("many.json", format!("[{}]", vec![format!("{{{light}, \"distance\": 2}}"); 17].join(","))),
    ] {
        std::fs::write(place.path(name), text).unwrap();
    }
    std::fs::create_dir(place.path("folder")).unwrap();
    std::fs::write(place.path("bad.toml"), "[picture]\nsamples = 15\n").unwrap();
    let before = place.list(".");
    let ball = ["render", "ball.gltf", "--out", "x.png"];
    let preset = ["--preset", "headlight"];
    let cases: [(&[&str], &str); 13] = [
        (&[], "--rig or --preset"),
        (&["--rig", "gone.json"], "gone.json"),
        (&["--rig", "text.json"], "text.json"),
        (&["--rig", "none.json"], "0 lights"),
        (&["--rig", "far.json"], "lights[0]: it has no distance"),
        (&["--rig", "dark.json"], "its specular"),
        (&["--rig", "kind.json"], "kind.json"),
        (&["--rig", "many.json"], "17 lights"),
        (&["--preset", "headlight", "--size", "0x4"], "0x4"),
        (&["--preset", "headlight", "--background", "blue"], "blue"),
        (&["--preset", "headlight", "--config", "bad.toml"], "picture.samples"),
        (&["--preset", "headlight", "--camera", "3"], "camera '3'"),
        (&["--preset", "headlight", "--size", "16384x16384"], "16384x16384"),
    ];
    let fails = |arguments: &[&str], code: i32, words: &str| {
        let output = place.klieg(arguments).assert().code(code).get_output().clone();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(words), "{arguments:?}: {text}");
        assert_eq!(place.list("."), before, "{arguments:?}");
    };
    for (more, words) in cases {
        fails(&[&ball, more].concat(), 2, words);
    }
    let into = |out| [&["render", "ball.gltf", "--out", out], &preset[..]].concat();
    fails(&into("ball.gltf"), 2, "would be overwritten");
    fails(&into("folder"), 2, "names no file");
    fails(&into(".."), 2, "names no file");
    fails(&into("ball.gltf/x.png"), 1, "cannot write");
    fails(&["thumbnail", "gone.glb", "x.png"], 2, "gone.glb");
    fails(&["thumbnail", "ball.gltf", "ball.gltf"], 2, "would be overwritten");
}
