//! Searches against each other at equal numbers of evaluations, paired by seed (Ha and Olivier 2006,
//! figures 8 and 12).

use super::statistics::{Quartiles, wilcoxon};
use super::{Observe, Subject, seeds};
use crate::Result;
use crate::design::{Course, race};
use crate::lighting::genome::Genome;
use crate::optimize::{Entry, Settings, find, genetic, random, restarts};

/// The searches that the paper's figures compare, by name.
pub const SEARCHES: [&str; 3] = [genetic::NAME, restarts::NAME, random::NAME];

/// All runs of one optimiser, in the order of the seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Contestant {
    /// The optimiser.
    pub optimizer: &'static Entry,
    /// A course for each seed.
    pub courses: Vec<Course>,
    /// For each seed, the scores of the local minima that it left for a new start.
    pub minima: Vec<Vec<f32>>,
}

/// Several optimisers, run with the same seeds and budgets.
#[derive(Debug, Clone, PartialEq)]
pub struct Contest {
    /// Evaluations of every run.
    pub budget: usize,
    /// The first seed; each further run has the next.
    pub seed: u64,
    /// The optimisers.
    pub contestants: Vec<Contestant>,
}

/// The scores of two optimisers, paired by seed.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Share of the runs in which the first one ended lower.
    pub won: f64,
    /// Share of the runs in which both ended alike.
    pub tied: f64,
    /// Median of the first one's score less the second's.
    pub median_difference: f32,
    /// Two-sided p-value of the Wilcoxon signed-rank test.
    pub p_value: f64,
}

impl Comparison {
    /// Of paired samples.
    pub fn of(a: &[f32], b: &[f32]) -> Self {
        let pairs = || a.iter().zip(b);
        let share = |count: usize| count as f64 / a.len().max(1) as f64;
        let differences: Vec<f32> = pairs().map(|(a, b)| a - b).collect();
        Self {
            won: share(pairs().filter(|(a, b)| a < b).count()),
            tied: share(pairs().filter(|(a, b)| a == b).count()),
            median_difference: Quartiles::of(&differences).median,
            p_value: wilcoxon(a, b),
        }
    }
}

impl Contestant {
    /// The last score of each run.
    pub fn scores(&self) -> Vec<f32> {
        self.courses.iter().map(Course::score).collect()
    }

    /// The best score of each run after some evaluations.
    pub fn best_after(&self, evaluations: usize) -> Vec<f32> {
        self.courses.iter().map(|course| course.best_after(evaluations)).collect()
    }
}

/// Runs the optimisers of these names side by side.
///
/// # Errors
/// [`crate::Error::Argument`] for an unknown name, settings or a number of runs out of range,
/// [`crate::Error::Interrupted`], and what the evaluator reports.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    settings: &Settings,
    (seed, runs): (u64, usize),
    optimizers: &[&str],
    observe: &mut Observe,
) -> Result<Contest> {
    let seeds = seeds(seed, runs)?;
    settings.check()?;
    let entries: Vec<_> = optimizers.iter().map(|name| find(name)).collect::<Result<_>>()?;
    let budget = settings.genetic.budget();
    let beginnings = subject.beginnings(genome, &seeds)?;
    let mut searches = Vec::new();
    for entry in &entries {
        for beginning in &beginnings {
            searches.push(beginning.clone().search(entry.name, genome, settings)?);
        }
    }
    let courses = race(&mut searches, budget, genome, subject.evaluator, observe)?;
    let contestant = |(number, optimizer): (usize, &'static Entry)| {
        let own = number * runs..(number + 1) * runs;
        let minima = searches[own.clone()].iter().map(|search| search.minima().to_vec()).collect();
        Contestant { optimizer, courses: courses[own].to_vec(), minima }
    };
    let contestants = entries.into_iter().enumerate().map(contestant).collect();
    Ok(Contest { budget, seed, contestants })
}
