//! Spread of brightness: the distance of its standard deviation from
//! [`spread_target`](crate::objective::Objective::spread_target), as a share of the largest there can be. Unlike
//! [`range`](super::range) it asks for no more than that.

use crate::constants::SPREAD_MOST;
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "spread",
    title: "Spread",
    meaning: "how far the spread of brightness is from its target",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, objective: &Objective) -> f32 {
    let target = objective.spread_target;
    (picture.variance.max(0.0).sqrt() - target).abs() / target.max(SPREAD_MOST - target)
}
