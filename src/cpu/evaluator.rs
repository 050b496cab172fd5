//! The native evaluator: the plain stages' results, fast.
//!
//! A task shades some individuals in one band of rows and measures them there while the pictures are
//! in the cache; the bands' sums are then added in order. Bands depend on the maps alone, so the bits
//! do not depend on the number of threads.

use super::bands::{Bands, Part, Shade};
use super::compact::Band;
use super::kernels::Tile;
use crate::Result;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection, check_places, check_scores};
use crate::lighting::shading::Shading;
use crate::lighting::{Light, LightRecord, Population};
use crate::objective::maps::{Maps, ViewStatistics};
use crate::objective::{Objective, Quality};
use crate::scene::view::View;
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
    view: ViewStatistics,
    objective: Objective,
    bands: Bands,
    /// Of the last chunk: all rigs' parts of the first band, then of the next.
    parts: Vec<Part>,
    /// Room for the planes of a task that no task uses at the moment.
    rooms: Mutex<Vec<Vec<Tile>>>,
    device: DeviceInfo,
}

impl CpuEvaluator {
    /// An evaluator of the view that `maps` describes.
    ///
    /// # Errors
    /// As [`Maps::check`], [`View::check`], [`Objective::check`] and [`Shading::check`].
    pub fn new(maps: Maps, view: &View, objective: Objective, shading: Shading) -> Result<Self> {
        maps.check()?;
        view.check()?;
        objective.check()?;
        shading.check()?;
        let bands = Bands::new(&maps, view, &objective, shading);
        let (parts, rooms) = Default::default();
        Ok(Self { view: maps.statistics(), maps, objective, bands, parts, rooms, device: device() })
    }

    /// Works in room for [`TASK_RIGS`] rigs.
    fn with_room<T>(&self, shade: Shade, work: impl FnOnce(&mut [Tile]) -> T) -> T {
        let rooms = || self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        let mut room = rooms().pop().unwrap_or_default();
        let tiles = TASK_RIGS * shade.planes() * self.bands.stride();
        if room.len() < tiles {
            room.resize(tiles, Tile::default());
        }
        let result = work(&mut room);
        rooms().push(room);
        result
    }

    /// Passes the quality of every rig to `take`, in order.
    fn measure_all(&mut self, population: &Population, mut take: impl FnMut(Quality)) {
        let lights = population.lights();
        let shade = self.bands.shade(population, &self.maps);
        let chunk = (CHUNK_PARTS / self.bands.bands.len().max(1)).max(1);
        for records in population.records().chunks(chunk * lights) {
            self.measure_chunk((records, lights), shade, &mut take);
        }
    }

    /// Measures the rigs of `lights` lights each in `records`.
    fn measure_chunk(
        &mut self,
        (records, lights): (&[LightRecord], usize),
        shade: Shade,
        take: &mut impl FnMut(Quality),
    ) {
        let rigs = records.len() / lights;
        let mut parts = std::mem::take(&mut self.parts);
        parts.resize(rigs * self.bands.bands.len(), Part::default());
        let tasks = THREAD_TASKS * rayon::current_num_threads();
        let task_rigs = (parts.len() / tasks).clamp(1, TASK_RIGS);
        let bands = parts.par_chunks_mut(rigs).zip(&self.bands.bands);
        bands
            .flat_map(|(parts, band)| {
                let tasks =
                    parts.par_chunks_mut(task_rigs).zip(records.par_chunks(task_rigs * lights));
                tasks.map(move |(parts, rigs)| (band, parts, rigs))
            })
            .for_each(|(band, parts, rigs)| {
                self.with_room(shade, |room| {
                    let shade = (shade, self.maps.shadows.as_ref());
                    self.bands.measure(band, (rigs, lights), shade, room, parts);
                });
            });
        for (rig, lights) in records.chunks(lights).enumerate() {
            let statistics = self.bands.statistics(parts.iter().skip(rig).step_by(rigs), lights);
            take(self.objective.quality(&statistics, &self.view));
        }
        self.parts = parts;
    }
}

impl Evaluator for CpuEvaluator {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        check_places(population, scores)?;
        let mut places = scores.iter_mut();
        self.measure_all(population, |quality| {
            places.next().into_iter().for_each(|place| *place = quality.score);
        });
        check_scores(population, scores)
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        let mut qualities = Vec::with_capacity(population.len());
        self.measure_all(population, |quality| qualities.push(quality));
        let scores: Vec<f32> = qualities.iter().map(|quality: &Quality| quality.score).collect();
        check_scores(population, &scores)?;
        Ok(qualities)
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let population = Population::of([rig])?;
        let mut picture = vec![0.0; self.maps.types.len()];
        let shade = self.bands.shade(&population, &self.maps);
        let rigs = (population.records(), rig.len());
        let measured = |band: &Band| {
            self.with_room(shade, |room| {
                let mut part = Part::default();
                let shade = (shade, self.maps.shadows.as_ref());
                self.bands.measure(band, rigs, shade, room, std::slice::from_mut(&mut part));
                let own: &[f32] = bytemuck::cast_slice(room);
                (part, own[band.own.clone()].to_vec())
            })
        };
        let measured: Vec<_> = self.bands.bands.par_iter().map(measured).collect();
        let own = measured.iter().flat_map(|(_, own)| own);
        for (&at, &i) in self.bands.pixels.at.iter().zip(own) {
            picture[at as usize] = i;
        }
        let parts = measured.iter().map(|(part, _)| part);
        let statistics = self.bands.statistics(parts, population.records());
        let Quality { score, terms } = self.objective.quality(&statistics, &self.view);
        check_scores(&population, &[score])?;
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
