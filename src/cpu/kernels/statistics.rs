//! Sums over pictures: brightness and gradients.

use super::super::compact::{LANES, Run, Taps};
use super::super::fast_math::reciprocal_sqrt;
use multiversion::multiversion;

/// Terms that are added in single precision before a sum goes on in double precision.
const SUM_BLOCK: usize = 64 * LANES;

/// Sum and sum of squared deviations from the mean.
#[multiversion(targets = "simd")]
pub fn moments(picture: &[f32]) -> (f64, f64) {
    moments_in_lanes(picture)
}

#[inline(always)]
pub(super) fn moments_in_lanes(picture: &[f32]) -> (f64, f64) {
    // In one pass, of what the pixels are off the mean of the first `m` of them. It lies within
    // `√(n/m)·σ` of the mean of all, so that what cancels below is small against the variance.
    let first = &picture[..picture.len().min(SUM_BLOCK)];
    let near = (sum_of(first, |i| i) / first.len().max(1) as f64) as f32;
    let (mut sum, mut squares) = (0.0, 0.0);
    for block in picture.chunks(SUM_BLOCK) {
        let (mut offs, mut off_squares) = ([0.0f32; LANES], [0.0f32; LANES]);
        let mut chunks = block.chunks_exact(LANES);
        for chunk in &mut chunks {
            for k in 0..LANES {
                add_deviation(chunk[k] - near, &mut offs[k], &mut off_squares[k]);
            }
        }
        for (k, i) in chunks.remainder().iter().enumerate() {
            add_deviation(i - near, &mut offs[k], &mut off_squares[k]);
        }
        sum += total(&offs);
        squares += total(&off_squares);
    }
    let count = picture.len() as f64;
    let off = sum / count.max(1.0);
    (count.mul_add(near.into(), sum), squares - count * off * off)
}

#[inline(always)]
fn add_deviation(off: f32, sum: &mut f32, squares: &mut f32) {
    *sum += off;
    *squares = off.mul_add(off, *squares);
}

/// Sum of `|∇I|` over runs of pixels whose neighbourhoods lie in the object.
#[multiversion(targets = "simd")]
pub fn interior_gradient(picture: &[f32], runs: &[Run]) -> f64 {
    runs_gradient(picture, runs)
}

/// Squares are gathered in a block whatever the runs' lengths, so that the roots are taken in full
/// lanes.
#[inline(always)]
pub(super) fn runs_gradient(picture: &[f32], runs: &[Run]) -> f64 {
    let mut squares = [0.0; SUM_BLOCK];
    let mut filled = 0;
    let mut total = 0.0;
    for run in runs {
        let mut done = 0;
        while done < run.len as usize {
            let part = (run.len as usize - done).min(SUM_BLOCK - filled);
            let row = |start: u32| &picture[start as usize + done..][..part + 2];
            let rows = [row(run.above), row(run.here), row(run.below)];
            row_squares(rows, &mut squares[filled..filled + part]);
            done += part;
            filled += part;
            if filled == SUM_BLOCK {
                total += lengths(&squares);
                filled = 0;
            }
        }
    }
    (total + lengths(&squares[..filled])) / 8.0
}

/// The same over the pixels between the ends of three rows.
#[inline(always)]
pub(super) fn row_squares(rows: [&[f32]; 3], squares: &mut [f32]) {
    let len = squares.len();
    if len < LANES {
        for (k, square) in squares.iter_mut().enumerate() {
            *square = square_in_rows(rows, k);
        }
        return;
    }
    // The last lanes may be taken a second time.
    for at in (0..len - LANES).step_by(LANES).chain([len - LANES]) {
        let rows = rows.map(|row| &row[at..at + LANES + 2]);
        let mut lanes = [0.0; LANES];
        for (k, square) in lanes.iter_mut().enumerate() {
            *square = square_in_rows(rows, k);
        }
        squares[at..at + LANES].copy_from_slice(&lanes);
    }
}

/// [`square`] in the pixel to the right of pixel `k` of a row.
#[inline(always)]
fn square_in_rows([a, h, b]: [&[f32]; 3], k: usize) -> f32 {
    square([a[k], a[k + 1], a[k + 2], h[k], h[k + 2], b[k], b[k + 1], b[k + 2]])
}

/// `64·|∇I|²` from the taps around a pixel, row by row.
#[inline(always)]
pub(super) fn square([a, b, c, d, f, g, h, i]: [f32; 8]) -> f32 {
    let (falling, rising) = (i - a, c - g);
    let x = 2.0f32.mul_add(f - d, falling + rising);
    let y = 2.0f32.mul_add(h - b, falling - rising);
    x.mul_add(x, y * y)
}

