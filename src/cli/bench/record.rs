//! What a benchmark finds, as its JSON says it. `docs/RESULT.md` is the reference.

use super::ceiling::{Ceiling, operations};
use super::machine::Machine;
use super::sample::{self, Plan, Sample};
use crate::design::profile::Profile;
use crate::evaluate::DeviceInfo;
use crate::lighting::LightKind;
use crate::scene::Scene;
use clap::ValueEnum;
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt;

/// `klieg.bench/2`; times in milliseconds, memory in bytes.
#[derive(Serialize)]
pub struct Bench {
    schema: &'static str,
    klieg: &'static str,
    profile: &'static str,
    kind: LightKind,
    seed: u64,
    warm_up: u32,
    most_runs: u32,
    most_seconds: f64,
    pub precision: f64,
    pub scenes: Vec<SceneRecord>,
    pub rows: Vec<Row>,
}

impl Bench {
    /// Without scenes and rows.
    pub fn new(profile: &Profile, kind: LightKind, seed: u64, plan: &Plan) -> Self {
        Self {
            schema: "klieg.bench/2",
            klieg: env!("CARGO_PKG_VERSION"),
            profile: profile.name,
            kind,
            seed,
            warm_up: plan.warm_up,
            most_runs: plan.runs,
            most_seconds: plan.limit.as_secs_f64(),
            precision: plan.precision,
            scenes: Vec::new(),
            rows: Vec::new(),
        }
    }
}

/// A scene.
#[derive(Serialize)]
pub struct SceneRecord {
    pub scene: String,
    pub triangles: u32,
    pub instances: usize,
    /// Loading or making it, once.
    pub load_ms: f64,
}

impl SceneRecord {
    pub fn new(scene: &Scene, load_ms: f64) -> Self {
        Self {
            scene: scene.path.display().to_string(),
            triangles: scene.polygons(),
            instances: scene.instances.len(),
            load_ms,
        }
    }
}

/// A view on a device, with the way of measuring there.
#[derive(Clone, Serialize)]
pub struct Setup {
    pub device: DeviceInfo,
    /// `layered`, `forward`, `compute`, `readback` or `native`.
    pub pipeline: String,
    /// Of the native evaluator.
    pub threads: Option<usize>,
    pub triangles: u32,
    pub size: [u32; 2],
    pub object_pixels: u32,
    /// Setting the device up and making the view's maps, once.
    pub maps_ms: f64,
    /// The shadow table, a part of that; none without shadows, and where it is not timed.
    pub shadows_ms: Option<f64>,
    /// Where it is known.
    pub ceiling: Option<Ceiling>,
}

impl Setup {
    pub fn new(
        scene: &Scene,
        size: [u32; 2],
        object_pixels: u32,
        maps_ms: f64,
        machine: &Machine,
    ) -> Self {
        Self {
            device: machine.device().clone(),
            pipeline: machine.pipeline(),
            threads: machine.threads(),
            triangles: scene.polygons(),
            size,
            object_pixels,
            maps_ms,
            shadows_ms: machine.shadows_ms(),
            ceiling: Ceiling::of(machine),
        }
    }

    /// Device, pipeline and threads in words.
    pub fn name(&self) -> String {
        let device = self.device.name.split(" (").next().unwrap_or_default();
        match self.threads {
            Some(1) => "native, 1 core".into(),
            Some(threads) => format!("native, {threads} cores"),
            None => format!("{device}, {}", self.pipeline),
        }
    }
}

/// What a generation has to do.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Work {
    pub lights: usize,
    pub population: usize,
    pub rigs: Rigs,
}

/// Which rigs are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Rigs {
    /// Uniform in their boxes
    Uniform,
    /// All lights glare from one side: one half of each picture is dark, the other clipped
    Skewed,
}

impl fmt::Display for Rigs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Uniform => "uniform",
            Self::Skewed => "skewed",
        })
    }
}

