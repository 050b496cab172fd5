//! Parallel rays of a tile of pixels walk the tree together: what a node's box is tested against is the
//! beam of all of them, and a triangle is tested against all rays at once.

use super::{Direction, TILE};
use crate::constants::OPAQUE;
use crate::objective::maps::Surface;
use crate::scene::occluders::{Node, Occluders, Plane, inverse, leave};
use glam::Vec3;
use multiversion::multiversion;

/// Rays of a tile, at most.
pub const LANES: usize = (TILE * TILE) as usize;

type Numbers = [f32; LANES];

/// Where the rays of a tile start.
#[derive(Debug, Clone)]
pub struct Tile {
    count: usize,
    origin: [Numbers; 3],
    face: [Numbers; 3],
    low: Vec3,
    high: Vec3,
}

impl Tile {
    /// Of object pixels, [`LANES`] at most and 1 at least. Lanes beyond them repeat the first.
    pub fn new(surface: &Surface, pixels: &[u32]) -> Self {
        let mut tile = Self {
            count: pixels.len(),
            origin: [[0.0; LANES]; 3],
            face: [[0.0; LANES]; 3],
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
        };
        for lane in 0..LANES {
            let at = pixels.get(lane).copied().unwrap_or(pixels[0]) as usize;
            let face = Vec3::from(surface.face[at]);
            let from = leave(surface.position[at].into(), face);
            tile.low = tile.low.min(from);
            tile.high = tile.high.max(from);
            for axis in 0..3 {
                tile.origin[axis][lane] = from[axis];
                tile.face[axis][lane] = face[axis];
            }
        }
        tile
    }
}

/// [`LANES`] numbers for each word of a pixel, of which lane `k`'s is the word of pixel `k`.
pub fn trace(
    tile: &Tile,
    occluders: &Occluders,
    directions: &[Direction],
    words: usize,
) -> Vec<u32> {
    let mut bits = vec![0; words * LANES];
    for direction in directions {
        let mut free = [0; LANES];
        trace_direction(tile, occluders, direction.towards, &mut free);
        let word = &mut bits[direction.word * LANES..][..LANES];
        for (word, free) in word.iter_mut().zip(free) {
            *word |= free << direction.bit;
        }
    }
    bits
}

/// 1 for each lane whose ray is free, else 0.
#[multiversion(targets = "simd")]
fn trace_direction(tile: &Tile, occluders: &Occluders, d: Vec3, free: &mut [u32; LANES]) {
    // Below the polygon's own horizon nothing is looked for.
    let mut waiting = [0u32; LANES];
    let mut count = 0;
    for lane in 0..LANES {
        let [x, y, z] = &tile.face;
        let above = x[lane] * d.x + y[lane] * d.y + z[lane] * d.z > 0.0;
        waiting[lane] = u32::from(above);
        free[lane] = u32::from(!above);
        count += if lane < tile.count { waiting[lane] } else { 0 };
    }
    if count == 0 {
        return;
    }
    let inverse = inverse(d);
    let mut at = 0;
    while let Some(node) = occluders.nodes.get(at) {
        if !reaches(node, tile, inverse) {
            at = node.skip as usize;
            continue;
        }
        at += 1;
        for triangle in &occluders.triangles[node.range()] {
            let Some(plane) = Plane::new(triangle, d) else { continue };
            if triangle.opacity == OPAQUE {
                block(tile, &plane, &mut waiting);
            } else {
                block_where_opaque(tile, &plane, &mut waiting, occluders, triangle.opacity);
            }
        }
        if !node.range().is_empty() && waiting == [0; LANES] {
            return;
        }
    }
    for (free, waiting) in free.iter_mut().zip(waiting) {
        *free |= waiting;
    }
}

/// Whether any ray of the tile's box can meet a node's.
#[inline(always)]
fn reaches(node: &Node, tile: &Tile, inverse: Vec3) -> bool {
    const WIDER: f32 = 1.0 + 4.0 * f32::EPSILON;
    let low = (Vec3::from(node.low) - tile.high) * inverse;
    let high = (Vec3::from(node.high) - tile.low) * inverse;
    let enter = low.min(high).max_element();
    let leave = low.max(high).min_element() * WIDER;
    enter <= leave && leave >= 0.0
}

/// Barycentric coordinates of a lane's ray, and the distance along it.
#[inline(always)]
fn meet(tile: &Tile, plane: &Plane, lane: usize) -> (f32, f32, f32) {
    let [x, y, z] = &tile.origin;
    let s = Vec3::new(x[lane], y[lane], z[lane]) - plane.corner;
    (s.dot(plane.u), s.dot(plane.v), s.dot(plane.t))
}

#[inline(always)]
fn inside(u: f32, v: f32, t: f32) -> bool {
    (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)
}

/// Takes the rays out that meet a triangle.
#[inline(always)]
fn block(tile: &Tile, plane: &Plane, waiting: &mut [u32; LANES]) {
    for (lane, waiting) in waiting.iter_mut().enumerate() {
        let (u, v, t) = meet(tile, plane, lane);
        *waiting = if inside(u, v, t) { 0 } else { *waiting };
    }
}

/// The same with a triangle that has an alpha mask.
fn block_where_opaque(
    tile: &Tile,
    plane: &Plane,
    waiting: &mut [u32; LANES],
    occluders: &Occluders,
    cells: u32,
) {
    for (lane, waiting) in waiting.iter_mut().enumerate() {
        let (u, v, t) = meet(tile, plane, lane);
        if *waiting != 0 && inside(u, v, t) && occluders.is_opaque(cells, u, v) {
            *waiting = 0;
        }
    }
}
