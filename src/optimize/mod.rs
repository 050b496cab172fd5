//! Searches for the lowest score: a search asks for the scores of some chromosomes and is told them. It
//! knows the range of each allele and nothing of lights, scenes or devices.
//!
//! [`OPTIMIZERS`] lists the searches by name; [`create`] makes one of them.

pub mod best;
pub mod bipop;
mod cma;
pub mod descent;
pub mod genetic;
pub mod heats;
pub mod random;
pub mod recorded;
pub mod restarts;
pub mod shade;
pub mod start;
pub mod table;
#[cfg(test)]
mod testing;

use std::fmt::Debug;

pub use best::Best;
pub use bipop::Bipop;
pub use descent::{Descent, DescentSettings, GreedySettings};
pub use genetic::{Genetic, GeneticSettings, MAX_POPULATION};
pub use heats::{Heats, side_by_side};
pub use random::Random;
pub use recorded::{Record, Recorded};
pub use restarts::Restarts;
pub use shade::{Shade, ShadeSettings};
pub use start::StartSettings;
pub use table::{Entry, OPTIMIZERS, Settings, Setup, create, find};

/// A search for the chromosome with the lowest score.
///
/// A generation is one [`Optimizer::ask`], whose chromosomes are evaluated together, and one
/// [`Optimizer::tell`]. All random numbers come from a seeded generator, so that the same scores lead to
/// the same questions.
pub trait Optimizer: Debug + Send + Sync {
    /// Its name: that of its [`Entry`] where it has one.
    fn name(&self) -> &'static str;

    /// The chromosomes whose scores it wants next, each with a value for every allele, inside its range;
    /// none when it has ended. Asking again gives the same until [`Optimizer::tell`].
    fn ask(&self) -> &[Vec<f32>];

    /// Takes the scores of what was asked for, in order.
    fn tell(&mut self, scores: &[f32]);

    /// The best chromosome of all that were scored, and its score; `None` before the first scores, and
    /// after [`Optimizer::renew`] before the next. [`Best`] takes care of it.
    fn best(&self) -> Option<(&[f32], f32)>;

    /// Scores of all that the search holds at present: its mean and worst are shown as its progress.
    fn scores(&self) -> &[f32];

    /// Forgets all scores, as they hold no more, and asks for what it holds at present, each chromosome
    /// passed through `change`, which stays inside the ranges. The best so far and whatever ends the
    /// search count anew; a search that has ended goes on.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>);

    /// Forgets all scores, as more exact ones of the same landscape come from here on; the search is no younger for it.
    fn refine(&mut self) {
        self.renew(&|chromosome| chromosome.to_vec());
    }

    /// A copy, random numbers included.
    fn boxed(&self) -> Box<dyn Optimizer>;

    /// Scores of the local minima that it came to and left for a new start, in order; none for searches
    /// without restarts.
    fn minima(&self) -> &[f32] {
        &[]
    }
}

