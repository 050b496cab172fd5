//! What stands in the way of light.

use super::Scene;
use super::view::View;
use crate::Result;
use glam::Vec3;

/// All triangles of a scene in the light frame.
#[derive(Debug)]
pub struct Occluders {
    triangles: Vec<[Vec3; 3]>,
}

/// Moves a point off its polygon.
pub fn leave(p: Vec3, face: Vec3) -> Vec3 {
    p + 1e-4 * face
}

impl Occluders {
    /// The occluders of a scene.
    ///
    /// # Errors
    /// None.
    pub fn new(scene: &Scene, view: &View) -> Result<Self> {
        let mut triangles = Vec::new();
        let from_world = view.frame.from_world();
        for (at, instance) in scene.instances.iter().enumerate() {
            for t in 0..scene.meshes[instance.mesh as usize].triangles() {
                triangles
                    .push(scene.corners(at, t).map(|p| from_world.transform_point3(p).as_vec3()));
            }
        }
        Ok(Self { triangles })
    }

    /// Whether a triangle stands there.
    pub fn blocked(&self, from: Vec3, direction: Vec3, distance: f32) -> bool {
        self.triangles.iter().any(|[a, b, c]| {
            let (e1, e2) = (*b - *a, *c - *a);
            let h = direction.cross(e2);
            let det = e1.dot(h);
            let s = from - *a;
            let u = s.dot(h) / det;
            let q = s.cross(e1);
            let v = direction.dot(q) / det;
            let t = e2.dot(q) / det;
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < distance
        })
    }
}
