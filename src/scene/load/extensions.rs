//! What extensions say that the model of glTF leaves out, read from the JSON itself.

use super::Parsed;
use super::appearance::Appearance;
use super::{draco, meshopt};
use gltf::json::extensions::texture::TextureTransform;
use serde::Deserialize as _;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Extensions that are read.
pub const SUPPORTED: [&str; 17] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions that give a texture another image, in the order in which they are looked for where a texture has
/// none of glTF's own.
const IMAGES: [&str; 2] = ["EXT_texture_webp", "KHR_texture_basisu"];

/// The extensions of a file, by the indices of what they extend.
pub struct Extensions {
    /// Names of those that the file cannot be read without.
    pub required: HashSet<String>,
    /// KHR_texture_transform of each material's normal texture.
    pub normal_transforms: HashMap<usize, TextureTransform>,
    /// Compressed buffer views.
    pub compressed: HashMap<usize, meshopt::Compressed>,
    /// Buffers that stand in for compressed views where these cannot be decoded.
    pub fallbacks: BTreeSet<usize>,
    /// Nodes whose mesh is drawn many times: the accessors of EXT_mesh_gpu_instancing by attribute.
    pub instancing: HashMap<usize, BTreeMap<String, usize>>,
    /// Compressed primitives, by their mesh and place in it.
    pub draco: HashMap<(usize, usize), draco::Compressed>,
    /// What they make of materials.
    pub appearances: HashMap<usize, Appearance>,
    /// Images of textures that have none of glTF's own.
    pub images: HashMap<usize, usize>,
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
        let mut images = HashMap::new();
        for extension in IMAGES.iter().rev() {
            let sources: HashMap<usize, Source> = each(root, "textures", extension, |t| t)?;
            images.extend(sources.into_iter().map(|(texture, image)| (texture, image.source)));
        }
        let required = root["extensionsRequired"].as_array().into_iter().flatten();
        Ok(Self {
            required: required.filter_map(|name| name.as_str().map(str::to_owned)).collect(),
            normal_transforms: normals,
            compressed,
            fallbacks,
            instancing: instancing.into_iter().map(|(node, i)| (node, i.attributes)).collect(),
            draco: compressed_primitives(root)?,
            appearances: appearances(root)?,
            images,
        })
    }
}

/// EXT_mesh_gpu_instancing.
#[derive(serde::Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

/// An extension of a texture.
#[derive(serde::Deserialize)]
struct Source {
    source: usize,
}

fn compressed_primitives(root: &Value) -> Parsed<HashMap<(usize, usize), draco::Compressed>> {
    let mut found = HashMap::new();
    for (mesh, json) in root["meshes"].as_array().into_iter().flatten().enumerate() {
        let primitives = each(json, "primitives", draco::EXTENSION, |primitive| primitive)
            .map_err(|fault| format!("meshes[{mesh}].{fault}"))?;
        found.extend(primitives.into_iter().map(|(index, value)| ((mesh, index), value)));
    }
    Ok(found)
}

fn appearances(root: &Value) -> Parsed<HashMap<usize, Appearance>> {
    let materials = root["materials"].as_array().into_iter().flatten().enumerate();
    let extended = materials.filter_map(|(index, json)| Some((index, json.get("extensions")?)));
    let parse = |(index, json): (usize, &Value)| {
        let appearance = Appearance::deserialize(json)
            .map_err(|error| format!("materials[{index}].extensions: {error}"))?;
        Ok((index, appearance))
    };
    extended.map(parse).collect()
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
