//! What light is wanted, from the command line to the picture.

use assert_cmd::assert::Assert;
use glam::Vec3;
use image::Rgba;
use klieg::cpu::CpuEvaluator;
use klieg::cpu::objects::of_objects;
use klieg::design::profile::Profile;
use klieg::evaluate::Evaluator;
use klieg::lighting::{Light, LightKind, direction};
use klieg::math::color::{luminance, srgb_decode};
use klieg::objective::shadows::ShadowSettings;
use klieg::scene::view::View;
use klieg_support::common::Folder;
use serde_json::Value;
use std::path::Path;

const SMALL: [&str; 8] =
    ["--device", "cpu", "--size", "96x96", "--coarse", "0", "--background", "transparent"];

/// The options with a number of generations, unless they say another.
fn options<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let usual: &[&str] =
        if more.contains(&"--generations") { &[] } else { &["--generations", "25"] };
    [&SMALL[..], usual, more].concat()
}

/// Designs the elephant into `out`.
fn design(place: &Folder, out: &str, more: &[&str]) -> Value {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/elephant.glb");
    let arguments = ["design", scene.to_str().unwrap(), "--out", out];
    place.klieg(&[&arguments[..], &options(more)].concat()).assert().success();
    place.read_json(&format!("{out}/result.json"))
}

/// CIE L* of each pixel of the object, ascending.
fn lightness(place: &Folder, out: &str) -> Vec<f32> {
    let picture = image::open(place.path(out).join("best.png")).unwrap().to_rgba8();
    let lightness = |&Rgba([r, g, b, _]): &Rgba<u8>| {
        let linear = Vec3::from([r, g, b].map(|channel| srgb_decode(f32::from(channel) / 255.0)));
        let y = luminance(linear);
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    };
    let mut object: Vec<f32> =
        picture.pixels().filter(|pixel| pixel.0[3] > 250).map(lightness).collect();
    object.sort_by(f32::total_cmp);
    assert!(object.len() > 1000);
    object
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

fn deviation(values: &[f32]) -> f32 {
    let middle = mean(values);
    mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>()).sqrt()
}

#[test]
fn a_step_of_brightness_is_seen_in_the_mean_lightness() {
    let place = Folder::new();
    let means = ["-1", "0", "1"].map(|steps| {
        let out = format!("steps{steps}");
        let result = design(&place, &out, &["--brightness", steps, "--generations", "40"]);
        assert_eq!(result["intent"]["brightness"].as_f64(), steps.parse().ok());
        mean(&lightness(&place, &out))
    });
    assert!(means[0] + 5.0 < means[1] && means[1] + 5.0 < means[2], "{means:?}");
}

#[test]
fn steps_of_contrast_and_moods_are_seen_in_the_spread_of_lightness() {
    let place = Folder::new();
    let [low, high] = ["-1.5", "1.5"].map(|steps| {
        let out = format!("steps{steps}");
        design(&place, &out, &["--contrast", steps]);
        deviation(&lightness(&place, &out))
    });
    assert!(low + 6.0 < high, "{low} {high}");
    let [soft, dramatic] = ["soft", "dramatic"].map(|mood| {
        let result = design(&place, mood, &["--mood", mood]);
        assert_eq!(result["intent"]["mood"], *mood);
        lightness(&place, mood)
    });
    assert!(deviation(&soft) + 6.0 < deviation(&dramatic));
    // A quarter of the object sinks into the shadows.
    let quarter = soft.len() / 4;
    assert!(mean(&dramatic[..quarter]) + 20.0 < mean(&soft[..quarter]));
}

#[test]
fn no_light_stands_below_the_horizon_of_the_world() {
    let place = Folder::new();
    let low = "[lights.boxes.key]\nelevation = [-60, -20]\nazimuth = [-90, 90]\ndiffuse = [0, 6]\n\
               distance = [1.5, 5]\n";
    std::fs::write(place.path("low.toml"), low).unwrap();
    let heights = |out: &str, more: &[&str]| {
        let more = [&["--config", "low.toml", "--generations", "3"], more].concat();
        let result = design(&place, out, &more);
        let axis = |name: &str| result["camera"][name][1].as_f64().unwrap() as f32;
        let up = Vec3::new(axis("right"), axis("up"), axis("back"));
        let lights = result["lights"].as_array().unwrap().iter();
        let height = |light: &Value| {
            let angle = |name: &str| (light[name].as_f64().unwrap() as f32).to_radians();
            direction(angle("elevation_deg"), angle("azimuth_deg")).dot(up)
        };
        lights.map(height).collect::<Vec<_>>()
    };
    assert!(heights("below", &[])[0] < -0.01);
    let above = heights("above", &["--no-below"]);
    assert!(above.iter().all(|&height| height > -1e-5), "{above:?}");
}

