//! Histogram of a picture's brightness over the object.

use crate::objective::maps::{Maps, PixelType};
use crate::objective::{HISTOGRAM_BINS, curvature_level};

/// Object pixels in each bin; `I` falls in bin `min(31, floor(32·I))`.
pub fn histogram(maps: &Maps, picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    let mut bins = [0; HISTOGRAM_BINS];
    for (&kind, &i) in maps.types.iter().zip(picture) {
        if kind != PixelType::Background {
            bins[bin_of(i)] += 1;
        }
    }
    bins
}

/// What the object pixels in each bin count by curvature ([`curvature_level`]).
pub fn by_curvature(maps: &Maps, picture: &[f32]) -> [u64; HISTOGRAM_BINS] {
    let mut bins = [0; HISTOGRAM_BINS];
    for (&gradient, &i) in maps.normal_gradient.iter().zip(picture) {
        bins[bin_of(i)] += u64::from(curvature_level(gradient, maps.normal_detail));
    }
    bins
}

fn bin_of(i: f32) -> usize {
    ((i * HISTOGRAM_BINS as f32) as usize).min(HISTOGRAM_BINS - 1)
}
