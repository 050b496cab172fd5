//! The values that a number may have.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};

/// The lowest and the highest value that an allele may have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f32; 2]", into = "[f32; 2]")]
pub struct Range {
    /// Lowest value.
    pub low: f32,
    /// Highest value.
    pub high: f32,
}

impl Range {
    /// From `low` to `high`.
    pub const fn new(low: f32, high: f32) -> Self {
        Self { low, high }
    }

    /// `high − low`.
    pub fn width(&self) -> f32 {
        self.high - self.low
    }

    /// The middle.
    pub fn middle(&self) -> f32 {
        self.at(0.5)
    }

    /// Whether `x` is inside, ends included.
    pub fn contains(&self, x: f32) -> bool {
        (self.low..=self.high).contains(&x)
    }

    /// The nearest value inside.
    pub fn nearest(&self, x: f32) -> f32 {
        x.clamp(self.low, self.high)
    }

    /// How far along the range `x` is, 0..=1; 0 in a range without width.
    pub fn share(&self, x: f32) -> f32 {
        if self.width() > 0.0 { ((x - self.low) / self.width()).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The value that is `share` (0..=1) along the range.
    pub fn at(&self, share: f32) -> f32 {
        self.nearest(self.low + share * self.width())
    }

    /// A uniform value.
    pub fn uniform(&self, rng: &mut impl Rng) -> f32 {
        self.at(rng.random())
    }

    /// `from`, which is inside, moved by a normal step with a standard deviation of `share` (0..=1)
    /// of the width. What leaves the range is drawn again, never clamped.
    pub fn step(&self, from: f32, share: f32, rng: &mut impl Rng) -> f32 {
        let Ok(normal) = Normal::new(from, share * self.width()) else { return from };
        loop {
            let value = normal.sample(rng);
            if self.contains(value) {
                return value;
            }
        }
    }

    /// From degrees to radians.
    pub(crate) fn to_radians(self) -> Self {
        Self::new(self.low.to_radians(), self.high.to_radians())
    }

    pub(crate) fn is_valid(&self) -> bool {
        self.low.is_finite() && self.high.is_finite() && self.low <= self.high
    }
}

impl From<[f32; 2]> for Range {
    fn from([low, high]: [f32; 2]) -> Self {
        Self { low, high }
    }
}

impl From<Range> for [f32; 2] {
    fn from(range: Range) -> Self {
        [range.low, range.high]
    }
}
