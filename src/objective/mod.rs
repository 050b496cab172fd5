//! The picture-quality function of Ha and Olivier (2006), after Shacked and Lischinski (2001):
//! `F = Σ w·F_term`, lower is better. The paper names the five terms but prints no formula, weight
//! or threshold: what stands here is our reconstruction, `docs/METHOD.md`.

pub mod maps;

use crate::constants;
use crate::error::within;
use crate::{Error, Result};
use maps::Maps;
use serde::{Deserialize, Serialize};

pub use crate::constants::FLAT_NORMALS;

/// Bins of the brightness histogram.
pub const HISTOGRAM_BINS: usize = constants::HISTOGRAM_BINS as usize;

/// One number for each of the five terms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terms {
    /// `F_edge`, edge distinctness.
    pub edge: f32,
    /// `F_mean`, mean brightness.
    pub mean: f32,
    /// `F_grad`, mean shading gradient.
    pub grad: f32,
    /// `F_var`, intensity range.
    pub var: f32,
    /// `F_hist`, evenness of the histogram.
    pub hist: f32,
}

impl Terms {
    /// Names, in the order of [`Terms::to_array`].
    pub const NAMES: [&str; 5] = ["edge", "mean", "grad", "var", "hist"];

    /// The five numbers in order.
    pub fn to_array(self) -> [f32; 5] {
        [self.edge, self.mean, self.grad, self.var, self.hist]
    }
}

/// A picture's quality.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quality {
    /// `F`.
    pub score: f32,
    /// The five terms.
    pub terms: Terms,
}

/// Settings of the quality function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Objective {
    /// Weight of each term.
    pub weights: Terms,
    /// Mean brightness aimed at, sRGB-encoded, 0..=1.
    pub mean_target: f32,
    /// Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel.
    pub edge_contrast: f32,
    /// Sobel length of the depth above which a pixel can be an edge, scene radii a pixel.
    pub edge_sobel: f32,
    /// Absolute Laplacian of the depth above which a pixel can be an edge, scene radii.
    pub edge_laplace: f32,
}

impl Default for Objective {
    fn default() -> Self {
        Self {
            weights: Terms { edge: 0.2, mean: 0.2, grad: 0.2, var: 0.2, hist: 0.2 },
            mean_target: 0.5,
            edge_contrast: 0.06,
            edge_sobel: 0.02,
            edge_laplace: 0.02,
        }
    }
}

/// What the reductions measure in one picture `I` (sRGB-encoded luminance, 0..=1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Mean over EDGE of `min(1, |∇I| / edge_contrast)`; 0 without EDGE pixels.
    pub edge_contrast: f32,
    /// Mean of `I` over the object.
    pub mean: f32,
    /// Variance of `I` over the object.
    pub variance: f32,
    /// `G`, mean of `|∇I|` over SURFACE; 0 without SURFACE pixels.
    pub gradient: f32,
    /// Object pixels in each bin.
    pub histogram: [u32; HISTOGRAM_BINS],
}

impl Objective {
    /// # Errors
    /// [`Error::Argument`] that names the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        let weights = self.weights.to_array();
        for (name, weight) in Terms::NAMES.iter().zip(weights) {
            within(&format!("weight {name}"), weight, 0.0, f32::MAX)?;
        }
        if weights.iter().all(|&weight| weight == 0.0) {
            return Err(Error::Argument("all weights are 0: nothing to search for".into()));
        }
        // Terms are at most 1, so that their sum is finite too.
        within("the sum of the weights", weights.iter().sum(), 0.0, f32::MAX)?;
        within("objective.mean_target", self.mean_target, 0.0, 1.0)?;
        within("objective.edge_contrast", self.edge_contrast, f32::MIN_POSITIVE, f32::MAX)?;
        within("objective.edge_sobel", self.edge_sobel, 0.0, f32::MAX)?;
        within("objective.edge_laplace", self.edge_laplace, 0.0, f32::MAX)
    }

    /// The five terms of a picture of the view that `maps` describes.
    pub fn terms(&self, picture: &Statistics, maps: &Maps) -> Terms {
        let counts = maps.counts;
        let target = self.mean_target;
        let edge = if counts.edge == 0 { 0.0 } else { 1.0 - picture.edge_contrast };
        let grad = if maps.normal_detail < FLAT_NORMALS {
            0.0
        } else {
            1.0 - (picture.gradient / maps.normal_detail).min(1.0)
        };
        Terms {
            edge,
            mean: (picture.mean - target).abs() / target.max(1.0 - target),
            grad,
            var: 1.0 - (picture.variance.max(0.0).sqrt() * 12f32.sqrt()).min(1.0),
            hist: 1.0 - entropy(&picture.histogram) / (HISTOGRAM_BINS as f32).ln(),
        }
    }

    /// The quality of a picture of the view that `maps` describes.
    pub fn quality(&self, picture: &Statistics, maps: &Maps) -> Quality {
        let terms = self.terms(picture, maps);
        Quality { score: self.score(&terms), terms }
    }

    /// `F`, the weighted sum of the terms.
    pub fn score(&self, terms: &Terms) -> f32 {
        let weights = self.weights.to_array();
        weights.iter().zip(terms.to_array()).map(|(w, t)| w * t).sum()
    }
}

/// Entropy of a histogram, nats.
fn entropy(histogram: &[u32]) -> f32 {
    let total: u32 = histogram.iter().sum();
    let share = |&count: &u32| count as f32 / total as f32;
    -histogram.iter().filter(|&&count| count > 0).map(share).map(|p| p * p.ln()).sum::<f32>()
}
