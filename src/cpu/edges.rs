//! Sobel and Laplace filters of the depth, whose thresholds make the edge map (Ha and Olivier 2006,
//! after Shacked and Lischinski 2001).

use super::neighbourhood::{laplace, repeated, sobel};
use crate::objective::maps::Surface;
use rayon::prelude::*;

/// Length of the depth's Sobel pair and the depth's Laplacian, one entry a pixel each; the picture's
/// border repeats.
pub fn depth_gradients(surface: &Surface) -> (Vec<f32>, Vec<f32>) {
    let gradients = (0..surface.depth.len()).into_par_iter().map(|at| {
        let taps =
            repeated(surface.width, surface.height, at).map(|tap| f64::from(surface.depth[tap]));
        let [x, y] = sobel(taps);
        ((x * x + y * y).sqrt() as f32, laplace(taps) as f32)
    });
    let mut result = (Vec::new(), Vec::new());
    gradients.unzip_into_vecs(&mut result.0, &mut result.1);
    result
}
