//! Pictures whose measures are known by hand.

use glam::{DMat4, DVec3};
use klieg::cpu::{self, CpuEvaluator, fitness, histogram, visibility};
use klieg::evaluate::{Evaluator, Inspection};
use klieg::lighting::genome::Boxes;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Role};
use klieg::math::color::{srgb_decode, srgb_encode};
use klieg::objective::maps::{Maps, PixelCounts, PixelType, Surface};
use klieg::objective::{HISTOGRAM_BINS, Objective, Terms};
use klieg::scene::view::View;
use klieg::scene::{Material, Scene};
use klieg::study::landscape::{self, Grid};
use klieg::study::{Subject, starts};
use klieg_support::shapes;
use shapes::{matt, orthographic, rectangle, scene, sphere};
use std::ops::ControlFlow;

/// The value of a term.
fn term(terms: &Terms, name: &str) -> f32 {
    terms.get(name).expect("one of the terms")
}

/// A directional light from the viewer.
fn headlight(diffuse: f32) -> Light {
    Light { kind: LightKind::DIRECTIONAL, diffuse, specular: 0.0, ..Light::default() }
}

fn maps(scene: &Scene, view: &View) -> Maps {
    cpu::maps(visibility::draw(scene, view), &Objective::default())
}

/// The plain stages' and the fast evaluator's measures.
fn inspect(scene: &Scene, view: &View, light: Light) -> [Inspection; 2] {
    let (maps, objective, shading) = (maps(scene, view), Objective::default(), Shading::default());
    let plain = fitness::fitness(&maps, view, &objective, &shading, &[light.record()]);
    let mut evaluator = CpuEvaluator::new(maps, view, objective, shading).expect("maps that fit");
    [plain, evaluator.inspect(&[light]).expect("one light")]
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

#[test]
fn a_plane_that_faces_viewer_and_light_is_one_even_tone() {
    let scene = scene([(rectangle(2.0, 2.0), matt(0.5), DMat4::IDENTITY)]);
    let view = orthographic(&scene, 1.0, 45, 31);
    let tone = srgb_encode(0.5 * (0.03 + 0.6));
    for found in inspect(&scene, &view, headlight(0.6)) {
        let statistics = &found.statistics;
        assert!(found.picture.iter().all(|&i| (i - tone).abs() < 1e-6));
        close(statistics.mean.into(), tone.into(), 1e-6);
        close(statistics.variance.into(), 0.0, 1e-12);
        close(statistics.gradient.into(), 0.0, 1e-6);
        let bin = (32.0 * tone) as usize;
        assert_eq!(statistics.histogram[bin], 45 * 31);
        close(term(&found.terms, "mean").into(), (f64::from(tone) - 0.5).abs() / 0.5, 1e-5);
        close(term(&found.terms, "var").into(), 1.0, 1e-4);
        assert_eq!(
            (term(&found.terms, "edge"), term(&found.terms, "grad"), term(&found.terms, "hist")),
            (0.0, 0.0, 1.0)
        );
    }
}

/// Seen along parallel rays, the share of a sphere's disc where `n·l < u` is `u²`.
#[test]
fn a_sphere_lit_by_the_viewer_has_the_moments_of_its_integral() {
    let scene = scene([(sphere(128), matt(0.8), DMat4::IDENTITY)]);
    let view = orthographic(&scene, 1.1, 301, 301);
    let (unlit, lit) = (0.03 * 0.8, 0.9 * 0.8);
    let brightness = |u: f64| f64::from(srgb_encode((unlit + lit * u) as f32));
    let steps = 100_000;
    let integral = |f: &dyn Fn(f64) -> f64| {
        let at = |k| (f64::from(k) + 0.5) / f64::from(steps);
        (0..steps).map(|k| f(at(k)) * 2.0 * at(k)).sum::<f64>() / f64::from(steps)
    };
    let mean = integral(&brightness);
    let variance = integral(&|u| (brightness(u) - mean).powi(2));
    for found in inspect(&scene, &view, headlight(0.9)) {
        close(found.statistics.mean.into(), mean, 1e-3);
        close(found.statistics.variance.into(), variance, 1e-3);
        let object: u32 = found.statistics.histogram.iter().sum();
        let radius = 301.0 / 2.2;
        close(object.into(), std::f64::consts::PI * radius * radius, 200.0);
        for (bin, &count) in found.statistics.histogram.iter().enumerate() {
            let share_below = |i: f64| {
                let u = (f64::from(srgb_decode(i as f32)) - unlit) / lit;
                u.clamp(0.0, 1.0).powi(2)
            };
            let (from, to) = (bin as f64 / 32.0, (bin + 1) as f64 / 32.0);
            let share = share_below(to) - share_below(from);
            close(f64::from(count) / f64::from(object), share, 3e-3);
        }
    }
}

/// Sobel/8 of a vertical step of height `a` is `a/2` in the two columns beside it. In the first and
/// the last row, whose outer taps take the centre's value, it is `(3, ±1)·a/8`.
#[test]
fn a_vertical_step_has_half_its_height_as_gradient() {
    let glowing = |light: f32| Material { emissive: [light; 3], ..matt(0.0) };
    let at = |x| DMat4::from_translation(DVec3::new(x, 0.0, 0.0));
    let scene = scene([
        (rectangle(2.0, 2.0), glowing(0.1), at(-2.0)),
        (rectangle(2.0, 2.0), glowing(0.6), at(2.0)),
    ]);
    let (width, height) = (40, 20);
    let view = orthographic(&scene, 1.0, width, height);
    let a = f64::from(srgb_encode(0.6) - srgb_encode(0.1));
    let sum = f64::from(2 * (height - 2)) * a / 2.0 + 4.0 * a * 10f64.sqrt() / 8.0;
    for found in inspect(&scene, &view, headlight(0.0)) {
        close(found.statistics.gradient.into(), sum / f64::from(width * height), 1e-6);
        close(found.statistics.variance.into(), a * a / 4.0, 1e-6);
        assert_eq!(found.statistics.histogram.iter().filter(|&&count| count > 0).count(), 2);
    }
}

/// A square before a plane, `step` scene radii nearer. Both sides of its outline have Sobel `step/2`
/// and Laplace `3·step/8`, its own corners `3√2·step/8` and `5·step/8`; a plane's pixel diagonally
/// off a corner has `√2·step/8` and `step/8`.
#[test]
fn edges_of_a_square_before_a_plane() {
    for (step, corners_are_edges) in [(0.1, false), (0.2, true), (0.03, false)] {
        let raised = DMat4::from_translation(DVec3::new(0.0, 0.0, step * 2f64.sqrt()));
        let scene = scene([
            (rectangle(1.0, 1.0), matt(0.5), DMat4::IDENTITY),
            (rectangle(0.5, 0.5), matt(0.5), raised),
        ]);
        let view = orthographic(&scene, 1.0, 32, 32);
        let maps = maps(&scene, &view);
        for (at, &kind) in maps.types.iter().enumerate() {
            let (x, y) = (at as i32 % 32, at as i32 / 32);
            // 1 in the square's outermost ring and in the plane's ring around it.
            let beside = |c: i32| (7..=24).contains(&c);
            let inner = |c: i32| (9..=22).contains(&c);
            let ring = beside(x) && beside(y) && !(inner(x) && inner(y));
            let corner = [7, 24].contains(&x) && [7, 24].contains(&y);
            let edge = ring && (!corner || corners_are_edges) && step > 0.06;
            let expected = if edge { PixelType::Edge } else { PixelType::Surface };
            assert_eq!(kind, expected, "step {step}, pixel {x}, {y}");
        }
        let rings = 18 * 18 - 14 * 14;
        let edges = if step < 0.06 { 0 } else { rings - if corners_are_edges { 0 } else { 4 } };
        assert_eq!(maps.counts, PixelCounts { surface: 32 * 32 - edges, edge: edges });
    }
}

#[test]
fn the_outline_before_the_background_is_an_edge_of_the_object_alone() {
    let scene = scene([(rectangle(1.0, 1.0), matt(0.5), DMat4::IDENTITY)]);
    let view = orthographic(&scene, 2.0, 32, 32);
    let maps = maps(&scene, &view);
    assert_eq!(maps.counts, PixelCounts { surface: 14 * 14, edge: 16 * 16 - 14 * 14 });
    assert_eq!(maps.visible, [1, 2]);
    let (object, background) = (maps.surface.depth[16 * 32 + 16], maps.surface.depth[0]);
    assert_eq!(background, object + 1.0);
}

/// A full picture of 64 columns whose brightness grows evenly.
#[test]
fn a_ramp_fills_the_histogram_evenly() {
    let (width, height) = (64, 10);
    let n = width as usize * height as usize;
    let maps = Maps {
        surface: Surface { width, height, code: vec![1; n], ..Surface::default() },
        types: vec![PixelType::Surface; n],
        counts: PixelCounts { surface: n as u32, edge: 0 },
        normal_detail: 1.0,
        ..Maps::default()
    };
    let slope = 1.0 / 64.0;
    let mut picture: Vec<f32> = (0..n).map(|at| ((at % 64) as f32 + 0.5) * slope).collect();
    assert_eq!(histogram::histogram(&maps, &picture), [n as u32 / 32; HISTOGRAM_BINS]);
    let objective = Objective::default();
    let measured = fitness::statistics(&maps, &picture, &objective);
    let terms = objective.terms(&measured, &maps.statistics());
    close(term(&terms, "hist").into(), 0.0, 1e-6); // the entropy of 32 equal shares is ln 32
    close(term(&terms, "mean").into(), 0.0, 1e-6);
    close(measured.variance.into(), (1.0 - 1.0 / (64.0 * 64.0)) / 12.0, 1e-6);
    // Half of the slope in the first and last column, three quarters in the first and last row, and
    // `(3, ±1)/8` of it in the corners.
    let slopes = 8.0 * (62.0 + 2.0 * 0.5) + 2.0 * 62.0 * 0.75 + 4.0 * 10f64.sqrt() / 8.0;
    close(measured.gradient.into(), f64::from(slope) * slopes / 640.0, 1e-6);
    picture[5] = 1.0;
    assert_ne!(histogram::histogram(&maps, &picture), [n as u32 / 32; HISTOGRAM_BINS]);
}

/// A ball looks the same from all sides: under a directional light, `F` depends on the angle between
/// light and viewer alone. It is worst near the front or the side, and best in between, where
/// light and shade both show.
#[test]
fn a_ball_is_best_lit_from_the_side() {
    let scene = scene([(sphere(64), matt(0.6), DMat4::IDENTITY)]);
    let view = orthographic(&scene, 1.2, 320, 320);
    let (maps, objective, shading) =
        (maps(&scene, &view), Objective::default(), Shading::default());
    let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading).expect("maps that fit");
    let kind = LightKind::DIRECTIONAL;
    let genome = starts::position_genome(Role::Key, kind, &Boxes::default()).expect("a genome");
    let mut subject = Subject { scene: &scene, view: &view, evaluator: &mut evaluator };
    let grid = Grid { columns: 31, rows: 16 };
    let observe = &mut |_| ControlFlow::Continue(());
    let landscape = landscape::run(&mut subject, &genome, grid, observe).expect("a landscape");

    let angle = |light: &Light| light.direction().z.acos().to_degrees();
    let mut by_angle: Vec<(f32, f32)> =
        landscape.lights.iter().map(angle).zip(landscape.scores()).collect();
    by_angle.sort_by(|a, b| a.0.total_cmp(&b.0));
    let far =
        |pair: &[(f32, f32)]| pair[1].0 - pair[0].0 < 0.1 && (pair[1].1 - pair[0].1).abs() > 0.01;
    assert!(!by_angle.windows(2).any(far));
    let best = angle(&landscape.lights[landscape.best()]);
    assert!((50.0..75.0).contains(&best), "{best}");
    let worst = angle(&landscape.lights[landscape.worst()]);
    assert!(!(15.0..75.0).contains(&worst), "{worst}");
}
