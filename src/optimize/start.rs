//! The first population.

use crate::Result;
use crate::error::within;
use crate::math::range::Range;
use rand::Rng;
use serde::{Deserialize, Serialize};

/// How the first population spreads around its first individual. The numbers are our reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StartSettings {
    /// Share of the population that scatters around the first individual, 0..=1; the rest is
    /// uniform in the box.
    pub scattered: f32,
    /// Standard deviation of that scatter as a share of each allele's range, 0..=1.
    pub spread: f32,
}

impl Default for StartSettings {
    fn default() -> Self {
        Self { scattered: 0.3333, spread: 0.1 }
    }
}

impl StartSettings {
    /// # Errors
    /// [`crate::Error::Argument`] for a share outside 0..=1.
    pub fn check(&self) -> Result<()> {
        within("start.scattered", self.scattered, 0.0, 1.0)?;
        within("start.spread", self.spread, 0.0, 1.0)
    }
}

/// The first population: `first` itself, some scattered around it, the rest uniform in the box.
pub fn population(
    bounds: &[Range],
    first: Vec<f32>,
    size: usize,
    settings: &StartSettings,
    rng: &mut impl Rng,
) -> Vec<Vec<f32>> {
    let scattered = (size as f32 * settings.scattered).round() as usize;
    let mut population = vec![first];
    while population.len() < size {
        let near = population.len() <= scattered;
        let individual =
            std::iter::zip(bounds, &population[0])
                .map(|(range, &center)| {
                    if near { range.step(center, settings.spread, rng) } else { range.uniform(rng) }
                })
                .collect();
        population.push(individual);
    }
    population
}
