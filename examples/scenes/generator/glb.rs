//! Writing a scene as binary glTF 2.0.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::mesh::Mesh;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// A scene under construction. The `add_…` calls answer with the index of what they added.
#[derive(Default)]
pub struct Glb {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    meshes: Vec<Value>,
    cameras: Vec<Value>,
    nodes: Vec<Value>,
}

impl Glb {
    /// A material, as glTF spells it.
    pub fn add_material(&mut self, material: Value) -> usize {
        add(&mut self.materials, material)
    }

    /// A repeating texture of a PNG file's bytes.
    pub fn add_texture(&mut self, name: &str, png: &[u8]) -> usize {
        let view = self.add_view(png, None);
        add(&mut self.images, json!({ "name": name, "bufferView": view, "mimeType": "image/png" }))
    }

    /// A mesh of primitives, each with a material.
    pub fn add_mesh(&mut self, name: &str, primitives: &[(&Mesh, usize)]) -> usize {
        let primitives: Vec<Value> =
            primitives.iter().map(|&(mesh, material)| self.primitive(mesh, material)).collect();
        add(&mut self.meshes, json!({ "name": name, "primitives": primitives }))
    }

    /// A node, as glTF spells it.
    pub fn add_node(&mut self, node: Value) -> usize {
        add(&mut self.nodes, node)
    }

    /// A perspective camera and its node. It looks at `points` from `view`, square, so that they
    /// fill the picture's width or height up to the share `fill`.
    pub fn add_camera(&mut self, name: &str, view: View, points: &[DVec3]) -> usize {
        let camera = add(
            &mut self.cameras,
            json!({ "name": name, "type": "perspective", "perspective": {
                "aspectRatio": 1.0, "yfov": view.yfov, "znear": 0.01, "zfar": 100.0 } }),
        );
        let (translation, rotation) = view.frame(points);
        self.add_node(json!({ "name": name, "camera": camera,
            "translation": translation.to_array(), "rotation": rotation }))
    }

    /// The file's bytes, with `roots` as the scene's nodes.
    pub fn finish(mut self, name: &str, roots: &[usize]) -> Vec<u8> {
        let mut document = Map::new();
        document.insert("asset".into(), json!({ "version": "2.0", "generator": "klieg scenes" }));
        document.insert("scene".into(), json!(0));
        document.insert("scenes".into(), json!([{ "name": name, "nodes": roots }]));
        pad(&mut self.binary, 0);
        document.insert("buffers".into(), json!([{ "byteLength": self.binary.len() }]));
        if !self.images.is_empty() {
            let textures = (0..self.images.len()).map(|i| json!({ "source": i, "sampler": 0 }));
            document.insert("textures".into(), textures.collect());
            // Trilinear, repeating.
            let sampler = json!({ "magFilter": 9729, "minFilter": 9987 });
            document.insert("samplers".into(), json!([sampler]));
        }
        for (key, list) in [
            ("bufferViews", self.views),
            ("accessors", self.accessors),
            ("materials", self.materials),
            ("images", self.images),
            ("meshes", self.meshes),
            ("cameras", self.cameras),
            ("nodes", self.nodes),
        ] {
            if !list.is_empty() {
                document.insert(key.into(), list.into());
            }
        }
        container(Value::Object(document).to_string().into_bytes(), &self.binary)
    }

    fn primitive(&mut self, mesh: &Mesh, material: usize) -> Value {
        let mut attributes = Map::new();
        let floats =
            |lists: &[f32]| -> Vec<u8> { lists.iter().flat_map(|x| x.to_le_bytes()).collect() };
        let positions = floats(mesh.positions.as_flattened());
        let position =
            self.add_accessor(&positions, FLOAT, "VEC3", mesh.positions.len(), ARRAY_BUFFER);
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3).filter_map(|i| mesh.positions.iter().map(|p| p[i]).reduce(pick)).collect()
        };
        self.accessors[position]["min"] = json!(bound(f32::min));
        self.accessors[position]["max"] = json!(bound(f32::max));
        attributes.insert("POSITION".into(), json!(position));
        for (name, kind, component, bytes) in [
            ("NORMAL", "VEC3", FLOAT, floats(mesh.normals.as_flattened())),
            ("TANGENT", "VEC4", FLOAT, floats(mesh.tangents.as_flattened())),
            ("TEXCOORD_0", "VEC2", FLOAT, floats(mesh.uvs.as_flattened())),
            ("COLOR_0", "VEC4", UNSIGNED_BYTE, mesh.colours.as_flattened().to_vec()),
        ] {
            if !bytes.is_empty() {
                let count = mesh.positions.len();
                let accessor = self.add_accessor(&bytes, component, kind, count, ARRAY_BUFFER);
                if component == UNSIGNED_BYTE {
                    self.accessors[accessor]["normalized"] = json!(true);
                }
                attributes.insert(name.into(), json!(accessor));
            }
        }
        // The highest value of an index type is reserved for primitive restart.
        let short = mesh.positions.len() <= usize::from(u16::MAX);
        let (component, bytes) = if short {
            (UNSIGNED_SHORT, mesh.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect())
        } else {
            let bytes: Vec<u8> = mesh.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            (UNSIGNED_INT, bytes)
        };
        let count = mesh.indices.len();
        let indices = self.add_accessor(&bytes, component, "SCALAR", count, ELEMENT_ARRAY_BUFFER);
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    fn add_accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
        target: u32,
    ) -> usize {
        let view = self.add_view(bytes, Some(target));
        add(
            &mut self.accessors,
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }),
        )
    }

    fn add_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        pad(&mut self.binary, 0);
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend(bytes);
        add(&mut self.views, view)
    }
}

/// Where a camera looks from.
#[derive(Clone, Copy)]
pub struct View {
    /// Degrees, from +Z towards +X.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
    /// Radians.
    pub yfov: f64,
    /// Share of the picture's width or height that the subject fills.
    pub fill: f64,
}

impl View {
    /// Position and rotation (x, y, z, w) of the camera that sees all `points` within the share
    /// `fill` of a square picture, as near as can be.
    fn frame(self, points: &[DVec3]) -> (DVec3, [f64; 4]) {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let (sa, ca) = (libm::sin(azimuth), libm::cos(azimuth));
        let (se, ce) = (libm::sin(elevation), libm::cos(elevation));
        let back = DVec3::new(ce * sa, se, ce * ca);
        let right = DVec3::new(ca, 0.0, -sa);
        let up = back.cross(right);
        // A point is within a side's plane when ±x + slope·z <= ±x0 + slope·distance.
        let slope = libm::tan(self.yfov * 0.5) * self.fill;
        let most = |side: DVec3| {
            let side = side + back * slope;
            points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(side.dot(*point)))
        };
        let (r, l, t, b) = (most(right), most(-right), most(up), most(-up));
        let distance = ((r + l) * 0.5).max((t + b) * 0.5) / slope;
        let position = right * ((r - l) * 0.5) + up * ((t - b) * 0.5) + back * distance;

        let (sa, ca) = (libm::sin(azimuth * 0.5), libm::cos(azimuth * 0.5));
        let (se, ce) = (libm::sin(-elevation * 0.5), libm::cos(-elevation * 0.5));
        (position, [ca * se, sa * ce, -sa * se, ca * ce])
    }
}

fn add(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

/// Fills up to the next multiple of four bytes.
fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), with);
}

fn container(mut json: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    pad(&mut json, b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    for word in [2, total as u32, json.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}
