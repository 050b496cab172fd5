//! `F_mean`, mean brightness (Ha and Olivier 2006, section 3): its distance from the target, as a share of
//! the largest there can be.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "mean",
    title: "Brightness",
    meaning: "how far the mean brightness is from its target",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, objective: &Objective) -> f32 {
    let target = objective.mean_of(view);
    (picture.mean - target).abs() / target.max(1.0 - target)
}
