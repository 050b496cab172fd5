//! The picture of one individual: the stored surface under the rig's lights.

use crate::lighting::LightRecord;
use crate::lighting::shading::{Shading, light_response};
use crate::math::color::{luminance, srgb_encode};
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

/// Linear radiance `L` of pixel `at` towards the viewer; `None` in the background.
fn radiance(
    maps: &Maps,
    view: &View,
    shading: &Shading,
    rig: &[LightRecord],
    at: usize,
) -> Option<Vec3> {
    let surface = &maps.surface;
    if surface.code[at] == 0 {
        return None;
    }
    let (p, n) = (Vec3::from(surface.position[at]), Vec3::from(surface.normal[at]));
    let v = view.towards_viewer(p);
    let reflectance = shading.reflectance(
        surface.base_color[at].into(),
        surface.metallic[at],
        surface.roughness[at],
        surface.emissive[at].into(),
    );
    Some(rig.iter().fold(reflectance.unlit, |l, light| {
        let (diffuse, specular) = light_response(light, p, n, v, reflectance.shininess);
        l + reflectance.diffuse * diffuse + reflectance.specular * specular
    }))
}
