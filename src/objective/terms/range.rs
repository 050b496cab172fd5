//! Contrast: `1 − min(1, σ / 0.2)`. Enough is enough: unlike [`var`](super::var) it pays for no more.

use crate::constants::RANGE_ENOUGH;
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "range",
    title: "Contrast",
    meaning: "how far the spread of brightness falls short of a fifth of the range",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    1.0 - (picture.variance.max(0.0).sqrt() / RANGE_ENOUGH).min(1.0)
}
