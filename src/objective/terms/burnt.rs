//! Burnt-out pixels: the share of the object with any channel at white, beyond a tolerance.

use crate::constants::{BURNT_RANGE, BURNT_TOLERATED};
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "burnt",
    title: "Burnt out",
    meaning: "how much of the object is burnt out, in any channel, beyond half a percent",
    needs: Needs::CHANNELS,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    ((picture.burnt - BURNT_TOLERATED).max(0.0) / BURNT_RANGE).min(1.0)
}
