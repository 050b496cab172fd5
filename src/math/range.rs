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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use std::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn shares_and_values_of_a_range() {
        let range = Range::new(-1.0, 3.0);
        assert_eq!((range.width(), range.middle(), range.at(0.25)), (4.0, 1.0, 0.0));
        assert_eq!([-2.0, 0.0, 4.0].map(|x| range.share(x)), [0.0, 0.25, 1.0]);
        assert_eq!([-2.0, 0.0, 4.0].map(|x| range.nearest(x)), [-1.0, 0.0, 3.0]);
        assert_eq!([-1.0, 3.0, 3.1].map(|x| range.contains(x)), [true, true, false]);
        assert_eq!(Range::new(2.0, 2.0).share(5.0), 0.0);
        assert_eq!(Range::new(-90.0, 180.0).to_radians(), Range::new(-FRAC_PI_2, PI));
        assert_eq!(<[f32; 2]>::from(Range::from([1.0, 2.0])), [1.0, 2.0]);
    }

    #[test]
    fn ranges_are_finite_and_ascending() {
        assert!(Range::new(1.0, 1.0).is_valid() && Range::new(-1.0, 1.0).is_valid());
        for (low, high) in
            [(1.0, 0.9), (f32::NAN, 1.0), (0.0, f32::INFINITY), (f32::NEG_INFINITY, 0.0)]
        {
            assert!(!Range::new(low, high).is_valid(), "{low} {high}");
        }
    }

    #[test]
    fn steps_are_normal_and_stay_inside() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let range = Range::new(-2.0, 2.0);
        let mut spread = |from: f32, share: f32| {
            let steps: Vec<_> =
                (0..4000).map(|_| range.step(from, share, &mut rng) - from).collect();
            assert!(steps.iter().all(|step| range.contains(from + step)));
            (steps.iter().map(|step| step * step).sum::<f32>() / 4000.0).sqrt()
        };
        assert!((spread(0.0, 0.1) - 0.4).abs() < 0.02);
        // Half of the steps from an end would leave the range: those are drawn again.
        assert!((spread(2.0, 0.1) - 0.4).abs() < 0.02);
        assert_eq!(spread(1.0, 0.0), 0.0);
        let values: Vec<_> = (0..4000).map(|_| range.uniform(&mut rng)).collect();
        assert!(values.iter().sum::<f32>().abs() / 4000.0 < 0.1);
        assert!(values.iter().any(|&x| x < -1.9) && values.iter().any(|&x| x > 1.9));
    }
}
