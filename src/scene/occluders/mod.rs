//! What blocks light: all triangles of a scene, in a bounding volume hierarchy.

mod opacity;
mod tree;

use super::Scene;
use super::view::View;
use crate::constants::{OPAQUE, SHADOW_OFFSET};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use opacity::Opacity;
use rayon::prelude::*;

/// Most triangles; a node of the tree has room for their numbers.
pub const MAX_TRIANGLES: usize = 1 << 27;

/// A node of the tree. Nodes stand in depth-first order: the next one of a node whose box is hit is the one
/// behind it, and that of any other is [`Node::skip`]. So a walk needs no stack.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lowest corner of the box.
    pub low: [f32; 3],
    /// The node after this one and all below it.
    pub skip: u32,
    /// Highest corner of the box.
    pub high: [f32; 3],
    /// Of a leaf its first triangle, and how many there are, less one, in the upper five bits;
    /// `u32::MAX` of an inner node.
    pub triangles: u32,
}

impl Node {
    /// [`Node::triangles`] of an inner node.
    pub const INNER: u32 = u32::MAX;

    /// The triangles of a leaf; none of an inner node.
    pub fn range(&self) -> std::ops::Range<usize> {
        if self.triangles == Self::INNER {
            return 0..0;
        }
        let first = (self.triangles & (MAX_TRIANGLES as u32 - 1)) as usize;
        first..first + (self.triangles >> 27) as usize + 1
    }
}

/// A triangle, in the order of the leaves.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// A corner.
    pub corner: [f32; 3],
    /// Where its cells begin in [`Occluders::opacity`]; `u32::MAX` where it blocks everywhere.
    pub opacity: u32,
    /// From that corner to the second one.
    pub edge1: [f32; 3],
    /// 0.
    pub padding1: u32,
    /// From that corner to the third one.
    pub edge2: [f32; 3],
    /// 0.
    pub padding2: u32,
}

/// What blocks light, in the light frame of a view. Both sides of every triangle block; what an alpha mask
/// cuts out does not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Occluders {
    /// The tree, its root first.
    pub nodes: Vec<Node>,
    /// The triangles, leaf after leaf.
    pub triangles: Vec<Triangle>,
    /// Which cells of the triangles with an alpha mask block. Each triangle's part begins with the number
    /// `n` of cells along an edge, and goes on with a bit for each half of `n·n` cells of its barycentric
    /// coordinates `u` and `v`: bit `2·(⌊u·n⌋·n + ⌊v·n⌋)`, one more beyond the cell's diagonal.
    pub opacity: Vec<u32>,
}

/// A ray prepared for a triangle: barycentric coordinates and the distance are linear in its origin
/// (Möller and Trumbore 1997, with the determinants turned round).
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// The triangle's corner.
    pub corner: Vec3,
    /// Of the first barycentric coordinate, `d×e2 / det`.
    pub u: Vec3,
    /// Of the second one, `e1×d / det`.
    pub v: Vec3,
    /// Of the distance along the ray, `e1×e2 / det`.
    pub t: Vec3,
}

impl Plane {
    /// Of rays along `direction`; `None` where they run along the triangle.
    #[inline(always)]
    pub fn new(triangle: &Triangle, direction: Vec3) -> Option<Self> {
        let (e1, e2) = (Vec3::from(triangle.edge1), Vec3::from(triangle.edge2));
        let p = direction.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let (u, v, t) = (p * inverse, e1.cross(direction) * inverse, e1.cross(e2) * inverse);
        Some(Self { corner: triangle.corner.into(), u, v, t })
    }
}

/// Moves a point off its polygon, to where rays to lights start. `face` is the polygon's unit normal on the
/// side that is seen.
pub fn leave(p: Vec3, face: Vec3) -> Vec3 {
    p + face * SHADOW_OFFSET
}

impl Occluders {
    /// All that a scene draws, in the light frame of `view`.
    ///
    /// # Errors
    /// [`Error::Input`] for more than [`MAX_TRIANGLES`] triangles.
    pub fn new(scene: &Scene, view: &View) -> Result<Self> {
        let count = scene.polygons() as usize;
        if count > MAX_TRIANGLES {
            let fault =
                format!("{count} triangles are too many for shadows ({MAX_TRIANGLES} at most)");
            return Err(Error::input(&scene.path, format!("{fault}: use --shadows off")));
        }
        let mut opacity = Opacity::default();
        let mut triangles = Vec::with_capacity(count);
        for (index, instance) in scene.instances.iter().enumerate() {
            let first = triangles.len();
            let number = scene.meshes[instance.mesh as usize].triangles();
            let corners = (0..number).into_par_iter().map(|t| {
                let into = view.frame.from_world();
                scene.corners(index, t).map(|corner| into.transform_point3(corner))
            });
            triangles.par_extend(corners.map(triangle));
            let cells = opacity.of(scene, instance);
            for (triangle, cells) in triangles[first..].iter_mut().zip(cells) {
                triangle.opacity = cells;
            }
        }
        triangles.retain(blocks);
        Ok(Self::of_triangles(triangles, opacity.words))
    }

