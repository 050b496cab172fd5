//! What is measured in a picture, whatever it is judged by.

use super::HISTOGRAM_BINS;
pub use crate::constants::{
    BURNT, CURVATURE_LEVELS, CURVATURE_MOST, DETAIL_LEAST, DETAIL_MOST, DETAIL_SHARE,
    OUTLINE_ENOUGH, UNLIT,
};

/// Statistics of one individual's picture `I` (sRGB-encoded luminance, 0..=1) and of the light that made
/// it. What the objective does not need ([`super::Needs`]) is 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// Mean over EDGE of `min(1, |∇I| / edge_contrast)`; 0 without EDGE pixels.
    pub edge_contrast: f32,
    /// Mean of `I` over the object.
    pub mean: f32,
    /// Variance of `I` over the object.
    pub variance: f32,
    /// `G`, mean of `|∇I|` over SURFACE; 0 without SURFACE pixels.
    pub gradient: f32,
    /// Object pixels in each bin.
    pub histogram: [u32; HISTOGRAM_BINS],
    /// `Σ w·min(1, |∇I| / max(0.35·|∇n|, 0.004)) / Σ w` over SURFACE with `w = min(|∇n|, 0.5)`; 0 where
    /// the sum of the weights is.
    pub detail: f32,
    /// Share of the object's pixels with any sRGB-encoded channel at [`BURNT`] or above.
    pub burnt: f32,
    /// Share of the object's pixels whose irradiance is below [`UNLIT`].
    pub unlit: f32,
    /// Of the encoded irradiance over the object.
    pub irradiance: Irradiance,
    /// Mean of `(I − T)²` over the pixels that the target picture `T` tells.
    pub residual: f32,
    /// Mean of `1 − min(1, |I − B| / 0.2)` over the object pixels of which one of the eight neighbours in the
    /// picture shows the background, of luminance `B`; 0 without any.
    pub outline: f32,
    /// Unit vector towards the first key light, light frame; 0 without any.
    pub key: [f32; 3],
    /// Entropy of the histogram in which each pixel counts by the curvature of the surface, nats; 0 where nothing
    /// curves. Its weight is `63·min(1, |∇n| / 4G_n)`, rounded, over SURFACE, 0 elsewhere.
    pub entropy: f32,
}

/// Moments of `e = sRGB(min(1, E))` over the object, `E` the diffuse irradiance of all lights: 1 where a
/// white matt surface would show white.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Irradiance {
    /// Mean.
    pub mean: f32,
    /// Variance.
    pub variance: f32,
    /// Covariances with the components `n_x` and `n_y` of the normal in the light frame.
    pub covariance: [f32; 2],
}

/// What a pixel counts in the histogram by curvature, 0 to [`CURVATURE_LEVELS`], where the normals' gradient is `|∇n|`
/// and its mean over SURFACE `G_n`.
pub fn curvature_level(gradient: f32, mean: f32) -> u8 {
    let share = (gradient / (CURVATURE_MOST * mean).max(1e-30)).min(1.0);
    (share * CURVATURE_LEVELS as f32 + 0.5) as u8
}

/// Entropy of a histogram, nats; 0 of an empty one.
pub fn entropy(histogram: &[u64; HISTOGRAM_BINS]) -> f32 {
    let total = histogram.iter().sum::<u64>() as f64;
    let shares = histogram.iter().filter(|&&count| count > 0).map(|&count| count as f64 / total);
    shares.map(|p| -p * p.ln()).sum::<f64>() as f32
}
