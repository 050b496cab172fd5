//! Rigs in colour: the pictures `I` and what the lights do, for any lights and either BRDF, with and without
//! shadows.

use super::super::compact::{ColorGroup, Group, LANES, Lanes};
use super::super::fast_math::{clamp, exp2, log2, reciprocal_sqrt, srgb_encode, srgb_exponent};
use super::Tile;
use super::shade::SHADE_BLOCK;
use super::shadow::{Casting, shadow};
use crate::lighting::LightRecord;
use crate::lighting::shading::Brdf;
use crate::math::color::{LUMINANCE, srgb_decode};
use crate::objective::BURNT;
use multiversion::multiversion;
use std::hint::select_unpredictable;

/// What has been added up in a group.
#[derive(Clone, Copy, Default)]
struct Sum {
    /// Radiance towards the viewer, by channel.
    radiance: [Lanes; 3],
    /// Diffuse irradiance.
    irradiance: Lanes,
}

/// What the passes over a group hand on, of one light.
#[derive(Clone, Copy, Default)]
struct Interim {
    /// Unit vector to the light.
    towards: [Lanes; 3],
    /// `n·l`.
    facing: Lanes,
    /// What of the light arrives: falloff, cone, `n·l` and visibility; 0 on the far side.
    received: Lanes,
    /// `n·(l + v)`, not below 0, and `|l + v|²`.
    along: Lanes,
    length2: Lanes,
    /// Value of the lobe, without the Fresnel term.
    lobe: Lanes,
    /// Schlick's `(1 − v·h)⁵`; 0 of Blinn-Phong.
    grazing: Lanes,
}

/// Two planes of `stride` tiles for each rig of `lights` lights: the picture `I` of the groups, and their
/// encoded irradiance `e`, as `-1 - e` where a channel is burnt out; see [`crate::cpu::population`].
#[multiversion(targets = "simd")]
pub fn shade_color(
    surface: (&[Group], &[ColorGroup]),
    casting: &Casting,
    (rigs, lights): (&[LightRecord], usize),
    brdf: Brdf,
    (planes, stride): (&mut [Tile], usize),
) {
    color_in_lanes(surface, casting, (rigs, lights), brdf, (planes, stride));
}

#[inline(always)]
pub(super) fn color_in_lanes(
    (groups, colors): (&[Group], &[ColorGroup]),
    casting: &Casting,
    (rigs, lights): (&[LightRecord], usize),
    brdf: Brdf,
    (planes, stride): (&mut [Tile], usize),
) {
    let mut room = [(Sum::default(), Interim::default()); SHADE_BLOCK];
    let blocks = groups.chunks(SHADE_BLOCK).zip(colors.chunks(SHADE_BLOCK));
    for (block, (groups, colors)) in blocks.enumerate() {
        let first = block * SHADE_BLOCK;
        for (rig, planes) in rigs.chunks_exact(lights).zip(planes.chunks_exact_mut(2 * stride)) {
            let room = &mut room[..groups.len()];
            light_block((groups, colors, first), casting, rig, brdf, room);
            let (pictures, irradiances) = planes.split_at_mut(stride);
            let (pictures, irradiances) = (&mut pictures[first..], &mut irradiances[first..]);
            finish(room, pictures, irradiances);
        }
    }
}

/// The colours of the groups under one rig: sRGB-encoded channels 0..=1, which are those of
/// [`crate::cpu::population::color_picture`].
#[multiversion(targets = "simd")]
pub fn paint(
    surface: (&[Group], &[ColorGroup]),
    casting: &Casting,
    rig: &[LightRecord],
    brdf: Brdf,
    painted: &mut [[Lanes; 3]],
) {
    let (groups, colors) = surface;
    let mut room = [(Sum::default(), Interim::default()); SHADE_BLOCK];
    let blocks = groups.chunks(SHADE_BLOCK).zip(colors.chunks(SHADE_BLOCK));
    let blocks = blocks.zip(painted.chunks_mut(SHADE_BLOCK));
    for (block, ((groups, colors), painted)) in blocks.enumerate() {
        let room = &mut room[..groups.len()];
        light_block((groups, colors, block * SHADE_BLOCK), casting, rig, brdf, room);
        for ((sum, _), painted) in room.iter().zip(painted) {
            for (radiance, encoded) in sum.radiance.iter().zip(painted) {
                encode(radiance, encoded);
            }
        }
    }
}

