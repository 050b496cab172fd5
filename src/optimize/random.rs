//! Uniform random search: what every other search has to beat.

use super::{Best, Optimizer};
use crate::math::range::Range;
use rand_chacha::ChaCha8Rng;

/// Asks for uniform chromosomes without end.
#[derive(Debug, Clone)]
pub struct Random {
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
    best: Best,
}

impl Random {
    /// A search that asks for `size` chromosomes at a time.
    pub fn new(bounds: &[Range], size: usize, rng: ChaCha8Rng) -> Self {
        let asked = vec![Vec::new(); size];
        let mut search =
            Self { bounds: bounds.to_vec(), rng, asked, scores: Vec::new(), best: Best::default() };
        search.draw();
        search
    }

    fn draw(&mut self) {
        for chromosome in &mut self.asked {
            *chromosome = self.bounds.iter().map(|range| range.uniform(&mut self.rng)).collect();
        }
    }
}

impl Optimizer for Random {
    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        self.scores = scores.to_vec();
        for (chromosome, &score) in self.asked.iter().zip(scores) {
            self.best.offer(chromosome, score);
        }
        self.draw();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }
}
