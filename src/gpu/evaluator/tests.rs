//! Which pipeline is taken, and populations in parts.

use super::*;
use crate::evaluate::Evaluator;
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::{Tuning, testing};
use crate::lighting::Light;
use crate::lighting::presets::Preset;

#[test]
fn a_view_with_too_many_object_pixels_is_drawn() {
    let context = testing::context();
    assert_eq!(best(&context, 1000), PipelineKind::Compute);
    assert!(!Runs::fits(&context, 1 << 31));
    let most = best(&context, 1 << 31);
    let runs = context.shape() == ComputeShape::Runs;
    assert_eq!(most == PipelineKind::Layered, runs);
    let (maps, view) = testing::maps(20, 10);
    let (objective, shading) = (Objective::default(), Shading::default());
    let view =
        ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain).unwrap();
    let error = Runs::new(&context, &view, 1 << 31).err();
    assert!(matches!(error, Some(Error::Unsupported { .. })));
    testing::assert_valid(&context);
}

#[test]
fn large_populations_are_submitted_in_parts_with_the_same_bits() {
    let (maps, view) = testing::maps(20, 10);
    // How many submissions there are with room for 8 individuals and for none, and how many stages.
    for (pipeline, shape, blocks, stages) in [
        (PipelineKind::Layered, None, [5, 37], 5),
        (PipelineKind::Compute, Some(ComputeShape::Runs), [5, 10], 3),
        (PipelineKind::Compute, Some(ComputeShape::Tiles), [5, 19], 2),
    ] {
        let tuning = Tuning { pipeline: Some(pipeline), shape, ..Tuning::default() };
        let context = testing::with_tuning(tuning);
        let (objective, shading) = (Objective::default(), Shading::default());
        let mut evaluator =
            GpuEvaluator::with_maps(&context, &maps, &view, objective, shading).unwrap();
        let rigs = rigs(37);
        let population = Population::of(rigs.iter().map(<[Light; 2]>::as_slice)).unwrap();
        let mut measured = |work: Option<u64>| {
            let mut scores = vec![0.0; rigs.len()];
            evaluator.reserve(37, 2).unwrap();
            if let (Some(work), Some(generation)) = (work, &mut evaluator.generation) {
                generation.submission_work = work;
                evaluator.recorded = None;
            }
            evaluator.evaluate(&population, &mut scores).unwrap();
            (scores, evaluator.commands.len())
        };
        let (expected, ordinary) = measured(None);
        // Room for 8 individuals of 200 pixels and 2 lights each; then for none.
        let parts = [3300, 1].map(|work| {
            let (scores, parts) = measured(Some(work));
            assert_eq!(scores, expected, "{pipeline} {shape:?}");
            parts
        });
        assert_eq!((ordinary, parts), (1, blocks), "{pipeline} {shape:?}");
        assert_eq!(evaluator.timings().len(), stages, "{:?}", evaluator.timings());
        testing::assert_valid(&context);
    }
}

/// So many rigs of two lights.
fn rigs(number: u8) -> Vec<[Light; 2]> {
    let light = |i: u8| Light { azimuth: f32::from(i), ..Preset::Headlight.rig()[0] };
    (0..number).map(|i| [light(i), light(2 * i + 1)]).collect()
}

#[test]
fn evaluations_that_were_begun_end_in_any_order_or_never() {
    let (maps, view) = testing::maps(20, 10);
    let context = testing::context();
    let (objective, shading) = (Objective::default(), Shading::default());
    let evaluator = || GpuEvaluator::with_maps(&context, &maps, &view, objective, shading).unwrap();
    let all = rigs(9);
    let few = Population::of(all[..2].iter().map(<[Light; 2]>::as_slice)).unwrap();
    let many = Population::of(all.iter().map(<[Light; 2]>::as_slice)).unwrap();
    let (mut first, mut second) = (evaluator(), evaluator());
    let mut expected = [0.0; 9];
    first.evaluate(&many, &mut expected).unwrap();
    let mut found = [[0.0; 9], [0.0; 9]];
    let [of_first, of_second] = [first.begin(&many).unwrap(), second.begin(&many).unwrap()];
    of_second(&mut found[1]).unwrap();
    of_first(&mut found[0]).unwrap();
    assert_eq!(found, [expected; 2]);
    // What nobody waits for neither spoils what follows, though that takes more memory, nor outlives its evaluator.
    let mut third = evaluator();
    drop(third.begin(&few).unwrap());
    third.evaluate(&many, &mut found[0]).unwrap();
    assert_eq!(found[0], expected);
    drop(third.begin(&few).unwrap());
    drop(third);
    let places = first.begin(&many).unwrap()(&mut found[0][..2]).unwrap_err();
    assert_eq!(places.to_string(), "2 places for the scores of 9 rigs");
    testing::assert_valid(&context);
}
