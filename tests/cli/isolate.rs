//! `klieg batch` where an item breaks its process: without and with a process for each.
#![cfg(target_os = "linux")]

use common::{Folder, ball};
use klieg_support::common;
use serde_json::{Value, json};
use std::process::Command;

const SMALL: &str = "--size 32x32 --generations 2 --population 6 --device cpu --shadows off";

/// A scene of flat triangles whose memory is many times its file: about 600 MB.
fn hungry(place: &Folder, name: &str) {
    let count = 3 << 20;
    let mut bytes: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    bytes.extend([0, 1, 2].repeat(count / 3));
    std::fs::write(place.path("hungry.bin"), &bytes).unwrap();
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    let scene = json!({
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": vec![primitive; 3]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": count, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": bytes.len() - 36}],
        "buffers": [{"byteLength": bytes.len(), "uri": "hungry.bin"}],
    });
    std::fs::write(place.path(name), scene.to_string()).unwrap();
}

/// Runs a batch of a ball, a hungry scene and another ball in `kibibytes` of address space.
fn run(place: &Folder, kibibytes: u32, more: &str) -> (Option<i32>, Value, String) {
    let klieg = assert_cmd::cargo::cargo_bin("klieg");
    let line = format!(
        "ulimit -v {kibibytes}; RAYON_NUM_THREADS=2 MALLOC_ARENA_MAX=2 exec {} batch a.gltf hungry.gltf z.gltf --out out {SMALL} {more}",
        klieg.display()
    );
    let output =
        Command::new("sh").current_dir(place.path("")).args(["-c", &line]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), place.read_json("out/batch.json"), said)
}

#[test]
fn an_item_that_breaks_its_process_is_one_failure() {
    let place = Folder::new();
    let state =
        |record: &Value, at: usize| record["items"][at]["state"].as_str().map(str::to_owned);
    for name in ["a.gltf", "z.gltf"] {
        std::fs::write(place.path(name), ball().to_string()).unwrap();
    }
    hungry(&place, "hungry.gltf");
    let (code, record, said) = run(&place, 250_000, "");
    assert_eq!(
        (code, &record["done"], &record["failed"]),
        (Some(2), &json!(2), &json!(1)),
        "{said}"
    );
    assert_eq!(state(&record, 1).as_deref(), Some("failed"));
    assert!(
        said.contains("warning: hungry: ") && said.contains("more memory than there is"),
        "{said}"
    );
    let shared = std::fs::read(place.path("out/a/best.png")).unwrap();
    // The same bytes in processes of their own, and nothing new where all is done.
    let (_, record, _) = run(&place, 250_000, "--isolate");
    assert_eq!((&record["skipped"], state(&record, 0).as_deref()), (&json!(2), Some("skipped")));
    let (code, record, said) = run(&place, 250_000, "--isolate --force");
    assert_eq!(
        (code, &record["done"], &record["failed"]),
        (Some(2), &json!(2), &json!(1)),
        "{said}"
    );
    assert_eq!(said.matches("device: ").count(), 1, "{said}");
    assert_eq!(std::fs::read(place.path("out/a/best.png")).unwrap(), shared);
}

/// What the system ends for want of memory is ended by this signal.
#[test]
fn a_killed_process_is_the_failure_of_its_item() {
    let place = Folder::new();
    for name in ["a.gltf", "z.gltf"] {
        std::fs::write(place.path(name), ball().to_string()).unwrap();
    }
    let list = "[[item]]\nscene = \"a.gltf\"\nname = \"slow\"\nsize = \"2000x2000\"\n\
                [[item]]\nscene = \"z.gltf\"\nname = \"quick\"\nsize = \"8x8\"\n";
    std::fs::write(place.path("list.toml"), list).unwrap();
    let mut batch = Command::new(assert_cmd::cargo::cargo_bin("klieg"))
        .current_dir(place.path(""))
        .args(["batch", "list.toml", "--out", "out", "--device", "cpu", "--isolate"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // The processes that a thread has started, proc_pid_task(5).
    let children = format!("/proc/{0}/task/{0}/children", batch.id());
    let child = loop {
        let text = std::fs::read_to_string(&children).unwrap_or_default();
        if let Some(child) = text.split_whitespace().next() {
            break child.to_owned();
        }
        assert!(batch.try_wait().unwrap().is_none());
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    assert!(Command::new("kill").args(["-KILL", &child]).status().unwrap().success());
    assert_eq!(batch.wait().unwrap().code(), Some(1));
    let record = place.read_json("out/batch.json");
    assert_eq!((&record["done"], &record["failed"]), (&json!(1), &json!(1)));
    let reason = record["items"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("SIGKILL") && reason.contains("not enough memory"), "{reason}");
    assert_eq!(record["items"][1]["state"], "done");
}

#[test]
fn a_design_that_takes_too_long_is_given_up() {
    let place = Folder::new();
    std::fs::write(place.path("a.gltf"), ball().to_string()).unwrap();
    let list = "[[item]]\nscene = \"a.gltf\"\nname = \"slow\"\nsize = \"4000x4000\"\n\
                [[item]]\nscene = \"a.gltf\"\nname = \"quick\"\nsize = \"8x8\"\n";
    std::fs::write(place.path("list.toml"), list).unwrap();
    let batch = ["batch", "list.toml", "--out", "out", "--device", "cpu", "--timeout"];
    place.klieg(&[&batch[..], &["5"]].concat()).assert().code(1);
    let record = place.read_json("out/batch.json");
    assert_eq!((&record["done"], &record["failed"]), (&json!(1), &json!(1)));
    assert_eq!(record["items"][0]["reason"], "it took longer than 5 s (--timeout)");
    assert_eq!(place.list("out"), ["batch.csv", "batch.json", "index.html", "quick"]);
    for faulty in ["0", "-1", "soon"] {
        place.klieg(&[&batch[..], &[faulty]].concat()).assert().code(2);
    }
}
