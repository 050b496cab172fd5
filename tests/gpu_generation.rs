//! A generation on the device against the CPU references, on maps made in the test.

use klieg::cpu::CpuEvaluator;
use klieg::evaluate::Evaluator;
use klieg::gpu::{ComputeShape, GpuEvaluator, PipelineKind, Tuning};
use klieg::lighting::shading::Shading;
use klieg::lighting::{LightKind, Population};
use klieg::objective::Objective;
use klieg::objective::maps::Maps;
use klieg::scene::view::View;
use klieg_support::{gpu as support, reference};
use reference::{difference, evaluate, evaluator, reference};
use support::{assert_valid, ball, context, maps, population, rigs, view, with_tuning};

const TOLERANCE: f32 = 1e-4;

#[test]
fn terms_are_those_of_the_references() {
    let context = context();
    for (width, height, orthographic) in [(97, 61, false), (64, 64, true), (130, 301, false)] {
        let (maps, view) = (ball(width, height), view(width, height, orthographic));
        assert!(maps.counts.edge > 20 && maps.counts.surface > 20);
        let mut evaluator = evaluator(&context, &maps, &view);
        for (lights, kind) in [
            (1, LightKind::POINT),
            (2, LightKind::DIRECTIONAL),
            (3, LightKind::POINT),
            (4, LightKind::POINT),
            (16, LightKind::DIRECTIONAL),
        ] {
            for rig in rigs(lights as u64, 4, lights, kind) {
                let made = evaluator.inspect(&rig).expect("an inspection");
                let expected = reference(&maps, &view, &rig);
                let far = difference(made.quality(), expected.quality());
                assert!(far < TOLERANCE, "{width}x{height} {lights}: {made:?} {expected:?}");
                for (at, (a, b)) in made.picture.iter().zip(&expected.picture).enumerate() {
                    assert!((a - b).abs() < 2e-3, "pixel {at}: {a} {b}");
                }
            }
        }
    }
    assert_valid(&context);
}

#[test]
fn qualities_are_the_scores_and_terms_of_each_rig() {
    let context = context();
    let (maps, view) = (ball(33, 21), view(33, 21, false));
    let mut evaluator = evaluator(&context, &maps, &view);
    let all = rigs(8, 41, 2, LightKind::POINT);
    let scores = evaluate(&mut evaluator, &all);
    let qualities = evaluator.qualities(&population(&all)).expect("qualities");
    assert_eq!(qualities.iter().map(|q| q.score).collect::<Vec<_>>(), scores);
    for (rig, quality) in all.iter().zip(&qualities) {
        assert_eq!(evaluator.inspect(rig).expect("an inspection").quality(), *quality);
    }
    let none = Population::new(2).expect("two lights");
    assert!(evaluator.qualities(&none).expect("no work").is_empty());
    assert_valid(&context);
}

#[test]
fn one_pixel_and_one_light_are_noticed() {
    let context = context();
    let (maps, view) = (ball(40, 30), view(40, 30, false));
    let rig = rigs(3, 1, 2, LightKind::POINT).remove(0);
    let made = evaluator(&context, &maps, &view).inspect(&rig).expect("an inspection");
    assert!(difference(made.quality(), reference(&maps, &view, &rig).quality()) < TOLERANCE);

    let mut pixel = maps.clone();
    let center = 15 * 40 + 20;
    pixel.surface.base_color[center] = [0.0; 3];
    pixel.surface.emissive[center] = [0.0; 3];
    assert!(difference(made.quality(), reference(&pixel, &view, &rig).quality()) > TOLERANCE);

    let mut light = rig.clone();
    light[1].azimuth += 0.1;
    assert!(difference(made.quality(), reference(&maps, &view, &light).quality()) > TOLERANCE);
    assert_valid(&context);
}

