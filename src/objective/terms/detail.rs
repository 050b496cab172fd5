//! Visible detail: `1 −` the share of the shape's detail that the picture shows, wherever it is. Unlike in
//! [`grad`](super::grad), a bright terminator cannot pay for flat areas. 0 on flat geometry.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "detail",
    title: "Detail",
    meaning: "how much of the relief cannot be seen, wherever it is",
    needs: Needs::DETAIL,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    if view.shape.detail_weight > 0.0 { 1.0 - picture.detail.min(1.0) } else { 0.0 }
}
