//! `klieg design`: the search, and all that it leaves behind.

use super::config::{First, Method, Settings};
use super::options::{Kind, SceneOptions, TargetOptions};
use super::print;
use super::progress::{self, Interrupt};
use super::session::{Session, milliseconds, warn};
use super::values::Lights;
use crate::lighting::genome::Genome;
use crate::lighting::presets::Preset;
use crate::lighting::start::{self, StartSettings};
use crate::optimize::{self, Descent, Genetic, Optimizer, Outcome, Progress};
use crate::report::html::Sheet;
use crate::report::json::{self, Design};
use crate::report::{Staging, csv, picture, plot};
use crate::scene;
use anyhow::{Result, anyhow};
use clap::Args;
use indicatif::ProgressBar;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The lit scene.
const LIT: &str = "lit.glb";

/// Size of `convergence.svg`.
const PLOT: (u32, u32) = (800, 480);

/// Find the best lights for a scene
///
/// Writes best.png, headlight.png, report.html, lit.glb, result.json, convergence.csv and
/// convergence.svg. Ctrl-C ends the search after the running generation and writes the best so far.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// Folder for the results, created where absent
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The lights: roles such as key,fill,rim, or a number from 1 to 16 (a key, a fill, a rim, then
    /// fills and rims in turn) [default: key,fill]
    #[arg(long, value_name = "ROLES|NUMBER")]
    lights: Option<Lights>,
    /// Kind of the lights [default: point]
    #[arg(long)]
    kind: Option<Kind>,
    /// Individuals of a generation, 2 or more [default: 30]
    #[arg(long, value_name = "N")]
    population: Option<usize>,
    /// Generations, 1 or more [default: 100]
    #[arg(long, value_name = "N")]
    generations: Option<usize>,
    /// How the lights are searched [default: ga]
    #[arg(long)]
    optimizer: Option<Method>,
    /// Where the search begins [default: k-means]
    #[arg(long, value_name = "RIG")]
    first: Option<First>,
    /// Seed of every random choice [default: 0]
    #[arg(long)]
    seed: Option<u64>,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let mut settings = self.scene.settings()?;
        self.target.apply(&mut settings);
        if let Some(lights) = &self.lights {
            settings.lights.roles = lights.clone();
        }
        settings.lights.kind = self.kind.map_or(settings.lights.kind, Into::into);
        let search = &mut settings.search;
        search.population = self.population.unwrap_or(search.population);
        search.generations = self.generations.unwrap_or(search.generations);
        settings.optimizer = self.optimizer.unwrap_or(settings.optimizer);
        settings.first = self.first.unwrap_or(settings.first);
        settings.seed = self.seed.unwrap_or(settings.seed);
        Ok(settings)
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let settings = options.settings()?;
    let lights = &settings.lights;
    let genome = Genome::new(&lights.roles.0, lights.kind, &lights.boxes)?;
    let mut session = Session::open(&options.scene.scene, settings)?;
    let mut staging = Staging::new(&options.out)?;
    spare(&options.scene.scene, &options.out.join(LIT))?;

    let search = Instant::now();
    let outcome = search_lights(&mut session, &genome, options.scene.json)?;
    session.timing.search = milliseconds(search);

    let mut design = write(&mut session, &outcome, &mut staging)?;
    session.timing.total = milliseconds(start);
    design.timing_ms = session.timing;
    let text = json::text(&design)?;
    staging.write("result.json", &text)?;
    let files = staging.publish()?;
    if outcome.stopped {
        eprintln!("stopped after {} generations: this is the best so far", design.generations);
    }
    if options.scene.json { print::out(text) } else { print::out(print::design(&design, &files)) }
}

/// The scene itself must not be what the lit one replaces.
///
/// # Errors
/// [`crate::Error::Argument`] when both are the same file.
fn spare(scene: &Path, lit: &Path) -> crate::Result<()> {
    let same =
        scene.canonicalize().ok().is_some_and(|scene| lit.canonicalize().ok() == Some(scene));
    if same {
        let fault = format!("{} would be overwritten: choose another --out", scene.display());
        return Err(crate::Error::Argument(fault));
    }
    Ok(())
}

