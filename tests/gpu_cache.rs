//! Pipelines are made once for a context, whatever scenes and sizes its evaluators have.

use engine::{ALL, Engine};
use figures::{instances, normal_mapped, perspective, quads};
use klieg::evaluate::Evaluator;
use klieg::gpu::{ComputeShape, Context, GpuEvaluator, PipelineKind, ReadbackEvaluator, Tuning};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind};
use klieg::objective::Objective;
use klieg::scene::Scene;
use klieg_support::{engine, figures, gpu as support};
use std::sync::Arc;
use support::{assert_valid, population, rigs, with_tuning};

/// Every way to measure, and the number of its pipelines: those of the view and of a generation.
const WAYS: [(PipelineKind, Option<ComputeShape>, u64); 4] = [
    (PipelineKind::Layered, None, 8 + 5),
    (PipelineKind::Forward, None, 8 + 5),
    (PipelineKind::Compute, Some(ComputeShape::Runs), 8 + 5),
    (PipelineKind::Compute, Some(ComputeShape::Tiles), 8 + 2),
];

fn tuning(pipeline: PipelineKind, shape: Option<ComputeShape>) -> Tuning {
    Tuning { pipeline: Some(pipeline), shape, ..Default::default() }
}

fn context(pipeline: PipelineKind, shape: Option<ComputeShape>) -> Arc<Context> {
    with_tuning(tuning(pipeline, shape))
}

fn evaluator(context: &Arc<Context>, scene: &Scene, [width, height]: [u32; 2]) -> GpuEvaluator {
    let view = perspective(scene, width, height);
    GpuEvaluator::new(context, scene, &view, Objective::default(), Shading::default())
        .expect("an evaluator")
}

fn lights(count: usize) -> Vec<Vec<Light>> {
    rigs(7, 5, count, LightKind::POINT)
}

fn scores(evaluator: &mut dyn Evaluator, rigs: &[Vec<Light>]) -> Vec<f32> {
    let mut scores = vec![f32::NAN; rigs.len()];
    evaluator.evaluate(&population(rigs), &mut scores).expect("scores");
    scores
}

#[test]
fn another_scene_of_another_size_makes_no_pipeline() {
    for (pipeline, shape, expected) in WAYS {
        let shared = context(pipeline, shape);
        let mut first = evaluator(&shared, &quads(), [70, 50]);
        let before = scores(&mut first, &lights(2));
        assert_eq!(shared.counters().pipelines, expected, "{pipeline:?} {shape:?}");
        for (scene, size) in [(instances(), [131, 40]), (normal_mapped(), [33, 97])] {
            let alone = context(pipeline, shape);
            let fresh = scores(&mut evaluator(&alone, &scene, size), &lights(2));
            let mut second = evaluator(&shared, &scene, size);
            let made = scores(&mut second, &lights(2));
            assert_eq!(shared.counters().pipelines, expected, "{pipeline:?} {shape:?}");
            assert_eq!(made, fresh, "{pipeline:?} {shape:?}");
            assert_ne!(made, before, "the scenes differ");
            assert_valid(&alone);
        }
        assert_eq!(scores(&mut first, &lights(2)), before, "{pipeline:?} {shape:?}");
        assert_valid(&shared);
    }
}

#[test]
fn another_number_of_lights_makes_one_pipeline_once() {
    for (pipeline, shape, expected) in WAYS {
        let shared = context(pipeline, shape);
        let mut first = evaluator(&shared, &quads(), [40, 30]);
        scores(&mut first, &lights(2));
        let mut second = evaluator(&shared, &quads(), [30, 40]);
        let three = scores(&mut second, &lights(3));
        assert_eq!(shared.counters().pipelines, expected + 1, "{pipeline:?} {shape:?}");
        assert_ne!(scores(&mut second, &lights(2)), three);
        scores(&mut first, &lights(3));
        assert_eq!(shared.counters().pipelines, expected + 1, "{pipeline:?} {shape:?}");
        assert_valid(&shared);
    }
}

#[test]
fn the_baseline_shares_the_draws_of_forward() {
    let (shared, scene) = (context(PipelineKind::Forward, None), quads());
    let all = scores(&mut evaluator(&shared, &scene, [40, 30]), &lights(2));
    let before = shared.counters();
    let view = perspective(&scene, 61, 45);
    let (objective, shading) = (Objective::default(), Shading::default());
    let mut baseline =
        ReadbackEvaluator::new(&shared, &scene, &view, objective, shading).expect("the baseline");
    assert_ne!(scores(&mut baseline, &lights(2)), all);
    let after = shared.counters();
    assert_eq!(after.pipelines, before.pipelines);
    assert!(after.allocations > before.allocations);
    assert_valid(&shared);
}

#[test]
fn evaluators_of_several_threads_share_the_pipelines() {
    for (pipeline, shape, expected) in WAYS {
        let engine = Engine::for_threads(ALL);
        let shared = engine.context(&tuning(pipeline, shape));
        let sizes = [[40, 30], [31, 47], [64, 8]];
        let of = |size| scores(&mut evaluator(&shared, &instances(), size), &lights(2));
        let together: Vec<_> = std::thread::scope(|scope| {
            let threads = sizes.map(|size| scope.spawn(move || of(size)));
            threads.map(|thread| thread.join().expect("scores")).into()
        });
        assert_eq!(shared.counters().pipelines, expected, "{pipeline:?} {shape:?}");
        assert_eq!(together, sizes.map(of), "{pipeline:?} {shape:?}");
        drop(shared);
        assert_eq!(engine.end(), [""; 0]);
    }
}

#[test]
fn what_a_context_keeps_does_not_keep_the_context() {
    let shared = context(PipelineKind::Layered, None);
    let mut evaluator = evaluator(&shared, &quads(), [20, 20]);
    scores(&mut evaluator, &lights(1));
    let weak = Arc::downgrade(&shared);
    drop(shared);
    assert!(weak.upgrade().is_some(), "the evaluator holds it");
    drop(evaluator);
    assert!(weak.upgrade().is_none());
}
