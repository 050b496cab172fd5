//! From a rig to the quality of its picture.

use super::{appearance, gradient, histogram, moments, population};
use crate::evaluate::Inspection;
use crate::lighting::LightRecord;
use crate::lighting::shading::Shading;
use crate::objective::maps::Maps;
use crate::objective::{Objective, Quality, Statistics, entropy};
use crate::scene::view::View;
use glam::Vec3;

/// What the reductions measure in a picture of which nothing but its brightness is known; what needs
/// more is 0.
pub fn statistics(maps: &Maps, picture: &[f32], objective: &Objective) -> Statistics {
    let needs = objective.needs();
    let background = objective.background.filter(|_| needs.background);
    let (mean, variance) = moments::moments(maps, picture);
    let (edge_contrast, gradient) = gradient::gradient(maps, picture, objective);
    Statistics {
        edge_contrast,
        mean,
        variance,
        gradient,
        histogram: histogram::histogram(maps, picture),
        detail: if needs.detail { gradient::detail(maps, picture) } else { 0.0 },
        residual: if needs.target { appearance::residual(maps, picture) } else { 0.0 },
        outline: background.map_or(0.0, |b| appearance::outline(maps, picture, b)),
        entropy: if needs.curvature {
            entropy(&histogram::by_curvature(maps, picture))
        } else {
            0.0
        },
        ..Statistics::default()
    }
}

/// The whole chain of plain stages for one rig.
pub fn fitness(
    maps: &Maps,
    view: &View,
    objective: &Objective,
    shading: &Shading,
    rig: &[LightRecord],
) -> Inspection {
    let needs = objective.needs();
    let picture = population::picture(maps, view, shading, rig);
    let mut statistics = statistics(maps, &picture, objective);
    if needs.channels {
        let burnt = population::burnt(maps, view, shading, rig);
        statistics.burnt = appearance::share(maps, |at| burnt[at]);
    }
    if needs.irradiance {
        let irradiance = population::irradiance(maps, view, shading, rig);
        statistics.unlit = appearance::unlit(maps, &irradiance);
        statistics.irradiance = appearance::irradiance(maps, &irradiance);
    }
    statistics.key = key(rig);
    let Quality { score, terms } = objective.quality(&statistics, &maps.statistics());
    Inspection { score, terms, statistics, picture }
}

/// Unit vector towards the first key light; 0 without any.
pub fn key(rig: &[LightRecord]) -> [f32; 3] {
    let key = rig.iter().find(|light| light.key > 0.0);
    key.map_or([0.0; 3], |light| Vec3::from(light.position).normalize_or_zero().to_array())
}
