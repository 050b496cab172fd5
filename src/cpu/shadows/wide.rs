//! The tree of the occluders with many children side by side: what a beam is tested against is then one vector
//! of boxes at a time.

use crate::scene::occluders::{Node, Occluders, Triangle};

/// Most children of a node.
pub const BOXES: usize = 16;

/// What a box holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// A node of [`Tree::nodes`].
    Inner(u32),
    /// The triangles of a leaf: the number of the first in [`Occluders::triangles`], and how many there are.
    Leaf(u32, u32),
}

/// Up to [`BOXES`] boxes, axis by axis.
#[derive(Debug, Clone)]
pub struct Boxes {
    /// Lowest coordinates along the three axes, then highest ones.
    pub sides: [[f32; BOXES]; 6],
    /// What is in them.
    pub children: [Child; BOXES],
    /// How many there are.
    pub len: usize,
}

impl Boxes {
    /// None yet.
    pub fn new() -> Self {
        Self { sides: [[0.0; BOXES]; 6], children: [Child::Leaf(0, 0); BOXES], len: 0 }
    }

    /// Adds one.
    ///
    /// # Panics
    /// Beyond [`BOXES`].
    pub fn push(&mut self, [low, high]: [[f32; 3]; 2], child: Child) {
        for axis in 0..3 {
            self.sides[axis][self.len] = low[axis];
            self.sides[3 + axis][self.len] = high[axis];
        }
        self.children[self.len] = child;
        self.len += 1;
    }

    /// Lowest and highest corner of each box, and what is in it.
    pub fn iter(&self) -> impl Iterator<Item = ([[f32; 3]; 2], Child)> {
        let corner = |first: usize, k: usize| [0, 1, 2].map(|axis| self.sides[first + axis][k]);
        (0..self.len).map(move |k| ([corner(0, k), corner(3, k)], self.children[k]))
    }
}

/// The occluders' tree, of the same leaves.
pub struct Tree<'a> {
    occluders: &'a Occluders,
    /// The root first; none where nothing blocks light.
    pub nodes: Vec<Boxes>,
}

impl<'a> Tree<'a> {
    /// Each node's boxes are those found by opening the largest one below it, time and again.
    pub fn new(occluders: &'a Occluders) -> Self {
        let mut tree = Self { occluders, nodes: Vec::new() };
        if !occluders.nodes.is_empty() {
            tree.add(0);
        }
        // Nodes behind this one are not linked to their children yet.
        let mut at = 0;
        while at < tree.nodes.len() {
            for k in 0..tree.nodes[at].len {
                let Child::Inner(below) = tree.nodes[at].children[k] else { continue };
                tree.nodes[at].children[k] = Child::Inner(tree.nodes.len() as u32);
                tree.add(below);
            }
            at += 1;
        }
        tree
    }

    /// The `count` triangles of a leaf, of which `first` is the first.
    #[inline(always)]
    pub fn triangles(&self, first: u32, count: u32) -> &'a [Triangle] {
        &self.occluders.triangles[first as usize..][..count as usize]
    }

    /// What casts the shadows.
    pub fn occluders(&self) -> &'a Occluders {
        self.occluders
    }

    /// Adds the node of what is below a node of the occluders, whose inner children have the numbers that they have there.
    fn add(&mut self, root: u32) {
        let nodes = &self.occluders.nodes;
        let mut open = vec![root];
        while open.len() < BOXES {
            let inner = |&at: &usize| nodes[open[at] as usize].triangles == Node::INNER;
            let area = |&at: &usize| half_area(&nodes[open[at] as usize]);
            let inner = (0..open.len()).filter(inner);
            let Some(at) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let first = open.swap_remove(at) + 1;
            open.extend([first, nodes[first as usize].skip]);
        }
        let mut boxes = Boxes::new();
        for at in open {
            let node = &nodes[at as usize];
            let child = match node.triangles {
                Node::INNER => Child::Inner(at),
                _ => Child::Leaf(node.range().start as u32, node.range().len() as u32),
            };
            boxes.push([node.low, node.high], child);
        }
        self.nodes.push(boxes);
    }
}

fn half_area(node: &Node) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| node.high[axis] - node.low[axis]);
    x * y + y * z + z * x
}
