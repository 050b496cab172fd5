//! What the device measures, and what the CPU references measure on the same maps.

use crate::gpu::population;
use klieg::cpu;
use klieg::evaluate::{Evaluator, Inspection};
use klieg::gpu::{Context, GpuEvaluator};
use klieg::lighting::Light;
use klieg::lighting::shading::Shading;
use klieg::objective::maps::Maps;
use klieg::objective::{Objective, Quality};
use klieg::scene::view::View;
use std::sync::Arc;

/// An evaluator of known maps.
pub fn evaluator(context: &Arc<Context>, maps: &Maps, view: &View) -> GpuEvaluator {
    GpuEvaluator::with_maps(context, maps, view, Objective::default(), Shading::default())
        .expect("an evaluator")
}

/// The scores of some rigs on the device.
pub fn evaluate(evaluator: &mut GpuEvaluator, rigs: &[Vec<Light>]) -> Vec<f32> {
    let mut scores = vec![f32::NAN; rigs.len()];
    evaluator.evaluate(&population(rigs), &mut scores).expect("scores");
    scores
}

/// A rig under the CPU references.
pub fn reference(maps: &Maps, view: &View, rig: &[Light]) -> Inspection {
    let records: Vec<_> = rig.iter().map(Light::record).collect();
    cpu::fitness::fitness(maps, view, &Objective::default(), &Shading::default(), &records)
}

/// The largest difference of score and terms.
pub fn difference(a: Quality, b: Quality) -> f32 {
    let terms = a.terms.values().zip(b.terms.values());
    terms.map(|(a, b)| (a - b).abs()).fold((a.score - b.score).abs(), f32::max)
}
