//! The pipelines of a generation against the CPU references, and against each other.

use figures::{instances, masked, normal_mapped, perspective, quads};
use klieg::evaluate::{Evaluator, Inspection};
use klieg::gpu::{ComputeShape, Context, GpuEvaluator, PipelineKind, Tuning};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind};
use klieg::objective::Objective;
use klieg::objective::maps::Maps;
use klieg::scene::Scene;
use klieg::scene::view::View;
use klieg_support::{figures, gpu as support, reference};
use reference::{difference, evaluate, evaluator, reference};
use std::sync::Arc;
use support::{assert_valid, ball, maps, population, rigs, view, with_tuning};

const TOLERANCE: f32 = 1e-4;

const LAYERED: (PipelineKind, Option<ComputeShape>) = (PipelineKind::Layered, None);
const FORWARD: (PipelineKind, Option<ComputeShape>) = (PipelineKind::Forward, None);
const RUNS: (PipelineKind, Option<ComputeShape>) =
    (PipelineKind::Compute, Some(ComputeShape::Runs));
const TILES: (PipelineKind, Option<ComputeShape>) =
    (PipelineKind::Compute, Some(ComputeShape::Tiles));
/// Those that need no scene.
const OF_MAPS: [(PipelineKind, Option<ComputeShape>); 3] = [LAYERED, RUNS, TILES];

fn context((pipeline, shape): (PipelineKind, Option<ComputeShape>)) -> Arc<Context> {
    with_tuning(Tuning { pipeline: Some(pipeline), shape, ..Default::default() })
}

fn of_scene(context: &Arc<Context>, scene: &Scene, view: &View) -> GpuEvaluator {
    GpuEvaluator::new(context, scene, view, Objective::default(), Shading::default())
        .expect("an evaluator")
}

/// Checks score and terms of every rig of a population.
fn check_all(evaluator: &mut GpuEvaluator, rigs: &[Vec<Light>], expected: &[Inspection]) {
    let made = evaluator.qualities(&population(rigs)).expect("qualities");
    assert_eq!(made.len(), expected.len());
    for (at, (a, b)) in made.iter().zip(expected).enumerate() {
        let far = difference(*a, b.quality());
        assert!(far < TOLERANCE, "{at}: {a:?} {:?}", b.terms);
    }
}

/// Checks score, terms, histogram and picture of a few rigs.
fn check(evaluator: &mut GpuEvaluator, maps: &Maps, view: &View, rigs: &[Vec<Light>], what: &str) {
    for rig in rigs {
        let made = evaluator.inspect(rig).expect("an inspection");
        let expected = reference(maps, view, rig);
        assert!(
            difference(made.quality(), expected.quality()) < TOLERANCE,
            "{what}: {made:?} {expected:?}"
        );
        assert_eq!(made.statistics.histogram.iter().sum::<u32>(), maps.counts.object(), "{what}");
        for (at, (a, b)) in made.picture.iter().zip(&expected.picture).enumerate() {
            assert!((a - b).abs() < 2e-3, "{what}, pixel {at}: {a} {b}");
        }
    }
}

/// Pictures of odd sizes: a ball, one pixel, all pixels, single rows and columns, nothing, and a
/// checkerboard, of whose pixels none has a neighbour beside it.
fn pictures() -> Vec<(&'static str, Maps)> {
    let flat = |_: f32, _: f32| Some(0.0);
    let dot = |x: f32, y: f32| (x.abs() < 0.02 && y.abs() < 0.02).then_some(0.0);
    let corner = |x: f32, y: f32| (x > 1.0 && y < -1.0).then_some(0.3 * x);
    let wave = |x: f32, y: f32| Some(0.3 * (7.0 * x).sin() * (5.0 * y).cos());
    let board = |x: f32, y: f32| {
        let cell = |v: f32| ((v + 1.1) / 2.2 * 37.0) as i32;
        ((cell(x) + cell(y)) % 2 == 0).then_some(0.1 * x)
    };
    let named = vec![
        ("ball", ball(97, 61)),
        ("tall ball", ball(31, 203)),
        ("full", maps(67, 35, wave)),
        ("flat", maps(51, 33, flat)),
        ("one pixel", maps(55, 55, dot)),
        ("corner", maps(70, 41, corner)),
        ("point", maps(1, 1, flat)),
        ("column", maps(1, 300, wave)),
        ("row", maps(300, 1, wave)),
        ("board", maps(37, 37, board)),
        ("nothing", maps(20, 20, |_, _| None)),
    ];
    assert_eq!(named[4].1.counts.object(), 1);
    assert_eq!(named[9].1.counts.object(), (37u32 * 37).div_ceil(2));
    named
}

