//! Greedy descents one after another: the first from a given start, each later one from a uniform
//! random one, so that the greedy search can use as many evaluations as another search.

use super::{Best, Descent, DescentSettings, Entry, Optimizer, Setup};
use crate::Result;
use crate::math::range::Range;
use rand_chacha::ChaCha8Rng;

/// Its name in settings.
pub const NAME: &str = "restarts";

pub(super) const ENTRY: Entry = Entry {
    name: NAME,
    title: "greedy with restarts",
    description: "Greedy descents one after another, from random starts",
    new: |Setup { bounds, first, settings, rng }| {
        let (descent, budget) = (settings.greedy.descent(), settings.genetic.budget());
        Ok(Box::new(Restarts::new(bounds, first, descent, budget, rng)?))
    },
    generations: |_| None,
    words: |settings| {
        format!("greedy descents with restarts, {} evaluations", settings.genetic.budget())
    },
};

/// Descends until it has used its budget.
#[derive(Debug, Clone)]
pub struct Restarts {
    settings: DescentSettings,
    bounds: Vec<Range>,
    budget: usize,
    rng: ChaCha8Rng,
    descent: Descent,
    /// Evaluations so far.
    evaluations: usize,
    /// The scores at which the descents before ended, in order.
    ends: Vec<f32>,
    best: Best,
}

impl Restarts {
    /// A search that descends from `first` and then from random starts. It ends with the generation in
    /// which it has made `budget` evaluations; [`usize::MAX`] is for ever.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a setting out of its range.
    pub fn new(
        bounds: &[Range],
        first: Vec<f32>,
        settings: DescentSettings,
        budget: usize,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let descent = Descent::new(bounds, &[first], settings)?;
        let (bounds, ends, best) = (bounds.to_vec(), Vec::new(), Best::default());
        Ok(Self { settings, bounds, budget, rng, descent, evaluations: 0, ends, best })
    }
}

impl Optimizer for Restarts {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        if self.evaluations < self.budget { self.descent.ask() } else { &[] }
    }

    fn tell(&mut self, scores: &[f32]) {
        self.best.offer_all(self.descent.ask(), scores);
        self.evaluations += scores.len();
        self.descent.tell(scores);
        if self.descent.ask().is_empty() {
            self.ends.extend(self.descent.positions().map(|(_, score)| score));
            let start = self.bounds.iter().map(|range| range.uniform(&mut self.rng)).collect();
            self.descent = Descent::begin(self.bounds.clone(), vec![start], self.settings);
        }
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        self.descent.scores()
    }

    /// Begins anew with a descent from the best so far, or from the first start where there is none.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        let best = self.best.get().map(|(best, _)| change(best));
        match best {
            Some(start) => {
                self.descent = Descent::begin(self.bounds.clone(), vec![start], self.settings);
            }
            None => self.descent.renew(change),
        }
        (self.evaluations, self.ends, self.best) = (0, Vec::new(), Best::default());
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }

    fn minima(&self) -> &[f32] {
        &self.ends
    }
}
