//! Processes side by side: in one output folder, and on one device.
#![cfg(unix)]

use common::Folder;
use klieg_support::common;
use std::process::{Child, Command, Stdio};

const SMALL: &str = "design ball.gltf --size 40x32 --generations 3 --population 6 --profile paper";

fn start(place: &Folder, more: &str) -> Child {
    Command::new(assert_cmd::cargo::cargo_bin("klieg"))
        .current_dir(place.path(""))
        .args(SMALL.split(' ').chain(more.split(' ')))
        .env("XDG_CACHE_HOME", place.path("cache"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn finished(processes: impl IntoIterator<Item = Child>) {
    for mut process in processes {
        assert!(process.wait().unwrap().success());
    }
}

/// The files that tell no times.
fn files(place: &Folder, out: &str) -> Vec<Vec<u8>> {
    let names = ["best.png", "headlight.png", "lit.glb", "convergence.csv", "convergence.svg"];
    names.iter().map(|name| std::fs::read(place.path(out).join(name)).unwrap()).collect()
}

#[test]
fn what_three_write_into_one_folder_is_of_one_of_them() {
    let place = Folder::new();
    let alone: Vec<_> = (0..3)
        .map(|seed| {
            let out = format!("alone{seed}");
            finished([start(&place, &format!("--device cpu --out {out} --seed {seed}"))]);
            files(&place, &out)
        })
        .collect();
    for _ in 0..4 {
        let writer = |seed| start(&place, &format!("--device cpu --out out --seed {seed}"));
        finished((0..3).map(writer).collect::<Vec<_>>());
        assert_eq!(place.list("out").len(), 7, "{:?}", place.list("out"));
        let together = files(&place, "out");
        let seed = place.read_json("out/result.json")["seed"].as_u64().unwrap();
        assert!(together == alone[seed as usize], "files of several runs");
    }
}

#[test]
fn two_processes_share_a_device() {
    let place = Folder::new();
    finished([start(&place, "--device vulkan --out alone")]);
    let outs = ["one", "two"];
    finished(outs.map(|out| start(&place, &format!("--device vulkan --out {out}"))));
    for out in outs {
        assert!(files(&place, out) == files(&place, "alone"), "{out}");
    }
}