#[test]
fn unusual_pictures() {
    let context = context();
    let flat = |_: f32, _: f32| Some(0.0);
    let dot = |x: f32, y: f32| (x.abs() < 0.02 && y.abs() < 0.02).then_some(0.0);
    let nothing = |_: f32, _: f32| None;
    let cases = [
        maps(51, 33, flat),
        maps(55, 55, dot),
        maps(1, 1, flat),
        maps(1, 300, flat),
        maps(300, 1, flat),
        maps(20, 20, nothing),
    ];
    assert_eq!(cases[1].counts.object(), 1);
    for maps in cases {
        let view = view(maps.surface.width, maps.surface.height, false);
        let mut evaluator = evaluator(&context, &maps, &view);
        for rig in rigs(11, 3, 2, LightKind::POINT) {
            let made = evaluator.inspect(&rig).expect("an inspection");
            let expected = reference(&maps, &view, &rig);
            assert!(
                difference(made.quality(), expected.quality()) < TOLERANCE,
                "{made:?} {expected:?}"
            );
            assert_eq!(made.statistics.histogram.iter().sum::<u32>(), maps.counts.object());
        }
    }
    assert_valid(&context);
}

#[test]
fn an_even_picture_has_no_variance_at_all() {
    let context = context();
    let mut maps = maps(200, 150, |_, _| Some(0.0));
    let n = maps.types.len();
    maps.surface.base_color = vec![[0.6, 0.5, 0.4]; n];
    maps.surface.metallic = vec![0.0; n];
    maps.surface.emissive = vec![[0.1; 3]; n];
    let mut rig = rigs(5, 1, 1, LightKind::DIRECTIONAL).remove(0);
    rig[0].specular = 0.0;
    let view = view(200, 150, true);
    let made = evaluator(&context, &maps, &view).inspect(&rig).expect("an inspection");
    assert_eq!((made.statistics.variance, made.statistics.gradient), (0.0, 0.0));
    assert_eq!(made.terms.get("hist"), Some(1.0));
    assert_valid(&context);
}

#[test]
fn populations_of_any_size_give_the_same_bits_in_any_number_of_draws() {
    let (width, height) = (45, 38);
    let (maps, view) = (ball(width, height), view(width, height, false));
    let all = rigs(9, 300, 3, LightKind::POINT);
    let whole = context();
    let mut one_draw = evaluator(&whole, &maps, &view);
    let expected = evaluate(&mut one_draw, &all);
    let first = reference(&maps, &view, &all[299]).score;
    assert!((expected[299] - first).abs() < TOLERANCE);
    assert_eq!(evaluate(&mut one_draw, &all), expected);
    assert_eq!(evaluate(&mut one_draw, &all[..30]), expected[..30]);
    assert_eq!(evaluate(&mut one_draw, &all[7..8]), expected[7..8]);

    // Room for seven pictures: 43 draws, the last of 6.
    let picture_memory = Some(u64::from(width * height * 4 * 7));
    let small = with_tuning(Tuning { picture_memory, ..Default::default() });
    let mut many_draws = evaluator(&small, &maps, &view);
    assert_eq!(evaluate(&mut many_draws, &all), expected);
    assert_valid(&whole);
    assert_valid(&small);
}

#[test]
fn a_population_beyond_the_layer_limit() {
    let pipeline = Some(PipelineKind::Layered);
    let context = with_tuning(Tuning { pipeline, ..Default::default() });
    let (maps, view) = (ball(9, 7), view(9, 7, false));
    let layers = context.report().max_layers as usize;
    let all = rigs(2, layers + 5, 1, LightKind::DIRECTIONAL);
    let mut evaluator = evaluator(&context, &maps, &view);
    let scores = evaluate(&mut evaluator, &all);
    for at in [0, layers - 1, layers, layers + 4] {
        assert!((scores[at] - reference(&maps, &view, &all[at]).score).abs() < TOLERANCE, "{at}");
    }
    assert_valid(&context);
}

