//! Instances, ready to be drawn in a view.

use crate::scene::view::View;
use crate::scene::{Instance, Material, Mesh, Scene, Vertex};
use glam::{Mat3, Mat4, Vec3};

/// An instance with its transforms to the light frame.
pub struct Object<'a> {
    /// Colour code of its first triangle.
    pub first_polygon: u32,
    mesh: &'a Mesh,
    /// Its material.
    pub material: &'a Material,
    frame_from_mesh: Mat4,
    normal_from_mesh: Mat3,
    /// Whether the transform mirrors, so that fronts are wound the other way.
    pub mirrored: bool,
}

impl<'a> Object<'a> {
    /// `instance` in the light frame of `view`.
    pub fn new(scene: &'a Scene, view: &View, instance: &Instance) -> Self {
        let mesh = &scene.meshes[instance.mesh as usize];
        let (normal_from_mesh, mirrored) = view.normal_from_mesh(&instance.world);
        Self {
            first_polygon: instance.first_polygon,
            mesh,
            material: &scene.materials[mesh.material as usize],
            frame_from_mesh: view.frame_from_mesh(&instance.world).as_mat4(),
            normal_from_mesh: normal_from_mesh.as_mat3(),
            mirrored,
        }
    }

    /// Indices of the corners of the polygon number `code`, which must be one of this object's.
    pub fn corners(&self, code: u32) -> [u32; 3] {
        let at = 3 * (code - self.first_polygon) as usize;
        let corners = &self.mesh.indices[at..at + 3];
        [corners[0], corners[1], corners[2]]
    }

    /// A vertex of the mesh.
    pub fn vertex(&self, index: u32) -> &'a Vertex {
        &self.mesh.vertices[index as usize]
    }

    /// Corners of the polygon number `code`, which must be one of this object's.
    pub fn vertices(&self, code: u32) -> [&'a Vertex; 3] {
        self.corners(code).map(|index| self.vertex(index))
    }

    /// Colour code after the last triangle's.
    pub fn end(&self) -> u32 {
        self.first_polygon + self.mesh.triangles()
    }

    /// Position in the light frame.
    pub fn position(&self, vertex: &Vertex) -> Vec3 {
        (self.frame_from_mesh * Vec3::from(vertex.position).extend(1.0)).truncate()
    }

    /// Unit normal in the light frame.
    pub fn normal(&self, vertex: &Vertex) -> Vec3 {
        (self.normal_from_mesh * Vec3::from(vertex.normal)).normalize_or_zero()
    }

    /// Unit tangent in the light frame.
    pub fn tangent(&self, vertex: &Vertex) -> Vec3 {
        let [x, y, z, _] = vertex.tangent;
        self.frame_from_mesh.transform_vector3(Vec3::new(x, y, z)).normalize_or_zero()
    }
}
