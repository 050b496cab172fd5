//! The paper's experiments, on any scene: the quality over one light's positions, searches from
//! several starts, and searches against each other. All runs of a study are evaluated side by side.

pub mod ablation;
pub mod contest;
pub mod landscape;
pub mod starts;
pub mod statistics;
pub mod sweep;

use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::lighting::start::{self, StartSettings};
use crate::optimize::{DescentSettings, Genetic, GeneticSettings, Optimizer, Random, Restarts};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
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

/// How the searches of a study are set.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SearchSettings {
    /// The first population.
    pub start: StartSettings,
    /// The genetic algorithm; its evaluations are the budget of every search.
    pub genetic: GeneticSettings,
    /// The greedy descent.
    pub descent: DescentSettings,
}

impl SearchSettings {
    /// Evaluations of the genetic algorithm's first generation, and of each later one.
    pub fn generation_sizes(&self) -> (usize, usize) {
        let population = self.genetic.population;
        (population, population - self.genetic.elites())
    }

    /// Evaluations of a whole genetic search.
    pub fn budget(&self) -> usize {
        let (first, later) = self.generation_sizes();
        later.saturating_mul(self.genetic.generations - 1).saturating_add(first)
    }
}

/// Seeds of `runs` runs: consecutive numbers from `seed` on.
///
/// # Errors
/// [`Error::Argument`] unless `runs` is 1 to [`MAX_RUNS`].
pub fn seeds(seed: u64, runs: usize) -> Result<Vec<u64>> {
    if !(1..=MAX_RUNS).contains(&runs) {
        return Err(Error::Argument(format!("{runs} runs: a study has 1 to {MAX_RUNS} of them")));
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
    fn genetic(mut self, genome: &Genome, settings: &SearchSettings) -> Result<Genetic> {
        let bounds = genome.bounds();
        // The budget alone ends a study's search.
        let genetic = GeneticSettings { generations: usize::MAX, patience: 0, ..settings.genetic };
        let (first, size) = (self.first, genetic.population);
        let population = start::population(bounds, first, size, &settings.start, &mut self.rng);
        Genetic::new(bounds, population, genetic, self.rng)
    }

    fn search(self, method: Method, genome: &Genome, settings: &SearchSettings) -> Result<Search> {
        let (bounds, size) = (genome.bounds(), settings.genetic.population);
        Ok(match method {
            Method::Genetic => Search::Genetic(self.genetic(genome, settings)?),
            Method::Greedy => {
                let search = Restarts::new(bounds, self.first, settings.descent, self.rng)?;
                Search::Greedy(search)
            }
            Method::Random => Search::Random(Random::new(bounds, size, self.rng)),
        })
    }
}

/// A search of any kind.
enum Search {
    Genetic(Genetic),
    Greedy(Restarts),
    Random(Random),
}

impl Search {
    fn optimizer(&mut self) -> &mut dyn Optimizer {
        match self {
            Self::Genetic(search) => search,
            Self::Greedy(search) => search,
            Self::Random(search) => search,
        }
    }

    /// Where the descents of a greedy search ended.
    fn ends(&self) -> Vec<f32> {
        match self {
            Self::Greedy(search) => search.ends().collect(),
            Self::Genetic(_) | Self::Random(_) => Vec::new(),
        }
    }
}

/// How a study searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The genetic algorithm.
    Genetic,
    /// Greedy descents, the first from the clusters' individual, then from random ones.
    Greedy,
    /// Uniform random search.
    Random,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Genetic, Self::Greedy, Self::Random];

    /// The method's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Genetic => "genetic algorithm",
            Self::Greedy => "greedy with restarts",
            Self::Random => "random search",
        }
    }
}
