//! Lights on the command line: their colours, kinds and intensities, and the scene's own.

use klieg_support::common::{Folder, ball};
use serde_json::{Value, json};

/// Puts a scene with a strong sun from the viewer's side and a faint red lamp at `sunny.gltf`.
fn sunny() -> Folder {
    let place = Folder::new();
    let mut scene = ball();
    scene["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    scene["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": 20 },
        { "type": "spot", "intensity": 9, "color": [1, 0, 0], "spot": { "outerConeAngle": 0.5 } },
    ] } });
    let light = |index: u32| json!({ "KHR_lights_punctual": { "light": index } });
    let nodes = scene["nodes"].as_array_mut().unwrap();
    nodes.push(
        json!({ "name": "sun", "rotation": [-0.3, 0.0, 0.0, 0.954], "extensions": light(0) }),
    );
    nodes.push(json!({ "name": "lamp", "translation": [0, 0, 3], "extensions": light(1) }));
    scene["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    std::fs::write(place.path("sunny.gltf"), scene.to_string()).unwrap();
    place
}

const SMALL: [&str; 6] = ["--size", "48x40", "--generations", "3", "--population", "8"];

fn design(place: &Folder, out: &str, more: &[&str]) -> Value {
    let arguments = ["design", "sunny.gltf", "--out", out];
    place.klieg(&[&arguments[..], &SMALL, more].concat()).assert().success();
    place.read_json(&format!("{out}/result.json"))
}

