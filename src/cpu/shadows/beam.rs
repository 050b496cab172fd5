//! The beam of a tile's rays in one direction, and which boxes and triangles they can meet. What is said to be out of
//! reach is so for every ray, roundings included; what is within reach has still to be tested ray by ray.

use super::tile::{LANES, PART_LANES, PARTS};
use super::wide::{BOXES, Boxes};
use crate::constants::OPAQUE;
use crate::scene::occluders::{Plane, Triangle};
use glam::Vec3;

/// Covers what rounding moves, scene radii.
const SLACK: f32 = 2e-6;

/// What a tile's rays of one direction fill. Along the direction all is projected onto the plane of the two axes that it
/// is not mainly along.
pub struct Beam {
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
    /// Of the rays that are `waiting`, from `origin`, by axis, along the unit vector `direction`.
    #[inline(always)]
    pub fn new(origin: &[[f32; LANES]; 3], direction: Vec3, waiting: &[u32; LANES]) -> Self {
        let [x, y, z] = direction.abs().to_array();
        let main = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
        let axes = [main, (main + 1) % 3, (main + 2) % 3];
        let direction = direction.to_array();
        let sign = if direction[main] < 0.0 { -1.0 } else { 1.0 };
        let shear = [direction[axes[1]] / direction[main], direction[axes[2]] / direction[main]];
        let origin = axes.map(|axis| &origin[axis]);
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
    pub fn meets(&self, boxes: &Boxes) -> u32 {
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

/// Up to [`BOXES`] triangles side by side, number by number: a corner, both edges.
pub struct Triangles {
    numbers: [[f32; BOXES]; 9],
    /// Of each as [`Triangle::opacity`].
    pub opacity: [u32; BOXES],
    /// How many there are.
    pub len: usize,
}

impl Triangles {
    /// None yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self { numbers: [[0.0; BOXES]; 9], opacity: [OPAQUE; BOXES], len: 0 }
    }

    /// Adds one, where there is room.
    #[inline(always)]
    pub fn push(&mut self, triangle: &Triangle) {
        for axis in 0..3 {
            self.numbers[axis][self.len] = triangle.corner[axis];
            self.numbers[3 + axis][self.len] = triangle.edge1[axis];
            self.numbers[6 + axis][self.len] = triangle.edge2[axis];
        }
        self.opacity[self.len] = triangle.opacity;
        self.len += 1;
    }

    /// The plane of each for the beam's rays; the determinant is 0 where they run along it.
    #[inline(always)]
    pub fn planes(&self, beam: &Beam) -> Planes {
        let mut planes = Planes { numbers: [[0.0; BOXES]; 13] };
        for k in 0..BOXES {
            let numbers = &self.numbers;
            let vector =
                |first: usize| [numbers[first][k], numbers[first + 1][k], numbers[first + 2][k]];
            let plane = Plane::new(vector(0), [vector(3), vector(6)], beam.direction);
            let Plane { corner: [a, b, c], u: [d, e, f], v: [g, h, i], t: [l, m, n], det } = plane;
            let numbers = [a, b, c, d, e, f, g, h, i, l, m, n, det];
            planes.numbers.iter_mut().zip(numbers).for_each(|(row, number)| row[k] = number);
        }
        planes
    }

    /// Which of them any ray of the beam's parts can meet: of triangle `k` and part `p` bit `k·PARTS + p`.
    #[inline(always)]
    pub fn met(&self, beam: &Beam) -> u64 {
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
pub struct Planes {
    numbers: [[f32; BOXES]; 13],
}

impl Planes {
    /// That of triangle `k`.
    #[inline(always)]
    pub fn get(&self, k: usize) -> Plane {
        let numbers = &self.numbers;
        let vector =
            |first: usize| [numbers[first][k], numbers[first + 1][k], numbers[first + 2][k]];
        Plane { corner: vector(0), u: vector(3), v: vector(6), t: vector(9), det: numbers[12][k] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::shadows::wide::Child;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn vector(rng: &mut impl Rng, size: f32) -> Vec3 {
        Vec3::from([0; 3].map(|_| rng.random_range(-size..size)))
    }

    #[test]
    fn what_a_ray_meets_is_within_reach() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut hits, mut reached, mut boxes_met) = (0, 0, 0);
        for _ in 0..2000 {
            let place = vector(&mut rng, 0.8);
            let from = [place; LANES].map(|place| place + vector(&mut rng, 0.02));
            let origin = [0, 1, 2].map(|axis| from.map(|from| from[axis]));
            let direction = vector(&mut rng, 1.0).normalize_or(Vec3::X);
            let waiting = [0; LANES].map(|_| u32::from(rng.random_bool(0.7)));
            let beam = Beam::new(&origin, direction, &waiting);
            let (mut triangles, mut boxes) = (Triangles::new(), Boxes::new());
            let all: Vec<_> = (0..BOXES)
                .map(|_| {
                    let along = rng.random_range(-0.2..1.0) * direction;
                    let corner = place + along + vector(&mut rng, 0.1);
                    let size = if rng.random() { 0.1 } else { 0.001 };
                    let triangle = Triangle {
                        corner: corner.into(),
                        opacity: OPAQUE,
                        edge1: vector(&mut rng, size).into(),
                        padding1: 0,
                        edge2: vector(&mut rng, size).into(),
                        padding2: 0,
                    };
                    triangles.push(&triangle);
                    let ends = [triangle.edge1, triangle.edge2].map(|e| corner + Vec3::from(e));
                    let low = corner.min(ends[0]).min(ends[1]).to_array();
                    let high = corner.max(ends[0]).max(ends[1]).to_array();
                    boxes.push([low, high], Child::Leaf(0, 1));
                    triangle
                })
                .collect();
            let (met, boxes) = (triangles.met(&beam), beam.meets(&boxes));
            let planes = triangles.planes(&beam);
            for (k, triangle) in all.iter().enumerate() {
                let edges = [triangle.edge1, triangle.edge2];
                let plane = Plane::new(triangle.corner, edges, beam.direction);
                assert_ne!(plane.det, 0.0);
                for lane in (0..LANES).filter(|&lane| waiting[lane] != 0) {
                    let from = from[lane].to_array();
                    let hit = plane.meet(from).is_inside(f32::INFINITY);
                    assert_eq!(hit, planes.get(k).meet(from).is_inside(f32::INFINITY));
                    let part = lane / PART_LANES;
                    assert!(!hit || (met >> (k * PARTS + part) & 1 == 1 && boxes >> k & 1 == 1));
                    hits += u32::from(hit);
                }
            }
            reached += met.count_ones();
            boxes_met += boxes.count_ones();
        }
        assert!(hits > 10_000, "{hits}");
        // Of 128,000 parts and 32,000 boxes.
        assert!(reached < 25_000 && boxes_met < 10_000, "{reached} {boxes_met}");
    }
}
