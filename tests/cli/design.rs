//! `klieg design`, from a scene to the files that it leaves.

use common::Folder;
use klieg::objective::Term;
use klieg_support::common;
use serde_json::Value;
use std::time::Duration;

const FILES: [&str; 7] = [
    "best.png",
    "convergence.csv",
    "convergence.svg",
    "headlight.png",
    "lit.glb",
    "report.html",
    "result.json",
];

/// All keys of an object, dotted; those of an array's first entry with `[]`.
fn keys(value: &Value, prefix: &str, out: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                keys(value, &name, out);
            }
        }
        Value::Array(values) if values.first().is_some_and(Value::is_object) => {
            keys(&values[0], &format!("{prefix}[]"), out);
        }
        _ => out.push(prefix.into()),
    }
}

#[test]
fn a_design_writes_all_files_and_beats_the_headlight() {
    let place = Folder::new();
    let output = place.design("a/b", &[]).assert().success().get_output().clone();
    assert_eq!(place.list("a/b"), FILES);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("device: ") && stderr.contains("(cpu, "), "{stderr}");
    let stdout = String::from_utf8(output.stdout).unwrap();
    for text in ["headlight", "designed", "key", "fill", "result.json"] {
        assert!(stdout.contains(text), "{text}: {stdout}");
    }

    let result = place.read_json("a/b/result.json");
    assert!(result["score"].as_f64() < result["headlight"]["score"].as_f64());
    for name in ["best.png", "headlight.png"] {
        let picture = image::open(place.path("a/b").join(name)).unwrap();
        assert_eq!((picture.width(), picture.height()), (48, 40));
    }
    let best = std::fs::read(place.path("a/b/best.png")).unwrap();
    assert_ne!(best, std::fs::read(place.path("a/b/headlight.png")).unwrap());
    let table = std::fs::read_to_string(place.path("a/b/convergence.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0], ["generation", "evaluations", "best", "mean", "worst", "picture"]);
    assert_eq!(rows.len(), 5);
    assert_eq!([rows[4][0], rows[4][1], rows[4][5]], ["4", "32", "whole"]);
    let best: f64 = rows[4][2].parse().unwrap();
    assert!((best - result["score"].as_f64().unwrap()).abs() < 1e-5);
}

#[test]
fn the_schema_of_the_result() {
    let place = Folder::new();
    let output = place
        .design("out", &["--profile", "paper", "--json"])
        .assert()
        .success()
        .get_output()
        .clone();
    let result = place.read_json("out/result.json");
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, result);

    let mut found = Vec::new();
    keys(&result, "", &mut found);
    found.sort();
    let terms =
        |prefix: &str| ["edge", "grad", "hist", "mean", "var"].map(|t| format!("{prefix}.{t}"));
    let mut expected: Vec<String> = [
        "schema",
        "klieg",
        "profile",
        "scene",
        "seed",
        "size",
        "score",
        "generations",
        "evaluations",
        "camera.name",
        "camera.type",
        "camera.yfov_deg",
        "camera.position",
        "camera.right",
        "camera.up",
        "camera.back",
        "device.name",
        "device.type",
        "device.driver",
        "intent.brightness",
        "intent.contrast",
        "intent.mood",
        "intent.below",
        "objective.targets.mean",
        "objective.targets.mean_stops",
        "objective.targets.spread",
        "objective.targets.edge_contrast",
        "objective.targets.edge_sobel",
        "objective.targets.edge_laplace",
        "objective.targets.example",
        "objective.targets.background",
        "headlight.score",
        "lights[].role",
        "lights[].kind",
        "lights[].color",
        "lights[].color_rgb",
        "lights[].size",
        "lights[].cone_deg",
        "lights[].axis",
        "lights[].elevation_deg",
        "lights[].azimuth_deg",
        "lights[].distance",
        "lights[].diffuse",
        "lights[].specular",
        "lights[].position",
        "scene_lights.count",
        "scene_lights.kept",
        "timing_ms.load",
        "timing_ms.maps",
        "timing_ms.search",
        "timing_ms.total",
    ]
    .map(String::from)
    .to_vec();
    expected.extend(terms("objective.weights"));
    expected.extend(terms("terms"));
    expected.extend(terms("headlight.terms"));
    expected.sort();
    assert_eq!(found, expected);
    assert_eq!(result["schema"], "klieg.result/1");
    assert_eq!(result["klieg"], env!("CARGO_PKG_VERSION"));
    assert_eq!(result["scene"], "ball.gltf");
    assert_eq!(result["size"], serde_json::json!([48, 40]));
    assert_eq!(result["lights"][0]["role"], "key");
    assert_eq!(result["lights"][1]["role"], "fill");
    assert!(result["lights"].as_array().unwrap().iter().all(|l| l["position"][2].is_number()));
}

