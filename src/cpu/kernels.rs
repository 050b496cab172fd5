//! The inner loops of the native evaluator, compiled for several vector instruction sets, of which the
//! machine's best is chosen at run time. All of them give the same bits: every sum is taken in
//! [`LANES`] parts in a fixed order.

use super::compact::{Group, LANES, Lanes, Run, Taps};
use super::fast_math::{clamp, exp2, log2, reciprocal_sqrt, srgb};
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use bytemuck::{Pod, Zeroable};
use multiversion::multiversion;

/// Terms that are added in single precision before a sum goes on in double precision.
const SUM_BLOCK: usize = 64 * LANES;

/// Groups that are shaded under the lights of all rigs before the next ones, so that they stay in the
/// first cache: 7 KiB.
const SHADE_BLOCK: usize = 8;

/// Pixels whose bins are kept before they are counted.
const COUNT_BLOCK: usize = 32 * LANES;

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
    let mut lit = [Lit::default(); SHADE_BLOCK];
    for (block, groups) in groups.chunks(SHADE_BLOCK).enumerate() {
        let pictures = pictures.chunks_exact_mut(stride);
        for (rig, picture) in rigs.chunks_exact(lights).zip(pictures) {
            shade_block(groups, rig, &mut picture[block * SHADE_BLOCK..][..groups.len()], &mut lit);
        }
    }
}

#[inline(always)]
fn shade_block(groups: &[Group], rig: &[LightRecord], tiles: &mut [Tile], block: &mut [Lit; SHADE_BLOCK]) {
    for (group, tile) in groups.iter().zip(&mut *tiles) {
        tile.0 = group.unlit;
    }
    for light in rig {
        if light.radius2 > 0.0 {
            add_light::<true>(groups, light, tiles, block);
        } else {
            add_light::<false>(groups, light, tiles, block);
        }
    }
    encode(tiles);
}

/// Encodes the luminances of a block.
#[inline(always)]
fn encode(tiles: &mut [Tile]) {
    let mut powers = [[0.0; LANES]; SHADE_BLOCK];
    for (power, tile) in powers.iter_mut().zip(&mut *tiles) {
        for (power, i) in power.iter_mut().zip(&mut tile.0) {
            *i = clamp(*i);
            *power = log2(*i) * (1.0 / 2.4);
        }
    }
    for (power, tile) in powers.iter().zip(tiles) {
        for (&power, i) in power.iter().zip(&mut tile.0) {
            *i = srgb(*i, exp2(power));
        }
    }
}

/// A group that faces a light.
#[repr(C, align(64))]
#[derive(Clone, Copy, Default)]
struct Lit {
    /// `n·(x − p)`, of which `n·l` is the unit vector's share.
    facing: Lanes,
    /// `1/|x − p|`.
    inverse: Lanes,
    /// `(n·h)²`, then its logarithm times the exponent.
    power: Lanes,
    /// Which one of the block.
    group: usize,
}