/// Sum of `min(most, scale·|∇I|)` over pixels that name their taps.
#[multiversion(targets = "simd")]
pub fn tapped_gradient(picture: &[f32], taps: &[Taps], scale: f32, most: f32) -> f64 {
    taps_gradient(picture, taps, scale, most)
}

#[inline(always)]
pub(super) fn taps_gradient(picture: &[f32], taps: &[Taps], scale: f32, most: f32) -> f64 {
    let scale = scale / 8.0;
    let mut total = 0.0;
    let mut squares = [0.0; SUM_BLOCK];
    for taps in taps.chunks(SUM_BLOCK) {
        let squares = &mut squares[..taps.len()];
        for (one, taps) in squares.iter_mut().zip(taps) {
            *one = square(taps.map(|tap| picture[tap as usize]));
        }
        total += sum_of(squares, |square| {
            let length = square * reciprocal_sqrt(square) * scale;
            if length < most { length } else { most }
        });
    }
    total
}

#[inline(always)]
fn lengths(squares: &[f32]) -> f64 {
    sum_of(squares, |square| square * reciprocal_sqrt(square))
}

/// Sum of `f` over at most [`SUM_BLOCK`] `values`.
#[inline(always)]
fn sum_of(values: &[f32], f: impl Fn(f32) -> f32) -> f64 {
    let mut lanes = [0.0f32; LANES];
    let mut chunks = values.chunks_exact(LANES);
    for chunk in &mut chunks {
        for k in 0..LANES {
            lanes[k] += f(chunk[k]);
        }
    }
    for (lane, &value) in lanes.iter_mut().zip(chunks.remainder()) {
        *lane += f(value);
    }
    total(&lanes)
}

#[inline(always)]
fn total(lanes: &[f32; LANES]) -> f64 {
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn exact_moments(picture: &[f32]) -> (f64, f64) {
        let sum: f64 = picture.iter().map(|&i| f64::from(i)).sum();
        let mean = sum / picture.len() as f64;
        (sum, picture.iter().map(|&i| (f64::from(i) - mean).powi(2)).sum())
    }

    #[test]
    fn moments_are_exact_enough_wherever_the_brightness_lies() {
        let mut random = ChaCha8Rng::seed_from_u64(14);
        for (mean, spread) in [(0.5, 0.5), (0.9, 0.01), (0.999, 1e-4), (0.3, 0.0)] {
            let mut picture: Vec<f32> =
                (0..40_003).map(|_| mean + spread * random.random_range(-1.0..1.0f32)).collect();
            for first in [mean, 0.0, 1.0] {
                picture[0] = first;
                let (sum, squares) = moments(&picture);
                let (exact_sum, exact_squares) = exact_moments(&picture);
                let deviation = |squares: f64| (squares.max(0.0) / 40_003.0).sqrt();
                let off = (deviation(squares) - deviation(exact_squares)).abs();
                assert!((sum - exact_sum).abs() < 1e-7 * 40_003.0, "{mean} {spread} {first}");
                assert!(off < 3e-6, "{mean} {spread} {first}: {off}");
            }
        }
        assert_eq!(moments(&[]), (0.0, 0.0));
        let (_, squares) = moments(&[0.25, 0.75]);
        assert!((squares - exact_moments(&[0.25, 0.751]).1).abs() > 1e-5);
    }

    #[test]
    fn gradients_of_runs_and_of_taps_agree() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let width = 2100;
        let picture: Vec<f32> = (0..3 * width).map(|_| random.random_range(0.0..1.0)).collect();
        let around = |k: u32| {
            let (here, below) = (k + width, k + 2 * width);
            [k, k + 1, k + 2, here, here + 2, below, below + 1, below + 2]
        };
        let run = |first: u32, len| Run {
            above: first,
            here: first + width,
            below: first + 2 * width,
            len,
        };
        let lens = (1..=48).chain([1000, 1024, 1025, width - 2]);
        for (first, len) in lens.flat_map(|len| [(0, len), (1, len.min(width - 3))]) {
            let taps: Vec<Taps> = (first..first + len).map(around).collect();
            // Two runs, so that the second begins in the middle of a block.
            let both = interior_gradient(&picture, &[run(0, 21), run(first, len)]);
            let short = interior_gradient(&picture, &[run(0, 21)]);
            let tapped = tapped_gradient(&picture, &taps, 1.0, f32::MAX);
            let error = (both - short - tapped).abs();
            assert!(error < 1e-6 * f64::from(len + 21), "{first} {len}: {error}");
            let other = tapped_gradient(&picture, &taps[1..], 1.0, f32::MAX);
            assert!((both - short - other).abs() > 1e-4);
        }
        let flat = [0.5; 64];
        assert_eq!(interior_gradient(&flat, &[Run { above: 0, here: 0, below: 0, len: 60 }]), 0.0);
    }
}
