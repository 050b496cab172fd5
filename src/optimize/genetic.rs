//! The real-coded genetic algorithm of Ha and Olivier (2006), section 4: elitism 10 %, binary
//! tournament, crossover 80 %, mutation 20 %. A value that leaves its box is drawn again, never
//! clamped.

use super::start::population;
use super::{Best, Entry, Optimizer, Setup};
use crate::math::range::Range;
use crate::{Error, Result};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Its name in settings.
pub const NAME: &str = "ga";

pub(crate) const ENTRY: Entry = Entry {
    name: NAME,
    title: "genetic algorithm",
    description: "The genetic algorithm of Ha and Olivier",
    new: |Setup { bounds, first, settings, mut rng }| {
        let genetic = settings.genetic;
        let start = population(bounds, first, genetic.population, &settings.start, &mut rng);
        Ok(Box::new(Genetic::new(bounds, start, genetic, rng)?))
    },
    generations: |settings| Some(settings.genetic.generations),
    words: |settings| {
        let GeneticSettings { population, elitism, crossover, mutation, .. } = settings.genetic;
        let [elitism, crossover, mutation] = [elitism, crossover, mutation].map(|x| 100.0 * x);
        format!(
            "population {population}, elitism {elitism:.0} %, crossover {crossover:.0} %, \
             mutation {mutation:.0} %"
        )
    },
};

/// Most individuals of a generation: what bounds memory on the host and on the device.
pub const MAX_POPULATION: usize = 1 << 17;

/// Settings of the genetic algorithm; the defaults are the paper's where it names a number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GeneticSettings {
    /// Individuals, 2 to [`MAX_POPULATION`].
    pub population: usize,
    /// Generations, the first population included; counted anew from a [`Optimizer::renew`].
    pub generations: usize,
    /// Share of the population, the best, that is copied with its scores.
    pub elitism: f32,
    /// Probability that a child is a blend of two parents rather than a copy of one.
    pub crossover: f32,
    /// Probability with which each of a child's alleles is moved.
    pub mutation: f32,
    /// Standard deviation of that move, as a share of the allele's range.
    pub mutation_step: f32,
    /// Individuals that compete to be a parent, 1 to [`MAX_POPULATION`]; one may be drawn twice.
    pub tournament: usize,
    /// Generations without a better individual after which the search ends, also counted anew; 0 for
    /// never.
    pub patience: usize,
}

impl Default for GeneticSettings {
    fn default() -> Self {
        Self {
            population: 30,
            generations: 100,
            elitism: 0.1,
            crossover: 0.8,
            mutation: 0.2,
            mutation_step: 0.2,
            tournament: 2,
            patience: 0,
        }
    }
}

impl GeneticSettings {
    /// The defaults without an end, for a search that runs as long as its caller wants.
    pub fn endless() -> Self {
        Self { generations: usize::MAX, ..Self::default() }
    }

    /// Number of elites: at least one individual is new in every generation.
    pub fn elites(&self) -> usize {
        ((self.population as f32 * self.elitism).round() as usize).min(self.population - 1)
    }

    /// Evaluations of the first generation, and of each later one.
    pub fn generation_sizes(&self) -> (usize, usize) {
        (self.population, self.population - self.elites())
    }

    /// Evaluations of a whole search.
    pub fn budget(&self) -> usize {
        let (first, later) = self.generation_sizes();
        later.saturating_mul(self.generations - 1).saturating_add(first)
    }

    /// # Errors
    /// [`Error::Argument`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        let fault = |text: String| Err(Error::Argument(text));
        let (population, tournament) = (self.population, self.tournament);
        if !(2..=MAX_POPULATION).contains(&population) {
            return fault(format!("population is {population}: it must be 2 to {MAX_POPULATION}"));
        }
        if !(1..=MAX_POPULATION).contains(&tournament) {
            return fault(format!("a tournament of {tournament}: it is 1 to {MAX_POPULATION}"));
        }
        if self.generations == 0 {
            return fault("generations must be 1 or more".into());
        }
        for (name, rate) in [
            ("elitism", self.elitism),
            ("crossover", self.crossover),
            ("mutation", self.mutation),
            ("mutation_step", self.mutation_step),
        ] {
            if !(0.0..=1.0).contains(&rate) {
                return fault(format!("{name} {rate} is not a share in 0..1"));
            }
        }
        Ok(())
    }
}

