//! Distance from a target picture: `1.25 d / (d + 0.25)`, `d = √residual`. It falls from wherever the picture is.

use crate::constants::TARGET_RANGE;
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "target",
    title: "Target",
    meaning: "how far the picture is from the target picture",
    needs: Needs::TARGET,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    let distance = picture.residual.max(0.0).sqrt();
    (1.0 + TARGET_RANGE) * distance / (distance + TARGET_RANGE)
}
