//! The polygons that can be seen.

use rayon::prelude::*;

/// Colour codes that occur in `code`, ascending, without the background.
pub fn visible(code: &[u32]) -> Vec<u32> {
    let mut visible = code.to_vec();
    // Neighbours often show the same polygon.
    visible.dedup();
    visible.par_sort_unstable();
    visible.dedup();
    visible.retain(|&code| code != 0);
    visible
}
