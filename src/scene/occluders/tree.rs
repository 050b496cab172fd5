//! The bounding volume hierarchy, as obvhs builds it (Meister and Bittner 2018), in depth-first order.

use super::{Node, Triangle, halves};
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb};
use rayon::prelude::*;
use std::time::Duration;

/// Most triangles of a leaf.
pub const LEAF: u32 = 4;

/// So many triangles cost little time in whatever way they lie.
const FEW: usize = 10_000;

/// The clustering merges neighbours that are each other's nearest. Where boxes lie in one another, or on each
/// other, there is one such pair in each of its passes over all, and the time is quadratic: no part of an
/// ordinary scene is so for as many neighbours as these.
const CLIMB: usize = 1024;

impl Boundable for Triangle {
    fn aabb(&self) -> Aabb {
        let a = Vec3::from(self.corner);
        let corners = [a, a + Vec3::from(self.edge1), a + Vec3::from(self.edge2)];
        Aabb::from_points(&corners.map(Vec3A::from))
    }
}

/// The nodes, and the triangles' numbers in the order of the leaves. Of triangles that lie on each other
/// one may stand for all.
pub fn build(triangles: &[Triangle]) -> (Vec<Node>, Vec<u32>) {
    if triangles.is_empty() {
        return Default::default();
    }
    if triangles.len() > FEW {
        let mut order = sorted(triangles);
        if longest_climb(triangles, &order) > CLIMB {
            order.dedup_by_key(|at| triangles[*at as usize]);
            return halves::build(triangles, order);
        }
    }
    let settings = BvhBuildParams { max_prims_per_leaf: LEAF, ..BvhBuildParams::medium_build() };
    let tree = build_bvh2(triangles, settings, &mut Duration::default());
    flatten(&tree)
}

fn flatten(tree: &Bvh2) -> (Vec<Node>, Vec<u32>) {
    let mut nodes = Vec::with_capacity(tree.nodes.len());
    let mut order = Vec::with_capacity(tree.primitive_indices.len());
    // Inner nodes come twice: the second time, all below them stand in the list.
    enum Step {
        Enter(u32),
        Leave(usize),
    }
    let mut steps = vec![Step::Enter(0)];
    while let Some(step) = steps.pop() {
        let at = match step {
            Step::Leave(at) => {
                let end = nodes.len() as u32;
                let node: &mut Node = &mut nodes[at];
                node.skip = end;
                continue;
            }
            Step::Enter(at) => at,
        };
        let node = &tree.nodes[at as usize];
        let count = node.prim_count as usize;
        let triangles = match count {
            0 => Node::INNER,
            _ => order.len() as u32 | (count as u32 - 1) << 27,
        };
        let bounds = node.aabb();
        let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
        nodes.push(Node { low, skip: nodes.len() as u32 + 1, high, triangles });
        let first = node.first_index as usize;
        if count == 0 {
            steps.push(Step::Leave(nodes.len() - 1));
            steps.extend([Step::Enter(first as u32 + 1), Step::Enter(first as u32)]);
        } else {
            order.extend(&tree.primitive_indices[first..first + count]);
        }
    }
    (nodes, order)
}

/// The nodes with the boxes of `triangles` in the place of those that the tree was built of.
pub fn fitted(nodes: &[Node], triangles: &[Triangle]) -> Vec<Node> {
    let mut fitted = nodes.to_vec();
    // What is below a node stands behind it: its two children are the next node and the one after all below that.
    for at in (0..nodes.len()).rev() {
        let node = nodes[at];
        let bounds = match node.range() {
            range if !range.is_empty() => {
                triangles[range].iter().fold(Aabb::empty(), |all, one| all.union(&one.aabb()))
            }
            _ => {
                let children = [at + 1, nodes[at + 1].skip as usize];
                let bounds = children.map(|child| {
                    let Node { low, high, .. } = fitted[child];
                    Aabb::new(low.into(), high.into())
                });
                bounds[0].union(&bounds[1])
            }
        };
        let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
        fitted[at] = Node { low, high, ..node };
    }
    fitted
}

