//! Sums over pictures.

use super::super::compact::{LANES, Run, Taps};
use super::super::fast_math::reciprocal_sqrt;
use crate::objective::HISTOGRAM_BINS;
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
    // A pixel's own brightness lies near the mean where all are alike, so that little cancels below.
    let near = picture.first().copied().unwrap_or_default();
    let (mut sum, mut squares) = (0.0, 0.0);
    for block in picture.chunks(SUM_BLOCK) {
        let (mut lanes, mut square_lanes) = ([0.0f32; LANES], [0.0f32; LANES]);
        let mut chunks = block.chunks_exact(LANES);
        for chunk in &mut chunks {
            for k in 0..LANES {
                let off = chunk[k] - near;
                lanes[k] += off;
                square_lanes[k] = off.mul_add(off, square_lanes[k]);
            }
        }
        for (k, i) in chunks.remainder().iter().enumerate() {
            let off = i - near;
            lanes[k] += off;
            square_lanes[k] = off.mul_add(off, square_lanes[k]);
        }
        sum += total(&lanes);
        squares += total(&square_lanes);
    }
    let count = picture.len() as f64;
    let off = sum / count.max(1.0);
    (count.mul_add(near.into(), sum), squares - count * off * off)
}

/// Counts a picture's pixels in bins.
#[multiversion(targets = "simd")]
pub fn histogram(picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    let mut counts = [0; HISTOGRAM_BINS];
    for part in picture.chunks(255 * COUNT_BLOCK) {
        count_bins(part, &mut counts);
    }
    counts
}

/// Words that are added bit by bit: one for each pixel, with the bit of its bin set.
const WORD_LANES: usize = 32;
/// Words of a lane in a block.
const LANE_WORDS: usize = 32;
/// Pixels that are counted together.
const COUNT_BLOCK: usize = LANE_WORDS * WORD_LANES;
type Words = [u32; WORD_LANES];

#[inline(always)]
fn count_bins(part: &[f32], counts: &mut [u32; HISTOGRAM_BINS]) {
    let mut planes = [[0; WORD_LANES]; LANE_WORDS.ilog2() as usize];
    let mut blocks = [[0; WORD_LANES]; 8];
    let mut words = [0; COUNT_BLOCK];
    for block in part.chunks(COUNT_BLOCK) {
        for (word, &i) in words.iter_mut().zip(block) {
            *word = 1 << bin_of(i);
        }
        words[block.len()..].fill(0);
        let mut half = COUNT_BLOCK / 2;
        for plane in &mut planes {
            let (low, high) = words.split_at_mut(half);
            let pairs = low.chunks_exact_mut(WORD_LANES).zip(high.chunks_exact(WORD_LANES));
            for (low, high) in pairs {
                for k in 0..WORD_LANES {
                    let (a, b, c) = (low[k], high[k], plane[k]);
                    low[k] = (a & b) | ((a ^ b) & c);
                    plane[k] = a ^ b ^ c;
                }
            }
            half /= 2;
        }
        spread(&words[..WORD_LANES], 0, &mut blocks);
    }
    let mut rest = [[0; WORD_LANES]; 8];
    for (level, plane) in planes.iter().enumerate() {
        spread(plane, level, &mut rest);
    }
    for (bin, count) in counts.iter_mut().enumerate() {
        for k in 0..WORD_LANES {
            let [blocks, rest] = [&blocks, &rest].map(|bytes| bytes[bin % 8][k] >> (bin / 8 * 8) & 255);
            *count += LANE_WORDS as u32 * blocks + rest;
        }
    }
}

#[inline(always)]
fn spread(words: &[u32], level: usize, bytes: &mut [Words; 8]) {
    for (shift, bytes) in bytes.iter_mut().enumerate() {
        for (byte, word) in bytes.iter_mut().zip(words) {
            *byte += (word >> shift & 0x0101_0101) << level;
        }
    }
}

/// `min(31, floor(32·i))`, 0 for what is not above 0.
#[inline(always)]
fn bin_of(i: f32) -> u32 {
    const LAST: f32 = (HISTOGRAM_BINS - 1) as f32;
    let scaled = i * HISTOGRAM_BINS as f32;
    let positive = if scaled > 0.0 { scaled } else { 0.0 };
    let bin = if positive < LAST { positive } else { LAST };
    // `as` would look for values out of range once more, which takes longer than all of the rest.
    // SAFETY: `bin` lies in 0..=31; where `i` is not a number the first comparison has made it 0.
    let bin: i32 = unsafe { bin.to_int_unchecked() };
    bin as u32
}

/// Sum of `|∇I|` over runs of pixels whose neighbourhoods lie in the object.
#[multiversion(targets = "simd")]
pub fn interior_gradient(picture: &[f32], runs: &[Run]) -> f64 {
    runs_gradient(picture, runs)
}

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

#[inline(always)]
fn row_squares([a, h, b]: [&[f32]; 3], squares: &mut [f32]) {
    let len = squares.len();
    let mut at = 0;
    while at + LANES < len {
        window_squares([a, h, b], at, squares);
        at += LANES;
    }
    if len >= LANES {
        window_squares([a, h, b], len - LANES, squares);
    } else {
        for (k, square) in squares.iter_mut().enumerate() {
            *square = row_square([a, h, b], k);
        }
    }
}

#[inline(always)]
fn window_squares(rows: [&[f32]; 3], at: usize, squares: &mut [f32]) {
    let rows = rows.map(|row| &row[at..at + LANES + 2]);
    let mut window = [0.0; LANES];
    for (k, square) in window.iter_mut().enumerate() {
        *square = row_square(rows, k);
    }
    squares[at..at + LANES].copy_from_slice(&window);
}

/// `64·|∇I|²` in the pixel to the right of pixel `k` of a row.
#[inline(always)]
fn row_square([a, h, b]: [&[f32]; 3], k: usize) -> f32 {
    square([a[k], a[k + 1], a[k + 2], h[k], h[k + 2], b[k], b[k + 1], b[k + 2]])
}

/// `64·|∇I|²` from the taps around a pixel, row by row.
#[inline(always)]
fn square([a, b, c, d, f, g, h, i]: [f32; 8]) -> f32 {
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
        total += sum(squares, |square| {
            let length = square * reciprocal_sqrt(square) * scale;
            if length < most { length } else { most }
        });
    }
    total
}

#[inline(always)]
fn lengths(squares: &[f32]) -> f64 {
    sum(squares, |square| square * reciprocal_sqrt(square))
}

/// Sum of `f` over at most [`SUM_BLOCK`] `values`.
#[inline(always)]
fn sum(values: &[f32], f: impl Fn(f32) -> f32) -> f64 {
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
