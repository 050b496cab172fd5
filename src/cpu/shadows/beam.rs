//! Parallel rays of a tile of pixels walk the tree together: what a node's box is tested against is the
//! beam of all of them, and a triangle is tested against all rays of those parts of the tile that it can block at once.
//! What does not depend on the direction is found out once for a tile.

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
const PART_LANES: usize = (PART[0] * PART[1]) as usize;

/// Parts of a tile.
const PARTS: usize = LANES / PART_LANES;

/// Covers what rounding moves, scene radii.
const SLACK: f32 = 2e-6;

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

/// Up to [`BOXES`] triangles side by side, number by number: a corner, both edges.
struct Triangles {
    numbers: [[f32; BOXES]; 9],
    opacity: [u32; BOXES],
    len: usize,
}

impl Triangles {
    /// None yet.
    #[inline(always)]
    fn new() -> Self {
        Self { numbers: [[0.0; BOXES]; 9], opacity: [OPAQUE; BOXES], len: 0 }
    }

    /// Adds one, where there is room.
    #[inline(always)]
    fn push(&mut self, triangle: &Triangle) {
        for axis in 0..3 {
            self.numbers[axis][self.len] = triangle.corner[axis];
            self.numbers[3 + axis][self.len] = triangle.edge1[axis];
            self.numbers[6 + axis][self.len] = triangle.edge2[axis];
        }
        self.opacity[self.len] = triangle.opacity;
        self.len += 1;
    }

    /// What [`Plane::new`] makes of each; the determinant is 0 where it makes none.
    #[inline(always)]
    fn planes(&self, direction: [f32; 3]) -> Planes {
        let mut planes = Planes { numbers: [[0.0; BOXES]; 13] };
        for k in 0..BOXES {
            let numbers = &self.numbers;
            let vector =
                |first: usize| [numbers[first][k], numbers[first + 1][k], numbers[first + 2][k]];
            let plane = Plane::turned(vector(0), [vector(3), vector(6)], direction);
            let Plane { corner: [a, b, c], u: [d, e, f], v: [g, h, i], t: [l, m, n], det } = plane;
            let numbers = [a, b, c, d, e, f, g, h, i, l, m, n, det];
            planes.numbers.iter_mut().zip(numbers).for_each(|(row, number)| row[k] = number);
        }
        planes
    }

    /// Which of them any ray of the beam's parts can meet: of triangle `k` and part `p` bit `k·PARTS + p`.
    #[inline(always)]
    fn met(&self, beam: &Beam) -> u64 {
        let numbers = &self.numbers;
        let vector = |first: usize| beam.axes.map(|axis| &numbers[first + axis]);
        let (corner, edge1, edge2) = (vector(0), vector(3), vector(6));
        let mut met = [0u32; BOXES];
        for k in 0..BOXES {
            let across = |side: usize| {
                let of = |vector: &[&[f32; BOXES]; 3]| {
                    vector[1 + side][k] - beam.shear[side] * vector[0][k]
                };
                let (a, b, c) = (of(&corner), of(&edge1), of(&edge2));
                [a + smaller(smaller(b, c), 0.0), a + larger(larger(b, c), 0.0)]
            };
            let (x, y) = (across(0), across(1));
            let along = |vector: &[&[f32; BOXES]; 3]| beam.sign * vector[0][k];
            let end = along(&corner) + larger(larger(along(&edge1), along(&edge2)), 0.0);
            for (part, bounds) in beam.parts.iter().enumerate() {
                met[k] |= u32::from(bounds.meet([x, y], end)) << part;
            }
        }
        let bits = |all, (k, &met): (usize, &u32)| all | u64::from(met) << (k * PARTS);
        met[..self.len].iter().enumerate().fold(0, bits)
    }
}

/// Planes side by side, number by number.
struct Planes {
    numbers: [[f32; BOXES]; 13],
}

impl Planes {
    #[inline(always)]
    fn get(&self, k: usize) -> Plane {
        let numbers = &self.numbers;
        let vector =
            |first: usize| [numbers[first][k], numbers[first + 1][k], numbers[first + 2][k]];
        Plane { corner: vector(0), u: vector(3), v: vector(6), t: vector(9), det: numbers[12][k] }
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

/// What a tile's rays of one direction fill. Along the direction all is projected onto the plane of the two axes that it
/// is not mainly along.
struct Beam {
    direction: [f32; 3],
    /// The axis that the direction is mainly along, and the two others.
    axes: [usize; 3],
    /// 1 where it points along the first axis, -1 against it.
    sign: f32,
    /// How far it leads along each of the two others for a step along the first.
    shear: [f32; 2],
    all: Bounds,
    parts: [Bounds; PARTS],
    /// Sides of a box: the one that the beam leaves last, and along the first axis those that are projected to the low
    /// and the high bound of each of the others.
    last: usize,
    low: [usize; 2],
    high: [usize; 2],
}

/// Bounds of rays: in the plane, and where along the direction's main axis the first one starts.
#[derive(Clone, Copy)]
struct Bounds {
    low: [f32; 2],
    high: [f32; 2],
    start: f32,
}

impl Bounds {
    const NONE: Self =
        Self { low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2], start: f32::INFINITY };

    /// Whether rays can meet what lies between these bounds in the plane, and ends at `end`.
    #[inline(always)]
    fn meet(&self, [x, y]: [[f32; 2]; 2], end: f32) -> bool {
        (x[0] <= self.high[0])
            & (x[1] >= self.low[0])
            & (y[0] <= self.high[1])
            & (y[1] >= self.low[1])
            & (end >= self.start)
    }

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        let [low, high] = [0, 1].map(|side| {
            [smaller(self.low[side], other.low[side]), larger(self.high[side], other.high[side])]
        });
        Self {
            low: [low[0], high[0]],
            high: [low[1], high[1]],
            start: smaller(self.start, other.start),
        }
    }
}

