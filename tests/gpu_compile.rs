//! The driver compiles every pipeline that a generation takes. `make drivers` runs this on drivers without their hardware,
//! where nothing is computed, and says so by `KLIEG_NO_HARDWARE`.

use klieg::cpu;
use klieg::design::profile;
use klieg::evaluate::Evaluator;
use klieg::gpu::{ComputeShape, GpuEvaluator, PipelineKind, Tuning};
use klieg::lighting::LightKind;
use klieg::objective::maps::Maps;
use klieg::objective::shadows::ShadowSettings;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load::load;
use klieg::scene::view::View;
use klieg_support::gpu as support;
use support::{assert_valid, population, rigs, with_tuning};

const INDIVIDUALS: usize = 4;

/// The maps of a scene of the project, with shadows for the profile that has them.
fn maps(profile: &profile::Profile) -> (Maps, View) {
    let scene = load(&klieg_support::root().join("scenes/pair.glb")).expect("a scene");
    let camera = frame(&scene, &Framing::default(), 1.0).expect("a camera");
    let view = View::new(&scene, camera, 48, 48).expect("a view");
    let shadows = ShadowSettings { side: 9, on: profile.shadows, ..ShadowSettings::default() };
    (cpu::draw(&scene, &view, &(profile.objective)(), (&shadows, None)).expect("maps"), view)
}

#[test]
fn every_way_to_judge_maps_compiles_and_runs() {
    let ways = [
        (PipelineKind::Layered, None),
        (PipelineKind::Compute, Some(ComputeShape::Runs)),
        (PipelineKind::Compute, Some(ComputeShape::Tiles)),
    ];
    let computes = std::env::var_os("KLIEG_NO_HARDWARE").is_none();
    for profile in [&profile::PAPER, &profile::NATURAL] {
        let (maps, view) = maps(profile);
        for (kind, shape) in ways {
            for any_lights in [false, true] {
                let tuning =
                    Tuning { pipeline: Some(kind), shape, any_lights, ..Default::default() };
                let context = with_tuning(tuning);
                if kind == PipelineKind::Layered && !context.report().draws_layers {
                    continue;
                }
                let both = ((profile.objective)(), (profile.shading)());
                let mut evaluator = GpuEvaluator::with_maps(&context, &maps, &view, both.0, both.1)
                    .expect("an evaluator");
                for lights in [1, 4] {
                    let rigs = rigs(5, INDIVIDUALS, lights, LightKind::POINT);
                    let mut scores = [f32::NAN; INDIVIDUALS];
                    let evaluated = evaluator.evaluate(&population(&rigs), &mut scores);
                    if computes {
                        evaluated.expect("scores");
                        assert!(scores.iter().all(|score| score.is_finite()), "{scores:?}");
                    }
                }
                assert!(context.counters().pipelines >= 2, "{:?}", context.counters());
                assert_valid(&context);
            }
        }
    }
}
