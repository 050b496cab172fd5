//! Rigs in colour: the pictures `I` and what the lights do, for any lights and either BRDF.

use super::super::compact::{ColorGroup, Group, LANES, Lanes};
use super::super::fast_math::{clamp, exp2, log2, reciprocal_sqrt, srgb_encode, srgb_exponent};
use super::Tile;
use crate::lighting::LightRecord;
use crate::lighting::shading::Brdf;
use crate::math::color::{LUMINANCE, srgb_decode};
use crate::objective::BURNT;
use multiversion::multiversion;

/// What has been added up in a group.
struct Light {
    /// Radiance towards the viewer, by channel.
    radiance: [Lanes; 3],
    /// Diffuse irradiance.
    irradiance: Lanes,
}

/// Two planes of `stride` tiles for each rig of `lights` lights: the picture `I` of the groups, and their
/// encoded irradiance `e`, as `-1 - e` where a channel is burnt out; see [`crate::cpu::population`].
#[multiversion(targets = "simd")]
pub fn shade_color(
    (groups, colors): (&[Group], &[ColorGroup]),
    (rigs, lights): (&[LightRecord], usize),
    brdf: Brdf,
    planes: &mut [Tile],
    stride: usize,
) {
    color_in_lanes((groups, colors), (rigs, lights), brdf, planes, stride);
}

#[inline(always)]
pub(super) fn color_in_lanes(
    (groups, colors): (&[Group], &[ColorGroup]),
    (rigs, lights): (&[LightRecord], usize),
    brdf: Brdf,
    planes: &mut [Tile],
    stride: usize,
) {
    let burnt = srgb_decode(BURNT);
    for (at, (group, color)) in groups.iter().zip(colors).enumerate() {
        for (rig, planes) in rigs.chunks_exact(lights).zip(planes.chunks_exact_mut(2 * stride)) {
            let (pictures, irradiances) = planes.split_at_mut(stride);
            let mut sum = Light { radiance: color.unlit, irradiance: [0.0; LANES] };
            for light in rig {
                match (brdf, light.radius2 > 0.0) {
                    (Brdf::BlinnPhong, true) => add::<false, true>(group, color, light, &mut sum),
                    (Brdf::BlinnPhong, false) => add::<false, false>(group, color, light, &mut sum),
                    (Brdf::Gltf, true) => add::<true, true>(group, color, light, &mut sum),
                    (Brdf::Gltf, false) => add::<true, false>(group, color, light, &mut sum),
                }
            }
            finish(&sum, burnt, &mut pictures[at].0, &mut irradiances[at].0);
        }
    }
}

