//! Gloom: the share of the object in the darkest quarter of the brightnesses.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "gloom",
    title: "Gloom",
    meaning: "how much of the object is in the darkest quarter of the brightnesses",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    let dark: u32 = picture.histogram[..8].iter().sum();
    dark as f32 / view.counts.object().max(1) as f32
}
