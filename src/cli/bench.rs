//! `klieg bench`: how long a generation takes.

use super::config::{Pipeline, Settings};
use super::options::{Kind, SceneOptions};
use super::session::{self, Engine, SIZE, milliseconds};
use super::values::{Device, Lights, Size};
use super::{device, print};
use crate::Error;
use crate::evaluate::DeviceInfo;
use crate::lighting::genome::{Genome, Range};
use crate::lighting::{LightKind, Population, check_number};
use crate::optimize::MAX_POPULATION;
use crate::report::json;
use crate::scene::Scene;
use anyhow::Result;
use clap::Args;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::Instant;

/// Time a generation
///
/// Evaluates random rigs, the same on every device, and prints the wall time of a generation and, on
/// Vulkan devices, the GPU's own time for each stage.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// Picture sizes
    #[arg(long, value_name = "WxH,…", value_delimiter = ',', default_values_t = [SIZE])]
    size: Vec<Size>,
    /// Numbers of lights
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [1, 4])]
    lights: Vec<usize>,
    /// Kind of the lights
    #[arg(long, default_value = "point")]
    kind: Kind,
    /// Numbers of individuals
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [30])]
    population: Vec<usize>,
    /// A device; may be given again [default: cpu and, where there is one, vulkan]
    #[arg(long)]
    device: Vec<Device>,
    /// How Vulkan devices make the pictures [default: auto]
    #[arg(long)]
    pipeline: Option<Pipeline>,
    /// Measured generations
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Generations before the measured ones
    #[arg(long, default_value_t = 5)]
    warm_up: u32,
    /// Seed of the rigs
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// What `klieg bench --json` prints; times in milliseconds.
#[derive(Serialize)]
struct Bench {
    schema: &'static str,
    klieg: &'static str,
    scene: String,
    polygons: u32,
    kind: LightKind,
    seed: u64,
    runs: u32,
    warm_up: u32,
    load_ms: f64,
    rows: Vec<Row>,
}

/// One device at one size, with rigs of one number of lights in populations of one size.
#[derive(Serialize)]
struct Row {
    device: DeviceInfo,
    size: [u32; 2],
    lights: usize,
    population: usize,
    /// Setting the device up and making the view's maps, once.
    maps_ms: f64,
    median_ms: f64,
    p95_ms: f64,
    evaluations_per_second: f64,
    /// Median of the GPU's time for each stage, in the stages' order.
    stages_ms: Map<String, Value>,
}

/// What is measured.
struct Work {
    lights: usize,
    population: usize,
}

pub(super) fn run(options: &Options) -> Result<()> {
    let settings = options.scene.settings()?;
    settings.check()?;
    let work = work(options)?;
    let start = Instant::now();
    let scene = session::load(&options.scene.scene)?;
    let load_ms = milliseconds(start);
    let mut rows = Vec::new();
    for device in devices(options) {
        for size in &options.size {
            let mut settings = settings.clone();
            settings.view.size = Some(*size);
            settings.device = device.clone();
            settings.pipeline = options.pipeline.unwrap_or(settings.pipeline);
            rows.extend(measure(options, &scene, &settings, &work)?);
        }
    }
    let bench = Bench {
        schema: "klieg.bench/1",
        klieg: env!("CARGO_PKG_VERSION"),
        scene: scene.path.display().to_string(),
        polygons: scene.polygons(),
        kind: options.kind.into(),
        seed: options.seed,
        runs: options.runs,
        warm_up: options.warm_up,
        load_ms,
        rows,
    };
    if options.scene.json { print::out(json::text(&bench)?) } else { print::out(show(&bench)) }
}

fn devices(options: &Options) -> Vec<Device> {
    if !options.device.is_empty() {
        return options.device.clone();
    }
    let vulkan = device::choose(&Device::Vulkan, &device::list().0).is_ok();
    [Device::Cpu].into_iter().chain(vulkan.then_some(Device::Vulkan)).collect()
}

/// All pairs of a number of lights and a population.
fn work(options: &Options) -> Result<Vec<Work>, Error> {
    options.lights.iter().try_for_each(|&lights| check_number(lights))?;
    if let Some(n) = options.population.iter().find(|n| !(1..=MAX_POPULATION).contains(*n)) {
        return Err(Error::Argument(format!("a population of {n}: it is 1 to {MAX_POPULATION}")));
    }
    let pairs = options.lights.iter().flat_map(|&lights| {
        options.population.iter().map(move |&population| Work { lights, population })
    });
    Ok(pairs.collect())
}

