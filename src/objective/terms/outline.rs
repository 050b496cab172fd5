//! Silhouette: how far the object's outline is from standing out against a given background. 0 without a
//! background.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "outline",
    title: "Silhouette",
    meaning: "how much of the outline merges with the background that is given",
    needs: Needs::BACKGROUND,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    picture.outline.min(1.0)
}
