//! The 3×3 neighbourhood of a pixel and the two filters on it, shared by all gradients.

use crate::objective::maps::PixelType;

/// Indices of the 3×3 neighbourhood of pixel `at`, row by row from the top; the picture's border
/// repeats.
pub fn repeated(width: u32, height: u32, at: usize) -> [usize; 9] {
    taps(width, height, at, |x, y, width, height| {
        y.clamp(0, height - 1) * width + x.clamp(0, width - 1)
    })
}

/// As [`repeated`], but a tap outside the object or the picture is the centre itself.
pub fn within_object(types: &[PixelType], width: u32, height: u32, at: usize) -> [usize; 9] {
    taps(width, height, at, |x, y, width, height| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        let index = y * width + x;
        if inside && types[index as usize] != PixelType::Background { index } else { at as i64 }
    })
}

fn taps(
    width: u32,
    height: u32,
    at: usize,
    index: impl Fn(i64, i64, i64, i64) -> i64,
) -> [usize; 9] {
    let (w, h) = (i64::from(width), i64::from(height));
    let (x, y) = (at as i64 % w, at as i64 / w);
    std::array::from_fn(|k| {
        let (dx, dy) = (k as i64 % 3 - 1, k as i64 / 3 - 1);
        index(x + dx, y + dy, w, h) as usize
    })
}

/// Sobel pair of a neighbourhood: `[-1 0 1; -2 0 2; -1 0 1]/8` and its transpose.
pub fn sobel(t: [f64; 9]) -> [f64; 2] {
    let x = (t[2] - t[0]) + 2.0 * (t[5] - t[3]) + (t[8] - t[6]);
    let y = (t[6] - t[0]) + 2.0 * (t[7] - t[1]) + (t[8] - t[2]);
    [x / 8.0, y / 8.0]
}

/// Laplacian of a neighbourhood: `[1 1 1; 1 -8 1; 1 1 1]/8`.
pub fn laplace(t: [f64; 9]) -> f64 {
    t.iter().map(|tap| tap - t[4]).sum::<f64>() / 8.0
}

/// Indices of the pixels around pixel `at`, of the eight those in the picture.
pub fn around(width: u32, height: u32, at: usize) -> impl Iterator<Item = usize> {
    repeated(width, height, at).into_iter().filter(move |&tap| tap != at)
}
