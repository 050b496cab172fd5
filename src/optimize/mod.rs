//! The seam between searches and evaluators: a search asks for the scores of some chromosomes and is
//! told them. Searches know the box of each allele and nothing of lights, scenes or devices.

pub mod best;
pub mod descent;
pub mod designer;
pub mod genetic;
pub mod race;
pub mod random;
pub mod restarts;
#[cfg(test)]
mod testing;

use crate::Result;
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::lighting::{Population, Rig};
use std::ops::ControlFlow;

pub use best::Best;
pub use descent::{Descent, DescentSettings};
pub use designer::Designer;
pub use genetic::{Genetic, GeneticSettings, MAX_POPULATION};
pub use race::{Course, race};
pub use random::Random;
pub use restarts::Restarts;

/// A search for the chromosome with the lowest score.
pub trait Optimizer {
    /// The chromosomes whose scores it wants next; none when it has finished.
    fn ask(&self) -> &[Vec<f32>];

    /// Takes the scores of what was asked for, in order.
    fn tell(&mut self, scores: &[f32]);

    /// The best chromosome so far and its score; `None` before the first scores.
    fn best(&self) -> Option<(&[f32], f32)>;

    /// Scores of all that the search holds at present.
    fn scores(&self) -> &[f32];
}

/// How a search stands after a generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Number of the generation; the first population is 1.
    pub generation: usize,
    /// Evaluations so far.
    pub evaluations: usize,
    /// Lowest score so far.
    pub best: f32,
    /// Mean score of the population.
    pub mean: f32,
    /// Highest score of the population.
    pub worst: f32,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The best rig.
    pub rig: Rig,
    /// Its `F`.
    pub score: f32,
    /// One entry for each generation.
    pub history: Vec<Progress>,
    /// Whether the observer ended it.
    pub stopped: bool,
}

impl Outcome {
    /// Evaluations in all.
    pub fn evaluations(&self) -> usize {
        self.history.last().map_or(0, |last| last.evaluations)
    }
}

/// Chromosomes on their way to an evaluator, and their scores.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    genome: Genome,
    population: Population,
    scores: Vec<f32>,
}

impl Batch {
    pub fn new(genome: &Genome) -> Result<Self> {
        let population = Population::new(genome.lights())?;
        Ok(Self { genome: genome.clone(), population, scores: Vec::new() })
    }

    /// Takes other chromosomes.
    pub fn fill<'c>(&mut self, chromosomes: impl IntoIterator<Item = &'c Vec<f32>>) {
        self.population.clear();
        for chromosome in chromosomes {
            let rig = self.genome.decode(chromosome);
            self.population.push(&rig).expect("all rigs of a genome have its number of lights");
        }
    }

    /// The scores of the chromosomes, evaluated as one population.
    pub fn evaluate(&mut self, evaluator: &mut dyn Evaluator) -> Result<&[f32]> {
        self.scores.resize(self.population.len(), 0.0);
        evaluator.evaluate(&self.population, &mut self.scores)?;
        Ok(&self.scores)
    }
}

/// Runs a search to its end, or until `observe`, called after every generation, breaks it off.
///
/// # Errors
/// What the evaluator reports.
///
/// # Panics
/// If the search asks for nothing at all.
pub fn run(
    search: &mut dyn Optimizer,
    genome: &Genome,
    evaluator: &mut dyn Evaluator,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let mut batch = Batch::new(genome)?;
    let mut history: Vec<Progress> = Vec::new();
    let mut stopped = false;
    while !stopped && !search.ask().is_empty() {
        batch.fill(search.ask());
        let scores = batch.evaluate(evaluator)?;
        search.tell(scores);
        let before = history.last().map_or(0, |last| last.evaluations);
        let progress = progress(search, history.len() + 1, before + scores.len());
        stopped = observe(&progress).is_break();
        history.push(progress);
    }
    let (chromosome, score) = search.best().expect("a search asks for something before it ends");
    Ok(Outcome { rig: genome.decode(chromosome), score, history, stopped })
}

fn progress(search: &dyn Optimizer, generation: usize, evaluations: usize) -> Progress {
    let scores = search.scores();
    Progress {
        generation,
        evaluations,
        best: search.best().map_or(f32::INFINITY, |(_, score)| score),
        mean: scores.iter().sum::<f32>() / scores.len() as f32,
        worst: scores.iter().copied().fold(f32::NEG_INFINITY, f32::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::start::{self, StartSettings};
    use crate::math::range::Range;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const BOUNDS: [Range; 3] = [Range::new(-1.0, 1.0); 3];

    /// One search of each kind; genetic ones with and without elites.
    fn searches(seed: u64) -> Vec<Box<dyn Optimizer>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let first: Vec<f32> = BOUNDS.iter().map(|range| range.uniform(&mut rng)).collect();
        let mut start = |size| {
            start::population(&BOUNDS, first.clone(), size, &StartSettings::default(), &mut rng)
        };
        let (many, few, starts) = (start(12), start(4), start(3));
        let genetic = |start: &[Vec<f32>], elitism| {
            let population = start.len();
            let settings = GeneticSettings { population, elitism, ..GeneticSettings::endless() };
            Box::new(Genetic::new(&BOUNDS, start.to_vec(), settings, rng.clone()).unwrap())
        };
        let descent = DescentSettings::default();
        vec![
            genetic(&many, 0.1),
            genetic(&many, 0.0),
            genetic(&few, 0.1),
            Box::new(Descent::new(&BOUNDS, &starts, descent).unwrap()),
            Box::new(Restarts::new(&BOUNDS, first, descent, rng.clone()).unwrap()),
            Box::new(Random::new(&BOUNDS, 5, rng)),
        ]
    }

    /// Ripples, so that most children are worse than their parents and probes find lower places.
    fn height(x: &[f32]) -> f32 {
        x.iter().map(|x| x * x + (30.0 * x).sin()).sum()
    }

    #[test]
    fn the_best_is_the_best_so_far() {
        for seed in 0..10 {
            for (number, mut search) in searches(seed).into_iter().enumerate() {
                let mut best: Option<(Vec<f32>, f32)> = None;
                for round in 0..60 {
                    let before = search.best().map(|(x, score)| (x.to_vec(), score));
                    assert_eq!(before, best, "search {number}, seed {seed}, round {round}");
                    let told: Vec<f32> = search.ask().iter().map(|x| height(x)).collect();
                    for (x, &score) in search.ask().iter().zip(&told) {
                        if best.as_ref().is_none_or(|(_, best)| score < *best) {
                            best = Some((x.clone(), score));
                        }
                    }
                    search.tell(&told);
                }
            }
        }
    }

    #[test]
    fn what_is_not_a_number_is_never_the_best() {
        for nan in [f32::NAN, -f32::NAN] {
            for (number, mut search) in searches(1).into_iter().enumerate() {
                let mut scores = vec![nan; search.ask().len()];
                search.tell(&scores);
                assert_eq!(search.best(), None, "search {number}");
                scores.resize(search.ask().len(), nan);
                if let Some(last) = scores.last_mut() {
                    *last = 0.9;
                    search.tell(&scores);
                    assert_eq!(search.best().unwrap().1, 0.9, "search {number}");
                }
            }
        }
    }
}