/// The individual that the search begins with.
fn first(session: &mut Session, genome: &Genome, rng: &mut ChaCha8Rng) -> Result<Vec<f32>> {
    let preset = match session.settings.first {
        First::KMeans => {
            let maps = session.evaluator.maps()?;
            return Ok(start::first(&session.scene, &session.view, maps, genome, rng));
        }
        First::Random => return Ok(genome.bounds().iter().map(|r| r.uniform(rng)).collect()),
        First::Scene => {
            let (rig, warnings) = scene::lights::rig(&session.scene, &session.view)?;
            warn(&warnings);
            return Ok(start::from_rig(genome, &rig)?);
        }
        First::Headlight => Preset::Headlight,
        First::LightKit => Preset::LightKit,
        First::ThreePoint => Preset::ThreePoint,
    };
    Ok(start::from_rig(genome, &preset.rig())?)
}

/// The search that the settings ask for.
fn search(session: &mut Session, genome: &Genome) -> Result<Box<dyn Optimizer>> {
    let Settings { seed, optimizer, start: spread, search, greedy, .. } = session.settings.clone();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = first(session, genome, &mut rng)?;
    let bounds = genome.bounds();
    Ok(match optimizer {
        Method::Ga => {
            let population = start::population(bounds, first, search.population, &spread, &mut rng);
            Box::new(Genetic::new(bounds, population, search, rng)?)
        }
        Method::Greedy => {
            let uniform = StartSettings { scattered: 0.0, ..spread };
            let starts = start::population(bounds, first, greedy.starts, &uniform, &mut rng);
            Box::new(Descent::new(bounds, &starts, greedy.descent())?)
        }
    })
}

/// Runs the search under the user's eyes.
fn search_lights(session: &mut Session, genome: &Genome, quiet: bool) -> Result<Outcome> {
    let mut search = search(session, genome)?;
    let interrupt = Interrupt::listen()?;
    let bar = progress_bar(&session.settings, quiet);
    let begin = Instant::now();
    let mut observe = |progress: &Progress| {
        let rate = progress.evaluations as f64 / begin.elapsed().as_secs_f64();
        bar.set_message(format!("F {:.4}, {rate:.0} evaluations/s", progress.best));
        bar.set_position(progress.generation as u64);
        interrupt.check()
    };
    let outcome = optimize::run(&mut *search, genome, &mut *session.evaluator, &mut observe)?;
    bar.finish_and_clear();
    Ok(outcome)
}

fn progress_bar(settings: &Settings, quiet: bool) -> ProgressBar {
    match settings.optimizer {
        Method::Ga => {
            let template = "{bar:32} {pos}/{len} generations, {msg}, {eta} left";
            progress::bar(Some(settings.search.generations as u64), template, quiet)
        }
        // A descent ends where the ground is level: nobody knows when.
        Method::Greedy => progress::bar(None, "{spinner} {pos} generations, {msg}", quiet),
    }
}

/// The search's settings in words.
fn in_words(settings: &Settings) -> String {
    let Settings { seed, search, greedy, .. } = settings;
    match settings.optimizer {
        Method::Ga => format!(
            "seed {seed}, population {}, elitism {:.0} %, crossover {:.0} %, mutation {:.0} %",
            search.population,
            100.0 * search.elitism,
            100.0 * search.crossover,
            100.0 * search.mutation,
        ),
        Method::Greedy => format!("seed {seed}, greedy descents from {} starts", greedy.starts),
    }
}

/// Writes everything but `result.json`, whose content it gives.
fn write(session: &mut Session, outcome: &Outcome, staging: &mut Staging) -> Result<Design> {
    let headlight_rig = Preset::Headlight.rig();
    let headlight = session.evaluator.inspect(&headlight_rig)?;
    let best = session.evaluator.inspect(&outcome.rig)?;
    let header = session.header(Design::SCHEMA);
    let Settings { seed, objective, .. } = &session.settings;
    let settings = in_words(&session.settings);
    let design =
        Design::new(header, (*seed, objective), (&best, &headlight), outcome, &session.view);

    let best = session.picture(&outcome.rig)?;
    let headlight = session.picture(&headlight_rig)?;
    staging.write("best.png", picture::png(&best)?)?;
    staging.write("headlight.png", picture::png(&headlight)?)?;
    let sheet = Sheet {
        design: &design,
        rig: &outcome.rig,
        best: &best,
        headlight: &headlight,
        history: &outcome.history,
        settings,
    };
    staging.write("report.html", sheet.render()?)?;
    let lit = staging.path(LIT);
    scene::lit::write(&session.scene.path, &session.view, &outcome.rig, &lit)?;
    staging.write("convergence.csv", csv::convergence(&outcome.history)?)?;
    let plot = plot::convergence(&outcome.history, PLOT).map_err(|e| anyhow!("plotting: {e}"))?;
    staging.write("convergence.svg", plot)?;
    Ok(design)
}
