//! Uniform random search: what every other search has to beat.

use super::{Best, Entry, Optimizer, Setup};
use crate::math::range::Range;
use rand_chacha::ChaCha8Rng;

/// Its name in settings.
pub const NAME: &str = "random";

pub(super) const ENTRY: Entry = Entry {
    name: NAME,
    title: "random search",
    description: "Uniform random search",
    new: |Setup { bounds, settings, rng, .. }| {
        let genetic = &settings.genetic;
        Ok(Box::new(Random::new(bounds, genetic.population, genetic.generations, rng)))
    },
    generations: |settings| Some(settings.genetic.generations),
    words: |settings| format!("random search, {} at a time", settings.genetic.population),
};

/// Asks for uniform chromosomes.
#[derive(Debug, Clone)]
pub struct Random {
    bounds: Vec<Range>,
    size: usize,
    generations: usize,
    rng: ChaCha8Rng,
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
    best: Best,
    /// Generations so far.
    generation: usize,
}

impl Random {
    /// A search that asks for `size` chromosomes at a time, `generations` times; [`usize::MAX`] is for
    /// ever.
    pub fn new(bounds: &[Range], size: usize, generations: usize, rng: ChaCha8Rng) -> Self {
        let (bounds, asked, scores) = (bounds.to_vec(), Vec::new(), Vec::new());
        let (best, generation) = (Best::default(), 0);
        let mut search = Self { bounds, size, generations, rng, asked, scores, best, generation };
        search.draw();
        search
    }

    fn draw(&mut self) {
        let Self { bounds, size, rng, .. } = self;
        let mut chromosome = || bounds.iter().map(|range| range.uniform(rng)).collect();
        self.asked = (0..*size).map(|_| chromosome()).collect();
    }
}

impl Optimizer for Random {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        if self.generation < self.generations { &self.asked } else { &[] }
    }

    fn tell(&mut self, scores: &[f32]) {
        self.scores = scores.to_vec();
        self.best.offer_all(&self.asked, scores);
        self.generation += 1;
        self.draw();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    /// Asks for the best so far among others.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        if let (Some((best, _)), Some(first)) = (self.best.get(), self.asked.first_mut()) {
            *first = change(best);
        }
        self.scores.clear();
        (self.best, self.generation) = (Best::default(), 0);
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }
}