/// Adds up what a rig does in the groups of a block, the first of which is number `first`.
#[inline(always)]
fn light_block(
    (groups, colors, first): (&[Group], &[ColorGroup], usize),
    casting: &Casting,
    rig: &[LightRecord],
    brdf: Brdf,
    room: &mut [(Sum, Interim)],
) {
    room.iter_mut().zip(colors).for_each(|((sum, _), color)| {
        *sum = Sum { radiance: color.unlit, irradiance: [0.0; LANES] };
    });
    let surface = (groups, colors, first);
    for light in rig {
        match (brdf.is_gltf(), light.radius2 > 0.0) {
            (false, true) => add::<false, true>(surface, casting, light, room),
            (false, false) => add::<false, false>(surface, casting, light, room),
            (true, true) => add::<true, true>(surface, casting, light, room),
            (true, false) => add::<true, false>(surface, casting, light, room),
        }
    }
}

/// Clamps and sRGB-encodes, in passes as everything here.
#[inline(always)]
fn encode(linear: &Lanes, encoded: &mut Lanes) {
    let mut exponents = [0.0; LANES];
    for k in 0..LANES {
        encoded[k] = clamp(linear[k]);
        exponents[k] = srgb_exponent(encoded[k]);
    }
    for k in 0..LANES {
        encoded[k] = srgb_encode(encoded[k], exponents[k]);
    }
}

/// Adds one light to the groups of a block, the first of which is number `first`; the formula is
/// [`crate::lighting::shading::Shading::response`]. In short passes, as the plain shading.
#[inline(always)]
fn add<const GLTF: bool, const POINT: bool>(
    (groups, colors, first): (&[Group], &[ColorGroup], usize),
    casting: &Casting,
    light: &LightRecord,
    room: &mut [(Sum, Interim)],
) {
    let mut lit = [0; SHADE_BLOCK];
    let mut count = 0;
    for (at, (group, (_, interim))) in groups.iter().zip(&mut *room).enumerate() {
        let any = arrive::<POINT>(group, light, interim);
        lit[count] = at;
        count += usize::from(any);
    }
    if let Some(shadows) = casting.shadows {
        let reached = std::mem::take(&mut count);
        for number in 0..reached {
            let at = lit[number];
            let Interim { towards, received, .. } = &mut room[at].1;
            shadow(casting, shadows, first + at, light, towards, received);
            lit[count] = at;
            // All are looked at, which takes less than a branch for each.
            count += usize::from(received.iter().fold(false, |any, &part| any | (part > 0.0)));
        }
    }
    let lit = &lit[..count];
    for &at in lit {
        find_half_vector(&groups[at], &mut room[at].1);
    }
    for &at in lit {
        match GLTF {
            true => ggx(&groups[at], &colors[at], &mut room[at].1),
            false => blinn_phong(&colors[at], &mut room[at].1),
        }
    }
    for &at in lit {
        let (sum, interim) = &mut room[at];
        reflect::<GLTF>(&colors[at], light, interim, sum);
    }
}

/// What of the light arrives, and whether any of it does.
#[inline(always)]
fn arrive<const POINT: bool>(group: &Group, light: &LightRecord, interim: &mut Interim) -> bool {
    let mut any = false;
    for k in 0..LANES {
        let (l, falloff) = towards::<POINT>(group, light, k);
        let n_l = dot(at(&group.normal, k), l);
        let cosine = -dot(light.axis, l);
        let cone = clamp(cosine.mul_add(light.cone_scale, light.cone_offset));
        interim.received[k] = if n_l > 0.0 { falloff * n_l * (cone * cone) } else { 0.0 };
        interim.facing[k] = n_l;
        for (axis, l) in l.into_iter().enumerate() {
            interim.towards[axis][k] = l;
        }
        any |= n_l > 0.0;
    }
    any
}

