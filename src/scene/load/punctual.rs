//! KHR_lights_punctual.

use super::{Parsed, label};
use crate::lighting::{Cone, LightKind};
use crate::scene::{SceneLight, camera};
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
        Checked::Valid(Type::Point) => LightKind::POINT,
        Checked::Valid(Type::Spot) => LightKind::SPOT,
        Checked::Valid(Type::Directional) => LightKind::DIRECTIONAL,
        Checked::Invalid => return Err("its type is none of glTF's".into()),
    };
    let numbers = json.color.iter().chain([&json.intensity]);
    if !numbers.copied().all(|value| value.is_finite() && value >= 0.0) {
        return Err("its colour or intensity is negative or not finite".into());
    }
    let cone = json.spot.as_ref().map_or(Cone::default(), |spot| Cone {
        inner: spot.inner_cone_angle,
        outer: spot.outer_cone_angle,
    });
    if !(cone.inner >= 0.0
        && cone.outer > 0.0
        && cone.outer.max(cone.inner) <= std::f32::consts::PI)
    {
        return Err("its cone has an angle that is not one of 0 to π".into());
    }
    let (_, _, back) = camera::axes(world).ok_or("its node has no orientation")?;
    Ok(SceneLight {
        name: label(node_name.or(json.name.as_deref())),
        position: world.w_axis.truncate(),
        direction: -back,
        kind,
        cone,
        color: json.color,
        intensity: json.intensity,
        range: json.range,
        klieg,
    })
}
