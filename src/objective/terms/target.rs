//! Distance from a target picture: `min(1, √residual / 0.25)`.

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
    (picture.residual.max(0.0).sqrt() / TARGET_RANGE).min(1.0)
}
