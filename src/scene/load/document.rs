//! glTF's JSON: version, extensions and references.

use super::extensions::{Extensions, SUPPORTED};
use super::used::Used;
use super::{Parsed, quoted, warn};
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error, Validate};
use gltf::json::{Path, Root};
use serde::Deserialize;
use serde_json::Value;

/// A parsed file whose references all lead somewhere.
pub struct Document {
    /// The file's content.
    pub root: Root,
    /// Each node's place in its parent, in double precision, which [`Root`] rounds: a scene may stand
    /// far from the origin.
    pub places: Vec<Place>,
    /// What its extensions say, which [`Root`] leaves out.
    pub extensions: Extensions,
    /// What anything in the file uses, drawn or not.
    pub used: Used,
}

/// A node's transform as the file has it.
#[derive(Default, Clone, Deserialize)]
pub struct Place {
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

/// Parses the JSON; optional extensions that are not supported go to `warnings`.
pub fn parse(json: &[u8], warnings: &mut Vec<String>) -> Parsed<Document> {
    let mut value: Value =
        serde_json::from_slice(json).map_err(|error| format!("is not valid JSON: {error}"))?;
    check_version(&value)?;
    check_extensions(&value, warnings)?;
    // A scene may lack nodes, which the model does not allow for.
    let scenes = value.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    // Channels that move no node, as those of KHR_animation_pointer, neither.
    let animations = value.get_mut("animations").and_then(Value::as_array_mut);
    for animation in animations.into_iter().flatten() {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            channels.retain(|channel| channel["target"].get("node").is_some());
        }
    }
    let extensions = Extensions::of(&value)?;
    let invalid = |error| format!("is not valid glTF: {error}");
    let nodes = value["nodes"].as_array().into_iter().flatten();
    let places = nodes.map(Place::deserialize).collect::<Result<_, _>>().map_err(invalid)?;
    let used = value.as_object().map(Used::of).unwrap_or_default();
    let root: Root = serde_json::from_value(value).map_err(invalid)?;
    check_references(&root)?;
    Ok(Document { root, places, extensions, used })
}

fn check_version(value: &Value) -> Parsed<()> {
    let asset = &value["asset"];
    let version = asset["version"].as_str().ok_or("is not glTF: it has no asset version")?;
    if version.split('.').next() != Some("2") {
        return Err(format!("is glTF version {}; klieg reads 2.0", quoted(version)));
    }
    if let Some(least) = asset["minVersion"].as_str().filter(|&least| least != "2.0") {
        return Err(format!("needs glTF version {}; klieg reads 2.0", quoted(least)));
    }
    Ok(())
}

fn check_extensions(value: &Value, warnings: &mut Vec<String>) -> Parsed<()> {
    let names = |key: &str| {
        let names = value[key].as_array().into_iter().flatten().filter_map(Value::as_str);
        let mut names: Vec<_> = names.filter(|name| !SUPPORTED.contains(name)).collect();
        names.sort_unstable();
        names.dedup();
        names
    };
    let required = names("extensionsRequired");
    if !required.is_empty() {
        let names = required.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
        return Err(format!("requires what klieg does not support: {names}"));
    }
    for name in names("extensionsUsed") {
        warn(warnings, format!("extension {} is not supported and is left out", quoted(name)));
    }
    Ok(())
}

/// Every index must lead to something, whether it is drawn or not.
fn check_references(root: &Root) -> Parsed<()> {
    // The model's own check below looks at the accessors of positions without asking.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if positions.is_some_and(|index| root.get(*index).is_none()) {
                return Err(format!(
                    "meshes[{m}].primitives[{p}].attributes.POSITION: index out of range"
                ));
            }
        }
    }
    let mut faults = Vec::new();
    let mut more = 0;
    root.validate(root, Path::new, &mut |path, error| {
        if error == Error::IndexOutOfBounds {
            if faults.len() < 3 {
                faults.push(format!("{}: index out of range", path()));
            } else {
                more += 1;
            }
        }
    });
    if more > 0 {
        faults.push(format!("and {more} more"));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults.join("; ")) }
}
