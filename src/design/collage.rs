//! Light Collages (Lee, Hao and Varshney, *Light Collages: Lighting Design for Effective Visualization*, 2004): each patch of
//! the surface has a light of its own, which is consistent within the patch and not with the others. The picture that is
//! made so is one that no lights make; [`paint`](super::paint) finds those that come nearest to it. Formulas and numbers
//! are our reconstruction, `docs/METHOD.md`.

mod patches;

use crate::constants::CURVATURE_MOST;
use crate::cpu::neighbourhood::around;
use crate::lighting::LightRecord;
use crate::lighting::shading::{Place, Reflectance, Shading};
use crate::math::color::{luminance, srgb_encode};
use crate::objective::maps::{Maps, PixelType};
use crate::scene::TextureLevel;
use crate::scene::view::View;
use glam::Vec3;
use patches::{NONE, patches};
use rayon::prelude::*;

/// Samples of a pixel along each side.
pub const SAMPLES: u32 = 2;
/// Directions that a patch's light may have.
const DIRECTIONS: usize = 600;
/// Largest cosine of the angle between them and the line of sight: light along it would be flat.
const ALONG: f32 = 0.7;
/// Most pixels of a patch that its placement looks at.
const PLACED: usize = 1 << 10;
/// What of the mean curvature of a patch a place has to exceed to be worth light,
const WORTH: f32 = 0.5;
/// and exponent and weight of highlights in the placement, which are good where the surface curves more than on average
/// and bad elsewhere.
const SHARPNESS: f32 = 24.0;
const HIGHLIGHTS: f32 = 1.0;
/// Intensity of the light on silhouettes, as a share of the patches'.
const SILHOUETTE: f32 = 0.9;
/// Parts of the picture's longer side across which patches blend,
const BLEND: f32 = 50.0;
/// and distance in depth from which on they do not, scene radii.
const APART: f32 = 0.06;

/// A picture of the view's surface under a collage of lights.
pub struct Collage {
    /// RGBA, [`SAMPLES`]² of the view's pixels to one, transparent beside the object.
    pub picture: TextureLevel,
    /// The patches' number.
    pub patches: usize,
}

impl Collage {
    /// Of a view that is [`SAMPLES`] times as large as its picture; `mean` is the mean brightness that is wanted,
    /// sRGB-encoded. Shadows that the maps have are not looked at.
    pub fn new((maps, view, shading): (&Maps, &View, &Shading), mean: f32) -> Self {
        let curvature = curvature(maps);
        let (labels, patches) = patches(maps, &curvature);
        let lights = lights(maps, view, (&labels, patches), &curvature);
        let shade = Shade { maps, view, shading, curvature: &curvature };
        let shaded = |at: usize| match labels[at] {
            NONE => [Vec3::ZERO; 2],
            _ => shade.pixel(at, &blend(maps, &labels, at), &lights),
        };
        let shaded: Vec<[Vec3; 2]> = (0..labels.len()).into_par_iter().map(shaded).collect();
        let exposure = exposure(&labels, &shaded, mean);
        let shown =
            |at: usize| (labels[at] != NONE).then(|| shaded[at][0] + exposure * shaded[at][1]);
        Self { picture: averaged(maps, shown), patches }
    }
}

/// What each pixel curves, 0 to 1: `|∇n|` as a share of four times its mean, smoothed.
fn curvature(maps: &Maps) -> Vec<f32> {
    let most = (CURVATURE_MOST * maps.normal_detail).max(1e-6);
    let (width, height) = (maps.surface.width, maps.surface.height);
    let mut curvature: Vec<f32> =
        maps.normal_gradient.iter().map(|gradient| (gradient / most).min(1.0)).collect();
    for _ in 0..1 + width.max(height) / 128 {
        let smooth = |at: usize| {
            if maps.types[at] != PixelType::Surface {
                return 0.0;
            }
            let near = around(width, height, at).chain([at]);
            let near = near.filter(|&tap| maps.types[tap] == PixelType::Surface);
            let (sum, count) =
                near.fold((0.0, 0.0), |(sum, count), tap| (sum + curvature[tap], count + 1.0));
            sum / count
        };
        curvature = (0..curvature.len()).into_par_iter().map(smooth).collect();
    }
    curvature
}

