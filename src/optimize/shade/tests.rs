use super::*;
use crate::optimize::testing::{D, Function, ellipsoid, rastrigin, rosenbrock, sphere};
use crate::optimize::{GeneticSettings, Settings, create};
use proptest::prelude::*;
use rand::SeedableRng;

fn search(
    bounds: &[Range],
    genetic: GeneticSettings,
    shade: ShadeSettings,
    seed: u64,
) -> Box<dyn Optimizer> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = bounds.iter().map(|range| range.uniform(&mut rng)).collect();
    let start = StartSettings { scattered: 0.0, ..Default::default() };
    let settings = &Settings { genetic, shade, start, ..Default::default() };
    create(NAME, Setup { bounds, first, settings, rng }).unwrap()
}

fn step(search: &mut dyn Optimizer, height: impl Fn(&[f32]) -> f32) {
    let scores: Vec<f32> = search.ask().iter().map(|x| height(x)).collect();
    search.tell(&scores);
}

/// Evaluations to 10⁻⁶ in the box −5..5, medians of 21 seeds. The reference is the L-SHADE of minionpy 1.9.1
/// with a population of 30 that does not shrink, a history of 10 and an archive of the population's size:
/// 3354, 10158 (19 of 21 runs), 8289 and 11251. It takes always the best 11 % where SHADE draws a share.
#[test]
fn standard_functions_take_as_many_evaluations_as_the_reference() {
    let functions: [(Function, usize, usize); 4] = [
        (sphere, 3354, 21),
        (rosenbrock, 10158, 19),
        (ellipsoid, 8289, 21),
        (rastrigin, 11251, 21),
    ];
    for (number, (function, expected, successes)) in functions.into_iter().enumerate() {
        let run = |seed| {
            let shade = ShadeSettings { settled: -1.0, ..Default::default() };
            let mut search =
                search(&[Range::new(-5.0, 5.0); D], GeneticSettings::endless(), shade, seed);
            let mut evaluations = 0;
            while search.best().is_none_or(|(_, score)| score >= 1e-6) && evaluations < 60_000 {
                evaluations += search.ask().len();
                step(&mut *search, function);
            }
            evaluations
        };
        let mut all: Vec<usize> = (0..21).map(run).collect();
        all.sort_unstable();
        let solved = all.iter().filter(|&&evaluations| evaluations < 60_000).count();
        println!("function {number}: {} evaluations, {solved} of 21", all[10]);
        let ratio = all[10] as f64 / expected as f64;
        assert!((0.8..1.25).contains(&ratio), "{number}: {all:?}");
        assert!(solved + 2 >= successes, "{number}: {all:?}");
    }
}

/// A search of twelve alleles whose first population has scores.
fn begun(start: StartSettings) -> Shade {
    let bounds = &[Range::new(0.0, 1.0); 12];
    let settings = &Settings { start, ..Default::default() };
    let rng = ChaCha8Rng::seed_from_u64(8);
    let mut search = Shade::new(Setup { bounds, first: vec![0.5; 12], settings, rng });
    step(&mut search, |x| x.iter().sum());
    search
}

#[test]
fn the_crossover_is_the_share_of_the_alleles_that_are_new() {
    let new = |crossover: f32| {
        let mut search = begun(StartSettings::default());
        search.history.fill(Control { crossover, factor: 0.5 });
        search.asked.clear();
        search.controls.clear();
        search.breed();
        let pairs = std::iter::zip(&search.population, &search.asked);
        let new = |(parent, trial): (&Vec<f32>, &Vec<f32>)| {
            std::iter::zip(parent, trial).filter(|(a, b)| a != b).count()
        };
        pairs.map(new).sum::<usize>() as f32 / (12 * search.population.len()) as f32
    };
    let [few, half, most] = [0.0, 0.5, 1.0].map(new);
    // One allele is new in any case, and the parameter is drawn with a deviation of 0.1.
    assert!(few > 0.06 && few < 0.2 && (0.4..0.65).contains(&half), "{few} {half}");
    assert!(most > 0.85, "{most}");
}

