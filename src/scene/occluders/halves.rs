//! A hierarchy of the halves of an order, of triangles that cannot be clustered.

use super::tree::LEAF;
use super::{Node, Triangle};
use obvhs::Boundable;
use obvhs::aabb::Aabb;

/// The nodes over triangles in the order of these numbers, and the numbers.
pub fn build(triangles: &[Triangle], order: Vec<u32>) -> (Vec<Node>, Vec<u32>) {
    let mut nodes = Vec::with_capacity(order.len());
    add(triangles, &order, 0, &mut nodes);
    (nodes, order)
}

/// Adds a node over `part`, which begins at `first` in the order, and all below it; gives its box. The depth
/// is the logarithm of the number of triangles.
fn add(triangles: &[Triangle], part: &[u32], first: u32, nodes: &mut Vec<Node>) -> Aabb {
    let at = nodes.len();
    nodes.push(Node { low: [0.0; 3], skip: 0, high: [0.0; 3], triangles: Node::INNER });
    let count = part.len() as u32;
    let bounds = if count <= LEAF {
        nodes[at].triangles = first | (count - 1) << 27;
        let boxes = part.iter().map(|&at| triangles[at as usize].aabb());
        boxes.fold(Aabb::empty(), |a, b| a.union(&b))
    } else {
        let (left, right) = part.split_at(part.len() / 2);
        let left_box = add(triangles, left, first, nodes);
        let right_box = add(triangles, right, first + left.len() as u32, nodes);
        left_box.union(&right_box)
    };
    (nodes[at].low, nodes[at].high) = (bounds.min.to_array(), bounds.max.to_array());
    nodes[at].skip = nodes.len() as u32;
    bounds
}
