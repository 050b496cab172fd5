//! PLY, STL and OBJ: files of triangles, read as the glTF that they amount to.

mod color;
mod mtl;
mod obj;
mod ply;
mod stl;

use super::files::{FilePart, MAX_BYTES, reason};
use super::guard::guarded;
use super::{FileAccess, Parsed};
use glam::{DQuat, DVec3};
use mtl::Libraries;
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;
use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::{Path, PathBuf};

/// Bytes of the reader's window: lines of text are short, and so are the elements of binary files.
const WINDOW: usize = 1 << 16;

/// The axis that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// As in glTF.
    Y,
    /// As in most programs that construct.
    Z,
}

/// What a file of triangles does not say of itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Orientation {
    /// Metres of a unit; 0.001 for STL and 1 for other formats where `None`.
    pub units: Option<f64>,
    /// The axis that points upwards; Z for STL and Y for other formats where `None`.
    pub up: Option<Up>,
}

/// The formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ply,
    Stl,
    Obj,
}

/// Triangles with what belongs to their vertices.
#[derive(Default)]
struct Part {
    name: String,
    positions: Vec<[f32; 3]>,
    /// One for each vertex, or none.
    normals: Vec<[f32; 3]>,
    /// Linear colours of each vertex, 65535 = 1, or none.
    colors: Vec<[u16; 4]>,
    /// From the upper left, one for each vertex, or none.
    texture_coordinates: Vec<[f32; 2]>,
    /// Three for each triangle; where there are none, every three vertices are a triangle.
    indices: Vec<u32>,
    /// Its material, among the file's own.
    material: Option<usize>,
}

/// A glTF file that is in memory.
pub struct Model {
    /// The name of the format that it was read from.
    pub format: &'static str,
    /// The root object.
    pub root: Value,
    /// The binary chunk.
    pub bin: Vec<u8>,
    /// What was left out.
    pub warnings: Vec<String>,
    /// Further files that were read.
    pub files: Vec<PathBuf>,
}

impl Model {
    /// The root object as text.
    pub fn json(&self) -> Vec<u8> {
        self.root.to_string().into_bytes()
    }
}

/// Reads a file of triangles, with the materials that it names among the files of `access`; `None` where it is in none
/// of these formats.
pub fn read(path: &Path, orientation: &Orientation, access: FileAccess) -> Parsed<Option<Model>> {
    let part = FilePart::open(path, MAX_BYTES)?;
    let Some(format) = format(path)? else { return Ok(None) };
    let reader = || File::open(path).map(|file| BufReader::with_capacity(WINDOW, file));
    let mut reader = reader().map_err(reason)?;
    let length = part.len();
    let mut libraries = Libraries::new(path, access);
    let (parts, materials) = guarded(|| match format {
        Format::Ply => ply::read(&mut reader).map(|part| (vec![part], Vec::new())),
        Format::Stl => stl::read(&mut reader, length).map(|part| (vec![part], Vec::new())),
        Format::Obj => obj::read(&mut reader, &mut libraries),
    })?;
    let mut root = empty(placed(format, orientation));
    for material in &materials {
        let material = libraries.convert(&mut root, material);
        push(&mut root, "materials", material);
    }
    let mut model = model(parts, format, root)?;
    (model.files, model.warnings) = (libraries.files().to_vec(), libraries.warnings);
    Ok(Some(model))
}

/// By its first bytes, or else by its name: STL and OBJ have no mark of their own.
fn format(path: &Path) -> Parsed<Option<Format>> {
    let mut head = [0; 4];
    let mut file = File::open(path).map_err(reason)?;
    let length = file.read(&mut head).map_err(reason)?;
    if head.starts_with(b"ply") {
        return Ok(Some(Format::Ply));
    }
    let name = path.extension().and_then(|name| name.to_str()).map(str::to_ascii_lowercase);
    Ok(match name.as_deref() {
        _ if &head == b"glTF" || length == 0 => None,
        Some("stl") => Some(Format::Stl),
        Some("obj") => Some(Format::Obj),
        _ => None,
    })
}

/// Materials of parts that have none: without and with colours of their vertices.
const OWN_MATERIALS: usize = 2;

