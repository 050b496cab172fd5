//! A term from outside the crate: a `static` and its weight are all that it takes.

use klieg::cpu::{self, CpuEvaluator};
use klieg::design::{self, Progress, start};
use klieg::evaluate::{Evaluator, Inspection};
use klieg::gpu::{GpuEvaluator, ScoreTarget};
use klieg::lighting::genome::{Boxes, Genome};
use klieg::lighting::presets::Preset;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Role};
use klieg::objective::maps::Maps;
use klieg::objective::{Needs, Objective, Term};
use klieg::optimize::start::{StartSettings, population as first_population};
use klieg::optimize::{Genetic, GeneticSettings};
use klieg_support::gpu::{assert_valid, ball, context, population, rigs, view};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

/// Share of the object in the darkest quarter of the brightnesses, and how much is too much.
static GLOOM: Term = Term {
    name: "gloom",
    title: "Gloom",
    meaning: "how much of the object is in the darkest quarter of the brightnesses",
    needs: Needs::NONE,
    formula: |picture, view, _| {
        let dark: u32 = picture.histogram[..8].iter().sum();
        dark as f32 / view.counts.object().max(1) as f32
    },
};

/// The paper's objective and the new term.
fn gloomless() -> Objective {
    let mut objective = Objective::default();
    objective.weights.set(&GLOOM, 2.0).expect("room for one more");
    objective
}

/// What the plain stages of the crate make of a rig.
fn reference(maps: &Maps, objective: &Objective, rig: &[Light]) -> Inspection {
    let records: Vec<_> = rig.iter().map(Light::record).collect();
    let view = view(96, 80, false);
    cpu::fitness::fitness(maps, &view, objective, &Shading::default(), &records)
}

fn scores(evaluator: &mut dyn Evaluator, rigs: &[Vec<Light>]) -> Vec<f32> {
    let mut scores = vec![0.0; rigs.len()];
    evaluator.evaluate(&population(rigs), &mut scores).expect("scores");
    scores
}

#[test]
fn both_evaluators_judge_by_a_term_that_no_shader_knows() {
    let (context, view, maps) = (context(), view(96, 80, false), ball(96, 80));
    let (objective, shading) = (gloomless(), Shading::default());
    assert!(objective.check().is_ok() && !objective.is_own() && Objective::default().is_own());
    let native = CpuEvaluator::new(maps.clone(), &view, objective, shading);
    let mut native = native.expect("an evaluator");
    let gpu = GpuEvaluator::with_maps(&context, &maps, &view, objective, shading);
    let mut gpu = gpu.expect("an evaluator");
    let plain = GpuEvaluator::with_maps(&context, &maps, &view, Objective::default(), shading);
    let mut plain = plain.expect("an evaluator");
    let rigs = rigs(3, 12, 2, LightKind::POINT);
    let without = scores(&mut plain, &rigs);
    for evaluator in [&mut native as &mut dyn Evaluator, &mut gpu] {
        let found = scores(evaluator, &rigs);
        let qualities = evaluator.qualities(&population(&rigs)).expect("qualities");
        for (i, rig) in rigs.iter().enumerate() {
            let expected = reference(&maps, &objective, rig);
            let gloom = qualities[i].terms.get("gloom").expect("the new term");
            assert!((gloom - expected.terms.get("gloom").expect("the new term")).abs() < 1e-3);
            assert!((found[i] - expected.score).abs() < 2e-3, "{} {}", found[i], expected.score);
            assert_eq!(found[i], qualities[i].score);
            assert_eq!(evaluator.inspect(rig).expect("a rig").terms, qualities[i].terms);
            assert!(
                (found[i] - without[i] - 2.0 * gloom).abs() < 1e-4,
                "{} {}",
                found[i],
                without[i]
            );
        }
        assert!(found.iter().zip(&without).any(|(a, b)| a - b > 0.1), "the term tells nothing");
    }
    // A recording's scores are the device's, which knows no such term.
    let (cmd, target) = (klieg::ash::vk::CommandBuffer::null(), ScoreTarget::Mapped);
    // SAFETY: it is refused before anything is recorded.
    let refused = unsafe { gpu.record(cmd, &population(&rigs), target) };
    assert!(refused.expect_err("a foreign term").to_string().contains("own terms"));
    assert_valid(&context);
}

/// The best lights that a short search finds.
fn search(evaluator: &mut dyn Evaluator) -> Inspection {
    let roles = [Role::Key, Role::Fill];
    let genome = Genome::new(&roles, LightKind::POINT, &Boxes::default()).expect("a genome");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let first = start::from_rig(&genome, &Preset::ThreePoint.rig()[..2]).expect("two lights");
    let settings =
        GeneticSettings { population: 16, generations: 12, ..GeneticSettings::default() };
    let (bounds, spread) = (genome.bounds(), StartSettings::default());
    let population = first_population(bounds, first, settings.population, &spread, &mut rng);
    let mut genetic = Genetic::new(bounds, population, settings, rng).expect("a search");
    let mut go_on = |_: &Progress| ControlFlow::Continue(());
    let found = design::run(&mut genetic, &genome, evaluator, &mut go_on).expect("an outcome");
    evaluator.inspect(&found.rig).expect("the best rig")
}

#[test]
fn a_search_follows_the_new_term_on_both_evaluators() {
    let (context, view, maps) = (context(), view(96, 80, false), ball(96, 80));
    let shading = Shading::default();
    let judge = |made: &Inspection| {
        let dark: u32 = made.statistics.histogram[..8].iter().sum();
        dark as f32 / maps.counts.object() as f32
    };
    let native = |objective| {
        CpuEvaluator::new(maps.clone(), &view, objective, shading).expect("an evaluator")
    };
    let usual = judge(&search(&mut native(Objective::default())));
    let bright = judge(&search(&mut native(gloomless())));
    let gpu = GpuEvaluator::with_maps(&context, &maps, &view, gloomless(), shading);
    let on_gpu = judge(&search(&mut gpu.expect("an evaluator")));
    assert!(bright < 0.7 * usual && on_gpu < 0.7 * usual, "{usual} {bright} {on_gpu}");
    assert_valid(&context);
}

#[test]
fn results_name_the_new_term_and_files_cannot() {
    let objective = gloomless();
    let maps = ball(32, 32);
    let made = reference(&maps, &objective, &Preset::Headlight.rig());
    let json = serde_json::to_value(made.quality()).expect("JSON");
    assert_eq!(json["terms"]["gloom"], made.terms.get("gloom").expect("the new term"));
    let weights = serde_json::to_string(&objective.weights).expect("JSON");
    let fault = serde_json::from_str::<klieg::objective::Terms>(&weights).unwrap_err().to_string();
    assert!(fault.contains("no term 'gloom'"), "{fault}");
}
