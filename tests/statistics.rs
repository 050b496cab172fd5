//! Every statistic, in every way that there is to measure it, against the CPU references: all terms at once,
//! under coloured lights and spots, with either BRDF.

use glam::Vec3;
use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::gpu::{ComputeShape, GpuEvaluator, PipelineKind, Tuning};
use klieg::lighting::shading::{Brdf, Shading};
use klieg::lighting::{LightRecord, Population};
use klieg::math::color::luminance;
use klieg::objective::maps::{Maps, PixelType};
use klieg::objective::terms::TERMS;
use klieg::objective::{Example, HISTOGRAM_BINS, MeanTarget, Objective, Quality, Terms};
use klieg::scene::view::View;
use klieg_support::gpu::{assert_valid, ball, view, with_tuning};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const TOLERANCE: f32 = 1e-4;

/// All of klieg's terms, equally weighed, with the mean brightness that the scene asks for, before grey.
fn all_terms() -> Objective {
    let weight = 1.0 / TERMS.len() as f32;
    let weights = Terms::named(TERMS.iter().map(|term| (term.name, weight))).expect("their names");
    let (mean_target, background) = (MeanTarget::Scene, Some(0.4));
    let (mean_stops, spread_target) = (-0.5, 0.3);
    let mut histogram = [0.0; HISTOGRAM_BINS];
    (0..HISTOGRAM_BINS).for_each(|bin| histogram[bin] = (bin + 1) as f32 / 528.0);
    let example = Some(Example { histogram, gradient: 0.03 });
    Objective {
        weights,
        mean_target,
        mean_stops,
        spread_target,
        example,
        background,
        ..Objective::default()
    }
}

/// The ball, with a target picture that tells a part of it.
fn maps(width: u32, height: u32) -> Maps {
    let mut maps = ball(width, height);
    let tone = |(at, kind): (usize, &PixelType)| match kind {
        PixelType::Background => -1.0,
        _ if at % 3 == 0 => -1.0,
        _ => (at % 97) as f32 / 97.0,
    };
    maps.target = maps.types.iter().enumerate().map(tone).collect();
    maps
}

/// Lights of all kinds and colours.
fn records(seed: u64, count: usize) -> Vec<LightRecord> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |low: f32, high: f32| random.random_range(low..high);
    let light = |k: usize| {
        let towards = Vec3::new(number(-1.0, 1.0), number(-0.5, 1.0), number(0.1, 1.0)).normalize();
        let distance = number(1.5, 4.0);
        let white = k % 4 == 3;
        let tint = Vec3::new(number(0.2, 2.0), number(0.5, 1.2), number(0.2, 3.0));
        LightRecord {
            position: (towards * if k.is_multiple_of(3) { 1.0 } else { distance }).to_array(),
            radius2: if k.is_multiple_of(3) { 0.0 } else { distance * distance },
            diffuse: number(0.0, 1.5),
            specular: number(0.0, 1.5),
            cone_scale: if k % 3 == 1 { 6.0 } else { 0.0 },
            cone_offset: if k % 3 == 1 { -5.0 } else { 1.0 },
            color: if white { [1.0; 3] } else { (tint / luminance(tint)).to_array() },
            size: 0.0,
            axis: (-towards + 0.1 * Vec3::X).normalize().to_array(),
            key: if k % 2 == 1 { 1.0 } else { 0.0 },
        }
    };
    (0..count).map(light).collect()
}

fn difference(a: &Quality, b: &Quality) -> f32 {
    assert!(a.terms.names().eq(b.terms.names()));
    let terms = a.terms.values().zip(b.terms.values());
    terms.map(|(a, b)| (a - b).abs()).fold((a.score - b.score).abs(), f32::max)
}

