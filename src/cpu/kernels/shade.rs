//! Pictures from lights.

use super::super::compact::{Group, LANES, Lanes};
use super::super::fast_math::{clamp, exp2, log2, reciprocal_sqrt, srgb};
use super::Tile;
use crate::lighting::LightRecord;
use multiversion::multiversion;

/// Groups that are shaded under the lights of all rigs before the next ones, so that they stay in the
/// first cache: 7 KiB.
const SHADE_BLOCK: usize = 8;

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
pub(super) fn shade_block(groups: &[Group], rig: &[LightRecord], tiles: &mut [Tile], block: &mut [Lit; SHADE_BLOCK]) {
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

