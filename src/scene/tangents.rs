//! Tangents of normal-mapped meshes: MikkTSpace (Mikkelsen 2008), as glTF 2.0, 3.7.2.1 asks for.

use super::assemble::normalized;
use super::{Mesh, Vertex};
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::Vec3;

/// Computes the tangents of a mesh for texture coordinate set `uv_set`. Vertices where tangents
/// part (mirrored or cut coordinates) are doubled.
pub(super) fn generate(mesh: &mut Mesh, uv_set: usize) {
    let mut corners = Corners { mesh, uv_set, tangents: vec![[0.0; 4]; mesh.indices.len()] };
    // It has no errors yet; where it finds no tangent, `repair` gives one.
    generate_tangents(&mut corners).ok();
    let tangents = corners.tangents;
    split(mesh, &tangents);
    repair(&mut mesh.vertices);
}

struct Corners<'a> {
    mesh: &'a Mesh,
    uv_set: usize,
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> &Vertex {
        &self.mesh.vertices[self.mesh.indices[3 * face + corner] as usize]
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).position
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).normal
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // MikkTSpace's v axis points up, glTF's down.
        let [u, v] = self.vertex(face, corner).uv[self.uv_set];
        [u, 1.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = space.map(|space| space.tangent_encoded());
        if let Some(tangent) = tangent.filter(|tangent| tangent.iter().all(|c| c.is_finite())) {
            self.tangents[3 * face + corner] = tangent;
        }
    }
}

/// Gives each vertex the tangent of its corners, doubling it where they differ.
fn split(mesh: &mut Mesh, tangents: &[[f32; 4]]) {
    const NONE: u32 = u32::MAX;
    /// No tangent has been set yet.
    const UNSET: [f32; 4] = [0.0, 0.0, 0.0, 2.0];
    let Mesh { vertices, indices, .. } = mesh;
    vertices.iter_mut().for_each(|vertex| vertex.tangent = UNSET);
    // The doubles of a vertex as a list: `next[v]` is the next one.
    let mut next = vec![NONE; vertices.len()];
    for (index, &tangent) in indices.iter_mut().zip(tangents) {
        let mut at = *index as usize;
        loop {
            if vertices[at].tangent == UNSET {
                vertices[at].tangent = tangent;
            }
            if vertices[at].tangent == tangent {
                break;
            }
            if next[at] == NONE {
                next[at] = vertices.len() as u32;
                next.push(NONE);
                vertices.push(Vertex { tangent, ..vertices[at] });
            }
            at = next[at] as usize;
        }
        *index = at as u32;
    }
}

/// Makes tangents unit vectors and signs ±1; one without direction becomes any that is
/// perpendicular to the normal.
pub(super) fn repair(vertices: &mut [Vertex]) {
    for vertex in vertices {
        let [x, y, z, sign] = vertex.tangent;
        let mut tangent = normalized(Vec3::new(x, y, z));
        if tangent == Vec3::ZERO {
            tangent = Vec3::from(vertex.normal).any_orthonormal_vector();
        }
        vertex.tangent = tangent.extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array();
    }
}
