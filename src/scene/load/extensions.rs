//! What extensions say that the model of glTF leaves out, read from the JSON itself.

use super::Parsed;
use super::meshopt;
use gltf::json::extensions::texture::TextureTransform;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Extensions that are read. Unlit materials are drawn lit, with a warning.
pub const SUPPORTED: [&str; 8] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

/// The extensions of a file, by the indices of what they extend.
#[derive(Default)]
pub struct Extensions {
    /// KHR_texture_transform of each material's normal texture.
    pub normal_transforms: HashMap<usize, TextureTransform>,
    /// Compressed buffer views.
    pub compressed: HashMap<usize, meshopt::Compressed>,
    /// Buffers that stand in for compressed views where these cannot be decoded.
    pub fallbacks: BTreeSet<usize>,
    /// Nodes whose mesh is drawn many times: the accessors of EXT_mesh_gpu_instancing by attribute.
    pub instancing: HashMap<usize, BTreeMap<String, usize>>,
}

impl Extensions {
    /// Reads those of a file's root object.
    pub fn of(root: &Value) -> Parsed<Self> {
        let normals = each(root, "materials", "KHR_texture_transform", |m| &m["normalTexture"])?;
        let mut compressed = HashMap::new();
        let mut fallbacks = BTreeSet::new();
        for extension in meshopt::EXTENSIONS {
            compressed.extend(each(root, "bufferViews", extension, |view| view)?);
            let buffers: HashMap<usize, Value> = each(root, "buffers", extension, |buffer| buffer)?;
            let is_fallback = |(index, value): (usize, Value)| {
                value["fallback"].as_bool().unwrap_or(false).then_some(index)
            };
            fallbacks.extend(buffers.into_iter().filter_map(is_fallback));
        }
        let instancing: HashMap<usize, Instancing> =
            each(root, "nodes", "EXT_mesh_gpu_instancing", |node| node)?;
        Ok(Self {
            normal_transforms: normals,
            compressed,
            fallbacks,
            instancing: instancing.into_iter().map(|(node, i)| (node, i.attributes)).collect(),
        })
    }
}

/// EXT_mesh_gpu_instancing.
#[derive(serde::Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

/// The extension `name` of what `part` finds in each element of the list `key`.
fn each<T: DeserializeOwned>(
    root: &Value,
    key: &str,
    name: &str,
    part: impl Fn(&Value) -> &Value,
) -> Parsed<HashMap<usize, T>> {
    let elements = root[key].as_array().into_iter().flatten().enumerate();
    let found = elements
        .filter_map(|(index, element)| Some((index, part(element)["extensions"].get(name)?)));
    let parse = |(index, value): (usize, &Value)| {
        let parsed =
            T::deserialize(value).map_err(|error| format!("{key}[{index}]: {name}: {error}"))?;
        Ok((index, parsed))
    };
    found.map(parse).collect()
}
