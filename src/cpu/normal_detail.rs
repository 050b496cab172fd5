//! How much detail the geometry has, against which terms measure the shading's.

use super::neighbourhood::{sobel, within_object};
use crate::objective::maps::{PixelType, Surface};
use rayon::prelude::*;

/// `|∇n|` of each pixel, and `G_n`, its mean over SURFACE (0 without SURFACE pixels).
///
/// `|∇n|` is the Frobenius length of the Sobel pair on the unit normals, a tap outside the object or the
/// picture taking the centre's value; 0 outside SURFACE.
pub fn normal_detail(surface: &Surface, types: &[PixelType]) -> (Vec<f32>, f32) {
    let row = |y: u32| {
        let (mut sum, mut count) = (0.0, 0u32);
        let first = y as usize * surface.width as usize;
        let mut gradients = vec![0.0; surface.width as usize];
        for (at, gradient) in (first..).zip(&mut gradients) {
            if types[at] == PixelType::Surface {
                let length = length(surface, types, at);
                *gradient = length as f32;
                sum += length;
                count += 1;
            }
        }
        (gradients, sum, count)
    };
    // The rows' sums are added in order, whatever thread made them.
    let rows: Vec<_> = (0..surface.height).into_par_iter().map(row).collect();
    let sum: f64 = rows.iter().map(|row| row.1).sum();
    let count: u32 = rows.iter().map(|row| row.2).sum();
    let gradients = rows.into_iter().flat_map(|row| row.0).collect();
    (gradients, if count == 0 { 0.0 } else { (sum / f64::from(count)) as f32 })
}

fn length(surface: &Surface, types: &[PixelType], at: usize) -> f64 {
    let taps = within_object(types, surface.width, surface.height, at);
    let squares: f64 = (0..3)
        .flat_map(|axis| sobel(taps.map(|tap| f64::from(surface.normal[tap][axis]))))
        .map(|difference| difference * difference)
        .sum();
    squares.sqrt()
}
