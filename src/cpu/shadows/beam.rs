//! Parallel rays of a tile of pixels walk the tree together: what a node's box is tested against is the
//! beam of all of them, and a triangle is tested against all rays at once. What does not depend on the
//! direction is found out once for a tile.

use super::wide::{BOXES, Boxes, Child, Tree};
use super::{Direction, TILE, rays};
use crate::constants::OPAQUE;
use crate::objective::maps::Surface;
use crate::scene::occluders::{Occluders, Plane, Triangle, WIDER, inverse, leave};
use glam::Vec3;
use multiversion::multiversion;

/// Rays of a tile, at most.
pub const LANES: usize = (TILE[0] * TILE[1]) as usize;

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

/// Triangles side by side, number by number: a corner, both edges.
struct Triangles {
    numbers: [[f32; BOXES]; 9],
    opacity: [u32; BOXES],
    len: usize,
}

impl Triangles {
    /// Of up to [`BOXES`] triangles.
    fn new(triangles: &[Triangle]) -> Self {
        let mut all =
            Self { numbers: [[0.0; BOXES]; 9], opacity: [OPAQUE; BOXES], len: triangles.len() };
        for (k, triangle) in triangles.iter().enumerate() {
            for axis in 0..3 {
                all.numbers[axis][k] = triangle.corner[axis];
                all.numbers[3 + axis][k] = triangle.edge1[axis];
                all.numbers[6 + axis][k] = triangle.edge2[axis];
            }
            all.opacity[k] = triangle.opacity;
        }
        all
    }

    /// What [`Plane::new`] makes of each; the determinant is 0 where it makes none.
    #[inline(always)]
    fn planes(&self, direction: [f32; 3]) -> Planes {
        let mut planes = Planes { numbers: [[0.0; BOXES]; 13] };
        for k in 0..BOXES {
            let vector = |first: usize| [0, 1, 2].map(|axis| self.numbers[first + axis][k]);
            let plane = Plane::turned(vector(0), [vector(3), vector(6)], direction);
            let Plane { corner: [a, b, c], u: [d, e, f], v: [g, h, i], t: [l, m, n], det } = plane;
            let numbers = [a, b, c, d, e, f, g, h, i, l, m, n, det];
            planes.numbers.iter_mut().zip(numbers).for_each(|(row, number)| row[k] = number);
        }
        planes
    }
}

/// Planes side by side, number by number.
struct Planes {
    numbers: [[f32; BOXES]; 13],
}

