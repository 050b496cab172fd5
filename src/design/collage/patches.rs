//! Patches of the visible surface between its creases: a watershed of the curvature (Mangan and Whitaker 1999), as in
//! *Light Collages*, on the pixels of a view.

use crate::cpu::neighbourhood::around;
use crate::objective::maps::{Maps, PixelType};

/// How much the curvature has to rise between two patches for them to be two, as a share of its largest.
const RISE: f32 = 0.08;
/// Least share of the object's pixels that is a patch.
const LEAST: f32 = 0.004;
/// Patch of a pixel that has none.
pub const NONE: u32 = u32::MAX;

/// The patch of each pixel, [`NONE`] in the background, and how many there are. `curvature` has 0 to 1 for each pixel.
pub fn patches(maps: &Maps, curvature: &[f32]) -> (Vec<u32>, usize) {
    let surface = |&at: &usize| maps.types[at] == PixelType::Surface;
    let mut order: Vec<usize> = (0..maps.types.len()).filter(surface).collect();
    order.sort_by(|&a, &b| curvature[a].total_cmp(&curvature[b]));
    let least = LEAST * maps.counts.object() as f32;
    let mut basins = Basins::default();
    let mut labels = vec![NONE; maps.types.len()];
    for &at in &order {
        let near = around(maps.surface.width, maps.surface.height, at);
        let mut beside: Vec<u32> =
            near.filter(|&tap| labels[tap] != NONE).map(|tap| labels[tap]).collect();
        beside.iter_mut().for_each(|label| *label = basins.root(*label));
        beside.sort_unstable_by_key(|&label| (basins.size_order(label), label));
        beside.dedup();
        // The largest basin beside it takes the pixel, and with it those that are too shallow or too small to stay.
        let Some((&own, others)) = beside.split_first() else {
            labels[at] = basins.add(curvature[at]);
            continue;
        };
        for &other in others {
            let floor = basins.floor[own as usize].max(basins.floor[other as usize]);
            let rise = curvature[at] - floor;
            if rise < RISE || (basins.size[other as usize] as f32) < least {
                basins.join(own, other);
            }
        }
        labels[at] = own;
        basins.size[own as usize] += 1;
    }
    let mut numbers = vec![NONE; basins.parent.len()];
    let mut count = 0;
    for at in order {
        let root = basins.root(labels[at]) as usize;
        if (basins.size[root] as f32) < least {
            labels[at] = NONE;
            continue;
        }
        if numbers[root] == NONE {
            numbers[root] = count;
            count += 1;
        }
        labels[at] = numbers[root];
    }
    spread(maps, &mut labels);
    // What no patch reaches is a patch of its own.
    let mut rest = 0;
    for (label, kind) in labels.iter_mut().zip(&maps.types) {
        if *label == NONE && *kind != PixelType::Background {
            (*label, rest) = (count, 1);
        }
    }
    (labels, (count + rest) as usize)
}

/// Gives object pixels without a patch that of the neighbour that is nearest in depth, from pixel to pixel.
fn spread(maps: &Maps, labels: &mut [u32]) {
    let (width, height, depth) = (maps.surface.width, maps.surface.height, &maps.surface.depth);
    let without =
        |at: usize, labels: &[u32]| maps.types[at] != PixelType::Background && labels[at] == NONE;
    let mut left: Vec<usize> = (0..labels.len()).filter(|&at| without(at, labels)).collect();
    while !left.is_empty() {
        let nearest = |&at: &usize| {
            let known = around(width, height, at).filter(|&tap| labels[tap] != NONE);
            let apart = |tap: usize| (depth[tap] - depth[at]).abs();
            known.min_by(|&a, &b| apart(a).total_cmp(&apart(b))).map(|tap| (at, labels[tap]))
        };
        let found: Vec<(usize, u32)> = left.iter().filter_map(nearest).collect();
        if found.is_empty() {
            break;
        }
        found.iter().for_each(|&(at, label)| labels[at] = label);
        left.retain(|&at| labels[at] == NONE);
    }
}

/// Basins that join each other.
#[derive(Default)]
struct Basins {
    parent: Vec<u32>,
    /// Pixels of each.
    size: Vec<u32>,
    /// Lowest curvature of each.
    floor: Vec<f32>,
}

impl Basins {
    fn add(&mut self, floor: f32) -> u32 {
        let label = self.parent.len() as u32;
        self.parent.push(label);
        self.size.push(1);
        self.floor.push(floor);
        label
    }

    fn root(&mut self, label: u32) -> u32 {
        let mut root = label;
        while self.parent[root as usize] != root {
            let above = self.parent[self.parent[root as usize] as usize];
            self.parent[root as usize] = above;
            root = above;
        }
        root
    }

    /// Descending by size.
    fn size_order(&self, root: u32) -> std::cmp::Reverse<u32> {
        std::cmp::Reverse(self.size[root as usize])
    }

    fn join(&mut self, root: u32, other: u32) {
        self.parent[other as usize] = root;
        self.size[root as usize] += self.size[other as usize];
        let floor = self.floor[root as usize].min(self.floor[other as usize]);
        self.floor[root as usize] = floor;
    }
}
