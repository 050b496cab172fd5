//! Contexts and evaluators that come and go on an engine's device leave nothing behind.

#![cfg(target_os = "linux")]

use engine::{ALL, Engine};
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, GpuEvaluator, Tuning};
use klieg::lighting::LightKind;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg_support::{engine, gpu as support};
use std::sync::Arc;
use support::{ball, population, rigs, view};

/// Kilobytes that the heap may grow by its own ways of keeping memory.
const SLACK: i64 = 1024;

/// Kilobytes of the process in memory.
fn resident() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

fn evaluated(context: &Arc<Context>) -> GpuEvaluator {
    let (maps, view) = (ball(24, 16), view(24, 16, false));
    let (objective, shading) = (Objective::default(), Shading::default());
    let mut evaluator = GpuEvaluator::with_maps(context, &maps, &view, objective, shading).unwrap();
    let population = population(&rigs(5, 4, 2, LightKind::POINT));
    evaluator.evaluate(&population, &mut [0.0; 4]).unwrap();
    evaluator
}

/// Kilobytes that the process grows by in the last four fifths of so many lives.
fn growth(lives: usize, mut live: impl FnMut()) -> i64 {
    (0..lives / 5).for_each(|_| live());
    let before = resident();
    (lives / 5..lives).for_each(|_| live());
    resident() - before
}

#[test]
fn a_thousand_lives_leave_no_memory_behind() {
    let engine = Engine::unwatched(ALL);
    let context = engine.context(&Tuning::default());
    drop(evaluated(&context));
    let (counters, taken) = (context.counters(), context.memory_taken());
    let grown = growth(1000, || drop(evaluated(&context)));
    assert!(grown < SLACK, "evaluators leave {grown} kB behind");
    assert_eq!(context.counters().pipelines, counters.pipelines);
    assert_eq!(context.memory_taken(), taken);
    let grown = growth(1000, || drop(engine.context(&Tuning::default())));
    assert!(grown < SLACK, "contexts leave {grown} kB behind");
    drop(context);
    engine.end();

    let engine = Engine::unwatched(ALL);
    let context = engine.context(&Tuning::default());
    let grown = growth(100, || std::mem::forget(evaluated(&context)));
    assert!(grown > SLACK, "a leak is not seen: {grown} kB");
}
