//! Primitives to indexed triangles (glTF 2.0, 3.7.2.1).

use super::Parsed;
use super::accessor::{Accessors, Elements, INDICES, NUMBERS, Wanted};
use super::pose::{Deformer, Pose};
use super::tangents;
use crate::scene::{Mesh, Vertex};
use glam::{DVec3, Vec3};
use gltf::json::Index;
use gltf::json::accessor::{Accessor, Type};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use rayon::prelude::*;

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
    // Without normals every triangle is flat, and so has its own vertices.
    let (from, indices) = match source.normals {
        Some(_) => weld(corners, source.positions.count()),
        None => {
            let count = corners.len() as u32;
            (corners, (0..count).collect())
        }
    };
    let deformer =
        Deformer::open(accessors, primitive, pose, source.positions.count(), from.len())?;
    // Collecting would hold the vertices twice.
    let mut vertices: Vec<Vertex> = bytemuck::zeroed_vec(from.len());
    vertices.par_iter_mut().zip(from).try_for_each(|(vertex, at)| {
        *vertex = source.vertex(at as usize, &deformer)?;
        Parsed::Ok(())
    })?;
    let mut mesh = Mesh { vertices, indices, ..Mesh::default() };
    repair_normals(&mut mesh);
    match normal_uv {
        Some(set) if source.normals.is_none() || source.tangents.is_none() => {
            tangents::generate(&mut mesh, set as usize);
        }
        Some(_) => tangents::repair(&mut mesh.vertices),
        None => {}
    }
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
        if !position.is_finite() {
            return Err(format!("position of vertex {at} is not finite"));
        }
        let color = self.colors.as_ref().map_or([255; 4], |elements| {
            let mut color = [0.0, 0.0, 0.0, 1.0];
            match elements.width() {
                4 => color = elements.floats(at),
                _ => color[..3].copy_from_slice(&elements.floats::<3>(at)),
            }
            color.map(|channel| (channel * 255.0).round() as u8)
        });
        let uv = [0, 1].map(|set| {
            let uv: [f32; 2] = self.uvs[set].as_ref().map_or([0.0; 2], |e| e.floats(at));
            uv.map(|coordinate| if coordinate.is_finite() { coordinate } else { 0.0 })
        });
        Ok(Vertex {
            position: position.to_array(),
            normal: normalized(normal).to_array(),
            tangent: tangent.extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array(),
            uv,
            color,
        })
    }
}

/// Unit length, or zero where it has no direction.
pub fn normalized(v: Vec3) -> Vec3 {
    // In double precision, as the square of a short or long vector may not be a single one.
    v.as_dvec3().normalize_or_zero().as_vec3()
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
    if let Some(at) = list.iter().position(|&index| index as usize >= count) {
        return Err(format!(
            "indices: index {} at {at} is out of range: there are {count} vertices",
            list[at]
        ));
    }
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

/// The vertices that are used, in the file's order, and `corners` renumbered to them.
fn weld(mut corners: Vec<u32>, count: usize) -> (Vec<u32>, Vec<u32>) {
    // Primitives may share one large buffer of which each uses a part: no table of all of it.
    if count / 8 > corners.len() {
        let mut from = corners.clone();
        from.sort_unstable();
        from.dedup();
        for corner in &mut corners {
            *corner = from.partition_point(|at| at < corner) as u32;
        }
        return (from, corners);
    }
    let mut number = vec![0u32; count];
    for &corner in &corners {
        number[corner as usize] = 1;
    }
    let mut from = Vec::new();
    for (at, number) in number.iter_mut().enumerate() {
        if *number == 1 {
            *number = from.len() as u32;
            from.push(at as u32);
        }
    }
    for corner in &mut corners {
        *corner = number[*corner as usize];
    }
    (from, corners)
}

/// Gives vertices without a normal that of their triangles, weighted by area.
fn repair_normals(mesh: &mut Mesh) {
    let lacks = |vertex: &Vertex| vertex.normal == [0.0; 3];
    if !mesh.vertices.iter().any(lacks) {
        return;
    }
    let mut sums = vec![DVec3::ZERO; mesh.vertices.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let corner = |k: usize| triangle[k] as usize;
        let lacking = (0..3).any(|k| lacks(&mesh.vertices[corner(k)]));
        if lacking {
            let [a, b, c] =
                [0, 1, 2].map(|k| Vec3::from(mesh.vertices[corner(k)].position).as_dvec3());
            let area = (b - a).cross(c - a);
            (0..3).for_each(|k| sums[corner(k)] += area);
        }
    }
    for (vertex, sum) in mesh.vertices.iter_mut().zip(sums) {
        if lacks(vertex) {
            vertex.normal = sum.normalize_or(DVec3::Z).as_vec3().to_array();
        }
    }
}