/// The direction of each patch's light: of [`directions`], the one of the highest `D + S`. `D` is the mean
/// of `(κ − κ̄/2)·(n·l)` over the patch, light in proportion to the curvature `κ`; `S` that of `(κ − K)·(n·h)^24`, highlights
/// where it is above its mean `K` over the object.
fn lights(
    maps: &Maps,
    view: &View,
    (labels, count): (&[u32], usize),
    curvature: &[f32],
) -> Vec<Vec3> {
    let mut members = vec![Vec::new(); count];
    for (at, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        members[label as usize].push(at);
    }
    let mean_of = |pixels: &[usize]| {
        pixels.iter().map(|&at| curvature[at]).sum::<f32>() / pixels.len().max(1) as f32
    };
    let all = members.concat();
    let usual = mean_of(&all);
    let best = |pixels: &Vec<usize>| {
        let worth = WORTH * mean_of(pixels);
        let step = pixels.len().div_ceil(PLACED).max(1);
        let sample = |&at: &usize| {
            let position = Vec3::from(maps.surface.position[at]);
            let (n, v) = (Vec3::from(maps.surface.normal[at]), view.towards_viewer(position));
            (n, v, curvature[at] - worth, curvature[at] - usual)
        };
        let samples: Vec<_> = pixels.iter().step_by(step).map(sample).collect();
        let placed = |l: Vec3| {
            let one = |&(n, v, diffuse, specular): &(Vec3, Vec3, f32, f32)| {
                let n_l = n.dot(l).max(0.0);
                let n_h = n.dot((l + v).normalize_or_zero()).max(0.0);
                let highlight = if n_l > 0.0 { n_h.powf(SHARPNESS) } else { 0.0 };
                diffuse * n_l + HIGHLIGHTS * specular * highlight
            };
            samples.iter().map(one).sum::<f32>()
        };
        let scored = directions().map(|l| (l, placed(l)));
        scored.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(Vec3::Z, |(l, _)| l)
    };
    members.par_iter().map(best).collect()
}

/// Directions in front of the viewer and above, off the line of sight, evenly spread along a spiral.
fn directions() -> impl Iterator<Item = Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    let spiral = (0..2 * DIRECTIONS).map(move |k| {
        let z = ALONG * (1.0 - (k as f32 + 0.5) / (2 * DIRECTIONS) as f32);
        let (sin, cos) = (golden * k as f32).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    });
    spiral.filter(|l| l.y >= 0.0)
}

/// The patches around a pixel and what each counts there: by its distance, and as far as the surface goes on.
fn blend(maps: &Maps, labels: &[u32], at: usize) -> Vec<(u32, f32)> {
    let (width, height) = (i64::from(maps.surface.width), i64::from(maps.surface.height));
    let (x, y) = (at as i64 % width, at as i64 / width);
    let radius = (width.max(height) as f32 / BLEND).ceil() as i64;
    let mut parts: Vec<(u32, f32)> = Vec::new();
    for row in (y - radius).max(0)..=(y + radius).min(height - 1) {
        for column in (x - radius).max(0)..=(x + radius).min(width - 1) {
            let tap = (row * width + column) as usize;
            if labels[tap] == NONE {
                continue;
            }
            let away = ((column - x).pow(2) + (row - y).pow(2)) as f32 / (radius * radius) as f32;
            let deep = (maps.surface.depth[tap] - maps.surface.depth[at]) / APART;
            let weight = (-2.0 * away - deep * deep).exp();
            match parts.iter_mut().find(|part| part.0 == labels[tap]) {
                Some(part) => part.1 += weight,
                None => parts.push((labels[tap], weight)),
            }
        }
    }
    let sum: f32 = parts.iter().map(|part| part.1).sum();
    parts.iter_mut().for_each(|part| part.1 /= sum);
    parts
}

