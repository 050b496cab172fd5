//! What the light does at each pixel: burnt-out and unlit pixels, the irradiance and how it follows the
//! normals, the distance from a target picture, and the contrast with a background.

use super::neighbourhood::repeated;
use crate::math::color::srgb_encode;
use crate::objective::maps::{Maps, PixelType};
use crate::objective::{Irradiance, OUTLINE_ENOUGH, UNLIT};

/// Indices of the object's pixels.
fn object(maps: &Maps) -> impl Iterator<Item = usize> + Clone {
    (0..maps.types.len()).filter(|&at| maps.types[at] != PixelType::Background)
}

/// Share of the object's pixels that pass; 0 without object pixels.
pub fn share(maps: &Maps, pass: impl Fn(usize) -> bool) -> f32 {
    let passed = object(maps).filter(|&at| pass(at)).count();
    (passed as f64 / f64::from(maps.counts.object().max(1))) as f32
}

/// Share of the object's pixels whose encoded irradiance is below that of [`UNLIT`].
pub fn unlit(maps: &Maps, irradiance: &[f32]) -> f32 {
    let least = srgb_encode(UNLIT);
    share(maps, |at| irradiance[at] < least)
}

/// Moments of the encoded irradiance over the object, and its covariances with the normals.
pub fn irradiance(maps: &Maps, irradiance: &[f32]) -> Irradiance {
    let count = f64::from(maps.counts.object().max(1));
    let mean_of = |value: &dyn Fn(usize) -> f64| object(maps).map(value).sum::<f64>() / count;
    let e = |at: usize| f64::from(irradiance[at]);
    let mean = mean_of(&e);
    let variance = mean_of(&|at| (e(at) - mean).powi(2));
    let covariance = [0, 1].map(|axis| {
        let n = |at: usize| f64::from(maps.surface.normal[at][axis]);
        mean_of(&|at| (e(at) - mean) * (n(at) - f64::from(maps.shape.normal_mean[axis]))) as f32
    });
    Irradiance { mean: mean as f32, variance: variance as f32, covariance }
}

/// Mean of `(I − T)²` over the object's pixels that the target tells; 0 where it tells none.
pub fn residual(maps: &Maps, picture: &[f32]) -> f32 {
    let told = object(maps).filter(|&at| maps.target.get(at).is_some_and(|&t| t >= 0.0));
    let count = told.clone().count().max(1) as f64;
    let squares = told.map(|at| (f64::from(picture[at]) - f64::from(maps.target[at])).powi(2));
    (squares.sum::<f64>() / count) as f32
}

/// Whether object pixel `at` has a neighbour, of the eight in the picture, that shows the background.
pub fn is_outline(maps: &Maps, at: usize) -> bool {
    let around = repeated(maps.surface.width, maps.surface.height, at);
    around.into_iter().any(|tap| maps.types[tap] == PixelType::Background)
}

/// Mean of `1 − min(1, |I − B| / 0.2)` over the outline's pixels, `B` the background's encoded luminance; 0 without
/// any.
pub fn outline(maps: &Maps, picture: &[f32], background: f32) -> f32 {
    let outline = object(maps).filter(|&at| is_outline(maps, at));
    let merged = |at: usize| {
        let distance = (f64::from(picture[at]) - f64::from(background)).abs();
        1.0 - (distance / f64::from(OUTLINE_ENOUGH)).min(1.0)
    };
    let count = outline.clone().count().max(1) as f64;
    (outline.map(merged).sum::<f64>() / count) as f32
}