/// Unit vector to the light and its falloff with the distance.
#[inline(always)]
fn towards<const POINT: bool>(group: &Group, light: &LightRecord, k: usize) -> ([f32; 3], f32) {
    let [x, y, z] = light.position;
    if !POINT {
        return ([x, y, z], 1.0);
    }
    let [px, py, pz] = at(&group.position, k);
    let (x, y, z) = (x - px, y - py, z - pz);
    let inverse = reciprocal_sqrt(x.mul_add(x, y.mul_add(y, z * z)));
    ([x * inverse, y * inverse, z * inverse], light.radius2 * (inverse * inverse))
}

#[inline(always)]
fn find_half_vector(group: &Group, interim: &mut Interim) {
    for k in 0..LANES {
        let [lx, ly, lz] = at(&interim.towards, k);
        let [vx, vy, vz] = at(&group.to_viewer, k);
        let (hx, hy, hz) = (lx + vx, ly + vy, lz + vz);
        // The summand keeps 0/0 away.
        interim.length2[k] = hx.mul_add(hx, hy.mul_add(hy, hz.mul_add(hz, f32::MIN_POSITIVE)));
        let along = interim.facing[k] + group.facing[k];
        interim.along[k] = if along > 0.0 { along } else { 0.0 };
    }
}

/// `(n·h)^s`.
#[inline(always)]
fn blinn_phong(color: &ColorGroup, interim: &mut Interim) {
    for k in 0..LANES {
        let along = interim.along[k];
        let n_h2 = along * along / interim.length2[k];
        interim.lobe[k] = exp2(color.lobe[k] * log2(if n_h2 < 1.0 { n_h2 } else { 1.0 }));
    }
}

/// The distribution of the normals times their visibility and π, and Schlick's `(1 − v·h)⁵`.
#[inline(always)]
fn ggx(group: &Group, color: &ColorGroup, interim: &mut Interim) {
    for k in 0..LANES {
        let (alpha2, length2) = (color.lobe[k], interim.length2[k]);
        let inverse2 = 1.0 / length2;
        let v_h = 0.5 * length2 * reciprocal_sqrt(length2);
        let miss = clamp(1.0 - v_h);
        interim.grazing[k] = (miss * miss) * (miss * miss) * miss;
        // The sine of the angle keeps the precision that 1 − cosine² would lose.
        let [nx, ny, nz] = at(&group.normal, k);
        let [vx, vy, vz] = at(&group.to_viewer, k);
        let [lx, ly, lz] = at(&interim.towards, k);
        let [hx, hy, hz] = [lx + vx, ly + vy, lz + vz];
        let (cx, cy, cz) =
            (ny.mul_add(hz, -(nz * hy)), nz.mul_add(hx, -(nx * hz)), nx.mul_add(hy, -(ny * hx)));
        let sine2 = cx.mul_add(cx, cy.mul_add(cy, cz * cz)) * inverse2;
        let along = interim.along[k];
        interim.lobe[k] = (along * along * inverse2).mul_add(alpha2, sine2);
    }
    for k in 0..LANES {
        let (alpha2, n_l, spread) = (color.lobe[k], interim.facing[k], interim.lobe[k]);
        let n_v = if group.facing[k] > 1e-4 { group.facing[k] } else { 1e-4 };
        let masking = masking(n_l, n_v, alpha2) + masking(n_v, n_l, alpha2);
        interim.lobe[k] = 0.5 * alpha2 / (spread * spread * masking);
    }
}

#[inline(always)]
fn masking(a: f32, b: f32, alpha2: f32) -> f32 {
    let square = (b * b).mul_add(1.0 - alpha2, alpha2);
    a * (square * reciprocal_sqrt(square))
}

