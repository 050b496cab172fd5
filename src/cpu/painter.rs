//! The picture of a rig in colour, fast: for people who watch while they move a light.

use super::compact::{ColorGroup, LANES, Lanes, Pixels};
use super::kernels::{self, Casting};
use crate::lighting::LightRecord;
use crate::lighting::shading::{Brdf, Shading};
use crate::objective::maps::Maps;
use crate::objective::shadows::Shadows;
use crate::scene::view::View;
use image::RgbaImage;
use rayon::prelude::*;

/// Groups of a task.
const TASK: usize = 64;

/// Paints rigs on the stored surface of a view, on all cores of rayon's current thread pool.
#[derive(Debug)]
pub struct Painter {
    pixels: Pixels,
    colors: Vec<ColorGroup>,
    /// Positions and polygons' normals, for lights within the scene; empty without shadows.
    places: Vec<[[f32; 3]; 2]>,
    brdf: Brdf,
    size: [u32; 2],
}

impl Painter {
    /// Of the view that `maps` describes.
    pub fn new(maps: &Maps, view: &View, shading: &Shading) -> Self {
        let pixels = Pixels::new(maps, view, shading);
        let place = |at: usize| [maps.surface.position[at], maps.surface.face[at]];
        Self {
            colors: pixels.colors(maps, shading),
            places: if maps.shadows.is_some() { pixels.numbers(place) } else { Vec::new() },
            pixels,
            brdf: shading.brdf,
            size: [maps.surface.width, maps.surface.height],
        }
    }

    /// The picture of a rig with the view's shadow table, if it has one: what
    /// [`color_picture`](super::population::color_picture) shows, opaque.
    pub fn paint(
        &self,
        shadows: Option<&Shadows>,
        rig: &[LightRecord],
        background: [u8; 3],
    ) -> RgbaImage {
        let [width, height] = self.size;
        let [r, g, b] = background;
        let mut picture = RgbaImage::from_pixel(width, height, image::Rgba([r, g, b, u8::MAX]));
        let mut painted = vec![[[0u8; 4]; LANES]; self.pixels.groups.len()];
        painted.par_chunks_mut(TASK).enumerate().for_each(|(task, painted)| {
            self.paint_groups(task * TASK, shadows, rig, painted);
        });
        let pixels: &mut [[u8; 4]] = bytemuck::cast_slice_mut(&mut picture);
        for (&at, color) in self.pixels.at.iter().zip(painted.as_flattened()) {
            pixels[at as usize] = *color;
        }
        picture
    }

    /// Paints the groups from number `first` on.
    fn paint_groups(
        &self,
        first: usize,
        shadows: Option<&Shadows>,
        rig: &[LightRecord],
        painted: &mut [[[u8; 4]; LANES]],
    ) {
        let groups = first..first + painted.len();
        let surface = (&self.pixels.groups[groups.clone()], &self.colors[groups]);
        let casting = Casting { shadows, places: &self.places, first };
        let mut encoded = [[[0.0; LANES]; 3]; TASK];
        let encoded: &mut [[Lanes; 3]] = &mut encoded[..painted.len()];
        kernels::paint(surface, &casting, rig, self.brdf, encoded);
        let byte = |value: f32| (value * 255.0 + 0.5) as u8;
        for (channels, painted) in encoded.iter().zip(painted) {
            for (k, pixel) in painted.iter_mut().enumerate() {
                let [r, g, b] = channels.map(|channel| byte(channel[k]));
                *pixel = [r, g, b, u8::MAX];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::{self, population};
    use crate::design::profile;
    use crate::lighting::presets::Preset;
    use crate::lighting::{Light, LightKind};
    use crate::objective::shadows::ShadowSettings;
    use crate::render::BACKGROUND;
    use crate::scene::framing::{Framing, frame};
    use crate::scene::load::load;
    use std::path::Path;

    #[test]
    fn it_paints_what_the_plain_picture_shows() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb");
        let scene = load(&path).unwrap();
        let camera = frame(&scene, &Framing::default(), 1.0).unwrap();
        let view = View::new(&scene, camera, 96, 96).unwrap();
        for profile in profile::PROFILES {
            let (objective, shading) = ((profile.objective)(), (profile.shading)());
            let shadows = ShadowSettings { on: profile.shadows, ..ShadowSettings::default() };
            let maps = cpu::draw(&scene, &view, &objective, (&shadows, None)).unwrap();
            let mut rig = Preset::ThreePoint.rig();
            rig.push(Light {
                kind: LightKind::SPOT,
                distance: 0.8,
                azimuth: 1.0,
                ..Light::default()
            });
            let records: Vec<LightRecord> = rig.iter().map(Light::record).collect();
            let painter = Painter::new(&maps, &view, &shading);
            let fast = painter.paint(maps.shadows.as_ref(), &records, BACKGROUND);
            let plain = population::color_picture(&maps, &view, &shading, &records, BACKGROUND);
            let off = fast
                .pixels()
                .zip(plain.pixels())
                .flat_map(|(a, b)| (0..3).map(move |channel| a.0[channel].abs_diff(b.0[channel])));
            assert!(off.max().unwrap() <= 1 && fast.pixels().all(|pixel| pixel.0[3] == 255));
            let dark = painter.paint(maps.shadows.as_ref(), &[LightRecord::DARK], BACKGROUND);
            assert_ne!(dark, fast);
        }
    }
}
