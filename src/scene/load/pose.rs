//! Morph targets and skins (glTF 2.0, 3.7.2.2 and 3.7.3): the pose that the file's nodes stand in.

use super::Parsed;
use super::accessor::{Accessors, NUMBERS, Wanted};
use super::elements::Elements;
use glam::{DMat3, DMat4, Mat4, Vec3};
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::skin::Skin;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::sync::Arc;

/// How a node poses its mesh.
#[derive(Default, Clone)]
pub struct Pose {
    /// Weights of the morph targets.
    pub weights: Vec<f32>,
    /// World from bind space for each joint, where the node has a skin.
    pub joints: Option<Arc<[DMat4]>>,
}

/// World from bind space for each joint of a skin.
pub fn joints(
    root: &Root,
    accessors: &Accessors,
    skin: Index<Skin>,
    world: &[DMat4],
) -> Parsed<Arc<[DMat4]>> {
    let skin = root.get(skin).ok_or("its skin is not there")?;
    let wanted =
        Wanted { types: &[Type::Mat4], components: &[ComponentType::F32], normalized: false };
    let inverse_bind =
        skin.inverse_bind_matrices.map(|index| accessors.open(index, &wanted)).transpose()?;
    if inverse_bind.as_ref().is_some_and(|matrices| matrices.count() < skin.joints.len()) {
        return Err("its skin has fewer inverse bind matrices than joints".into());
    }
    accessors.charge(skin.joints.len())?;
    let matrix = |(i, joint): (usize, &Index<_>)| {
        let bind = inverse_bind
            .as_ref()
            .map_or(Mat4::IDENTITY, |matrices| Mat4::from_cols_array(&matrices.floats::<16>(i)));
        world[joint.value()] * bind.as_dmat4()
    };
    Ok(skin.joints.iter().enumerate().map(matrix).collect())
}

/// A primitive's morph targets and joints, ready to move its vertices.
pub struct Deformer<'a> {
    targets: Vec<Target<'a>>,
    joints: Option<Arc<[DMat4]>>,
    influences: Vec<(Elements<'a>, Elements<'a>)>,
}

struct Target<'a> {
    weight: f32,
    /// Changes of position, normal and tangent.
    deltas: [Option<Elements<'a>>; 3],
}

impl<'a> Deformer<'a> {
    /// Opens what `pose` moves of a primitive of `count` vertices, of which `drawn` are drawn.
    pub fn open(
        accessors: &Accessors<'a>,
        primitive: &Primitive,
        pose: &Pose,
        count: usize,
        drawn: usize,
    ) -> Parsed<Self> {
        let open = |index, types: &[Type], components: &[ComponentType], normalized| {
            accessors.charge(drawn)?;
            let elements = accessors.open(index, &Wanted { types, components, normalized })?;
            if elements.count() != count {
                return Err(format!(
                    "accessors[{}] has {} elements where POSITION has {count}",
                    index.value(),
                    elements.count()
                ));
            }
            Ok(elements)
        };
        let mut targets = Vec::new();
        for (target, &weight) in primitive.targets.iter().flatten().zip(&pose.weights) {
            if weight == 0.0 {
                continue;
            }
            let delta = |index: Option<_>| {
                index.map(|index| open(index, &[Type::Vec3], NUMBERS, false)).transpose()
            };
            let deltas =
                [delta(target.positions)?, delta(target.normals)?, delta(target.tangents)?];
            targets.push(Target { weight, deltas });
        }
        let mut influences = Vec::new();
        for set in 0.. {
            let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
            let (Some(_), Some(&joints), Some(&weights)) =
                (&pose.joints, find(Semantic::Joints(set)), find(Semantic::Weights(set)))
            else {
                break;
            };
            let whole = [ComponentType::U8, ComponentType::U16];
            influences.push((
                open(joints, &[Type::Vec4], &whole, false)?,
                open(weights, &[Type::Vec4], NUMBERS, true)?,
            ));
        }
        Ok(Self { targets, joints: pose.joints.clone(), influences })
    }

    /// Whether the skin, rather than the node, places the vertices in the world.
    pub fn skinned(&self) -> bool {
        !self.influences.is_empty()
    }

    /// Position, normal and tangent of vertex `at` of the file, moved.
    pub fn apply(&self, at: usize, vectors: [Vec3; 3]) -> Parsed<[Vec3; 3]> {
        let mut moved = vectors;
        for target in &self.targets {
            for (vector, delta) in moved.iter_mut().zip(&target.deltas) {
                if let Some(delta) = delta {
                    *vector += target.weight * Vec3::from(delta.floats(at));
                }
            }
        }
        let Some(matrix) = self.matrix(at)? else { return Ok(moved) };
        let linear = DMat3::from_mat4(matrix);
        // The cofactors turn normals as the inverse transpose does, and exist for flat scales too.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let sign = linear.determinant().signum();
        let [position, normal, tangent] = moved.map(|v| v.as_dvec3());
        Ok([
            matrix.transform_point3(position).as_vec3(),
            (cofactors * normal * sign).normalize_or_zero().as_vec3(),
            (linear * tangent).normalize_or_zero().as_vec3(),
        ])
    }

    /// World from bind space for vertex `at`; `None` without a skin.
    fn matrix(&self, at: usize) -> Parsed<Option<DMat4>> {
        let Some(matrices) = self.joints.as_deref().filter(|_| self.skinned()) else {
            return Ok(None);
        };
        let mut sum = DMat4::ZERO;
        let mut total = 0.0;
        for (joints, weights) in &self.influences {
            let joints = joints.integers::<4>(at);
            for (joint, weight) in joints.into_iter().zip(weights.floats::<4>(at)) {
                if weight > 0.0 {
                    let matrix = matrices
                        .get(joint as usize)
                        .ok_or_else(|| format!("joint {joint} of vertex {at} is out of range"))?;
                    sum += *matrix * f64::from(weight);
                    total += f64::from(weight);
                }
            }
        }
        // A vertex that no joint holds stays with the first.
        let held = total > 0.0;
        Ok(Some(if held { sum * (1.0 / total) } else { matrices.first().copied().unwrap_or(sum) }))
    }
}
