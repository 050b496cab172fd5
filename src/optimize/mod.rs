//! The seam between searches and evaluators: a search asks for the scores of some chromosomes and is
//! told them. Searches know the box of each allele and nothing of lights, scenes or devices.

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
        let population = Population::new(genome.rig_lights())?;
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