#[test]
fn roles_have_fixed_temperatures_and_lights_of_a_rig_are_kept() {
    let place = Folder::new();
    let warm = design(&place, "warm", &["--warm", "key=3000K", "--generations", "2"]);
    assert_eq!([&warm["lights"][0]["color"], &warm["lights"][1]["color"]], ["3000K", "#ffffff"]);

    let lit = place.path("warm/lit.glb");
    let again = |out: &str, keep: &str| {
        let more = ["--first", "scene", "--keep", keep, "--generations", "3", "--seed", "5"];
        let arguments = [&["design", lit.to_str().unwrap(), "--out", out][..], &options(&more)];
        place.klieg(&arguments.concat()).assert().success();
        place.read_json(&format!("{out}/result.json"))["lights"].clone()
    };
    let near = |a: &Value, b: &Value| {
        let same =
            |name: &&str| (a[*name].as_f64().unwrap() - b[*name].as_f64().unwrap()).abs() < 1e-3;
        ["elevation_deg", "azimuth_deg", "diffuse", "distance"]
            .iter()
            .filter(|name| same(name))
            .count()
    };
    let kept = again("key", "key");
    assert_eq!(near(&kept[0], &warm["lights"][0]), 4, "{kept}");
    assert!(near(&kept[1], &warm["lights"][1]) < 4, "{kept}");
    let kept = again("part", "1.azimuth");
    assert_eq!(near(&kept[1], &warm["lights"][1]), 1, "{kept}");
}

#[test]
fn wishes_that_make_no_sense_are_faults_of_the_user() {
    let place = Folder::new();
    let preset = ["--first", "three-point", "--lights", "3", "--keep"];
    for (more, said) in [
        (&["--brightness", "3"][..], "brightness is 3"),
        (&["--mood", "grim"], "soft, natural, dramatic"),
        (&["--keep", "key"], "no rig of which a light could be kept"),
        (&[&preset[..], &["back"]].concat(), "'back' is none of key, fill, rim"),
        (&[&preset[..], &["7"]].concat(), "no light 7"),
        (&[&preset[..], &["key.size"]].concat(), "no 'size' to keep"),
    ] {
        let fault = place.design("out", more).assert().code(2).get_output().stderr.clone();
        let fault = String::from_utf8(fault).unwrap();
        assert!(fault.contains(said), "{more:?}: {fault}");
        assert!(!place.path("out/result.json").exists());
    }
}

#[test]
fn the_statistics_of_an_example_come_back() {
    let place = Folder::new();
    let made = design(&place, "made", &["--mood", "dramatic", "--brightness", "1"]);
    let like = place.path("made/best.png");
    let found = design(&place, "like", &["--like", like.to_str().unwrap(), "--seed", "9"]);
    design(&place, "usual", &["--seed", "9"]);
    let [wanted, found_l, usual] = ["made", "like", "usual"].map(|out| lightness(&place, out));
    // Percentiles, the tenth to the ninetieth.
    let apart = |a: &[f32], b: &[f32]| {
        let at = |all: &[f32], tenth: usize| all[all.len() * tenth / 10];
        mean(&(1..10).map(|tenth| (at(a, tenth) - at(b, tenth)).abs()).collect::<Vec<_>>())
    };
    let (near, far) = (apart(&found_l, &wanted), apart(&usual, &wanted));
    assert!(near < 6.0 && 2.0 * near < far, "{near} {far}");
    let example = &found["objective"]["targets"]["example"];
    assert_eq!(example["histogram"].as_array().unwrap().len(), 32);
    assert!(found["terms"]["example"].as_f64().unwrap() < 0.25, "{found}");
    assert!(made["terms"].get("example").is_none());
}

