//! Sums over what the lights do: the irradiance, burnt-out and unlit pixels, a target picture; and over the
//! detail that is seen.

use super::super::compact::{LANES, Run, Shaped, Taps};
use super::super::fast_math::reciprocal_sqrt;
use super::statistics::{row_squares, square};
use crate::math::color::srgb_encode;
use crate::objective::UNLIT;
use multiversion::multiversion;

/// Pixels whose terms are added in single precision before a sum goes on in double precision.
const BLOCK: usize = 64 * LANES;

/// Sums over the pixels of a band.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AppearanceSums {
    /// Pixels with a channel that is burnt out.
    pub burnt: u32,
    /// Pixels of too little irradiance.
    pub unlit: u32,
    /// Of `e` times the distance of `n_x` and `n_y` from their means.
    pub covariance: [f64; 2],
}

/// Sums over a plane of irradiances as [`shade_color`](super::shade_color) leaves them, which are turned into
/// plain ones; `normals` are the distances of `n_x` and `n_y` from their means, of the same pixels.
#[multiversion(targets = "simd")]
pub fn appearance(irradiance: &mut [f32], normals: [&[f32]; 2]) -> AppearanceSums {
    appearance_in_lanes(irradiance, normals)
}

#[inline(always)]
pub(super) fn appearance_in_lanes(irradiance: &mut [f32], normals: [&[f32]; 2]) -> AppearanceSums {
    let least = srgb_encode(UNLIT);
    let mut sums = AppearanceSums::default();
    let [xs, ys] = normals;
    for ((block, xs), ys) in
        irradiance.chunks_mut(BLOCK).zip(xs.chunks(BLOCK)).zip(ys.chunks(BLOCK))
    {
        let (mut burnt, mut unlit) = ([0u32; LANES], [0u32; LANES]);
        let mut covariance = [[0.0f32; LANES]; 2];
        for (at, ((e, &x), &y)) in block.iter_mut().zip(xs).zip(ys).enumerate() {
            let k = at % LANES;
            let white = *e < 0.0;
            *e = if white { -1.0 - *e } else { *e };
            burnt[k] += u32::from(white);
            unlit[k] += u32::from(*e < least);
            covariance[0][k] = e.mul_add(x, covariance[0][k]);
            covariance[1][k] = e.mul_add(y, covariance[1][k]);
        }
        sums.burnt += burnt.iter().sum::<u32>();
        sums.unlit += unlit.iter().sum::<u32>();
        for (sum, lanes) in sums.covariance.iter_mut().zip(covariance) {
            *sum += total(&lanes);
        }
    }
    sums
}

/// Sum of `(I − T)²` over the pixels that the target `T` tells.
#[multiversion(targets = "simd")]
pub fn residual(picture: &[f32], target: &[f32]) -> f64 {
    residual_in_lanes(picture, target)
}

#[inline(always)]
pub(super) fn residual_in_lanes(picture: &[f32], target: &[f32]) -> f64 {
    let mut sum = 0.0;
    for (picture, target) in picture.chunks(BLOCK).zip(target.chunks(BLOCK)) {
        let mut lanes = [0.0f32; LANES];
        for (at, (&i, &t)) in picture.iter().zip(target).enumerate() {
            let off = if t >= 0.0 { i - t } else { 0.0 };
            lanes[at % LANES] = off.mul_add(off, lanes[at % LANES]);
        }
        sum += total(&lanes);
    }
    sum
}

/// Sums of `w·min(1, |∇I|·s)` and of `|∇I|` over runs of pixels whose neighbourhoods lie in the object;
/// `shaped` has `w` and `s` of each pixel, counted as the picture.
#[multiversion(targets = "simd")]
pub fn interior_detail(picture: &[f32], runs: &[Run], shaped: &[Shaped]) -> [f64; 2] {
    runs_detail(picture, runs, shaped)
}

#[inline(always)]
pub(super) fn runs_detail(picture: &[f32], runs: &[Run], shaped: &[Shaped]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let mut squares = [0.0; BLOCK];
    for run in runs {
        let mut done = 0;
        while done < run.len as usize {
            let part = (run.len as usize - done).min(BLOCK);
            let row = |start: u32| &picture[start as usize + done..][..part + 2];
            row_squares([row(run.above), row(run.here), row(run.below)], &mut squares[..part]);
            let shaped = &shaped[run.here as usize + 1 + done..][..part];
            add_detail(&squares[..part], shaped.iter().copied(), &mut sums);
            done += part;
        }
    }
    sums
}

/// The same over the pixels `at` that name their taps.
#[multiversion(targets = "simd")]
pub fn tapped_detail(
    picture: &[f32],
    (taps, at): (&[Taps], &[u32]),
    shaped: &[Shaped],
) -> [f64; 2] {
    taps_detail(picture, (taps, at), shaped)
}

#[inline(always)]
pub(super) fn taps_detail(
    picture: &[f32],
    (taps, at): (&[Taps], &[u32]),
    shaped: &[Shaped],
) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let mut squares = [0.0; BLOCK];
    for (taps, at) in taps.chunks(BLOCK).zip(at.chunks(BLOCK)) {
        let squares = &mut squares[..taps.len()];
        for (one, taps) in squares.iter_mut().zip(taps) {
            *one = square(taps.map(|tap| picture[tap as usize]));
        }
        add_detail(squares, at.iter().map(|&at| shaped[at as usize]), &mut sums);
    }
    sums
}

#[inline(always)]
fn add_detail(squares: &[f32], shaped: impl Iterator<Item = Shaped>, sums: &mut [f64; 2]) {
    let mut lanes = [[0.0f32; LANES]; 2];
    for (at, (&square, Shaped { weight, scale })) in squares.iter().zip(shaped).enumerate() {
        let k = at % LANES;
        let length = square * reciprocal_sqrt(square) / 8.0;
        let seen = length * scale;
        lanes[0][k] = weight.mul_add(if seen < 1.0 { seen } else { 1.0 }, lanes[0][k]);
        lanes[1][k] += length;
    }
    for (sum, lanes) in sums.iter_mut().zip(&lanes) {
        *sum += total(lanes);
    }
}

#[inline(always)]
fn total(lanes: &[f32; LANES]) -> f64 {
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}
