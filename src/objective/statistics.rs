//! What is measured in a picture, whatever it is judged by.

use super::HISTOGRAM_BINS;

/// Encoded value from which on a channel counts as burnt out.
pub const BURNT: f32 = 0.985;

/// Diffuse irradiance below which a pixel counts as unlit; at 1 a white surface shows white.
pub const UNLIT: f32 = 0.05;

/// Share of the normals' gradient that the picture's gradient has to reach for a detail to be seen.
pub const DETAIL_SHARE: f32 = 0.35;

/// Least gradient of the picture at which a detail is seen, encoded units a pixel.
pub const DETAIL_LEAST: f32 = 0.004;

/// Gradient of the normals above which a detail weighs no more.
pub const DETAIL_MOST: f32 = 0.5;

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