/// Adds what is reflected.
#[inline(always)]
fn reflect<const GLTF: bool>(
    color: &ColorGroup,
    light: &LightRecord,
    interim: &Interim,
    sum: &mut Sum,
) {
    let Interim { received, lobe, grazing, .. } = interim;
    let mut irradiance = [0.0; LANES];
    for k in 0..LANES {
        irradiance[k] = received[k].mul_add(light.diffuse, sum.irradiance[k]);
    }
    sum.irradiance = irradiance;
    let mut specular = [0.0; LANES];
    for k in 0..LANES {
        // What is infinite on unlit pixels must not meet their 0. A plain `if` becomes a branch.
        let lobe = lobe[k] * light.specular;
        specular[k] = select_unpredictable(received[k] > 0.0, lobe, 0.0);
    }
    let lit = Lit { received, specular: &specular, grazing };
    for (c, radiance) in sum.radiance.iter_mut().enumerate() {
        let reflectance = [&color.diffuse[c], &color.specular[c]];
        let tint = [light.color[c], light.diffuse];
        *radiance = reflect_channel::<GLTF>(radiance, reflectance, tint, &lit);
    }
}

/// What all channels of a group have in common, of one light.
struct Lit<'a> {
    received: &'a Lanes,
    /// The lobe times the light's specular intensity; 0 where nothing is received.
    specular: &'a Lanes,
    grazing: &'a Lanes,
}

/// A channel's radiance with what it reflects of a light, whose part in it and diffuse intensity `tint` has.
/// Made in an array of its own: written over the old one, compilers take the channels for the lanes of vectors.
#[inline(always)]
fn reflect_channel<const GLTF: bool>(
    before: &Lanes,
    [diffuse, specular]: [&Lanes; 2],
    [part, intensity]: [f32; 2],
    lit: &Lit,
) -> Lanes {
    let mut radiance = [0.0; LANES];
    for k in 0..LANES {
        let (f0, grazing) = (specular[k], lit.grazing[k]);
        let fresnel = if GLTF { (1.0 - f0).mul_add(grazing, f0) } else { f0 };
        let matt = if GLTF { 1.0 - grazing } else { 1.0 };
        let diffuse = diffuse[k] * matt * intensity;
        let reflected = fresnel.mul_add(lit.specular[k], diffuse);
        radiance[k] = (lit.received[k] * part).mul_add(reflected, before[k]);
    }
    radiance
}

/// Encodes what has been added up, in passes for the same reason.
#[inline(always)]
fn finish(room: &mut [(Sum, Interim)], pictures: &mut [Tile], irradiances: &mut [Tile]) {
    let burnt = srgb_decode(BURNT);
    let weights = LUMINANCE.to_array();
    let planes = pictures.iter_mut().zip(irradiances);
    for ((sum, interim), (picture, irradiance)) in room.iter_mut().zip(planes) {
        let [r, g, b] = &sum.radiance;
        let Interim { lobe: luminances, along: exponents, received: e, facing: powers, .. } =
            interim;
        for k in 0..LANES {
            let mixed = r[k].mul_add(weights[0], g[k].mul_add(weights[1], b[k] * weights[2]));
            luminances[k] = clamp(mixed);
            exponents[k] = srgb_exponent(luminances[k]);
        }
        for k in 0..LANES {
            e[k] = clamp(sum.irradiance[k]);
            powers[k] = srgb_exponent(e[k]);
        }
        for k in 0..LANES {
            picture.0[k] = srgb_encode(luminances[k], exponents[k]);
        }
        for k in 0..LANES {
            let e = srgb_encode(e[k], powers[k]);
            let white = (r[k] >= burnt) | (g[k] >= burnt) | (b[k] >= burnt);
            irradiance.0[k] = if white { -1.0 - e } else { e };
        }
    }
}

#[inline(always)]
fn at(vectors: &[Lanes; 3], k: usize) -> [f32; 3] {
    let [x, y, z] = vectors;
    [x[k], y[k], z[k]]
}

#[inline(always)]
fn dot([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> f32 {
    ax.mul_add(bx, ay.mul_add(by, az * bz))
}