fn score(place: &Folder, scene: &str, more: &[&str]) -> Value {
    let arguments = [&["score", scene, "--size", "48x40", "--json"], more].concat();
    let output = place.klieg(&arguments).assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Names of the nodes of a GLB that carry a light.
fn lit_nodes(place: &Folder, name: &str) -> Vec<String> {
    let (root, _) = glb(place, name);
    let nodes = root["nodes"].as_array().unwrap().iter();
    let lit = nodes.filter(|node| node["extensions"].get("KHR_lights_punctual").is_some());
    lit.map(|node| node["name"].as_str().unwrap().to_owned()).collect()
}

/// JSON of a GLB, and its lights.
fn glb(place: &Folder, name: &str) -> (Value, Value) {
    let bytes = std::fs::read(place.path(name)).unwrap();
    let glb = gltf::binary::Glb::from_slice(&bytes).unwrap();
    let root: Value = serde_json::from_slice(&glb.json).unwrap();
    let lights = root["extensions"]["KHR_lights_punctual"]["lights"].clone();
    (root, lights)
}

fn close(a: &Value, b: &Value) -> bool {
    (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-4
}

fn values(result: &Value, key: &str) -> Vec<Value> {
    result["lights"].as_array().unwrap().iter().map(|light| light[key].clone()).collect()
}

#[test]
fn the_scene_s_own_lights_are_taken_out_and_count_for_nothing() {
    let place = sunny();
    let result = design(&place, "out", &[]);
    assert_eq!(result["scene_lights"], json!({ "count": 2, "kept": false }));
    assert_eq!(values(&result, "role"), ["key", "fill"]);
    assert_eq!(lit_nodes(&place, "out/lit.glb"), ["klieg key", "klieg fill"]);
    let again = score(&place, "out/lit.glb", &[]);
    assert!(close(&again["score"], &result["score"]), "{again} {result}");
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(report.contains("2 lights are taken out"), "{report}");
    // A scene without lights has nothing to tell of.
    place.design("plain", &[]).assert().success();
    assert_eq!(place.read_json("plain/result.json")["scene_lights"]["count"], 0);
    assert!(
        !std::fs::read_to_string(place.path("plain/report.html")).unwrap().contains("own light")
    );
}

#[test]
fn kept_lights_count_in_every_score_and_stay() {
    let place = sunny();
    let without = design(&place, "without", &[]);
    let result = design(&place, "out", &["--keep-lights"]);
    assert_eq!(result["scene_lights"], json!({ "count": 2, "kept": true }));
    assert_eq!(values(&result, "role"), ["key", "fill", "scene", "scene"]);
    assert_eq!(values(&result, "kind")[2..], ["directional", "spot"]);
    assert_eq!(values(&result, "color")[2..], ["#ffffff", "#ff0000"]);
    let lit = lit_nodes(&place, "out/lit.glb");
    assert_eq!(lit, ["sun", "lamp", "klieg key", "klieg fill"]);
    let again = score(&place, "out/lit.glb", &[]);
    assert!(close(&again["score"], &result["score"]), "{again} {result}");
    assert_eq!(values(&again, "role"), ["key", "fill", "scene", "scene"]);
    assert!(!close(&result["headlight"]["score"], &without["headlight"]["score"]));
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(report.contains("2 lights are kept"), "{report}");

    let headlight = |more: &[&str]| {
        score(&place, "sunny.gltf", &[&["--preset", "headlight"], more].concat())["score"].clone()
    };
    assert!(close(&headlight(&["--keep-lights"]), &result["headlight"]["score"]));
    assert!(close(&headlight(&[]), &without["headlight"]["score"]));
    let key = ["--light", "30,20,2,0.2,0.2"];
    let given = score(&place, "sunny.gltf", &[&key[..], &["--keep-lights"]].concat());
    assert_eq!(values(&given, "role"), ["key", "scene", "scene"]);
    assert!(!close(&given["score"], &score(&place, "sunny.gltf", &key)["score"]));
}

#[test]
fn a_search_over_kept_lights_begins_anywhere_and_ends_at_sixteen() {
    let place = sunny();
    // The lit scene's own lights are klieg's: these start the search, and are not kept.
    design(&place, "out", &["--keep-lights"]);
    let arguments = ["design", "out/lit.glb", "--out", "two", "--first", "scene", "--keep-lights"];
    place.klieg(&[&arguments[..], &SMALL].concat()).assert().success();
    let result = place.read_json("two/result.json");
    assert_eq!(values(&result, "role"), ["key", "fill", "scene", "scene"]);
    assert_eq!(lit_nodes(&place, "two/lit.glb").len(), 4);

    let arguments = ["design", "sunny.gltf", "--out", "many", "--lights", "15", "--keep-lights"];
    let output = place.klieg(&[&arguments[..], &SMALL].concat()).assert().code(2);
    let fault = String::from_utf8(output.get_output().stderr.clone()).unwrap();
    assert!(fault.contains("15 lights to search and 2 of the scene's own"), "{fault}");
}

#[test]
fn a_batch_keeps_lights_too() {
    let place = sunny();
    std::fs::write(place.path("keep.toml"), "[lights]\nkeep = true\n").unwrap();
    let arguments = ["batch", "sunny.gltf", "--out", "all", "--config", "keep.toml"];
    place.klieg(&[&arguments[..], &SMALL, &["--color", "4000K"]].concat()).assert().success();
    let result = place.read_json("all/sunny/result.json");
    assert_eq!(result["scene_lights"]["kept"], true);
    assert_eq!(values(&result, "color"), ["4000K", "4000K", "#ffffff", "#ff0000"]);
    assert_eq!(lit_nodes(&place, "all/sunny/lit.glb").len(), 4);
}

#[test]
fn colours_go_by_role_into_all_files_and_come_back() {
    let place = sunny();
    let colors = ["--color", "fill=#ffddaa", "--color", "key=3200K"];
    let result = design(&place, "out", &colors);
    assert_eq!(values(&result, "color"), ["3200K", "#ffddaa"]);
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(report.contains("3200K") && report.contains("background: #ffddaa"), "{report}");
    let (_, lights) = glb(&place, "out/lit.glb");
    let green = lights[1]["color"][1].as_f64().unwrap();
    assert!((green - 0.723_055).abs() < 1e-5 && lights[1]["color"][0] == 1.0, "{lights}");
    let again = score(&place, "out/lit.glb", &[]);
    assert_eq!(values(&again, "color")[1], "#ffddaa");
    assert!(close(&again["score"], &result["score"]));
    for (a, b) in values(&again, "color_rgb").iter().zip(values(&result, "color_rgb")) {
        assert!((0..3).all(|i| close(&a[i], &b[i])), "{a} {b}");
    }
    let given = score(&place, "sunny.gltf", &["--preset", "three-point", "--color", "rim=9000K"]);
    assert_eq!(values(&given, "color"), ["#ffffff", "#ffffff", "9000K"]);
    place.klieg(&["score", "sunny.gltf", "--color", "9000K"]).assert().code(2);
}

#[test]
fn spots_are_searched_and_written() {
    let place = sunny();
    let result = design(&place, "out", &["--kind", "spot", "--intensities", "one"]);
    assert_eq!(values(&result, "kind"), ["spot", "spot"]);
    assert_eq!(values(&result, "diffuse"), values(&result, "specular"));
    let [inner, outer] = [0, 1].map(|i| values(&result, "cone_deg")[0][i].as_f64().unwrap());
    assert!(
        (10.0..=60.0).contains(&outer) && (inner - outer / 2.0).abs() < 1e-4,
        "{inner} {outer}"
    );
    let (_, lights) = glb(&place, "out/lit.glb");
    let written = lights[0]["spot"]["outerConeAngle"].as_f64().unwrap().to_degrees();
    assert!(lights[0]["type"] == "spot" && (written - outer).abs() < 1e-4, "{lights}");
    let again = score(&place, "out/lit.glb", &[]);
    assert!(close(&again["score"], &result["score"]));
    assert!(close(&values(&again, "cone_deg")[0][1], &outer.into()));
    // Both intensities are free of each other again.
    let two = design(&place, "two", &["--intensities", "two"]);
    assert_ne!(values(&two, "diffuse"), values(&two, "specular"));
}
