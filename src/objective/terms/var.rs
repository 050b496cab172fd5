//! `F_var`, intensity range (Ha and Olivier 2006, section 3): `1 − min(1, σ·√12)`; an even spread of all
//! brightnesses has 0.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "var",
    title: "Range of brightness",
    meaning: "how far the spread of brightness falls short of an even one",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    1.0 - (picture.variance.max(0.0).sqrt() * 12f32.sqrt()).min(1.0)
}
