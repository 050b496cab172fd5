//! The bounding volume hierarchy, as obvhs builds it (Meister and Bittner 2018), in depth-first order.

use super::{Node, Triangle};
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb};
use std::time::Duration;

/// Most triangles of a leaf.
const LEAF: u32 = 4;

impl Boundable for Triangle {
    fn aabb(&self) -> Aabb {
        let a = Vec3::from(self.corner);
        let corners = [a, a + Vec3::from(self.edge1), a + Vec3::from(self.edge2)];
        Aabb::from_points(&corners.map(Vec3A::from))
    }
}

/// The nodes, and the triangles' numbers in the order of the leaves.
pub fn build(triangles: &[Triangle]) -> (Vec<Node>, Vec<u32>) {
    if triangles.is_empty() {
        return Default::default();
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
