//! The project's own scenes: both evaluators against the CPU references, and whole designs.

use klieg::cpu::{self, CpuEvaluator};
use klieg::design::{self, Outcome, start};
use klieg::evaluate::{Evaluator, Inspection};
use klieg::gpu::GpuEvaluator;
use klieg::lighting::genome::{Boxes, Genome};
use klieg::lighting::presets::Preset;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Role};
use klieg::objective::Objective;
use klieg::optimize::{self, GeneticSettings, Settings, Setup};
use klieg::scene::Scene;
use klieg::scene::view::View;
use klieg_support::gpu as support;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use support::{assert_valid, context, rigs};

const SCENES: [&str; 3] = ["elephant", "pair", "still-life"];
const TOLERANCE: f32 = 1e-4;

/// A scene through its own camera.
fn open(name: &str, size: u32) -> (Scene, View) {
    let path = klieg_support::root().join(format!("scenes/{name}.glb"));
    let scene = klieg::scene::load::load(&path).unwrap();
    let view = View::new(&scene, scene.cameras[0].clone(), size, size).unwrap();
    (scene, view)
}

/// The largest difference of a term.
fn difference(a: &Inspection, b: &Inspection) -> f32 {
    let terms = a.terms.values().zip(b.terms.values());
    terms.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn both_evaluators_agree_on_200_rigs_in_every_scene() {
    let context = context();
    let (objective, shading) = (Objective::default(), Shading::default());
    for name in SCENES {
        let (scene, view) = open(name, 160);
        let mut gpu = GpuEvaluator::new(&context, &scene, &view, objective, shading).unwrap();
        let maps = gpu.maps().unwrap().clone();
        let mut native = CpuEvaluator::new(maps.clone(), &view, objective, shading).unwrap();
        let reference = |rig: &[Light]| {
            let records: Vec<_> = rig.iter().map(Light::record).collect();
            cpu::fitness::fitness(&maps, &view, &objective, &shading, &records)
        };
        let mut worst = [0f32; 2];
        for lights in 1..=4 {
            let kinds = [LightKind::POINT, LightKind::DIRECTIONAL];
            for (kind, rig) in kinds.into_iter().flat_map(|kind| {
                rigs(lights as u64, 25, lights, kind).into_iter().map(move |r| (kind, r))
            }) {
                let expected = reference(&rig);
                let made = [native.inspect(&rig).unwrap(), gpu.inspect(&rig).unwrap()];
                for (worst, made) in worst.iter_mut().zip(&made) {
                    *worst = worst.max(difference(made, &expected));
                    assert!(*worst < TOLERANCE, "{name}, {lights} {kind:?}: {made:?} {expected:?}");
                }
                let mut planted = rig.clone();
                planted[0].azimuth += 0.05;
                planted[0].diffuse += 0.2;
                assert!(difference(&made[0], &reference(&planted)) > TOLERANCE, "{name}: {rig:?}");
            }
        }
        println!("{name}: native within {:e}, Vulkan within {:e}", worst[0], worst[1]);
    }
    assert_valid(&context);
}

/// The default search, with a key and a fill.
fn design(
    scene: &Scene,
    view: &View,
    evaluator: &mut dyn Evaluator,
    generations: usize,
) -> Outcome {
    let roles = [Role::Key, Role::Fill];
    let genome = Genome::new(&roles, LightKind::POINT, &Boxes::default()).unwrap();
    let genetic = GeneticSettings { generations, ..Default::default() };
    let settings = &Settings { genetic, ..Default::default() };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let maps = evaluator.maps().unwrap();
    let first = start::first(scene, view, maps, &genome, &mut rng);
    let setup = Setup { bounds: genome.bounds(), first, settings, rng };
    let mut search = optimize::create("ga", setup).unwrap();
    let observe = &mut |_: &_| ControlFlow::Continue(());
    design::run(&mut *search, &genome, evaluator, observe).unwrap()
}

#[test]
fn a_design_beats_every_preset_in_every_scene() {
    for name in SCENES {
        let (scene, view) = open(name, 192);
        let (objective, shading) = (Objective::default(), Shading::default());
        let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &objective);
        let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading).unwrap();
        let outcome = design(&scene, &view, &mut evaluator, 100);
        let inspected = evaluator.inspect(&outcome.rig).unwrap();
        assert_eq!(inspected.score, outcome.score, "{name}");
        for preset in Preset::ALL {
            let score = evaluator.inspect(&preset.rig()).unwrap().score;
            println!("{name}: {} {score}, designed {}", preset.name(), outcome.score);
            assert!(outcome.score < 0.9 * score, "{name}: {} has {score}", preset.name());
        }
    }
}

#[test]
fn a_design_on_the_device_repeats_itself_and_is_what_the_cpu_would_say() {
    let context = context();
    let (scene, view) = open("pair", 96);
    let (objective, shading) = (Objective::default(), Shading::default());
    let run = || {
        let mut gpu = GpuEvaluator::new(&context, &scene, &view, objective, shading).unwrap();
        let outcome = design(&scene, &view, &mut gpu, 25);
        let maps = gpu.maps().unwrap().clone();
        let native = CpuEvaluator::new(maps, &view, objective, shading)
            .unwrap()
            .inspect(&outcome.rig)
            .unwrap();
        assert!((native.score - outcome.score).abs() < TOLERANCE);
        outcome
    };
    let outcome = run();
    assert_eq!(outcome, run());
    assert_eq!(outcome.history.len(), 25);
    assert!(outcome.history[24].best < outcome.history[0].best);
    assert_valid(&context);
}