#[test]
fn a_mutant_goes_towards_one_of_the_best_and_by_the_difference_of_two_others() {
    let mut search = begun(StartSettings::default());
    // Nothing leaves such a box.
    search.bounds = vec![Range::new(-9.0, 9.0); 12];
    search.archive = vec![vec![0.2; 12]];
    let mut order: Vec<usize> = (0..search.population.len()).collect();
    order.sort_by(|&a, &b| search.scores[a].total_cmp(&search.scores[b]));
    let all: Vec<_> = search.population.iter().chain(&search.archive).cloned().collect();
    for parent in 0..search.population.len() {
        let mutant = search.mutant(parent, 0.7, &order);
        let x = &search.population[parent];
        let made = |best: &[f32], one: &[f32], other: &[f32]| {
            let allele = |at: usize| x[at] + 0.7 * (best[at] - x[at]) + 0.7 * (one[at] - other[at]);
            (0..12).all(|at| (allele(at) - mutant[at]).abs() < 1e-5)
        };
        let among = (search.settings.best * order.len() as f32).round() as usize;
        let found = order[..among].iter().any(|&best| {
            let pairs = search.population.iter().flat_map(|one| all.iter().map(move |o| (one, o)));
            pairs.filter(|(one, o)| one != o).any(|(one, o)| made(&all[best], one, o))
        });
        assert!(found, "{parent}");
    }
}

#[test]
fn a_population_after_another_is_drawn_from_all_of_the_box() {
    // The first one would stand in one place.
    let mut search = begun(StartSettings { scattered: 1.0, spread: 0.0 });
    assert!(search.population.iter().all(|x| *x == search.population[0]));
    search.begin(None);
    for allele in 0..12 {
        let values = || search.asked.iter().map(|x| x[allele]);
        assert!(values().fold(1.0, f32::min) < 0.3 && values().fold(0.0, f32::max) > 0.7);
    }
    let place = vec![0.25; 12];
    search.begin(Some(place.clone()));
    assert!(search.asked.iter().all(|x| *x == place));
}

fn shades() -> impl Strategy<Value = ShadeSettings> {
    (1usize..20, 0f32..=3.0, 0f32..=1.0, prop::sample::select(vec![-1.0, 1e-3, 0.5]), 1usize..4)
        .prop_map(|(history, archive, best, settled, starts)| ShadeSettings {
            history,
            archive,
            best,
            settled,
            starts,
        })
}

proptest! {
    #[test]
    fn invariants_hold_for_all_settings(
        shade in shades(),
        population in 2usize..40,
        seed: u64,
        bounds in prop::collection::vec((-2f32..2.0, 0f32..3.0), 1..12),
    ) {
        let bounds: Vec<Range> =
            bounds.iter().map(|&(low, width)| Range::new(low, low + width)).collect();
        let height = |x: &[f32]| x.iter().map(|x| (x - 0.3).powi(2) - (20.0 * x).cos()).sum::<f32>();
        let genetic = GeneticSettings { population, generations: 20, ..GeneticSettings::endless() };
        let mut search = search(&bounds, genetic, shade, seed);
        let mut generations = 0;
        let mut populations = 0;
        while !search.ask().is_empty() {
            prop_assert_eq!(search.ask().len(), population);
            for individual in search.ask() {
                prop_assert!(bounds.iter().zip(individual).all(|(r, &x)| r.contains(x)));
            }
            let before = search.scores().to_vec();
            step(&mut *search, height);
            generations += 1;
            // None becomes worse but where a new population begins.
            let worse = std::iter::zip(search.scores(), &before).any(|(after, before)| after > before);
            prop_assert!(!worse || search.minima().len() > populations || generations == 1
                || populations > 0);
            populations = search.minima().len();
        }
        prop_assert!(generations <= 20 && populations <= shade.starts);
        prop_assert!(generations == 20 || populations == shade.starts);
    }
}

/// Lowest in a corner of the box.
fn corner(x: &[f32]) -> f32 {
    1.0 + x.iter().map(|x| (x - 2.0).powi(2)).sum::<f32>()
}

#[test]
fn it_reaches_the_corners_of_the_box() {
    let shade = ShadeSettings { settled: 1e-3, ..Default::default() };
    let mut search = search(&[Range::new(-1.0, 1.0); 6], GeneticSettings::endless(), shade, 1);
    while !search.ask().is_empty() {
        step(&mut *search, corner);
    }
    let (best, score) = search.best().unwrap();
    assert!(best.iter().all(|&x| x > 0.99 && x <= 1.0), "{best:?}");
    assert!(score < 7.0 * 1.001, "{score}");
}

