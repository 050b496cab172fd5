//! What the program makes of scenes with cameras and animations of their own, and what it says of files.

use common::{Folder, ball};
use klieg_support::common;
use serde_json::{Value, json};

#[test]
fn a_scene_with_an_orthographic_camera_is_designed() {
    let place = Folder::new();
    let mut scene = ball();
    let lens = json!({"xmag": 1.5, "ymag": 1.25, "znear": 0.1, "zfar": 10.0});
    scene["cameras"] = json!([{"type": "orthographic", "orthographic": lens}]);
    scene["nodes"][0]["children"] = json!([2]);
    let camera = json!({"camera": 0, "translation": [0.0, 0.0, 4.0]});
    scene["nodes"].as_array_mut().unwrap().push(camera);
    std::fs::write(place.path("ball.gltf"), scene.to_string()).unwrap();
    place.design("out", &[]).assert().success();
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(report.contains("orthographic, 2.50 world units high"));
    assert_eq!(place.read_json("out/result.json")["camera"]["ymag"], 1.25);
}

/// The ball as two that an animation moves apart, in a GLB's JSON.
fn animated() -> Value {
    let mut scene = ball();
    let mut bytes = [0.0f32, 2.0].map(f32::to_le_bytes).concat();
    let places = [[0.0f32, 0.0, 0.0], [3.0, 0.0, 0.0]].concat();
    bytes.extend(places.iter().flat_map(|x| x.to_le_bytes()));
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let push = |list: &mut Value, value: Value| list.as_array_mut().unwrap().push(value);
    push(
        &mut scene["buffers"],
        json!({"byteLength": bytes.len(),
        "uri": format!("data:application/octet-stream;base64,{data}")}),
    );
    push(&mut scene["bufferViews"], json!({"buffer": 1, "byteLength": 8}));
    push(&mut scene["bufferViews"], json!({"buffer": 1, "byteOffset": 8, "byteLength": 24}));
    push(
        &mut scene["accessors"],
        json!({"bufferView": 2, "componentType": 5126, "count": 2,
        "type": "SCALAR", "min": [0.0], "max": [2.0]}),
    );
    push(
        &mut scene["accessors"],
        json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}),
    );
    scene["animations"] = json!([{"name": "apart", "channels": [{"sampler": 0,
        "target": {"node": 1, "path": "translation"}}], "samplers": [{"input": 2, "output": 3}]}]);
    scene
}

/// The radius of the scene that `klieg inspect` tells of, and its pose in words.
fn pose(place: &Folder, options: &[&str]) -> (f64, String) {
    let arguments = [&["inspect", "a.gltf", "--json"], options].concat();
    let output = place.klieg(&arguments).assert().success().get_output().clone();
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    (told["drawn"]["radius"].as_f64().unwrap(), told["drawn"]["pose"].as_str().unwrap().to_owned())
}

#[test]
fn options_and_files_name_the_moment_that_is_shown() {
    let place = Folder::new();
    std::fs::write(place.path("a.gltf"), animated().to_string()).unwrap();
    std::fs::write(place.path("a.toml"), "[pose]\ntime = 2.0").unwrap();
    for (options, radius, words) in [
        (&[][..], 1.0, "animation 'apart' at 0 s"),
        (&["--rest"], 1.605, "as its nodes stand"),
        (&["--time", "2"], 2.25, "animation 'apart' at 2 s"),
        (&["--animation", "apart", "--time", "2"], 2.25, "animation 'apart' at 2 s"),
        (&["--config", "a.toml"], 2.25, "animation 'apart' at 2 s"),
        (&["--config", "a.toml", "--rest"], 1.605, "as its nodes stand"),
    ] {
        let (found, told) = pose(&place, options);
        assert!(
            (found - radius).abs() < 0.01 && told.contains(words),
            "{options:?}: {found} {told}"
        );
    }
    for (options, part) in [
        (&["--animation", "walk"][..], "it has 0 'apart'"),
        (&["--time", "-1"], "time is -1"),
        (&["--rest", "--time", "1"], "--rest"),
    ] {
        let arguments = [&["score", "a.gltf", "--preset", "headlight"], options].concat();
        let output = place.klieg(&arguments).assert().code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(part), "{options:?}: {said}");
    }
    // What is written keeps the animation.
    let small = ["--size", "16x16", "--generations", "1", "--population", "4", "--time", "1"];
    let design = [&["design", "a.gltf", "--out", "out"][..], &small].concat();
    place.klieg(&design).assert().success();
    let glb = std::fs::read(place.path("out/lit.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let root: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let scene = animated();
    assert_eq!(root["animations"], scene["animations"]);
    assert_eq!(root["nodes"][1]["translation"], scene["nodes"][1]["translation"]);
}

#[test]
fn inspect_says_what_is_there_what_is_drawn_and_what_is_not() {
    let place = Folder::new();
    let mut scene = animated();
    scene["asset"]["generator"] = "An exporter".into();
    scene["images"] = json!([{"uri": "gone.png"}, {"mimeType": "image/ktx2", "bufferView": 0}]);
    scene["extensionsUsed"] = json!(["EXAMPLE_unknown"]);
    std::fs::write(place.path("a.gltf"), scene.to_string()).unwrap();
    let output = place.klieg(&["inspect", "a.gltf"]).assert().success().get_output().clone();
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "a.gltf: glTF 2.0, ",
        "by An exporter",
        "2 nodes",
        "1 image/ktx2, 1 image/png",
        "apart (2.00 s)",
        "576 triangles in 2 drawings",
        "klieg's own framing",
        "'EXAMPLE_unknown' is not supported",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    scene["extensionsRequired"] = json!(["EXAMPLE_unknown"]);
    std::fs::write(place.path("a.gltf"), scene.to_string()).unwrap();
    let output = place.klieg(&["inspect", "a.gltf"]).assert().code(2).get_output().clone();
    let text = String::from_utf8(output.stdout).unwrap();
    let parts = ["576", "klieg cannot use it", "'EXAMPLE_unknown'", "gltf-transform"];
    assert!(
        !text.contains(parts[0]) && parts[1..].iter().all(|part| text.contains(part)),
        "{text}"
    );
    let output =
        place.klieg(&["inspect", "a.gltf", "--json"]).assert().code(2).get_output().clone();
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&told["schema"], &told["drawn"]), (&json!("klieg.inspect/1"), &Value::Null));
    assert!(told["fault"].as_str().unwrap().contains("EXAMPLE_unknown"));
    std::fs::write(place.path("a.gltf"), "{").unwrap();
    place.klieg(&["inspect", "a.gltf"]).assert().code(2);
}

#[test]
fn inspect_tells_of_files_that_are_no_gltf() {
    let place = Folder::new();
    let obj = "o plate\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 1\nf 1 2 3 4\n";
    std::fs::write(place.path("plate.obj"), obj).unwrap();
    let output = place.klieg(&["inspect", "plate.obj", "--json"]).assert().success();
    let told: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(told["contents"]["container"], "OBJ");
    assert_eq!(told["contents"]["bytes"], obj.len());
    assert_eq!(told["drawn"]["triangles"], 2);
}
