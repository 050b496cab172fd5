//! From a picture to its quality.

use super::{gradient, histogram, moments, population};
use crate::evaluate::Inspection;
use crate::lighting::LightRecord;
use crate::lighting::shading::Shading;
use crate::objective::maps::Maps;
use crate::objective::{Objective, Statistics};
use crate::scene::view::View;

/// What the reductions measure in a picture.
pub fn statistics(maps: &Maps, picture: &[f32], objective: &Objective) -> Statistics {
    let (mean, variance) = moments::moments(maps, picture);
    let (edge_contrast, gradient) = gradient::gradient(maps, picture, objective);
    let histogram = histogram::histogram(maps, picture);
    Statistics { edge_contrast, mean, variance, gradient, histogram }
}

/// The whole chain of plain stages for one rig.
pub fn fitness(
    maps: &Maps,
    view: &View,
    objective: &Objective,
    shading: &Shading,
    rig: &[LightRecord],
) -> Inspection {
    let picture = population::picture(maps, view, shading, rig);
    let statistics = statistics(maps, &picture, objective);
    let terms = objective.terms(&statistics, maps);
    Inspection { score: objective.score(&terms), terms, statistics, picture }
}
