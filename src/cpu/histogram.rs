//! Histogram of a picture's brightness over the object.

use crate::objective::HISTOGRAM_BINS;
use crate::objective::maps::{Maps, PixelType};

/// Object pixels in each bin; `I` falls in bin `min(31, floor(32·I))`.
pub fn histogram(maps: &Maps, picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    let mut bins = [0; HISTOGRAM_BINS];
    for (&kind, &i) in maps.types.iter().zip(picture) {
        if kind != PixelType::Background {
            bins[((i * HISTOGRAM_BINS as f32) as usize).min(HISTOGRAM_BINS - 1)] += 1;
        }
    }
    bins
}