/// A generation on a machine.
#[derive(Serialize)]
pub struct Row {
    #[serde(flatten)]
    pub setup: Setup,
    #[serde(flatten)]
    pub work: Work,
    /// The first generation, which makes memory and pipelines.
    pub first_ms: f64,
    pub runs: usize,
    pub median_ms: f64,
    /// 95 % confidence interval of the median; null for fewer than six runs.
    pub median_interval_ms: Option<[f64; 2]>,
    pub p95_ms: f64,
    /// Median of the GPU's own time.
    pub gpu_ms: Option<f64>,
    /// Median of the GPU's time for each stage, in the stages' order.
    pub stages_ms: Map<String, Value>,
    pub evaluations_per_second: f64,
    pub light_pixels_per_second: f64,
    /// Of the operations that the method needs; null for lights whose operations are not counted.
    pub gflops: Option<f64>,
    /// The least time for the work at the ceiling, as a share of the median.
    pub floor_share: Option<f64>,
    /// Most memory of the process since the view was set up.
    pub host_bytes: Option<u64>,
    /// Taken on the device.
    pub device_bytes: Option<u64>,
    /// Of the measured generations, ascending.
    #[serde(skip)]
    pub walls: Vec<f64>,
}

impl Row {
    pub fn new(
        setup: Setup,
        work: Work,
        kind: LightKind,
        (first_ms, sample, stages): (f64, &Sample, Stages),
        [host_bytes, device_bytes]: [Option<u64>; 2],
    ) -> Self {
        let median_ms = sample.median();
        let rate = 1e3 / median_ms;
        let pixels = f64::from(setup.object_pixels) * work.population as f64;
        let counted = kind == LightKind::POINT;
        let operations: f64 = operations(work.lights).into_iter().sum();
        let floor = setup.ceiling.map(|ceiling| ceiling.floor(work.lights, pixels));
        Self {
            first_ms,
            runs: sample.sorted.len(),
            median_ms,
            median_interval_ms: sample.interval(),
            p95_ms: sample.percentile(0.95),
            gpu_ms: stages.total(),
            stages_ms: stages.medians(),
            evaluations_per_second: work.population as f64 * rate,
            light_pixels_per_second: pixels * work.lights as f64 * rate,
            gflops: counted.then_some(operations * pixels * rate * 1e-9),
            floor_share: floor.filter(|_| counted).map(|seconds| seconds * rate),
            host_bytes,
            device_bytes,
            walls: sample.sorted.clone(),
            setup,
            work,
        }
    }

    /// Half-width of the median's interval, as a share of it.
    pub fn spread(&self) -> Option<f64> {
        self.median_interval_ms.map(|[low, high]| (high - low) / 2.0 / self.median_ms)
    }

    /// Whether the median is known so well.
    pub fn is_stable(&self, precision: f64) -> bool {
        self.spread().is_some_and(|spread| spread <= precision)
    }
}

/// The GPU's times for each stage, one for each generation.
#[derive(Debug, Default)]
pub struct Stages {
    stages: Vec<(&'static str, Vec<f64>)>,
    totals: Vec<f64>,
}

impl Stages {
    /// Adds those of a generation, if there are any.
    pub fn add(&mut self, times: &[(&'static str, f64)]) {
        for &(stage, time) in times {
            match self.stages.iter_mut().find(|(name, _)| *name == stage) {
                Some((_, times)) => times.push(time),
                None => self.stages.push((stage, vec![time])),
            }
        }
        if !times.is_empty() {
            self.totals.push(times.iter().map(|(_, time)| time).sum());
        }
    }

    fn total(&self) -> Option<f64> {
        (!self.totals.is_empty()).then(|| sorted_median(&self.totals))
    }

    fn medians(&self) -> Map<String, Value> {
        let median =
            |(name, times): &(&str, Vec<f64>)| ((*name).to_owned(), sorted_median(times).into());
        self.stages.iter().map(median).collect()
    }
}

fn sorted_median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sample::median(&sorted)
}
