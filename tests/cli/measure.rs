//! `klieg score`, `analyze`, `devices`, `terms` and `bench`.

use common::Folder;
use klieg::objective::terms::TERMS;
use klieg_support::common;
use serde_json::{Value, json};

/// Standard output as JSON, which it must be alone.
fn json_of(place: &Folder, arguments: &[&str]) -> Value {
    let output = place.klieg(arguments).args(["--json"]).assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn scores_of_given_lights_and_presets() {
    let place = Folder::new();
    let score = ["score", "ball.gltf", "--size", "40x40", "--profile", "paper"];
    let given = |more: &[&str]| json_of(&place, &[&score[..], more].concat());
    let headlight = given(&["--preset", "headlight"]);
    let same = given(&["--light", "0,0,1,1,1", "--kind", "directional"]);
    assert_eq!(headlight["score"], same["score"]);
    assert_eq!((&headlight["rig"], &same["rig"]), (&json!("headlight"), &json!("options")));
    let other = given(&["--light", "-30,-60,2,1,1", "--light", "40,20,2,0.5,0"]);
    assert_ne!(headlight["score"], other["score"]);
    assert!((other["lights"][0]["azimuth_deg"].as_f64().unwrap() + 60.0).abs() < 1e-4);
    assert_eq!(other["lights"].as_array().unwrap().len(), 2);
    assert_eq!(given(&["--preset", "light-kit"])["lights"].as_array().unwrap().len(), 5);

    let terms: Vec<f64> =
        other["terms"].as_object().unwrap().values().map(|t| t.as_f64().unwrap()).collect();
    let mean = terms.iter().sum::<f64>() / 5.0;
    assert!((mean - other["score"].as_f64().unwrap()).abs() < 1e-5);
    let weighed = given(&["--preset", "headlight", "--weights", "0,1,0,0,0"]);
    assert_eq!(weighed["score"], weighed["terms"]["mean"]);

    let text = place.klieg(&score).args(["--preset", "three-point"]).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.contains("three-point") && text.contains("rim"), "{text}");
}

/// The names and numbers of an object.
fn numbers(value: &Value) -> Vec<(&str, f64)> {
    let all = value.as_object().unwrap().iter();
    all.map(|(name, number)| (name.as_str(), number.as_f64().unwrap())).collect()
}

#[test]
fn any_terms_are_weighed_and_shown() {
    let place = Folder::new();
    let score = ["score", "ball.gltf", "--size", "40x40", "--preset", "headlight"];
    let toml = "[objective.weights]\nrange = 0.5\nhist = 0.25\ndirection = 0.0\n";
    std::fs::write(place.path("k.toml"), toml).unwrap();
    let scored = json_of(&place, &[&score[..], &["--config", "k.toml"]].concat());
    let weights = numbers(&scored["objective"]["weights"]);
    assert_eq!(weights, [("hist", 0.25), ("range", 0.5), ("direction", 0.0)]);
    let terms = numbers(&scored["terms"]);
    let sum: f64 = terms.iter().zip(&weights).map(|((_, term), (_, weight))| term * weight).sum();
    assert!(terms.iter().map(|t| t.0).eq(weights.iter().map(|w| w.0)), "{terms:?}");
    assert!((sum - scored["score"].as_f64().unwrap()).abs() < 1e-6 && sum > 0.0);
    // What only a term of weight 0 needs is not measured.
    let more = ["--config", "k.toml", "--weights", "relief=0,hist=1"];
    let scored = json_of(&place, &[&score[..], &more].concat());
    let names = |key: &Value| numbers(key).iter().map(|n| n.0.to_owned()).collect::<Vec<_>>();
    assert_eq!(names(&scored["objective"]["weights"]), ["hist", "range", "relief", "direction"]);
    assert_eq!(names(&scored["terms"]), ["hist", "range", "direction"]);
    let text = place.klieg(&score).args(["--weights", "range=1"]).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.lines().any(|line| line.starts_with(" range ")), "{text}");
}

