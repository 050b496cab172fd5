//! Searches side by side, of which the best goes on: in a landscape of many valleys a population decides early for one of
//! them, so that where scores are cheap it pays to look into several.

use super::{Optimizer, Setup, create};
use crate::Result;

/// Searches that are asked together until [`Optimizer::refine`] leaves the one with the lowest score.
#[derive(Debug, Clone)]
pub struct Heats {
    searches: Vec<Box<dyn Optimizer>>,
    /// Which of them still ask.
    running: Vec<bool>,
    /// A search waits for the others when its scores differ by no more than this share of the lowest.
    settled: f32,
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
}

/// `count` searches of the optimizer that is called `name`, each with a stream of random numbers of its own: side by
/// side, or the one alone.
///
/// # Errors
/// As [`create`].
pub fn side_by_side(
    name: &str,
    setup: &Setup<'_>,
    count: u32,
    settled: f32,
) -> Result<Box<dyn Optimizer>> {
    let search = |stream| {
        let mut setup = setup.clone();
        setup.rng.set_stream(stream);
        create(name, setup)
    };
    if count == 1 {
        return create(name, setup.clone());
    }
    let searches = (0..u64::from(count)).map(search).collect::<Result<_>>()?;
    Ok(Box::new(Heats::new(searches, settled)))
}

impl Heats {
    /// Of at least one search.
    ///
    /// # Panics
    /// Without searches.
    pub fn new(searches: Vec<Box<dyn Optimizer>>, settled: f32) -> Self {
        assert!(!searches.is_empty(), "heats need a search");
        let mut heats = Self {
            running: vec![true; searches.len()],
            searches,
            settled,
            asked: Vec::new(),
            scores: Vec::new(),
        };
        heats.collect();
        heats
    }

    /// Collects what the running searches ask for.
    fn collect(&mut self) {
        let running = self.searches.iter().zip(&self.running).filter(|(_, running)| **running);
        self.asked = running.flat_map(|(search, _)| search.ask().iter().cloned()).collect();
        self.scores = self.searches.iter().flat_map(|search| search.scores().to_vec()).collect();
    }

    /// Whether the scores that a search holds differ by little.
    fn has_settled(&self, search: &dyn Optimizer) -> bool {
        let scores = search.scores();
        let low = scores.iter().copied().fold(f32::INFINITY, f32::min);
        let high = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        high - low <= self.settled * low.abs()
    }

    /// The search with the lowest score; the first of those that are equal.
    fn winner(&self) -> usize {
        let score =
            |at: &usize| self.searches[*at].best().map_or(f32::INFINITY, |(_, score)| score);
        (0..self.searches.len()).min_by(|a, b| score(a).total_cmp(&score(b))).unwrap_or(0)
    }
}

impl Optimizer for Heats {
    fn name(&self) -> &'static str {
        self.searches[0].name()
    }

    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        let mut rest = scores;
        for at in 0..self.searches.len() {
            if !self.running[at] {
                continue;
            }
            let (own, others) = rest.split_at(self.searches[at].ask().len());
            rest = others;
            self.searches[at].tell(own);
            let search = &self.searches[at];
            self.running[at] = !search.ask().is_empty() && !self.has_settled(&**search);
        }
        self.collect();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.searches[self.winner()].best()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        self.searches.iter_mut().for_each(|search| search.renew(change));
        self.running.fill(true);
        self.collect();
    }

    fn refine(&mut self) {
        let mut winner = self.searches.swap_remove(self.winner());
        winner.refine();
        // What goes on alone ends by itself.
        *self = Self::new(vec![winner], -1.0);
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }

    fn minima(&self) -> &[f32] {
        self.searches[self.winner()].minima()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::range::Range;
    use crate::optimize::{Settings, Setup, create, shade};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const BOUNDS: [Range; 2] = [Range { low: -1.0, high: 1.0 }; 2];

    /// Two valleys, of which the narrower one is lower.
    fn valleys(x: &[f32]) -> f32 {
        let to = |place: f32| x.iter().map(|x| (x - place).powi(2)).sum::<f32>();
        (1.0 + to(-0.4)).min(0.5 + 3.0 * to(0.7))
    }

    fn search(seed: u64) -> Box<dyn Optimizer> {
        let mut settings = Settings::default();
        (settings.genetic.population, settings.genetic.generations) = (8, 60);
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let setup = Setup { bounds: &BOUNDS, first: vec![-0.5; 2], settings: &settings, rng };
        create(shade::NAME, setup).unwrap()
    }

    fn go(search: &mut dyn Optimizer, generations: usize) -> f32 {
        for _ in 0..generations {
            let scores: Vec<f32> = search.ask().iter().map(|x| valleys(x)).collect();
            if scores.is_empty() {
                break;
            }
            search.tell(&scores);
        }
        search.best().unwrap().1
    }

    #[test]
    fn the_best_of_several_goes_on() {
        let alone: Vec<f32> = (0..8).map(|seed| go(&mut *search(seed), 60)).collect();
        let lost = alone.iter().filter(|&&score| score > 0.9).count();
        assert!((1..8).contains(&lost), "{alone:?}");
        let mut heats = Heats::new((0..8).map(search).collect(), 0.1);
        assert_eq!((heats.ask().len(), heats.name()), (8 * 8, shade::NAME));
        let copy = heats.boxed();
        go(&mut heats, 20);
        assert!(heats.ask().len() < 8 * 8, "some have settled and wait");
        assert_eq!(heats.scores().len(), 8 * 8);
        heats.refine();
        assert_eq!((heats.ask().len(), heats.best()), (8, None));
        let score = go(&mut heats, 60);
        assert!(score < 0.51, "{score}");
        assert_eq!(copy.ask().len(), 8 * 8);
    }

    #[test]
    fn when_all_have_settled_nothing_is_asked_until_one_goes_on() {
        let mut heats = Heats::new((0..3).map(search).collect(), 0.1);
        go(&mut heats, 60);
        assert!(heats.ask().is_empty());
        heats.refine();
        assert_eq!(heats.ask().len(), 8);
        let mut heats = Heats::new((0..3).map(search).collect(), 0.1);
        go(&mut heats, 3);
        heats.renew(&|x| x.to_vec());
        assert_eq!((heats.ask().len(), heats.best()), (3 * 8, None));
    }
}