    /// Of triangles in any order.
    fn of_triangles(triangles: Vec<Triangle>, opacity: Vec<u32>) -> Self {
        let (nodes, order) = tree::build(&triangles);
        let triangles = order.iter().map(|&at| triangles[at as usize]).collect();
        Self { nodes, triangles, opacity }
    }

    /// Whether anything blocks the way from `from` along the unit vector `direction` before `distance`, all
    /// in the light frame; an infinite distance leads out of the scene.
    pub fn blocked(&self, from: Vec3, direction: Vec3, distance: f32) -> bool {
        let inverse = inverse(direction);
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !reaches(node, from, inverse, distance) {
                at = node.skip as usize;
                continue;
            }
            at += 1;
            for triangle in &self.triangles[node.range()] {
                if self.hits(triangle, from, direction, distance) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether a ray meets a triangle where it blocks.
    fn hits(&self, triangle: &Triangle, from: Vec3, direction: Vec3, distance: f32) -> bool {
        // The steps of `Plane::new`, with the bits of its numbers; most rays miss at the first coordinate.
        let (e1, e2) = (Vec3::from(triangle.edge1), Vec3::from(triangle.edge2));
        let p = direction.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return false;
        }
        let inverse = 1.0 / det;
        let s = from - Vec3::from(triangle.corner);
        let u = s.dot(p * inverse);
        if !(0.0..=1.0).contains(&u) {
            return false;
        }
        let v = s.dot(e1.cross(direction) * inverse);
        if !(v >= 0.0 && u + v <= 1.0) {
            return false;
        }
        let t = s.dot(e1.cross(e2) * inverse);
        let hit = t > 0.0 && t < distance;
        hit && (triangle.opacity == OPAQUE || self.is_opaque(triangle.opacity, u, v))
    }

    /// Whether the cell at the barycentric coordinates `u` and `v` of an alpha mask blocks.
    pub fn is_opaque(&self, cells: u32, u: f32, v: f32) -> bool {
        let cells = &self.opacity[cells as usize..];
        let n = cells[0];
        let (x, y) = (u * n as f32, v * n as f32);
        let (i, j) = ((x as u32).min(n - 1), (y as u32).min(n - 1));
        let beyond = (x - i as f32) + (y - j as f32) > 1.0;
        let bit = 2 * (i * n + j) + u32::from(beyond);
        cells[1 + (bit / 32) as usize] >> (bit % 32) & 1 == 1
    }
}

/// Reciprocals of a direction's components, all finite, so that no product of theirs is not a number.
#[inline(always)]
pub fn inverse(direction: Vec3) -> Vec3 {
    const LEAST: f32 = 1e-12;
    let safe = |c: f32| if c.abs() < LEAST { LEAST.copysign(c) } else { c };
    Vec3::new(safe(direction.x), safe(direction.y), safe(direction.z)).recip()
}

/// Whether a ray meets a node's box before `distance`.
#[inline(always)]
fn reaches(node: &Node, from: Vec3, inverse: Vec3, distance: f32) -> bool {
    /// Rounding must not lose a hit on the border of a box.
    const WIDER: f32 = 1.0 + 4.0 * f32::EPSILON;
    let low = (Vec3::from(node.low) - from) * inverse;
    let high = (Vec3::from(node.high) - from) * inverse;
    let enter = low.min(high).max_element();
    let leave = low.max(high).min_element() * WIDER;
    enter <= leave && leave >= 0.0 && enter < distance
}

fn triangle([a, b, c]: [DVec3; 3]) -> Triangle {
    Triangle {
        corner: a.as_vec3().to_array(),
        opacity: OPAQUE,
        edge1: (b - a).as_vec3().to_array(),
        padding1: 0,
        edge2: (c - a).as_vec3().to_array(),
        padding2: 0,
    }
}

/// Whether a triangle has an area.
fn blocks(triangle: &Triangle) -> bool {
    let area = Vec3::from(triangle.edge1).cross(triangle.edge2.into());
    area != Vec3::ZERO && area.is_finite() && Vec3::from(triangle.corner).is_finite()
}
