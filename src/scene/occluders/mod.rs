//! What blocks light: all triangles of a scene, in a bounding volume hierarchy.

mod halves;
mod opacity;
mod packet;
mod tree;

pub use packet::{Packet, RAYS};

use super::Scene;
use super::view::View;
use crate::constants::{OPAQUE, SHADOW_OFFSET};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3, Vec3};
use opacity::Opacity;
use rayon::prelude::*;

/// Most triangles; a node of the tree has room for their numbers.
pub const MAX_TRIANGLES: usize = 1 << 27;

/// What distances to the far sides of boxes are multiplied with: rounding must not lose a hit on their border.
const WIDER: f32 = 1.0 + 4.0 * f32::EPSILON;

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

/// Rays of one direction prepared for a triangle: barycentric coordinates and the distance are linear in
/// their origin (Möller and Trumbore 1997, with the determinants turned round).
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// The triangle's corner.
    pub corner: [f32; 3],
    /// `d×e2`, of the sign that makes `det` positive; so are the next two.
    pub u: [f32; 3],
    /// `e1×d`.
    pub v: [f32; 3],
    /// `e1×e2`.
    pub t: [f32; 3],
    /// `e1·(d×e2)`.
    pub det: f32,
}

/// Where a ray meets a triangle's plane: barycentric coordinates and distance, all times `det`.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    u: f32,
    v: f32,
    t: f32,
    det: f32,
}

impl Meeting {
    /// Whether it is in the triangle, in front of the origin and nearer than `distance`.
    #[inline(always)]
    pub fn is_inside(&self, distance: f32) -> bool {
        let Self { u, v, t, det } = *self;
        (u >= 0.0) & (v >= 0.0) & (u + v <= det) & (t > 0.0) & (t < distance * det)
    }

    /// The second and the third barycentric coordinate.
    #[inline(always)]
    pub fn barycentric(&self) -> [f32; 2] {
        [self.u / self.det, self.v / self.det]
    }
}

impl Plane {
    /// Of rays along `direction`, for the triangle of a corner and two edges; `det` is 0 where they run along it.
    #[inline(always)]
    pub fn new(corner: [f32; 3], [e1, e2]: [[f32; 3]; 2], direction: [f32; 3]) -> Self {
        let u = cross(direction, e2);
        let det = dot(e1, u);
        let sign = if det < 0.0 { -1.0 } else { 1.0 };
        let turned = |a: [f32; 3]| [a[0] * sign, a[1] * sign, a[2] * sign];
        let (v, t) = (turned(cross(e1, direction)), turned(cross(e1, e2)));
        Self { corner, u: turned(u), v, t, det: det * sign }
    }

    /// Where the ray from `origin` meets it.
    #[inline(always)]
    pub fn meet(&self, origin: [f32; 3]) -> Meeting {
        let [x, y, z] = origin;
        let s = [x - self.corner[0], y - self.corner[1], z - self.corner[2]];
        Meeting { u: dot(s, self.u), v: dot(s, self.v), t: dot(s, self.t), det: self.det }
    }
}

#[inline(always)]
fn dot([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> f32 {
    ax * bx + ay * by + az * bz
}

#[inline(always)]
fn cross([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> [f32; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
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

    /// The same in the light frame of another view of the scene, of the same centre and radius, which `turn` leads into.
    /// The tree keeps its shape, and its boxes are fitted anew, which takes a small part of the time of [`Occluders::new`].
    #[must_use]
    pub fn turned(&self, turn: DMat3) -> Self {
        let turned = |v: [f32; 3]| (turn * Vec3::from(v).as_dvec3()).as_vec3().to_array();
        let triangle = |old: &Triangle| Triangle {
            corner: turned(old.corner),
            edge1: turned(old.edge1),
            edge2: turned(old.edge2),
            ..*old
        };
        let triangles: Vec<_> = self.triangles.par_iter().map(triangle).collect();
        let nodes = tree::fitted(&self.nodes, &triangles);
        Self { nodes, triangles, opacity: self.opacity.clone() }
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
        // The numbers of a `Plane`, bit by bit; most rays miss at the first coordinate.
        let (e1, e2, d) = (triangle.edge1, triangle.edge2, direction.to_array());
        let p = cross(d, e2);
        let det = dot(e1, p);
        let sign = if det < 0.0 { -1.0 } else { 1.0 };
        let s = (from - Vec3::from(triangle.corner)).to_array();
        let (u, det) = (sign * dot(s, p), sign * det);
        if det == 0.0 || !(0.0..=det).contains(&u) {
            return false;
        }
        let v = sign * dot(s, cross(e1, d));
        let meeting = Meeting { u, v, t: sign * dot(s, cross(e1, e2)), det };
        let opaque = || {
            triangle.opacity == OPAQUE || self.is_opaque(triangle.opacity, meeting.barycentric())
        };
        meeting.is_inside(distance) && opaque()
    }

    /// Whether the cell at the second and third barycentric coordinate of an alpha mask blocks.
    pub fn is_opaque(&self, cells: u32, [u, v]: [f32; 2]) -> bool {
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
fn inverse(direction: Vec3) -> Vec3 {
    const LEAST: f32 = 1e-12;
    let safe = |c: f32| if c.abs() < LEAST { LEAST.copysign(c) } else { c };
    Vec3::new(safe(direction.x), safe(direction.y), safe(direction.z)).recip()
}

/// Whether a ray meets a node's box before `distance`.
#[inline(always)]
fn reaches(node: &Node, from: Vec3, inverse: Vec3, distance: f32) -> bool {
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
