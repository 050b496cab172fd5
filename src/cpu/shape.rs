//! The shape that a view shows, in a few numbers.

use crate::math::color::luminance;
use crate::objective::DETAIL_MOST;
use crate::objective::maps::{PixelType, Shape, Surface};
use glam::Vec3;

/// The shape of the object pixels of a surface; all 0 without any.
pub fn shape(surface: &Surface, types: &[PixelType], normal_gradient: &[f32]) -> Shape {
    let object = || (0..types.len()).filter(|&at| types[at] != PixelType::Background);
    let count = object().count().max(1) as f64;
    let mean_of = |value: &dyn Fn(usize) -> f64| object().map(value).sum::<f64>() / count;
    let n = |at: usize, axis: usize| f64::from(surface.normal[at][axis]);
    let mean = [0, 1].map(|axis| mean_of(&|at| n(at, axis)));
    let covariance = [(0, 0), (0, 1), (1, 1)]
        .map(|(a, b)| mean_of(&|at| (n(at, a) - mean[a]) * (n(at, b) - mean[b])));
    let weight = normal_gradient.iter().map(|&g| f64::from(g.min(DETAIL_MOST))).sum::<f64>();
    let base = mean_of(&|at| luminance(Vec3::from(surface.base_color[at])).into());
    Shape {
        normal_mean: mean.map(|x| x as f32),
        normal_covariance: covariance.map(|x| x as f32),
        detail_weight: weight as f32,
        base_luminance: base as f32,
    }
}
