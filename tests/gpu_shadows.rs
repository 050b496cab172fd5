//! The shadow table that a device makes, and pictures with shadows, against the CPU references.

use figures::{perspective, shadowed};
use klieg::cpu;
use klieg::evaluate::Evaluator;
use klieg::gpu::{ComputeShape, Context, GpuEvaluator, PipelineKind, ShadowMaker, Tuning};
use klieg::lighting::shading::{Brdf, Shading};
use klieg::lighting::{Cone, Light, LightKind};
use klieg::objective::maps::Maps;
use klieg::objective::shadows::{ShadowSettings, Shadows};
use klieg::objective::{Objective, Terms};
use klieg::scene::Scene;
use klieg::scene::occluders::Occluders;
use klieg::scene::view::View;
use klieg_support::{figures, gpu as support, reference};
use std::sync::Arc;
use support::{assert_valid, with_tuning};

/// Share of the bits that must be the same: rays that graze an edge may meet it or not.
const SAME: f64 = 0.9995;

fn settings_of(side: u32) -> ShadowSettings {
    ShadowSettings { on: true, side, ..ShadowSettings::default() }
}

fn made_by(maker: ShadowMaker) -> Arc<Context> {
    with_tuning(Tuning { shadow_maker: Some(maker), ..Tuning::default() })
}

fn maps(context: &Arc<Context>, scene: &Scene, view: &View, side: u32) -> Maps {
    let settings = (settings_of(side), (Objective::default(), Shading::default()));
    let mut evaluator =
        GpuEvaluator::with_shadows(context, scene, view, settings.1, &settings.0).unwrap();
    evaluator.maps().unwrap().clone()
}

/// Share of the bits that two tables have in common.
fn same_bits(a: &Shadows, b: &Shadows) -> f64 {
    assert_eq!((a.side(), a.pixels()), (b.side(), b.pixels()));
    let (mut same, mut all) = (0u64, 0u64);
    for number in 0..a.pixels() {
        for (y, x) in (0..a.side()).flat_map(|y| (0..a.side()).map(move |x| (y, x))) {
            same += u64::from(a.bit(number, [x, y]) == b.bit(number, [x, y]));
            all += 1;
        }
    }
    same as f64 / all as f64
}

/// Compares the device's table with the reference's of the same surface.
fn compare(context: &Arc<Context>, name: &str, scene: &Scene, view: &View, side: u32) {
    let maps = maps(context, scene, view, side);
    let occluders = Arc::new(Occluders::new(scene, view).unwrap());
    let reference = cpu::shadows::reference(&maps.surface, occluders, side);
    let made = maps.shadows.as_ref().expect("a table");
    let same = same_bits(made, &reference);
    let lit = made.openness().iter().sum::<f32>() / made.pixels() as f32;
    println!("{name}: {same} of {} pixels, openness {lit}", made.pixels());
    assert!(same >= SAME, "{name}: {same}");
    assert!((0.2..0.99).contains(&lit), "{name}: {lit}");
    let far = |(a, b): (&f32, &f32)| (a - b).abs();
    let far = made.openness().iter().zip(reference.openness()).map(far).fold(0.0, f32::max);
    assert!(far < 0.02, "{name}: {far}");
    assert_valid(context);
}

fn project_scene(name: &str) -> Scene {
    let path = klieg_support::root().join(format!("scenes/{name}.glb"));
    klieg::scene::load::load(&path).unwrap()
}

#[test]
fn the_device_makes_the_table_of_the_reference() {
    let context = made_by(ShadowMaker::Device);
    let scene = shadowed();
    // Of one word a row, of two, and of the fewest bits.
    for (side, [width, height]) in [(31, [40, 30]), (33, [31, 20]), (3, [80, 60])] {
        compare(&context, "shadowed", &scene, &perspective(&scene, width, height), side);
    }
}

#[test]
fn project_scenes_have_the_table_of_the_reference() {
    let context = made_by(ShadowMaker::Device);
    for name in ["elephant", "pair", "still-life"] {
        let scene = project_scene(name);
        let view = View::new(&scene, scene.cameras[0].clone(), 48, 36).unwrap();
        compare(&context, name, &scene, &view, 15);
    }
}

#[test]
fn host_and_device_make_the_same_table() {
    let scene = shadowed();
    let view = perspective(&scene, 44, 33);
    let [host, device] = [ShadowMaker::Host, ShadowMaker::Device].map(|maker| {
        let context = made_by(maker);
        let maps = maps(&context, &scene, &view, 31);
        assert_valid(&context);
        maps
    });
    let (host, device) = (host.shadows.unwrap(), device.shadows.unwrap());
    assert!(same_bits(&host, &device) >= SAME);
}

const WAYS: [(PipelineKind, Option<ComputeShape>); 4] = [
    (PipelineKind::Layered, None),
    (PipelineKind::Forward, None),
    (PipelineKind::Compute, Some(ComputeShape::Runs)),
    (PipelineKind::Compute, Some(ComputeShape::Tiles)),
];