/// The triangles' numbers along a Z-order curve (Morton 1966) of their boxes' centres, those that lie on each
/// other side by side.
fn sorted(triangles: &[Triangle]) -> Vec<u32> {
    let all = triangles.par_iter().map(Boundable::aabb).reduce(Aabb::empty, |a, b| a.union(&b));
    let scale = ((1 << 21) - 1) as f32 / all.diagonal().max(Vec3A::splat(f32::MIN_POSITIVE));
    let key = |triangle: &Triangle| {
        let place = (triangle.aabb().center() - all.min) * scale;
        let [x, y, z] = place.to_array().map(|c| spread(c as u64));
        x << 2 | y << 1 | z
    };
    let bits = |triangle: &Triangle| bytemuck::cast::<Triangle, [u32; 12]>(*triangle);
    let mut order: Vec<(u64, u32)> =
        triangles.par_iter().enumerate().map(|(at, t)| (key(t), at as u32)).collect();
    order.par_sort_unstable_by(|a, b| {
        let same = || bits(&triangles[a.1 as usize]).cmp(&bits(&triangles[b.1 as usize]));
        a.0.cmp(&b.0).then_with(same).then(a.1.cmp(&b.1))
    });
    order.into_iter().map(|(_, at)| at).collect()
}

/// The lower 21 bits with two zeros before each.
fn spread(mut bits: u64) -> u64 {
    bits &= (1 << 21) - 1;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// Most neighbours in `order` among which no two are nearer to each other than to those beside them.
fn longest_climb(triangles: &[Triangle], order: &[u32]) -> usize {
    let cost = |pair: &[u32]| {
        let [a, b] = [pair[0], pair[1]].map(|at| triangles[at as usize].aabb());
        a.union(&b).half_area()
    };
    let (mut longest, mut run) = (0, 0);
    let mut costs = [f32::INFINITY; 2];
    for next in order.windows(2).map(cost) {
        let [before, now] = costs;
        run = if now < before && now < next { 0 } else { run + 1 };
        longest = longest.max(run);
        costs = [now, next];
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    /// A right triangle at `x` with legs of `size`.
    fn at(x: f32, size: f32) -> Triangle {
        Triangle {
            corner: [x, 0.0, 0.0],
            opacity: crate::constants::OPAQUE,
            edge1: [size, 0.0, 0.0],
            padding1: 0,
            edge2: [0.0, size, 0.0],
            padding2: 0,
        }
    }

    /// Every triangle is in a leaf whose box, and those above it, hold it.
    fn check(triangles: &[Triangle], nodes: &[Node], order: &[u32]) {
        let mut above: Vec<(usize, Aabb)> = Vec::new();
        let mut seen = 0;
        for (at, node) in nodes.iter().enumerate() {
            above.retain(|&(end, _)| end > at);
            let of = Aabb { min: Vec3A::from(node.low), max: Vec3A::from(node.high) };
            above.push((node.skip as usize, of));
            for &triangle in &order[node.range()] {
                let own = triangles[triangle as usize].aabb();
                for (_, of) in &above {
                    assert!(of.min.cmple(own.min).all() && of.max.cmpge(own.max).all());
                }
                seen += 1;
            }
        }
        assert_eq!((seen, above.iter().map(|a| a.0).max()), (order.len(), Some(nodes.len())));
    }

    #[test]
    fn triangles_that_lie_on_or_in_each_other_take_no_quadratic_time() {
        let begin = Instant::now();
        let count = 300_000;
        let same: Vec<_> = (0..count).map(|_| at(0.0, 1.0)).collect();
        let (nodes, order) = build(&same);
        assert_eq!((nodes.len(), order.len()), (1, 1));
        // All have one corner in common, and each lies in the next.
        let nested: Vec<_> = (1..=count).map(|i| at(0.0, i as f32)).collect();
        let (nodes, order) = build(&nested);
        assert_eq!(order.len(), count);
        check(&nested, &nodes, &order);
        // An ordinary part beside them.
        let mixed: Vec<_> =
            (0..count).map(|i| if i % 2 == 0 { at(0.5, 1.0) } else { at(i as f32, 0.1) }).collect();
        let (nodes, order) = build(&mixed);
        check(&mixed, &nodes, &order);
        assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
    }

    #[test]
    fn ordinary_triangles_are_clustered() {
        let size = |i: usize| 0.1 + (i * 31 % 97) as f32 / 97.0;
        let grid: Vec<_> = (0..20_000).map(|i| at((i * 7919 % 20_011) as f32, size(i))).collect();
        assert!(longest_climb(&grid, &sorted(&grid)) < CLIMB);
        let (nodes, order) = build(&grid);
        check(&grid, &nodes, &order);
        assert_eq!(order.len(), grid.len());
    }
}
