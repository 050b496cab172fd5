//! What pictures are judged by: `F = Σ w·F_term` over any list of [`terms`], lower is better. A picture is
//! measured once ([`Statistics`]), and each term is a formula of what was measured ([`Term`]).
//!
//! The default is the picture-quality function of Ha and Olivier (2006), after Shacked and Lischinski
//! (2001). The paper names its five terms but prints no formula, weight or threshold: what stands here is our
//! reconstruction, `docs/METHOD.md`.

mod example;
pub mod maps;
mod mean_target;
pub mod shadows;
mod statistics;
mod term;
pub mod terms;

use crate::constants::{self, MEAN_LEAST, MEAN_MOST};
use crate::error::within;
use crate::math::color::{srgb_decode, srgb_encode};
use crate::{Error, Result};
use maps::ViewStatistics;
use serde::{Deserialize, Serialize};

pub use example::Example;
pub use mean_target::MeanTarget;
pub use statistics::{
    BURNT, CURVATURE_LEVELS, DETAIL_LEAST, DETAIL_MOST, DETAIL_SHARE, Irradiance, OUTLINE_ENOUGH,
    Statistics, UNLIT, curvature_level, entropy,
};
pub use term::{MAX_TERMS, Needs, Term, Terms};

/// Bins of the brightness histogram.
pub const HISTOGRAM_BINS: usize = constants::HISTOGRAM_BINS as usize;

/// A picture's quality.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quality {
    /// `F`.
    pub score: f32,
    /// The objective's terms.
    pub terms: Terms,
}

/// Settings of the quality function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Objective {
    /// Weight of each term.
    pub weights: Terms,
    /// Mean brightness aimed at.
    pub mean_target: MeanTarget,
    /// Photographic stops by which that is moved, −4..=4: one doubles its light, and what is aimed at stays in
    /// 0.1..=0.9.
    pub mean_stops: f32,
    /// Standard deviation of the brightness that term `spread` aims at, sRGB-encoded, 0..=0.5.
    pub spread_target: f32,
    /// Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel.
    pub edge_contrast: f32,
    /// Sobel length of the depth above which a pixel can be an edge, scene radii a pixel.
    pub edge_sobel: f32,
    /// Absolute Laplacian of the depth above which a pixel can be an edge, scene radii.
    pub edge_laplace: f32,
    /// The example that term `example` aims at; without it the weights of terms that need one count as 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub example: Option<Example>,
    /// Luminance behind the objects, sRGB-encoded, 0..=1. Without it the weights of terms that need it count
    /// as 0. Files say it as the background of final pictures.
    #[serde(skip)]
    pub background: Option<f32>,
}

impl Default for Objective {
    fn default() -> Self {
        Self {
            weights: paper_weights(),
            mean_target: MeanTarget::Value(0.5),
            mean_stops: 0.0,
            spread_target: 0.2,
            edge_contrast: 0.06,
            edge_sobel: 0.02,
            edge_laplace: 0.02,
            example: None,
            background: None,
        }
    }
}

impl Objective {
    /// # Errors
    /// [`Error::Argument`] that names the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        for (term, weight) in self.weights.iter() {
            within(&format!("weight {}", term.name), weight, 0.0, f32::MAX)?;
        }
        let counts = |(term, weight): (&Term, f32)| weight > 0.0 && self.can_measure(term);
        if !self.weights.iter().any(counts) {
            let fault = if self.weights.values().any(|weight| weight > 0.0) {
                "all weights are 0 but those of terms that need a background or an example, and none is given"
            } else {
                "all weights are 0: nothing to search for"
            };
            return Err(Error::Argument(fault.into()));
        }
        // Terms are at most 1, so that their sum is finite too.
        within("the sum of the weights", self.weights.values().sum(), 0.0, f32::MAX)?;
        self.mean_target.check()?;
        within("objective.mean_stops", self.mean_stops, -4.0, 4.0)?;
        within("objective.spread_target", self.spread_target, 0.0, 0.5)?;
        within("objective.edge_contrast", self.edge_contrast, f32::MIN_POSITIVE, f32::MAX)?;
        within("objective.edge_sobel", self.edge_sobel, 0.0, f32::MAX)?;
        within("objective.edge_laplace", self.edge_laplace, 0.0, f32::MAX)?;
        self.example.map_or(Ok(()), |example| example.check())?;
        self.background.map_or(Ok(()), |b| within("objective.background", b, 0.0, 1.0))
    }

    /// # Errors
    /// [`Error::Argument`] where a term of a weight above 0 compares with a target picture, of which the
    /// caller has none.
    pub fn check_without_target(&self) -> Result<()> {
        if !self.needs().target {
            return Ok(());
        }
        let fault = "term target needs a target picture, which only Rust programs can give: \
                     Maps::set_target";
        Err(Error::Argument(fault.into()))
    }

    /// Whether all terms are klieg's own, so that devices know their formulas.
    pub fn is_own(&self) -> bool {
        self.weights.iter().all(|(term, _)| terms::TERMS.iter().any(|&own| std::ptr::eq(own, term)))
    }

    /// Whether the background and the example that a term needs are given.
    pub(crate) fn can_measure(&self, term: &Term) -> bool {
        (!term.needs.background || self.background.is_some())
            && (!term.needs.example || self.example.is_some())
    }

    /// The mean brightness aimed at in a view, sRGB-encoded: [`MeanTarget::of`], moved by
    /// [`Objective::mean_stops`].
    pub fn mean_of(&self, view: &ViewStatistics) -> f32 {
        let target = self.mean_target.of(view);
        if self.mean_stops == 0.0 {
            return target;
        }
        srgb_encode(srgb_decode(target) * self.mean_stops.exp2()).clamp(MEAN_LEAST, MEAN_MOST)
    }

    /// What pictures have to be measured for: what terms of a weight above 0 need. Those that need a background
    /// or an example do not count without one.
    pub fn needs(&self) -> Needs {
        let counts = |&(term, weight): &(&Term, f32)| weight > 0.0 && self.can_measure(term);
        let weighed = self.weights.iter().filter(counts);
        weighed.fold(Needs::NONE, |needs, (term, _)| needs.and(term.needs))
    }

    /// The terms of a picture of a view. Those that need what no term of a weight above 0 needs were not
    /// measured, and are left out.
    pub fn terms(&self, picture: &Statistics, view: &ViewStatistics) -> Terms {
        self.measured().map(|term, _| (term.formula)(picture, view, self))
    }

    /// The weights of the terms whose statistics are measured.
    pub fn measured(&self) -> Terms {
        let needs = self.needs();
        self.weights.filter(|term| needs.and(term.needs) == needs)
    }

    /// The quality of a picture of a view.
    pub fn quality(&self, picture: &Statistics, view: &ViewStatistics) -> Quality {
        let terms = self.terms(picture, view);
        Quality { score: self.score(&terms), terms }
    }

    /// `F`, the weighted sum of the terms, in their order.
    pub fn score(&self, terms: &Terms) -> f32 {
        self.measured().values().zip(terms.values()).map(|(w, t)| w * t).sum()
    }
}

/// The paper's five terms, equally weighed.
fn paper_weights() -> Terms {
    let equal = ["edge", "mean", "grad", "var", "hist"].map(|name| (name, 0.2));
    Terms::named(equal).unwrap_or_default()
}
