//! The polygons that can be seen.

use std::collections::BTreeSet;

/// Colour codes that occur in `code`, ascending, without the background.
pub fn visible(code: &[u32]) -> Vec<u32> {
    code.iter().copied().filter(|&code| code != 0).collect::<BTreeSet<_>>().into_iter().collect()
}