/// Adds one light; the formula is [`crate::lighting::shading::Shading::response`].
#[inline(always)]
fn add<const GLTF: bool, const POINT: bool>(
    group: &Group,
    color: &ColorGroup,
    light: &LightRecord,
    sum: &mut Light,
) {
    let (mut received, mut lobe) = ([0.0; LANES], [0.0; LANES]);
    let mut grazing = [0.0; LANES];
    let mut any = false;
    for k in 0..LANES {
        let (l, falloff) = towards::<POINT>(group, light, k);
        let n_l = dot(at(&group.normal, k), l);
        let cosine = -dot(light.axis, l);
        let cone = clamp(cosine.mul_add(light.cone_scale, light.cone_offset));
        received[k] = if n_l > 0.0 { falloff * n_l * (cone * cone) } else { 0.0 };
        any |= n_l > 0.0;
        (lobe[k], grazing[k]) = if GLTF {
            ggx(group, color, k, l, n_l)
        } else {
            (blinn_phong(group, color, k, l), 0.0)
        };
    }
    if !any {
        return;
    }
    for k in 0..LANES {
        sum.irradiance[k] = received[k].mul_add(light.diffuse, sum.irradiance[k]);
        // What is infinite on unlit pixels must not meet their 0.
        lobe[k] = if received[k] > 0.0 { lobe[k] * light.specular } else { 0.0 };
    }
    for (c, radiance) in sum.radiance.iter_mut().enumerate() {
        for k in 0..LANES {
            let f0 = color.specular[c][k];
            let fresnel = if GLTF { (1.0 - f0).mul_add(grazing[k], f0) } else { f0 };
            let matt = if GLTF { 1.0 - grazing[k] } else { 1.0 };
            let diffuse = color.diffuse[c][k] * matt * light.diffuse;
            let reflected = fresnel.mul_add(lobe[k], diffuse);
            radiance[k] = (received[k] * light.color[c]).mul_add(reflected, radiance[k]);
        }
    }
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

/// `(n·h)^s`.
#[inline(always)]
fn blinn_phong(group: &Group, color: &ColorGroup, k: usize, l: [f32; 3]) -> f32 {
    let (along, length2) = half(group, k, l);
    let n_h2 = along * along / length2;
    exp2(color.lobe[k] * log2(if n_h2 < 1.0 { n_h2 } else { 1.0 }))
}

/// The distribution of the normals times their visibility and π, and Schlick's `(1 − v·h)⁵`.
#[inline(always)]
fn ggx(group: &Group, color: &ColorGroup, k: usize, l: [f32; 3], n_l: f32) -> (f32, f32) {
    let alpha2 = color.lobe[k];
    let (along, length2) = half(group, k, l);
    let inverse2 = 1.0 / length2;
    let v_h = 0.5 * length2 * reciprocal_sqrt(length2);
    let miss = clamp(1.0 - v_h);
    let grazing = (miss * miss) * (miss * miss) * miss;
    // The sine of the angle keeps the precision that 1 − cosine² would lose.
    let [nx, ny, nz] = at(&group.normal, k);
    let [vx, vy, vz] = at(&group.to_viewer, k);
    let [hx, hy, hz] = [l[0] + vx, l[1] + vy, l[2] + vz];
    let (cx, cy, cz) =
        (ny.mul_add(hz, -(nz * hy)), nz.mul_add(hx, -(nx * hz)), nx.mul_add(hy, -(ny * hx)));
    let sine2 = cx.mul_add(cx, cy.mul_add(cy, cz * cz)) * inverse2;
    let spread = (along * along * inverse2).mul_add(alpha2, sine2);
    let distribution = alpha2 / (spread * spread);
    let n_v = if group.facing[k] > 1e-4 { group.facing[k] } else { 1e-4 };
    let masking = masking(n_l, n_v, alpha2) + masking(n_v, n_l, alpha2);
    (distribution * (0.5 / masking), grazing)
}

#[inline(always)]
fn masking(a: f32, b: f32, alpha2: f32) -> f32 {
    let square = (b * b).mul_add(1.0 - alpha2, alpha2);
    a * (square * reciprocal_sqrt(square))
}

/// `n·(l + v)`, not below 0, and `|l + v|²`.
#[inline(always)]
fn half(group: &Group, k: usize, l: [f32; 3]) -> (f32, f32) {
    let [vx, vy, vz] = at(&group.to_viewer, k);
    let (hx, hy, hz) = (l[0] + vx, l[1] + vy, l[2] + vz);
    let length2 = hx.mul_add(hx, hy.mul_add(hy, hz.mul_add(hz, f32::MIN_POSITIVE)));
    let along = dot(at(&group.normal, k), l) + group.facing[k];
    (if along > 0.0 { along } else { 0.0 }, length2)
}

/// Encodes what has been added up.
#[inline(always)]
fn finish(sum: &Light, burnt: f32, picture: &mut Lanes, irradiance: &mut Lanes) {
    let [r, g, b] = &sum.radiance;
    let weights = LUMINANCE.to_array();
    for k in 0..LANES {
        let luminance =
            clamp(r[k].mul_add(weights[0], g[k].mul_add(weights[1], b[k] * weights[2])));
        picture[k] = srgb_encode(luminance, srgb_exponent(luminance));
        let e = clamp(sum.irradiance[k]);
        let e = srgb_encode(e, srgb_exponent(e));
        let white = r[k] >= burnt || g[k] >= burnt || b[k] >= burnt;
        irradiance[k] = if white { -1.0 - e } else { e };
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
