//! Parallel rays of a tile of pixels walk the tree together: what a node's box is tested against is the
//! beam of all of them, and a triangle is tested against all rays at once. What does not depend on the
//! direction is found out once for a tile.

use super::{Direction, TILE, rays};
use crate::constants::OPAQUE;
use crate::objective::maps::Surface;
use crate::scene::occluders::{Node, Occluders, Plane, Triangle, WIDER, inverse, leave};
use glam::Vec3;
use multiversion::multiversion;
use std::ops::Range;

/// Rays of a tile, at most.
pub const LANES: usize = (TILE[0] * TILE[1]) as usize;

/// Triangles at a tile beyond which a packet of rays from each pixel is faster than beams of all pixels.
const DENSE: usize = 80;

/// Boxes that are tested side by side.
const BOXES: usize = 16;

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

    fn overlaps(&self, node: &Node) -> bool {
        (0..3).all(|axis| node.low[axis] <= self.high[axis] && node.high[axis] >= self.low[axis])
    }

    /// Whether a point lies above the horizon of any pixel.
    fn any_above(&self, p: Vec3) -> bool {
        (0..LANES).any(|lane| self.face(lane).dot(p - self.origin(lane)) > 0.0)
    }

    /// Whether any part of a node's box does.
    fn any_box_above(&self, node: &Node) -> bool {
        let (low, high) = (Vec3::from(node.low), Vec3::from(node.high));
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
    near: Vec<Triangle>,
    /// Largest subtrees that the tile does not touch: their nodes,
    far: Vec<Range<usize>>,
    /// and their boxes, by [`BOXES`]: the eight numbers of a node.
    boxes: Vec<[[f32; BOXES]; 8]>,
}

impl Surroundings {
    fn new(tile: &Tile, occluders: &Occluders) -> Self {
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let mut at = 0;
        while let Some(node) = occluders.nodes.get(at) {
            if tile.overlaps(node) {
                let triangles = occluders.triangles[node.range()].iter();
                near.extend(triangles.copied().filter(|triangle| tile.any_corner_above(triangle)));
                at += 1;
            } else {
                if tile.any_box_above(node) {
                    far.push(at..node.skip as usize);
                }
                at = node.skip as usize;
            }
        }
        let boxes = far.chunks(BOXES).map(|far| {
            // What is infinitely far away is met by nothing.
            let mut boxes = [[f32::MAX; BOXES]; 8];
            for (lane, nodes) in far.iter().enumerate() {
                let numbers: [f32; 8] = bytemuck::cast(occluders.nodes[nodes.start]);
                boxes.iter_mut().zip(numbers).for_each(|(row, number)| row[lane] = number);
            }
            boxes
        });
        Self { boxes: boxes.collect(), near, far }
    }
}

/// [`LANES`] numbers for each word of a pixel, of which lane `k`'s is the word of pixel `k`. No part of the
/// directions has more than a packet of rays.
pub fn trace(
    tile: &Tile,
    occluders: &Occluders,
    directions: &[Vec<Direction>],
    words: usize,
) -> Vec<u32> {
    let surroundings = Surroundings::new(tile, occluders);
    if surroundings.near.len() > DENSE {
        return rays::trace(tile, occluders, directions, words);
    }
    let mut bits = vec![0; words * LANES];
    for direction in directions.iter().flatten() {
        let mut free = [0; LANES];
        trace_direction(tile, &surroundings, occluders, direction.towards, &mut free);
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
    /// Where in a node's eight numbers the near and the far side of its box stand, by axis.
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
            far: [4, 5, 6],
            last: tile.high,
            first: tile.low,
        };
        for (axis, inverse) in inverse.into_iter().enumerate() {
            if inverse < 0.0 {
                (beam.near[axis], beam.far[axis]) = (4 + axis, axis);
                (beam.last[axis], beam.first[axis]) = (tile.low[axis], tile.high[axis]);
            }
        }
        beam
    }

    /// Whether any ray of the tile's box can meet a box, by its near and its far side along each axis.
    #[inline(always)]
    fn meets(&self, near: [f32; 3], far: [f32; 3]) -> bool {
        let (mut enter, mut leave) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            enter[axis] = (near[axis] - self.last[axis]) * self.inverse[axis];
            leave[axis] = (far[axis] - self.first[axis]) * self.inverse[axis];
        }
        let entered = larger(larger(enter[0], enter[1]), enter[2]);
        let left = smaller(smaller(leave[0], leave[1]), leave[2]) * WIDER;
        (entered <= left) & (left >= 0.0)
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

/// 1 for each lane whose ray is free, else 0.
#[multiversion(targets = "simd")]
fn trace_direction(
    tile: &Tile,
    surroundings: &Surroundings,
    occluders: &Occluders,
    d: Vec3,
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
    for triangle in &surroundings.near {
        block(tile, &beam, triangle, occluders, &mut waiting);
    }
    for (boxes, far) in surroundings.boxes.iter().zip(surroundings.far.chunks(BOXES)) {
        let mut reached = [0u32; BOXES];
        let [near_x, near_y, near_z] = [0, 1, 2].map(|axis| &boxes[beam.near[axis] & 7]);
        let [far_x, far_y, far_z] = [0, 1, 2].map(|axis| &boxes[beam.far[axis] & 7]);
        for lane in 0..BOXES {
            let near = [near_x[lane], near_y[lane], near_z[lane]];
            let far = [far_x[lane], far_y[lane], far_z[lane]];
            reached[lane] = u32::from(beam.meets(near, far));
        }
        for (nodes, _) in far.iter().zip(reached).filter(|&(_, reached)| reached != 0) {
            if waiting == [0; LANES] {
                return;
            }
            walk(tile, &beam, occluders, nodes, &mut waiting);
        }
    }
    for (free, waiting) in free.iter_mut().zip(waiting) {
        *free |= waiting;
    }
}

/// Takes the rays out that meet anything of a subtree.
#[inline(always)]
fn walk(
    tile: &Tile,
    beam: &Beam,
    occluders: &Occluders,
    nodes: &Range<usize>,
    waiting: &mut [u32; LANES],
) {
    let mut at = nodes.start;
    while at < nodes.end {
        let node = &occluders.nodes[at];
        let numbers: &[f32; 8] = bytemuck::cast_ref(node);
        let near =
            [numbers[beam.near[0] & 7], numbers[beam.near[1] & 7], numbers[beam.near[2] & 7]];
        let far = [numbers[beam.far[0] & 7], numbers[beam.far[1] & 7], numbers[beam.far[2] & 7]];
        if !beam.meets(near, far) {
            at = node.skip as usize;
            continue;
        }
        at += 1;
        if node.triangles == Node::INNER {
            continue;
        }
        for triangle in &occluders.triangles[node.range()] {
            block(tile, beam, triangle, occluders, waiting);
        }
        if *waiting == [0; LANES] {
            return;
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
    let Some(plane) = Plane::new(triangle, beam.direction) else { return };
    if triangle.opacity != OPAQUE {
        return block_where_opaque(tile, &plane, triangle.opacity, occluders, waiting);
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
