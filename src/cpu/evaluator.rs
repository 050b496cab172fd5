//! The native evaluator: the plain stages' results, fast.
//!
//! A task shades some individuals in one band of rows and measures them there while the pictures are
//! in the cache; the bands' sums are then added in order. Bands depend on the maps alone, so the bits
//! do not depend on the number of threads.

use super::compact::{Band, Pixels};
use super::kernels::{self, Tile};
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::shading::Shading;
use crate::lighting::{Light, LightRecord, Population};
use crate::objective::maps::Maps;
use crate::objective::{HISTOGRAM_BINS, Objective, Quality, Statistics};
use crate::scene::view::View;
use crate::{Error, Result};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Parts that are made before they are put together; it bounds their memory.
const CHUNK_PARTS: usize = 1 << 18;

/// Most rigs of a task: each record of the surface is read once for all of them.
const TASK_RIGS: usize = 8;

/// Tasks for each thread, at least, before a task takes several rigs.
const THREAD_TASKS: usize = 4;

/// Evaluates populations on all cores of the machine (rayon's current thread pool).
#[derive(Debug)]
pub struct CpuEvaluator {
    maps: Maps,
    objective: Objective,
    pixels: Pixels,
    bands: Vec<Band>,
    /// Of the last chunk: all rigs' parts of the first band, then of the next.
    parts: Vec<Part>,
    /// Room for the pictures of a task, [`TASK_RIGS`] of [`CpuEvaluator::stride`] tiles each, that no
    /// task uses at the moment.
    rooms: Mutex<Vec<Vec<Tile>>>,
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

impl CpuEvaluator {
    /// An evaluator of the view that `maps` describes.
    ///
    /// # Errors
    /// As [`Maps::check`] and [`View::check`].
    pub fn new(maps: Maps, view: &View, objective: Objective, shading: Shading) -> Result<Self> {
        maps.check()?;
        view.check()?;
        let pixels = Pixels::new(&maps, view, &shading);
        let bands = pixels.bands(&maps);
        let (parts, rooms) = Default::default();
        Ok(Self { maps, objective, pixels, bands, parts, rooms, device: device() })
    }

    /// Tiles of a picture of any band.
    fn stride(&self) -> usize {
        self.bands.iter().map(|band| band.groups.len()).max().unwrap_or(0).max(1)
    }

    fn with_room<T>(&self, work: impl FnOnce(&mut [Tile]) -> T) -> T {
        let rooms = || self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        let spare = rooms().pop();
        let mut room = spare.unwrap_or_else(|| vec![Tile::default(); TASK_RIGS * self.stride()]);
        let result = work(&mut room);
        rooms().push(room);
        result
    }

    /// Shades some rigs in one band and measures them; the pictures stay in the room.
    fn measure(
        &self,
        band: &Band,
        rigs: &[LightRecord],
        lights: usize,
        room: &mut [Tile],
        parts: &mut [Part],
    ) {
        let groups = &self.pixels.groups[band.groups.clone()];
        let stride = self.stride();
        kernels::shade(groups, rigs, lights, room, stride);
        for (part, picture) in parts.iter_mut().zip(room.chunks_exact(stride)) {
            *part = self.part(band, bytemuck::cast_slice(picture));
        }
    }

    /// Measures one rig's picture of a band.
    fn part(&self, band: &Band, picture: &[f32]) -> Part {
        let own = &picture[band.own.clone()];
        let (sum, squares) = kernels::moments(own);
        let inner = kernels::interior_gradient(picture, &band.runs);
        let outer = kernels::tapped_gradient(picture, &band.surface, 1.0, f32::MAX);
        let full = 1.0 / self.objective.edge_contrast;
        let edge = kernels::tapped_gradient(picture, &band.edge, full, 1.0);
        Part { sum, squares, edge, gradient: inner + outer, histogram: kernels::histogram(own) }
    }

    /// Passes the quality of every rig to `take`, in order.
    fn measure_all(&mut self, population: &Population, mut take: impl FnMut(Quality)) {
        let lights = population.lights();
        let chunk = (CHUNK_PARTS / self.bands.len().max(1)).max(1);
        for records in population.records().chunks(chunk * lights) {
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
        let tasks = THREAD_TASKS * rayon::current_num_threads();
        let task_rigs = (parts.len() / tasks).clamp(1, TASK_RIGS);
        let bands = parts.par_chunks_mut(rigs).zip(&self.bands);
        bands
            .flat_map(|(parts, band)| {
                let tasks =
                    parts.par_chunks_mut(task_rigs).zip(records.par_chunks(task_rigs * lights));
                tasks.map(move |(parts, rigs)| (band, parts, rigs))
            })
            .for_each(|(band, parts, rigs)| {
                self.with_room(|room| self.measure(band, rigs, lights, room, parts));
            });
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
        let mut parts = vec![Part::default(); self.bands.len()];
        let mut at = self.pixels.at.iter();
        for (band, part) in self.bands.iter().zip(&mut parts) {
            self.with_room(|room| {
                let part = std::slice::from_mut(part);
                self.measure(band, population.records(), rig.len(), room, part);
                let own: &[f32] = bytemuck::cast_slice(room);
                for (&i, &at) in own[band.own.clone()].iter().zip(&mut at) {
                    picture[at as usize] = i;
                }
            });
        }
        let statistics = self.statistics(parts.iter());
        let Quality { score, terms } = self.objective.quality(&statistics, &self.maps);
        Ok(Inspection { score, terms, statistics, picture })
    }

    fn maps(&mut self) -> Result<&Maps> {
        Ok(&self.maps)
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
