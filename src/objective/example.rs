//! What a picture that serves as an example is like.

use super::HISTOGRAM_BINS;
use crate::error::within;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Statistics of an example, which term `example` aims at (Ha and Olivier 2007).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Example {
    /// Share of its pixels in each bin of the brightness (sRGB-encoded luminance); they add up to 1.
    pub histogram: [f32; HISTOGRAM_BINS],
    /// Mean of `|∇I|`, encoded units a pixel of the view's.
    pub gradient: f32,
}

impl Example {
    /// # Errors
    /// [`Error::Argument`] for shares or a gradient that no picture has.
    pub fn check(&self) -> Result<()> {
        let sum: f32 = self.histogram.iter().sum();
        let shares = self.histogram.iter().all(|share| (0.0..=1.0).contains(share));
        if !shares || (sum - 1.0).abs() > 1e-3 {
            let fault = format!(
                "objective.example.histogram adds up to {sum}: its shares must add up to 1"
            );
            return Err(Error::Argument(fault));
        }
        within("objective.example.gradient", self.gradient, 0.0, 1.0)
    }

    /// Share of the pixels up to the end of each bin.
    pub fn cumulative(&self) -> [f32; HISTOGRAM_BINS] {
        let mut sum = 0.0;
        self.histogram.map(|share| {
            sum += share;
            sum
        })
    }
}