/// Adds one light's luminance; the formula is [`crate::lighting::shading::light_response`].
#[inline(always)]
fn add_light<const POINT: bool>(groups: &[Group], light: &LightRecord, tiles: &mut [Tile], block: &mut [Lit; SHADE_BLOCK]) {
    let at = light.position;
    let mut count = 0;
    for (index, group) in groups.iter().enumerate() {
        let lit = &mut block[count];
        let mut any = false;
        for k in 0..LANES {
            let facing = dot_normal(group, k, to_light::<POINT>(group, at, k));
            lit.facing[k] = facing;
            any |= facing > 0.0;
        }
        lit.group = index;
        // Neighbours are alike: often all of a group are turned away from the light.
        count += usize::from(any);
    }
    let block = &mut block[..count];
    for lit in &mut *block {
        let group = &groups[lit.group];
        for k in 0..LANES {
            let [x, y, z] = to_light::<POINT>(group, at, k);
            lit.inverse[k] =
                if POINT { reciprocal_sqrt(x.mul_add(x, y.mul_add(y, z * z))) } else { 1.0 };
        }
    }
    for lit in &mut *block {
        let group = &groups[lit.group];
        for k in 0..LANES {
            let [x, y, z] = to_light::<POINT>(group, at, k);
            let hx = x.mul_add(lit.inverse[k], group.to_viewer[0][k]);
            let hy = y.mul_add(lit.inverse[k], group.to_viewer[1][k]);
            let hz = z.mul_add(lit.inverse[k], group.to_viewer[2][k]);
            // The summand keeps 0/0 away.
            let square = hx.mul_add(hx, hy.mul_add(hy, hz.mul_add(hz, f32::MIN_POSITIVE)));
            let along = lit.facing[k] * lit.inverse[k] + group.facing[k];
            let n_h2 = along * along / square;
            lit.power[k] = if n_h2 < 1.0 { n_h2 } else { 1.0 };
        }
    }
    for lit in &mut *block {
        let group = &groups[lit.group];
        for (power, exponent) in lit.power.iter_mut().zip(group.exponent) {
            *power = exponent * log2(*power);
        }
    }
    let scale = if POINT { light.radius2 } else { 1.0 };
    let (diffuse, specular) = (light.diffuse * scale, light.specular * scale);
    for lit in &*block {
        let group = &groups[lit.group];
        let tile = &mut tiles[lit.group];
        for k in 0..LANES {
            let inverse = lit.inverse[k];
            let n_l = lit.facing[k] * inverse;
            let strength = if n_l > 0.0 { n_l * (inverse * inverse) } else { 0.0 };
            let highlight = exp2(lit.power[k]);
            let reflected =
                diffuse.mul_add(group.diffuse[k], specular * (group.specular[k] * highlight));
            tile.0[k] = strength.mul_add(reflected, tile.0[k]);
        }
    }
}

/// From the group's pixel `k` to a point light, the unit direction to a directional one.
#[inline(always)]
fn to_light<const POINT: bool>(group: &Group, [x, y, z]: [f32; 3], k: usize) -> [f32; 3] {
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
    moments_in_lanes(picture)
}

#[inline(always)]
fn moments_in_lanes(picture: &[f32]) -> (f64, f64) {
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
    // Neighbours are often alike: counting them apart keeps an increment from waiting on the last.
    let mut counts = [[0u32; HISTOGRAM_BINS]; LANES];
    for block in picture.chunks(COUNT_BLOCK) {
        let mut bins = [0; COUNT_BLOCK];
        for (bin, &i) in bins.iter_mut().zip(block) {
            *bin = bin_of(i);
        }
        for bins in bins[..block.len()].chunks(LANES) {
            for (counts, &bin) in counts.iter_mut().zip(bins) {
                counts[usize::from(bin) % HISTOGRAM_BINS] += 1;
            }
        }
    }
    std::array::from_fn(|bin| counts.iter().map(|counts| counts[bin]).sum())
}

/// `min(31, floor(32·i))`, 0 for what is not above 0.
#[inline(always)]
fn bin_of(i: f32) -> u8 {
    const LAST: f32 = (HISTOGRAM_BINS - 1) as f32;
    let scaled = i * HISTOGRAM_BINS as f32;
    let positive = if scaled > 0.0 { scaled } else { 0.0 };
    let bin = if positive < LAST { positive } else { LAST };
    // `as` would look for values out of range once more, which takes longer than all of the rest.
    // SAFETY: `bin` lies in 0..=31; where `i` is not a number the first comparison has made it 0.
    let bin: i32 = unsafe { bin.to_int_unchecked() };
    bin as u8
}

/// Sum of `|∇I|` over runs of pixels whose neighbourhoods lie in the object.
#[multiversion(targets = "simd")]
pub fn interior_gradient(picture: &[f32], runs: &[Run]) -> f64 {
    let mut total = 0.0;
    for run in runs {
        let row = |start: u32| &picture[start as usize..][..run.len as usize + 2];
        total += run_gradient(row(run.above), row(run.here), row(run.below));
    }
    total
}