#[test]
fn a_generation_reads_four_bytes_an_individual_and_makes_nothing() {
    let context = context();
    let (maps, view) = (ball(70, 50), view(70, 50, false));
    let mut evaluator = evaluator(&context, &maps, &view);
    evaluate(&mut evaluator, &rigs(1, 30, 2, LightKind::POINT));
    for seed in 2..5 {
        let before = context.counters();
        evaluate(&mut evaluator, &rigs(seed, 30, 2, LightKind::POINT));
        let after = context.counters();
        assert_eq!(after.bytes_read - before.bytes_read, 4 * 30);
        assert_eq!(
            (after.allocations, after.pipelines, after.descriptors),
            (before.allocations, before.pipelines, before.descriptors)
        );
    }
    // The counters do count.
    let before = context.counters();
    evaluate(&mut evaluator, &rigs(1, 31, 3, LightKind::POINT));
    let after = context.counters();
    assert!(after.allocations > before.allocations && after.pipelines > before.pipelines);
    assert!(after.descriptors > before.descriptors);
    let stems: Vec<_> = evaluator.timings().iter().map(|row| row.0).collect();
    let stages: &[_] = match context.report().shape {
        ComputeShape::Runs => &["shading", "statistics", "fitness"],
        ComputeShape::Tiles => &["tiles", "fitness"],
    };
    assert_eq!(stems, stages);
    assert_valid(&context);
}

#[test]
fn more_individuals_than_the_buffers_hold_are_refused() {
    let context = context();
    let (maps, view) = (ball(4, 4), view(4, 4, false));
    let mut evaluator = evaluator(&context, &maps, &view);
    // No buffer of Vulkan's has the 656 GiB of their details.
    let error = evaluator.reserve(u32::MAX, 1).expect_err("too many");
    assert!(error.is_input() && error.to_string().contains("4294967295"), "{error}");
    let rig = rigs(1, 1, 1, LightKind::POINT).remove(0);
    assert_eq!(evaluate(&mut evaluator, std::slice::from_ref(&rig)).len(), 1);
    assert_valid(&context);
}

#[test]
fn maps_and_views_that_do_not_fit_are_refused() {
    let context = context();
    let (maps, view) = (ball(20, 10), view(20, 10, false));
    let refused = |maps: &Maps, view: &View, part: &str| {
        let (objective, shading) = (Objective::default(), Shading::default());
        let on_gpu = GpuEvaluator::with_maps(&context, maps, view, objective, shading).map(drop);
        let on_cpu = CpuEvaluator::new(maps.clone(), view, objective, shading).map(drop);
        for error in [on_gpu, on_cpu] {
            let error = error.expect_err(part);
            assert!(error.is_input() && error.to_string().contains(part), "{error}");
        }
    };
    let mut short = maps.clone();
    short.types.truncate(100);
    refused(&short, &view, "types has 100 entries for 20x10");
    let mut short = maps.clone();
    short.surface.normal.truncate(100);
    refused(&short, &view, "normal has 100 entries");
    let mut low = maps.clone();
    low.counts.surface = 1;
    refused(&low, &view, "surface: 1");
    let mut endless = view.clone();
    endless.eye.x = f32::INFINITY;
    refused(&maps, &endless, "a finite eye");
    assert_valid(&context);
}

#[test]
fn nothing_to_do_and_wrong_arguments() {
    let context = context();
    let (maps, wide) = (ball(20, 10), view(20, 10, false));
    let mut evaluator = evaluator(&context, &maps, &wide);
    let none = Population::new(2).expect("two lights");
    evaluator.evaluate(&none, &mut []).expect("no work");
    let error = evaluator.evaluate(&none, &mut [0.0]).expect_err("a place too many");
    assert!(error.is_input(), "{error}");
    let other = view(10, 20, false);
    let (objective, shading) = (Objective::default(), Shading::default());
    let error = GpuEvaluator::with_maps(&context, &maps, &other, objective, shading);
    assert!(error.is_err_and(|error| error.is_input()));
    assert_valid(&context);
}
