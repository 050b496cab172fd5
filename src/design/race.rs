//! Many searches side by side: what all of them ask for is evaluated as one population, and each gets
//! the scores that it would get alone.

use super::Batch;
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::optimize::Optimizer;
use crate::{Error, Result};
use serde::Serialize;
use std::ops::ControlFlow;

/// An evaluation that was better than all before it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Improvement {
    /// Its number, from 1.
    pub evaluation: usize,
    /// Its `F`.
    pub score: f32,
}

/// The course of a search.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course {
    /// Every improvement, in order.
    pub improvements: Vec<Improvement>,
    /// The best chromosome.
    pub chromosome: Vec<f32>,
    /// Evaluations in all.
    pub evaluations: usize,
}

impl Course {
    /// Lowest score of all; infinite without an evaluation.
    pub fn score(&self) -> f32 {
        self.improvements.last().map_or(f32::INFINITY, |last| last.score)
    }

    /// Lowest score of the first `evaluations`; infinite before the first.
    pub fn best_after(&self, evaluations: usize) -> f32 {
        let made = self.improvements.partition_point(|i| i.evaluation <= evaluations);
        self.improvements[..made].last().map_or(f32::INFINITY, |last| last.score)
    }

    fn add(&mut self, chromosome: &[f32], score: f32) {
        self.evaluations += 1;
        if score < self.score() {
            self.improvements.push(Improvement { evaluation: self.evaluations, score });
            self.chromosome = chromosome.to_vec();
        }
    }
}

/// Runs every search until it ends by itself or `budget` evaluations have been made for it. The last
/// questions of a search are cut where the budget ends, so that all have been given exactly as much.
///
/// `observe` is told how many evaluations were made since it was last called.
///
/// # Errors
/// [`Error::Interrupted`] when `observe` breaks off, [`Error::Argument`] for a search that asks for
/// chromosomes of another length than the genome's, and what the evaluator reports.
pub fn race(
    searches: &mut [Box<dyn Optimizer>],
    budget: usize,
    genome: &Genome,
    evaluator: &mut dyn Evaluator,
    observe: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Vec<Course>> {
    let mut courses = vec![Course::default(); searches.len()];
    let mut batch = Batch::new(genome)?;
    loop {
        let counts: Vec<usize> = std::iter::zip(&*searches, &courses)
            .map(|(search, course)| search.ask().len().min(budget - course.evaluations))
            .collect();
        let total = counts.iter().sum();
        if total == 0 {
            return Ok(courses);
        }
        batch.clear();
        for (search, &count) in std::iter::zip(&*searches, &counts) {
            batch.add(&**search, &search.ask()[..count])?;
        }
        let mut scores = batch.evaluate(evaluator)?;
        for ((search, course), count) in searches.iter_mut().zip(&mut courses).zip(counts) {
            let (own, others) = scores.split_at(count);
            scores = others;
            search.ask().iter().zip(own).for_each(|(x, score)| course.add(x, *score));
            // One that was cut short stands at its budget: it is asked no more.
            if count > 0 && count == search.ask().len() {
                search.tell(own);
            }
        }
        if observe(total).is_break() {
            return Err(Error::Interrupted);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::testing::{Hills, genome, height};
    use crate::lighting::Light;
    use crate::optimize::{self, OPTIMIZERS, Settings, Setup};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// One search of each kind.
    fn searches(genome: &Genome, seed: u64) -> Vec<Box<dyn Optimizer>> {
        let (bounds, settings) = (genome.bounds(), &Settings::endless());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let first: Vec<f32> = bounds.iter().map(|range| range.uniform(&mut rng)).collect();
        let setup = Setup { bounds, first, settings, rng };
        let make = |entry: &optimize::Entry| optimize::create(entry.name, setup.clone()).unwrap();
        OPTIMIZERS.iter().map(make).collect()
    }

    fn run(searches: &mut [Box<dyn Optimizer>], budget: usize, hills: &mut Hills) -> Vec<Course> {
        race(searches, budget, &genome(), hills, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn side_by_side_each_search_gets_what_it_gets_alone() {
        let genome = genome();
        let all = || (0..5).flat_map(|seed| searches(&genome, seed)).collect::<Vec<_>>();
        let mut together = Hills::default();
        let courses = run(&mut all(), 1000, &mut together);
        let mut alone = Hills::default();
        for (course, mut search) in courses.iter().zip(all()) {
            assert_eq!(run(std::slice::from_mut(&mut search), 1000, &mut alone)[0], *course);
        }
        assert!(together.calls * 4 < alone.calls, "{} {}", together.calls, alone.calls);
        let scores: Vec<f32> = courses.iter().map(Course::score).collect();
        assert!(scores.iter().any(|&score| score != scores[0]));
    }

    #[test]
    fn every_search_gets_the_same_number_of_evaluations() {
        let genome = genome();
        let mut searches = searches(&genome, 1);
        for (i, course) in run(&mut searches, 777, &mut Hills::default()).iter().enumerate() {
            // A single descent ends by itself.
            assert!(course.evaluations == 777 || i == 3 && course.evaluations < 777);
            assert!(course.improvements.is_sorted_by(|a, b| a.evaluation < b.evaluation));
            assert!(course.improvements.is_sorted_by(|a, b| a.score > b.score));
            let rig: Vec<_> = genome.decode(&course.chromosome).iter().map(Light::record).collect();
            assert_eq!(height(&rig), course.score());
            assert_eq!(course.best_after(0), f32::INFINITY);
            assert_eq!(course.best_after(777), course.score());
            let second = course.improvements[1];
            assert_eq!(course.best_after(second.evaluation), second.score);
            assert_eq!(course.best_after(second.evaluation - 1), course.improvements[0].score);
        }
    }

    #[test]
    fn restarts_never_stop_and_remember_the_best() {
        let genome = genome();
        let mut searches = searches(&genome, 4);
        let restarts = searches.iter().position(|search| search.name() == "restarts").unwrap();
        let restarts = &mut searches[restarts..=restarts];
        let courses = run(restarts, 100_000, &mut Hills::default());
        let ends = restarts[0].minima();
        assert!(ends.len() > 5);
        assert!(ends.iter().any(|end| *end > ends[0] + 0.01 || *end < ends[0] - 0.01));
        assert_eq!(restarts[0].best(), Some((&courses[0].chromosome[..], courses[0].score())));
    }

    #[test]
    fn an_observer_can_break_off() {
        let genome = genome();
        let mut searches = searches(&genome, 0);
        let broken = race(&mut searches, 500, &genome, &mut Hills::default(), &mut |made| {
            assert_eq!(made, 30 + 30 + 10 + 1 + 1 + 30);
            ControlFlow::Break(())
        });
        assert!(matches!(broken, Err(Error::Interrupted)));
    }
}