/// What shades pixels.
struct Shade<'a> {
    maps: &'a Maps,
    view: &'a View,
    shading: &'a Shading,
    curvature: &'a [f32],
}

impl Shade<'_> {
    /// Linear radiance of a pixel without its lights, and what these add: the lights of the patches around it, which
    /// are as strong as the surface curves, and the light on its silhouette.
    fn pixel(&self, at: usize, patches: &[(u32, f32)], lights: &[Vec3]) -> [Vec3; 2] {
        let surface = &self.maps.surface;
        let (position, normal) = (Vec3::from(surface.position[at]), Vec3::from(surface.normal[at]));
        let place = Place { position, normal, to_viewer: self.view.towards_viewer(position) };
        let looks: Reflectance = surface.reflectance(self.shading, at);
        let curved = self.curvature[at];
        let mut lit = Vec3::ZERO;
        for &(patch, share) in patches {
            let position = lights[patch as usize].to_array();
            let (diffuse, specular) = (share * (0.5 + curved), share * curved.sqrt());
            let light = LightRecord { position, diffuse, specular, ..LightRecord::DARK };
            lit += self.shading.response(&light, &place, &looks).radiance;
        }
        let facing = normal.dot(place.to_viewer).clamp(0.0, 1.0);
        let aside = (normal - facing * place.to_viewer).normalize_or(normal);
        let diffuse = SILHOUETTE * (1.0 - facing).powi(3) * (2.0 * curved).min(1.0);
        let position = aside.to_array();
        let light = LightRecord { position, diffuse, ..LightRecord::DARK };
        lit += self.shading.response(&light, &place, &looks).radiance;
        [looks.unlit, lit]
    }
}

/// The intensity of all lights that gives the object the wanted mean brightness, by bisection.
fn exposure(labels: &[u32], shaded: &[[Vec3; 2]], mean: f32) -> f32 {
    let objects = || std::iter::zip(labels, shaded).filter(|(label, _)| **label != NONE);
    let count = objects().count().max(1) as f32;
    let made = |exposure: f32| {
        let bright = |[unlit, lit]: &[Vec3; 2]| {
            srgb_encode(luminance((*unlit + exposure * *lit).min(Vec3::ONE)))
        };
        objects().map(|(_, pixel)| bright(pixel)).sum::<f32>() / count
    };
    let (mut low, mut high) = (0.0, 16.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if made(middle) < mean { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The picture, each of whose pixels is the mean of [`SAMPLES`]² of the maps', as far as they show the object.
fn averaged(maps: &Maps, shown: impl Fn(usize) -> Option<Vec3>) -> TextureLevel {
    let (width, height) = (maps.surface.width / SAMPLES, maps.surface.height / SAMPLES);
    let texel = |place: u32| {
        let corner = [place % width, place / width].map(|side| side * SAMPLES);
        let sample = |k: u32| {
            let [x, y] = [corner[0] + k % SAMPLES, corner[1] + k / SAMPLES];
            shown((y * maps.surface.width + x) as usize)
        };
        let samples: Vec<Vec3> = (0..SAMPLES * SAMPLES).filter_map(sample).collect();
        let covered = samples.len() as f32;
        let mean =
            samples.iter().map(|color| color.min(Vec3::ONE)).sum::<Vec3>() / covered.max(1.0);
        let byte = |share: f32| (share * 255.0).round() as u8;
        let [r, g, b] = mean.to_array().map(|channel| byte(srgb_encode(channel)));
        [r, g, b, byte(covered / (SAMPLES * SAMPLES) as f32)]
    };
    TextureLevel { width, height, texels: (0..width * height).map(texel).collect() }
}

#[cfg(test)]
mod tests;
