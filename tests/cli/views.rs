//! `--views`, `--rig`, `--over` and `--time START:END:STEP`: from the command line to the files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::PngDecoder;
use image::{AnimationDecoder, ImageDecoder};
use klieg_support::common::Folder;
use serde_json::{Value, json};
use std::io::BufReader;

/// A folder with `cameras.gltf`: the ball with two cameras and an animation that moves the smaller one.
fn folder() -> Folder {
    let place = Folder::new();
    let mut scene = place.read_json("ball.gltf");
    let numbers: [f32; 8] = [0.0, 2.0, 0.9, 0.5, -0.9, -1.4, 0.9, 1.2];
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let buffer = scene["buffers"].as_array().unwrap().len();
    let view = scene["bufferViews"].as_array().unwrap().len();
    let accessor = scene["accessors"].as_array().unwrap().len();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let mut push = |key: &str, value: Value| {
        if scene[key].is_null() {
            scene[key] = json!([]);
        }
        scene[key].as_array_mut().unwrap().push(value);
    };
    push("buffers", json!({"byteLength": bytes.len(), "uri": uri}));
    push("bufferViews", json!({"buffer": buffer, "byteLength": 8}));
    push("bufferViews", json!({"buffer": buffer, "byteOffset": 8, "byteLength": 24}));
    push(
        "accessors",
        json!({"bufferView": view, "componentType": 5126, "type": "SCALAR", "count": 2,
        "min": [0.0], "max": [2.0]}),
    );
    push(
        "accessors",
        json!({"bufferView": view + 1, "componentType": 5126, "type": "VEC3", "count": 2}),
    );
    push(
        "animations",
        json!({"name": "round", "samplers": [{"input": accessor, "output": accessor + 1}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}),
    );
    let lens = json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}});
    push("cameras", lens);
    push("nodes", json!({"name": "front", "camera": 0, "translation": [0.0, 0.5, 5.0]}));
    let side = [0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()];
    push(
        "nodes",
        json!({"name": "side", "camera": 0, "translation": [5.0, 0.5, 0.0], "rotation": side}),
    );
    scene["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    std::fs::write(place.path("cameras.gltf"), scene.to_string()).unwrap();
    place
}

const SMALL: [&str; 8] =
    ["--size", "40x32", "--generations", "3", "--population", "6", "--coarse", "0"];

/// Designs for several views into `out`; gives `result.json`.
fn design(place: &Folder, scene: &str, out: &str, more: &[&str]) -> Value {
    let arguments = ["design", scene, "--out", out, "--json"];
    place.klieg(&arguments).args(SMALL).args(more).assert().success();
    place.read_json(&format!("{out}/result.json"))
}

fn titles(result: &Value) -> Vec<&str> {
    let each = result["views"]["each"].as_array().unwrap();
    each.iter().map(|view| view["title"].as_str().unwrap()).collect()
}

fn numbers<'a>(result: &'a Value, key: &'a str) -> Vec<f64> {
    let each = result["views"]["each"].as_array().unwrap();
    each.iter().map(|view| view[key].as_f64().unwrap()).collect()
}

/// Size and number of the pictures of an animation.
fn animation(place: &Folder, out: &str) -> ((u32, u32), usize) {
    let file = std::fs::File::open(place.path(out).join("turntable.png")).unwrap();
    let decoder = PngDecoder::new(BufReader::new(file)).unwrap();
    let size = decoder.dimensions();
    let frames = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
    assert!(frames.windows(2).all(|pair| pair[0].buffer() != pair[1].buffer()));
    (size, frames.len())
}

#[test]
fn a_turntable_has_a_picture_of_each_view_and_one_that_turns() {
    let place = folder();
    let result = design(&place, "ball.gltf", "out", &["--views", "4", "--azimuth", "10"]);
    let files = place.list("out");
    for name in ["view-01.png", "view-04.png", "turntable.png", "best.png", "lit.glb"] {
        assert!(files.iter().any(|file| file == name), "{name}: {files:?}");
    }
    assert!(!files.iter().any(|file| file == "view-05.png"));
    let read = |name: &str| image::open(place.path("out").join(name)).unwrap().to_rgb8();
    assert_eq!(
        (read("view-01.png"), read("view-02.png").dimensions()),
        (read("best.png"), (40, 32))
    );
    assert!(read("view-01.png") != read("view-03.png"));
    assert_eq!(animation(&place, "out"), ((88, 32), 24));

    assert_eq!(titles(&result), ["azimuth 10°", "azimuth 100°", "azimuth 190°", "azimuth 280°"]);
    assert_eq!(
        (&result["views"]["rig"], &result["views"]["over"]),
        (&json!("world"), &json!("mean"))
    );
    let mean = numbers(&result, "score").iter().sum::<f64>() / 4.0;
    assert!((mean - result["score"].as_f64().unwrap()).abs() < 1e-6);
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(page.contains("All views") && page.contains("azimuth 280°"));

    // The lit scene has the score that the search saw.
    let again =
        ["score", "out/lit.glb", "--views", "4", "--azimuth", "10", "--size", "40x32", "--json"];
    let output = place.klieg(&again).assert().success().get_output().stdout.clone();
    let again: Value = serde_json::from_slice(&output).unwrap();
    for (a, b) in numbers(&again, "score").iter().zip(numbers(&result, "score")) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    let table = place.klieg(&["score", "out/lit.glb", "--views", "3", "--size", "40x32"]);
    let table = { table }.assert().success().get_output().stdout.clone();
    assert!(String::from_utf8(table).unwrap().contains("azimuth 150°"));
}