/// The same over one run, of rows that are two pixels longer than it.
#[inline(always)]
fn run_gradient(above: &[f32], here: &[f32], below: &[f32]) -> f64 {
    let len = here.len() - 2;
    let mut lanes = [0.0; LANES];
    let mut at = 0;
    while at + LANES <= len {
        let rows = [above, here, below].map(|row| &row[at..at + LANES + 2]);
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane += row_gradient(rows, k);
        }
        at += LANES;
    }
    for k in at..len {
        lanes[k - at] += row_gradient([above, here, below], k);
    }
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}

/// `|∇I|` in the pixel to the right of pixel `k` of a row.
#[inline(always)]
fn row_gradient([a, h, b]: [&[f32]; 3], k: usize) -> f32 {
    gradient([a[k], a[k + 1], a[k + 2], h[k], h[k + 2], b[k], b[k + 1], b[k + 2]])
}

/// `|∇I|` from the taps around a pixel, row by row.
#[inline(always)]
fn gradient([a, b, c, d, f, g, h, i]: [f32; 8]) -> f32 {
    let x = 2.0f32.mul_add(f - d, (c - a) + (i - g));
    let y = 2.0f32.mul_add(h - b, (g - a) + (i - c));
    let square = x.mul_add(x, y * y);
    square * reciprocal_sqrt(square) * 0.125
}

/// Sum of `min(most, scale·|∇I|)` over pixels that name their taps.
#[multiversion(targets = "simd")]
pub fn tapped_gradient(picture: &[f32], taps: &[Taps], scale: f32, most: f32) -> f64 {
    let mut total = 0.0;
    for taps in taps.chunks(LANES) {
        total += taps_gradient(picture, taps, scale, most);
    }
    total
}

