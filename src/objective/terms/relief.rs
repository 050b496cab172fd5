//! Relief: how little the shading tells left from right and up from down. `1 − min(1, R² / 0.6)`, where
//! `R² = cᵀC⁻¹c / var(e)` is the coefficient of determination of the encoded irradiance `e` by the normals'
//! components `n_x` and `n_y`: `C` is their covariance matrix, fixed for a view, `c` their covariances with
//! `e`. A headlight has none: it looks flat. 0 on flat geometry.

use crate::constants::{RELIEF_ENOUGH, RELIEF_LEAST};
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "relief",
    title: "Relief",
    meaning: "how little the shading tells left from right and up from down",
    needs: Needs::IRRADIANCE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, _: &Objective) -> f32 {
    let Some([xx, xy, yy]) = view.shape.normal_precision() else { return 0.0 };
    let [x, y] = picture.irradiance.covariance;
    let explained = xx * x * x + 2.0 * xy * x * y + yy * y * y;
    1.0 - (explained / picture.irradiance.variance.max(RELIEF_LEAST) / RELIEF_ENOUGH).clamp(0.0, 1.0)
}
