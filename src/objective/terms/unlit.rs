//! Unlit pixels: the share of the object that no light reaches.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// Share of the object that makes the term 1.
pub const RANGE: f32 = 0.15;

/// See the module.
pub static TERM: Term = Term {
    name: "unlit",
    title: "Unlit",
    meaning: "how much of the object no light reaches",
    needs: Needs::IRRADIANCE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    (picture.unlit / RANGE).min(1.0)
}
