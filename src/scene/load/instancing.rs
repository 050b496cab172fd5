//! Meshes that a node draws many times (`EXT_mesh_gpu_instancing`).

use super::Parsed;
use super::accessor::{Accessors, NUMBERS, Wanted};
use super::elements::Elements;
use glam::{DMat4, DQuat, DVec3, Quat, Vec3};
use gltf::json::Index;
use gltf::json::accessor::Type;
use std::collections::BTreeMap;

/// What an instance costs of the elements that a file may have, as it takes more memory than a vertex.
const ELEMENTS_OF_INSTANCE: usize = 32;

/// Where a node's instances stand in its space, of the accessors by attribute; attributes other than
/// `TRANSLATION`, `ROTATION` and `SCALE` do not move them.
pub fn places(accessors: &Accessors, attributes: &BTreeMap<String, usize>) -> Parsed<Vec<DMat4>> {
    let open = |name: &str, kind| -> Parsed<Option<Elements>> {
        let Some(&index) = attributes.get(name) else { return Ok(None) };
        let wanted = Wanted { types: &[kind], components: NUMBERS, normalized: name == "ROTATION" };
        let index = u32::try_from(index).map_err(|_| format!("{name}: index out of range"))?;
        let elements = accessors.open(Index::new(index), &wanted);
        elements.map(Some).map_err(|fault| format!("{name}: {fault}"))
    };
    let translations = open("TRANSLATION", Type::Vec3)?;
    let rotations = open("ROTATION", Type::Vec4)?;
    let scales = open("SCALE", Type::Vec3)?;
    let counts = [&translations, &rotations, &scales].map(|e| e.as_ref().map(Elements::count));
    let count = counts.iter().flatten().max().copied().unwrap_or(0);
    if counts.iter().flatten().any(|&other| other != count) {
        return Err("its attributes differ in their number of elements".into());
    }
    accessors.charge(count.saturating_mul(ELEMENTS_OF_INSTANCE))?;
    let place = |at| {
        let vector = |elements: &Option<Elements>, default| {
            elements.as_ref().map_or(default, |e| Vec3::from(e.floats(at)).as_dvec3())
        };
        let rotation =
            rotations.as_ref().map_or(Quat::IDENTITY, |e| Quat::from_array(e.floats(at)));
        let rotation = rotation.as_dquat();
        let rotation =
            if rotation.length() > 1e-6 { rotation.normalize() } else { DQuat::IDENTITY };
        let place = DMat4::from_scale_rotation_translation(
            vector(&scales, DVec3::ONE),
            rotation,
            vector(&translations, DVec3::ZERO),
        );
        match place.as_mat4().is_finite() {
            true => Ok(place),
            false => Err(format!("instance {at} has no finite place")),
        }
    };
    (0..count).map(place).collect()
}
