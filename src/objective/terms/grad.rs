//! `F_grad`, shading gradient (Ha and Olivier 2006, section 3): `1 − min(1, G / G_n)`; 0 on flat geometry.

use crate::constants::GRAD_FLAT;
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "grad",
    title: "Shading",
    meaning: "how far the shading varies less than the shape",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    if view.normal_detail < GRAD_FLAT {
        return 0.0;
    }
    1.0 - (picture.gradient / view.normal_detail).min(1.0)
}