#[test]
fn pictures_that_cannot_be_used_are_faults_of_the_user() {
    let place = Folder::new();
    std::fs::write(place.path("text.png"), "no picture").unwrap();
    let small = image::RgbaImage::from_pixel(2, 2, Rgba([9, 9, 9, 0]));
    small.save(place.path("small.png")).unwrap();
    let whole = std::fs::read(place.path("small.png")).unwrap();
    std::fs::write(place.path("cut.png"), &whole[..whole.len() - 20]).unwrap();
    for (more, said) in [
        (["--like", "absent.png"], "absent.png"),
        (["--like", "text.png"], "text.png: it is neither PNG nor JPEG"),
        (["--like", "cut.png"], "cut.png: it cannot be decoded"),
        (["--like", "small.png"], "small.png: the picture is transparent everywhere"),
        (["--target-picture", "text.png"], "text.png: it is neither PNG nor JPEG"),
        (["--target-picture", "small.png"], "small.png: the target picture has 2x2 pixels"),
    ] {
        let fault = place.design("out", &more).assert().code(2).get_output().stderr.clone();
        let fault = String::from_utf8(fault).unwrap();
        assert!(fault.contains(said), "{more:?}: {fault}");
        assert!(!place.path("out/result.json").exists(), "{more:?}");
    }
    design(&place, "out", &["--generations", "1"]);
    let before = std::fs::read(place.path("out/best.png")).unwrap();
    for option in ["--like", "--target-picture"] {
        place.design("out", &[option, "out/best.png"]).assert().code(2);
        assert_eq!(std::fs::read(place.path("out/best.png")).unwrap(), before);
    }
}

#[test]
fn a_target_picture_is_painted() {
    let place = Folder::new();
    let warm = ["--warm", "key=3500K", "--generations", "8"];
    design(&place, "made", &warm);
    let target = place.path("made/best.png");
    let more = ["--target-picture", target.to_str().unwrap(), "--seed", "4", "--generations", "40"];
    let found = design(&place, "found", &more);
    design(&place, "usual", &["--generations", "8", "--seed", "4"]);
    // Mean distance of the channels, 0..=255.
    let apart = |out: &str| {
        let [a, b] = ["made", out].map(|out| {
            image::open(place.path(out).join("best.png")).unwrap().to_rgba8().into_raw()
        });
        let off = std::iter::zip(&a, &b).map(|(a, b)| f32::from(a.abs_diff(*b)));
        off.sum::<f32>() / a.len() as f32
    };
    assert!(apart("found") < 4.0, "{} {found}", apart("found"));
    assert!(apart("usual") > 4.0 * apart("found"), "{}", apart("usual"));
}

/// `F` of a design's rig in the pair's picture, as the objects of one name alone show it.
fn judged_by(object: &str, result: &Value) -> f32 {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb");
    let scene = klieg::scene::load::load(&path).unwrap();
    let view = View::new(&scene, scene.cameras[0].clone(), 96, 96).unwrap();
    let profile = Profile::named("natural").unwrap();
    let (objective, shading) = ((profile.objective)(), (profile.shading)());
    let shadows = ShadowSettings { on: true, ..ShadowSettings::default() };
    let maps = klieg::cpu::draw(&scene, &view, &objective, (&shadows, None)).unwrap();
    let instance = scene.instances.iter().find(|instance| instance.name == object).unwrap();
    let range = scene.polygon_range(instance);
    let maps = of_objects(&maps, |code| range.contains(&code));
    let number = |light: &Value, name: &str| light[name].as_f64().unwrap() as f32;
    let light = |light: &Value| Light {
        kind: LightKind::POINT,
        elevation: number(light, "elevation_deg").to_radians(),
        azimuth: number(light, "azimuth_deg").to_radians(),
        distance: number(light, "distance"),
        diffuse: number(light, "diffuse"),
        specular: number(light, "specular"),
        ..Light::default()
    };
    let rig: Vec<_> = result["lights"].as_array().unwrap().iter().map(light).collect();
    let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading).unwrap();
    evaluator.inspect(&rig).unwrap().score
}

/// Designs two objects into `out`.
fn design_pair(place: &Folder, out: &str, more: &[&str]) -> Assert {
    let pair = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb");
    let arguments = ["design", pair.to_str().unwrap(), "--out", out];
    place.klieg(&[&arguments[..], &options(more)].concat()).assert()
}

#[test]
fn what_is_in_focus_is_lit_better_than_without() {
    let place = Folder::new();
    let design = |out: &str, more: &[&str]| design_pair(&place, out, more);
    design("plain", &[]).success();
    design("focused", &["--focus", "AMPHORA"]).success();
    let [plain, focused] =
        ["plain", "focused"].map(|out| place.read_json(&format!("{out}/result.json")));
    assert!(plain["focus"].is_null() && focused["focus"][0] == "AMPHORA");
    let [before, after] = [&plain, &focused].map(|result| judged_by("amphora", result));
    assert!(after + 0.01 < before, "{before} {after}");

    let unknown = design("none", &["--focus", "teapot"]).code(2);
    let said = String::from_utf8_lossy(&unknown.get_output().stderr).into_owned();
    assert!(said.contains("no object is named 'teapot': there are amphora, elephant"), "{said}");
    let still_life = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/still-life.glb");
    let hidden = ["--focus", "back apple's stalk", "--size", "24x16"];
    let unseen = place
        .klieg(&[&["design", still_life.to_str().unwrap(), "--out", "none"], &hidden[..]].concat())
        .assert();
    let said = String::from_utf8_lossy(&unseen.code(2).get_output().stderr).into_owned();
    assert!(said.contains("does not see what is in focus: back apple"), "{said}");
    assert!(!place.path("none").exists());
}