#[test]
fn the_terms_are_listed() {
    let place = Folder::new();
    let listing = json_of(&place, &["terms", "--profile", "paper"]);
    assert_eq!(listing["schema"], "klieg.terms/1");
    let terms = listing["terms"].as_array().unwrap();
    assert_eq!(terms.len(), TERMS.len());
    let text = place.klieg(&["terms"]).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    for (listed, term) in terms.iter().zip(TERMS) {
        assert_eq!((&listed["name"], &listed["title"]), (&json!(term.name), &json!(term.title)));
        let needs: Vec<_> = term.needs.names().collect();
        assert_eq!(listed["needs"], json!(needs));
        // A row goes on in lines that begin with blanks.
        let mut lines = text.lines();
        let row = lines.find(|line| line.starts_with(&format!(" {} ", term.name)));
        let row = row.unwrap_or_else(|| panic!("{}: {text}", term.name));
        let row: Vec<_> = std::iter::once(row)
            .chain(lines.take_while(|line| line.starts_with("  ")))
            .flat_map(str::split_whitespace)
            .collect();
        assert!(term.meaning.split_whitespace().all(|word| row.contains(&word)), "{row:?}");
        assert!(needs.iter().all(|need| row.iter().any(|word| word.contains(need))), "{row:?}");
    }
    let weights: f64 = terms.iter().map(|term| term["weight"].as_f64().unwrap()).sum();
    assert!((weights - 1.0).abs() < 1e-6);
}

