//! `--profile`: what settings start from.

use common::Folder;
use klieg::design::profile::{DEFAULT, NATURAL, PROFILES};
use klieg::objective::Terms;
use klieg_support::common;
use serde_json::{Value, json};

/// Standard output as JSON, which it must be alone.
fn json_of(place: &Folder, arguments: &[&str]) -> Value {
    let output = place.klieg(arguments).args(["--json"]).assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Azimuth and intensities of a light.
fn numbers(light: &Value) -> [f64; 3] {
    ["azimuth_deg", "diffuse", "specular"].map(|key| light[key].as_f64().unwrap())
}

#[test]
fn a_natural_design_has_its_objective_and_its_lights() {
    let place = Folder::new();
    place.design("out", &["--profile", "natural", "--lights", "3"]).assert().success();
    let result = place.read_json("out/result.json");
    assert_eq!(result["profile"], "natural");
    assert_eq!(result["objective"]["targets"]["mean"], "scene");
    let weights = (NATURAL.objective)().weights;
    let told: Terms = serde_json::from_value(result["objective"]["weights"].clone()).unwrap();
    assert_eq!(told, weights);
    // Without a background the outline does not count.
    let terms = |result: &Value| -> Vec<String> {
        result["terms"].as_object().unwrap().keys().cloned().collect()
    };
    assert_eq!(terms(&result), (NATURAL.objective)().measured().names().collect::<Vec<_>>());
    assert_eq!(result["objective"]["targets"]["background"], Value::Null);
    let white = ["--profile", "natural", "--background", "#ffffff"];
    place.design("white", &white).assert().success();
    let white = place.read_json("white/result.json");
    assert_eq!(terms(&white), weights.names().collect::<Vec<_>>());
    let background = white["objective"]["targets"]["background"].as_f64().unwrap();
    assert!((background - 1.0).abs() < 1e-6, "{background}");
    let [key, fill, rim] = [0, 1, 2].map(|at| numbers(&result["lights"][at]));
    for [_, diffuse, specular] in [key, fill, rim] {
        assert_eq!(diffuse, specular);
    }
    let across = if key[0] > 0.0 { key[0] - fill[0] } else { fill[0] - key[0] };
    assert!((19.99..110.01).contains(&across), "{key:?} {fill:?}");
    assert!((0.049..0.601).contains(&(fill[1] / key[1])), "{key:?} {fill:?}");
    assert!((0.099..1.501).contains(&(rim[1] / key[1])), "{key:?} {rim:?}");
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(report.contains("profile natural, seed 0"));
    place.design("usual", &[]).assert().success();
    assert_eq!(place.read_json("usual/result.json")["profile"], DEFAULT.name);
}

#[test]
fn a_preset_is_judged_as_the_profile_has_it() {
    let place = Folder::new();
    let score = ["score", "ball.gltf", "--size", "40x40", "--preset", "three-point"];
    let scored = |more: &[&str]| json_of(&place, &[&score[..], more].concat());
    let (paper, natural) = (scored(&["--profile", "paper"]), scored(&["--profile", "natural"]));
    assert_eq!((&paper["profile"], &natural["profile"]), (&json!("paper"), &json!("natural")));
    assert_eq!(natural["terms"].as_object().unwrap().len(), 9);
    // Its shading counts as well as its objective.
    let paper_shading = ["--profile", "natural", "--brdf", "blinn-phong"];
    assert_ne!(natural["terms"]["mean"], scored(&paper_shading)["terms"]["mean"]);
    assert_eq!(scored(&[]), scored(&["--profile", DEFAULT.name]));

    // A file may name it too, and is asked before the default and after the command line.
    std::fs::write(place.path("k.toml"), "profile = \"natural\"\nseed = 3\n").unwrap();
    assert_eq!(natural, scored(&["--config", "k.toml"]));
    assert_eq!(paper, scored(&["--config", "k.toml", "--profile", "paper"]));
    let weighed = scored(&["--profile", "natural", "--weights", "relief=1"]);
    assert_eq!(weighed["objective"]["weights"]["relief"], 1.0);
    assert_eq!(weighed["objective"]["weights"]["burnt"], natural["objective"]["weights"]["burnt"]);
}

#[test]
fn every_command_with_settings_names_its_profile() {
    let place = Folder::new();
    let natural = ["--profile", "natural"];
    let small = ["--size", "24x20"];
    let search = ["--generations", "2", "--population", "4"];
    let study = ["--grid", "4x3"];
    // The paper's experiments and the measurements stay with its method.
    for (arguments, usual) in [
        (&["analyze", "ball.gltf", "--out", "maps"][..], DEFAULT.name),
        (&["study", "landscape", "ball.gltf", "--out", "land", study[0], study[1]], "paper"),
        (&["bench", "ball.gltf", "--runs", "1", "--lights", "1", "--warm-up", "0"], "paper"),
        (
            &["batch", "ball.gltf", "--out", "many", search[0], search[1], search[2], search[3]],
            DEFAULT.name,
        ),
    ] {
        let unnamed = json_of(&place, &[arguments, &small].concat());
        assert_eq!(unnamed["profile"], usual, "{arguments:?}");
        let named = json_of(&place, &[arguments, &small, &natural].concat());
        assert_eq!(named["profile"], "natural", "{arguments:?}");
    }
}

#[test]
fn terms_are_listed_with_the_weights_of_a_profile() {
    let place = Folder::new();
    for profile in PROFILES {
        let listing = json_of(&place, &["terms", "--profile", profile.name]);
        assert_eq!(listing["profile"], profile.name);
        for term in listing["terms"].as_array().unwrap() {
            let weight = (profile.objective)().weights.get(term["name"].as_str().unwrap());
            let told: f32 = serde_json::from_value(term["weight"].clone()).unwrap();
            assert_eq!(told, weight.unwrap_or(0.0));
        }
    }
}

#[test]
fn an_unknown_profile_is_refused_with_the_known_ones() {
    let place = Folder::new();
    let fault = place.klieg(&["score", "ball.gltf", "--profile", "film"]).assert().code(2);
    let text = String::from_utf8(fault.get_output().stderr.clone()).unwrap();
    assert!(text.contains("film") && text.contains("paper, natural"), "{text}");
    std::fs::write(place.path("k.toml"), "profile = \"film\"\n").unwrap();
    let fault = place.klieg(&["score", "ball.gltf", "--config", "k.toml"]).assert().code(2);
    let text = String::from_utf8(fault.get_output().stderr.clone()).unwrap();
    assert!(text.contains("k.toml") && text.contains("line 1"), "{text}");
}

#[test]
fn shadows_are_a_choice_and_their_table_tells_where_it_is_coarse() {
    let place = Folder::new();
    let score = |arguments: &[&str]| {
        let mut all =
            vec!["score", "ball.gltf", "--preset", "three-point", "--size", "200x200", "--json"];
        all.extend(arguments);
        let output = place.klieg(&all).output().unwrap();
        assert!(output.status.success());
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        (json["score"].as_f64().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (with, quiet) = score(&[]);
    let (without, _) = score(&["--shadows", "off"]);
    assert!((with - without).abs() > 1e-6 && !quiet.contains("shadow table"), "{with} {without}");
    let settings = place.path("coarse.toml");
    std::fs::write(&settings, "[shadows]\nmemory = 1\n").unwrap();
    let (_, told) = score(&["--config", settings.to_str().unwrap()]);
    assert!(
        told.contains("directions in place of 31x31") && told.contains("shadows.memory"),
        "{told}"
    );
}
