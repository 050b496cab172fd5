//! Evaluations that an engine records into its own command buffers.

use engine::{ALL, Engine, Frame, HostBuffer, tunings};
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, GpuEvaluator, ScoreTarget};
use klieg::lighting::shading::Shading;
use klieg::lighting::{LightKind, Population};
use klieg::objective::Objective;
use klieg_support::{engine, gpu as support};
use std::sync::Arc;
use support::{ball, population, rigs, view};

fn evaluator(context: &Arc<Context>) -> GpuEvaluator {
    let (maps, view) = (ball(45, 38), view(45, 38, false));
    let (objective, shading) = (Objective::default(), Shading::default());
    GpuEvaluator::with_maps(context, &maps, &view, objective, shading).unwrap()
}

fn scores(evaluator: &mut GpuEvaluator, population: &Population) -> Vec<f32> {
    let mut scores = vec![0.0; population.len()];
    evaluator.evaluate(population, &mut scores).unwrap();
    scores
}

fn record<'a>(
    engine: &'a Engine,
    evaluator: &mut GpuEvaluator,
    population: &Population,
    target: ScoreTarget,
) -> Frame<'a> {
    // SAFETY: the tests wait for every frame before they drop evaluator and buffer.
    let into = |cmd| unsafe { evaluator.record(cmd, population, target).unwrap() };
    Frame::record(engine, into)
}

#[test]
fn a_recorded_evaluation_gives_the_same_bits() {
    let engine = Engine::new(ALL);
    for tuning in tunings() {
        let context = engine.context(&tuning);
        let mut evaluator = evaluator(&context);
        let first = population(&rigs(1, 9, 3, LightKind::POINT));
        let second = population(&rigs(2, 5, 3, LightKind::POINT));
        let expected = [&first, &second].map(|p| scores(&mut evaluator, p));
        assert_ne!(expected[0][..5], expected[1]);
        evaluator.reserve(9, 3).unwrap();

        let before = context.counters();
        let buffer = HostBuffer::new(&engine, 16);
        let at = |offset| ScoreTarget::Buffer { buffer: buffer.raw, offset };
        // Both are under way at once; the barriers of the second order them.
        let frames = [
            record(&engine, &mut evaluator, &first, at(0)),
            record(&engine, &mut evaluator, &second, at(4 * 10)),
        ];
        frames.iter().for_each(Frame::submit);
        frames.iter().for_each(Frame::wait);
        assert_eq!(context.counters(), before, "a recording makes nothing and reads nothing");
        assert_eq!(buffer.read(0, 9), expected[0]);
        assert_eq!(buffer.read(10, 5), expected[1]);

        // A frame again, and scores in klieg's own memory.
        frames[0].submit();
        frames[0].wait();
        assert_eq!(buffer.read(0, 9), expected[0]);
        let frame = record(&engine, &mut evaluator, &second, ScoreTarget::Mapped);
        frame.submit();
        frame.wait();
        let mut read = [0.0; 5];
        evaluator.read_scores(&mut read).unwrap();
        assert_eq!(read[..], expected[1]);
        assert_eq!(scores(&mut evaluator, &first), expected[0]);
    }
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn a_population_of_many_updates_is_recorded_whole() {
    let engine = Engine::new(ALL);
    let context = engine.context(&tunings()[1]);
    let mut evaluator = evaluator(&context);
    // 150 · 16 lights of 32 bytes are more than one vkCmdUpdateBuffer takes.
    let many = population(&rigs(3, 150, 16, LightKind::POINT));
    let expected = scores(&mut evaluator, &many);
    let frame = record(&engine, &mut evaluator, &many, ScoreTarget::Mapped);
    // What is in the buffer before has nothing to say.
    scores(&mut evaluator, &population(&rigs(4, 150, 16, LightKind::DIRECTIONAL)));
    frame.submit();
    frame.wait();
    let mut read = vec![0.0; 150];
    evaluator.read_scores(&mut read).unwrap();
    assert_eq!(read, expected);
    drop((frame, evaluator, context));
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn what_was_not_reserved_is_refused() {
    let engine = Engine::new(ALL);
    for tuning in tunings() {
        let context = engine.context(&tuning);
        let mut evaluator = evaluator(&context);
        let of = |count, lights| population(&rigs(1, count, lights, LightKind::POINT));
        assert!(evaluator.read_scores(&mut [0.0]).is_err());
        assert!(evaluator.reserve(4, 17).is_err());
        evaluator.reserve(4, 2).unwrap();
        let frame = Frame::record(&engine, |cmd| {
            for (count, lights, fits) in [(4, 2, true), (5, 2, false), (2, 4, false), (4, 1, false)]
            {
                let population = of(count, lights);
                // SAFETY: the frame is never submitted.
                let made = unsafe { evaluator.record(cmd, &population, ScoreTarget::Mapped) };
                assert_eq!(made.is_ok(), fits, "{count} rigs of {lights}");
            }
        });
        drop(frame);
        assert!(evaluator.read_scores(&mut [0.0; 5]).is_err());
    }
    assert_eq!(engine.end(), [""; 0]);
}
