//! Maximum entropy light source placement, natively: lights one after another are at least as good as a dense grid of
//! directions.

use klieg::cpu::{self, CpuEvaluator};
use klieg::design::profile::NATURAL;
use klieg::design::{self, one_by_one};
use klieg::evaluate::Evaluator;
use klieg::lighting::genome::{Boxes, Genome};
use klieg::lighting::{Light, LightKind, Population, Rig, Role};
use klieg::math::range::Range;
use klieg::objective::shadows::ShadowSettings;
use klieg::objective::{Objective, Terms};
use klieg::optimize::{self, GeneticSettings, Settings, Setup};
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load;
use klieg::scene::view::View;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::path::Path;

/// Steps of the grid along each angle.
const STEPS: usize = 45;

/// The elephant, judged by one term.
fn elephant(term: &str) -> CpuEvaluator {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/elephant.glb");
    let scene = load::load(&path).unwrap();
    let camera = frame(&scene, &Framing::default(), 1.0).unwrap();
    let view = View::new(&scene, camera, 48, 48).unwrap();
    let weights = Terms::named([(term, 1.0)]).unwrap();
    let objective = Objective { weights, ..(NATURAL.objective)() };
    let off = ShadowSettings { on: false, ..ShadowSettings::default() };
    let maps = cpu::draw(&scene, &view, &objective, (&off, None)).unwrap();
    CpuEvaluator::new(maps, &view, objective, (NATURAL.shading)()).unwrap()
}

/// Two lights from anywhere in front, of one intensity.
fn genome() -> Genome {
    let mut boxes: Boxes = (NATURAL.boxes)();
    boxes.key.elevation = Range::new(-80.0, 80.0);
    boxes.key.azimuth = Range::new(-90.0, 90.0);
    let genome = Genome::new(&[Role::Key, Role::Key], LightKind::DIRECTIONAL, &boxes).unwrap();
    let light = Light { diffuse: 0.6, ..Light::default() };
    (0..2).fold(genome, |genome, at| genome.hold(at, &light, Some("diffuse")).unwrap())
}

/// The lowest and the highest score of the lights `before` with one more, from every direction of the grid.
fn grid(evaluator: &mut CpuEvaluator, before: &[Light]) -> (f32, f32) {
    let (lights, mut genome) = (before.len() + 1, genome().of_first(before.len() + 1));
    for (at, light) in before.iter().enumerate() {
        genome = genome.hold(at, light, None).unwrap();
    }
    let place =
        |step: usize, range: &Range| range.low + (step as f32 + 0.5) / STEPS as f32 * range.width();
    let [elevation, azimuth] = genome.bounds() else { panic!("two angles are searched") };
    let chromosome = |k: usize| [place(k / STEPS, elevation), place(k % STEPS, azimuth)];
    let rigs: Vec<Rig> = (0..STEPS * STEPS).map(|k| genome.decode(&chromosome(k))).collect();
    assert!(rigs.iter().all(|rig| rig.len() == lights));
    let mut scores = vec![0.0; rigs.len()];
    let population = Population::of(rigs.iter().map(Vec::as_slice)).unwrap();
    evaluator.evaluate(&population, &mut scores).unwrap();
    let fold = |with: fn(f32, f32) -> f32| scores.iter().copied().reduce(with).unwrap();
    (fold(f32::min), fold(f32::max))
}

#[test]
fn each_light_is_the_best_addition_to_those_before_it() {
    for term in ["hist", "entropy"] {
        let mut evaluator = elephant(term);
        let genetic =
            GeneticSettings { population: 20, generations: 50, ..GeneticSettings::default() };
        let settings = Settings { genetic, ..Settings::default() };
        let mut seen = Vec::new();
        let mut observe = |progress: &design::Progress| {
            seen.push(*progress);
            ControlFlow::Continue(())
        };
        let mut scores = Vec::new();
        let found = one_by_one::<klieg::Error>(&genome(), &mut observe, &mut |genome, observe| {
            let first = genome.bounds().iter().map(Range::middle).collect();
            let rng = ChaCha8Rng::seed_from_u64(5);
            let setup = Setup { bounds: genome.bounds(), first, settings: &settings, rng };
            let mut search = optimize::create("shade", setup)?;
            let outcome = design::run(&mut *search, genome, &mut evaluator, observe)?;
            scores.push(outcome.score);
            Ok(outcome)
        })
        .unwrap();
        assert_eq!((found.rig.len(), found.score), (2, scores[1]));
        assert_eq!(found.history, seen);
        let counted = |k: usize| seen[k].generation == k + 1;
        assert!((0..seen.len()).all(counted) && !found.stopped);
        assert!(seen.is_sorted_by(|a, b| a.evaluations < b.evaluations));
        for (lights, &score) in scores.iter().enumerate() {
            let (best, worst) = grid(&mut evaluator, &found.rig[..lights]);
            assert!(score <= best, "{term}, light {lights}: {score} and on the grid {best}");
            let apart = if lights == 0 { 0.1 } else { 0.004 };
            assert!(worst > best + apart, "{term}, light {lights}: {best} to {worst} on the grid");
        }
    }
}

#[test]
fn no_light_follows_where_the_observer_has_had_enough() {
    let mut searched = 0;
    let mut observe = |_: &design::Progress| ControlFlow::Break(());
    let found = one_by_one::<klieg::Error>(&genome(), &mut observe, &mut |genome, observe| {
        searched += 1;
        let mut evaluator = elephant("hist");
        let first = genome.bounds().iter().map(Range::middle).collect();
        let (settings, rng) = (Settings::default(), ChaCha8Rng::seed_from_u64(1));
        let setup = Setup { bounds: genome.bounds(), first, settings: &settings, rng };
        design::run(&mut *optimize::create("shade", setup)?, genome, &mut evaluator, observe)
    })
    .unwrap();
    assert_eq!((searched, found.rig.len(), found.stopped), (1, 1, true));
}
