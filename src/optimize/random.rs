//! Uniform random search: what every other search has to beat.

use super::Optimizer;
use crate::math::range::Range;
use rand_chacha::ChaCha8Rng;

/// Asks for uniform chromosomes without end.
#[derive(Debug, Clone)]
pub struct Random {
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
    best: Option<(Vec<f32>, f32)>,
}

impl Random {
    /// A search that asks for `size` chromosomes at a time.
    pub fn new(bounds: &[Range], size: usize, rng: ChaCha8Rng) -> Self {
        let asked = vec![Vec::new(); size];
        let mut search =
            Self { bounds: bounds.to_vec(), rng, asked, scores: Vec::new(), best: None };
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
        let told = self.asked.iter().zip(scores);
        if let Some((chromosome, &score)) = told.min_by(|a, b| a.1.total_cmp(b.1))
            && self.best.as_ref().is_none_or(|(_, best)| score < *best)
        {
            self.best = Some((chromosome.clone(), score));
        }
        self.draw();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.as_ref().map(|(chromosome, score)| (chromosome.as_slice(), *score))
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }
}