#[test]
fn an_analysis_agrees_with_its_arrays() {
    let place = Folder::new();
    let arguments = ["analyze", "ball.gltf", "--out", "maps", "--size", "50x40", "--lights", "3"];
    let analysis = json_of(&place, &arguments);
    assert_eq!(analysis, place.read_json("maps/analyze.json"));
    let expected = [
        "analyze.json",
        "base_color.npy",
        "clusters.png",
        "code.npy",
        "code.png",
        "depth.npy",
        "depth.png",
        "edges.png",
        "emissive.npy",
        "metallic.npy",
        "normal.npy",
        "normals.png",
        "position.npy",
        "roughness.npy",
        "types.npy",
        "types.png",
    ];
    assert_eq!(place.list("maps"), expected);
    for name in expected.iter().filter(|name| name.ends_with(".png")) {
        let picture = image::open(place.path("maps").join(name)).unwrap();
        assert_eq!((picture.width(), picture.height()), (50, 40));
    }
    for array in analysis["arrays"].as_array().unwrap() {
        let bytes =
            std::fs::read(place.path("maps").join(array["file"].as_str().unwrap())).unwrap();
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(json!(file.shape()), array["shape"]);
    }
    let code: Vec<u32> = array(&place, "code");
    let types: Vec<u8> = array(&place, "types");
    for (kind, name) in ["background", "surface", "edge"].iter().enumerate() {
        let count = types.iter().filter(|&&t| usize::from(t) == kind).count();
        assert_eq!(analysis["pixels"][name], count, "{name}");
    }
    let objects = analysis["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 2);
    for object in objects {
        let first = object["first_polygon"].as_u64().unwrap() as u32;
        let range = first..first + object["polygons"].as_u64().unwrap() as u32;
        let pixels = code.iter().filter(|c| range.contains(c)).count();
        assert_eq!(object["visible_pixels"], pixels);
        assert!(pixels > 0);
    }
    let clusters = analysis["clusters"].as_array().unwrap();
    assert_eq!(clusters.len(), 3);
    let members: u64 = clusters.iter().map(|c| c["polygons"].as_u64().unwrap()).sum();
    assert_eq!(analysis["visible_polygons"], members);
}

/// An array of the folder `maps`.
fn array<T: npyz::Deserialize>(place: &Folder, name: &str) -> Vec<T> {
    let bytes = std::fs::read(place.path(&format!("maps/{name}.npy"))).unwrap();
    npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap()
}

#[test]
fn an_analysis_has_all_that_shading_needs() {
    let place = Folder::new();
    let analysis = json_of(&place, &["analyze", "ball.gltf", "--out", "maps", "--size", "50x40"]);
    let [code, vectors] = [json!([40, 50]), json!([40, 50, 3])];
    let shape = |name: &str| {
        let arrays = analysis["arrays"].as_array().unwrap();
        arrays.iter().find(|of| of["file"] == format!("{name}.npy")).unwrap()["shape"].clone()
    };
    for name in ["position", "normal", "base_color", "emissive"] {
        assert_eq!(shape(name), vectors, "{name}");
    }
    assert_eq!([shape("metallic"), shape("roughness")], [code.clone(), code]);
    let objects: Vec<_> = array::<u32>(&place, "code").iter().map(|&code| code != 0).collect();
    let [depth, roughness, metallic]: [Vec<f32>; 3] =
        ["depth", "roughness", "metallic"].map(|name| array(&place, name));
    let position: Vec<f32> = array(&place, "position");
    // The viewer's place along its axis, which a position and its depth lead to from any pixel.
    let camera = |name: &str| -> Vec<f64> {
        analysis["camera"][name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let center = analysis["center"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
    let away = std::iter::zip(camera("position"), center).map(|(eye, center)| eye - center);
    let eye: f64 = std::iter::zip(away, camera("back")).map(|(away, back)| away * back).sum();
    let eye = eye / analysis["radius"].as_f64().unwrap();
    for (at, _) in objects.iter().enumerate().filter(|(_, object)| **object) {
        let found = f64::from(position[3 * at + 2] + depth[at]);
        assert!((found - eye).abs() < 1e-4, "{found}, not {eye}");
        assert_eq!((metallic[at], roughness[at]), (0.0, 0.5));
    }
    let emissive: Vec<f32> = array(&place, "emissive");
    assert!(emissive.iter().all(|&channel| channel == 0.0));
}

#[test]
fn the_list_of_devices_ends_with_the_native_evaluator() {
    let place = Folder::new();
    let listing = json_of(&place, &["devices"]);
    let devices = listing["devices"].as_array().unwrap();
    let indices: Vec<_> = devices.iter().map(|d| d["index"].as_u64().unwrap() as usize).collect();
    assert_eq!(indices, (0..devices.len()).collect::<Vec<_>>());
    let native = &devices[devices.len() - 1];
    assert_eq!(native["type"], "cpu");
    assert!(listing["auto"].as_u64().unwrap() < devices.len() as u64);
    for device in &devices[..devices.len() - 1] {
        assert_eq!(device["pipeline"], "compute");
        assert!(!device["pipeline_reason"].as_str().unwrap().is_empty());
        assert!(!device["shadow_reason"].as_str().unwrap().is_empty());
    }
    let text = place.klieg(&["devices"]).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    for device in devices {
        assert!(text.contains(device["name"].as_str().unwrap()), "{text}");
    }
    let index = native["index"].to_string();
    let score =
        ["score", "ball.gltf", "--preset", "headlight", "--size", "16x16", "--device", &index];
    assert_eq!(json_of(&place, &score)["device"]["type"], "cpu");
}

#[test]
fn the_memory_of_a_search_is_told_before_it_is_taken() {
    let place = Folder::new();
    let planned = |more: &[&str]| {
        let asked = ["devices", "--for", "ball.gltf", "--size", "64x48"];
        json_of(&place, &[&asked[..], more].concat())
    };
    let told = planned(&["--lights", "3", "--population", "50"]);
    let search = &told["for"];
    assert_eq!((&search["size"], &search["lights"]), (&json!("64x48"), &json!(3)));
    assert_eq!((&search["population"], &search["shadows"]), (&json!(50), &json!(true)));
    let plain = planned(&["--shadows", "off"]);
    let vulkan = |listing: &Value| -> Vec<Value> {
        let devices = listing["devices"].as_array().unwrap();
        devices[..devices.len() - 1].to_vec()
    };
    for (device, unshadowed) in vulkan(&told).iter().zip(vulkan(&plain)) {
        let names: Vec<_> = device["plans"].as_array().unwrap().iter().collect();
        assert_eq!(names.iter().map(|plan| &plan["pipeline"]).collect::<Vec<_>>()[0], "compute");
        for (plan, other) in names.iter().zip(unshadowed["plans"].as_array().unwrap()) {
            let bytes = |plan: &Value, name: &str| plan[name].as_u64().unwrap();
            // 31 words of 4 bytes for each pixel.
            assert!(bytes(plan, "shadows") >= 64 * 48 * 31 * 4, "{plan}");
            assert!(bytes(other, "shadows") < 64 << 10, "{other}");
            assert!(bytes(plan, "population") > bytes(other, "population"), "{plan} {other}");
            assert_eq!(plan["fits"], true, "{plan}");
        }
    }
    let text = place.klieg(&["devices", "--for", "ball.gltf"]).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.contains("at 512x512, 20 rigs of 2 lights, with shadows"), "{text}");

    std::fs::write(place.path("bad.gltf"), "{").unwrap();
    for wrong in [
        &["--for", "bad.gltf"][..],
        &["--for", "none.gltf"],
        &["--for", "ball.gltf", "--population", "1"],
        &["--size", "64x64"],
    ] {
        place.klieg(&[&["devices"], wrong].concat()).assert().code(2);
    }
}

#[test]
fn every_pipeline_gives_the_same_score() {
    let place = Folder::new();
    let score = |more: &[&str]| {
        let arguments = ["score", "ball.gltf", "--preset", "headlight", "--size", "40x30"];
        json_of(&place, &[&arguments[..], &["--device", "vulkan"], more].concat())["score"]
            .as_f64()
            .unwrap()
    };
    let expected = score(&[]);
    for pipeline in ["auto", "layered", "forward", "compute"] {
        assert!((score(&["--pipeline", pipeline]) - expected).abs() < 1e-4, "{pipeline}");
    }
    std::fs::write(place.path("layered.toml"), "pipeline = \"layered\"").unwrap();
    for (more, said) in [(&[][..], "pipeline layered"), (&["--pipeline", "compute"], "compute")] {
        let arguments = ["score", "ball.gltf", "--preset", "headlight", "--config", "layered.toml"];
        let arguments = [&arguments[..], &["--size", "40x30", "--device", "vulkan"], more].concat();
        let run = place.klieg(&arguments).assert().success();
        let log = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert!(log.contains(said), "{log}");
    }
    let unknown = ["score", "ball.gltf", "--preset", "headlight", "--pipeline", "none"];
    place.klieg(&unknown).assert().code(2);
}

/// Pipelines that a run has compiled are stored for the next one. Whatever is there instead does no harm.
#[test]
fn compiled_pipelines_are_stored_in_the_cache_folder() {
    let place = Folder::new();
    let arguments = ["score", "ball.gltf", "--size", "24x24", "--device", "vulkan", "--json"];
    let run = |cache: &str| {
        let mut command = place.klieg(&arguments);
        let command = command.args(["--preset", "headlight"]).env("XDG_CACHE_HOME", cache);
        let output = command.assert().success().get_output().clone();
        let score: Value = serde_json::from_slice(&output.stdout).unwrap();
        (score["score"].clone(), String::from_utf8(output.stderr).unwrap())
    };
    let cache = place.path("cache");
    let cache = cache.to_str().unwrap();
    let first = run(cache);
    let [name] = &place.list("cache/klieg")[..] else { panic!("one file") };
    let file = place.path("cache/klieg").join(name);
    let stored = std::fs::read(&file).unwrap();
    assert_eq!(run(cache), first);
    std::fs::write(&file, &stored[..stored.len() / 2]).unwrap();
    assert_eq!(run(cache), first);
    assert_eq!(std::fs::read(&file).unwrap().len(), stored.len(), "the broken file is replaced");
    // Mesa, whose own cache is there too, may complain.
    assert_eq!(run(place.path("ball.gltf").to_str().unwrap()).0, first.0, "no folder");
}
