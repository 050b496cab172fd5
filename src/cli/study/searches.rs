//! Studies of searches: their courses, their results in pairs, their settings, and the quality
//! function's numbers.

use super::{Common, RunOptions};
use crate::cli::config::Settings;
use crate::cli::optimizer::OptimizerName;
use crate::cli::print;
use crate::cli::progress::Watch;
use crate::cli::session::{self, Session};
use crate::cli::values::Lights;
use crate::lighting::genome::Genome;
use crate::optimize::{self, genetic, restarts};
use crate::report::Staging;
use crate::report::exhibit;
use crate::study::contest::{self, Contest, SEARCHES};
use crate::study::{ablation as ablations, sweep as sweeps};
use anyhow::Result;
use clap::Args;

/// What studies of searches ask for.
#[derive(Debug, Args)]
struct SearchOptions {
    #[command(flatten)]
    common: Common,
    /// The lights: roles such as key,fill,rim, or a number from 1 to 16 [default: key,fill]
    #[arg(long, value_name = "ROLES|NUMBER")]
    lights: Option<Lights>,
    #[command(flatten)]
    length: RunOptions,
}

/// How searches converge
///
/// The best F after every generation of the genetic algorithm, and after as many evaluations of
/// greedy descents with restarts and of uniform random search, or of other optimizers: means and
/// quartiles over the runs (figure 8 of the paper).
#[derive(Debug, Args)]
pub(super) struct ConvergenceOptions {
    #[command(flatten)]
    search: SearchOptions,
    /// The optimizers, one or several with commas between [default: ga,restarts,random]
    #[arg(long = "optimizers", value_name = "NAMES", value_delimiter = ',', value_parser = OptimizerName::parser())]
    optimizers: Vec<OptimizerName>,
}

/// The genetic algorithm against greedy descents
///
/// Both with the same seeds and numbers of evaluations: medians, quartiles, share of runs won, the
/// p-value of a Wilcoxon signed-rank test, and the median runs' pictures (figure 12 of the paper).
#[derive(Debug, Args)]
pub(super) struct CompareOptions {
    #[command(flatten)]
    search: SearchOptions,
}

/// Settings of the genetic algorithm
///
/// Population size, elitism, crossover and mutation rates, one changed at a time at equal numbers of
/// evaluations.
#[derive(Debug, Args)]
pub(super) struct SweepOptions {
    #[command(flatten)]
    search: SearchOptions,
}

/// Numbers of the quality function
///
/// Weights, targets and thresholds, one changed at a time: how the best lights and pictures change.
#[derive(Debug, Args)]
pub(super) struct AblationOptions {
    #[command(flatten)]
    search: SearchOptions,
}

/// A study of searches on its way.
struct Study {
    session: Session,
    staging: Staging,
    genome: Genome,
    settings: optimize::Settings,
    /// First seed, and runs.
    runs: (u64, usize),
}

impl SearchOptions {
    fn open(&self) -> Result<Study> {
        let mut settings = self.common.settings()?;
        if let Some(lights) = &self.lights {
            settings.lights.roles = lights.clone();
        }
        self.length.apply(&mut settings);
        crate::study::seeds(settings.seed, self.length.runs)?;
        let lights = &settings.lights;
        let genome = Genome::new(&lights.roles.0, lights.kind, &lights.boxes)?;
        let (seed, searches) = (settings.seed, settings.optimizers());
        let (session, staging) = self.common.open(settings)?;
        Ok(Study { session, staging, genome, settings: searches, runs: (seed, self.length.runs) })
    }

    fn watch(&self, searches: usize, settings: &optimize::Settings) -> Result<Watch> {
        let total = settings.genetic.budget().saturating_mul(searches) as u64;
        Watch::new(Some(total), self.common.scene.json)
    }

    fn contest(&self, study: &mut Study, optimizers: &[&str]) -> Result<Contest> {
        let watch = self.watch(optimizers.len() * self.length.runs, &study.settings)?;
        watch.stage("searches");
        let subject = &mut study.session.subject();
        let made = &mut |evaluations| watch.made(evaluations);
        Ok(contest::run(subject, &study.genome, &study.settings, study.runs, optimizers, made)?)
    }
}