/// All rows of one device and size.
fn measure(
    options: &Options,
    scene: &Scene,
    settings: &Settings,
    work: &[Work],
) -> Result<Vec<Row>> {
    let view = session::view(scene, &settings.view)?;
    let start = Instant::now();
    let mut evaluator = session::evaluator(scene, &view, settings, &settings.device)?;
    let maps_ms = milliseconds(start);
    session::announce(&evaluator);
    work.iter().map(|work| row(options, settings, work, maps_ms, &mut evaluator)).collect()
}

fn row(
    options: &Options,
    settings: &Settings,
    &Work { lights, population }: &Work,
    maps_ms: f64,
    evaluator: &mut Engine,
) -> Result<Row> {
    let roles = Lights::number(lights).map_err(Error::Argument)?.0;
    let genome = Genome::new(&roles, options.kind.into(), &settings.lights.boxes)?;
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut scores = vec![0.0; population];
    let (mut walls, mut stages) = (Vec::new(), Vec::<(&str, Vec<f64>)>::new());
    for run in 0..options.warm_up + options.runs {
        let rigs = random(&genome, population, &mut rng)?;
        let start = Instant::now();
        evaluator.evaluate(&rigs, &mut scores)?;
        let wall = milliseconds(start);
        if run >= options.warm_up {
            walls.push(wall);
            for &(stage, time) in evaluator.stage_times() {
                match stages.iter_mut().find(|(name, _)| *name == stage) {
                    Some((_, times)) => times.push(time),
                    None => stages.push((stage, vec![time])),
                }
            }
        }
    }
    walls.sort_by(f64::total_cmp);
    let median_ms = median(&walls);
    Ok(Row {
        device: evaluator.device().clone(),
        size: settings.view.size.unwrap_or(SIZE).0,
        lights,
        population,
        maps_ms,
        median_ms,
        p95_ms: percentile(&walls, 0.95),
        evaluations_per_second: population as f64 / median_ms * 1e3,
        stages_ms: stages
            .into_iter()
            .map(|(name, times)| (name.into(), sorted_median(times).into()))
            .collect(),
    })
}

/// A population of uniform rigs.
fn random(genome: &Genome, size: usize, rng: &mut ChaCha8Rng) -> Result<Population, Error> {
    let mut population = Population::new(genome.lights())?;
    for _ in 0..size {
        let chromosome: Vec<f32> = genome.bounds().iter().map(|r: &Range| r.uniform(rng)).collect();
        population.push(&genome.decode(&chromosome))?;
    }
    Ok(population)
}

fn sorted_median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    median(&values)
}

/// Median of sorted values.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 }
}

/// The nearest-rank percentile of sorted values.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted[rank.max(1) - 1]
}

fn show(bench: &Bench) -> String {
    let Bench { scene, polygons, runs, warm_up, load_ms, .. } = bench;
    let names =
        ["device", "size", "lights", "N", "median ms", "p95 ms", "evaluations/s", "maps ms"];
    let mut table = print::columns(&names, &[]);
    for row in &bench.rows {
        table.add_row([
            row.device.name.clone(),
            Size(row.size).to_string(),
            row.lights.to_string(),
            row.population.to_string(),
            format!("{:.2}", row.median_ms),
            format!("{:.2}", row.p95_ms),
            format!("{:.0}", row.evaluations_per_second),
            format!("{:.0}", row.maps_ms),
        ]);
    }
    let mut text = format!(
        "{scene}: {polygons} polygons, loaded in {load_ms:.0} ms\n\
         median and 95th percentile of {runs} generations after {warm_up}\n\n{table}\n"
    );
    for row in bench.rows.iter().filter(|row| !row.stages_ms.is_empty()) {
        let time = |ms: &Value| ms.as_f64().unwrap_or_default();
        let stages = row.stages_ms.iter().map(|(stage, ms)| format!("{stage} {:.3}", time(ms)));
        let stages: Vec<_> = stages.collect();
        let (name, size) = (&row.device.name, Size(row.size));
        text += &format!(
            "\n{name}, {size}, lights {}, N {}, GPU ms:\n  {}\n",
            row.lights,
            row.population,
            stages.join(", ")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_percentiles() {
        assert_eq!(sorted_median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(sorted_median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(percentile(&values, 0.95), 19.0);
        assert_eq!(percentile(&values[..1], 0.95), 1.0);
    }
}