/// A root object with one node and no meshes.
fn empty(node: Value) -> Value {
    json!({
        "asset": {"version": "2.0", "generator": "klieg"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [node],
        "buffers": [], "bufferViews": [], "accessors": [], "meshes": [], "images": [], "textures": [],
        "materials": [grey("grey", 0.5), grey("coloured", 1.0)],
    })
}

fn model(parts: Vec<Part>, format: Format, mut root: Value) -> Parsed<Model> {
    let mut bin = Vec::new();
    let mut children = Vec::new();
    for part in parts.into_iter().filter(|part| !part.positions.is_empty()) {
        let mut attributes = json!({
            "POSITION": accessor(&mut root, &mut bin, &part.positions, "VEC3", 5126),
        });
        let [low, high] = bounds(&part.positions)?;
        let position = attributes["POSITION"].as_u64().unwrap_or_default() as usize;
        root["accessors"][position]["min"] = json!(low);
        root["accessors"][position]["max"] = json!(high);
        if !part.normals.is_empty() {
            attributes["NORMAL"] = accessor(&mut root, &mut bin, &part.normals, "VEC3", 5126);
        }
        let colored = !part.colors.is_empty();
        if colored {
            let color = accessor(&mut root, &mut bin, &part.colors, "VEC4", 5123);
            root["accessors"][color.as_u64().unwrap_or_default() as usize]["normalized"] =
                json!(true);
            attributes["COLOR_0"] = color;
        }
        if !part.texture_coordinates.is_empty() {
            attributes["TEXCOORD_0"] =
                accessor(&mut root, &mut bin, &part.texture_coordinates, "VEC2", 5126);
        }
        let own = |material| OWN_MATERIALS + material;
        let material = part.material.map_or(usize::from(colored), own);
        let mut primitive = json!({"attributes": attributes, "material": material});
        if !part.indices.is_empty() {
            primitive["indices"] = accessor(&mut root, &mut bin, &part.indices, "SCALAR", 5125);
        }
        children.push(push(&mut root, "nodes", json!({"name": part.name, "mesh": children.len()})));
        push(&mut root, "meshes", json!({"name": part.name, "primitives": [primitive]}));
    }
    if children.is_empty() {
        return Err("has no triangles".into());
    }
    root["nodes"][0]["children"] = json!(children);
    root["buffers"] = json!([{"byteLength": bin.len()}]);
    // No list of a glTF file may be empty.
    for key in ["images", "textures"] {
        if root[key].as_array().is_some_and(Vec::is_empty) {
            root.as_object_mut().and_then(|root| root.remove(key));
        }
    }
    let format = match format {
        Format::Ply => "PLY",
        Format::Stl => "STL",
        Format::Obj => "OBJ",
    };
    Ok(Model { format, root, bin, warnings: Vec::new(), files: Vec::new() })
}

/// The node that turns and scales a file's space into glTF's.
fn placed(format: Format, orientation: &Orientation) -> Value {
    let (units, up) = match format {
        Format::Stl => (0.001, Up::Z),
        Format::Ply | Format::Obj => (1.0, Up::Y),
    };
    let scale = DVec3::splat(orientation.units.unwrap_or(units));
    let mut node = json!({"name": "model"});
    if scale != DVec3::ONE {
        node["scale"] = json!(scale.to_array());
    }
    if orientation.up.unwrap_or(up) == Up::Z {
        node["rotation"] = json!(DQuat::from_rotation_x(-FRAC_PI_2).to_array());
    }
    node
}

/// A dull dielectric, seen from both sides: these formats are often wound either way.
fn grey(name: &str, base: f32) -> Value {
    json!({
        "name": name, "doubleSided": true,
        "pbrMetallicRoughness":
            {"baseColorFactor": [base, base, base, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6},
    })
}

/// Appends elements of 4 bytes or multiples of it as an accessor; its index.
fn accessor<T: bytemuck::NoUninit>(
    root: &mut Value,
    bin: &mut Vec<u8>,
    elements: &[T],
    kind: &str,
    component: u32,
) -> Value {
    let bytes: &[u8] = bytemuck::cast_slice(elements);
    let view = json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()});
    bin.extend_from_slice(bytes);
    let view = push(root, "bufferViews", view);
    let accessor = json!({
        "bufferView": view, "count": elements.len(), "type": kind, "componentType": component,
    });
    push(root, "accessors", accessor)
}

/// Appends to a list of the root object; the element's index.
fn push(root: &mut Value, key: &str, value: Value) -> Value {
    let list = root[key].as_array_mut();
    let index = list.as_ref().map_or(0, |list| list.len());
    if let Some(list) = list {
        list.push(value);
    }
    index.into()
}

fn bounds(positions: &[[f32; 3]]) -> Parsed<[[f32; 3]; 2]> {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for (at, position) in positions.iter().enumerate() {
        for (axis, &value) in position.iter().enumerate() {
            if !value.is_finite() {
                return Err(format!("position of vertex {at} is not finite"));
            }
            bounds[0][axis] = bounds[0][axis].min(value);
            bounds[1][axis] = bounds[1][axis].max(value);
        }
    }
    Ok(bounds)
}
