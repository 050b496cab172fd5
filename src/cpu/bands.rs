//! A band of rows under some rigs: shading and sums of the native evaluator, and the statistics that the
//! bands' sums make.

use super::compact::{Band, ColorGroup, LANES, Pixels, Shaped};
use super::fitness;
use super::kernels::{self, AppearanceSums, Casting, Tile};
use crate::constants::NO_TARGET;
use crate::lighting::shading::{Brdf, Shading};
use crate::lighting::{LightRecord, Population};
use crate::objective::maps::{Maps, PixelCounts};
use crate::objective::shadows::Shadows;
use crate::objective::{
    DETAIL_LEAST, DETAIL_MOST, DETAIL_SHARE, HISTOGRAM_BINS, Irradiance, Needs, OUTLINE_ENOUGH,
    Objective, Statistics, curvature_level, entropy,
};
use crate::scene::view::View;
use std::ops::Range;
use std::sync::OnceLock;

/// The object's pixels in bands, with what shading and sums read of them.
#[derive(Debug)]
pub struct Bands {
    /// The pixels.
    pub pixels: Pixels,
    /// Cut into bands.
    pub bands: Vec<Band>,
    /// Positions and polygons' normals, for lights within the scene; empty without shadows.
    places: Vec<[[f32; 3]; 2]>,
    shading: Shading,
    needs: Needs,
    edge_contrast: f32,
    counts: PixelCounts,
    /// Made for the first rig that is shaded in colour.
    colors: OnceLock<Vec<ColorGroup>>,
    /// Distances of `n_x` and `n_y` from their means; empty unless what the lights do is needed.
    normals: [Vec<f32>; 2],
    /// Empty unless detail is needed.
    shaped: Vec<Shaped>,
    detail_weight: f32,
    /// Empty unless a target is needed.
    target: Vec<f32>,
    told: usize,
    /// Luminance behind the outline, where that is needed.
    background: Option<f32>,
    /// What the pixels count by curvature; empty unless that is needed.
    curved: Vec<u8>,
}

/// What one band adds to an individual's statistics.
#[derive(Debug, Clone, Copy, Default)]
pub struct Part {
    /// Of `I`.
    sum: f64,
    /// Of squared deviations of `I` from the band's own mean.
    squares: f64,
    /// Of `min(1, |∇I| / edge_contrast)` over EDGE.
    edge: f64,
    /// Of `|∇I|` over SURFACE.
    gradient: f64,
    histogram: [u32; HISTOGRAM_BINS],
    /// Over SURFACE, of the weight of the detail that is seen.
    detail: f64,
    /// Of `(I − T)²`.
    residual: f64,
    /// Of `1 − min(1, |I − B| / 0.2)` over the outline.
    outline: f64,
    /// Of the encoded irradiance, as `sum` and `squares`.
    irradiance: [f64; 2],
    appearance: AppearanceSums,
    /// What the pixels of each bin count by curvature.
    curved: [u32; HISTOGRAM_BINS],
}

/// How rigs are shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shade {
    /// Luminances of white Blinn-Phong: one plane, the picture.
    Plain,
    /// In colour: a second plane, what the lights do.
    Color,
}

impl Shade {
    /// Planes of a rig.
    pub fn planes(self) -> usize {
        match self {
            Self::Plain => 1,
            Self::Color => 2,
        }
    }
}

impl Bands {
    /// Of the view that `maps` describes.
    pub fn new(maps: &Maps, view: &View, objective: &Objective, shading: Shading) -> Self {
        let pixels = Pixels::new(maps, view, &shading);
        let needs = objective.needs();
        let normal = |axis: usize| {
            let off = |at: usize| maps.surface.normal[at][axis] - maps.shape.normal_mean[axis];
            pixels.numbers(off)
        };
        let shaped = |at: usize| Shaped {
            weight: maps.normal_gradient[at].min(DETAIL_MOST),
            scale: 1.0 / (DETAIL_SHARE * maps.normal_gradient[at]).max(DETAIL_LEAST),
        };
        let curved = |at: usize| curvature_level(maps.normal_gradient[at], maps.normal_detail);
        let place = |at: usize| [maps.surface.position[at], maps.surface.face[at]];
        let target = |at: usize| maps.target.get(at).copied().unwrap_or(NO_TARGET);
        Self {
            bands: pixels.bands(maps),
            normals: if needs.lights() { [0, 1].map(normal) } else { Default::default() },
            shaped: if needs.detail { pixels.numbers(shaped) } else { Vec::new() },
            detail_weight: maps.shape.detail_weight,
            target: if needs.target { pixels.numbers(target) } else { Vec::new() },
            told: maps.told(),
            background: objective.background.filter(|_| needs.background),
            curved: if needs.curvature { pixels.numbers(curved) } else { Vec::new() },
            places: if maps.shadows.is_some() { pixels.numbers(place) } else { Vec::new() },
            pixels,
            shading,
            needs,
            edge_contrast: objective.edge_contrast,
            counts: maps.counts,
            colors: OnceLock::new(),
        }
    }

