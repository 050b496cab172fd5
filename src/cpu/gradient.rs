//! Gradients of a picture: distinctness of its edges and detail of its shading.

use super::neighbourhood::{sobel, within_object};
use crate::objective::maps::{Maps, PixelType};
use crate::objective::{DETAIL_LEAST, DETAIL_MOST, DETAIL_SHARE, Objective};

/// Mean over EDGE of `min(1, |∇I| / edge_contrast)` and mean over SURFACE of `|∇I|`; 0 for a type
/// without pixels.
pub fn gradient(maps: &Maps, picture: &[f32], objective: &Objective) -> (f32, f32) {
    let (mut edge, mut surface) = (0.0, 0.0);
    for (at, &kind) in maps.types.iter().enumerate() {
        match kind {
            PixelType::Background => {}
            PixelType::Surface => surface += length(maps, picture, at),
            PixelType::Edge => {
                let contrast = length(maps, picture, at) / f64::from(objective.edge_contrast);
                edge += contrast.min(1.0);
            }
        }
    }
    let mean = |sum: f64, count: u32| (sum / f64::from(count.max(1))) as f32;
    (mean(edge, maps.counts.edge), mean(surface, maps.counts.surface))
}

/// Share of the shape's detail that the picture shows: `Σ w·min(1, |∇I| / max(0.35·|∇n|, 0.004)) / Σ w`
/// over SURFACE with `w = min(|∇n|, 0.5)`; 0 where the weights' sum is.
pub fn detail(maps: &Maps, picture: &[f32]) -> f32 {
    let (mut seen, mut total) = (0.0, 0.0);
    for (at, &gradient) in maps.normal_gradient.iter().enumerate() {
        if maps.types[at] == PixelType::Surface {
            let enough = f64::from((DETAIL_SHARE * gradient).max(DETAIL_LEAST));
            let weight = f64::from(gradient.min(DETAIL_MOST));
            seen += weight * (length(maps, picture, at) / enough).min(1.0);
            total += weight;
        }
    }
    if total > 0.0 { (seen / total) as f32 } else { 0.0 }
}

/// `|∇I|` at pixel `at`; a tap outside the object or the picture takes the centre's value.
fn length(maps: &Maps, picture: &[f32], at: usize) -> f64 {
    let taps = within_object(&maps.types, maps.surface.width, maps.surface.height, at);
    let [x, y] = sobel(taps.map(|tap| f64::from(picture[tap])));
    x.hypot(y)
}