#[test]
fn objects_stay_dim_beside_others_that_are_lit() {
    let place = Folder::new();
    let design = |out: &str, more: &[&str]| design_pair(&place, out, more);
    design("plain", &[]).success();
    design("dim", &["--dim", "amphora"]).success();
    let [plain, dim] = ["plain", "dim"].map(|out| place.read_json(&format!("{out}/result.json")));
    assert!(plain["dim"].is_null() && dim["dim"][0] == "amphora");
    // Root mean square differences from the brightness that is wanted.
    let target = |result: &Value, of: &str| result.pointer(of).and_then(Value::as_f64);
    let apart = |of: &str| target(&dim, of).map(|term| 0.25 * term / (1.25 - term)).unwrap();
    assert!(target(&plain, "/terms/target").is_none());
    assert!(apart("/terms/target") < 0.1875, "{}", dim["terms"]);
    assert!(apart("/headlight/terms/target") > 0.2475, "{}", dim["headlight"]);
    let weights = dim["objective"]["weights"].as_object().unwrap();
    let terms = weights.iter().map(|(name, weight)| {
        weight.as_f64().unwrap() * dim["terms"][name].as_f64().unwrap_or_default()
    });
    let (sum, score) = (terms.sum::<f64>(), dim["score"].as_f64().unwrap());
    assert!((sum - score).abs() < 1e-4, "{sum} {score}");

    for (names, said) in [
        ("teapot", "no object is named 'teapot'"),
        ("amphora,elephant", "does not see what is to stay dim and something beside it: amphora"),
    ] {
        let output = design("none", &["--dim", names]).code(2).get_output().clone();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(text.contains(said), "{text}");
    }
    design("both", &["--dim", "amphora", "--focus", "elephant"]).success();
}

/// Mean encoded brightness of a square of the picture.
fn brightness(place: &Folder, out: &str, [x, y]: [u32; 2], side: u32) -> f32 {
    let picture = image::open(place.path(out).join("best.png")).unwrap().to_luma8();
    let values = (y..y + side).flat_map(|v| (x..x + side).map(move |u| (u, v)));
    mean(&values.map(|(u, v)| f32::from(picture.get_pixel(u, v).0[0])).collect::<Vec<_>>())
}

#[test]
fn shadows_and_highlights_lie_where_they_are_drawn() {
    let place = Folder::new();
    // On the flank of the elephant, which looks to the left.
    let (at, side) = ([52, 40], 6);
    let stroke = |name: &str, grey: u8| {
        let mut picture = image::RgbaImage::new(96, 96);
        for (x, y) in (at[1]..at[1] + side).flat_map(|y| (at[0]..at[0] + side).map(move |x| (x, y)))
        {
            picture.put_pixel(x, y, Rgba([grey, grey, grey, 255]));
        }
        picture.save(place.path(name)).unwrap();
        place.path(name)
    };
    design(&place, "free", &[]);
    let shadow = stroke("shadow.png", 10);
    let result = design(&place, "dark", &["--strokes", shadow.to_str().unwrap()]);
    assert_eq!(result["strokes"], true);
    assert_eq!(result["objective"]["weights"]["target"], 1.0);
    let [free, dark] = ["free", "dark"].map(|out| brightness(&place, out, at, side));
    assert!(dark < 70.0 && dark + 60.0 < free, "{dark} {free}");
    // Darkness everywhere is no shadow.
    let [all, left] = ["free", "dark"].map(|out| brightness(&place, out, [0, 0], 96));
    assert!(left > 0.5 * all, "{left} {all}");

    let light = stroke("light.png", 255);
    let light = light.to_str().unwrap();
    let held = |seed| {
        let result = design(&place, seed, &["--strokes", light, "--seed", seed]);
        let key = &result["lights"][0];
        ["elevation_deg", "azimuth_deg", "distance"].map(|name| key[name].as_f64().unwrap())
    };
    assert_eq!(held("1"), held("2"));

    let arguments = ["design", "scene.glb", "--out", "o", "--strokes", light, "--focus", "x"];
    place.klieg(&arguments).assert().code(2);
}
