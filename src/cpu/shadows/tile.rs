//! Parallel rays of a tile of pixels walk the tree together: what a node's box is tested against is the
//! beam of all of them (`beam.rs`), and a triangle is tested against all rays of those parts of the tile that it can block
//! at once. What does not depend on the direction is found out once for a tile.

use super::beam::{Beam, Triangles};
use super::wide::{BOXES, Boxes, Child, Tree};
use super::{Direction, PART, TILE, rays};
use crate::constants::OPAQUE;
use crate::objective::maps::Surface;
use crate::scene::occluders::{Occluders, Plane, Triangle, leave};
use glam::Vec3;
use multiversion::multiversion;

/// Rays of a tile, at most.
pub const LANES: usize = (TILE[0] * TILE[1]) as usize;

/// Rays of a part of a tile, which are tested together.
pub const PART_LANES: usize = (PART[0] * PART[1]) as usize;

/// Parts of a tile.
pub const PARTS: usize = LANES / PART_LANES;

/// Triangles at a tile beyond which a packet of rays from each pixel is faster than beams of all pixels.
const DENSE: usize = 80;

type Numbers = [f32; LANES];

/// Where the rays of a tile start.
#[derive(Debug, Clone)]
pub struct Tile {
    origin: [Numbers; 3],
    face: [Numbers; 3],
    low: [f32; 3],
    high: [f32; 3],
}

impl Tile {
    /// Of object pixels, [`LANES`] at most and 1 at least. Lanes beyond them repeat the first.
    pub fn new(surface: &Surface, pixels: &[u32]) -> Self {
        let mut tile = Self {
            origin: [[0.0; LANES]; 3],
            face: [[0.0; LANES]; 3],
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        };
        for lane in 0..LANES {
            let at = pixels.get(lane).copied().unwrap_or(pixels[0]) as usize;
            let face = surface.face[at];
            let from = leave(surface.position[at].into(), face.into());
            for axis in 0..3 {
                tile.origin[axis][lane] = from[axis];
                tile.face[axis][lane] = face[axis];
                tile.low[axis] = tile.low[axis].min(from[axis]);
                tile.high[axis] = tile.high[axis].max(from[axis]);
            }
        }
        tile
    }

    /// Where a lane's ray starts.
    pub fn origin(&self, lane: usize) -> Vec3 {
        Vec3::from(self.origin.each_ref().map(|numbers| numbers[lane]))
    }

    /// The unit normal of a lane's polygon, turned to the viewer.
    pub fn face(&self, lane: usize) -> Vec3 {
        Vec3::from(self.face.each_ref().map(|numbers| numbers[lane]))
    }

    fn overlaps(&self, [low, high]: [[f32; 3]; 2]) -> bool {
        (0..3).all(|axis| low[axis] <= self.high[axis] && high[axis] >= self.low[axis])
    }

    /// Whether a point lies above the horizon of any pixel.
    fn any_above(&self, p: Vec3) -> bool {
        (0..LANES).any(|lane| self.face(lane).dot(p - self.origin(lane)) > 0.0)
    }

    /// Whether any part of a box does.
    fn any_box_above(&self, corners: [[f32; 3]; 2]) -> bool {
        let [low, high] = corners.map(Vec3::from);
        (0..LANES).any(|lane| {
            let face = self.face(lane);
            let top = Vec3::select(face.cmpgt(Vec3::ZERO), high, low);
            face.dot(top - self.origin(lane)) > 0.0
        })
    }

    /// Whether any corner of a triangle does; what lies below all horizons never blocks.
    fn any_corner_above(&self, triangle: &Triangle) -> bool {
        let a = Vec3::from(triangle.corner);
        let corners = [a, a + Vec3::from(triangle.edge1), a + Vec3::from(triangle.edge2)];
        corners.into_iter().any(|corner| self.any_above(corner))
    }
}

/// What a tile's rays can meet, whatever their direction.
struct Surroundings {
    /// Triangles in leaves that the tile itself touches.
    near: Vec<Triangles>,
    /// Largest parts of the tree that the tile does not touch.
    far: Vec<Boxes>,
}

impl Surroundings {
    /// `None` where the tile touches more than [`DENSE`] triangles.
    fn new(tile: &Tile, tree: &Tree) -> Option<Self> {
        let mut near: Vec<&Triangle> = Vec::new();
        let mut far: Vec<Boxes> = Vec::new();
        let mut waiting: Vec<&Boxes> = tree.nodes.first().into_iter().collect();
        while let Some(boxes) = waiting.pop() {
            for (corners, child) in boxes.iter() {
                if tile.overlaps(corners) {
                    match child {
                        Child::Inner(at) => waiting.push(&tree.nodes[at as usize]),
                        Child::Leaf(first, count) => {
                            let triangles = tree.triangles(first, count).iter();
                            near.extend(triangles.filter(|one| tile.any_corner_above(one)));
                        }
                    }
                    if near.len() > DENSE {
                        return None;
                    }
                } else if tile.any_box_above(corners) {
                    if far.last().is_none_or(|boxes| boxes.len == BOXES) {
                        far.push(Boxes::new());
                    }
                    far.last_mut()?.push(corners, child);
                }
            }
        }
        let side_by_side = |some: &[&Triangle]| {
            let mut triangles = Triangles::new();
            some.iter().for_each(|triangle| triangles.push(triangle));
            triangles
        };
        Some(Self { near: near.chunks(BOXES).map(side_by_side).collect(), far })
    }
}

