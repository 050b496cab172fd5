//! Searches for lights: chromosomes of an [`Optimizer`] go through the [`Genome`] to an [`Evaluator`], and
//! the scores back. [`run`] takes one search to its end,
//! [`coarse::run_coarse_first`] on small pictures at first, [`race()`] many side by side, and a [`Designer`]
//! goes on a little every frame. A [`Journal`] lets a search go on in another process.

mod batch;
pub mod coarse;
pub mod collage;
mod designer;
pub mod dim;
pub mod dispersion;
pub mod dome;
pub mod focus;
pub mod gallery;
pub mod intent;
mod journal;
pub mod like;
mod one_by_one;
pub mod paint;
pub mod profile;
pub mod race;
pub mod start;
pub mod strokes;
#[cfg(test)]
mod testing;
pub mod views;

use crate::evaluate::Evaluator;
use crate::lighting::Rig;
use crate::lighting::genome::Genome;
use crate::optimize::Optimizer;
use crate::{Error, Result};
use std::ops::ControlFlow;

pub(crate) use batch::Batch;
pub use coarse::CoarseSettings;
pub use designer::Designer;
pub use dim::Dimmed;
pub use dispersion::Dispersion;
pub use dome::Dome;
pub use focus::Focused;
pub use intent::{Intent, Mood};
pub use journal::{Journal, Remembered};
pub use like::Look;
pub use one_by_one::one_by_one;
pub use race::{Course, race};
pub use strokes::Strokes;
pub use views::{Over, Views};

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
    /// The scores are of pictures of every `step`-th pixel along both sides, 1 for whole ones ([`coarse`]): those of one
    /// size are not compared with those of another.
    pub step: u32,
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

/// Runs a search to its end, or until `observe`, called after every generation, breaks it off.
///
/// # Errors
/// [`Error::Argument`] for a search that asks for chromosomes of another length than the genome's or ends
/// without a score, and what the evaluator reports.
pub fn run(
    search: &mut dyn Optimizer,
    genome: &Genome,
    evaluator: &mut dyn Evaluator,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let mut run = Run::new(genome)?;
    let mut stopped = false;
    run.go(search, evaluator, &mut |progress| {
        let flow = observe(progress);
        stopped = flow.is_break();
        flow
    })?;
    run.finish(search, genome, stopped)
}

/// A search on its way.
struct Run {
    batch: Batch,
    /// Of every how manieth pixel the pictures are that it looks at.
    step: u32,
    history: Vec<Progress>,
}

impl Run {
    fn new(genome: &Genome) -> Result<Self> {
        Ok(Self { batch: Batch::new(genome)?, step: 1, history: Vec::new() })
    }

    /// Goes on until the search ends or `observe` breaks off.
    fn go(
        &mut self,
        search: &mut dyn Optimizer,
        evaluator: &mut dyn Evaluator,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        while !search.ask().is_empty() {
            self.batch.fill(search)?;
            let scores = self.batch.evaluate(evaluator)?;
            search.tell(scores);
            let before = self.history.last().map_or(0, |last| last.evaluations);
            let (generation, evaluations) = (self.history.len() + 1, before + scores.len());
            let progress = progress(search, (generation, evaluations), self.step);
            self.history.push(progress);
            if observe(&progress).is_break() {
                break;
            }
        }
        Ok(())
    }

    fn finish(self, search: &dyn Optimizer, genome: &Genome, stopped: bool) -> Result<Outcome> {
        let (chromosome, score) = search.best().ok_or_else(|| without_score(search))?;
        Ok(Outcome { rig: genome.decode(chromosome), score, history: self.history, stopped })
    }
}

fn without_score(search: &dyn Optimizer) -> Error {
    Error::Argument(format!("the search '{}' has ended without a score", search.name()))
}

fn progress(
    search: &dyn Optimizer,
    (generation, evaluations): (usize, usize),
    step: u32,
) -> Progress {
    let scores = search.scores();
    Progress {
        generation,
        evaluations,
        best: search.best().map_or(f32::INFINITY, |(_, score)| score),
        mean: scores.iter().sum::<f32>() / scores.len().max(1) as f32,
        worst: scores.iter().copied().fold(f32::NEG_INFINITY, f32::max),
        step,
    }
}
