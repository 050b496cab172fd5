//! Rays that walk the tree together, because they start and point nearly alike.

use super::{Node, Occluders, Triangle, WIDER, cross, dot, inverse};
use crate::constants::OPAQUE;
use glam::Vec3;
use multiversion::multiversion;

/// Most rays of a packet.
pub const RAYS: usize = 16;

type Numbers = [f32; RAYS];

/// Up to [`RAYS`] rays.
#[derive(Debug, Clone, Default)]
pub struct Packet {
    len: usize,
    from: [Numbers; 3],
    direction: [Numbers; 3],
    inverse: [Numbers; 3],
    distance: Numbers,
}

impl Packet {
    /// Adds a ray, as [`Occluders::blocked`] takes it.
    ///
    /// # Panics
    /// Beyond [`RAYS`] rays.
    pub fn push(&mut self, from: Vec3, direction: Vec3, distance: f32) {
        let (ray, inverse) = (self.len, inverse(direction));
        for axis in 0..3 {
            self.from[axis][ray] = from[axis];
            self.direction[axis][ray] = direction[axis];
            self.inverse[axis][ray] = inverse[axis];
        }
        self.distance[ray] = distance;
        self.len += 1;
    }

    /// The second and the third barycentric coordinate of where a ray meets a triangle.
    fn barycentric(&self, triangle: &Triangle, ray: usize) -> [f32; 2] {
        let d = [0, 1, 2].map(|axis| self.direction[axis][ray]);
        let s = [0, 1, 2].map(|axis| self.from[axis][ray] - triangle.corner[axis]);
        let p = cross(d, triangle.edge2);
        let det = dot(triangle.edge1, p);
        [dot(s, p) / det, dot(s, cross(triangle.edge1, d)) / det]
    }
}

impl Occluders {
    /// What [`Occluders::blocked`] says of every ray of a packet: bit `k` of ray `k`.
    pub fn blocked_rays(&self, packet: &Packet) -> u32 {
        walk(self, packet)
    }
}

#[multiversion(targets = "simd")]
fn walk(occluders: &Occluders, packet: &Packet) -> u32 {
    let mut waiting = [0u32; RAYS];
    waiting[..packet.len].fill(1);
    let mut at = 0;
    while let Some(node) = occluders.nodes.get(at) {
        let reached = reaches(packet, node, &waiting);
        if reached == [0; RAYS] {
            at = node.skip as usize;
            continue;
        }
        at += 1;
        if node.triangles == Node::INNER {
            continue;
        }
        for triangle in &occluders.triangles[node.range()] {
            let mut met = hits(packet, triangle, &reached);
            if triangle.opacity != OPAQUE {
                for (ray, met) in met.iter_mut().enumerate().filter(|(_, met)| **met != 0) {
                    let place = packet.barycentric(triangle, ray);
                    *met = u32::from(occluders.is_opaque(triangle.opacity, place));
                }
            }
            for (waiting, met) in waiting.iter_mut().zip(met) {
                *waiting &= !met;
            }
        }
        if waiting == [0; RAYS] {
            break;
        }
    }
    let free = |bits, ray: usize| bits | waiting[ray] << ray;
    !(0..packet.len).fold(0, free) & ((1 << packet.len) - 1)
}

/// 1 for each waiting ray that meets a node's box, else 0.
#[inline(always)]
fn reaches(packet: &Packet, node: &Node, waiting: &[u32; RAYS]) -> [u32; RAYS] {
    let mut reached = [0; RAYS];
    for ray in 0..RAYS {
        let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            let (from, inverse) = (packet.from[axis][ray], packet.inverse[axis][ray]);
            let (low, high) =
                ((node.low[axis] - from) * inverse, (node.high[axis] - from) * inverse);
            let (near, far) = if low < high { (low, high) } else { (high, low) };
            enter = if enter > near { enter } else { near };
            leave = if leave < far { leave } else { far };
        }
        let leave = leave * WIDER;
        let meets = (enter <= leave) & (leave >= 0.0) & (enter < packet.distance[ray]);
        reached[ray] = u32::from(meets) & waiting[ray];
    }
    reached
}

/// 1 for each reached ray that meets a triangle, else 0.
#[inline(always)]
fn hits(packet: &Packet, triangle: &Triangle, reached: &[u32; RAYS]) -> [u32; RAYS] {
    let (corner, e1, e2) = (triangle.corner, triangle.edge1, triangle.edge2);
    let normal = cross(e1, e2);
    let mut met = [0; RAYS];
    for ray in 0..RAYS {
        let d = [0, 1, 2].map(|axis| packet.direction[axis][ray]);
        let s = [0, 1, 2].map(|axis| packet.from[axis][ray] - corner[axis]);
        let p = cross(d, e2);
        let det = dot(e1, p);
        let sign = if det < 0.0 { -1.0 } else { 1.0 };
        let (u, v) = (sign * dot(s, p), sign * dot(s, cross(e1, d)));
        let (t, det) = (sign * dot(s, normal), sign * det);
        let inside = (det > 0.0)
            & (u >= 0.0)
            & (v >= 0.0)
            & (u + v <= det)
            & (t > 0.0)
            & (t < packet.distance[ray] * det);
        met[ray] = u32::from(inside) & reached[ray];
    }
    met
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn vector(rng: &mut impl Rng, size: f32) -> Vec3 {
        Vec3::from([0; 3].map(|_| rng.random_range(-size..size)))
    }

    #[test]
    fn packets_say_what_single_rays_say() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let triangles = (0..400).map(|at| Triangle {
            corner: vector(&mut rng, 1.0).into(),
            // Every fifth has two cells on each edge, of which one in four blocks.
            opacity: if at % 5 == 0 { 0 } else { OPAQUE },
            edge1: vector(&mut rng, 0.4).into(),
            padding1: 0,
            edge2: vector(&mut rng, 0.4).into(),
            padding2: 0,
        });
        let occluders = Occluders::of_triangles(triangles.collect(), vec![2, 0b1000_0001]);
        let mut blocked = 0;
        for _ in 0..500 {
            let (from, towards) = (vector(&mut rng, 1.5), vector(&mut rng, 1.0));
            let rays: Vec<_> = (0..rng.random_range(1..=RAYS))
                .map(|_| {
                    let direction = (towards + vector(&mut rng, 0.2)).normalize_or(Vec3::X);
                    let distance = if rng.random() { f32::INFINITY } else { rng.random() };
                    (from + vector(&mut rng, 0.1), direction, distance)
                })
                .collect();
            let mut packet = Packet::default();
            rays.iter().for_each(|&(from, direction, distance)| {
                packet.push(from, direction, distance);
            });
            let single =
                rays.iter().map(|&(from, d, distance)| occluders.blocked(from, d, distance));
            let expected =
                single.enumerate().fold(0, |bits, (ray, met)| bits | u32::from(met) << ray);
            assert_eq!(occluders.blocked_rays(&packet), expected);
            blocked += expected.count_ones();
        }
        assert!((400..4000).contains(&blocked), "{blocked}");
    }
}