    /// How the lights of a population are shaded.
    pub fn shade(&self, population: &Population, maps: &Maps) -> Shade {
        let blinn_phong = self.shading.brdf == Brdf::BlinnPhong;
        let plain = blinn_phong && !self.needs.lights() && maps.shadows.is_none();
        if plain && population.is_plain() {
            return Shade::Plain;
        }
        self.colors.get_or_init(|| self.pixels.colors(maps, &self.shading));
        Shade::Color
    }

    /// Tiles of a plane of any band.
    pub fn stride(&self) -> usize {
        self.bands.iter().map(|band| band.groups.len()).max().unwrap_or(0).max(1)
    }

    /// Shades some rigs in one band and measures them; the planes stay in the room.
    pub fn measure(
        &self,
        band: &Band,
        (rigs, lights): (&[LightRecord], usize),
        (shade, shadows): (Shade, Option<&Shadows>),
        room: &mut [Tile],
        parts: &mut [Part],
    ) {
        let groups = &self.pixels.groups[band.groups.clone()];
        let stride = self.stride();
        match (shade, self.colors.get()) {
            (Shade::Color, Some(colors)) => {
                let colors = &colors[band.groups.clone()];
                let (brdf, first) = (self.shading.brdf, band.groups.start);
                let casting = Casting { shadows, places: &self.places, first };
                let planes = (&mut *room, stride);
                kernels::shade_color((groups, colors), &casting, (rigs, lights), brdf, planes);
            }
            _ => kernels::shade(groups, rigs, lights, room, stride),
        }
        for (part, planes) in parts.iter_mut().zip(room.chunks_exact_mut(shade.planes() * stride)) {
            let (picture, irradiance) = planes.split_at_mut(stride);
            *part = self.part(band, bytemuck::cast_slice(picture));
            if self.needs.lights() {
                self.add_appearance(band, bytemuck::cast_slice_mut(irradiance), part);
            }
        }
    }

    /// Measures one rig's picture of a band.
    fn part(&self, band: &Band, picture: &[f32]) -> Part {
        let own = &picture[band.own.clone()];
        let (sum, squares) = kernels::moments(own);
        let edge = kernels::tapped_gradient(picture, &band.edge, 1.0 / self.edge_contrast, 1.0);
        let histogram = kernels::histogram(own);
        let (detail, gradient) = self.gradients(band, picture);
        let mut part = Part { sum, squares, edge, gradient, histogram, detail, ..Part::default() };
        if self.needs.target {
            part.residual = kernels::residual(own, &self.target[self.own(band)]);
        }
        if let Some(background) = self.background {
            part.outline = merged(picture, &band.outline, background);
        }
        if self.needs.curvature {
            part.curved = kernels::weighted_histogram(own, &self.curved[self.own(band)]);
        }
        part
    }

    /// Sums over SURFACE: of the weight of the detail that is seen, where it is needed, and of `|∇I|`.
    fn gradients(&self, band: &Band, picture: &[f32]) -> (f64, f64) {
        if !self.needs.detail {
            let inner = kernels::interior_gradient(picture, &band.runs);
            let outer = kernels::tapped_gradient(picture, &band.surface, 1.0, f32::MAX);
            return (0.0, inner + outer);
        }
        let shaped = &self.shaped[band.groups.start * LANES..];
        let inner = kernels::interior_detail(picture, &band.runs, shaped);
        let outer = kernels::tapped_detail(picture, (&band.surface, &band.surface_at), shaped);
        (inner[0] + outer[0], inner[1] + outer[1])
    }