/// The result without its times.
fn timeless(place: &Folder, name: &str) -> Value {
    let mut result = place.read_json(name);
    result.as_object_mut().unwrap().remove("timing_ms").unwrap();
    result
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let place = Folder::new();
    for (out, seed) in [("a", "7"), ("b", "7"), ("c", "8")] {
        place.design(out, &["--seed", seed]).assert().success();
    }
    assert_eq!(timeless(&place, "a/result.json"), timeless(&place, "b/result.json"));
    assert_ne!(timeless(&place, "a/result.json"), timeless(&place, "c/result.json"));
    for name in FILES.iter().filter(|name| **name != "result.json") {
        let read = |out: &str| std::fs::read(place.path(out).join(name)).unwrap();
        assert!(read("a") == read("b"), "{name}");
        assert!(*name == "headlight.png" || read("a") != read("c"), "{name}");
    }
}

#[test]
fn a_lit_scene_scores_as_it_was_designed() {
    let place = Folder::new();
    for kind in ["point", "directional"] {
        place.design(kind, &["--kind", kind, "--lights", "3"]).assert().success();
        let result = place.read_json(&format!("{kind}/result.json"));
        let lit = format!("{kind}/lit.glb");
        let output =
            place.klieg(&["score", &lit, "--json"]).assert().success().get_output().clone();
        let score: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(score["rig"], "scene");
        assert_eq!(score["size"], result["size"]);
        assert_eq!(score["lights"].as_array().unwrap().len(), 3);
        let difference = score["score"].as_f64().unwrap() - result["score"].as_f64().unwrap();
        assert!(difference.abs() < 1e-3, "{kind}: {difference}");
        let headlight = ["score", &lit, "--preset", "headlight", "--json"];
        let output = place.klieg(&headlight).assert().success().get_output().clone();
        let other: Value = serde_json::from_slice(&output.stdout).unwrap();
        let difference = other["score"].as_f64().unwrap() - result["score"].as_f64().unwrap();
        assert!(difference.abs() > 1e-3, "the comparison cannot fail");
    }
}

#[test]
fn the_sheet_is_self_contained() {
    let place = Folder::new();
    let scene = place.path("a & b <i>.gltf");
    std::fs::rename(place.path("ball.gltf"), &scene).unwrap();
    let mut command = place.klieg(&["design", "a & b <i>.gltf", "--out", "out"]);
    command.args(["--size", "32x32", "--generations", "2"]).assert().success();
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    let external: Vec<_> = ["src=\"", "href=\"", "url("]
        .iter()
        .flat_map(|mark| page.match_indices(mark).map(|(at, mark)| &page[at + mark.len()..]))
        .filter(|rest| !rest.starts_with("data:"))
        .collect();
    assert!(external.is_empty());
    assert!(page.matches("<script").count() == 1 && !page.contains("@import"));
    let namespaces = page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(page.matches("http").count(), namespaces);
    assert!(page.contains("a &amp; b &lt;i&gt;.gltf") && !page.contains("<i>.gltf"));
    // Four pictures, and a map for each of two lights.
    assert_eq!(page.matches("data:image/png;base64,").count(), 6);
    assert_eq!(page.matches("<svg class=\"dome\"").count(), 2);
}

