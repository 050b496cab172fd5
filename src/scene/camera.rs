//! The file's cameras and how one is chosen.

use super::Scene;
use super::view::{Camera, DesignedView, Projection};
use crate::{Error, Result};
use glam::{DMat4, DVec3};
use gltf::json::camera::{Camera as Json, Type};
use gltf::json::validation::Checked;

/// The camera of `scene` that `selector` names, or else numbers from 0.
///
/// # Errors
/// [`Error::Argument`] that lists the cameras when there is no such one.
pub fn choose(scene: &Scene, selector: &str) -> Result<Camera> {
    let by_name = || scene.cameras.iter().find(|camera| camera.name == selector);
    let by_index = || scene.cameras.get(selector.parse::<usize>().ok()?);
    by_name().or_else(by_index).cloned().ok_or_else(|| {
        let names = scene.cameras.iter().enumerate();
        let names: Vec<_> = names.map(|(i, camera)| format!("{i} '{}'", camera.name)).collect();
        let path = scene.path.display();
        Error::Argument(match names.is_empty() {
            true => format!("there is no camera '{selector}': {path} has none"),
            false => {
                format!("there is no camera '{selector}': {path} has {}", names.join(", "))
            }
        })
    })
}

/// A glTF camera that stands at `world`; the fault where it cannot be used.
pub(super) fn convert(
    json: &Json,
    name: String,
    world: &DMat4,
    designed: Option<DesignedView>,
) -> std::result::Result<Camera, String> {
    let (projection, near, far) = lens(json)?;
    let (right, up, back) = axes(world).ok_or("its node has no orientation")?;
    let eye = world.w_axis.truncate();
    Ok(Camera { name, eye, right, up, back, projection, near, far, designed })
}

/// Lens, near and far plane (glTF 2.0, 3.10.3).
fn lens(json: &Json) -> std::result::Result<(Projection, f64, Option<f64>), String> {
    let positive = |name: &str, value: f32| match value.is_finite() && value > 0.0 {
        true => Ok(f64::from(value)),
        false => Err(format!("its {name} is {value}, which is not positive")),
    };
    let (projection, near, far) = match (json.type_, &json.perspective, &json.orthographic) {
        (Checked::Valid(Type::Perspective), Some(lens), _) => {
            let yfov = positive("yfov", lens.yfov)?;
            if yfov >= std::f64::consts::PI {
                return Err(format!("its yfov is {yfov}, which is not below π"));
            }
            let far = lens.zfar.map(|far| positive("zfar", far)).transpose()?;
            (Projection::Perspective { yfov }, positive("znear", lens.znear)?, far)
        }
        (Checked::Valid(Type::Orthographic), _, Some(lens)) => {
            let ymag = positive("ymag", lens.ymag)?;
            let near = f64::from(lens.znear);
            if !(near.is_finite() && near >= 0.0) {
                return Err(format!("its znear is {near}, which is negative"));
            }
            (Projection::Orthographic { ymag }, near, Some(positive("zfar", lens.zfar)?))
        }
        _ => return Err("it is neither perspective nor orthographic".into()),
    };
    if let Some(far) = far.filter(|&far| far <= near) {
        return Err(format!("its zfar {far} is not beyond its znear {near}"));
    }
    Ok((projection, near, far))
}

/// Orthonormal right, up and back axes of a node that looks along its −Z axis; `None` where the
/// node is flat.
pub(super) fn axes(world: &DMat4) -> Option<(DVec3, DVec3, DVec3)> {
    let back = world.z_axis.truncate().try_normalize()?;
    let right = world.y_axis.truncate().try_normalize()?.cross(back).try_normalize()?;
    Some((right, back.cross(right), back))
}
