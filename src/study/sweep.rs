//! The genetic algorithm's settings, one changed at a time at an equal number of evaluations: whether
//! the paper's 30 individuals, 10 % elitism, 80 % crossover and 20 % mutation hold up on a scene.

use super::contest::Comparison;
use super::{Observe, Subject, seeds};
use crate::Result;
use crate::design::{Course, race};
use crate::lighting::genome::Genome;
use crate::optimize::{GeneticSettings, Settings, genetic};

/// A setting that is swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Parameter {
    /// Individuals.
    Population,
    /// Share of elites.
    Elitism,
    /// Crossover rate.
    Crossover,
    /// Mutation rate.
    Mutation,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Population, Self::Elitism, Self::Crossover, Self::Mutation];

    /// The values tried beside the standard one.
    fn values(self) -> &'static [f32] {
        match self {
            Self::Population => &[10.0, 20.0, 30.0, 60.0, 120.0],
            Self::Elitism => &[0.0, 0.05, 0.1, 0.2, 0.4],
            Self::Crossover => &[0.2, 0.4, 0.6, 0.8, 1.0],
            Self::Mutation => &[0.05, 0.1, 0.2, 0.4, 0.8],
        }
    }

    fn of(self, settings: &GeneticSettings) -> f32 {
        match self {
            Self::Population => settings.population as f32,
            Self::Elitism => settings.elitism,
            Self::Crossover => settings.crossover,
            Self::Mutation => settings.mutation,
        }
    }

    fn set(self, settings: &mut GeneticSettings, value: f32) {
        match self {
            Self::Population => settings.population = value as usize,
            Self::Elitism => settings.elitism = value,
            Self::Crossover => settings.crossover = value,
            Self::Mutation => settings.mutation = value,
        }
    }

    /// The value as people write it.
    pub fn label(self, value: f32) -> String {
        match self {
            Self::Population => format!("{value}"),
            _ => format!("{:.4}", 100.0 * value).trim_end_matches('0').trim_end_matches('.').into(),
        }
    }
}

/// The runs with one setting changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// What is changed.
    pub parameter: Parameter,
    /// To what.
    pub value: f32,
    /// Whether it is the standard value, from which nothing is changed.
    pub standard: bool,
    /// The last score of each run.
    pub scores: Vec<f32>,
    /// Against the standard runs of the same seeds.
    pub against_standard: Comparison,
}

/// All trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The standard settings.
    pub standard: GeneticSettings,
    /// Evaluations of every run.
    pub budget: usize,
    /// The first seed; each further run has the next.
    pub seed: u64,
    /// Parameter after parameter, with rising values.
    pub trials: Vec<Trial>,
}

/// Number of searches of a sweep.
pub fn searches(standard: &GeneticSettings, runs: usize) -> usize {
    let changes = changes(standard);
    (1 + changes.iter().filter(|(_, _, is_standard)| !is_standard).count()) * runs
}

/// Every value of every parameter, and whether it is the standard one.
fn changes(standard: &GeneticSettings) -> Vec<(Parameter, f32, bool)> {
    let mut changes = Vec::new();
    for parameter in Parameter::ALL {
        let own = parameter.of(standard);
        let mut values: Vec<f32> = parameter.values().to_vec();
        if !values.contains(&own) {
            values.push(own);
        }
        values.sort_by(f32::total_cmp);
        changes.extend(values.into_iter().map(|value| (parameter, value, value == own)));
    }
    changes
}

/// Runs all trials side by side.
///
/// # Errors
/// [`crate::Error::Argument`] for settings or a number of runs out of range,
/// [`crate::Error::Interrupted`], and what the evaluator reports.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    settings: &Settings,
    (seed, runs): (u64, usize),
    observe: &mut Observe,
) -> Result<Sweep> {
    let seeds = seeds(seed, runs)?;
    settings.check()?;
    let budget = settings.genetic.budget();
    let standard = settings.genetic;
    let changes = changes(&standard);
    let beginnings = subject.beginnings(genome, &seeds)?;
    // The standard settings run once for all parameters.
    let mut variants = vec![standard];
    for &(parameter, value, _) in changes.iter().filter(|(_, _, is_standard)| !is_standard) {
        let mut variant = standard;
        parameter.set(&mut variant, value);
        variants.push(variant);
    }
    let mut searches = Vec::new();
    for genetic in variants {
        let settings = Settings { genetic, ..*settings };
        for beginning in &beginnings {
            searches.push(beginning.clone().search(genetic::NAME, genome, &settings)?);
        }
    }
    let courses = race(&mut searches, budget, genome, subject.evaluator, observe)?;
    let scores = courses.chunks(runs).map(|runs| runs.iter().map(Course::score).collect());
    let scores: Vec<Vec<f32>> = scores.collect();
    let mut changed = scores[1..].iter();
    let trial = |(parameter, value, standard): (Parameter, f32, bool)| {
        let own = if standard { None } else { changed.next() }.unwrap_or(&scores[0]);
        let against_standard = Comparison::of(own, &scores[0]);
        Trial { parameter, value, standard, scores: own.clone(), against_standard }
    };
    let trials = changes.into_iter().map(trial).collect();
    Ok(Sweep { standard, budget, seed, trials })
}
