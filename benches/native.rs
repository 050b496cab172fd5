//! The native evaluator's hot loops: `cargo bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat4, DVec3};
use klieg::cpu::{self, CpuEvaluator, visibility};
use klieg::evaluate::Evaluator;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Population, Role};
use klieg::objective::Objective;
use klieg::scene::Scene;
use klieg::scene::view::{Projection, View};
use klieg_support::shapes;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shapes::{camera, matt, scene, sphere, view};

const RIGS: usize = 30;

fn ball(rings: u32, size: u32) -> (Scene, View) {
    let scene = scene([(sphere(rings), matt(0.5), DMat4::IDENTITY)]);
    let camera = camera(DVec3::new(0.0, 0.0, 3.2), Projection::Perspective { yfov: 0.67 });
    let view = view(&scene, camera, size, size);
    (scene, view)
}

/// Random rigs of point lights in front of the scene.
fn population(lights: usize) -> Population {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut light = || Light {
        role: Role::Key,
        kind: LightKind::POINT,
        elevation: random.random_range(0.0..1.5),
        azimuth: random.random_range(-1.5..1.5),
        distance: random.random_range(1.5..5.0),
        diffuse: random.random_range(0.0..1.0),
        specular: random.random_range(0.0..1.0),
        ..Light::default()
    };
    let rigs: Vec<Vec<Light>> = (0..RIGS).map(|_| (0..lights).map(|_| light()).collect()).collect();
    Population::of(rigs.iter().map(Vec::as_slice)).expect("rigs of one length")
}

/// A generation at 512 x 512, in light-pixels a second.
fn generation(criterion: &mut Criterion) {
    let (scene, view) = ball(100, 512);
    let objective = Objective::default();
    let maps = cpu::maps(visibility::draw(&scene, &view), &objective);
    let pixels = u64::from(maps.counts.object()) * RIGS as u64;
    let mut evaluator = CpuEvaluator::new(maps, &view, objective, Shading::default()).unwrap();
    let mut group = criterion.benchmark_group("generation");
    for lights in [1, 4] {
        let population = population(lights);
        let mut scores = [0.0; RIGS];
        group.throughput(Throughput::Elements(pixels * lights as u64));
        group.bench_function(format!("{lights} lights"), |bencher| {
            bencher.iter(|| evaluator.evaluate(&population, &mut scores));
        });
    }
}

/// A million triangles at 1024 x 1024, and the maps of what is seen.
fn view_maps(criterion: &mut Criterion) {
    let (scene, view) = ball(500, 1024);
    let surface = visibility::draw(&scene, &view);
    let mut group = criterion.benchmark_group("view");
    group.throughput(Throughput::Elements(scene.polygons().into()));
    group.bench_function("visibility", |bencher| {
        bencher.iter(|| visibility::draw(&scene, &view));
    });
    group.bench_function("maps", |bencher| {
        bencher.iter(|| cpu::maps(surface.clone(), &Objective::default()));
    });
}

criterion_group! {
    name = native;
    config = Criterion::default().sample_size(20);
    targets = generation, view_maps
}
criterion_main!(native);
