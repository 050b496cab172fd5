//! Exit codes and messages: 2 with the fault named for what the user gave, 1 for the machine.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use common::{Folder, ball, klieg};
use klieg_support::common;

/// Every command that loads a scene refuses one that reads outside its folder, unless it is told to.
#[test]
fn files_outside_the_scene_s_folder_are_read_only_where_allowed() {
    let place = Folder::new();
    let mut scene = ball();
    let uri = scene["buffers"][0]["uri"].as_str().unwrap();
    let data = STANDARD.decode(uri.split_once(',').unwrap().1).unwrap();
    std::fs::write(place.path("outside.bin"), data).unwrap();
    scene["buffers"][0]["uri"] = "../outside.bin".into();
    std::fs::create_dir(place.path("scene")).unwrap();
    std::fs::write(place.path("scene/a.gltf"), scene.to_string()).unwrap();
    let small = ["--size", "16x12"];
    let commands: [&[&str]; 5] = [
        &["analyze", "scene/a.gltf", "--out", "maps"],
        &["score", "scene/a.gltf", "--preset", "headlight"],
        &["design", "scene/a.gltf", "--out", "out", "--generations", "1"],
        &["study", "landscape", "scene/a.gltf", "--out", "study", "--grid", "2x2"],
        &["bench", "scene/a.gltf", "--runs", "1", "--population", "2", "--lights", "1"],
    ];
    for command in commands {
        let command = [command, &small].concat();
        let message = fails(&place, &command, 2);
        let words = ["a.gltf", "'../outside.bin'", "--allow-outside"];
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        place.klieg(&[&command[..], &["--allow-outside"]].concat()).assert().success();
    }
    let batch = ["batch", "scene", "--out", "lit", "--generations", "1", "--size", "16x12"];
    let refused = place.klieg(&batch).assert().code(2).get_output().clone();
    assert!(String::from_utf8(refused.stderr).unwrap().contains("'../outside.bin'"));
    std::fs::write(place.path("allow.toml"), "allow_outside = true").unwrap();
    place.klieg(&[&batch[..], &["--config", "allow.toml"]].concat()).assert().success();
    // What they wrote needs no permission any more.
    for lit in ["out/lit.glb", "lit/a/lit.glb"] {
        place.klieg(&["score", lit]).assert().success();
    }
}

