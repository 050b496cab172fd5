//! What the program does to the files and the terminal of those who run it: outputs never replace inputs,
//! special files and names do no harm, and killed runs leave nothing for good.

use common::{Folder, ball};
use klieg_support::common;
use serde_json::{Value, json};

const SMALL: [&str; 6] = ["--size", "16x16", "--generations", "1", "--population", "4"];

/// The message of a run that must fail as bad input.
fn refused(place: &Folder, arguments: &[&str]) -> String {
    let output = place.klieg(arguments).assert().code(2).get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

/// The ball with its buffer in the file `buffer`, and an image that nothing uses in `image`.
fn in_files(place: &Folder, scene: &str, buffer: &str, image: &str) {
    use base64::Engine;
    let mut root = ball();
    let uri = root["buffers"][0]["uri"].as_str().unwrap();
    let data = base64::engine::general_purpose::STANDARD.decode(uri.split_once(',').unwrap().1);
    std::fs::create_dir_all(place.path(scene).parent().unwrap()).unwrap();
    std::fs::write(place.path(scene).with_file_name(buffer), data.unwrap()).unwrap();
    std::fs::write(place.path(scene).with_file_name(image), "an image").unwrap();
    root["buffers"][0]["uri"] = buffer.into();
    root["images"] = json!([{ "uri": image }]);
    std::fs::write(place.path(scene), root.to_string()).unwrap();
}

/// All files of a folder and what is in them.
fn contents(place: &Folder, folder: &str) -> Vec<(String, Option<Vec<u8>>)> {
    let names = place.list(folder).into_iter();
    names.map(|name| (name.clone(), std::fs::read(place.path(folder).join(name)).ok())).collect()
}

#[test]
fn outputs_never_replace_inputs() {
    let place = Folder::new();
    in_files(&place, "d/scene.gltf", "result.json", "best.png");
    std::fs::write(place.path("d/convergence.csv"), "seed = 1").unwrap();
    in_files(&place, "a/scene.gltf", "depth.npy", "analyze.json");
    std::fs::write(place.path("list.txt"), "b/x/scene.gltf").unwrap();
    in_files(&place, "b/x/scene.gltf", "buffer.bin", "item.json");
    std::fs::rename(place.path("b/x"), place.path("b/b-x-scene")).unwrap();
    std::fs::write(place.path("list.txt"), "b/b-x-scene/scene.gltf").unwrap();
    let before = ["d", "a", "b/b-x-scene"].map(|folder| contents(&place, folder));
    let design = ["design", "ball.gltf", "--out", "d", "--config", "d/convergence.csv"];
    for (command, file) in [
        (&["design", "d/scene.gltf", "--out", "d"][..], "d/best.png"),
        (&design, "d/convergence.csv"),
        (&["analyze", "a/scene.gltf", "--out", "a"], "a/depth.npy"),
        (&["render", "d/scene.gltf", "--out", "d/best.png", "--preset", "headlight"], "d/best.png"),
        (&["render", "d/scene.gltf", "--out", "d/scene.gltf", "--preset", "headlight"], "d/scene"),
        (&["thumbnail", "d/scene.gltf", "d/result.json"], "d/result.json"),
        (&["study", "landscape", "a/scene.gltf", "--out", "a", "--grid", "2x2"], ""),
    ] {
        if file.is_empty() {
            continue;
        }
        let message = refused(&place, command);
        assert!(message.contains(file) && message.contains("overwritten"), "{message}");
    }
    std::fs::write(
        place.path("l.toml"),
        "[[item]]\nscene = \"b/b-x-scene/scene.gltf\"\nname = \"b-x-scene\"\n",
    )
    .unwrap();
    let message = refused(&place, &["batch", "l.toml", "--out", "b"]);
    assert!(message.contains("item.json would be overwritten"), "{message}");
    assert_eq!(["d", "a", "b/b-x-scene"].map(|folder| contents(&place, folder)), before);
}

#[test]
fn a_folder_in_the_place_of_an_output_is_told_before_anything_is_written() {
    let place = Folder::new();
    for (out, file, command) in [
        ("d", "lit.glb", &["design", "ball.gltf", "--out", "d"][..]),
        ("a", "normal.npy", &["analyze", "ball.gltf", "--out", "a"]),
    ] {
        std::fs::create_dir_all(place.path(out).join(file)).unwrap();
        let message = refused(&place, command);
        assert!(message.contains(file) && message.contains("is a folder"), "{message}");
        assert_eq!(place.list(out), [file]);
    }
    let render = ["render", "ball.gltf", "--out", "d/lit.glb", "--preset", "headlight"];
    assert!(refused(&place, &render).contains("names no file"));
}

#[test]
fn names_do_not_command_the_terminal_or_the_report() {
    let evil = "\u{1b}[31m\u{202e}\u{85}gnp";
    let is_evil = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    let place = Folder::new();
    let mut scene = ball();
    scene["nodes"][0]["name"] = evil.into();
    scene["meshes"][0]["name"] = evil.into();
    scene["extensionsUsed"] = json!([evil]);
    scene["cameras"] = json!([{"type": "perspective", "name": evil, "perspective":
        {"yfov": 0.8, "znear": 0.1}}]);
    scene["nodes"].as_array_mut().unwrap().push(json!({"camera": 0, "translation": [0, 0, 4]}));
    scene["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let name = format!("{}.gltf", evil.replace('\u{85}', ""));
    std::fs::write(place.path(&name), scene.to_string()).unwrap();
    for command in [
        &[&["design", &name, "--out", "out"][..], &SMALL].concat()[..],
        &["analyze", &name, "--out", "maps", "--size", "16x16"],
        &["analyze", &name, "--out", "maps", "--size", "16x16", "--json"],
        &["score", &name],
    ] {
        let output = place.klieg(command).output().unwrap();
        for text in [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()) {
            assert!(!text.contains(is_evil), "{command:?}: {text:?}");
        }
    }
    let report = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(!report.contains(is_evil) && report.contains("\\u{202e}"));
    assert_eq!(place.read_json("maps/analyze.json")["objects"][0]["name"], evil);
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    /// The program as a process of its own.
    fn program(place: &Folder, arguments: &[&str]) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("klieg"));
        command.current_dir(place.path("")).args(arguments).args(["--device", "cpu"]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    #[test]
    fn a_full_or_closed_standard_error_is_no_failure() {
        let place = Folder::new();
        let mut scene = ball();
        scene["extensionsUsed"] = json!(["EXAMPLE_unknown"]);
        std::fs::write(place.path("ball.gltf"), scene.to_string()).unwrap();
        let design = [&["design", "ball.gltf", "--out", "out"][..], &SMALL].concat();
        let batch = [&["batch", "ball.gltf", "gone.glb", "--out", "b"][..], &SMALL].concat();
        let klieg = assert_cmd::cargo::cargo_bin("klieg");
        for (redirection, arguments, code) in [
            ("2>/dev/full", &design[..], 0),
            ("2>&-", &design, 0),
            ("2>/dev/full", &["score", "gone.gltf"], 2),
            ("2>/dev/full", &batch, 2),
        ] {
            let words = arguments.join(" ");
            let line = format!("exec {} {words} --device cpu {redirection}", klieg.display());
            let mut shell = Command::new("sh");
            shell.current_dir(place.path("")).args(["-c", &line]).stdout(Stdio::null());
            assert_eq!(shell.status().unwrap().code(), Some(code), "{line}");
        }
    }

    #[test]
    fn pipes_and_endless_files_are_refused_at_once() {
        let place = Folder::new();
        for name in ["pipe", "pipe.txt", "pipe.toml", "pipe.glb"] {
            assert!(Command::new("mkfifo").arg(place.path(name)).status().unwrap().success());
        }
        for arguments in [
            &["score", "ball.gltf", "--preset", "headlight", "--config", "pipe"][..],
            &["score", "ball.gltf", "--preset", "headlight", "--config", "/dev/zero"],
            &["score", "pipe.glb", "--preset", "headlight"],
            &["score", "/dev/zero", "--preset", "headlight"],
            &["render", "ball.gltf", "--out", "x.png", "--rig", "pipe"],
            &["batch", "pipe.txt", "--out", "out"],
            &["batch", "pipe.toml", "--out", "out"],
            &["batch", "pipe.glb", "--out", "out"],
        ] {
            let mut command = place.klieg(arguments);
            let output = command.timeout(Duration::from_secs(20)).assert().code(2);
            let message = String::from_utf8(output.get_output().stderr.clone()).unwrap();
            assert!(message.contains("is not a regular file"), "{arguments:?}: {message}");
        }
    }

    /// Waits until a folder holds a staging folder.
    fn wait_for_staging(place: &Folder, child: &mut std::process::Child) {
        let begin = Instant::now();
        let staging = |place: &Folder| {
            place.path("out").exists()
                && place.list("out").iter().any(|name| name.starts_with(".klieg-"))
        };
        while !staging(place) {
            assert!(
                begin.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none()
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    const LONG: [&str; 10] = [
        "design",
        "ball.gltf",
        "--out",
        "out",
        "--size",
        "700x700",
        "--generations",
        "100000",
        "--shadows",
        "off",
    ];

    #[test]
    fn what_a_killed_run_left_goes_with_the_next_one() {
        let place = Folder::new();
        let mut child = program(&place, &LONG).spawn().unwrap();
        wait_for_staging(&place, &mut child);
        // One that still runs keeps its folder.
        place
            .klieg(&[&["design", "ball.gltf", "--out", "out"][..], &SMALL].concat())
            .assert()
            .success();
        assert_eq!(place.list("out").iter().filter(|n| n.starts_with(".klieg-")).count(), 1);
        child.kill().unwrap();
        child.wait().unwrap();
        place
            .klieg(&[&["design", "ball.gltf", "--out", "out"][..], &SMALL].concat())
            .assert()
            .success();
        assert!(place.list("out").iter().all(|name| !name.starts_with('.')));
    }

    #[test]
    fn a_second_interrupt_leaves_nothing() {
        let place = Folder::new();
        let mut child = program(&place, &LONG).spawn().unwrap();
        wait_for_staging(&place, &mut child);
        // Before it listens, the first one ends it as any program.
        std::thread::sleep(Duration::from_millis(300));
        let mut codes = Vec::new();
        while child.try_wait().unwrap().is_none() {
            codes.push(Command::new("kill").args(["-INT", &child.id().to_string()]).status());
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(child.wait().unwrap().code(), Some(130), "{} interrupts", codes.len());
        assert_eq!(place.list("out"), [""; 0]);
    }
}

#[test]
fn a_record_of_a_batch_is_json() {
    let place = Folder::new();
    let batch = [&["batch", "ball.gltf", "--out", "out"][..], &SMALL].concat();
    place.klieg(&batch).assert().success();
    let record: Value = place.read_json("out/batch.json");
    assert_eq!((&record["done"], &record["device"]["type"]), (&json!(1), &json!("cpu")));
}
