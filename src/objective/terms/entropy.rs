//! Illumination entropy where the surface curves (Gumhold 2002, *Maximum Entropy Light Source Placement*):
//! `1 − H / ln 32` with the entropy `H` of the histogram in which each pixel counts by the curvature that it shows, nats.
//! Without these weights it is [`hist`](super::hist). 0 on flat geometry.

use crate::constants::GRAD_FLAT;
use crate::objective::maps::ViewStatistics;
use crate::objective::{HISTOGRAM_BINS, Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "entropy",
    title: "Entropy",
    meaning: "how unevenly the brightnesses are used where the surface curves",
    needs: Needs::CURVATURE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    if view.normal_detail < GRAD_FLAT {
        return 0.0;
    }
    1.0 - (picture.entropy / (HISTOGRAM_BINS as f32).ln()).min(1.0)
}
