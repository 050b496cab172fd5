//! Greedy descents one after another: the first from a given start, each later one from a uniform
//! random one, so that the greedy search can use as many evaluations as another search.

use super::{Descent, DescentSettings, Optimizer};
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
    /// Where the descents before ended, in order.
    ends: Vec<(Vec<f32>, f32)>,
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
        Ok(Self { settings, bounds: bounds.to_vec(), rng, descent, ends: Vec::new() })
    }

    /// The scores at which the descents ended that came to their end, in order.
    pub fn ends(&self) -> impl Iterator<Item = f32> {
        self.ends.iter().map(|(_, score)| *score)
    }
}

impl Optimizer for Restarts {
    fn ask(&self) -> &[Vec<f32>] {
        self.descent.ask()
    }

    fn tell(&mut self, scores: &[f32]) {
        self.descent.tell(scores);
        if self.descent.ask().is_empty() {
            let end = self.descent.best().map(|(chromosome, score)| (chromosome.to_vec(), score));
            self.ends.extend(end);
            let start = self.bounds.iter().map(|range| range.uniform(&mut self.rng)).collect();
            self.descent = Descent::new(&self.bounds, &[start], self.settings)
                .expect("the settings were checked for the first descent");
        }
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        let ends = self.ends.iter().map(|(chromosome, score)| (chromosome.as_slice(), *score));
        ends.chain(self.descent.best()).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn scores(&self) -> &[f32] {
        self.descent.scores()
    }
}