#[test]
fn the_sheet_explains_every_term_of_the_objective() {
    let place = Folder::new();
    place
        .design("out", &["--profile", "paper", "--weights", "range=0.35,grad=0"])
        .assert()
        .success();
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    let result = place.read_json("out/result.json");
    let table = page.split("<table class=\"judged\">").nth(1).unwrap();
    let rows: Vec<_> = table.split("</table>").next().unwrap().split("<tr>").skip(2).collect();
    let measured = result["terms"].as_object().unwrap().keys();
    assert!(measured.clone().eq(["edge", "mean", "grad", "var", "hist", "range"]));
    // What does not count has no row, and is told below.
    let names = measured.filter(|name| *name != "grad");
    assert_eq!(rows.len(), names.clone().count() + 1);
    let others = page.split("of weight 0:").nth(1).expect("what does not count");
    assert!(others.split("</p>").next().unwrap().contains("shading"));
    for (row, name) in rows.iter().zip(names) {
        let term = Term::named(name).unwrap();
        let number = |pointer: &str| result.pointer(&format!("{pointer}/{name}")).unwrap();
        let digits =
            |pointer, digits| format!("<td>{:.digits$}</td>", number(pointer).as_f64().unwrap());
        for part in [
            term.title,
            term.meaning,
            &digits("/objective/weights", 2),
            &digits("/headlight/terms", 3),
            &digits("/terms", 3),
        ] {
            assert!(row.contains(part), "{part}: {row}");
        }
    }
    assert!(!page.contains("five"));
}

#[test]
fn options_go_before_the_configuration() {
    let place = Folder::new();
    let text = "seed = 5\n[view]\nsize = \"20x30\"\nazimuth = -40.0\n[lights]\nroles = [\"rim\"]\n\
                kind = \"directional\"\n[search]\npopulation = 6\ngenerations = 2\n";
    std::fs::write(place.path("k.toml"), text).unwrap();
    let base = ["design", "ball.gltf", "--config", "k.toml"];
    place.klieg(&base).args(["--out", "a"]).assert().success();
    let result = place.read_json("a/result.json");
    assert_eq!((&result["seed"], &result["size"]), (&5.into(), &serde_json::json!([20, 30])));
    assert_eq!(
        (&result["lights"][0]["role"], &result["lights"][0]["kind"]),
        (&"rim".into(), &"directional".into())
    );
    assert_eq!(result["lights"][0]["position"], Value::Null);
    assert_eq!(result["generations"], 2);
    let more = [
        "--out",
        "b",
        "--seed",
        "6",
        "--size",
        "32x32",
        "--lights",
        "key,rim",
        "--weights",
        "edge=1",
    ];
    place.klieg(&base).args(more).assert().success();
    let result = place.read_json("b/result.json");
    assert_eq!((&result["seed"], &result["size"]), (&6.into(), &serde_json::json!([32, 32])));
    assert_eq!(result["lights"].as_array().unwrap().len(), 2);
    assert_eq!(result["objective"]["weights"]["edge"], 1.0);
}

/// Ctrl-C: the running generation ends, and the best so far is written.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_best_so_far() {
    let place = Folder::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("klieg"))
        .current_dir(place.path(""))
        .args(["design", "ball.gltf", "--out", "out", "--device", "cpu", "--size", "64x64"])
        .args(["--generations", "1000000", "--optimizer", "ga"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // The staging folder appears just before the search begins.
    while !place.path("out").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_secs(2));
    let interrupt = ["-INT", &child.id().to_string()];
    assert!(std::process::Command::new("kill").args(interrupt).status().unwrap().success());
    assert!(child.wait().unwrap().success());
    assert_eq!(place.list("out"), FILES);
    assert!(place.read_json("out/result.json")["generations"].as_u64().unwrap() < 1_000_000);
}

