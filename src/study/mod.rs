//! The paper's experiments, on any scene: the quality over one light's positions, searches from
//! several starts, and searches against each other. All runs of a study are evaluated side by side.

pub mod ablation;
pub mod contest;
pub mod gaps;
pub mod landscape;
pub mod starts;
pub mod statistics;
pub mod sweep;

use crate::design::start;
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::optimize::{self, GeneticSettings, Optimizer, Settings, Setup};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

/// Most runs of a study, each with a seed of its own.
pub const MAX_RUNS: usize = 1000;

/// Called with the number of evaluations made since the last call; it can break the study off, which
/// then ends with [`Error::Interrupted`].
pub type Observe<'a> = dyn FnMut(usize) -> ControlFlow<()> + 'a;

/// What is studied: a view of a scene, and what measures it.
pub struct Subject<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view.
    pub view: &'a View,
    /// Measures the view.
    pub evaluator: &'a mut dyn Evaluator,
}

/// Seeds of `runs` runs: consecutive numbers from `seed` on.
///
/// # Errors
/// [`Error::Argument`] unless `runs` is 1 to [`MAX_RUNS`].
pub fn seeds(seed: u64, runs: usize) -> Result<Vec<u64>> {
    if !(1..=MAX_RUNS).contains(&runs) {
        return Err(Error::Argument(format!("runs is {runs}: it must be 1 to {MAX_RUNS}")));
    }
    Ok((0..runs as u64).map(|run| seed.wrapping_add(run)).collect())
}

/// A search's beginning: the clusters' individual of a seed, and the random numbers that follow.
/// Searches of one seed begin alike, whatever their kind.
#[derive(Debug, Clone)]
struct Beginning {
    first: Vec<f32>,
    rng: ChaCha8Rng,
}

impl Subject<'_> {
    fn beginnings(&mut self, genome: &Genome, seeds: &[u64]) -> Result<Vec<Beginning>> {
        let maps = self.evaluator.maps()?;
        let begin = |&seed: &u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let first = start::first(self.scene, self.view, maps, genome, &mut rng);
            Beginning { first, rng }
        };
        Ok(seeds.iter().map(begin).collect())
    }
}

impl Beginning {
    /// The search of a name; a study's budget alone ends it.
    fn search(
        self,
        optimizer: &str,
        genome: &Genome,
        settings: &Settings,
    ) -> Result<Box<dyn Optimizer>> {
        let genetic = GeneticSettings { generations: usize::MAX, patience: 0, ..settings.genetic };
        let settings = &Settings { genetic, ..*settings };
        let Self { first, rng } = self;
        optimize::create(optimizer, Setup { bounds: genome.bounds(), first, settings, rng })
    }
}
