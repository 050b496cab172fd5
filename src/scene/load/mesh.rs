//! Primitives to indexed triangles (glTF 2.0, 3.7.2.1).

use super::Parsed;
use super::accessor::{Accessors, INDICES, NUMBERS, Wanted};
use super::elements::Elements;
use super::pose::{Deformer, Pose};
use crate::scene::assemble::{Tangents, Triangles, check_indices};
use crate::scene::{Mesh, Vertex};
use glam::Vec3;
use gltf::json::Index;
use gltf::json::accessor::{Accessor, Type};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// Whether a primitive has triangles.
pub fn has_triangles(primitive: &Primitive) -> Parsed<bool> {
    match primitive.mode {
        Checked::Valid(mode) => {
            Ok(matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
        }
        Checked::Invalid => Err("its mode is none of glTF's".into()),
    }
}

/// The texture coordinate sets 0 and 1 that a primitive has.
pub fn uv_sets(primitive: &Primitive) -> [bool; 2] {
    [0, 1].map(|set| find(primitive, Semantic::TexCoords(set)).is_some())
}

/// A primitive's triangles, and whether they stand in the world already (skinned) rather than in
/// their node's space. `normal_uv` is the coordinate set of the material's normal texture.
pub fn build(
    accessors: &Accessors,
    primitive: &Primitive,
    pose: &Pose,
    normal_uv: Option<u32>,
) -> Parsed<(Mesh, bool)> {
    let source = Source::open(accessors, primitive)?;
    let corners = triangles(accessors, primitive, source.positions.count())?;
    let count = source.positions.count();
    let triangles = Triangles::new(corners, count, source.normals.is_some());
    let deformer = Deformer::open(accessors, primitive, pose, count, triangles.vertices())?;
    let tangents = match (normal_uv, &source.tangents) {
        (None, _) => Tangents::Unused,
        (Some(_), Some(_)) if source.normals.is_some() => Tangents::Given,
        (Some(set), _) => Tangents::Computed { uv_set: set as usize },
    };
    let mesh = triangles.mesh(tangents, |at| source.vertex(at, &deformer))?;
    Ok((mesh, deformer.skinned()))
}

fn find(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// The attributes of a primitive.
struct Source<'a> {
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    tangents: Option<Elements<'a>>,
    uvs: [Option<Elements<'a>>; 2],
    colors: Option<Elements<'a>>,
}

impl<'a> Source<'a> {
    fn open(accessors: &Accessors<'a>, primitive: &Primitive) -> Parsed<Self> {
        let open = |semantic: Semantic, types: &[Type], normalized| {
            let name = semantic.to_string();
            let wanted = Wanted { types, components: NUMBERS, normalized };
            find(primitive, semantic)
                .map(|index| accessors.open(index, &wanted))
                .transpose()
                .map_err(|fault| format!("{name}: {fault}"))
        };
        let positions = open(Semantic::Positions, &[Type::Vec3], false)?;
        let positions = positions.ok_or("it has no POSITION")?;
        let source = Self {
            normals: open(Semantic::Normals, &[Type::Vec3], false)?,
            tangents: open(Semantic::Tangents, &[Type::Vec4], false)?,
            uvs: [
                open(Semantic::TexCoords(0), &[Type::Vec2], false)?,
                open(Semantic::TexCoords(1), &[Type::Vec2], false)?,
            ],
            colors: open(Semantic::Colors(0), &[Type::Vec3, Type::Vec4], true)?,
            positions,
        };
        let count = source.positions.count();
        let [uv0, uv1] = &source.uvs;
        for (name, attribute) in [
            ("NORMAL", &source.normals),
            ("TANGENT", &source.tangents),
            ("TEXCOORD_0", uv0),
            ("TEXCOORD_1", uv1),
            ("COLOR_0", &source.colors),
        ] {
            if let Some(other) = attribute.as_ref().map(Elements::count).filter(|&c| c != count) {
                return Err(format!("{name} has {other} elements where POSITION has {count}"));
            }
        }
        Ok(source)
    }

    /// Vertex `at` of the file; the normal is zero where there is no usable one.
    fn vertex(&self, at: usize, deformer: &Deformer) -> Parsed<Vertex> {
        let position = Vec3::from(self.positions.floats(at));
        let normal = self.normals.as_ref().map_or(Vec3::ZERO, |e| Vec3::from(e.floats(at)));
        // glTF 2.0, 3.7.2.1: tangents without normals are ignored.
        let tangents = self.tangents.as_ref().filter(|_| self.normals.is_some());
        let [x, y, z, sign] = tangents.map_or([0.0; 4], |elements| elements.floats(at));
        let [position, normal, tangent] =
            deformer.apply(at, [position, normal, Vec3::new(x, y, z)])?;
        let color = self.colors.as_ref().map_or([255; 4], |elements| {
            let mut color = [0.0, 0.0, 0.0, 1.0];
            match elements.width() {
                4 => color = elements.floats(at),
                _ => color[..3].copy_from_slice(&elements.floats::<3>(at)),
            }
            color.map(|channel| (channel * 255.0).round() as u8)
        });
        let uv = [0, 1]
            .map(|set| self.uvs[set].as_ref().map_or([0.0; 2], |elements| elements.floats(at)));
        let vertex = Vertex {
            position: position.to_array(),
            normal: normal.to_array(),
            tangent: tangent.extend(sign).to_array(),
            uv,
            color,
        };
        vertex.checked(at)
    }
}

/// Corners of a primitive's triangles as vertices of the file, all below `count`.
fn triangles(accessors: &Accessors, primitive: &Primitive, count: usize) -> Parsed<Vec<u32>> {
    let list = match primitive.indices {
        Some(index) => {
            let wanted = Wanted { types: &[Type::Scalar], components: INDICES, normalized: false };
            let indices =
                accessors.open(index, &wanted).map_err(|fault| format!("indices: {fault}"))?;
            accessors.charge(indices.count())?;
            (0..indices.count()).map(|at| indices.index(at)).collect::<Vec<_>>()
        }
        None => {
            accessors.charge(count)?;
            (0..count as u32).collect()
        }
    };
    check_indices(&list, count)?;
    let mode = if let Checked::Valid(mode) = primitive.mode { mode } else { Mode::Triangles };
    if mode != Mode::Triangles {
        accessors.charge(list.len().saturating_mul(3))?;
    }
    // glTF 2.0, 3.7.2.1; triangles that repeat an index only stitch strips together.
    let corners: Vec<u32> = match mode {
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| [t[0], t[1 + i % 2], t[2 - i % 2]];
            list.windows(3).enumerate().map(turned).filter(distinct).flatten().collect()
        }
        Mode::TriangleFan => {
            let hub = list.first().copied().unwrap_or_default();
            let rim = list.get(1..).unwrap_or_default();
            rim.windows(2).map(|t| [t[0], t[1], hub]).filter(distinct).flatten().collect()
        }
        _ => {
            let mut list = list;
            list.truncate(list.len() / 3 * 3);
            list
        }
    };
    Ok(corners)
}

fn distinct(t: &[u32; 3]) -> bool {
    t[0] != t[1] && t[1] != t[2] && t[2] != t[0]
}
