//! The object's pixels alone, as the inner loops read them: one array for each number, and lists of
//! the neighbours that the gradients need. Pixels keep their order, rows from the top.

use super::neighbourhood;
use crate::lighting::shading::{Shading, luminance};
use crate::objective::maps::{Maps, PixelType};
use crate::scene::view::View;
use glam::Vec3;
use std::ops::Range;

/// A band ends with the first row that brings it to this many pixels and to [`BAND_ROWS`] rows.
const BAND_PIXELS: usize = 1 << 14;
/// See [`BAND_PIXELS`].
const BAND_ROWS: usize = 32;

/// What shading needs of each object pixel.
#[derive(Debug, Clone, Default)]
pub struct Pixels {
    /// Position in the light frame, by axis.
    pub position: [Vec<f32>; 3],
    /// Unit normal.
    pub normal: [Vec<f32>; 3],
    /// Unit vector to the viewer.
    pub to_viewer: [Vec<f32>; 3],
    /// Luminance of the diffuse reflectance.
    pub diffuse: Vec<f32>,
    /// Luminance of the specular reflectance with its normalisation.
    pub specular: Vec<f32>,
    /// `s·log₂e`, so that `(n·h)^s = 2^(exponent·ln(n·h))`.
    pub exponent: Vec<f32>,
    /// Luminance without any light.
    pub unlit: Vec<f32>,
    /// The pixel's index in the picture.
    pub at: Vec<u32>,
}

/// SURFACE pixels side by side whose neighbourhoods lie in the object. The three indices count from
/// the band's first shaded pixel and name the pixel left of the run's first, its upper and its lower
/// neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Upper row.
    pub above: u32,
    /// The run's own row.
    pub here: u32,
    /// Lower row.
    pub below: u32,
    /// Pixels of the run.
    pub len: u32,
}

/// Some rows of the picture, measured together.
#[derive(Debug, Clone, Default)]
pub struct Band {
    /// Pixels that are measured.
    pub own: Range<usize>,
    /// Pixels that are shaded: the measured ones, and the rows above and below for the gradients.
    pub shaded: Range<usize>,
    /// Inner SURFACE pixels.
    pub runs: Vec<Run>,
    /// Neighbourhoods of the other SURFACE pixels, counted from the first shaded pixel.
    pub surface: Vec<[u32; 9]>,
    /// Neighbourhoods of the EDGE pixels.
    pub edge: Vec<[u32; 9]>,
}

impl Pixels {
    /// The object's pixels.
    pub fn new(maps: &Maps, view: &View, shading: &Shading) -> Self {
        let surface = &maps.surface;
        let mut pixels = Self::default();
        for at in (0..surface.code.len()).filter(|&at| maps.types[at] != PixelType::Background) {
            let position = Vec3::from(surface.position[at]);
            let reflectance = shading.reflectance(
                surface.base_color[at].into(),
                surface.metallic[at],
                surface.roughness[at],
                surface.emissive[at].into(),
            );
            let axes = |columns: &mut [Vec<f32>; 3], vector: [f32; 3]| {
                columns.iter_mut().zip(vector).for_each(|(column, x)| column.push(x));
            };
            axes(&mut pixels.position, surface.position[at]);
            axes(&mut pixels.normal, surface.normal[at]);
            axes(&mut pixels.to_viewer, view.towards_viewer(position).to_array());
            pixels.diffuse.push(luminance(reflectance.diffuse));
            pixels.specular.push(luminance(reflectance.specular));
            pixels.exponent.push(reflectance.shininess * std::f32::consts::LOG2_E);
            pixels.unlit.push(luminance(reflectance.unlit));
            pixels.at.push(at as u32);
        }
        pixels
    }

    /// Cuts the picture into bands. They depend on the maps alone.
    pub fn bands(&self, maps: &Maps) -> Vec<Band> {
        let width = maps.surface.width as usize;
        let row_start = |row: usize| self.at.partition_point(|&at| (at as usize) < row * width);
        let rows: Vec<usize> = (0..=maps.surface.height as usize).map(row_start).collect();
        let mut bands = Vec::new();
        let mut first = 0;
        for end in 1..rows.len() {
            let full = rows[end] - rows[first] >= BAND_PIXELS && end - first >= BAND_ROWS;
            if full || end == rows.len() - 1 {
                let above = rows[first.saturating_sub(1)];
                let below = rows[(end + 1).min(rows.len() - 1)];
                bands.push(self.band(maps, rows[first]..rows[end], above..below));
                first = end;
            }
        }
        bands
    }

    fn band(&self, maps: &Maps, own: Range<usize>, shaded: Range<usize>) -> Band {
        let (width, height) = (maps.surface.width, maps.surface.height);
        let local = |at: usize| {
            let index = self.at[shaded.clone()].binary_search(&(at as u32));
            index.expect("a neighbour in the object lies in the rows that are shaded") as u32
        };
        let mut band = Band { own: own.clone(), shaded: shaded.clone(), ..Band::default() };
        let mut last_inner = usize::MAX;
        for &at in &self.at[own] {
            let at = at as usize;
            let taps = neighbourhood::within_object(&maps.types, width, height, at);
            let inner = (0..9).all(|k| k == 4 || taps[k] != at);
            match maps.types[at] {
                PixelType::Edge => band.edge.push(taps.map(local)),
                _ if !inner => band.surface.push(taps.map(local)),
                _ => {
                    // Rows do not run together: their first and last pixels are never inner.
                    match band.runs.last_mut() {
                        Some(run) if last_inner.wrapping_add(1) == at => run.len += 1,
                        _ => {
                            let [above, here, below] = [taps[0], taps[3], taps[6]].map(local);
                            band.runs.push(Run { above, here, below, len: 1 });
                        }
                    }
                    last_inner = at;
                }
            }
        }
        band
    }
}