/// Two terms that read what lights do, beside the paper's.
fn objective() -> Objective {
    let weights = Objective::default().weights;
    let mut named: Vec<_> = weights.iter().map(|(term, weight)| (term.name, weight)).collect();
    named.extend([("unlit", 0.1), ("burnt", 0.1)]);
    Objective { weights: Terms::named(named).unwrap(), ..Objective::default() }
}

/// A rig whose pictures differ with and without shadows: two lights outside of the scene, and with `near` one
/// within it.
fn rig(seed: u64, near: bool) -> Vec<Light> {
    let mut rig =
        support::rigs(seed, 1, 2, [LightKind::POINT, LightKind::DIRECTIONAL][seed as usize % 2])
            .remove(0);
    if near {
        let kind = [LightKind::SPOT, LightKind::POINT][seed as usize % 2];
        rig[1] = Light { kind, distance: 0.8, diffuse: 0.7, ..rig[1] };
        rig[1].cone = Cone { inner: 0.8, outer: 1.2 };
    }
    rig
}

/// Checks scores, terms and pictures of some rigs against the references: in at most so many pixels a ray
/// that grazes an edge may meet it on one side alone.
fn check(
    evaluator: &mut GpuEvaluator,
    view: &View,
    shading: Shading,
    rigs: &[Vec<Light>],
    (what, most_other): (&str, usize),
) {
    let maps = evaluator.maps().unwrap().clone();
    let without = Maps { shadows: None, ..maps.clone() };
    for rig in rigs {
        let records: Vec<_> = rig.iter().map(Light::record).collect();
        let made = evaluator.inspect(rig).unwrap();
        let expected = cpu::fitness::fitness(&maps, view, &objective(), &shading, &records);
        let far = reference::difference(made.quality(), expected.quality());
        let plain = cpu::fitness::fitness(&without, view, &objective(), &shading, &records);
        println!("{what}: {far:e} {} {}", expected.score, plain.score);
        assert_ne!(expected.picture, plain.picture, "{what}: no shadow falls");
        let pixels = made.picture.iter().zip(&expected.picture);
        let other = pixels.filter(|(a, b)| (*a - *b).abs() >= 2e-3).count();
        assert!(other <= most_other, "{what}: {other} pixels");
        let most = if other == 0 { 1e-4 } else { 1e-3 };
        assert!(far < most, "{what}: {:?} {:?}", made.terms, expected.terms);
    }
}

#[test]
fn every_pipeline_shades_with_the_table_and_with_near_lights() {
    let scene = shadowed();
    let view = perspective(&scene, 70, 50);
    for (pipeline, shape) in WAYS {
        let tuning = Tuning { pipeline: Some(pipeline), shape, ..Tuning::default() };
        let context = with_tuning(tuning);
        for brdf in [Brdf::BlinnPhong, Brdf::Gltf] {
            let shading = Shading { brdf, ..Shading::default() };
            let settings = (objective(), shading);
            let mut evaluator =
                GpuEvaluator::with_shadows(&context, &scene, &view, settings, &settings_of(31))
                    .unwrap();
            for near in [false, true] {
                let rigs = [rig(1, near), rig(2, near)];
                let what = format!("{pipeline} {shape:?} {brdf:?} near {near}");
                check(&mut evaluator, &view, shading, &rigs, (&what, if near { 3 } else { 0 }));
            }
        }
        assert_valid(&context);
    }
}

#[test]
fn maps_that_are_known_bring_their_shadows() {
    let scene = shadowed();
    let view = perspective(&scene, 52, 41);
    let context = with_tuning(Tuning::default());
    let settings = (objective(), Shading::default());
    let mut drawn =
        GpuEvaluator::with_shadows(&context, &scene, &view, settings, &settings_of(31)).unwrap();
    let maps = drawn.maps().unwrap().clone();
    let mut known =
        GpuEvaluator::with_maps(&context, &maps, &view, settings.0, settings.1).unwrap();
    let without = Maps { shadows: None, ..maps };
    let mut plain =
        GpuEvaluator::with_maps(&context, &without, &view, settings.0, settings.1).unwrap();
    for near in [false, true] {
        let population = support::population(&[rig(3, near), rig(4, near)]);
        let [mut a, mut b, mut c] = [[0.0; 2]; 3];
        drawn.evaluate(&population, &mut a).unwrap();
        known.evaluate(&population, &mut b).unwrap();
        plain.evaluate(&population, &mut c).unwrap();
        for k in 0..2 {
            assert!((a[k] - b[k]).abs() < 1e-5 && (a[k] - c[k]).abs() > 1e-3, "{a:?} {b:?} {c:?}");
        }
    }
    assert_valid(&context);
}

#[test]
fn settings_out_of_their_range_are_refused() {
    let scene = shadowed();
    let view = perspective(&scene, 8, 8);
    let context = with_tuning(Tuning::default());
    for (side, memory) in [(30, 1), (65, 1), (31, 0)] {
        let wrong = ShadowSettings { on: true, side, memory };
        let settings = (objective(), Shading::default());
        let made = GpuEvaluator::with_shadows(&context, &scene, &view, settings, &wrong);
        assert!(made.is_err_and(|error| error.is_input()), "{side} {memory}");
    }
}
