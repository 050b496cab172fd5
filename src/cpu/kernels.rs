//! The inner loops of the native evaluator, compiled for several vector instruction sets, of which the
//! machine's best is chosen at run time. All of them give the same bits: every sum is taken in
//! [`LANES`] parts in a fixed order.

use super::compact::{Group, LANES, Lanes, Run};
use super::fast_math::{exp2, log2, reciprocal_sqrt, srgb_encode};
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use bytemuck::{Pod, Zeroable};
use multiversion::multiversion;

/// Terms that are added in single precision before a sum goes on in double precision.
const SUM_BLOCK: usize = 64 * LANES;

/// Groups that are shaded under the lights of all rigs before the next ones, so that they stay in the
/// first cache: 7 KiB.
const SHADE_BLOCK: usize = 8;

/// Bytes of the widest vectors.
const BYTES: usize = 64;

/// Pixels whose bins are counted together; in each of [`BYTES`] places fewer than 256.
const COUNT_BLOCK: usize = 64 * BYTES;

/// A picture's pixels, group by group.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub struct Tile(Lanes);

/// The pictures `I` of `groups` under rigs of `lights` lights each, one for each piece of `pictures`
/// of `stride` tiles; see [`crate::cpu::population`].
#[multiversion(targets = "simd")]
pub fn shade(
    groups: &[Group],
    rigs: &[LightRecord],
    lights: usize,
    pictures: &mut [Tile],
    stride: usize,
) {
    for (block, groups) in groups.chunks(SHADE_BLOCK).enumerate() {
        let pictures = pictures.chunks_exact_mut(stride);
        for (rig, picture) in rigs.chunks_exact(lights).zip(pictures) {
            shade_block(groups, rig, &mut picture[block * SHADE_BLOCK..][..groups.len()]);
        }
    }
}

#[inline(always)]
fn shade_block(groups: &[Group], rig: &[LightRecord], tiles: &mut [Tile]) {
    for (group, tile) in groups.iter().zip(&mut *tiles) {
        tile.0 = group.unlit;
    }
    for light in rig {
        if light.radius2 > 0.0 {
            add_light::<true>(groups, light, tiles);
        } else {
            add_light::<false>(groups, light, tiles);
        }
    }
    for tile in tiles {
        for i in &mut tile.0 {
            *i = srgb_encode(*i);
        }
    }
}

/// Adds one light's luminance; the formula is [`crate::lighting::shading::light_response`].
#[inline(always)]
fn add_light<const POINT: bool>(groups: &[Group], light: &LightRecord, tiles: &mut [Tile]) {
    let scale = if POINT { light.radius2 } else { 1.0 };
    let (diffuse, specular) = (light.diffuse * scale, light.specular * scale);
    for (group, tile) in groups.iter().zip(tiles) {
        // Neighbours are alike: often all of a group are turned away from the light.
        let mut lit = 0;
        for k in 0..LANES {
            let [x, y, z] = to_light::<POINT>(group, light, k);
            lit |= !dot_normal(group, k, [x, y, z]).to_bits() >> 31;
        }
        if lit == 0 {
            continue;
        }
        for k in 0..LANES {
            let [x, y, z] = to_light::<POINT>(group, light, k);
            let square = x.mul_add(x, y.mul_add(y, z * z));
            let inverse = if POINT { reciprocal_sqrt(square) } else { 1.0 };
            let n_l = dot_normal(group, k, [x, y, z]) * inverse;
            let hx = x.mul_add(inverse, group.to_viewer[0][k]);
            let hy = y.mul_add(inverse, group.to_viewer[1][k]);
            let hz = z.mul_add(inverse, group.to_viewer[2][k]);
            // The summand keeps 0/0 away.
            let square = hx.mul_add(hx, hy.mul_add(hy, hz.mul_add(hz, f32::MIN_POSITIVE)));
            let along = n_l + group.facing[k];
            let n_h2 = along * along / square;
            let n_h2 = if n_h2 < 1.0 { n_h2 } else { 1.0 };
            let highlight = exp2(group.exponent[k] * log2(n_h2));
            let strength = if n_l > 0.0 { n_l * (inverse * inverse) } else { 0.0 };
            let reflected =
                diffuse.mul_add(group.diffuse[k], specular * (group.specular[k] * highlight));
            tile.0[k] = strength.mul_add(reflected, tile.0[k]);
        }
    }
}

/// From the group's pixel `k` to a point light, the unit direction to a directional one.
#[inline(always)]
fn to_light<const POINT: bool>(group: &Group, light: &LightRecord, k: usize) -> [f32; 3] {
    let [x, y, z] = light.position;
    if !POINT {
        return [x, y, z];
    }
    let [px, py, pz] = &group.position;
    [x - px[k], y - py[k], z - pz[k]]
}

#[inline(always)]
fn dot_normal(group: &Group, k: usize, [x, y, z]: [f32; 3]) -> f32 {
    let [nx, ny, nz] = &group.normal;
    nx[k].mul_add(x, ny[k].mul_add(y, nz[k] * z))
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

/// Counts a picture's pixels in bins.
#[multiversion(targets = "simd")]
pub fn histogram(picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    // For each bin how many pixels lie in it or above: comparing all pixels with all bins in vectors
    // of bytes is faster than one increment after another, and takes the same time for any picture.
    let mut at_least = [0; HISTOGRAM_BINS + 1];
    for block in picture.chunks(COUNT_BLOCK) {
        let mut bins = [0; COUNT_BLOCK];
        for (bin, &i) in bins.iter_mut().zip(block) {
            *bin = bin_of(i);
        }
        let bins = &bins[..block.len().next_multiple_of(BYTES)];
        at_least[0] += block.len() as u32;
        for k in 1..HISTOGRAM_BINS {
            at_least[k] += count(bins, k as i8);
        }
    }
    std::array::from_fn(|k| at_least[k] - at_least[k + 1])
}

/// How many numbers are not below `bin`; at most 255 for each of the [`BYTES`] places.
#[inline(always)]
fn count(bins: &[i8], bin: i8) -> u32 {
    let mut counts = [0u8; BYTES];
    for chunk in bins.chunks_exact(BYTES) {
        for k in 0..BYTES {
            counts[k] += u8::from(chunk[k] >= bin);
        }
    }
    counts.iter().map(|&count| u32::from(count)).sum()
}

#[inline(always)]
fn bin_of(i: f32) -> i8 {
    ((i * HISTOGRAM_BINS as f32) as i32).clamp(0, HISTOGRAM_BINS as i32 - 1) as i8
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
