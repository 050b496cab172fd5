//! The pictures `I` of rigs.

use super::super::compact::{Group, LANES, Lanes};
use super::super::fast_math::{clamp, exp2, log2, reciprocal_sqrt, srgb_encode, srgb_exponent};
use super::Tile;
use crate::lighting::LightRecord;
use multiversion::multiversion;

/// Groups that are shaded under the lights of all rigs before the next ones, so that they stay in the
/// first cache: 7 KiB.
pub(super) const SHADE_BLOCK: usize = 8;

/// What the passes of a light over a group hand on to each other.
#[repr(C, align(64))]
#[derive(Clone, Copy, Default)]
struct Interim {
    /// `n·(x − p)`, or `n·x` of a directional light.
    facing: Lanes,
    /// `1/|x − p|`, or 1.
    inverse: Lanes,
    /// `(n·h)²`, then the logarithm of the highlight.
    highlight: Lanes,
}

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
    shade_in_lanes(groups, rigs, lights, pictures, stride);
}

#[inline(always)]
pub(super) fn shade_in_lanes(
    groups: &[Group],
    rigs: &[LightRecord],
    lights: usize,
    pictures: &mut [Tile],
    stride: usize,
) {
    let mut interim = [Interim::default(); SHADE_BLOCK];
    for (block, groups) in groups.chunks(SHADE_BLOCK).enumerate() {
        let pictures = pictures.chunks_exact_mut(stride);
        for (rig, picture) in rigs.chunks_exact(lights).zip(pictures) {
            let tiles = &mut picture[block * SHADE_BLOCK..][..groups.len()];
            shade_block(groups, rig, &mut interim, tiles);
        }
    }
}

#[inline(always)]
fn shade_block(
    groups: &[Group],
    rig: &[LightRecord],
    interim: &mut [Interim; SHADE_BLOCK],
    tiles: &mut [Tile],
) {
    for (group, tile) in groups.iter().zip(&mut *tiles) {
        tile.0 = group.unlit;
    }
    for light in rig {
        if light.radius2 > 0.0 {
            add_light::<true>(groups, light, interim, tiles);
        } else {
            add_light::<false>(groups, light, interim, tiles);
        }
    }
    encode(tiles);
}

/// Adds one light's luminance; the formula is [`crate::lighting::shading::light_response`].
///
/// In one pass it would be a chain of some forty operations, each of which waits for the one before,
/// longer than what a processor looks ahead to fill the gaps. Short passes keep it busy, and their
/// constants in registers.
#[inline(always)]
fn add_light<const POINT: bool>(
    groups: &[Group],
    light: &LightRecord,
    interim: &mut [Interim; SHADE_BLOCK],
    tiles: &mut [Tile],
) {
    let mut lit = [0; SHADE_BLOCK];
    let mut count = 0;
    for (at, (group, interim)) in groups.iter().zip(&mut *interim).enumerate() {
        // Neighbours are alike: often all of a group are turned away from the light.
        let any = faces::<POINT>(group, light.position, interim);
        lit[count] = at;
        count += usize::from(any);
    }
    let lit = &lit[..count];
    if POINT {
        for &at in lit {
            measure_distance(&groups[at], light.position, &mut interim[at]);
        }
    }
    for &at in lit {
        find_half_vector::<POINT>(&groups[at], light.position, &mut interim[at]);
    }
    for &at in lit {
        let highlight = &mut interim[at].highlight;
        for (highlight, exponent) in highlight.iter_mut().zip(groups[at].exponent) {
            *highlight = exponent * log2(*highlight);
        }
    }
    for &at in lit {
        reflect::<POINT>(&groups[at], light, &interim[at], &mut tiles[at]);
    }
}

/// Whether the light reaches a pixel of the group.
#[inline(always)]
fn faces<const POINT: bool>(group: &Group, light: [f32; 3], interim: &mut Interim) -> bool {
    let mut any = false;
    for k in 0..LANES {
        let facing = dot_normal(group, k, to_light::<POINT>(group, light, k));
        interim.facing[k] = facing;
        any |= facing > 0.0;
    }
    any
}

#[inline(always)]
fn measure_distance(group: &Group, light: [f32; 3], interim: &mut Interim) {
    for k in 0..LANES {
        let [x, y, z] = to_light::<true>(group, light, k);
        interim.inverse[k] = reciprocal_sqrt(x.mul_add(x, y.mul_add(y, z * z)));
    }
}

#[inline(always)]
fn find_half_vector<const POINT: bool>(group: &Group, light: [f32; 3], interim: &mut Interim) {
    for k in 0..LANES {
        let [x, y, z] = to_light::<POINT>(group, light, k);
        let inverse = if POINT { interim.inverse[k] } else { 1.0 };
        let hx = x.mul_add(inverse, group.to_viewer[0][k]);
        let hy = y.mul_add(inverse, group.to_viewer[1][k]);
        let hz = z.mul_add(inverse, group.to_viewer[2][k]);
        // The summand keeps 0/0 away.
        let square = hx.mul_add(hx, hy.mul_add(hy, hz.mul_add(hz, f32::MIN_POSITIVE)));
        let along = interim.facing[k] * inverse + group.facing[k];
        let n_h2 = along * along / square;
        interim.highlight[k] = if n_h2 < 1.0 { n_h2 } else { 1.0 };
    }
}

#[inline(always)]
fn reflect<const POINT: bool>(
    group: &Group,
    light: &LightRecord,
    interim: &Interim,
    tile: &mut Tile,
) {
    let scale = if POINT { light.radius2 } else { 1.0 };
    let (diffuse, specular) = (light.diffuse * scale, light.specular * scale);
    for k in 0..LANES {
        let inverse = if POINT { interim.inverse[k] } else { 1.0 };
        let n_l = interim.facing[k] * inverse;
        let strength = if n_l > 0.0 { n_l * (inverse * inverse) } else { 0.0 };
        let highlight = exp2(interim.highlight[k]);
        let reflected =
            diffuse.mul_add(group.diffuse[k], specular * (group.specular[k] * highlight));
        tile.0[k] = strength.mul_add(reflected, tile.0[k]);
    }
}

/// Encodes a block's luminances, in two passes for the same reason.
#[inline(always)]
fn encode(tiles: &mut [Tile]) {
    let mut exponents = [[0.0; LANES]; SHADE_BLOCK];
    for (exponents, tile) in exponents.iter_mut().zip(&mut *tiles) {
        for (exponent, i) in exponents.iter_mut().zip(&mut tile.0) {
            *i = clamp(*i);
            *exponent = srgb_exponent(*i);
        }
    }
    for (exponents, tile) in exponents.iter().zip(tiles) {
        for (&exponent, i) in exponents.iter().zip(&mut tile.0) {
            *i = srgb_encode(*i, exponent);
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
