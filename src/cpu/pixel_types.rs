//! Sorts the pixels into edges, other object pixels and background.

use crate::objective::Objective;
use crate::objective::maps::PixelType;

/// The type of each pixel: EDGE where an object pixel's depth exceeds both thresholds of `objective`,
/// SURFACE for other object pixels (`code` ≠ 0).
pub fn classify(
    code: &[u32],
    sobel: &[f32],
    laplace: &[f32],
    objective: &Objective,
) -> Vec<PixelType> {
    let jumps = |sobel: f32, laplace: f32| {
        sobel > objective.edge_sobel && laplace.abs() > objective.edge_laplace
    };
    code.iter()
        .zip(sobel)
        .zip(laplace)
        .map(|((&code, &sobel), &laplace)| match code {
            0 => PixelType::Background,
            _ if jumps(sobel, laplace) => PixelType::Edge,
            _ => PixelType::Surface,
        })
        .collect()
}