/// The largest difference of any term of an evaluator from the references; each rig's, and that of a rig
/// in which one number is off.
fn check(
    evaluator: &mut dyn Evaluator,
    (maps, view): (&Maps, &View),
    lights: usize,
    shading: &Shading,
    seed: u64,
) {
    let objective = all_terms();
    let population = Population::of_records(lights, records(seed, 7 * lights)).expect("rigs");
    let found = evaluator.qualities(&population).expect("qualities");
    for (rig, found) in population.rigs().zip(&found) {
        let expected = cpu::fitness::fitness(maps, view, &objective, shading, rig).quality();
        assert_eq!(expected.terms.iter().count(), TERMS.len());
        let off = difference(found, &expected);
        assert!(off < TOLERANCE, "{lights} lights, {shading:?}: {off}\n{found:?}\n{expected:?}");
        let mut planted = rig.to_vec();
        planted[0].color[1] *= 1.2;
        planted[0].diffuse += 0.02;
        let planted = cpu::fitness::fitness(maps, view, &objective, shading, &planted).quality();
        assert!(planted == expected || difference(found, &planted) > TOLERANCE);
    }
}

fn shadings() -> [Shading; 2] {
    [Brdf::BlinnPhong, Brdf::Gltf].map(|brdf| Shading { brdf, ..Shading::default() })
}

#[test]
fn the_native_evaluator_measures_what_the_references_do() {
    for (at, (width, height)) in [(64, 48), (150, 131)].into_iter().enumerate() {
        let maps = maps(width, height);
        for shading in shadings() {
            for lights in [1, 2, 5] {
                let view = view(width, height, false);
                let mut native =
                    CpuEvaluator::new(maps.clone(), &view, all_terms(), shading).expect("maps");
                check(&mut native, (&maps, &view), lights, &shading, (at * 10 + lights) as u64);
            }
        }
    }
}

/// The ways of measuring a population on a device.
fn ways() -> Vec<Tuning> {
    let compute = |shape| Tuning {
        pipeline: Some(PipelineKind::Compute),
        shape: Some(shape),
        ..Tuning::default()
    };
    vec![
        Tuning { pipeline: Some(PipelineKind::Layered), ..Tuning::default() },
        compute(ComputeShape::Runs),
        compute(ComputeShape::Tiles),
    ]
}

#[test]
fn every_way_on_the_device_measures_what_the_references_do() {
    for tuning in ways() {
        let context = with_tuning(tuning.clone());
        for (at, (width, height)) in [(64, 48), (150, 131)].into_iter().enumerate() {
            let (maps, view) = (maps(width, height), view(width, height, false));
            for shading in shadings() {
                let mut gpu = GpuEvaluator::with_maps(&context, &maps, &view, all_terms(), shading)
                    .expect("an evaluator");
                for lights in [1, 5] {
                    let seed = (at * 10 + lights) as u64;
                    check(&mut gpu, (&maps, &view), lights, &shading, seed);
                }
            }
        }
        assert_valid(&context);
    }
}

/// A slope that the picture's border cuts on three sides.
#[test]
fn outlines_end_at_the_picture_s_border() {
    let (width, height) = (70, 45);
    let maps = klieg_support::gpu::maps(width, height, |x, y| (x < 0.1 * y).then_some(0.3 * x));
    let (view, shading) = (view(width, height, false), Shading::default());
    let weights = Terms::named([("outline", 1.0)]).expect("a term");
    let objective = Objective { weights, background: Some(0.3), ..Objective::default() };
    let population = Population::of_records(2, records(5, 10)).expect("rigs");
    let outline = (0..maps.types.len()).filter(|&at| {
        maps.types[at] != PixelType::Background && cpu::appearance::is_outline(&maps, at)
    });
    assert!(outline.count() < 2 * height as usize, "a border counts");
    let expected = population
        .rigs()
        .map(|rig| cpu::fitness::fitness(&maps, &view, &objective, &shading, rig).score);
    let expected: Vec<_> = expected.collect();
    assert!(expected.iter().any(|score| (0.05..0.95).contains(score)), "{expected:?}");
    let measure = |evaluator: &mut dyn Evaluator| {
        let mut scores = vec![0.0; population.len()];
        evaluator.evaluate(&population, &mut scores).expect("scores");
        let mut pairs = scores.iter().zip(&expected);
        assert!(pairs.all(|(a, b)| (a - b).abs() < TOLERANCE), "{scores:?} {expected:?}");
    };
    measure(&mut CpuEvaluator::new(maps.clone(), &view, objective, shading).expect("maps"));
    for tuning in ways() {
        let context = with_tuning(tuning);
        measure(
            &mut GpuEvaluator::with_maps(&context, &maps, &view, objective, shading).expect("maps"),
        );
        assert_valid(&context);
    }
}

