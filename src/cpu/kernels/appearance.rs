//! Sums over what the lights do: the irradiance, burnt-out and unlit pixels, a target picture; and over the
//! detail that is seen.

use super::super::compact::{LANES, Lanes, Run, Shaped, Taps};
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
        let mut lanes = AppearanceLanes::default();
        let mut groups = block.chunks_exact_mut(LANES);
        let (mut xs, mut ys) = (xs.chunks_exact(LANES), ys.chunks_exact(LANES));
        for ((e, x), y) in (&mut groups).zip(&mut xs).zip(&mut ys) {
            lanes.add(e, [x, y], least);
        }
        lanes.add(groups.into_remainder(), [xs.remainder(), ys.remainder()], least);
        sums.burnt += lanes.burnt.iter().sum::<u32>();
        sums.unlit += lanes.unlit.iter().sum::<u32>();
        for (sum, lanes) in sums.covariance.iter_mut().zip(&lanes.covariance) {
            *sum += total(lanes);
        }
    }
    sums
}

/// [`AppearanceSums`] in lanes.
#[derive(Default)]
struct AppearanceLanes {
    burnt: [u32; LANES],
    unlit: [u32; LANES],
    covariance: [Lanes; 2],
}

impl AppearanceLanes {
    /// Adds up to [`LANES`] pixels.
    #[inline(always)]
    fn add(&mut self, irradiance: &mut [f32], normals: [&[f32]; 2], least: f32) {
        let mut e = lanes(irradiance, 1.0);
        for (k, e) in e.iter_mut().enumerate() {
            let white = *e < 0.0;
            *e = if white { -1.0 - *e } else { *e };
            self.burnt[k] += u32::from(white);
            self.unlit[k] += u32::from(*e < least);
        }
        for (covariance, normals) in self.covariance.iter_mut().zip(normals) {
            let (n, mut sum) = (lanes(normals, 0.0), *covariance);
            for k in 0..LANES {
                sum[k] = e[k].mul_add(n[k], sum[k]);
            }
            *covariance = sum;
        }
        irradiance.copy_from_slice(&e[..irradiance.len()]);
    }
}

/// Up to [`LANES`] numbers; what is missing is `rest`.
#[inline(always)]
fn lanes(numbers: &[f32], rest: f32) -> Lanes {
    let mut lanes = [rest; LANES];
    lanes[..numbers.len()].copy_from_slice(numbers);
    lanes
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
        let mut squares = [0.0; LANES];
        let (mut groups, mut targets) = (picture.chunks_exact(LANES), target.chunks_exact(LANES));
        for (picture, target) in (&mut groups).zip(&mut targets) {
            add_residual(&mut squares, picture, target);
        }
        add_residual(&mut squares, groups.remainder(), targets.remainder());
        sum += total(&squares);
    }
    sum
}

/// Adds up to [`LANES`] pixels.
#[inline(always)]
fn add_residual(squares: &mut Lanes, picture: &[f32], target: &[f32]) {
    let (picture, target) = (lanes(picture, 0.0), lanes(target, -1.0));
    let mut sums = *squares;
    for k in 0..LANES {
        let off = if target[k] >= 0.0 { picture[k] - target[k] } else { 0.0 };
        sums[k] = off.mul_add(off, sums[k]);
    }
    *squares = sums;
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
            add_detail(&squares[..part], shaped, &mut sums);
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
    let mut tapped = [Shaped::default(); BLOCK];
    for (taps, at) in taps.chunks(BLOCK).zip(at.chunks(BLOCK)) {
        let squares = &mut squares[..taps.len()];
        for (one, taps) in squares.iter_mut().zip(taps) {
            *one = square(taps.map(|tap| picture[tap as usize]));
        }
        let tapped = &mut tapped[..at.len()];
        for (tapped, &at) in tapped.iter_mut().zip(at) {
            *tapped = shaped[at as usize];
        }
        add_detail(squares, tapped, &mut sums);
    }
    sums
}

/// Adds [`BLOCK`] pixels at most.
#[inline(always)]
fn add_detail(squares: &[f32], shaped: &[Shaped], sums: &mut [f64; 2]) {
    let mut added = [[0.0f32; LANES]; 2];
    let (mut groups, mut shaped) = (squares.chunks_exact(LANES), shaped.chunks_exact(LANES));
    for (squares, shaped) in (&mut groups).zip(&mut shaped) {
        add_group(&mut added, squares, shaped);
    }
    add_group(&mut added, groups.remainder(), shaped.remainder());
    for (sum, lanes) in sums.iter_mut().zip(&added) {
        *sum += total(lanes);
    }
}

/// Adds up to [`LANES`] pixels.
#[inline(always)]
fn add_group(added: &mut [Lanes; 2], squares: &[f32], shaped: &[Shaped]) {
    let squares = lanes(squares, 0.0);
    let mut weights = [Shaped::default(); LANES];
    weights[..shaped.len()].copy_from_slice(shaped);
    let [mut seen, mut lengths] = *added;
    for k in 0..LANES {
        let Shaped { weight, scale } = weights[k];
        let length = squares[k] * reciprocal_sqrt(squares[k]) / 8.0;
        let share = length * scale;
        seen[k] = weight.mul_add(if share < 1.0 { share } else { 1.0 }, seen[k]);
        lengths[k] += length;
    }
    *added = [seen, lengths];
}

#[inline(always)]
fn total(lanes: &Lanes) -> f64 {
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}