/// The search's state.
#[derive(Debug, Clone)]
pub struct Genetic {
    settings: GeneticSettings,
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    /// Scored individuals, the best first.
    population: Vec<Vec<f32>>,
    scores: Vec<f32>,
    best: Best,
    /// Individuals that wait for their scores.
    asked: Vec<Vec<f32>>,
    /// Generations since the start, or since the scores were last renewed.
    generation: usize,
    /// The one of them that the best individual so far is from.
    improved: usize,
}

impl Genetic {
    /// A search that starts from the individuals `start`, all inside `bounds`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a setting out of its range or a start of another size.
    pub fn new(
        bounds: &[Range],
        start: Vec<Vec<f32>>,
        settings: GeneticSettings,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        settings.check()?;
        if start.len() != settings.population {
            let (given, size) = (start.len(), settings.population);
            return Err(Error::Argument(format!("{given} individuals for a population of {size}")));
        }
        Ok(Self {
            settings,
            bounds: bounds.to_vec(),
            rng,
            population: Vec::new(),
            scores: Vec::new(),
            best: Best::default(),
            asked: start,
            generation: 0,
            improved: 0,
        })
    }

    /// All scored individuals, the best first.
    pub fn population(&self) -> &[Vec<f32>] {
        &self.population
    }

    fn finished(&self) -> bool {
        let GeneticSettings { generations, patience, .. } = self.settings;
        self.generation >= generations
            || (patience > 0 && self.generation - self.improved >= patience)
    }

    /// The winner of a tournament. The population is sorted, so that the lowest index wins.
    fn parent(&mut self) -> usize {
        let draw = |_| self.rng.random_range(0..self.population.len());
        (0..self.settings.tournament).map(draw).min().unwrap_or(0)
    }

    fn child(&mut self) -> Vec<f32> {
        let (mother, father) = (self.parent(), self.parent());
        let mut child = self.population[mother].clone();
        if self.rng.random_bool(f64::from(self.settings.crossover)) {
            for (allele, &other) in child.iter_mut().zip(&self.population[father]) {
                let (low, high) = (allele.min(other), allele.max(other));
                // The bounds hold in exact arithmetic; rounding may step over them.
                *allele = (low + self.rng.random::<f32>() * (high - low)).clamp(low, high);
            }
        }
        let (rate, share) = (f64::from(self.settings.mutation), self.settings.mutation_step);
        for (allele, range) in child.iter_mut().zip(&self.bounds) {
            if self.rng.random_bool(rate) {
                *allele = range.step(*allele, share, &mut self.rng);
            }
        }
        child
    }
}

impl Optimizer for Genetic {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        let improved = self.best.offer_all(&self.asked, scores);
        let elites = self.settings.elites().min(self.population.len());
        let kept = self.population.drain(..elites).zip(self.scores.drain(..elites));
        let mut all: Vec<_> =
            kept.chain(self.asked.drain(..).zip(scores.iter().copied())).collect();
        // What is not a number goes last, whatever its sign.
        let order = |a: f32, b: f32| a.is_nan().cmp(&b.is_nan()).then(a.total_cmp(&b));
        all.sort_by(|a, b| order(a.1, b.1));
        (self.population, self.scores) = all.into_iter().unzip();
        self.generation += 1;
        if improved {
            self.improved = self.generation;
        }
        if !self.finished() {
            let children = self.settings.population - self.settings.elites();
            self.asked = (0..children).map(|_| self.child()).collect();
        }
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    /// Asks for the elites and those that wait for their scores, or for everyone of an ended search.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        self.population.truncate(self.settings.population - self.asked.len());
        let all = self.population.drain(..).chain(self.asked.drain(..));
        self.asked = all.map(|individual| change(&individual)).collect();
        self.scores.clear();
        self.best = Best::default();
        (self.generation, self.improved) = (0, 0);
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::Settings;
    use proptest::prelude::*;
    use rand::SeedableRng;

    /// Squared distance from a point of the box, with ripples: many local minima.
    fn ripples(x: &[f32]) -> f32 {
        x.iter().map(|&x| (x - 0.3).powi(2) + 0.1 * (1.0 - (20.0 * (x - 0.3)).cos())).sum()
    }

    fn search(bounds: &[Range], settings: GeneticSettings, seed: u64) -> Genetic {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let first = bounds.iter().map(Range::middle).collect();
        let start = population(bounds, first, settings.population, &Default::default(), &mut rng);
        Genetic::new(bounds, start, settings, rng).unwrap()
    }

