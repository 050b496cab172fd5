//! Mip chains of pictures.

use super::TextureLevel;
use crate::math::color::{srgb_decode, srgb_encode};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Longest side of an image, in pixels.
pub(super) const MAX_SIDE: u32 = 16_384;
/// Most pixels of all images together, each use counted.
pub(super) const MAX_PIXELS: u64 = 1 << 30;

/// The mip chain of a picture: box filters of 2×2 texels, in linear light.
pub(super) fn mips(full: TextureLevel, srgb: bool) -> Vec<TextureLevel> {
    let mut levels = vec![full];
    while let Some(last) = levels.last().filter(|level| level.width > 1 || level.height > 1) {
        let half = halved(last, srgb);
        levels.push(half);
    }
    levels
}

/// Source texels of one destination texel along an axis, and their weights.
type Taps = [(usize, f32); 3];

/// The taps for texel `i` of `n / 2`. An odd size is covered evenly by three taps with weights that
/// slide along (polyphase box filter, Guthe and Heckbert, *Non-Power-of-Two Mipmapping*, 2005).
fn taps(i: usize, n: usize) -> Taps {
    let half = n / 2;
    let total = n as f32;
    match (n, n % 2) {
        (1, _) => [(0, 1.0), (0, 0.0), (0, 0.0)],
        (_, 0) => [(2 * i, 0.5), (2 * i + 1, 0.5), (2 * i, 0.0)],
        _ => [
            (2 * i, (half - i) as f32 / total),
            (2 * i + 1, half as f32 / total),
            (2 * i + 2, (i + 1) as f32 / total),
        ],
    }
}

fn halved(from: &TextureLevel, srgb: bool) -> TextureLevel {
    let (w, h) = (from.width as usize, from.height as usize);
    let (width, height) = ((w / 2).max(1), (h / 2).max(1));
    let tables = &*TABLES;
    let decode = if srgb { &tables.linear } else { &tables.unit };
    let mut texels = vec![[0; 4]; width * height];
    texels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let mut sum = [0.0; 4];
            for (sy, wy) in taps(y, h) {
                for (sx, wx) in taps(x, w) {
                    if wx * wy > 0.0 {
                        let [r, g, b, a] = from.texels[sy * w + sx].map(usize::from);
                        let value = [decode[r], decode[g], decode[b], tables.unit[a]];
                        (0..4).for_each(|k| sum[k] += wx * wy * value[k]);
                    }
                }
            }
            let byte = |value: f32| (value * 255.0).round() as u8;
            let color = |value: f32| match srgb {
                true => tables.srgb[(value * 65535.0).round() as usize],
                false => byte(value),
            };
            *texel = [color(sum[0]), color(sum[1]), color(sum[2]), byte(sum[3])];
        }
    });
    TextureLevel { width: width as u32, height: height as u32, texels }
}

/// The transfer function of sRGB (IEC 61966-2-1) as tables.
struct Tables {
    /// 0..1 for each byte.
    unit: [f32; 256],
    /// Linear light for each sRGB byte.
    linear: [f32; 256],
    /// sRGB byte for linear light in steps of 1/65535, a twentieth of the finest byte step.
    srgb: Vec<u8>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let unit = std::array::from_fn(|byte| byte as f32 / 255.0);
    let linear = unit.map(srgb_decode);
    let encoded = |step: u32| (srgb_encode(step as f32 / 65535.0) * 255.0).round() as u8;
    // One entry more than the range, should a sum of weights round above 1.
    Tables { unit, linear, srgb: (0..=65536).map(encoded).collect() }
});