#[test]
fn every_pipeline_agrees_with_the_references_on_odd_pictures() {
    for way in OF_MAPS {
        let context = context(way);
        for (seed, (name, maps)) in pictures().into_iter().enumerate() {
            let view = view(maps.surface.width, maps.surface.height, seed % 2 == 1);
            let mut evaluator = evaluator(&context, &maps, &view);
            let kind = [LightKind::POINT, LightKind::DIRECTIONAL][seed / 2 % 2];
            let rigs = rigs(seed as u64, 2, 2, kind);
            check(&mut evaluator, &maps, &view, &rigs, &format!("{way:?} {name}"));
        }
        assert_valid(&context);
    }
}

#[test]
fn every_pipeline_agrees_with_the_references_for_1_to_16_lights() {
    let (maps, view) = (ball(83, 59), view(83, 59, false));
    assert!(maps.counts.edge > 20 && maps.counts.surface > 20);
    for way in OF_MAPS {
        let context = context(way);
        let mut evaluator = evaluator(&context, &maps, &view);
        // Each number is a shader of its own, and long to compile for tiles on a software device.
        let numbers: &[usize] =
            if way == TILES { &[1, 2, 16] } else { &[1, 2, 3, 4, 5, 8, 11, 16] };
        for &lights in numbers {
            for kind in [LightKind::POINT, LightKind::DIRECTIONAL] {
                let rigs = rigs(lights as u64, 2, lights, kind);
                check(&mut evaluator, &maps, &view, &rigs, &format!("{way:?} {lights}"));
            }
        }
        assert_valid(&context);
    }
}

#[test]
fn every_pipeline_scores_populations_of_1_to_300() {
    let (maps, view) = (ball(45, 38), view(45, 38, false));
    let all = rigs(9, 300, 2, LightKind::POINT);
    let expected: Vec<_> = all.iter().map(|rig| reference(&maps, &view, rig)).collect();
    for (pipeline, shape) in OF_MAPS {
        let context = context((pipeline, shape));
        let mut at_once = evaluator(&context, &maps, &view);
        check_all(&mut at_once, &all, &expected);
        let scores = evaluate(&mut at_once, &all);
        for count in [1, 2, 3, 5, 30, 255] {
            assert_eq!(evaluate(&mut at_once, &all[..count]), scores[..count], "{count}");
        }
        assert_eq!(evaluate(&mut at_once, &all[7..8]), scores[7..8]);
        assert_valid(&context);

        // Room for a few pictures only: many chunks, the last of them smaller.
        let picture_memory = Some(45 * 38 * 4 * 11);
        let tuning =
            Tuning { pipeline: Some(pipeline), shape, picture_memory, ..Tuning::default() };
        let small = with_tuning(tuning);
        let mut in_chunks = evaluator(&small, &maps, &view);
        assert_eq!(evaluate(&mut in_chunks, &all), scores, "{pipeline} {shape:?}");
        assert_valid(&small);
    }
}

#[test]
fn scenes_look_the_same_in_every_pipeline() {
    let scenes = [
        ("quads", quads(), 121, 77),
        ("instances", instances(), 90, 101),
        ("normal mapped", normal_mapped(), 64, 64),
        ("masked", masked(), 75, 50),
    ];
    for way in [LAYERED, FORWARD, RUNS, TILES] {
        let context = context(way);
        for (name, scene, width, height) in &scenes {
            let view = perspective(scene, *width, *height);
            let mut evaluator = of_scene(&context, scene, &view);
            let maps = evaluator.maps().expect("maps").clone();
            assert!(maps.counts.edge > 0 && maps.counts.surface > 100);
            for (lights, kind) in [(1, LightKind::POINT), (2, LightKind::DIRECTIONAL)] {
                let rigs = rigs(lights as u64, 2, lights, kind);
                check(&mut evaluator, &maps, &view, &rigs, &format!("{way:?} {name}"));
            }
        }
        assert_valid(&context);
    }
}

#[test]
fn forward_gives_the_same_bits_in_any_number_of_draws() {
    let scene = instances();
    let view = perspective(&scene, 40, 33);
    let all = rigs(3, 37, 16, LightKind::POINT);
    let (pipeline, shape) = FORWARD;
    let whole = context(FORWARD);
    let mut at_once = of_scene(&whole, &scene, &view);
    let maps = at_once.maps().expect("maps").clone();
    let expected: Vec<_> = all.iter().map(|rig| reference(&maps, &view, rig)).collect();
    check_all(&mut at_once, &all, &expected);
    let scores = evaluate(&mut at_once, &all);
    let picture_memory = Some(40 * 33 * 8 * 5);
    let tuning = Tuning { pipeline: Some(pipeline), shape, picture_memory, ..Tuning::default() };
    let small = with_tuning(tuning);
    assert_eq!(evaluate(&mut of_scene(&small, &scene, &view), &all), scores);
    assert_valid(&whole);
    assert_valid(&small);
}