/// Runs a command that must fail and gives its message.
fn fails(place: &Folder, arguments: &[&str], code: i32) -> String {
    let output = place.klieg(arguments).assert().code(code).get_output().clone();
    assert!(output.stdout.is_empty(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn wrong_scenes_are_named_and_nothing_is_written() {
    let place = Folder::new();
    std::fs::create_dir(place.path("folder.glb")).unwrap();
    std::fs::write(place.path("text.glb"), "not a scene").unwrap();
    let mut empty = ball();
    empty["scenes"][0]["nodes"] = serde_json::json!([]);
    std::fs::write(place.path("empty.gltf"), empty.to_string()).unwrap();
    let whole = ball().to_string();
    std::fs::write(place.path("cut.gltf"), &whole[..whole.len() / 2]).unwrap();
    let change = |file: &str, pointer: &str, value: serde_json::Value| {
        let mut scene = ball();
        *scene.pointer_mut(pointer).unwrap() = value;
        std::fs::write(place.path(file), scene.to_string()).unwrap();
    };
    change("buffer.gltf", "/buffers/0/uri", "gone.bin".into());
    change("accessor.gltf", "/meshes/0/primitives/0/indices", 7.into());
    change("long.gltf", "/accessors/0/count", 1_000_000_000.into());
    let points = serde_json::json!([{"attributes": {"POSITION": 0}, "mode": 0}]);
    change("points.gltf", "/meshes/0/primitives", points);
    std::fs::write(place.path("nan.bin"), f32::NAN.to_le_bytes().repeat(25_000)).unwrap();
    let mut nan = ball();
    nan["buffers"][0]["uri"] = "nan.bin".into();
    nan["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    std::fs::write(place.path("nan.gltf"), nan.to_string()).unwrap();
    for (file, fault) in [
        ("absent.glb", "not found"),
        ("folder.glb", "is a directory"),
        ("text.glb", ""),
        ("empty.gltf", "no triangles"),
        ("cut.gltf", "JSON"),
        ("buffer.gltf", "gone.bin"),
        ("accessor.gltf", "indices"),
        ("long.gltf", "accessor"),
        ("points.gltf", "triangles"),
        ("nan.gltf", "finite"),
    ] {
        for command in ["design", "analyze"] {
            let message = fails(&place, &[command, file, "--out", "out"], 2);
            assert!(message.starts_with("klieg: error: "), "{message}");
            assert!(message.contains(file) && message.contains(fault), "{message}");
            assert!(!place.path("out").exists(), "{file}");
        }
        assert!(fails(&place, &["score", file, "--preset", "headlight"], 2).contains(file));
    }
}

#[test]
fn wrong_options_are_refused() {
    let place = Folder::new();
    let design = ["design", "ball.gltf", "--out", "out"];
    for (option, value, part) in [
        ("--size", "0x5", "--size"),
        ("--size", "16385x5", "--size"),
        ("--lights", "0", "--lights"),
        ("--lights", "17", "--lights"),
        ("--lights", "back", "--lights"),
        ("--size", "16384x16384", "16384x16384"),
        ("--population", "1", "population"),
        ("--population", "1000000000", "population"),
        ("--generations", "0", "generations"),
        ("--generations", "-1", "'-1'"),
        ("--weights", "1,2", "--weights"),
        ("--weights", "releif=1", "no term 'releif': the terms are edge, mean"),
        ("--weights", "target=1", "target picture"),
        ("--weights", "nan,1,1,1,1", "--weights"),
        ("--weights", "-1,1,1,1,1", "--weights"),
        ("--weights", "0,0,0,0,0", "weights"),
        ("--weights", "3e38,3e38,0,0,0", "weights"),
        ("--fov", "180", "fov"),
        ("--fov", "nan", "fov"),
        ("--azimuth", "inf", "azimuth"),
        ("--elevation", "91", "elevation"),
        ("--kind", "lamp", "--kind"),
        ("--color", "red", "--color"),
        ("--color", "scene=5600K", "scene"),
        ("--color", "900K", "1000 to 40000 K"),
        ("--intensities", "3", "--intensities"),
        ("--camera", "nobody", "nobody"),
        ("--device", "no such device", "no such device"),
        ("--config", "absent.toml", "absent.toml"),
    ] {
        let mut arguments = design.to_vec();
        arguments.extend([option, value]);
        let message = fails(&place, &arguments, 2);
        assert!(message.contains(part), "{option} {value}: {message}");
    }
    assert!(!place.path("out").exists());
    fails(&place, &["design", "ball.gltf"], 2);
    fails(&place, &["score", "ball.gltf", "--light", "0,0,2,1"], 2);
    fails(&place, &["score", "ball.gltf", "--light", "0,0,0,1,1"], 2);
    fails(&place, &["score", "ball.gltf", "--light", "0,0,2,1,1", "--preset", "headlight"], 2);
    fails(&place, &["score", "ball.gltf", "--camera", "0", "--azimuth", "5"], 2);
    let seventeen: Vec<_> = std::iter::repeat_n(["--light", "0,0,2,1,1"], 17).flatten().collect();
    fails(&place, &[&["score", "ball.gltf"][..], &seventeen].concat(), 2);
    assert!(fails(&place, &["score", "ball.gltf"], 2).contains("ball.gltf"));
    fails(&place, &["bench", "ball.gltf", "--lights", "0"], 2);
    fails(&place, &["bench", "ball.gltf", "--population", "0"], 2);
    fails(&place, &["bench", "ball.gltf", "--population", "1000000000"], 2);
    fails(&place, &["bench", "ball.gltf", "--runs", "0"], 2);
}

#[test]
fn a_wrong_configuration_is_named_with_line_and_key() {
    let place = Folder::new();
    std::fs::write(place.path("k.toml"), "[search]\n\nelitsm = 0.5\n").unwrap();
    let message = fails(&place, &["score", "ball.gltf", "--config", "k.toml"], 2);
    for part in ["k.toml", "line 3", "elitsm"] {
        assert!(message.contains(part), "{message}");
    }
    std::fs::write(place.path("k.toml"), "[objective.weights]\nreleif = 0.5\n").unwrap();
    let message = fails(&place, &["score", "ball.gltf", "--config", "k.toml"], 2);
    for part in ["k.toml", "line 1", "no term 'releif'", "edge, mean", "relief"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn an_output_folder_that_cannot_be_made_is_the_machines_fault() {
    let place = Folder::new();
    std::fs::write(place.path("file"), "").unwrap();
    for command in ["design", "analyze"] {
        let into = |out| fails(&place, &[command, "ball.gltf", "--size", "16x16", "--out", out], 1);
        let message = into("file");
        assert!(message.contains("cannot write file: it is a file"), "{message}");
        let message = into("file/below");
        assert!(message.contains("cannot write file/below"), "{message}");
        assert_eq!(message.matches("os error").count(), 1, "{message}");
    }
    assert_eq!(std::fs::read(place.path("file")).unwrap(), b"");
}

#[test]
fn no_arguments_and_help() {
    klieg(&[]).assert().code(2);
    let output = klieg(&["--help"]).assert().success().get_output().clone();
    let help = String::from_utf8(output.stdout).unwrap();
    for command in ["design", "batch", "score", "analyze", "devices", "terms", "bench"] {
        assert!(help.contains(command), "{help}");
        klieg(&[command, "--help"]).assert().success();
    }
    klieg(&["--version"])
        .assert()
        .success()
        .stdout(format!("klieg {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn unknown_optimizers_are_answered_with_all_names() {
    let place = Folder::new();
    std::fs::write(place.path("odd.toml"), "seed = 1\noptimizer = \"annealing\"\n").unwrap();
    let names = ["ga", "shade", "cma-es", "greedy", "restarts", "random"];
    for arguments in [
        ["design", "ball.gltf", "--out", "out", "--optimizer", "annealing"],
        ["batch", "ball.gltf", "--out", "out", "--optimizer", "annealing"],
        ["design", "ball.gltf", "--out", "out", "--config", "odd.toml"],
    ] {
        let message = fails(&place, &arguments, 2);
        assert!(message.contains("annealing"), "{message}");
        assert!(names.iter().all(|name| message.contains(name)), "{message}");
        assert!(!message.contains("odd.toml") || message.contains("line 2"), "{message}");
    }
    let study = ["study", "convergence", "ball.gltf", "--out", "out", "--optimizers", "ga,odd"];
    assert!(fails(&place, &study, 2).contains("restarts"));
    assert!(!place.path("out").exists());
}
