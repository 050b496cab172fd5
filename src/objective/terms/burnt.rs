//! Burnt-out pixels: the share of the object with any channel at white, beyond a tolerance.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// Share of the object that may burn out: highlights.
pub const TOLERATED: f32 = 0.005;
/// Share beyond it that makes the term 1.
pub const RANGE: f32 = 0.05;

/// See the module.
pub static TERM: Term = Term {
    name: "burnt",
    title: "Burnt out",
    meaning: "how much of the object is burnt out, in any channel, beyond half a percent",
    needs: Needs::CHANNELS,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    ((picture.burnt - TOLERATED).max(0.0) / RANGE).min(1.0)
}