/// The same over at most [`LANES`] pixels.
#[inline(always)]
fn taps_gradient(picture: &[f32], taps: &[Taps], scale: f32, most: f32) -> f64 {
    let mut around = [[0.0; LANES]; 8];
    for (lane, taps) in taps.iter().enumerate() {
        for k in 0..8 {
            around[k][lane] = picture[taps[k] as usize];
        }
    }
    let mut lengths = [0.0; LANES];
    for k in 0..LANES {
        let [a, b, c, d, f, g, h, i] = &around;
        let taps = [a[k], b[k], c[k], d[k], f[k], g[k], h[k], i[k]];
        let length = gradient(taps) * scale;
        lengths[k] = if length < most { length } else { most };
    }
    lengths.iter().map(|&length| f64::from(length)).sum()
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// What every kernel makes of the same input, as bits.
    #[derive(Debug, PartialEq)]
    struct Outcome {
        picture: Vec<u32>,
        sums: [u64; 4],
    }

    struct Input {
        groups: Vec<Group>,
        rig: Vec<LightRecord>,
        taps: Vec<Taps>,
    }

    const LEN: usize = 5 * LANES;

    impl Input {
        fn new() -> Self {
            let mut random = ChaCha8Rng::seed_from_u64(11);
            let mut number = |low: f32, high: f32| random.random_range(low..high);
            let mut group = || {
                let mut lanes = |low, high| -> Lanes { std::array::from_fn(|_| number(low, high)) };
                Group {
                    position: [lanes(-1.0, 1.0), lanes(-1.0, 1.0), lanes(-1.0, 1.0)],
                    normal: [lanes(-0.6, 0.6), lanes(-0.6, 0.6), lanes(0.1, 0.8)],
                    to_viewer: [lanes(-0.1, 0.1), lanes(-0.1, 0.1), lanes(0.9, 1.0)],
                    facing: lanes(0.0, 1.0),
                    diffuse: lanes(0.0, 1.0),
                    specular: lanes(0.0, 2.0),
                    exponent: lanes(0.5, 2048.0),
                    unlit: lanes(0.0, 0.1),
                }
            };
            let groups = (0..LEN / LANES).map(|_| group()).collect();
            let light = |k: u16| LightRecord {
                position: [number(-2.0, 2.0), number(-2.0, 2.0), number(1.0, 3.0)],
                radius2: f32::from(k % 3) * 2.0,
                diffuse: number(0.0, 0.2),
                specular: number(0.0, 0.1),
                padding: [0.0; 2],
            };
            let rig = (0..9).map(light).collect();
            let tap = |_| std::array::from_fn(|_| number(0.0, LEN as f32) as u32);
            Self { groups, rig, taps: (0..LANES).map(tap).collect() }
        }

        #[inline(always)]
        fn outcome(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            shade_block(&self.groups, &self.rig, &mut tiles);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            let (sum, squares) = moments_in_lanes(&picture[3..]);
            let [above, here, below] = [0, 21, 42].map(|at| &picture[at..at + 38]);
            let inner = run_gradient(above, here, below);
            let outer = taps_gradient(picture, &self.taps, 1.0 / 0.06, 1.0);
            Outcome {
                picture: picture.iter().map(|i| i.to_bits()).collect(),
                sums: [sum, squares, inner, outer].map(f64::to_bits),
            }
        }

        /// By the version that is chosen for this machine.
        fn dispatched(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            let stride = tiles.len();
            shade(&self.groups, &self.rig, self.rig.len(), &mut tiles, stride);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            let (sum, squares) = moments(&picture[3..]);
            let inner =
                interior_gradient(picture, &[Run { above: 0, here: 21, below: 42, len: 36 }]);
            let outer = tapped_gradient(picture, &self.taps, 1.0 / 0.06, 1.0);
            Outcome {
                picture: picture.iter().map(|i| i.to_bits()).collect(),
                sums: [sum, squares, inner, outer].map(f64::to_bits),
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn avx2(input: &Input) -> Outcome {
        input.outcome()
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx,avx2,fma,avx512f,avx512bw,avx512dq,avx512vl")]
    fn avx512(input: &Input) -> Outcome {
        input.outcome()
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let mut input = Input::new();
        let baseline = input.outcome();
        assert_eq!(input.dispatched(), baseline);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the machine has what the function is compiled for.
                assert_eq!(unsafe { avx2(&input) }, baseline);
            }
            let wide = is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512dq");
            if wide && is_x86_feature_detected!("avx512vl") {
                // SAFETY: as above.
                assert_eq!(unsafe { avx512(&input) }, baseline);
            }
        }
        // The last bits of one number are enough to tell two outcomes apart.
        let unlit = &mut input.groups[0].unlit[5];
        *unlit = f32::from_bits(unlit.to_bits() + 64);
        assert_ne!(input.dispatched(), baseline);
    }

    #[test]
    fn bins_are_those_of_the_plain_histogram() {
        let mut picture: Vec<f32> = (0..=64).map(|k| k as f32 / 64.0).collect();
        picture.extend([0.999_999_9, f32::NAN, -1.0, f32::INFINITY, 0.031_249_998]);
        for &i in &picture {
            let plain = ((i * 32.0) as i32).clamp(0, 31);
            assert_eq!(i32::from(bin_of(i)), plain, "{i}");
        }
        for len in 0..picture.len() {
            assert_eq!(histogram(&picture[..len]).iter().sum::<u32>(), len as u32);
        }
        let skewed = [vec![0.0; 1000], vec![1.0; 777]].concat();
        let counts = histogram(&skewed);
        assert_eq!((counts[0], counts[31]), (1000, 777));
    }

    #[test]
    fn gradients_of_runs_and_of_taps_agree() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let width = 50;
        let picture: Vec<f32> = (0..3 * width).map(|_| random.random_range(0.0..1.0)).collect();
        for len in 1..=width - 2 {
            let run = Run { above: 0, here: width, below: 2 * width, len };
            let around = |k: u32| {
                let below = k + 2 * width;
                let here = k + width;
                [k, k + 1, k + 2, here, here + 2, below, below + 1, below + 2]
            };
            let taps: Vec<Taps> = (0..len).map(around).collect();
            let run = interior_gradient(&picture, &[run]);
            let tapped = tapped_gradient(&picture, &taps, 1.0, f32::MAX);
            assert!((run - tapped).abs() < 1e-5, "{len}: {run} {tapped}");
        }
        let flat = [0.5; 64];
        assert_eq!(interior_gradient(&flat, &[Run { above: 0, here: 0, below: 0, len: 60 }]), 0.0);
    }
}