    /// Measures what the lights do in a band.
    fn add_appearance(&self, band: &Band, irradiance: &mut [f32], part: &mut Part) {
        let own = &mut irradiance[band.own.clone()];
        let pixels = self.own(band);
        let normals = self.normals.each_ref().map(|numbers| &numbers[pixels.clone()]);
        part.appearance = kernels::appearance(own, normals);
        let (sum, squares) = kernels::moments(own);
        part.irradiance = [sum, squares];
    }

    /// A band's own pixels, counted from the first of all.
    fn own(&self, band: &Band) -> Range<usize> {
        let first = band.groups.start * LANES;
        first + band.own.start..first + band.own.end
    }

    /// Puts an individual's parts together.
    pub fn statistics<'a>(
        &self,
        parts: impl Iterator<Item = &'a Part> + Clone,
        rig: &[LightRecord],
    ) -> Statistics {
        let counts = self.counts;
        let total = |f: fn(&Part) -> f64| parts.clone().map(f).sum::<f64>();
        let mean_of = |sum: f64, count: u32| sum / f64::from(count.max(1));
        let share = |count: u32| mean_of(count.into(), counts.object()) as f32;
        let [mean, variance] = self.moments(parts.clone().map(|part| [part.sum, part.squares]));
        let mut histogram = [0; HISTOGRAM_BINS];
        for part in parts.clone() {
            histogram.iter_mut().zip(part.histogram).for_each(|(bin, count)| *bin += count);
        }
        let mut statistics = Statistics {
            edge_contrast: mean_of(total(|part| part.edge), counts.edge) as f32,
            mean,
            variance,
            gradient: mean_of(total(|part| part.gradient), counts.surface) as f32,
            histogram,
            key: fitness::key(rig),
            ..Statistics::default()
        };
        if self.needs.detail && self.detail_weight > 0.0 {
            let seen = total(|part| part.detail);
            statistics.detail = (seen / f64::from(self.detail_weight)) as f32;
        }
        if self.needs.target {
            let squares = total(|part| part.residual);
            statistics.residual = (squares / self.told.max(1) as f64) as f32;
        }
        if self.needs.background {
            let count = self.bands.iter().map(|band| band.outline.len()).sum::<usize>();
            statistics.outline = mean_of(total(|part| part.outline), count as u32) as f32;
        }
        if self.needs.curvature {
            let mut curved = [0; HISTOGRAM_BINS];
            for part in parts.clone() {
                curved.iter_mut().zip(part.curved).for_each(|(bin, sum)| *bin += u64::from(sum));
            }
            statistics.entropy = entropy(&curved);
        }
        if self.needs.channels {
            statistics.burnt = share(parts.clone().map(|part| part.appearance.burnt).sum());
        }
        if self.needs.irradiance {
            statistics.unlit = share(parts.clone().map(|part| part.appearance.unlit).sum());
            let [mean, variance] = self.moments(parts.clone().map(|part| part.irradiance));
            let covariance = [0, 1].map(|axis| {
                let sum = parts.clone().map(|part| part.appearance.covariance[axis]).sum();
                mean_of(sum, counts.object()) as f32
            });
            statistics.irradiance = Irradiance { mean, variance, covariance };
        }
        statistics
    }

    /// Mean and variance over the object from the bands' sums and sums of squared deviations.
    fn moments(&self, sums: impl Iterator<Item = [f64; 2]> + Clone) -> [f32; 2] {
        let count = f64::from(self.counts.object().max(1));
        let mean = sums.clone().map(|[sum, _]| sum).sum::<f64>() / count;
        // The bands' own variances, and that of their means (Chan, Golub and LeVeque 1983).
        let between = sums.clone().zip(&self.bands).map(|([sum, _], band)| {
            let count = band.own.len() as f64;
            let off = sum / count.max(1.0) - mean;
            count * off * off
        });
        let squares = sums.map(|[_, squares]| squares).sum::<f64>() + between.sum::<f64>();
        [mean as f32, (squares / count) as f32]
    }
}

/// Sum of `1 − min(1, |I − B| / 0.2)` over the pixels `at`.
fn merged(picture: &[f32], at: &[u32], background: f32) -> f64 {
    let distance = |&at: &u32| (picture[at as usize] - background).abs();
    at.iter().map(|at| f64::from(1.0 - (distance(at) / OUTLINE_ENOUGH).min(1.0))).sum()
}
