//! The inner loops of the native evaluator, compiled for several vector instruction sets, of which the
//! machine's best is chosen at run time. All of them give the same bits: every sum is taken in
//! [`LANES`] parts in a fixed order.

use super::compact::{Pixels, Run};
use super::fast_math::{exp2, ln, reciprocal_sqrt, srgb_encode};
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use multiversion::multiversion;
use std::ops::Range;

/// Partial sums of each sum: one for each lane of the widest vectors.
const LANES: usize = 16;

/// Terms that are added in single precision before a sum goes on in double precision.
const SUM_BLOCK: usize = 64 * LANES;

/// Pixels that are shaded under all lights before the next ones, so that they stay in the cache.
const SHADE_BLOCK: usize = 512;

/// The picture `I` of the pixels `range` under a rig; see [`crate::cpu::population`].
#[multiversion(targets = "simd")]
pub fn shade(pixels: &Pixels, range: Range<usize>, rig: &[LightRecord], picture: &mut [f32]) {
    for (block, out) in picture.chunks_mut(SHADE_BLOCK).enumerate() {
        let start = range.start + block * SHADE_BLOCK;
        out.copy_from_slice(&pixels.unlit[start..start + out.len()]);
        for light in rig {
            if light.radius2 > 0.0 {
                add_light::<true>(pixels, start, light, out);
            } else {
                add_light::<false>(pixels, start, light, out);
            }
        }
        for i in out {
            *i = srgb_encode(*i);
        }
    }
}

/// Adds one light's luminance to the pixels from `start` on; the formula is [`crate::lighting::shading::light_response`].
#[inline(always)]
fn add_light<const POINT: bool>(
    pixels: &Pixels,
    start: usize,
    light: &LightRecord,
    out: &mut [f32],
) {
    // Slices of one visible length: a bounds check left in the loop would leave its end to scalar code.
    let n = out.len();
    let [px, py, pz] = pixels.position.each_ref().map(|c| &c[start..][..n]);
    let [nx, ny, nz] = pixels.normal.each_ref().map(|c| &c[start..][..n]);
    let [vx, vy, vz] = pixels.to_viewer.each_ref().map(|c| &c[start..][..n]);
    let diffuse = &pixels.diffuse[start..][..n];
    let specular = &pixels.specular[start..][..n];
    let exponent = &pixels.exponent[start..][..n];
    let [x, y, z] = light.position;
    for i in 0..n {
        let (mut lx, mut ly, mut lz, mut falloff) = (x, y, z, 1.0);
        if POINT {
            (lx, ly, lz) = (x - px[i], y - py[i], z - pz[i]);
            let inverse = reciprocal_sqrt(lx * lx + ly * ly + lz * lz);
            (lx, ly, lz) = (lx * inverse, ly * inverse, lz * inverse);
            falloff = light.radius2 * (inverse * inverse);
        }
        let n_l = nx[i] * lx + ny[i] * ly + nz[i] * lz;
        let (hx, hy, hz) = (lx + vx[i], ly + vy[i], lz + vz[i]);
        let along = nx[i] * hx + ny[i] * hy + nz[i] * hz;
        let n_h = along * reciprocal_sqrt(hx * hx + hy * hy + hz * hz);
        let n_h = if n_h > 0.0 { n_h } else { 0.0 };
        let highlight = exp2(exponent[i] * ln(n_h));
        let strength = if n_l > 0.0 { falloff * n_l } else { 0.0 };
        let reflected = light.diffuse * diffuse[i] + light.specular * (specular[i] * highlight);
        out[i] += strength * reflected;
    }
}

/// Sum and sum of squared deviations from the mean.
#[multiversion(targets = "simd")]
pub fn moments(picture: &[f32]) -> (f64, f64) {
    let total = sum(picture, |i| i);
    let count = picture.len().max(1) as f64;
    let mean = (total / count) as f32;
    let squares = sum(picture, |i| (i - mean) * (i - mean));
    let off = total / count - f64::from(mean);
    (total, squares - count * off * off)
}

/// Adds a picture to its histogram.
#[multiversion(targets = "simd")]
pub fn histogram(picture: &[f32], bins: &mut [u32; HISTOGRAM_BINS]) {
    // Neighbours are often alike: counting them apart keeps an increment from waiting on the last.
    let mut parts = [[0u32; HISTOGRAM_BINS]; LANES];
    let mut chunks = picture.chunks_exact(LANES);
    for chunk in &mut chunks {
        let mut bin = [0usize; LANES];
        for k in 0..LANES {
            bin[k] = bin_of(chunk[k]);
        }
        for k in 0..LANES {
            parts[k][bin[k]] += 1;
        }
    }
    for &i in chunks.remainder() {
        bins[bin_of(i)] += 1;
    }
    for part in parts {
        for (bin, count) in bins.iter_mut().zip(part) {
            *bin += count;
        }
    }
}

#[inline(always)]
fn bin_of(i: f32) -> usize {
    ((i * HISTOGRAM_BINS as f32) as i32).clamp(0, HISTOGRAM_BINS as i32 - 1) as usize
}

/// Sum of `|∇I|` over runs of pixels whose neighbourhoods lie in the object. `lengths` is scratch
/// space for the longest run.
#[multiversion(targets = "simd")]
pub fn interior_gradient(picture: &[f32], runs: &[Run], lengths: &mut [f32]) -> f64 {
    let mut total = 0.0;
    for run in runs {
        let row = |start: u32| &picture[start as usize..(start + run.len) as usize + 2];
        let (above, here, below) = (row(run.above), row(run.here), row(run.below));
        let lengths = &mut lengths[..run.len as usize];
        for (i, length) in lengths.iter_mut().enumerate() {
            let x = (above[i + 2] - above[i])
                + 2.0 * (here[i + 2] - here[i])
                + (below[i + 2] - below[i]);
            let y = (below[i] - above[i])
                + 2.0 * (below[i + 1] - above[i + 1])
                + (below[i + 2] - above[i + 2]);
            *length = (x * x + y * y).sqrt() * 0.125;
        }
        total += sum(lengths, |length| length);
    }
    total
}

/// Sum of `f(|∇I|)` over pixels that name their nine taps.
pub fn tapped_gradient(picture: &[f32], taps: &[[u32; 9]], f: impl Fn(f32) -> f32) -> f64 {
    taps.iter()
        .map(|taps| {
            let t = taps.map(|tap| picture[tap as usize]);
            let x = (t[2] - t[0]) + 2.0 * (t[5] - t[3]) + (t[8] - t[6]);
            let y = (t[6] - t[0]) + 2.0 * (t[7] - t[1]) + (t[8] - t[2]);
            f64::from(f((x * x + y * y).sqrt() * 0.125))
        })
        .sum()
}

/// Sum of `f` over `values`.
#[inline(always)]
fn sum(values: &[f32], f: impl Fn(f32) -> f32) -> f64 {
    let mut total = 0.0;
    for block in values.chunks(SUM_BLOCK) {
        let mut lanes = [0.0f32; LANES];
        let mut chunks = block.chunks_exact(LANES);
        for chunk in &mut chunks {
            for k in 0..LANES {
                lanes[k] += f(chunk[k]);
            }
        }
        for (lane, &value) in lanes.iter_mut().zip(chunks.remainder()) {
            *lane += f(value);
        }
        total += lanes.iter().map(|&lane| f64::from(lane)).sum::<f64>();
    }
    total
}