impl Planes {
    #[inline(always)]
    fn get(&self, k: usize) -> Plane {
        let vector = |first: usize| [0, 1, 2].map(|at| self.numbers[first + at][k]);
        Plane {
            corner: vector(0),
            u: vector(3),
            v: vector(6),
            t: vector(9),
            det: self.numbers[12][k],
        }
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
        let mut near = Vec::new();
        let mut far: Vec<Boxes> = Vec::new();
        let mut waiting: Vec<&Boxes> = tree.nodes.first().into_iter().collect();
        while let Some(boxes) = waiting.pop() {
            for (corners, child) in boxes.iter() {
                if tile.overlaps(corners) {
                    match child {
                        Child::Inner(at) => waiting.push(&tree.nodes[at as usize]),
                        Child::Leaf(leaf) => near.extend(
                            tree.triangles(leaf).iter().filter(|one| tile.any_corner_above(one)),
                        ),
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
        let near = near.chunks(BOXES).map(Triangles::new);
        Some(Self { near: near.collect(), far })
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

/// A direction as the tree is walked along it by a tile.
struct Beam {
    direction: [f32; 3],
    inverse: [f32; 3],
    /// Which of a box's sides are the near and the far one, by axis.
    near: [usize; 3],
    far: [usize; 3],
    /// The corners of the tile's box that reach the near side last and the far side first.
    last: [f32; 3],
    first: [f32; 3],
}

impl Beam {
    #[inline(always)]
    fn new(tile: &Tile, direction: Vec3) -> Self {
        let inverse = inverse(direction).to_array();
        let mut beam = Self {
            direction: direction.to_array(),
            inverse,
            near: [0, 1, 2],
            far: [3, 4, 5],
            last: tile.high,
            first: tile.low,
        };
        for (axis, inverse) in inverse.into_iter().enumerate() {
            if inverse < 0.0 {
                (beam.near[axis], beam.far[axis]) = (3 + axis, axis);
                (beam.last[axis], beam.first[axis]) = (tile.low[axis], tile.high[axis]);
            }
        }
        beam
    }

    /// Which boxes any ray of the tile's box can meet, a bit for each.
    #[inline(always)]
    fn meets(&self, boxes: &Boxes) -> u32 {
        let near = self.near.map(|side| &boxes.sides[side]);
        let far = self.far.map(|side| &boxes.sides[side]);
        let mut met = [0; BOXES];
        for (k, met) in met.iter_mut().enumerate() {
            let enter = |axis: usize| (near[axis][k] - self.last[axis]) * self.inverse[axis];
            let leave = |axis: usize| (far[axis][k] - self.first[axis]) * self.inverse[axis];
            let entered = larger(larger(enter(0), enter(1)), enter(2));
            let left = smaller(smaller(leave(0), leave(1)), leave(2)) * WIDER;
            *met = u32::from((entered <= left) & (left >= 0.0)) << k;
        }
        met.into_iter().fold(0, |bits, bit| bits | bit) & ((1 << boxes.len) - 1)
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
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
    if waiting == [0; LANES] {
        return;
    }
    let beam = Beam::new(tile, d);
    for triangles in &surroundings.near {
        block_near(tile, &beam, triangles, tree.occluders(), &mut waiting);
    }
    for boxes in &surroundings.far {
        if waiting == [0; LANES] {
            return;
        }
        walk(tile, &beam, tree, (boxes, next), &mut waiting);
    }
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
    (mut boxes, next): (&Boxes, &mut Vec<u32>),
    waiting: &mut [u32; LANES],
) {
    next.clear();
    loop {
        let mut met = beam.meets(boxes);
        while met != 0 {
            let child = met.trailing_zeros() as usize;
            met &= met - 1;
            match boxes.children[child] {
                Child::Leaf(leaf) => {
                    for triangle in tree.triangles(leaf) {
                        block(tile, beam, triangle, tree.occluders(), waiting);
                    }
                }
                Child::Inner(at) => next.push(at),
            }
        }
        if *waiting == [0; LANES] {
            return;
        }
        let Some(at) = next.pop() else { return };
        boxes = &tree.nodes[at as usize];
    }
}

/// Takes the rays out that meet triangles beside the tile.
#[inline(always)]
fn block_near(
    tile: &Tile,
    beam: &Beam,
    triangles: &Triangles,
    occluders: &Occluders,
    waiting: &mut [u32; LANES],
) {
    let planes = triangles.planes(beam.direction);
    for k in 0..triangles.len {
        let plane = planes.get(k);
        if plane.det != 0.0 {
            block_plane(tile, &plane, triangles.opacity[k], occluders, waiting);
        }
    }
}

/// Takes the rays out that meet a triangle.
#[inline(always)]
fn block(
    tile: &Tile,
    beam: &Beam,
    triangle: &Triangle,
    occluders: &Occluders,
    waiting: &mut [u32; LANES],
) {
    if let Some(plane) = Plane::new(triangle, beam.direction) {
        block_plane(tile, &plane, triangle.opacity, occluders, waiting);
    }
}

#[inline(always)]
fn block_plane(
    tile: &Tile,
    plane: &Plane,
    opacity: u32,
    occluders: &Occluders,
    waiting: &mut [u32; LANES],
) {
    if opacity != OPAQUE {
        return block_where_opaque(tile, plane, opacity, occluders, waiting);
    }
    let [x, y, z] = &tile.origin;
    for lane in 0..LANES {
        let met = plane.meet([x[lane], y[lane], z[lane]]).is_inside(f32::INFINITY);
        waiting[lane] = if met { 0 } else { waiting[lane] };
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
