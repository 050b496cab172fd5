//! Searches against each other at equal numbers of evaluations, paired by seed (Ha and Olivier 2006,
//! figures 8 and 12).

use super::statistics::{Quartiles, wilcoxon};
use super::{Method, Observe, Search, SearchSettings, Subject, seeds};
use crate::Result;
use crate::lighting::genome::Genome;
use crate::optimize::{Course, race};

/// All runs of one method, in the order of the seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Contestant {
    /// The method.
    pub method: Method,
    /// A course for each seed.
    pub courses: Vec<Course>,
    /// For each seed, where the descents of a greedy search ended that came to their end.
    pub ends: Vec<Vec<f32>>,
}

/// Several methods, run with the same seeds and budgets.
#[derive(Debug, Clone, PartialEq)]
pub struct Contest {
    /// Evaluations of every run.
    pub budget: usize,
    /// The first seed; each further run has the next.
    pub seed: u64,
    /// The methods.
    pub contestants: Vec<Contestant>,
}

/// The scores of two methods, paired by seed.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Share of the runs in which the first method ended lower.
    pub won: f64,
    /// Share of the runs in which both ended alike.
    pub tied: f64,
    /// Median of the first method's score less the second's.
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

/// Runs all methods side by side.
///
/// # Errors
/// [`crate::Error::Argument`] for settings or a number of runs out of range,
/// [`crate::Error::Interrupted`], and what the evaluator reports.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    settings: &SearchSettings,
    (seed, runs): (u64, usize),
    methods: &[Method],
    observe: &mut Observe,
) -> Result<Contest> {
    let seeds = seeds(seed, runs)?;
    settings.genetic.check()?;
    let budget = settings.budget();
    let beginnings = subject.beginnings(genome, &seeds)?;
    let mut searches = Vec::new();
    for &method in methods {
        for beginning in &beginnings {
            searches.push(beginning.clone().search(method, genome, settings)?);
        }
    }
    let mut optimizers: Vec<_> = searches.iter_mut().map(Search::optimizer).collect();
    let courses = race(&mut optimizers, budget, genome, subject.evaluator, observe)?;
    let contestant = |(&method, (courses, searches)): (&Method, (&[Course], &[Search]))| {
        let ends = searches.iter().map(Search::ends).collect();
        Contestant { method, courses: courses.to_vec(), ends }
    };
    let runs_of_each = courses.chunks(runs).zip(searches.chunks(runs));
    let contestants = methods.iter().zip(runs_of_each).map(contestant).collect();
    Ok(Contest { budget, seed, contestants })
}
