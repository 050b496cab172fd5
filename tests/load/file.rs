//! A small writer of glTF files, right or wrong ones.

use klieg::scene::Scene;
use klieg::scene::load::load;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A glTF file in the making, whose one buffer is `bin`.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Little-endian bytes.
pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// The unit square in z = 0 as four vertices: (0, 0), (1, 0), (0, 1), (1, 1).
pub const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
/// Its normals.
pub const FRONT: [f32; 12] = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];
/// Its texture coordinates, upright: v points down.
pub const UVS: [f32; 8] = [0., 1., 1., 1., 0., 0., 1., 0.];

impl File {
    pub fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}}), bin: Vec::new() }
    }

    /// A node with the square as two indexed triangles, with normals.
    pub fn square() -> Self {
        let mut file = Self::new();
        let position = file.accessor(&floats(&SQUARE), "VEC3", F32, 4);
        let normal = file.accessor(&floats(&FRONT), "VEC3", F32, 4);
        let indices = file.accessor(&shorts(&[0, 1, 2, 2, 1, 3]), "SCALAR", U16, 6);
        file.mesh(json!({
            "attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices
        }));
        file
    }

    /// The square with texture coordinates and a material.
    pub fn textured(material: Value) -> Self {
        let mut file = Self::square();
        let uv = file.accessor(&floats(&UVS), "VEC2", F32, 4);
        file.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
        file.primitive()["material"] = json!(0);
        file.json["materials"] = json!([material]);
        file
    }

    /// The first primitive.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Appends an object to a top-level list; its index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Appends bytes as a buffer view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        self.push("bufferViews", view)
    }

    pub fn accessor(&mut self, bytes: &[u8], kind: &str, component: u32, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "type": kind, "componentType": component, "count": count
        });
        self.push("accessors", accessor)
    }

    /// Appends a mesh of one primitive and a node that shows it.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({"name": "shape", "primitives": [primitive]}));
        self.push("nodes", json!({"mesh": mesh}))
    }

    fn finished(&self, uri: Option<Value>) -> Value {
        let mut json = self.json.clone();
        if json["buffers"].is_null() && !self.bin.is_empty() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = uri;
            }
        }
        json
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec(&self.finished(None)).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let chunk = |kind: &[u8; 4], data: &[u8]| {
            [&(data.len() as u32).to_le_bytes(), &kind[..], data].concat()
        };
        let body = [chunk(b"JSON", &json), chunk(b"BIN\0", &bin)].concat();
        let length = (12 + body.len() as u32).to_le_bytes();
        [b"glTF", &2u32.to_le_bytes(), &length, &body[..]].concat()
    }

    /// JSON whose buffer is at `uri`.
    pub fn gltf(&self, uri: &str) -> Vec<u8> {
        serde_json::to_vec(&self.finished(Some(json!(uri)))).unwrap()
    }

    /// Loads it as GLB.
    pub fn load(&self) -> klieg::Result<Scene> {
        Folder::new().load("scene.glb", &self.glb())
    }

    /// Loads what must be right.
    pub fn scene(&self) -> Scene {
        self.load().unwrap_or_else(|error| panic!("{error}\n{}", self.json))
    }

    /// The fault of what must be wrong, without the file's name.
    pub fn fault(&self) -> String {
        fault(self.load(), "scene.glb")
    }
}

/// The fault of an `Error::Input` for the file named `name`.
pub fn fault(result: klieg::Result<Scene>, name: &str) -> String {
    match result {
        Err(klieg::Error::Input { path, fault }) => {
            assert_eq!(path.file_name().and_then(|n| n.to_str()), Some(name), "{fault}");
            fault
        }
        Err(error) => panic!("another kind of error: {error}"),
        Ok(_) => panic!("it was loaded"),
    }
}

/// A folder of its own for files.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    pub fn load(&self, name: &str, bytes: &[u8]) -> klieg::Result<Scene> {
        self.write(name, bytes);
        load(&self.path(name))
    }
}

/// Corners of all triangles, in the world.
pub fn corners(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    (1..=scene.polygons())
        .filter_map(|code| scene.polygon(code))
        .map(|(instance, triangle)| scene.corners(instance, triangle).map(|p| p.to_array()))
        .collect()
}

/// A PNG of RGBA texels.
pub fn png(width: u32, height: u32, texels: &[u8]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(width, height, texels.to_vec()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}
