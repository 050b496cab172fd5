use super::*;
use crate::optimize::testing::{D, Function, ellipsoid, rastrigin, rosenbrock, sphere};
use crate::optimize::{GeneticSettings, Settings, create};
use proptest::prelude::*;
use rand::SeedableRng;

fn search(bounds: &[Range], genetic: GeneticSettings, seed: u64) -> Box<dyn Optimizer> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = bounds.iter().map(|range| range.uniform(&mut rng)).collect();
    let settings = &Settings { genetic, ..Settings::endless() };
    create(NAME, Setup { bounds, first, settings, rng }).unwrap()
}

fn step(search: &mut dyn Optimizer, height: impl Fn(&[f32]) -> f32) {
    let scores: Vec<f32> = search.ask().iter().map(|x| height(x)).collect();
    search.tell(&scores);
}

/// Evaluations to 10⁻⁶ in the box −5..5, medians. The reference is `fmin2` of pycma 4.5.0 with `bipop=True`, a first
/// step of 2 and bounds −5 and 5, 21 seeds.
#[test]
fn standard_functions_take_as_many_evaluations_as_pycma() {
    let functions: [(Function, usize); 3] = [(sphere, 1168), (rosenbrock, 5248), (ellipsoid, 3948)];
    for (number, (function, expected)) in functions.into_iter().enumerate() {
        let run = |seed| {
            let mut search = search(&[Range::new(-5.0, 5.0); D], GeneticSettings::endless(), seed);
            let mut evaluations = 0;
            while search.best().is_none_or(|(_, score)| score >= 1e-6) && evaluations < 20_000 {
                evaluations += search.ask().len();
                step(&mut *search, function);
            }
            evaluations
        };
        let mut all: Vec<usize> = (0..21).map(run).collect();
        all.sort_unstable();
        let median = all[10];
        println!("function {number}: {median} evaluations of {expected}: {all:?}");
        let ratio = median as f64 / expected as f64;
        assert!((0.8..1.25).contains(&ratio), "{number}: {all:?}");
        assert!(all[20] < 20_000, "{number}: {all:?}");
    }
}

proptest! {
    #[test]
    fn it_asks_for_what_is_inside_and_ends_with_its_budget(
        generations in 1usize..200,
        seed: u64,
        bounds in prop::collection::vec((-2f32..2.0, 0f32..3.0), 1..12),
    ) {
        let bounds: Vec<Range> =
            bounds.iter().map(|&(low, width)| Range::new(low, low + width)).collect();
        let genetic = GeneticSettings { generations, ..GeneticSettings::default() };
        let mut search = search(&bounds, genetic, seed);
        let height = |x: &[f32]| x.iter().map(|x| (x - 0.3).powi(2) - (20.0 * x).cos()).sum::<f32>();
        let (mut evaluations, mut last) = (0, 0);
        while !search.ask().is_empty() {
            for individual in search.ask() {
                prop_assert!(bounds.iter().zip(individual).all(|(r, &x)| r.contains(x)));
            }
            last = search.ask().len();
            evaluations += last;
            step(&mut *search, height);
        }
        let budget = genetic.budget();
        prop_assert!(evaluations >= budget && evaluations - last < budget, "{evaluations}");
    }
}

#[test]
fn points_and_alleles_stand_for_each_other() {
    for at in 0..=1000 {
        let x = -MARGIN + (1.0 + 2.0 * MARGIN) * f64::from(at) / 1000.0;
        let share = fold(x);
        let [back] = into_unit(&[Range::new(0.0, 1.0)], &[share as f32])[..] else { panic!() };
        assert!((fold(back) - share).abs() < 1e-6, "{x}");
        for other in [-2.0 * MARGIN - x, 2.0 + 2.0 * MARGIN - x, x + 2.0 + 4.0 * MARGIN] {
            assert!((fold(other) - share).abs() < 1e-9, "{x} {other}");
        }
        assert!((MARGIN..1.0 - MARGIN).contains(&x) == (fold(x) == x), "{x}");
    }
    assert_eq!([fold(-MARGIN), fold(1.0 + MARGIN)], [0.0, 1.0]);
}

#[test]
fn it_reaches_the_corners_of_the_box() {
    let genetic = GeneticSettings { generations: 60, ..GeneticSettings::default() };
    let mut search = search(&[Range::new(-1.0, 1.0); 6], genetic, 1);
    while !search.ask().is_empty() {
        step(&mut *search, |x| 1.0 + x.iter().map(|x| (x - 2.0).powi(2)).sum::<f32>());
    }
    let (best, score) = search.best().unwrap();
    assert!(best.iter().all(|&x| x > 0.99 && x <= 1.0), "{best:?}");
    assert!(score < 7.0 * 1.001, "{score}");
}

/// On a function with many valleys, large populations and small ones follow each other with about as many evaluations.
#[test]
fn populations_double_and_small_ones_use_as_much() {
    let mut search = Bipop::new(Setup {
        bounds: &[Range::new(-5.0, 5.0); D],
        first: vec![1.0; D],
        settings: &Settings::endless(),
        rng: ChaCha8Rng::seed_from_u64(3),
    });
    let (mut sizes, mut regimes) = (Vec::new(), Vec::new());
    while search.ends.len() < 8 {
        if search.made == 0 {
            sizes.push(search.run.samples());
            regimes.push(search.regime);
        }
        step(&mut search, |x| 1.0 + rastrigin(x));
    }
    let large = std::iter::zip(&sizes, &regimes).filter(|(_, regime)| **regime == Regime::Large);
    let large: Vec<usize> = large.map(|(&size, _)| size).collect();
    assert!(large.iter().enumerate().all(|(at, &size)| size == 20 << at), "{large:?}");
    assert_eq!((sizes[0], regimes[0], regimes[1]), (10, Regime::First, Regime::Large));
    let mut all = std::iter::zip(&sizes, &regimes);
    assert!(all.any(|(&size, &regime)| regime == Regime::Small && size > 10), "{sizes:?}");
    for (at, regime) in regimes.iter().enumerate() {
        let before = regimes[..at].iter().filter(|one| **one == Regime::Large).count();
        assert!(*regime != Regime::Small || (10..=10 << before).contains(&sizes[at]), "{sizes:?}");
    }
    assert_eq!(search.minima().len(), 8);
    assert!(search.minima().iter().all(|&end| end >= 0.999));
}

#[test]
fn level_ground_and_numbers_that_are_none_stop_nothing() {
    for score in [0.5, 0.0, f32::INFINITY, f32::NAN] {
        let mut search = search(&[Range::new(0.0, 1.0); 3], GeneticSettings::endless(), 4);
        for _ in 0..300 {
            assert!(search.ask().iter().flatten().all(|x| (0.0..=1.0).contains(x)), "{score}");
            step(&mut *search, |_| score);
        }
    }
}

/// As it is where an engine's camera never rests: a generation, and all scores are void.
#[test]
fn it_descends_even_where_every_generation_is_the_last() {
    let mut search = search(&[Range::new(-5.0, 5.0); 4], GeneticSettings::endless(), 0);
    let height = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>();
    let mut bests = Vec::new();
    for _ in 0..120 {
        step(&mut *search, height);
        bests.push(search.best().unwrap().1);
        search.renew(&|x| x.to_vec());
    }
    assert!(bests[119] < 0.01 * bests[0], "{bests:?}");
}
