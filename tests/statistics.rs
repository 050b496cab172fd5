//! Every statistic, in every way that there is to measure it, against the CPU references: all terms at once,
//! under coloured lights and spots, with either BRDF.

#[path = "support/gpu.rs"]
#[allow(dead_code, reason = "every test program uses its own part")]
mod support;

use glam::Vec3;
use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::lighting::shading::{Brdf, Shading};
use klieg::lighting::{LightRecord, Population};
use klieg::math::color::luminance;
use klieg::objective::maps::{Maps, PixelType};
use klieg::objective::terms::TERMS;
use klieg::objective::{Objective, Quality, Terms};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use support::{ball, view};

const TOLERANCE: f32 = 1e-4;

/// All of klieg's terms, equally weighed.
fn all_terms() -> Objective {
    let weight = 1.0 / TERMS.len() as f32;
    let weights = Terms::named(TERMS.iter().map(|term| (term.name, weight))).expect("their names");
    Objective { weights, ..Objective::default() }
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
    let mut light = |k: usize| {
        let towards = Vec3::new(number(-1.0, 1.0), number(-0.5, 1.0), number(0.1, 1.0)).normalize();
        let distance = number(1.5, 4.0);
        let white = k % 4 == 3;
        let tint = Vec3::new(number(0.2, 2.0), number(0.5, 1.2), number(0.2, 3.0));
        LightRecord {
            position: (towards * if k % 3 == 0 { 1.0 } else { distance }).to_array(),
            radius2: if k % 3 == 0 { 0.0 } else { distance * distance },
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
    (0..count).map(|k| light(k)).collect()
}

fn difference(a: &Quality, b: &Quality) -> f32 {
    assert!(a.terms.names().eq(b.terms.names()));
    let terms = a.terms.values().zip(b.terms.values());
    terms.map(|(a, b)| (a - b).abs()).fold((a.score - b.score).abs(), f32::max)
}

/// The largest difference of any term of an evaluator from the references; each rig's, and that of a rig
/// in which one number is off.
fn check(evaluator: &mut dyn Evaluator, maps: &Maps, lights: usize, shading: &Shading, seed: u64) {
    let objective = all_terms();
    let view = view(maps.surface.width, maps.surface.height, false);
    let population = Population::of_records(lights, records(seed, 7 * lights)).expect("rigs");
    let found = evaluator.qualities(&population).expect("qualities");
    for (rig, found) in population.rigs().zip(&found) {
        let expected = cpu::fitness::fitness(maps, &view, &objective, shading, rig).quality();
        assert_eq!(expected.terms.iter().count(), TERMS.len());
        let off = difference(found, &expected);
        assert!(off < TOLERANCE, "{lights} lights, {shading:?}: {off}\n{found:?}\n{expected:?}");
        let mut planted = rig.to_vec();
        planted[0].color[1] *= 1.2;
        planted[0].diffuse += 0.02;
        let planted = cpu::fitness::fitness(maps, &view, &objective, shading, &planted).quality();
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
                check(&mut native, &maps, lights, &shading, (at * 10 + lights) as u64);
            }
        }
    }
}
