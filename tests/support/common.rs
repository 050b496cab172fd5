//! A small scene and the program, for the tests of the command line.

use assert_cmd::Command;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A folder that goes when the test ends, with a scene in it.
pub struct Folder {
    folder: tempfile::TempDir,
}

impl Folder {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("ball.gltf"), ball().to_string()).unwrap();
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `klieg` in this folder, on the native evaluator unless `arguments` name a device.
    pub fn klieg(&self, arguments: &[&str]) -> Command {
        let mut command = klieg(arguments);
        let without_device =
            ["devices", "terms", "render", "thumbnail", "inspect", "completions", "man"];
        if !without_device.contains(&arguments[0]) && !arguments.contains(&"--device") {
            command.args(["--device", "cpu"]);
        }
        command.current_dir(self.folder.path());
        command
    }

    /// A short design into the folder `out`.
    pub fn design(&self, out: &str, more: &[&str]) -> Command {
        let mut command = self.klieg(&["design", "ball.gltf", "--out", out]);
        command.args(["--size", "48x40", "--generations", "4", "--population", "8"]).args(more);
        command
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// Names of all entries of a folder, hidden ones included.
    pub fn list(&self, name: &str) -> Vec<String> {
        list(&self.path(name))
    }
}

pub fn list(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub fn klieg(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("klieg").unwrap();
    command.args(arguments).env("XDG_CACHE_HOME", crate::temporary());
    command
}

/// A ball in front of a smaller one, embedded, without cameras and lights.
pub fn ball() -> Value {
    let (positions, indices) = sphere(16, 10);
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let index_start = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "large", "mesh": 0},
            {"name": "small", "mesh": 0, "translation": [0.9, 0.5, -0.9], "scale": [0.5, 0.5, 0.5]},
        ],
        "meshes": [{
            "name": "ball",
            "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "material": 0}],
        }],
        "materials": [{"pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.5, 0.3, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5,
        }}],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3",
                "min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0],
            },
            {"bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": index_start},
            {"buffer": 0, "byteOffset": index_start, "byteLength": bytes.len() - index_start},
        ],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{data}"),
        }],
    })
}

/// Unit sphere of `slices` × `stacks` quads.
fn sphere(slices: u32, stacks: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    use std::f32::consts::{PI, TAU};
    let mut positions = Vec::new();
    for stack in 0..=stacks {
        for slice in 0..slices {
            let (polar, turn) =
                (PI * stack as f32 / stacks as f32, TAU * slice as f32 / slices as f32);
            let (ring, height) = polar.sin_cos();
            positions.push([ring * turn.sin(), height, ring * turn.cos()]);
        }
    }
    let mut indices = Vec::new();
    for stack in 0..stacks {
        for slice in 0..slices {
            let at = |stack: u32, slice: u32| stack * slices + slice % slices;
            let [a, b] = [at(stack, slice), at(stack, slice + 1)];
            let [c, d] = [at(stack + 1, slice), at(stack + 1, slice + 1)];
            if stack > 0 {
                indices.extend([a, c, b]);
            }
            if stack + 1 < stacks {
                indices.extend([b, c, d]);
            }
        }
    }
    (positions, indices)
}