impl Clone for Box<dyn Optimizer> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::range::Range;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const BOUNDS: [Range; 3] = [Range::new(-1.0, 1.0); 3];

    /// One search of each kind with either settings.
    fn searches(seed: u64, settings: [GeneticSettings; 2]) -> Vec<Box<dyn Optimizer>> {
        let greedy = GreedySettings { starts: 3, ..GreedySettings::default() };
        let make = |(entry, genetic): (&Entry, GeneticSettings)| {
            let settings = Settings { genetic, greedy, ..Settings::default() };
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let first = BOUNDS.iter().map(|range| range.uniform(&mut rng)).collect();
            let setup = Setup { bounds: &BOUNDS, first, settings: &settings, rng };
            create(entry.name, setup).unwrap()
        };
        let all =
            settings.into_iter().flat_map(|genetic| OPTIMIZERS.iter().map(move |e| (e, genetic)));
        all.map(make).collect()
    }

    /// Endless ones, with elites and without any.
    fn endless(seed: u64) -> Vec<Box<dyn Optimizer>> {
        let settings = GeneticSettings { population: 12, ..GeneticSettings::endless() };
        searches(seed, [settings, GeneticSettings { elitism: 0.0, ..settings }])
    }

    /// Ripples, so that most children are worse than their parents and probes find lower places.
    fn height(x: &[f32]) -> f32 {
        x.iter().map(|x| x * x + (30.0 * x).sin()).sum()
    }

    #[test]
    fn the_best_is_the_best_so_far() {
        for seed in 0..10 {
            for mut search in endless(seed) {
                let mut best: Option<(Vec<f32>, f32)> = None;
                for round in 0..60 {
                    let before = search.best().map(|(x, score)| (x.to_vec(), score));
                    assert_eq!(before, best, "{}, seed {seed}, round {round}", search.name());
                    let told: Vec<f32> = search.ask().iter().map(|x| height(x)).collect();
                    for (x, &score) in search.ask().iter().zip(&told) {
                        if best.as_ref().is_none_or(|(_, best)| score < *best) {
                            best = Some((x.clone(), score));
                        }
                    }
                    search.tell(&told);
                }
            }
        }
    }

    #[test]
    fn what_is_not_a_number_is_never_the_best() {
        for nan in [f32::NAN, -f32::NAN] {
            for mut search in endless(1) {
                let mut scores = vec![nan; search.ask().len()];
                search.tell(&scores);
                assert_eq!(search.best(), None, "{}", search.name());
                scores.resize(search.ask().len(), nan);
                if let Some(last) = scores.last_mut() {
                    *last = 0.9;
                    search.tell(&scores);
                    assert_eq!(search.best().unwrap().1, 0.9, "{}", search.name());
                }
            }
        }
    }

    /// A generation; the search's base is added to every score.
    fn step(search: &mut dyn Optimizer, base: f32) -> Vec<f32> {
        let scores: Vec<f32> = search.ask().iter().map(|x| base + height(x)).collect();
        search.tell(&scores);
        scores
    }

    #[test]
    fn searches_without_restarts_leave_no_minima() {
        for mut search in endless(2) {
            (0..400).for_each(|_| drop(step(&mut *search, 0.0)));
            let restarts = !["ga", "greedy", "random"].contains(&search.name());
            assert_eq!(!search.minima().is_empty(), restarts, "{}", search.name());
        }
    }

    #[test]
    fn the_best_starts_anew_when_scores_have_become_void() {
        for mut search in endless(7) {
            for rounds in [0, 1, 20, 200] {
                (0..rounds).for_each(|_| drop(step(&mut *search, 0.0)));
                let before = search.best().map(|(x, _)| x.to_vec());
                search.renew(&|x| x.iter().map(|x| -x).collect());
                let name = search.name();
                assert_eq!(search.best(), None, "{name}");
                assert!(!search.ask().is_empty(), "{name}");
                let best = before.map(|x| x.iter().map(|x| -x).collect::<Vec<_>>());
                // Without elites the best so far may no longer be there; a probe is beside its descent.
                if let Some(best) = best
                    && ["restarts", "random", "shade"].contains(&name)
                {
                    assert!(search.ask().contains(&best), "{name}");
                }
                let lowest = step(&mut *search, 100.0).into_iter().fold(f32::INFINITY, f32::min);
                assert_eq!(search.best().unwrap().1, lowest, "{name}");
            }
        }
    }

    #[test]
    fn a_copy_goes_the_same_way() {
        for mut search in endless(5) {
            (0..9).for_each(|_| drop(step(&mut *search, 0.0)));
            let mut copy = search.clone();
            assert_eq!(copy.name(), search.name());
            for _ in 0..9 {
                assert_eq!(copy.ask(), search.ask());
                step(&mut *copy, 0.0);
                step(&mut *search, 0.0);
            }
            assert_eq!((copy.best(), copy.scores()), (search.best(), search.scores()));
        }
    }

    #[test]
    fn every_search_ends_where_its_settings_say_and_goes_on_when_renewed() {
        let settings = GeneticSettings { population: 10, generations: 7, ..Default::default() };
        for mut search in searches(3, [settings; 2]) {
            for _ in 0..2 {
                let mut evaluations = 0;
                while !search.ask().is_empty() {
                    evaluations += step(&mut *search, 0.0).len();
                }
                let expected = match search.name() {
                    "ga" => 10 + 6 * 9..=10 + 6 * 9,
                    "random" | "shade" => 70..=70,
                    // Up to the probes of one place more.
                    "restarts" => settings.budget()..=settings.budget() + 5,
                    _ => 1..=10_000,
                };
                assert!(expected.contains(&evaluations), "{} {evaluations}", search.name());
                search.renew(&|x| x.to_vec());
            }
        }
    }

    #[test]
    fn optimizers_are_made_by_name_alone() {
        for entry in OPTIMIZERS {
            let same = OPTIMIZERS.iter().filter(|other| other.name == entry.name);
            assert_eq!(same.count(), 1);
        }
        for (search, entry) in endless(0).iter().zip(OPTIMIZERS) {
            assert_eq!(search.name(), entry.name);
        }
        let setup = |first: Vec<f32>, settings| Setup {
            bounds: &BOUNDS,
            first,
            settings,
            rng: ChaCha8Rng::seed_from_u64(0),
        };
        let refused = |name: &str, setup, words: &str| {
            let fault = create(name, setup).unwrap_err();
            assert!(fault.is_input() && fault.to_string().contains(words), "{fault}");
        };
        let settings = Settings::default();
        let mut wrong = settings;
        wrong.genetic.population = 1;
        let middle = vec![0.0; 3];
        refused("annealing", setup(middle.clone(), &settings), "'annealing'");
        refused(
            "",
            setup(middle.clone(), &settings),
            "ga, shade, cma-es, greedy, restarts, random",
        );
        for entry in OPTIMIZERS {
            refused(entry.name, setup(vec![0.0; 2], &settings), "2 alleles");
            refused(entry.name, setup(vec![0.0, f32::NAN, 0.0], &settings), "allele 1");
            refused(entry.name, setup(middle.clone(), &wrong), "population is 1");
        }
    }
}