#[test]
fn a_scene_far_from_the_origin_scores_as_it_was_designed() {
    let place = Folder::new();
    let mut far = place.read_json("ball.gltf");
    let parent = serde_json::json!({"children": [0, 1], "translation": [1e6, -3e5, 2e6]});
    far["nodes"].as_array_mut().unwrap().push(parent);
    far["scenes"][0]["nodes"] = serde_json::json!([2]);
    std::fs::write(place.path("far.gltf"), far.to_string()).unwrap();
    let small = ["--size", "48x40", "--generations", "2", "--population", "8", "--json"];
    let output = place.klieg(&["design", "far.gltf", "--out", "out"]).args(small).output().unwrap();
    let designed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let output = place.klieg(&["score", "out/lit.glb", "--json"]).output().unwrap();
    let scored: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let difference = designed["score"].as_f64().unwrap() - scored["score"].as_f64().unwrap();
    assert!(difference.abs() < 1e-3, "{designed} {scored}");
}

#[test]
fn the_scene_itself_is_never_overwritten() {
    let place = Folder::new();
    place.design("out", &[]).assert().success();
    let before = std::fs::read(place.path("out/lit.glb")).unwrap();
    let mut command = place.klieg(&["design", "out/lit.glb", "--out", "out"]);
    command.args(["--generations", "2"]).assert().code(2);
    assert_eq!(std::fs::read(place.path("out/lit.glb")).unwrap(), before);
    assert_eq!(place.list("out").len(), 7);
}

#[test]
fn a_design_on_a_vulkan_device_repeats_itself_and_scores_as_it_was_designed() {
    let place = Folder::new();
    for out in ["one", "two"] {
        let vulkan = ["design", "ball.gltf", "--out", out, "--device", "vulkan"];
        let small = ["--size", "48x40", "--generations", "4", "--population", "8"];
        place.klieg(&vulkan).args(small).assert().success();
    }
    for name in place.list("one") {
        let read = |out: &str| std::fs::read(place.path(&format!("{out}/{name}"))).unwrap();
        assert!(name == "result.json" || read("one") == read("two"), "{name}");
    }
    let result = place.read_json("one/result.json");
    assert_ne!(result["device"]["type"], "cpu");
    for device in ["vulkan", "cpu"] {
        let arguments = ["score", "one/lit.glb", "--json", "--device", device];
        let output = place.klieg(&arguments).output().unwrap();
        let score: Value = serde_json::from_slice(&output.stdout).unwrap();
        let difference = score["score"].as_f64().unwrap() - result["score"].as_f64().unwrap();
        assert!(difference.abs() < 1e-3, "{device}: {score} {result}");
    }
}

#[test]
fn a_search_can_begin_with_the_scene_s_own_lights() {
    let place = Folder::new();
    place.design("first", &[]).assert().success();
    let found = place.read_json("first/result.json");
    let again = |out: &str, more: &[&str]| {
        let arguments = ["design", "first/lit.glb", "--out", out, "--first", "scene"];
        let mut command = place.klieg(&arguments);
        command.args(["--population", "2", "--generations", "1"]).args(more);
        command
    };
    // The elite of two individuals is what was found before, or better.
    again("again", &[]).assert().success();
    let (before, after) = (found["score"].as_f64(), place.read_json("again/result.json"));
    assert!(after["score"].as_f64().unwrap() <= before.unwrap() + 1e-5, "{after}");
    again("greedy", &["--optimizer", "greedy"]).assert().success();
    let after = place.read_json("greedy/result.json");
    assert!(after["score"].as_f64() < before, "{after}");
    let output = again("wrong", &["--lights", "3"]).assert().code(2).get_output().clone();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("2 lights") && text.contains("search for 3"), "{text}");
}

#[test]
fn little_memory_gives_the_same_bytes() {
    let place = Folder::new();
    let run = |out: &str, pipeline: &str, more: &[&str]| {
        let arguments = ["design", "ball.gltf", "--out", out, "--device", "vulkan"];
        let mut command = place.klieg(&arguments);
        command.args(["--size", "300x300", "--generations", "2", "--pipeline", pipeline]);
        command.args(more).assert().success();
        std::fs::read(place.path(out).join("convergence.csv")).unwrap()
    };
    for pipeline in ["layered", "compute"] {
        // A population of 30 needs 10 MB of layers, so that 1 MiB makes ten parts of it.
        assert!(run("all", pipeline, &[]) == run("parts", pipeline, &["--memory", "1"]));
    }
    place.design("none", &["--memory", "0"]).assert().code(2);
}
