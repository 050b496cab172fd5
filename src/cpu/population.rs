//! The picture of one individual: the stored surface under the rig's lights.

use crate::lighting::LightRecord;
use crate::lighting::shading::{Place, Response, Shading};
use crate::math::color::{luminance, srgb_decode, srgb_encode};
use crate::objective::BURNT;
use crate::objective::maps::Maps;
use crate::scene::view::View;
use glam::Vec3;
use image::{Rgb, RgbImage};

/// The picture `I` that is judged: sRGB-encoded luminance 0..=1, 0 in the background, one entry a
/// pixel, rows from the top.
pub fn picture(maps: &Maps, view: &View, shading: &Shading, rig: &[LightRecord]) -> Vec<f32> {
    let brightness =
        |at| radiance(maps, view, shading, rig, at).map_or(0.0, |l| srgb_encode(luminance(l)));
    (0..maps.types.len()).map(brightness).collect()
}

/// The same picture in colour, for people: each channel is clamped and sRGB-encoded.
pub fn color_picture(
    maps: &Maps,
    view: &View,
    shading: &Shading,
    rig: &[LightRecord],
    background: [u8; 3],
) -> RgbImage {
    let surface = &maps.surface;
    RgbImage::from_fn(surface.width, surface.height, |x, y| {
        let at = y as usize * surface.width as usize + x as usize;
        Rgb(radiance(maps, view, shading, rig, at).map_or(background, |l| {
            l.to_array().map(|channel| (srgb_encode(channel) * 255.0).round() as u8)
        }))
    })
}

/// The encoded diffuse irradiance `e = sRGB(min(1, E))`, 0 in the background, one entry a pixel.
pub fn irradiance(maps: &Maps, view: &View, shading: &Shading, rig: &[LightRecord]) -> Vec<f32> {
    let encoded = |at| lit(maps, view, shading, rig, at).map_or(0.0, |l| srgb_encode(l.irradiance));
    (0..maps.types.len()).map(encoded).collect()
}

/// Whether each pixel has a channel that is burnt out ([`BURNT`]); the background has none.
pub fn burnt(maps: &Maps, view: &View, shading: &Shading, rig: &[LightRecord]) -> Vec<bool> {
    let most = srgb_decode(BURNT);
    let burnt =
        |at| lit(maps, view, shading, rig, at).is_some_and(|l| l.radiance.max_element() >= most);
    (0..maps.types.len()).map(burnt).collect()
}

/// Radiance of pixel `at` towards the viewer, and its irradiance; `None` in the background.
fn lit(
    maps: &Maps,
    view: &View,
    shading: &Shading,
    rig: &[LightRecord],
    at: usize,
) -> Option<Response> {
    let surface = &maps.surface;
    if surface.code[at] == 0 {
        return None;
    }
    let (position, normal) = (Vec3::from(surface.position[at]), Vec3::from(surface.normal[at]));
    let place = Place { position, normal, to_viewer: view.towards_viewer(position) };
    let looks = maps.reflectance(shading, at);
    let visibility = |light: &LightRecord| match maps.shadows.as_ref() {
        Some(shadows) => {
            let number = shadows.number(at).unwrap_or(0);
            shadows.light(number, light, position, surface.face[at].into())
        }
        None => 1.0,
    };
    let unlit = Response { radiance: looks.unlit, irradiance: 0.0 };
    Some(rig.iter().fold(unlit, |sum, light| {
        let one = shading.response(light, &place, &looks);
        let seen = visibility(light);
        Response {
            radiance: sum.radiance + one.radiance * seen,
            irradiance: sum.irradiance + one.irradiance * seen,
        }
    }))
}

/// Linear radiance that one light adds to pixel `at` towards the viewer; 0 in the background.
pub fn added(maps: &Maps, view: &View, shading: &Shading, light: &LightRecord, at: usize) -> Vec3 {
    let lit = radiance(maps, view, shading, std::slice::from_ref(light), at);
    lit.map_or(Vec3::ZERO, |lit| lit - maps.reflectance(shading, at).unlit)
}

/// Linear radiance of pixel `at` towards the viewer; `None` in the background.
pub fn radiance(
    maps: &Maps,
    view: &View,
    shading: &Shading,
    rig: &[LightRecord],
    at: usize,
) -> Option<Vec3> {
    lit(maps, view, shading, rig, at).map(|lit| lit.radiance)
}
