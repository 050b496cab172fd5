//! The object's pixels alone, as the inner loops read them: one array for each number, and lists of
//! the neighbours that the gradients need. Pixels keep their order, rows from the top.

use super::{appearance, neighbourhood};
use crate::lighting::shading::{Coefficients, Shading};
use crate::math::color::luminance;
use crate::objective::maps::{Maps, PixelType};
use crate::scene::view::View;
use glam::Vec3;
use std::ops::Range;

/// A band ends with the first row that brings it to this many pixels and to [`BAND_ROWS`] rows.
const BAND_PIXELS: usize = 1 << 14;
/// See [`BAND_PIXELS`].
const BAND_ROWS: usize = 32;

/// Pixels of a [`Group`]: the widest vectors hold as many numbers.
pub const LANES: usize = 16;

/// One number for each pixel of a group.
pub type Lanes = [f32; LANES];

/// What shading needs of [`LANES`] successive object pixels, 56 bytes each. Side by side in memory,
/// they are read as one stream; an array for each number would bring all of them into the same few
/// lines of the cache.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Group {
    /// Position in the light frame, by axis.
    pub position: [Lanes; 3],
    /// Unit normal `n`.
    pub normal: [Lanes; 3],
    /// Unit vector to the viewer `v`.
    pub to_viewer: [Lanes; 3],
    /// `n·v`.
    pub facing: Lanes,
    /// Luminance of the diffuse reflectance.
    pub diffuse: Lanes,
    /// Luminance of the specular reflectance with its normalisation.
    pub specular: Lanes,
    /// `s/2`, so that `(n·h)^s = 2^(exponent·log₂((n·h)²))`.
    pub exponent: Lanes,
    /// Luminance without any light.
    pub unlit: Lanes,
}

/// What shading in colour needs of the same pixels besides, 40 bytes each.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ColorGroup {
    /// Diffuse reflectance, by channel.
    pub diffuse: [Lanes; 3],
    /// Specular reflectance: of Blinn-Phong with its normalisation, else at normal incidence.
    pub specular: [Lanes; 3],
    /// Width of the lobe: `s/2` of Blinn-Phong, else `α²`.
    pub lobe: Lanes,
    /// Radiance without any light.
    pub unlit: [Lanes; 3],
}

/// How much a pixel's detail weighs, and how its gradient becomes a share of what has to be seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shaped {
    /// `min(|∇n|, 0.5)`.
    pub weight: f32,
    /// `1 / max(0.35·|∇n|, 0.004)`.
    pub scale: f32,
}

/// The object's pixels.
#[derive(Debug, Clone, Default)]
pub struct Pixels {
    /// The last group is filled up with pixels that reflect nothing.
    pub groups: Vec<Group>,
    /// Each pixel's index in the picture.
    pub at: Vec<u32>,
}

/// SURFACE pixels side by side whose neighbourhoods lie in the object. The three indices count from
/// the first pixel of the band's first group and name the pixel left of the run's first, its upper and
/// its lower neighbour.
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

/// The pixels around one, row by row from the top.
pub type Taps = [u32; 8];

/// Some rows of the picture, measured together.
#[derive(Debug, Clone, Default)]
pub struct Band {
    /// Pixels that are measured, counted from the first pixel of the first group.
    pub own: Range<usize>,
    /// Groups that are shaded: those of the measured pixels, and of the rows above and below for the
    /// gradients.
    pub groups: Range<usize>,
    /// Inner SURFACE pixels.
    pub runs: Vec<Run>,
    /// Surroundings of the other SURFACE pixels, counted as `own`.
    pub surface: Vec<Taps>,
    /// These pixels themselves, counted likewise.
    pub surface_at: Vec<u32>,
    /// Surroundings of the EDGE pixels, counted likewise.
    pub edge: Vec<Taps>,
    /// Pixels beside the background, counted likewise.
    pub outline: Vec<u32>,
}

impl Pixels {
    /// The object's pixels.
    pub fn new(maps: &Maps, view: &View, shading: &Shading) -> Self {
        let surface = &maps.surface;
        let mut pixels = Self::default();
        for at in (0..surface.code.len()).filter(|&at| maps.types[at] != PixelType::Background) {
            let lane = pixels.at.len() % LANES;
            if lane == 0 {
                pixels.groups.push(Group::default());
            }
            pixels.at.push(at as u32);
            let group = pixels.groups.last_mut().expect("pushed with the first of its pixels");
            let reflectance = surface.reflectance(shading, at);
            let normal = Vec3::from(surface.normal[at]);
            let to_viewer = view.towards_viewer(surface.position[at].into());
            for axis in 0..3 {
                group.position[axis][lane] = surface.position[at][axis];
                group.normal[axis][lane] = normal[axis];
                group.to_viewer[axis][lane] = to_viewer[axis];
            }
            group.facing[lane] = normal.dot(to_viewer);
            group.diffuse[lane] = luminance(reflectance.diffuse);
            group.specular[lane] = luminance(reflectance.specular);
            group.exponent[lane] = 0.5 * reflectance.shininess;
            group.unlit[lane] = luminance(reflectance.unlit);
        }
        pixels
    }

    /// What shading in colour needs of the pixels.
    pub fn colors(&self, maps: &Maps, shading: &Shading) -> Vec<ColorGroup> {
        let mut colors = vec![ColorGroup::default(); self.groups.len()];
        for (i, &at) in self.at.iter().enumerate() {
            let (group, lane, at) = (&mut colors[i / LANES], i % LANES, at as usize);
            let looks = maps.reflectance(shading, at);
            let Coefficients { diffuse, specular, lobe } =
                looks.coefficients(shading.brdf, self.groups[i / LANES].facing[lane]);
            group.lobe[lane] = lobe;
            for channel in 0..3 {
                group.diffuse[channel][lane] = diffuse[channel];
                group.specular[channel][lane] = specular[channel];
                group.unlit[channel][lane] = looks.unlit[channel];
            }
        }
        colors
    }

    /// A number of each object pixel, and of those that fill the last group up.
    pub fn numbers<T: Copy + Default>(&self, number: impl Fn(usize) -> T) -> Vec<T> {
        let mut numbers: Vec<T> = self.at.iter().map(|&at| number(at as usize)).collect();
        numbers.resize(self.groups.len() * LANES, T::default());
        numbers
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
        let groups = shaded.start / LANES..shaded.end.div_ceil(LANES);
        let first = groups.start * LANES;
        let local = |at: usize| {
            let index = self.at[shaded.clone()].binary_search(&(at as u32));
            let index = index.expect("a neighbour in the object lies in the rows that are shaded");
            (index + shaded.start - first) as u32
        };
        let from_first = own.start - first..own.end - first;
        let mut band = Band { own: from_first, groups, ..Band::default() };
        let mut last_inner = usize::MAX;
        for &at in &self.at[own] {
            let at = at as usize;
            let taps = neighbourhood::within_object(&maps.types, width, height, at);
            let around = [0, 1, 2, 3, 5, 6, 7, 8].map(|k| taps[k]);
            let inner = around.iter().all(|&tap| tap != at);
            if !inner && appearance::is_outline(maps, at) {
                band.outline.push(local(at));
            }
            match maps.types[at] {
                PixelType::Edge => band.edge.push(around.map(local)),
                _ if !inner => {
                    band.surface.push(around.map(local));
                    band.surface_at.push(local(at));
                }
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
