//! `klieg design --checkpoint` and `--resume`: processes that are killed, and checkpoints that do not belong.
#![cfg(unix)]

use common::Folder;
use klieg_support::common;
use serde_json::Value;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Half of the search looks at small pictures, and generations of both halves take longer than a look at the
/// checkpoint.
const DESIGN: &str =
    "design ball.gltf --device cpu --size 256x256 --coarse 96 --generations 40 --config plain.toml";

/// A ball, and settings by which its pictures are drawn soon.
fn place() -> Folder {
    let place = Folder::new();
    std::fs::write(place.path("plain.toml"), "[picture]\nsamples = 1\n").unwrap();
    place
}

fn design(place: &Folder, more: &str) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("klieg"));
    command.current_dir(place.path("")).args(DESIGN.split(' ')).args(more.split(' '));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Populations that a checkpoint has.
fn populations(checkpoint: &Path) -> usize {
    let bytes = std::fs::read(checkpoint).unwrap_or_default();
    bytes.iter().filter(|&&byte| byte == b'\n').count().saturating_sub(1)
}

/// Kills a design by SIGKILL when its checkpoint has so many populations.
fn killed_after(place: &Folder, count: usize, more: &str) {
    let mut process = design(place, more).spawn().unwrap();
    while populations(&place.path("way")) < count {
        assert!(process.try_wait().unwrap().is_none(), "it ended before population {count}");
        std::thread::sleep(Duration::from_micros(500));
    }
    process.kill().unwrap();
    assert_eq!(process.wait().unwrap().signal(), Some(9));
}

fn result(place: &Folder, out: &str) -> Value {
    let mut result = place.read_json(&format!("{out}/result.json"));
    result.as_object_mut().unwrap().remove("timing_ms").unwrap();
    result
}

fn same_files(place: &Folder, one: &str, other: &str) {
    let names = place.list(one);
    assert_eq!(place.list(other), names);
    assert_eq!(result(place, one), result(place, other));
    // The others tell times.
    for name in names.iter().filter(|name| !name.ends_with("json") && !name.ends_with("html")) {
        let read = |out: &str| std::fs::read(place.path(out).join(name)).unwrap();
        assert!(read(one) == read(other), "{name}");
    }
}

#[test]
fn a_design_that_is_killed_at_any_moment_goes_on_to_the_same_bytes() {
    let place = place();
    assert!(design(&place, "--out whole").status().unwrap().success());
    // In the first population, on small pictures, on larger and whole ones, and in the last generation.
    killed_after(&place, 0, "--out out --checkpoint way --resume");
    for count in [3, 11, 26, 36, 40] {
        killed_after(&place, count, "--out out --checkpoint way --resume");
        assert!(place.path("way").exists() && !place.path("out/result.json").exists());
    }
    let finished = design(&place, "--out out --checkpoint way --resume").status().unwrap();
    assert!(finished.success() && !place.path("way").exists());
    same_files(&place, "whole", "out");
}

#[test]
fn checkpoints_of_something_else_are_refused() {
    let place = place();
    killed_after(&place, 2, "--out out --checkpoint way");
    let kept = std::fs::read(place.path("way")).unwrap();
    let refused = |more: &str, words: &str| {
        let line = format!("{DESIGN} {more}");
        let arguments: Vec<_> = line.split(' ').collect();
        let output = place.klieg(&arguments).assert().code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(words), "{said}");
        assert_eq!(std::fs::read(place.path("way")).unwrap(), kept);
    };
    refused("--out out --checkpoint way", "--resume");
    refused("--out out --checkpoint way --resume --seed 3", "settings.seed is 0 there, 3 here");
    refused("--out out --checkpoint ball.gltf --resume", "no checkpoint");
    refused("--out out --checkpoint out/best.png", "checkpoint must have another name");
    refused("--out out --resume", "--checkpoint");
    assert!(!place.path("out/best.png").exists());
    // Another scene of the same name.
    let scene = std::fs::read_to_string(place.path("ball.gltf")).unwrap();
    std::fs::write(place.path("ball.gltf"), scene.replace("0.8", "0.7")).unwrap();
    refused("--out out --checkpoint way --resume", "(scene is ");
}

#[test]
fn what_changes_no_score_may_differ_and_a_folder_does() {
    let place = Folder::new();
    let run = |more: &str| {
        let line = format!("design ball.gltf --size 32x32 --generations 6 --population 6 {more}");
        place.klieg(&line.split(' ').collect::<Vec<_>>()).assert().success();
    };
    run("--out whole --tone-mapping neutral");
    // It ends with its first generation, and is not complete.
    run("--out out --checkpoint . --time-limit 0.000001");
    assert_eq!(populations(&place.path("klieg.checkpoint")), 1);
    run("--out out --checkpoint . --resume --tone-mapping neutral");
    assert!(!place.path("klieg.checkpoint").exists());
    same_files(&place, "whole", "out");
}
