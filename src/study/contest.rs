//! Searches against each other at equal numbers of evaluations, paired by seed (Ha and Olivier 2006,
//! figures 8 and 12).

use super::statistics::{LEVEL, Quartiles, least_p_value, wilcoxon};
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
    /// What that says.
    pub verdict: Finding,
}

/// What a comparison of two optimisers says of the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finding {
    /// It ends lower, by more than chance.
    Lower,
    /// It ends higher, by more than chance.
    Higher,
    /// What difference there is may be chance.
    Alike,
    /// With so few runs no difference could be told from chance.
    TooFewRuns,
}

impl Finding {
    /// In words that follow the optimiser's name.
    pub fn words(self) -> &'static str {
        match self {
            Self::Lower => "ends lower",
            Self::Higher => "ends higher",
            Self::Alike => "does not differ beyond chance",
            Self::TooFewRuns => "too few runs to tell",
        }
    }
}

impl Comparison {
    /// Of paired samples.
    pub fn of(a: &[f32], b: &[f32]) -> Self {
        let pairs = || a.iter().zip(b);
        let share = |count: usize| count as f64 / a.len().max(1) as f64;
        let differences: Vec<f32> = pairs().map(|(a, b)| a - b).collect();
        let median_difference = Quartiles::of(&differences).median;
        let p_value = wilcoxon(a, b);
        let verdict = match p_value < LEVEL {
            _ if least_p_value(a.len().min(b.len())) >= LEVEL => Finding::TooFewRuns,
            true if median_difference < 0.0 => Finding::Lower,
            true if median_difference > 0.0 => Finding::Higher,
            _ => Finding::Alike,
        };
        Self {
            won: share(pairs().filter(|(a, b)| a < b).count()),
            tied: share(pairs().filter(|(a, b)| a == b).count()),
            median_difference,
            p_value,
            verdict,
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
    let budget = settings.genetic.budget();
    run_within(budget, subject, genome, settings, (seed, runs), optimizers, observe)
}

/// As [`run`], with another number of evaluations for every run.
///
/// # Errors
/// The same.
pub fn run_within(
    budget: usize,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_pairs_are_too_few_to_tell_and_six_can_tell() {
        let verdict = |a: &[f32], b: &[f32]| Comparison::of(a, b).verdict;
        let (low, high) = ([0.1, 0.2, 0.3, 0.1, 0.2, 0.1], [0.4, 0.6, 0.8, 0.5, 0.9, 0.7]);
        assert_eq!(verdict(&low[..5], &high[..5]), Finding::TooFewRuns);
        assert_eq!(verdict(&low, &high), Finding::Lower);
        assert_eq!(verdict(&high, &low), Finding::Higher);
        assert_eq!(verdict(&low, &low), Finding::Alike);
        let mut mixed = high;
        mixed[0] = 0.0;
        assert_eq!(verdict(&low, &mixed), Finding::Alike);
        assert_eq!(verdict(&[], &[]), Finding::TooFewRuns);
    }
}
