//! `F_edge`, edge distinctness (Ha and Olivier 2006, section 3): `1 −` the mean over EDGE of
//! `min(1, |∇I| / edge_contrast)`; 0 without edges.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "edge",
    title: "Edges",
    meaning: "how indistinct the edges of the objects are",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    if view.counts.edge == 0 { 0.0 } else { 1.0 - picture.edge_contrast }
}