/// [`LANES`] numbers for each word of a pixel, of which lane `k`'s is the word of pixel `k`. No part of the
/// directions has more than a packet of rays.
pub fn trace(tile: &Tile, tree: &Tree, directions: &[Vec<Direction>], words: usize) -> Vec<u32> {
    let Some(surroundings) = Surroundings::new(tile, tree) else {
        return rays::trace(tile, tree.occluders(), directions, words);
    };
    let mut bits = vec![0; words * LANES];
    let mut next = Vec::new();
    for direction in directions.iter().flatten() {
        let mut free = [0; LANES];
        let to = (direction.towards, &mut next);
        trace_direction(tile, &surroundings, tree, to, &mut free);
        let word = &mut bits[direction.word * LANES..][..LANES];
        for (word, free) in word.iter_mut().zip(free) {
            *word |= free << direction.bit;
        }
    }
    bits
}

/// 1 for each lane whose ray is free, else 0. `next` is room for the numbers of nodes.
#[multiversion(targets = "simd")]
fn trace_direction(
    tile: &Tile,
    surroundings: &Surroundings,
    tree: &Tree,
    (d, next): (Vec3, &mut Vec<u32>),
    free: &mut [u32; LANES],
) {
    // Below the polygon's own horizon nothing is looked for.
    let mut waiting = [0u32; LANES];
    for lane in 0..LANES {
        let [x, y, z] = &tile.face;
        let above = x[lane] * d.x + y[lane] * d.y + z[lane] * d.z > 0.0;
        waiting[lane] = u32::from(above);
        free[lane] = u32::from(!above);
    }
    if none(&waiting) {
        return;
    }
    let beam = Beam::new(&tile.origin, d, &waiting);
    for triangles in &surroundings.near {
        block(tile, &beam, triangles, tree.occluders(), &mut waiting);
    }
    if none(&waiting) {
        return;
    }
    walk(tile, &beam, tree, (&surroundings.far, next), &mut waiting);
    for (free, waiting) in free.iter_mut().zip(waiting) {
        *free |= waiting;
    }
}

/// Takes the rays out that meet anything in boxes.
#[inline(always)]
fn walk(
    tile: &Tile,
    beam: &Beam,
    tree: &Tree,
    (far, next): (&[Boxes], &mut Vec<u32>),
    waiting: &mut [u32; LANES],
) {
    let mut found = Triangles::new();
    for mut boxes in far {
        next.clear();
        loop {
            let mut met = beam.meets(boxes);
            while met != 0 {
                let child = met.trailing_zeros() as usize;
                met &= met - 1;
                match boxes.children[child] {
                    Child::Inner(at) => next.push(at),
                    Child::Leaf(first, count) => {
                        for triangle in tree.triangles(first, count) {
                            if found.len == BOXES {
                                block(tile, beam, &found, tree.occluders(), waiting);
                                if none(waiting) {
                                    return;
                                }
                                found.len = 0;
                            }
                            found.push(triangle);
                        }
                    }
                }
            }
            let Some(at) = next.pop() else { break };
            boxes = &tree.nodes[at as usize];
        }
    }
    block(tile, beam, &found, tree.occluders(), waiting);
}

#[inline(always)]
fn none(waiting: &[u32; LANES]) -> bool {
    waiting.iter().fold(0, |all, one| all | one) == 0
}

/// Takes the rays out that meet triangles.
#[inline(always)]
fn block(
    tile: &Tile,
    beam: &Beam,
    triangles: &Triangles,
    occluders: &Occluders,
    waiting: &mut [u32; LANES],
) {
    let mut met = triangles.met(beam);
    if met == 0 {
        return;
    }
    let planes = triangles.planes(beam);
    while met != 0 {
        let k = met.trailing_zeros() as usize / PARTS;
        let parts = (met >> (k * PARTS)) as u32 & ((1 << PARTS) - 1);
        met &= !(((1 << PARTS) - 1) << (k * PARTS));
        let plane = planes.get(k);
        if plane.det == 0.0 {
            continue;
        }
        if triangles.opacity[k] == OPAQUE {
            block_parts(tile, &plane, parts, waiting);
        } else {
            block_where_opaque(tile, &plane, triangles.opacity[k], occluders, waiting);
        }
    }
}

/// Takes those rays of some parts out that meet a triangle.
#[inline(always)]
fn block_parts(tile: &Tile, plane: &Plane, mut parts: u32, waiting: &mut [u32; LANES]) {
    let [x, y, z] = &tile.origin;
    while parts != 0 {
        let first = PART_LANES * (parts.trailing_zeros() as usize % PARTS);
        parts &= parts - 1;
        for lane in first..first + PART_LANES {
            let met = plane.meet([x[lane], y[lane], z[lane]]).is_inside(f32::INFINITY);
            // A selection would become a masked store, which is slow on AMD's processors.
            waiting[lane] &= u32::from(!met);
        }
    }
}

/// The same with a triangle that has an alpha mask.
#[inline(never)]
fn block_where_opaque(
    tile: &Tile,
    plane: &Plane,
    cells: u32,
    occluders: &Occluders,
    waiting: &mut [u32; LANES],
) {
    for (lane, waiting) in waiting.iter_mut().enumerate() {
        let meeting = plane.meet(tile.origin(lane).to_array());
        let blocked = *waiting != 0 && meeting.is_inside(f32::INFINITY);
        if blocked && occluders.is_opaque(cells, meeting.barycentric()) {
            *waiting = 0;
        }
    }
}