pub(super) fn convergence(options: &ConvergenceOptions) -> Result<()> {
    let search = &options.search;
    let mut study = search.open()?;
    let chosen: Vec<_> = options.optimizers.iter().map(|OptimizerName(entry)| entry.name).collect();
    let optimizers = if chosen.is_empty() { &SEARCHES[..] } else { &chosen };
    let contest = search.contest(&mut study, optimizers)?;
    let Study { mut session, staging, genome, settings, .. } = study;
    let exhibit = exhibit::contest::convergence(
        &contest,
        settings.genetic.generation_sizes(),
        &genome,
        &mut session,
    )?;
    let mut table = print::columns(&["", "median F"], &["lowest", "highest", "settled after"]);
    for method in &exhibit.data.methods {
        let last = method.last;
        let numbers = [last.median, last.low, last.high].map(|score| format!("{score:.4}"));
        let name = method.title.to_owned();
        table.add_row([name].into_iter().chain(numbers).chain([method.settled.to_string()]));
    }
    let summary = format!("{table}\n");
    search.common.finish((session, staging), "convergence", &exhibit, &summary)
}

pub(super) fn compare(options: &CompareOptions) -> Result<()> {
    let search = &options.search;
    let mut study = search.open()?;
    let contest = search.contest(&mut study, &[genetic::NAME, restarts::NAME])?;
    let Study { mut session, staging, genome, .. } = study;
    let exhibit = exhibit::contest::compare(&contest, &genome, &mut session)?;
    let data = &exhibit.data;
    let comparison = &data.comparison;
    let summary = format!(
        "median F: genetic algorithm {:.4}, greedy with restarts {:.4}\n\
         the genetic algorithm won {:.0} % of {} runs; Wilcoxon signed-rank p = {:.3}: {}\n",
        data.genetic.quartiles.median,
        data.greedy.quartiles.median,
        100.0 * comparison.won,
        data.runs,
        comparison.p_value,
        comparison.verdict.words()
    );
    search.common.finish((session, staging), "compare", &exhibit, &summary)
}

pub(super) fn sweep(options: &SweepOptions) -> Result<()> {
    let search = &options.search;
    let mut study = search.open()?;
    let searches = sweeps::searches(&study.settings.genetic, search.length.runs);
    let watch = search.watch(searches, &study.settings)?;
    watch.stage("searches");
    let subject = &mut study.session.subject();
    let made = &mut |evaluations| watch.made(evaluations);
    let sweep = sweeps::run(subject, &study.genome, &study.settings, study.runs, made)?;
    drop(watch);
    let exhibit = exhibit::sweep::exhibit(&sweep)?;
    let names = ["", "value"];
    let more = ["median F", "quartiles", "against standard", "p"];
    let mut table = print::columns(&names, &more);
    for trial in &exhibit.data.trials {
        let (last, against) = (trial.last, trial.against_standard);
        let label = trial.parameter.label(trial.value);
        table.add_row([
            format!("{:?}", trial.parameter).to_lowercase(),
            if trial.standard { format!("{label} *") } else { label },
            format!("{:.4}", last.median),
            format!("{:.4} to {:.4}", last.first, last.third),
            format!("{:+.4}", against.median_difference),
            format!("{:.3}", against.p_value),
        ]);
    }
    let summary = format!("{table}\n\n* the standard settings\n");
    search.common.finish((study.session, study.staging), "sweep", &exhibit, &summary)
}

pub(super) fn ablation(options: &AblationOptions) -> Result<()> {
    let search = &options.search;
    let mut study = search.open()?;
    let base = study.session.settings.objective;
    let variants = ablations::variants(&base).len();
    let watch = search.watch(variants * search.length.runs, &study.settings)?;
    watch.stage("searches");
    let made = &mut |evaluations| watch.made(evaluations);
    let settings = study.session.settings.clone();
    let mut subject = study.session.subject();
    let (scene, view) = (subject.scene, subject.view);
    let mut make = |objective: &_| {
        let settings = Settings { objective: *objective, ..settings.clone() };
        Ok(session::evaluator(scene, view, &settings, &settings.device)?.boxed())
    };
    let (genome, searches) = (&study.genome, (&base, &study.settings));
    let effects = ablations::run(&mut subject, genome, searches, study.runs, &mut make, made)?;
    drop(watch);
    let Study { mut session, staging, .. } = study;
    let exhibit = exhibit::ablation::exhibit(&effects, &mut session)?;
    let mut table = print::columns(
        &["", "F"],
        &["edge", "mean", "grad", "var", "hist", "white", "key\nup", "key\naside", "change"],
    );
    print::tighten(&mut table);
    for variant in &exhibit.data.variants {
        let numbers = [variant.score].into_iter().chain(variant.terms.values());
        let numbers = numbers.map(|x| format!("{x:.3}")).chain([
            format!("{:.1} %", 100.0 * variant.white),
            format!("{:.0}°", variant.key_elevation_deg),
            format!("{:.0}°", variant.key_from_viewer_deg),
            format!("{:.3}", variant.change),
        ]);
        table.add_row([variant.name.clone()].into_iter().chain(numbers));
    }
    search.common.finish((session, staging), "ablation", &exhibit, &format!("{table}\n"))
}