#[test]
fn the_same_seed_goes_the_same_way() {
    let run = |seed| {
        let genetic = GeneticSettings { generations: 40, ..GeneticSettings::endless() };
        let mut search = search(&[Range::new(-5.0, 5.0); D], genetic, Default::default(), seed);
        while !search.ask().is_empty() {
            step(&mut *search, rastrigin);
        }
        search.best().map(|(x, score)| (x.to_vec(), score)).unwrap()
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

/// Two valleys, the wider one less deep.
fn valleys(x: &[f32]) -> f32 {
    let to = |place: f32| x.iter().map(|x| (x - place).powi(2)).sum::<f32>();
    (0.2 + to(0.5)).min(0.1 + 40.0 * to(-0.7))
}

#[test]
fn a_population_that_has_settled_ends_or_another_begins() {
    let starts = |starts| {
        let shade = ShadeSettings { starts, ..Default::default() };
        let mut search = search(&[Range::new(-1.0, 1.0); 3], GeneticSettings::endless(), shade, 0);
        let mut generations = 0;
        while !search.ask().is_empty() {
            step(&mut *search, valleys);
            generations += 1;
        }
        assert!(search.minima().iter().all(|end| (0.1..0.201).contains(end)));
        let lowest = search.minima().iter().copied().fold(f32::INFINITY, f32::min);
        assert_eq!(search.best().unwrap().1, lowest);
        (generations, search.minima().len())
    };
    let (one, five) = (starts(1), starts(5));
    assert_eq!((one.1, five.1), (1, 5));
    assert!(one.0 < 100 && five.0 > 3 * one.0, "{one:?} {five:?}");
}

#[test]
fn patience_ends_a_search_that_stands_still() {
    let genetic = GeneticSettings { patience: 5, ..GeneticSettings::endless() };
    let mut search = search(&[Range::new(0.0, 1.0); 2], genetic, Default::default(), 0);
    let mut generations = 0;
    // The lowest score is the first of all, and none ever draws level with it.
    while !search.ask().is_empty() {
        let scores = |at| if generations == 0 { 1.0 + at as f32 } else { 100.0 };
        let scores: Vec<f32> = (0..search.ask().len()).map(scores).collect();
        search.tell(&scores);
        generations += 1;
    }
    assert_eq!(generations, 6);
}

#[test]
fn a_search_that_has_settled_finds_the_lowest_place_of_another_landscape() {
    let bounds = [Range::new(-1.0, 1.0); 4];
    let bowl = |at: f32| move |x: &[f32]| 0.1 + x.iter().map(|x| (x - at).powi(2)).sum::<f32>();
    let mut search = search(&bounds, GeneticSettings::endless(), Default::default(), 2);
    for place in [0.8, -0.8, 0.1] {
        let mut generations = 0;
        while !search.ask().is_empty() {
            step(&mut *search, bowl(place));
            generations += 1;
        }
        let (best, score) = search.best().unwrap();
        assert!(score < 0.101 && generations < 100, "{score} {generations}");
        let best = best.to_vec();
        search.renew(&|x| x.to_vec());
        assert!(search.ask().contains(&best));
    }
}

/// As it is where an engine's camera never rests: a generation, and all scores are void.
#[test]
fn it_descends_even_where_every_generation_is_the_last() {
    let mut search =
        search(&[Range::new(-5.0, 5.0); 4], GeneticSettings::endless(), Default::default(), 0);
    let height = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>();
    let mut bests = Vec::new();
    for _ in 0..120 {
        step(&mut *search, height);
        bests.push(search.best().unwrap().1);
        step(&mut *search, height);
        search.renew(&|x| x.to_vec());
    }
    assert!(bests[119] < 0.01 * bests[0], "{bests:?}");
}

#[test]
fn settings_out_of_range_are_refused() {
    let wrong = [
        ShadeSettings { history: 0, ..Default::default() },
        ShadeSettings { history: MAX_HISTORY + 1, ..Default::default() },
        ShadeSettings { starts: 0, ..Default::default() },
        ShadeSettings { archive: -0.1, ..Default::default() },
        ShadeSettings { best: 1.1, ..Default::default() },
        ShadeSettings { settled: f32::NAN, ..Default::default() },
    ];
    for settings in wrong {
        let fault = settings.check().unwrap_err().to_string();
        assert!(fault.contains("shade."), "{fault}");
    }
}
