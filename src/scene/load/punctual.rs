//! KHR_lights_punctual.

use super::{Parsed, label};
use crate::scene::{SceneLight, SceneLightKind, camera};
use glam::DMat4;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

/// A light that stands at `world`.
pub fn convert(
    json: &Light,
    node_name: Option<&str>,
    world: &DMat4,
    klieg: Option<serde_json::Value>,
) -> Parsed<SceneLight> {
    let kind = match json.type_ {
        Checked::Valid(Type::Point) => SceneLightKind::Point,
        Checked::Valid(Type::Spot) => SceneLightKind::Spot,
        Checked::Valid(Type::Directional) => SceneLightKind::Directional,
        Checked::Invalid => return Err("its type is none of glTF's".into()),
    };
    let numbers = json.color.iter().chain([&json.intensity]);
    if !numbers.copied().all(|value| value.is_finite() && value >= 0.0) {
        return Err("its colour or intensity is negative or not finite".into());
    }
    let (_, _, back) = camera::axes(world).ok_or("its node has no orientation")?;
    Ok(SceneLight {
        name: label(node_name.or(json.name.as_deref())),
        position: world.w_axis.truncate(),
        direction: -back,
        kind,
        color: json.color,
        intensity: json.intensity,
        klieg,
    })
}
