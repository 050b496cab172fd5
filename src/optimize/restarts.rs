//! Greedy descents one after another: the first from a given start, each later one from a uniform
//! random one, so that the greedy search can use as many evaluations as another search.

use super::{Best, Descent, DescentSettings, Optimizer};
use crate::Result;
use crate::math::range::Range;
use rand_chacha::ChaCha8Rng;

/// Descends without end.
#[derive(Debug, Clone)]
pub struct Restarts {
    settings: DescentSettings,
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    descent: Descent,
    /// The scores at which the descents before ended, in order.
    ends: Vec<f32>,
    best: Best,
}

impl Restarts {
    /// A search that descends from `first` and then from random starts.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a setting out of its range.
    pub fn new(
        bounds: &[Range],
        first: Vec<f32>,
        settings: DescentSettings,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let descent = Descent::new(bounds, &[first], settings)?;
        let (bounds, ends, best) = (bounds.to_vec(), Vec::new(), Best::default());
        Ok(Self { settings, bounds, rng, descent, ends, best })
    }

    /// The scores at which the descents ended that came to their end, in order.
    pub fn ends(&self) -> impl Iterator<Item = f32> {
        self.ends.iter().copied()
    }
}

impl Optimizer for Restarts {
    fn ask(&self) -> &[Vec<f32>] {
        self.descent.ask()
    }

    fn tell(&mut self, scores: &[f32]) {
        for (chromosome, &score) in self.descent.ask().iter().zip(scores) {
            self.best.offer(chromosome, score);
        }
        self.descent.tell(scores);
        if self.descent.ask().is_empty() {
            self.ends.extend(self.descent.positions().map(|(_, score)| score));
            let start = self.bounds.iter().map(|range| range.uniform(&mut self.rng)).collect();
            self.descent = Descent::new(&self.bounds, &[start], self.settings)
                .expect("the settings were checked for the first descent");
        }
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        self.descent.scores()
    }
}