impl Beam {
    /// Of the rays that are `waiting`.
    #[inline(always)]
    fn new(tile: &Tile, direction: Vec3, waiting: &[u32; LANES]) -> Self {
        let [x, y, z] = direction.abs().to_array();
        let main = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
        let axes = [main, (main + 1) % 3, (main + 2) % 3];
        let direction = direction.to_array();
        let sign = if direction[main] < 0.0 { -1.0 } else { 1.0 };
        let shear = [direction[axes[1]] / direction[main], direction[axes[2]] / direction[main]];
        let origin = axes.map(|axis| &tile.origin[axis]);
        let mut parts = [Bounds::NONE; PARTS];
        for (part, bounds) in parts.iter_mut().enumerate() {
            let first = part * PART_LANES;
            let (mut start, mut low) = ([0.0; PART_LANES], [[0.0; PART_LANES]; 2]);
            let mut high = low;
            for k in 0..PART_LANES {
                let (lane, on) = (first + k, waiting[first + k] != 0);
                start[k] = if on { sign * origin[0][lane] } else { f32::INFINITY };
                for side in 0..2 {
                    let at = origin[1 + side][lane] - shear[side] * origin[0][lane];
                    low[side][k] = if on { at } else { f32::INFINITY };
                    high[side][k] = if on { at } else { f32::NEG_INFINITY };
                }
            }
            *bounds = Bounds {
                low: [first_of(&low[0], smaller) - SLACK, first_of(&low[1], smaller) - SLACK],
                high: [first_of(&high[0], larger) + SLACK, first_of(&high[1], larger) + SLACK],
                start: first_of(&start, smaller) - SLACK,
            };
        }
        let sides = |shear: f32| if shear > 0.0 { [3 + main, main] } else { [main, 3 + main] };
        let [x, y] = [sides(shear[0]), sides(shear[1])];
        Self {
            direction,
            axes,
            sign,
            shear,
            all: parts.iter().fold(Bounds::NONE, |all, part| all.union(part)),
            parts,
            last: if sign > 0.0 { 3 + main } else { main },
            low: [x[0], y[0]],
            high: [x[1], y[1]],
        }
    }

    /// Which boxes any of the rays can meet, a bit for each.
    #[inline(always)]
    fn meets(&self, boxes: &Boxes) -> u32 {
        let row = |side: usize| &boxes.sides[side];
        let low = [0, 1].map(|side| [row(self.axes[1 + side]), row(self.low[side])]);
        let high = [0, 1].map(|side| [row(3 + self.axes[1 + side]), row(self.high[side])]);
        let last = row(self.last);
        let mut met = [0; BOXES];
        for (k, met) in met.iter_mut().enumerate() {
            let across = |side: usize| {
                let of = |[own, main]: [&[f32; BOXES]; 2]| own[k] - self.shear[side] * main[k];
                [of(low[side]), of(high[side])]
            };
            *met = u32::from(self.all.meet([across(0), across(1)], self.sign * last[k])) << k;
        }
        met.into_iter().fold(0, |bits, bit| bits | bit) & ((1 << boxes.len) - 1)
    }
}

/// Of some numbers the one that `pick` picks, of two at a time.
#[inline(always)]
fn first_of(numbers: &[f32; PART_LANES], pick: impl Fn(f32, f32) -> f32) -> f32 {
    let [a, b, c, d, e, f, g, h] = *numbers;
    let (a, b, c, d) = (pick(a, e), pick(b, f), pick(c, g), pick(d, h));
    pick(pick(a, c), pick(b, d))
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
    if none(&waiting) {
        return;
    }
    let beam = Beam::new(tile, d, &waiting);
    for triangles in &surroundings.near {
        block(tile, &beam, triangles, tree.occluders(), &mut waiting);
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
    let planes = triangles.planes(beam.direction);
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
            // A selection would become a masked store, which takes some processors forty times as long.
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
