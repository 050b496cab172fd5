//! Devices that fail, by a layer between klieg and the driver (`tests/c/fault_layer.c`), full disks and folders that
//! vanish: a message, no half-written results, and another device where none was named.
#![cfg(target_os = "linux")]

use common::Folder;
use klieg_support::common;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

const SMALL: &str = "--size 48x40 --generations 6 --population 8";

/// The folder of the layer's library and manifest.
fn layer() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fault-layer");
        std::fs::create_dir_all(&place).unwrap();
        let library = place.join("libfault.so");
        let built = Command::new("cc")
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"])
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/c/fault_layer.c"))
            .arg("-o")
            .arg(&library)
            .status();
        assert!(built.unwrap().success());
        let manifest = json!({"file_format_version": "1.2.0", "layer": {
            "name": "VK_LAYER_KLIEG_fault", "type": "GLOBAL", "library_path": library,
            "api_version": "1.3.0", "implementation_version": "1", "description": "faults",
        }});
        std::fs::write(place.join("fault.json"), manifest.to_string()).unwrap();
        place
    })
}

/// `klieg` in this folder, with the fault, on devices that say they are integrated GPUs.
fn faulty(place: &Folder, fault: &str, line: &str) -> assert_cmd::Command {
    let mut command = place.klieg(&line.split(' ').collect::<Vec<_>>());
    command
        .env("VK_LAYER_PATH", layer())
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KLIEG_fault")
        .env("KLIEG_TEST_FAULT", fault)
        .env("KLIEG_TEST_KIND", "1")
        .timeout(Duration::from_secs(120));
    command
}

/// Devices weaker than any that the tests run on: what they lack, and a word of the reason where pipeline `layered` cannot be.
const WEAK: [(&str, Option<&str>); 11] = [
    ("maxComputeSharedMemorySize=16384", None),
    ("maxStorageBufferRange=65536", None),
    (
        "maxStorageBufferRange=65536 maxComputeSharedMemorySize=16384 timestampComputeAndGraphics=0",
        None,
    ),
    ("maxImageArrayLayers=256 maxFramebufferLayers=256", None),
    ("maxFramebufferLayers=1", None),
    ("maxPerStageDescriptorStorageImages=4", None),
    ("timestampComputeAndGraphics=0", None),
    ("fullDrawIndexUint32=0 maxDrawIndexedIndexValue=16777215", None),
    ("maxVertexOutputComponents=96", Some("maxVertexOutputComponents of 104")),
    ("geometryShader=0", None),
    ("graphics=0 shaderOutputLayer=0", Some("shaderOutputLayer")),
];

#[test]
fn weak_devices_give_the_right_score_or_a_reason() {
    let place = Folder::new();
    let score = |weak: &str, how: &str| {
        let line = format!("score ball.gltf --preset three-point --json --size 48x40 {how}");
        let output = faulty(&place, "", &line).env("KLIEG_TEST_WEAK", weak).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let score = serde_json::from_slice::<Value>(&output.stdout).ok();
        (score.and_then(|score| score["score"].as_f64()), output.status.code(), said)
    };
    let (right, ..) = score("", "--device cpu");
    let right = right.unwrap();
    for (weak, lacks) in WEAK {
        for pipeline in ["compute", "layered"] {
            let how = format!("--device vulkan --pipeline {pipeline}");
            let (score, code, said) = score(weak, &how);
            match (pipeline, lacks) {
                ("layered", Some(word)) => {
                    assert_eq!((score, code), (None, Some(1)), "{weak}: {said}");
                    assert!(said.contains("error: ") && said.contains(word), "{weak}: {said}");
                }
                _ => {
                    let score = score.unwrap_or_else(|| panic!("{weak}, {how}: {said}"));
                    assert!((score - right).abs() < 1e-4, "{weak}, {how}: {score} {right}");
                }
            }
        }
    }
}

/// The call, how often it works, its result from then on, and words of the message.
const FAULTS: [(&str, &str); 9] = [
    ("vkCreateDevice 0 -3", "vkCreateDevice"),
    ("vkCreateShaderModule 0 -1", "vkCreateShaderModule"),
    ("vkCreateGraphicsPipelines 0 -3", "vkCreateGraphicsPipelines"),
    ("vkCreateComputePipelines 3 -1", "vkCreateComputePipelines"),
    ("vkAllocateMemory 0 -2", "memory"),
    ("vkCreateImage 2 -2", "vkCreateImage"),
    ("vkCreateBuffer 5 -2", "vkCreateBuffer"),
    ("vkQueueSubmit 0 -4", "vkQueueSubmit"),
    // In the midst of the search.
    ("vkQueueSubmit 8 -4", "vkQueueSubmit"),
];

#[test]
fn a_device_that_fails_is_an_error_and_leaves_nothing() {
    let place = Folder::new();
    for (fault, words) in FAULTS {
        let line = format!("design ball.gltf --out out --device vulkan {SMALL}");
        let output = faulty(&place, fault, &line).assert().code(1).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("error: ") && said.contains(words), "{fault}: {said}");
        assert!(!said.contains("panicked"), "{fault}: {said}");
        if place.path("out").exists() {
            assert!(place.list("out").is_empty(), "{fault}: {:?}", place.list("out"));
        }
    }
}

