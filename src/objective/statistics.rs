//! What is measured in a picture, whatever it is judged by.

use super::HISTOGRAM_BINS;
pub use crate::constants::{BURNT, DETAIL_LEAST, DETAIL_MOST, DETAIL_SHARE, OUTLINE_ENOUGH, UNLIT};

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
