//! Unlit pixels: the share of the object that no light reaches.

use crate::constants::UNLIT_RANGE;
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "unlit",
    title: "Unlit",
    meaning: "how much of the object no light reaches",
    needs: Needs::IRRADIANCE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    (picture.unlit / UNLIT_RANGE).min(1.0)
}
