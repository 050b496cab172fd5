//! `klieg bench`: how long a generation takes.

mod ceiling;
mod machine;
mod memory;
mod output;
mod record;
mod relief;
mod sample;

use super::config::{Pipeline, Settings};
use super::lights::kinds;
use super::options::LookOptions;
use super::print;
use super::session::{self, SIZE, milliseconds};
use super::values::{Device, Lights, Size};
use crate::Error;
use crate::design::profile;
use crate::lighting::genome::Genome;
use crate::lighting::{LightKind, Population, Rig, check_number};
use crate::math::range::Range;
use crate::optimize::MAX_POPULATION;
use crate::report::{Inputs, Staging, json};
use crate::scene::Scene;
use anyhow::Result;
use clap::Args;
use machine::{Baseline, Machine, Method};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use record::{Bench, Rigs, Row, SceneRecord, Setup, Work};
use relief::Triangles;
use sample::Plan;
use std::f32::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time a generation
///
/// Evaluates random rigs, the same everywhere, for every combination of scene, size, device, pipeline,
/// number of lights and population. A generation is the wall time from new lights on the host to
/// scores on the host; it is repeated until the 95 % confidence interval of its median is narrow.
/// Lists are separated by commas.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Scene: a .gltf or .glb file, or a .ply, .stl or .obj one
    #[arg(required_unless_present = "triangles", conflicts_with = "triangles")]
    scene: Option<PathBuf>,
    /// In place of a scene, reliefs of about so many triangles, such as 10k,1M; all have the same
    /// object pixels
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    triangles: Vec<Triangles>,
    /// Draw the reliefs as 16 instances of one tile
    #[arg(long, conflicts_with = "scene")]
    instanced: bool,
    #[command(flatten)]
    look: LookOptions,
    /// Picture sizes
    #[arg(long, value_name = "WxH,…", value_delimiter = ',', default_values_t = [SIZE])]
    size: Vec<Size>,
    /// Numbers of lights
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [1, 4])]
    lights: Vec<usize>,
    /// Kind of the lights
    #[arg(long, default_value = "point", value_parser = kinds())]
    kind: LightKind,
    /// Numbers of individuals
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [30])]
    population: Vec<usize>,
    /// Rigs of lights
    #[arg(long, value_name = "RIGS,…", value_delimiter = ',', default_values_t = [Rigs::Uniform])]
    rigs: Vec<Rigs>,
    /// Devices [default: cpu and, where there is one, vulkan]
    #[arg(long, value_name = "DEVICE,…", value_delimiter = ',')]
    device: Vec<Device>,
    /// How Vulkan devices make the pictures [default: auto]
    #[arg(long, value_name = "PIPELINE,…", value_delimiter = ',')]
    pipeline: Vec<Pipeline>,
    /// What else is measured, to compare with
    #[arg(long, value_name = "BASELINE,…", value_delimiter = ',')]
    baseline: Vec<Baseline>,
    /// Generations before the measured ones, at least
    #[arg(long, value_name = "N", default_value_t = 5)]
    warm_up: u32,
    /// Most measured generations
    #[arg(long, value_name = "N", default_value_t = 200,
        value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Most seconds for the measured generations of a row
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    seconds: f64,
    /// Half-width of the median's confidence interval, as a share of it, that is enough
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    precision: f64,
    /// Seed of the rigs
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Folder for bench.json, bench.csv and a plot of each sweep, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &Options) -> Result<()> {
    let settings = options.look.settings(&profile::PAPER)?;
    settings.check()?;
    options.check()?;
    let pipelines = match &options.pipeline[..] {
        [] => &[settings.pipeline],
        given => given,
    };
    let methods = machine::methods(&options.device, pipelines, &options.baseline)?;
    // A folder that cannot be written to is told at once; an interrupted run leaves nothing in it.
    options.out.as_deref().map(Staging::new).transpose()?;
    let mut bench = Bench::new(settings.profile.0, options.kind, options.seed, &options.plan());
    let mut inputs = Inputs::new(options.look.config());
    for source in options.sources() {
        let start = Instant::now();
        let scene = source.scene(&settings)?;
        let load_ms = milliseconds(start);
        inputs.extend(session::inputs(&scene, None));
        bench.scenes.push(SceneRecord::new(&scene, load_ms));
        for size in &options.size {
            for method in &methods {
                let mut settings = settings.clone();
                settings.view.size = Some(*size);
                bench.rows.extend(options.measure(&scene, &settings, method)?);
            }
        }
    }
    let files = match &options.out {
        Some(out) => output::write(&bench, Staging::new(out)?.sparing(inputs))?,
        None => Vec::new(),
    };
    if options.json {
        print::out(json::text(&bench)?)
    } else {
        print::out(output::show(&bench) + &print::written(&files))
    }
}

/// Where a scene comes from.
enum Source<'a> {
    File(&'a PathBuf),
    Relief(Triangles, bool),
}

impl Source<'_> {
    fn scene(&self, settings: &Settings) -> Result<Scene> {
        match *self {
            Self::File(path) => session::load(path, &settings.loading()),
            Self::Relief(triangles, instanced) => Ok(relief::scene(triangles, instanced)),
        }
    }
}

