//! Optimisers over many scenes, against the lowest `F` that is known.

use super::RunOptions;
use crate::cli::config::Settings;
use crate::cli::optimizer::OptimizerName;
use crate::cli::options::{LookOptions, TargetOptions};
use crate::cli::print;
use crate::cli::progress::Watch;
use crate::cli::session::Session;
use crate::cli::values::Lights;
use crate::design::profile::{self, Profile};
use crate::evaluate::DeviceInfo;
use crate::lighting::genome::Genome;
use crate::report::Staging;
use crate::report::exhibit::Exhibit;
use crate::report::exhibit::gaps::{self, Figures};
use crate::report::json::{self, ObjectiveRecord};
use crate::study::gaps::{Case, Long, TARGETS};
use crate::study::seeds;
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Optimizers over many scenes
///
/// How far above the lowest F that is known each optimizer ends, in percent, over all scenes and runs: median,
/// quartiles and worst, and how many evaluations it takes to come near. What is known is the lowest of all runs, and
/// of longer ones of SHADE.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// glTF scenes
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Numbers of lights, one or several with commas between
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', default_value = "1,2,3")]
    lights: Vec<usize>,
    /// The optimizers, one or several with commas between
    #[arg(long = "optimizers", value_name = "NAMES", value_delimiter = ',', value_parser = OptimizerName::parser(),
        default_value = "ga,shade")]
    optimizers: Vec<OptimizerName>,
    #[command(flatten)]
    length: RunOptions,
    /// Longer runs, 0 to 1000
    #[arg(long, value_name = "N", default_value_t = 2)]
    long_runs: usize,
    /// Evaluations of a longer run, as a multiple of the budget
    #[arg(long, value_name = "N", default_value_t = 5)]
    longer: usize,
    /// Seed of every random choice [default: 0]
    #[arg(long)]
    seed: Option<u64>,
    /// Print JSON, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

/// `optimizers.json`.
#[derive(Serialize)]
struct File<'a> {
    schema: &'static str,
    klieg: &'static str,
    profile: &'static str,
    device: DeviceInfo,
    seed: u64,
    objective: ObjectiveRecord,
    #[serde(flatten)]
    figures: &'a Figures,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let mut settings = self.look.settings(&profile::PAPER)?;
        self.target.apply(&mut settings);
        self.length.apply(&mut settings);
        settings.seed = self.seed.unwrap_or(settings.seed);
        seeds(settings.seed, self.length.runs)?;
        seeds(settings.seed, self.long_runs.max(1))?;
        settings.check()?;
        Ok(settings)
    }

    fn genomes(&self, settings: &Settings) -> crate::Result<Vec<Genome>> {
        let genome = |&number: &usize| {
            let Lights(roles) = Lights::number(number).map_err(crate::Error::Argument)?;
            Genome::new(&roles, settings.lights.kind, &settings.lights.boxes)
        };
        self.lights.iter().map(genome).collect()
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    let settings = options.settings()?;
    let genomes = options.genomes(&settings)?;
    let searches = settings.optimizers();
    let budget = searches.genetic.budget();
    let long = Long { evaluations: budget.saturating_mul(options.longer), runs: options.long_runs };
    let names: Vec<_> = options.optimizers.iter().map(|OptimizerName(entry)| entry.name).collect();
    let mut staging = Staging::new(&options.out)?;
    let watch = Watch::new(None, options.json)?;
    let (mut cases, mut device) = (Vec::<Case>::new(), None);
    for scene in &options.scenes {
        let mut session = Session::open(scene, settings.clone())?;
        for genome in &genomes {
            watch.stage(format!("{}, {} lights", scene.display(), genome.lights()));
            let (runs, made) = ((settings.seed, options.length.runs), &mut |made| watch.made(made));
            let subject = &mut session.subject();
            cases.push(crate::study::gaps::case(
                subject, genome, &searches, runs, &names, long, made,
            )?);
        }
        device = Some(session.evaluator.device().clone());
    }
    drop(watch);

    let exhibit = gaps::exhibit(&cases)?;
    exhibit.write(&mut staging)?;
    let Profile { name, .. } = settings.profile.0;
    let text = json::text(&File {
        schema: "klieg.optimizers/1",
        klieg: env!("CARGO_PKG_VERSION"),
        profile: name,
        device: device.context("there are scenes")?,
        seed: settings.seed,
        objective: (&settings.objective).into(),
        figures: &exhibit.data,
    })?;
    staging.write("optimizers.json", &text)?;
    let files = staging.publish()?;
    if options.json {
        return print::out(text);
    }
    print::out(format!("{}\n\n{}", summary(&exhibit), print::written(&files)))
}

fn summary(exhibit: &Exhibit<Figures>) -> String {
    let within = |at: usize| format!("within\n{} %", TARGETS[at]);
    let (two, one) = (within(2), within(3));
    let numbers = ["median\ngap, %", "quartiles", "worst", &two, &one, "evalua-\ntions"];
    let mut table = print::columns(&["lights", ""], &numbers);
    print::tighten(&mut table);
    for standing in &exhibit.data.standings {
        let gaps = standing.gaps;
        table.add_row([
            standing.lights.to_string(),
            standing.title.to_owned(),
            format!("{:.2}", gaps.median),
            format!("{:.2} to {:.2}", gaps.first, gaps.third),
            format!("{:.1}", gaps.high),
            format!("{:.0} %", 100.0 * standing.within[2]),
            format!("{:.0} %", 100.0 * standing.within[3]),
            format!("{:.0}", standing.evaluations),
        ]);
    }
    table.to_string()
}
