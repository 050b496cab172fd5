//! A kind of light that another crate adds: a lamp under a ceiling, as `docs/EXTENDING.md` shows it.

use glam::{DMat4, DVec3};
use klieg::cpu::{self, CpuEvaluator, fitness, visibility};
use klieg::design;
use klieg::lighting::genome::{Boxes, Genome};
use klieg::lighting::kinds::alleles::{AZIMUTH, DIFFUSE, SPECULAR};
use klieg::lighting::kinds::{Allele, KINDS, Kind};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, LightRecord, Role};
use klieg::objective::Objective;
use klieg::optimize::{Genetic, GeneticSettings};
use klieg::scene::view::Projection;
use klieg_support::shapes;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

/// Height of the ceiling above the scene's centre, scene radii.
const HEIGHT: f32 = 1.6;

/// Distance from the axis through the scene's centre; it decides elevation and distance.
const GROUND: Allele = Allele {
    name: "ground distance",
    range: |space| Some(space.distance),
    get: |light| light.distance * light.elevation.cos(),
    set: |light, ground| {
        light.elevation = HEIGHT.atan2(ground);
        light.distance = HEIGHT.hypot(ground);
    },
    turns: false,
    relation: |_| None,
};

static CEILING: Kind = Kind {
    name: "ceiling",
    meaning: "Lamps under a ceiling",
    parallel: false,
    cone: false,
    alleles: &[AZIMUTH, GROUND, DIFFUSE, SPECULAR],
};

fn genome(roles: &[Role]) -> Genome {
    Genome::new(roles, LightKind::new(&CEILING), &Boxes::default()).expect("a genome")
}

#[test]
fn a_kind_of_one_s_own_has_a_genome() {
    let genome = genome(&[Role::Key, Role::Fill]);
    assert_eq!(genome.bounds().len(), 8);
    let chromosome = [0.5, 2.0, 1.5, 0.25, -1.0, 4.0, 0.5, 0.75];
    let rig = genome.decode(&chromosome);
    for light in &rig {
        assert!((light.direction().y * light.distance - HEIGHT).abs() < 1e-5, "{light:?}");
    }
    let again = genome.encode(&rig);
    assert!(again.iter().zip(chromosome).all(|(a, b)| (a - b).abs() < 1e-5), "{again:?}");
    assert!(!KINDS.contains(&LightKind::new(&CEILING)) && LightKind::named("ceiling").is_err());
}

#[test]
fn a_search_finds_the_best_lamp_under_the_ceiling() {
    let scene = shapes::scene([(shapes::sphere(24), shapes::matt(0.6), DMat4::IDENTITY)]);
    let lens = Projection::Perspective { yfov: 0.67 };
    let view = shapes::view(&scene, shapes::camera(DVec3::new(0.0, 0.0, 3.2), lens), 64, 64);
    let (objective, shading) = (Objective::default(), Shading::default());
    let maps = cpu::maps(visibility::draw(&scene, &view), &objective);
    let mut evaluator = CpuEvaluator::new(maps.clone(), &view, objective, shading).expect("maps");

    let genome = genome(&[Role::Key]);
    let settings =
        GeneticSettings { population: 24, generations: 12, ..GeneticSettings::default() };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut individual = || genome.bounds().iter().map(|range| range.uniform(&mut rng)).collect();
    let start: Vec<Vec<f32>> = (0..settings.population).map(|_| individual()).collect();
    let mut search = Genetic::new(genome.bounds(), start, settings, rng).expect("a search");
    let outcome =
        design::run(&mut search, &genome, &mut evaluator, &mut |_| ControlFlow::Continue(()))
            .expect("an outcome");

    let [lamp] = outcome.rig[..] else { panic!("{:?}", outcome.rig) };
    assert!((lamp.direction().y * lamp.distance - HEIGHT).abs() < 1e-5, "{lamp:?}");
    let reference = |light: &Light| {
        let rig: [LightRecord; 1] = [light.record()];
        fitness::fitness(&maps, &view, &objective, &shading, &rig).quality().score
    };
    assert!((reference(&lamp) - outcome.score).abs() < 1e-4);
    assert!(outcome.score < outcome.history[0].best);
    // No lamp on a grid of places is better by much, and one from behind is far worse.
    let bounds = genome.bounds();
    let at = |azimuth: usize, ground: usize| {
        let mut chromosome = genome.encode(&[lamp]);
        chromosome[0] = bounds[0].at(azimuth as f32 / 12.0);
        chromosome[1] = bounds[1].at(ground as f32 / 6.0);
        reference(&genome.decode(&chromosome)[0])
    };
    let places = (0..=12).flat_map(|azimuth| (0..=6).map(move |ground| (azimuth, ground)));
    let lowest = places.map(|(azimuth, ground)| at(azimuth, ground)).fold(f32::MAX, f32::min);
    assert!(outcome.score < lowest + 0.02, "{} {lowest}", outcome.score);
    let behind = Light { azimuth: std::f32::consts::PI, ..lamp };
    assert!(reference(&behind) > outcome.score + 0.05);
}