#[test]
fn forward_needs_a_scene() {
    let context = context(FORWARD);
    let (maps, view) = (ball(20, 10), view(20, 10, false));
    let (objective, shading) = (Objective::default(), Shading::default());
    let error = GpuEvaluator::with_maps(&context, &maps, &view, objective, shading).err();
    let error = error.expect("maps are not a scene");
    assert!(error.is_input() && error.to_string().contains("forward"), "{error}");
}

#[test]
fn one_pixel_and_one_light_are_noticed_by_every_pipeline() {
    let (maps, view) = (ball(40, 30), view(40, 30, false));
    let rig = rigs(3, 1, 2, LightKind::POINT).remove(0);
    let mut pixel = maps.clone();
    let center = 15 * 40 + 20;
    pixel.surface.base_color[center] = [0.0; 3];
    pixel.surface.emissive[center] = [0.0; 3];
    let mut light = rig.clone();
    light[1].azimuth += 0.1;
    for way in OF_MAPS {
        let context = context(way);
        let made = evaluator(&context, &maps, &view).inspect(&rig).expect("an inspection");
        assert!(difference(made.quality(), reference(&maps, &view, &rig).quality()) < TOLERANCE);
        assert!(difference(made.quality(), reference(&pixel, &view, &rig).quality()) > TOLERANCE);
        assert!(difference(made.quality(), reference(&maps, &view, &light).quality()) > TOLERANCE);
    }
}

#[test]
fn forward_notices_a_moved_polygon() {
    let context = context(FORWARD);
    let scene = quads();
    let view = perspective(&scene, 64, 48);
    let rig = rigs(3, 1, 2, LightKind::POINT).remove(0);
    let mut evaluator = of_scene(&context, &scene, &view);
    let maps = evaluator.maps().expect("maps").clone();
    let made = evaluator.inspect(&rig).expect("an inspection");
    let mut moved = scene.clone();
    moved.meshes[0].vertices[0].position[0] -= 0.2;
    let moved = of_scene(&context, &moved, &view).inspect(&rig).expect("an inspection");
    assert!(difference(made.quality(), reference(&maps, &view, &rig).quality()) < TOLERANCE);
    assert!(difference(moved.quality(), reference(&maps, &view, &rig).quality()) > TOLERANCE);
}

#[test]
fn no_pipeline_makes_anything_after_its_first_generation() {
    let scene = quads();
    let view = perspective(&scene, 70, 50);
    for (way, stems) in [
        (LAYERED, &["population", "histogram", "moments", "gradient", "fitness"][..]),
        (FORWARD, &["forward", "histogram", "moments", "gradient", "fitness"]),
        (RUNS, &["shading", "statistics", "fitness"]),
        (TILES, &["tiles", "fitness"]),
    ] {
        let context = context(way);
        let mut evaluator = of_scene(&context, &scene, &view);
        evaluate(&mut evaluator, &rigs(1, 30, 2, LightKind::POINT));
        for seed in 2..5 {
            let before = context.counters();
            evaluate(&mut evaluator, &rigs(seed, 30, 2, LightKind::POINT));
            let after = context.counters();
            assert_eq!(after.bytes_read - before.bytes_read, 4 * 30);
            let made = |c: klieg::gpu::Counters| (c.allocations, c.pipelines, c.descriptors);
            assert_eq!(made(after), made(before), "{way:?}");
        }
        // The counters do count.
        let before = context.counters();
        evaluate(&mut evaluator, &rigs(1, 31, 2, LightKind::POINT));
        assert_ne!(context.counters(), before);
        let run: Vec<_> = evaluator.timings().iter().map(|row| row.0).collect();
        assert_eq!(run, stems);
        assert_valid(&context);
    }
}

/// Set in the test's own copy of itself, whose vectors are wider. lavapipe can compile no draws for
/// those; and as its shader cache takes shaders of other widths for its own, the copy goes without.
const COPY: &str = "KLIEG_TEST_COPY";

#[test]
fn wider_subgroups_agree_too() {
    let (maps, view) = (ball(83, 59), view(83, 59, false));
    let all = rigs(4, 30, 2, LightKind::POINT);
    let expected: Vec<_> = all.iter().map(|rig| reference(&maps, &view, rig)).collect();
    if std::env::var_os(COPY).is_some() {
        for way in [RUNS, TILES] {
            let context = context(way);
            let mut evaluator = evaluator(&context, &maps, &view);
            check_all(&mut evaluator, &all, &expected);
            println!("{way:?} at {}", context.report().subgroup_size);
            assert_valid(&context);
        }
        return;
    }
    let software = context(RUNS).report().info.kind == "software";
    let output = std::process::Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", "wider_subgroups_agree_too", "--nocapture"])
        .env(COPY, "1")
        .env("LP_NATIVE_VECTOR_WIDTH", "512")
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .output()
        .expect("the test's own program");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(!software || said.matches("at 16").count() == 2, "{said}");
}