fn result(place: &Folder, out: &str) -> Value {
    let mut result = place.read_json(&format!("{out}/result.json"));
    result.as_object_mut().unwrap().remove("timing_ms").unwrap();
    result
}

#[test]
fn where_no_device_was_named_the_cpu_takes_its_place() {
    let place = Folder::new();
    let design = |out: &str, device: &str| {
        format!("design ball.gltf --out {out} --checkpoint way --device {device} {SMALL}")
    };
    let sound =
        faulty(&place, "", &design("sound", "auto")).assert().success().get_output().clone();
    assert!(String::from_utf8(sound.stderr).unwrap().contains("(integrated, "));
    faulty(&place, "", &design("cpu", "cpu")).assert().success();
    for (fault, words) in FAULTS {
        let output =
            faulty(&place, fault, &design("out", "auto")).assert().success().get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("warning: ") && said.contains(words), "{fault}: {said}");
        assert!(said.contains("CPU") && said.contains("(cpu, "), "{fault}: {said}");
        assert_eq!(result(&place, "out"), result(&place, "cpu"), "{fault}");
        assert!(!place.path("way").exists());
        std::fs::remove_dir_all(place.path("out")).unwrap();
    }
}

#[test]
fn a_batch_goes_on_where_a_device_is_lost() {
    let place = Folder::new();
    let list = "[[item]]\nscene = \"ball.gltf\"\nname = \"a\"\n[[item]]\nscene = \"ball.gltf\"\nname = \"b\"\n";
    std::fs::write(place.path("list.toml"), list).unwrap();
    let lost = "vkQueueSubmit 8 -4";
    let line = format!("batch list.toml --out out --device auto {SMALL}");
    let output = faulty(&place, lost, &line).assert().success().get_output().clone();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("a: ") && said.contains("again on the CPU"), "{said}");
    assert_eq!(place.read_json("out/batch.json")["done"], 2);
    faulty(&place, "", &format!("design ball.gltf --out cpu --device cpu {SMALL}"))
        .assert()
        .success();
    assert_eq!(result(&place, "out/a"), result(&place, "cpu"));
    let line = format!("batch list.toml --out other --device vulkan {SMALL}");
    faulty(&place, lost, &line).assert().code(1);
    assert_eq!(place.read_json("other/batch.json")["failed"], 2);
}

/// The outcome of a shell's line in this folder, and what was said.
fn shell(place: &Folder, line: &str) -> (Option<i32>, String) {
    let klieg = assert_cmd::cargo::cargo_bin("klieg");
    let line = line.replace("KLIEG", &klieg.display().to_string());
    let output =
        Command::new("sh").current_dir(place.path("")).args(["-c", &line]).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// No file may be longer than a KiB: writing fails in their midst, as it does on a full disk.
#[test]
fn a_full_disk_is_an_error_and_leaves_nothing() {
    let place = Folder::new();
    let commands = [
        format!("design ball.gltf --out out --device cpu {SMALL}"),
        "design ball.gltf --out out --checkpoint out/way --device cpu --size 48x40 --generations 90".to_owned(),
        "analyze ball.gltf --out out --device cpu --size 48x40".to_owned(),
        "study landscape ball.gltf --out out --device cpu --size 48x40 --grid 5x5".to_owned(),
    ];
    for command in commands {
        let line = format!("trap '' XFSZ; ulimit -f 2; exec KLIEG {command}");
        let (code, said) = shell(&place, &line);
        assert_eq!(code, Some(1), "{command}: {said}");
        assert!(said.contains("error: cannot write out"), "{command}: {said}");
        let mut left = place.list("out");
        left.retain(|name| name != "way");
        assert!(left.is_empty(), "{command}: {left:?}");
    }
}

#[test]
fn an_output_folder_that_vanishes_is_an_error() {
    let place = Folder::new();
    let more = "--out out --checkpoint way --device cpu --size 256x256 --coarse 0 --generations 30";
    let mut design = Command::new(assert_cmd::cargo::cargo_bin("klieg"))
        .current_dir(place.path(""))
        .args(["design", "ball.gltf"])
        .args(more.split(' '))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !place.path("way").exists() {
        assert!(design.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(2));
    }
    std::fs::remove_dir_all(place.path("out")).unwrap();
    let output = design.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && said.contains("cannot write out"), "{said}");
    assert!(!place.path("out").exists());
}

#[test]
fn a_reader_that_goes_away_is_no_error_and_a_full_one_is() {
    let place = Folder::new();
    let score = "KLIEG score ball.gltf --preset headlight --device cpu --size 48x40 --json";
    // The reader has gone before anything is written.
    let (_, said) = shell(&place, &format!("({score}; echo $? >&2) | true"));
    assert!(said.ends_with("0\n") && !said.contains("error"), "{said}");
    let (code, said) = shell(&place, &format!("{score} > /dev/full"));
    assert!(code == Some(1) && said.contains("standard output"), "{said}");
}