impl Options {
    fn sources(&self) -> impl Iterator<Item = Source<'_>> {
        let reliefs = self.triangles.iter().map(|&n| Source::Relief(n, self.instanced));
        self.scene.iter().map(Source::File).chain(reliefs)
    }

    fn plan(&self) -> Plan {
        Plan {
            warm_up: self.warm_up,
            runs: self.runs,
            limit: Duration::from_secs_f64(self.seconds),
            precision: self.precision,
        }
    }

    fn check(&self) -> Result<(), Error> {
        self.lights.iter().try_for_each(|&lights| check_number(lights))?;
        if let Some(n) = self.population.iter().find(|n| !(1..=MAX_POPULATION).contains(*n)) {
            let fault = format!("a population of {n}: it is 1 to {MAX_POPULATION}");
            return Err(Error::Argument(fault));
        }
        if !(0.0..=86_400.0).contains(&self.seconds) {
            return Err(Error::Argument(format!(
                "seconds is {}: it must be 0 to 86400",
                self.seconds
            )));
        }
        if !(0.0..=1.0).contains(&self.precision) {
            return Err(Error::Argument(format!(
                "precision is {}: it must be 0 to 1",
                self.precision
            )));
        }
        Ok(())
    }

    /// All rows of one view and one method.
    fn measure(&self, scene: &Scene, settings: &Settings, method: &Method) -> Result<Vec<Row>> {
        let view = session::view(scene, &settings.view)?;
        memory::reset_peak();
        let start = Instant::now();
        let mut machine = Machine::new(method, scene, &view, settings)?;
        let maps_ms = milliseconds(start);
        let object_pixels = machine.objects()?;
        if object_pixels == 0 {
            let fault = format!("camera '{}' sees nothing of the scene", view.camera.name);
            return Err(Error::input(&scene.path, fault).into());
        }
        let setup = Setup::new(scene, [view.width, view.height], object_pixels, maps_ms, &machine);
        let (name, triangles) = (setup.name(), setup.triangles);
        tracing::info!("measuring {name}, {triangles} triangles, {}", Size(setup.size));
        let mut rows = Vec::new();
        for &lights in &self.lights {
            for &population in &self.population {
                for &rigs in &self.rigs {
                    let work = Work { lights, population, rigs };
                    rows.push(self.row(settings, setup.clone(), work, &mut machine)?);
                }
            }
        }
        Ok(rows)
    }

    fn row(
        &self,
        settings: &Settings,
        setup: Setup,
        work: Work,
        machine: &mut Machine,
    ) -> Result<Row> {
        let roles = Lights::number(work.lights).map_err(Error::Argument)?.0;
        let genome = Genome::new(&roles, self.kind, &settings.lights.boxes)?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut scores = vec![0.0; work.population];
        let mut generation = |machine: &mut Machine| {
            let rigs = random(&genome, &work, &mut rng)?;
            let start = Instant::now();
            machine.evaluate(&rigs, &mut scores)?;
            Ok(milliseconds(start))
        };
        let first_ms = generation(machine)?;
        let mut stages = record::Stages::default();
        let sample = self.plan().sample(|counts| {
            let wall = generation(machine)?;
            if counts {
                stages.add(machine.stage_times());
            }
            Ok(wall)
        })?;
        let memory = [memory::peak(), machine.device_memory()];
        Ok(Row::new(setup, work, self.kind, (first_ms, &sample, stages), memory))
    }
}

/// Diffuse intensity of a glaring light.
const GLARE: f32 = 100.0;

/// A population of random rigs.
fn random(genome: &Genome, work: &Work, rng: &mut ChaCha8Rng) -> Result<Population, Error> {
    let mut population = Population::new(genome.rig_lights())?;
    for _ in 0..work.population {
        population.push(&rig(genome, work.rigs, rng))?;
    }
    Ok(population)
}

fn rig(genome: &Genome, rigs: Rigs, rng: &mut ChaCha8Rng) -> Rig {
    let chromosome: Vec<f32> = genome.bounds().iter().map(|r: &Range| r.uniform(rng)).collect();
    let mut rig = genome.decode(&chromosome);
    if rigs == Rigs::Skewed {
        let side = if rng.random() { FRAC_PI_2 } else { -FRAC_PI_2 };
        for light in &mut rig {
            (light.elevation, light.azimuth) = (0.0, side);
            (light.diffuse, light.specular) = (GLARE, 0.0);
        }
    }
    rig
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::{self, CpuEvaluator};
    use crate::evaluate::Evaluator;
    use crate::lighting::genome::Boxes;
    use crate::lighting::shading::Shading;
    use crate::objective::{HISTOGRAM_BINS, Objective};
    use crate::scene::view::View;

    #[test]
    fn skewed_pictures_are_half_dark_and_half_clipped() {
        let scene = relief::scene("5k".parse().unwrap(), false);
        let view = View::new(&scene, scene.cameras[0].clone(), 64, 64).unwrap();
        let objective = Objective::default();
        let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &objective);
        let objects = maps.counts.object() as f32;
        let mut evaluator = CpuEvaluator::new(maps, &view, objective, Shading::default()).unwrap();
        let roles = Lights::number(2).unwrap().0;
        let genome = Genome::new(&roles, LightKind::POINT, &Boxes::default()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut halves = |rigs| {
            let seen = evaluator.inspect(&rig(&genome, rigs, &mut rng)).unwrap();
            let bins = seen.statistics.histogram;
            let dark: u32 = bins[..HISTOGRAM_BINS / 4].iter().sum();
            [dark, bins[HISTOGRAM_BINS - 1]].map(|count| count as f32 / objects)
        };
        for _ in 0..4 {
            assert!(halves(Rigs::Skewed).into_iter().all(|half| half > 0.4));
            assert!(!halves(Rigs::Uniform).into_iter().all(|half| half > 0.4));
        }
    }
}