#[test]
fn devices_aim_at_the_mean_that_the_scene_asks_for() {
    let view = view(64, 48, false);
    let weights = Terms::named([("mean", 1.0)]).expect("a term");
    let objective = Objective { weights, mean_target: MeanTarget::Scene, ..Objective::default() };
    let context = with_tuning(ways().remove(0));
    let population = Population::of_records(2, records(3, 4)).expect("rigs");
    let mut targets = Vec::new();
    for base in [0.02, 0.3, 0.6, 1.0] {
        let mut maps = maps(64, 48);
        maps.surface.base_color.fill([base; 3]);
        maps.shape.base_luminance = base;
        let mut gpu = GpuEvaluator::with_maps(&context, &maps, &view, objective, shadings()[0])
            .expect("an evaluator");
        let mut scores = vec![0.0; population.len()];
        gpu.evaluate(&population, &mut scores).expect("scores");
        let target = MeanTarget::Scene.of(&maps.statistics());
        for (rig, score) in population.rigs().zip(scores) {
            let fixed = Objective { mean_target: MeanTarget::Value(target), ..objective };
            let expected = cpu::fitness::fitness(&maps, &view, &fixed, &shadings()[0], rig).score;
            assert!((score - expected).abs() < TOLERANCE, "base {base}: {score} {expected}");
        }
        targets.push(target);
    }
    assert!(targets.is_sorted_by(|a, b| a < b), "{targets:?}");
    assert_valid(&context);
}

#[test]
fn a_drawn_scene_is_measured_as_its_maps_are() {
    let path = klieg_support::root().join("scenes/still-life.glb");
    let scene = klieg::scene::load::load(&path).expect("a scene of the project");
    let view = View::new(&scene, scene.cameras[0].clone(), 96, 80).expect("a view");
    let forward = Tuning { pipeline: Some(PipelineKind::Forward), ..Tuning::default() };
    for tuning in ways().into_iter().chain([forward]) {
        let context = with_tuning(tuning);
        for shading in shadings() {
            let mut gpu = GpuEvaluator::new(&context, &scene, &view, all_terms(), shading)
                .expect("an evaluator");
            let maps = gpu.maps().expect("maps").clone();
            check(&mut gpu, (&maps, &view), 3, &shading, 9);
        }
        assert_valid(&context);
    }
}

#[test]
fn coloured_lights_are_judged_by_the_paper_too() {
    let (maps, view, shading) = (maps(64, 48), view(64, 48, false), Shading::default());
    let objective = Objective::default();
    let population = Population::of_records(2, records(4, 12)).expect("rigs");
    let expected: Vec<f32> = population
        .rigs()
        .map(|rig| cpu::fitness::fitness(&maps, &view, &objective, &shading, rig).score)
        .collect();
    let close = |scores: &[f32]| {
        let pairs = scores.iter().zip(&expected);
        pairs.for_each(|(a, b)| assert!((a - b).abs() < TOLERANCE, "{a} {b}"));
    };
    let mut scores = vec![0.0; population.len()];
    let mut native =
        CpuEvaluator::new(maps.clone(), &view, objective, shading).expect("an evaluator");
    native.evaluate(&population, &mut scores).expect("scores");
    close(&scores);
    let white: Vec<_> = population
        .records()
        .iter()
        .map(|&light| LightRecord { color: [1.0; 3], ..light })
        .collect();
    let white = Population::of_records(2, white).expect("rigs");
    for tuning in ways() {
        let context = with_tuning(tuning);
        let mut gpu = GpuEvaluator::with_maps(&context, &maps, &view, objective, shading)
            .expect("an evaluator");
        let mut before = vec![0.0; white.len()];
        gpu.evaluate(&white, &mut before).expect("scores");
        gpu.evaluate(&population, &mut scores).expect("scores");
        close(&scores);
        assert!(scores.iter().zip(&before).any(|(a, b)| (a - b).abs() > 1e-3));
        // What is plain keeps its bits after something in colour.
        let mut after = vec![0.0; white.len()];
        gpu.evaluate(&white, &mut after).expect("scores");
        assert_eq!(before, after);
        assert_valid(&context);
    }
}