    fn step(search: &mut Genetic) {
        let scores: Vec<f32> = search.ask().iter().map(|x| ripples(x)).collect();
        search.tell(&scores);
    }

    fn settings() -> impl Strategy<Value = GeneticSettings> {
        (2usize..40, 0f32..=1.0, 0f32..=1.0, 0f32..=1.0, 0f32..=1.0, 1usize..5).prop_map(
            |(population, elitism, crossover, mutation, mutation_step, tournament)| {
                let rates = GeneticSettings { elitism, crossover, mutation, ..Default::default() };
                GeneticSettings { population, mutation_step, tournament, generations: 12, ..rates }
            },
        )
    }

    proptest! {
        #[test]
        fn invariants_hold_for_all_settings(
            settings in settings(),
            seed: u64,
            bounds in prop::collection::vec((-2f32..2.0, 0f32..3.0), 1..12),
        ) {
            let bounds: Vec<Range> =
                bounds.iter().map(|&(low, width)| Range::new(low, low + width)).collect();
            let mut search = search(&bounds, settings, seed);
            let mut evaluated = 0;
            while !search.ask().is_empty() {
                for individual in search.ask() {
                    prop_assert!(bounds.iter().zip(individual).all(|(r, &x)| r.contains(x)));
                }
                let elites: Vec<_> =
                    search.population().iter().take(settings.elites()).cloned().collect();
                let best = search.best().map(|(_, score)| score);
                evaluated += search.ask().len();
                step(&mut search);
                prop_assert_eq!(search.population().len(), settings.population);
                if let Some(best) = best {
                    prop_assert!(search.best().unwrap().1 <= best);
                }
                // An elite may fall in rank, but it was there to compete: only better ones precede.
                for elite in &elites {
                    prop_assert!(search.population().contains(elite));
                }
                for (individual, &score) in search.population().iter().zip(search.scores()) {
                    prop_assert_eq!(ripples(individual), score);
                }
                prop_assert!(search.scores().is_sorted());
                prop_assert_eq!(search.scores().len(), settings.population);
            }
            let children = settings.population - settings.elites();
            prop_assert_eq!(evaluated, settings.population + 11 * children);
        }
    }

    #[test]
    fn it_finds_the_lowest_of_many_minima_and_repeats_itself() {
        let bounds = [Range::new(-1.0, 1.0); 6];
        let run = |seed| {
            let mut search = search(&bounds, GeneticSettings::default(), seed);
            while !search.ask().is_empty() {
                step(&mut search);
            }
            search.best().map(|(x, score)| (x.to_vec(), score)).unwrap()
        };
        let scores: Vec<f32> = (0..10).map(|seed| run(seed).1).collect();
        assert!(scores.iter().all(|&score| score < 0.05), "{scores:?}");
        assert_eq!(run(3), run(3));
        assert_ne!(run(3).0, run(4).0);
    }

    #[test]
    fn patience_ends_a_search_that_stands_still() {
        let settings = GeneticSettings { patience: 5, ..GeneticSettings::default() };
        let mut search = search(&[Range::new(0.0, 1.0); 2], settings, 0);
        let mut generations = 0;
        while !search.ask().is_empty() {
            let scores = vec![0.5; search.ask().len()];
            search.tell(&scores);
            generations += 1;
        }
        assert_eq!(generations, 6);
    }

    #[test]
    fn the_default_is_the_papers_in_words_and_evaluations() {
        let words = "population 30, elitism 10 %, crossover 80 %, mutation 20 %";
        assert_eq!((ENTRY.words)(&Settings::default()), words);
        assert_eq!(GeneticSettings::default().budget(), 30 + 99 * 27);
        let short = GeneticSettings { generations: 1, ..GeneticSettings::default() };
        assert_eq!(short.budget(), 30);
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        let wrong = [
            GeneticSettings { population: 1, ..Default::default() },
            GeneticSettings { population: MAX_POPULATION + 1, ..Default::default() },
            GeneticSettings { generations: 0, ..Default::default() },
            GeneticSettings { tournament: 0, ..Default::default() },
            GeneticSettings { tournament: usize::MAX, ..Default::default() },
            GeneticSettings { crossover: 1.1, ..Default::default() },
            GeneticSettings { mutation: f32::NAN, ..Default::default() },
        ];
        for settings in wrong {
            assert!(settings.check().is_err(), "{settings:?}");
        }
    }
}