#[test]
fn cameras_of_the_file_are_views_and_a_camera_s_rig_goes_with_it() {
    let place = folder();
    let more = ["--views", "all", "--rig", "camera", "--over", "worst"];
    let result = design(&place, "cameras.gltf", "out", &more);
    assert_eq!(titles(&result), ["front", "side"]);
    let worst = numbers(&result, "score").into_iter().fold(f64::MIN, f64::max);
    assert_eq!(result["score"].as_f64(), Some(worst));
    assert_eq!(animation(&place, "out"), ((88, 32), 2));
    let named = design(&place, "cameras.gltf", "named", &["--views", "side, front"]);
    assert_eq!(titles(&named), ["side", "front"]);
    // klieg's own camera is none of the file's.
    let again = ["score", "out/lit.glb", "--views", "all", "--rig", "camera", "--over", "worst"];
    let mut again = place.klieg(&again);
    let output = again.args(["--size", "40x32", "--json"]).assert().success().get_output().clone();
    let again: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(titles(&again), ["front", "side"]);
    assert!((again["score"].as_f64().unwrap() - worst).abs() < 1e-4);
}

#[test]
fn moments_are_views_of_one_camera() {
    let place = folder();
    let more = ["--time", "0:2:0.5", "--azimuth", "0", "--profile", "paper"];
    let result = design(&place, "cameras.gltf", "out", &more);
    assert_eq!(numbers(&result, "time"), [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(titles(&result)[1], "azimuth 0°, 0.5 s");
    let cameras: Vec<&Value> =
        result["views"]["each"].as_array().unwrap().iter().map(|view| &view["camera"]).collect();
    assert!(cameras.windows(2).all(|pair| pair[0] == pair[1]), "the camera stands still");
    assert_eq!(animation(&place, "out"), ((88, 32), 5));
    let both =
        design(&place, "cameras.gltf", "both", &["--time", "0:1:1", "--views", "front,side"]);
    assert_eq!(titles(&both), ["front, 0 s", "side, 0 s", "front, 1 s", "side, 1 s"]);
}

#[test]
fn views_stand_in_files_and_batches_too() {
    let place = folder();
    std::fs::write(place.path("views.toml"), "[views]\ncameras = 3\nover = \"worst\"\n").unwrap();
    let result = design(&place, "ball.gltf", "out", &["--config", "views.toml"]);
    assert_eq!((titles(&result).len(), &result["views"]["over"]), (3, &json!("worst")));
    let batch = ["batch", "ball.gltf", "--out", "all", "--config", "views.toml"];
    place.klieg(&batch).args(SMALL).assert().success();
    let same = place.read_json("all/ball/result.json");
    assert_eq!((&same["lights"], &same["score"]), (&result["lights"], &result["score"]));
    assert!(place.path("all/ball/view-03.png").is_file());
}

#[test]
fn views_that_cannot_be_are_refused() {
    let place = folder();
    let design = ["design", "cameras.gltf", "--out", "out"];
    for (options, words) in [
        (&["--views", "0"][..], "2 to 64"),
        (&["--views", "65"], "2 to 64"),
        (&["--views", "-1"], "2 to 64"),
        (&["--views", "front,back"], "'back'"),
        (&["--views", "front"], "one view alone"),
        (&["--time", "0:2:0"], "step"),
        (&["--time", "2:0:1"], "end"),
        (&["--time", "0:9:0.1"], "91 moments"),
        (&["--views", "16", "--time", "0:2:0.5"], "80 views"),
        (&["--views", "all", "--azimuth", "3"], "exclude"),
        (&["--views", "4", "--over", "best"], "neither mean nor worst"),
        (&["--views", "4", "--rig", "wall"], "neither world nor camera"),
        (&["--views", "4", "--alternatives", "3"], "one view"),
    ] {
        let output = place.klieg(&[&design[..], &SMALL, options].concat()).assert().code(2);
        let text = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        assert!(text.contains(words), "{options:?}: {text}");
        assert!(!place.path("out/result.json").exists());
    }
    let output = place.klieg(&["score", "ball.gltf", "--preset", "headlight", "--views", "all"]);
    let output = { output }.assert().code(2).get_output().stderr.clone();
    assert!(String::from_utf8(output).unwrap().contains("--views 8"));
    for command in [
        &["gallery", "cameras.gltf", "--out", "out"][..],
        &["render", "cameras.gltf", "--out", "out.png", "--preset", "headlight"],
    ] {
        let output = place.klieg(&[command, &["--time", "0:2:1"]].concat()).assert().code(2);
        let text = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        assert!(text.contains("single view"), "{text}");
    }
}
