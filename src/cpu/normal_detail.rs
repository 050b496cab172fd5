//! How much detail the geometry has, against which `F_grad` measures the shading's.

use super::neighbourhood::{sobel, within_object};
use crate::objective::maps::{PixelType, Surface};
use rayon::prelude::*;

/// `G_n`: mean over SURFACE of the Frobenius length of the Sobel pair on the unit normals, a tap
/// outside the object or the picture taking the centre's value; 0 without SURFACE pixels.
pub fn normal_detail(surface: &Surface, types: &[PixelType]) -> f32 {
    let row = |y: u32| {
        let (mut sum, mut count) = (0.0, 0u32);
        let first = y as usize * surface.width as usize;
        let pixels = first..first + surface.width as usize;
        for at in pixels.filter(|&at| types[at] == PixelType::Surface) {
            let taps = within_object(types, surface.width, surface.height, at);
            let squares: f64 = (0..3)
                .flat_map(|axis| sobel(taps.map(|tap| f64::from(surface.normal[tap][axis]))))
                .map(|difference| difference * difference)
                .sum();
            sum += squares.sqrt();
            count += 1;
        }
        (sum, count)
    };
    // The rows' sums are added in order, whatever thread made them.
    let rows: Vec<_> = (0..surface.height).into_par_iter().map(row).collect();
    let sum: f64 = rows.iter().map(|row| row.0).sum();
    let count: u32 = rows.iter().map(|row| row.1).sum();
    if count == 0 { 0.0 } else { (sum / f64::from(count)) as f32 }
}
