//! A driver that knows no polygon numbers and draws no layers: SwiftShader, which comes with Chromium.

use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, GpuEvaluator, PipelineKind, Tuning};
use klieg::lighting::LightKind;
use klieg::lighting::shading::{Brdf, Shading};
use klieg::objective::Objective;
use klieg::objective::shadows::ShadowSettings;
use klieg::scene::Wrap;
use klieg_support::figures::{perspective, shadowed, textured};
use klieg_support::gpu::{assert_valid, population, rigs, with_tuning};
use klieg_support::swiftshader::on_swiftshader;
use std::sync::Arc;

fn context(pipeline: Option<PipelineKind>) -> Arc<Context> {
    with_tuning(Tuning { pipeline, ..Tuning::default() })
}

#[test]
fn it_runs_and_says_what_it_cannot_draw() {
    if !on_swiftshader("it_runs_and_says_what_it_cannot_draw") {
        return;
    }
    let devices = klieg::gpu::devices().expect("a Vulkan loader");
    let [device] = &devices[..] else { panic!("{devices:?}") };
    assert!(device.info.name.contains("SwiftShader") && device.lacks.is_empty(), "{device:?}");
    assert!(!device.draws_scenes && !device.draws_layers);
    let lacks = device.lacks_for_drawing.join(" ");
    assert!(lacks.contains("geometryShader") && lacks.contains("shaderOutputLayer"), "{lacks}");

    let scene = textured([Wrap::Repeat; 2]);
    let (objective, shading) = (Objective::default(), Shading::default());
    for pipeline in [PipelineKind::Layered, PipelineKind::Forward] {
        let (context, view) = (context(Some(pipeline)), perspective(&scene, 20, 20));
        let made = GpuEvaluator::new(&context, &scene, &view, objective, shading);
        let error = made.err().expect("an error").to_string();
        assert!(error.contains("pictures drawn in layers") && error.contains("shaderOutputLayer"));
    }
}

#[test]
fn its_scores_are_those_of_the_cpu() {
    if !on_swiftshader("its_scores_are_those_of_the_cpu") {
        return;
    }
    let context = context(None);
    let colors = Shading { brdf: Brdf::GltfScattering, ..Shading::default() };
    let shadows = ShadowSettings { on: true, side: 15, ..ShadowSettings::default() };
    let population = population(&rigs(3, 12, 2, LightKind::POINT));
    for (scene, shading, shadows) in [
        (textured([Wrap::Repeat; 2]), Shading::default(), ShadowSettings::default()),
        (textured([Wrap::Repeat; 2]), colors, ShadowSettings::default()),
        (shadowed(), colors, shadows),
    ] {
        let (objective, view) = (Objective::default(), perspective(&scene, 97, 61));
        let maps = cpu::draw(&scene, &view, &objective, (&shadows, None)).expect("maps");
        let mut native = CpuEvaluator::new(maps, &view, objective, shading).expect("an evaluator");
        let both = (objective, shading);
        let mut device = GpuEvaluator::with_shadows(&context, &scene, &view, both, &shadows)
            .expect("an evaluator");
        let (mut expected, mut scores) = ([0.0; 12], [0.0; 12]);
        native.evaluate(&population, &mut expected).expect("scores");
        device.evaluate(&population, &mut scores).expect("scores");
        for (score, expected) in scores.into_iter().zip(expected) {
            assert!((score - expected).abs() <= 1e-4, "{score} {expected}");
        }
        assert!(expected.iter().any(|score| (score - expected[0]).abs() > 1e-3));
    }
    assert_valid(&context);
}
