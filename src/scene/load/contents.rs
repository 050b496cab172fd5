//! What a file holds, used or not; of glTF nothing but its JSON is read.

use super::files::{self, FilePart, MAX_BYTES};
use super::models::{self, Orientation};
use super::{FileAccess, label};
use crate::{Error, Result};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The parts of a file, as its JSON tells them.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Contents {
    /// `glTF`, `GLB`, `PLY`, `STL` or `OBJ`; what the last three amount to in glTF is told here.
    pub container: &'static str,
    /// Bytes of the JSON and of a GLB's binary chunk, and of other files as a whole.
    pub bytes: u64,
    /// Version of glTF.
    pub version: String,
    /// The program that wrote it.
    pub generator: String,
    /// Extensions that it uses.
    pub extensions_used: Vec<String>,
    /// Extensions without which it cannot be shown.
    pub extensions_required: Vec<String>,
    /// How many there are of glTF's lists: nodes, meshes, materials and so on; of `primitives` and
    /// `morphTargets` over all meshes.
    pub counts: BTreeMap<String, usize>,
    /// How many images there are of each media type; `unknown` where the file does not tell.
    pub images: BTreeMap<String, usize>,
    /// Animations.
    pub animations: Vec<AnimationInfo>,
}

/// An animation.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct AnimationInfo {
    /// Its name, empty where it has none.
    pub name: String,
    /// Time of its last key frame, seconds.
    pub seconds: f64,
}

impl Contents {
    /// Those of the file at `path`.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that cannot be read, or is in none of these formats.
    pub fn read(path: &Path) -> Result<Self> {
        let fault = |fault: String| Error::input(path, fault);
        if let Some(model) =
            models::read(path, &Orientation::default(), FileAccess::default()).map_err(fault)?
        {
            let bytes = FilePart::open(path, MAX_BYTES).map_err(fault)?.len();
            return Ok(Self { bytes, container: model.format, ..Self::of(&model.root) });
        }
        let (json, bin) = files::open(path).map_err(fault)?;
        let root: Value = serde_json::from_slice(&json)
            .map_err(|error| fault(format!("is not valid JSON: {error}")))?;
        let bytes = json.len() as u64 + bin.as_ref().map_or(0, FilePart::len);
        Ok(Self { bytes, container: if bin.is_some() { "GLB" } else { "glTF" }, ..Self::of(&root) })
    }

    fn of(root: &Value) -> Self {
        let text = |value: &Value| label(value.as_str());
        let texts = |key| list(root, key).iter().map(text).collect();
        let mut counts: BTreeMap<String, usize> =
            LISTS.into_iter().map(|key| (key.to_owned(), list(root, key).len())).collect();
        let lights = &root["extensions"]["KHR_lights_punctual"];
        counts.insert("lights".into(), list(lights, "lights").len());
        let primitives = || list(root, "meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
        counts.insert("primitives".into(), primitives().count());
        let targets = primitives().map(|primitive| list(primitive, "targets").len());
        counts.insert("morphTargets".into(), targets.sum());
        let mut images = BTreeMap::new();
        for image in list(root, "images") {
            *images.entry(media_type(image)).or_default() += 1;
        }
        let animations = list(root, "animations").iter();
        Self {
            version: text(&root["asset"]["version"]),
            generator: text(&root["asset"]["generator"]),
            extensions_used: texts("extensionsUsed"),
            extensions_required: texts("extensionsRequired"),
            counts,
            images,
            animations: animations.map(|animation| AnimationInfo::of(root, animation)).collect(),
            ..Self::default()
        }
    }
}

/// Lists of glTF's root object.
const LISTS: [&str; 9] = [
    "scenes",
    "nodes",
    "meshes",
    "materials",
    "textures",
    "images",
    "skins",
    "cameras",
    "animations",
];

impl AnimationInfo {
    fn of(root: &Value, animation: &Value) -> Self {
        let end = |sampler: &Value| {
            let input = usize::try_from(sampler["input"].as_u64()?).ok()?;
            list(root, "accessors").get(input)?["max"][0].as_f64()
        };
        let ends = list(animation, "samplers").iter().filter_map(end);
        Self { name: label(animation["name"].as_str()), seconds: ends.fold(0.0, f64::max) }
    }
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// What an image says that it is, by itself or by the end of its file's name.
fn media_type(image: &Value) -> String {
    let uri = image["uri"].as_str().unwrap_or_default();
    let of_data = || uri.strip_prefix("data:")?.split([';', ',']).next();
    let of_name = || {
        let (_, end) = uri.rsplit_once('.').filter(|_| !uri.starts_with("data:"))?;
        match &*end.to_ascii_lowercase() {
            "png" => Some("image/png"),
            "jpg" | "jpeg" => Some("image/jpeg"),
            "ktx2" => Some("image/ktx2"),
            "webp" => Some("image/webp"),
            "avif" => Some("image/avif"),
            _ => None,
        }
    };
    label(image["mimeType"].as_str().or_else(of_data).or_else(of_name).or(Some("unknown")))
}
