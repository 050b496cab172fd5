//! `klieg study`: the paper's experiments on any scene.

mod optimizers;
mod positions;
mod searches;

use super::config::Settings;
use super::lights::kinds;
use super::options::{SceneOptions, TargetOptions};
use super::print;
use super::session::Session;
use crate::design::profile;
use crate::lighting::LightKind;
use crate::report::Staging;
use crate::report::exhibit::{Exhibit, StudyFile};
use crate::report::json;
use anyhow::Result;
use clap::{Args, Subcommand};
use serde::Serialize;
use std::path::PathBuf;

/// Run an experiment of the paper on a scene
///
/// Writes tables (CSV), plots (SVG), pictures (PNG) and the figures as JSON. All runs of a study are
/// evaluated side by side. Ctrl-C ends a study without writing anything.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(subcommand)]
    study: Study,
}

#[derive(Debug, Subcommand)]
enum Study {
    Landscape(positions::LandscapeOptions),
    Starts(positions::StartsOptions),
    Convergence(searches::ConvergenceOptions),
    Compare(searches::CompareOptions),
    Sweep(searches::SweepOptions),
    Ablation(searches::AblationOptions),
    Optimizers(optimizers::Options),
}

pub(super) fn run(options: &Options) -> Result<()> {
    match &options.study {
        Study::Landscape(options) => positions::landscape(options),
        Study::Starts(options) => positions::starts(options),
        Study::Convergence(options) => searches::convergence(options),
        Study::Compare(options) => searches::compare(options),
        Study::Sweep(options) => searches::sweep(options),
        Study::Ablation(options) => searches::ablation(options),
        Study::Optimizers(options) => optimizers::run(options),
    }
}

/// What all studies ask for.
#[derive(Debug, Args)]
struct Common {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Kind of the lights [default: point]
    #[arg(long, value_parser = kinds())]
    kind: Option<LightKind>,
    /// Seed of every random choice [default: 0]
    #[arg(long)]
    seed: Option<u64>,
}

/// How many searches studies make, and how long they are.
#[derive(Debug, Args)]
struct RunOptions {
    /// Runs of each search, each with a seed of its own, 1 to 1000
    #[arg(long, value_name = "N", default_value_t = 10)]
    runs: usize,
    /// Individuals of a generation, 2 or more [default: the profile's; natural: 20, paper: 30]
    #[arg(long, value_name = "N")]
    population: Option<usize>,
    /// Generations of the genetic algorithm, whose evaluations are the budget of every search
    /// [default: 100]
    #[arg(long, value_name = "N")]
    generations: Option<usize>,
}

impl RunOptions {
    /// Puts these options in the place of `settings`.
    fn apply(&self, settings: &mut Settings) {
        let search = &mut settings.search;
        search.population = self.population.unwrap_or(search.population);
        search.generations = self.generations.unwrap_or(search.generations);
    }
}

impl Common {
    fn settings(&self) -> crate::Result<Settings> {
        let mut settings = self.scene.settings(&profile::PAPER)?;
        self.target.apply(&mut settings);
        settings.lights.kind = self.kind.unwrap_or(settings.lights.kind);
        settings.seed = self.seed.unwrap_or(settings.seed);
        Ok(settings)
    }

    /// The scene in view, and a place for the results.
    fn open(&self, settings: Settings) -> Result<(Session, Staging)> {
        let session = Session::open(self.scene.path()?, settings)?;
        let inputs = session.inputs(self.scene.config());
        Ok((session, Staging::new(&self.out)?.sparing(inputs)))
    }

    /// Writes an exhibit and its figures, and prints `summary` or the figures.
    fn finish<T: Serialize>(
        &self,
        (session, mut staging): (Session, Staging),
        study: &'static str,
        exhibit: &Exhibit<T>,
        summary: &str,
    ) -> Result<()> {
        exhibit.write(&mut staging)?;
        let file = StudyFile {
            header: session.header(StudyFile::<T>::SCHEMA),
            study,
            seed: session.settings.seed,
            objective: (&session.settings.objective).into(),
            figures: &exhibit.data,
        };
        let text = json::text(&file)?;
        staging.write(format!("{study}.json"), &text)?;
        let files = staging.publish()?;
        if self.scene.json {
            print::out(text)
        } else {
            print::out(format!("{summary}\n{}", print::written(&files)))
        }
    }
}
