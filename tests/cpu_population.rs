//! The native evaluator over populations of all sizes, and what larger work may cost it.

use glam::DMat4;
use klieg::cpu::{self, visibility};
use klieg::evaluate::Evaluator;
use klieg::lighting::{Light, Population};
use klieg_support::{shapes, surfaces};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shapes::{matt, orthographic, scene, sphere};
use std::time::Instant;
use surfaces::{Bench, TOLERANCE, rig, surface, worst};

fn population(rigs: &[Vec<Light>]) -> Population {
    Population::of(rigs.iter().map(Vec::as_slice)).expect("rigs of one length")
}

#[test]
fn random_objects_agree_with_the_plain_stages() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(21);
    for case in 0..24u32 {
        let (width, height) = (random.random_range(1..90), random.random_range(1..70));
        let share = [0.0, 0.02, 0.5, 0.98, 1.0][case as usize % 5];
        let hit: Vec<bool> = (0..width * height).map(|_| random.random_bool(share)).collect();
        let surface = surface(width, height, |x, y| hit[(y * width + x) as usize]);
        let maps = cpu::maps(surface, &bench.objective);
        let lights = 1 + case as usize % 16;
        let rig = rig(&mut random, lights, 2.0 / lights as f32);
        let difference = bench.difference(&maps, &rig);
        assert!(difference < TOLERANCE, "{difference}: {width}x{height}, {lights} lights, {share}");
    }
}

#[test]
fn one_pixel_anywhere_is_an_object() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(22);
    let rig = rig(&mut random, 3, 0.6);
    for at in [(0, 0), (16, 0), (0, 10), (16, 10), (7, 4)] {
        let maps = cpu::maps(surface(17, 11, |x, y| (x, y) == at), &bench.objective);
        assert_eq!(maps.counts.object(), 1);
        assert!(bench.difference(&maps, &rig) < TOLERANCE, "{at:?}");
    }
}

#[test]
fn populations_of_any_size_have_the_qualities_of_their_rigs() {
    let bench = Bench::new();
    let maps = cpu::maps(surface(203, 151, |x, y| x + y > 9), &bench.objective);
    let mut evaluator = bench.evaluator(&maps);
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let rigs: Vec<_> = (0..300).map(|_| rig(&mut random, 2, 1.0)).collect();
    let single: Vec<_> =
        rigs.iter().map(|rig| evaluator.inspect(rig).expect("two lights").quality()).collect();
    for n in [1, 2, 7, 8, 9, 30, 31, 300] {
        let qualities = evaluator.qualities(&population(&rigs[..n])).expect("qualities");
        assert_eq!(qualities, single[..n], "{n}");
    }
    for at in [0, 150, 299] {
        let plain = bench.plain(&maps, &rigs[at]);
        assert!(worst(&single[at].terms, &plain) < TOLERANCE);
        assert!(worst(&single[at].terms, &bench.plain(&maps, &rigs[at ^ 1])) > TOLERANCE);
    }
}

/// The least of three times, in seconds.
fn least(mut work: impl FnMut()) -> f64 {
    let mut time = || {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..3).map(|_| time()).fold(f64::INFINITY, f64::min)
}

/// Eight times the work may take four times eight times as long, on a machine that does other things
/// too; quadratic growth would take 64 times as long.
fn assert_grows_in_proportion(what: &str, small: f64, large: f64) {
    assert!(large < 32.0 * small.max(1e-3), "{what}: {small} s grew to {large} s");
}

#[test]
fn time_grows_in_proportion_to_the_rigs() {
    let bench = Bench::new();
    let maps = cpu::maps(surface(120, 120, |_, _| true), &bench.objective);
    let mut evaluator = bench.evaluator(&maps);
    let mut random = ChaCha8Rng::seed_from_u64(24);
    let rigs: Vec<_> = (0..400).map(|_| rig(&mut random, 4, 0.5)).collect();
    let [small, large] = [50, 400].map(|n| {
        let population = population(&rigs[..n]);
        let mut scores = vec![0.0; n];
        least(|| evaluator.evaluate(&population, &mut scores).expect("scores"))
    });
    assert_grows_in_proportion("rigs", small, large);
}

#[test]
fn time_grows_in_proportion_to_the_triangles_and_the_instances() {
    let spheres = |rings: u32, count: u32| {
        let mut scene = scene([(sphere(rings), matt(0.5), DMat4::IDENTITY)]);
        for k in 1..count {
            let mut next = scene.instances[0].clone();
            next.first_polygon = 1 + k * scene.meshes[0].triangles();
            next.world = DMat4::from_translation(0.01 * glam::DVec3::splat(f64::from(k)));
            scene.instances.push(next);
        }
        let view = orthographic(&scene, 2.0, 64, 64);
        least(|| assert!(visibility::draw(&scene, &view).code.iter().any(|&code| code != 0)))
    };
    // 2·96·2·96 and eight times as many triangles.
    assert_grows_in_proportion("triangles", spheres(96, 1), spheres(272, 1));
    assert_grows_in_proportion("instances", spheres(16, 100), spheres(16, 800));
}

#[test]
fn the_guard_sees_quadratic_growth() {
    let quadratic = std::panic::catch_unwind(|| assert_grows_in_proportion("", 0.01, 0.64));
    assert!(quadratic.is_err());
}
