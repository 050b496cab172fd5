//! The native evaluator: the plain stages' results, fast.
//!
//! A task shades one individual in one band of rows and measures it there while the picture is in the
//! cache; the bands' sums are then added in order. Bands depend on the maps alone, so the bits do not
//! depend on the number of threads.

use super::compact::{Band, Pixels};
use super::kernels;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::shading::Shading;
use crate::lighting::{Light, LightRecord, Population};
use crate::objective::maps::Maps;
use crate::objective::{HISTOGRAM_BINS, Objective, Quality, Statistics};
use crate::scene::view::View;
use crate::{Error, Result};
use rayon::prelude::*;

/// Rigs that are evaluated together; it bounds the memory of the parts.
const CHUNK_RIGS: usize = 1 << 10;

/// Evaluates populations on all cores of the machine (rayon's current thread pool).
#[derive(Debug)]
pub struct CpuEvaluator {
    maps: Maps,
    objective: Objective,
    pixels: Pixels,
    bands: Vec<Band>,
    /// Of the last chunk: all rigs' parts of the first band, then of the next.
    parts: Vec<Part>,
    device: DeviceInfo,
}

/// What one band adds to an individual's statistics.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    /// Of `I`.
    sum: f64,
    /// Of squared deviations of `I` from the band's own mean.
    squares: f64,
    /// Of `min(1, |∇I| / edge_contrast)` over EDGE.
    edge: f64,
    /// Of `|∇I|` over SURFACE.
    gradient: f64,
    histogram: [u32; HISTOGRAM_BINS],
}

/// Memory of one thread.
struct Scratch {
    picture: Vec<f32>,
    lengths: Vec<f32>,
}

impl CpuEvaluator {
    /// An evaluator of the view that `maps` describes.
    pub fn new(maps: Maps, view: &View, objective: Objective, shading: Shading) -> Self {
        let pixels = Pixels::new(&maps, view, &shading);
        let bands = pixels.bands(&maps);
        Self { maps, objective, pixels, bands, parts: Vec::new(), device: device() }
    }

    fn scratch(&self) -> Scratch {
        let largest = self.bands.iter().map(|band| band.shaded.len()).max().unwrap_or(0);
        let width = self.maps.surface.width as usize;
        Scratch { picture: vec![0.0; largest], lengths: vec![0.0; width] }
    }

    /// Shades and measures one individual in one band; the picture stays in the scratch space.
    fn measure(&self, band: &Band, rig: &[LightRecord], scratch: &mut Scratch) -> Part {
        let picture = &mut scratch.picture[..band.shaded.len()];
        kernels::shade(&self.pixels, band.shaded.clone(), rig, picture);
        let own = band.own_of(picture);
        let (sum, squares) = kernels::moments(own);
        let mut histogram = [0; HISTOGRAM_BINS];
        kernels::histogram(own, &mut histogram);
        let inner = kernels::interior_gradient(picture, &band.runs, &mut scratch.lengths);
        let outer = kernels::tapped_gradient(picture, &band.surface, |length| length);
        let full = self.objective.edge_contrast;
        let edge = kernels::tapped_gradient(picture, &band.edge, |length| (length / full).min(1.0));
        Part { sum, squares, edge, gradient: inner + outer, histogram }
    }

    /// Passes the quality of every rig to `take`, in order.
    fn measure_all(&mut self, population: &Population, mut take: impl FnMut(Quality)) {
        let lights = population.lights();
        for records in population.records().chunks(CHUNK_RIGS * lights) {
            self.measure_chunk(records, lights, &mut take);
        }
    }

    /// Measures the rigs of `lights` lights each in `records`.
    fn measure_chunk(
        &mut self,
        records: &[LightRecord],
        lights: usize,
        take: &mut impl FnMut(Quality),
    ) {
        let rigs = records.len() / lights;
        let mut parts = std::mem::take(&mut self.parts);
        parts.resize(rigs * self.bands.len(), Part::default());
        parts.par_iter_mut().enumerate().for_each_init(
            || self.scratch(),
            |scratch, (task, part)| {
                let (band, rig) = (task / rigs, task % rigs);
                let rig = &records[rig * lights..(rig + 1) * lights];
                *part = self.measure(&self.bands[band], rig, scratch);
            },
        );
        for rig in 0..rigs {
            let statistics = self.statistics(parts.iter().skip(rig).step_by(rigs));
            take(self.objective.quality(&statistics, &self.maps));
        }
        self.parts = parts;
    }

    /// Puts an individual's parts together.
    fn statistics<'a>(&self, parts: impl Iterator<Item = &'a Part> + Clone) -> Statistics {
        let counts = self.maps.counts;
        let total = |f: fn(&Part) -> f64| parts.clone().map(f).sum::<f64>();
        let mean_of = |sum: f64, count: u32| sum / f64::from(count.max(1));
        let mean = mean_of(total(|part| part.sum), counts.object());
        // The bands' own variances, and that of their means (Chan, Golub and LeVeque 1983).
        let between = parts.clone().zip(&self.bands).map(|(part, band)| {
            let count = band.own.len() as f64;
            let off = part.sum / count.max(1.0) - mean;
            count * off * off
        });
        let squares = total(|part| part.squares) + between.sum::<f64>();
        let mut histogram = [0; HISTOGRAM_BINS];
        for part in parts.clone() {
            histogram.iter_mut().zip(part.histogram).for_each(|(bin, count)| *bin += count);
        }
        Statistics {
            edge_contrast: mean_of(total(|part| part.edge), counts.edge) as f32,
            mean: mean as f32,
            variance: mean_of(squares, counts.object()) as f32,
            gradient: mean_of(total(|part| part.gradient), counts.surface) as f32,
            histogram,
        }
    }
}

impl Evaluator for CpuEvaluator {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        let rigs = population.len();
        if scores.len() != rigs {
            return Err(Error::Argument(format!("{} places for {rigs} scores", scores.len())));
        }
        let mut places = scores.iter_mut();
        self.measure_all(population, |quality| {
            places.next().into_iter().for_each(|place| *place = quality.score);
        });
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        let mut qualities = Vec::with_capacity(population.len());
        self.measure_all(population, |quality| qualities.push(quality));
        Ok(qualities)
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let population = Population::of([rig])?;
        let mut picture = vec![0.0; self.maps.types.len()];
        let mut scratch = self.scratch();
        let mut parts = Vec::new();
        for band in &self.bands {
            parts.push(self.measure(band, population.records(), &mut scratch));
            let own = band.own_of(&scratch.picture);
            for (&at, &i) in self.pixels.at[band.own.clone()].iter().zip(own) {
                picture[at as usize] = i;
            }
        }
        let statistics = self.statistics(parts.iter());
        let Quality { score, terms } = self.objective.quality(&statistics, &self.maps);
        Ok(Inspection { score, terms, statistics, picture })
    }

    fn maps(&mut self) -> Result<&Maps> {
        Ok(&self.maps)
    }
}

impl Band {
    /// The measured part of a picture of the shaded pixels.
    fn own_of<'a>(&self, shaded: &'a [f32]) -> &'a [f32] {
        &shaded[self.own.start - self.shaded.start..self.own.end - self.shaded.start]
    }
}

/// The processor's own name where the system tells it, its architecture otherwise.
pub fn device() -> DeviceInfo {
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    DeviceInfo {
        name: model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        kind: "cpu",
        driver: concat!("klieg ", env!("CARGO_PKG_VERSION")).to_owned(),
    }
}
