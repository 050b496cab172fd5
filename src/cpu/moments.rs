//! Mean and variance of a picture's brightness over the object.

use crate::objective::maps::{Maps, PixelType};

/// Mean and variance of `I` over the object; both 0 without object pixels.
pub fn moments(maps: &Maps, picture: &[f32]) -> (f32, f32) {
    let object = || {
        let pixels = maps.types.iter().zip(picture);
        pixels.filter(|&(&kind, _)| kind != PixelType::Background).map(|(_, &i)| f64::from(i))
    };
    let count = f64::from(maps.counts.object());
    if count == 0.0 {
        return (0.0, 0.0);
    }
    let mean = object().sum::<f64>() / count;
    let variance = object().map(|i| (i - mean) * (i - mean)).sum::<f64>() / count;
    (mean as f32, variance as f32)
}
