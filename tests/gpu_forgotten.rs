//! Once a context has forgotten its device, every call on what was made there fails, and none reaches
//! memory or functions that may be gone.

use klieg_support::drawn;
use klieg_support::engine;
use klieg_support::gpu as support;
use klieg_support::shapes;

use ash::vk;
use drawn::{Drawn, SAMPLED};
use engine::{ALL, Engine, Texture};
use glam::{DMat4, DVec3};
use klieg::evaluate::Evaluator;
use klieg::gpu::{
    Context, EngineImage, GpuEvaluator, PictureEvaluator, ReadbackEvaluator, SurfaceEvaluator,
    Tuning,
};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Population};
use klieg::objective::Objective;
use klieg::scene::Scene;
use klieg::scene::engine::PictureFormat;
use klieg::scene::view::{Projection, View};
use klieg::{Error, Result};
use std::sync::Arc;
use support::{ball, population, rigs};

const SIZE: [u32; 2] = [24, 16];

fn settings() -> (Objective, Shading) {
    Default::default()
}

fn scene() -> (Scene, View) {
    let parts = [(shapes::rectangle(0.7, 0.7), shapes::matt(0.5), DMat4::IDENTITY)];
    let scene = shapes::scene(parts);
    let camera = shapes::camera(DVec3::Z * 4.0, Projection::Perspective { yfov: 0.6 });
    let view = shapes::view(&scene, camera, SIZE[0], SIZE[1]);
    (scene, view)
}

fn forgotten<T>(call: &str, result: Result<T>) {
    match result {
        Err(Error::Forgotten) => {}
        Err(error) => panic!("{call}: {error}"),
        Ok(_) => panic!("{call} worked"),
    }
}

/// What any evaluator can do.
fn all_forgotten(name: &str, evaluator: &mut dyn Evaluator, rigs: &[Vec<Light>]) {
    let population = population(rigs);
    let mut scores = vec![0.0; rigs.len()];
    forgotten(&format!("{name}::evaluate"), evaluator.evaluate(&population, &mut scores));
    let none = Population::new(2).expect("two lights");
    forgotten(&format!("{name}::evaluate of none"), evaluator.evaluate(&none, &mut []));
    forgotten(&format!("{name}::qualities"), evaluator.qualities(&population));
    forgotten(&format!("{name}::qualities of none"), evaluator.qualities(&none));
    forgotten(&format!("{name}::inspect"), evaluator.inspect(&rigs[0]));
}

/// Runs `body` on a context of a fresh engine, whose device stays until what `body` returns is dropped, so
/// that a call that should not be made does no harm.
fn on_a_device<T>(body: impl FnOnce(&Arc<Context>, &Engine) -> T) {
    let engine = Engine::unwatched(ALL);
    let context = engine.context(&Tuning::default());
    drop(body(&context, &engine));
    drop(context);
    engine.end();
}

#[test]
fn evaluators_of_scenes() {
    on_a_device(|context, _| {
        let ((scene, view), (objective, shading)) = (scene(), settings());
        let new = || GpuEvaluator::new(context, &scene, &view, objective, shading);
        let readback = || ReadbackEvaluator::new(context, &scene, &view, objective, shading);
        let rigs = rigs(5, 4, 2, LightKind::POINT);
        let (mut drawn, mut read) = (new().expect("one"), readback().expect("one"));
        let mut scores = [0.0; 4];
        drawn.evaluate(&population(&rigs), &mut scores).expect("scores");
        drawn.read_scores(&mut scores).expect("scores");
        read.evaluate(&population(&rigs), &mut scores).expect("scores");
        context.forget_device();
        all_forgotten("GpuEvaluator", &mut drawn, &rigs);
        forgotten("GpuEvaluator::maps", drawn.maps());
        forgotten("GpuEvaluator::read_scores", drawn.read_scores(&mut scores));
        forgotten("GpuEvaluator::read_scores of none", drawn.read_scores(&mut []));
        forgotten("GpuEvaluator::reserve", drawn.reserve(2, 2));
        forgotten("GpuEvaluator::new", new());
        all_forgotten("ReadbackEvaluator", &mut read, &rigs);
        assert!(read.maps().is_ok(), "its maps are known");
        forgotten("ReadbackEvaluator::new", readback());
        assert_eq!(context.memory_taken(), 0);
        (drawn, read)
    });
}

#[test]
fn evaluators_of_maps_and_surfaces() {
    on_a_device(|context, _| {
        let ((objective, shading), rigs) = (settings(), rigs(5, 4, 2, LightKind::POINT));
        let (maps, view) = (ball(SIZE[0], SIZE[1]), support::view(SIZE[0], SIZE[1], false));
        let known = || GpuEvaluator::with_maps(context, &maps, &view, objective, shading);
        let engines = || SurfaceEvaluator::new(context, SIZE, objective, shading);
        let (mut made, mut surface) = (known().expect("one"), engines().expect("one"));
        let mut scores = [0.0; 4];
        made.evaluate(&population(&rigs), &mut scores).expect("scores");
        surface.evaluator().evaluate(&population(&rigs), &mut scores).expect("scores");
        context.forget_device();
        all_forgotten("GpuEvaluator", &mut made, &rigs);
        assert!(made.maps().is_ok(), "its maps are known");
        forgotten("GpuEvaluator::with_maps", known());
        all_forgotten("SurfaceEvaluator", surface.evaluator(), &rigs);
        forgotten("SurfaceEvaluator::maps", surface.evaluator().maps());
        let read = surface.evaluator().read_scores(&mut scores);
        forgotten("SurfaceEvaluator::read_scores", read);
        forgotten("SurfaceEvaluator::new", engines());
        (made, surface)
    });
}

#[test]
fn evaluators_of_pictures() {
    on_a_device(|context, engine| {
        let (objective, _) = settings();
        let drawn = Drawn::new(engine, ball(SIZE[0], SIZE[1]));
        let new = || PictureEvaluator::new(context, SIZE, objective);
        let mut evaluator = new().expect("one");
        let texels = vec![0; 3 * 4 * (SIZE[0] * SIZE[1]) as usize];
        let array = Texture::new(engine, SIZE, (3, true), vk::Format::R32_SFLOAT, &texels);
        let image = EngineImage { view: array.view, layout: SAMPLED };
        let format = PictureFormat::default();
        // SAFETY: the images are the engine's, of this size, and outlive what is recorded.
        let pictures = unsafe {
            evaluator.look(&drawn.surface(&evaluator), &Drawn::camera()).expect("a view");
            evaluator.import_pictures(image, 3, format).expect("pictures")
        };
        let mut scores = [0.0; 3];
        evaluator.evaluate(&pictures, 3, &mut scores).expect("scores");
        context.forget_device();
        forgotten("evaluate", evaluator.evaluate(&pictures, 3, &mut scores));
        forgotten("evaluate of none", evaluator.evaluate(&pictures, 0, &mut []));
        forgotten("qualities", evaluator.qualities(&pictures, 3));
        forgotten("inspect", evaluator.inspect(&pictures, 1));
        forgotten("maps", evaluator.maps());
        forgotten("read_scores", evaluator.read_scores(&mut scores));
        forgotten("reserve", evaluator.reserve(1));
        forgotten("new", new());
    });
}
