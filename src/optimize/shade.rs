//! SHADE, differential evolution that learns its parameters from what has succeeded: Tanabe and Fukunaga (2013),
//! *Success-history based parameter adaptation for differential evolution*, on the strategy current-to-pbest/1 with
//! an archive of Zhang and Sanderson (2009), *JADE*. The population stays as large as it is, so that the search
//! needs no budget and asks for equally many chromosomes at a time.

use super::start::population;
use super::{Best, Entry, Optimizer, Setup, StartSettings};
use crate::error::within;
use crate::math::range::Range;
use crate::{Error, Result};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Cauchy, Distribution, Normal};
use serde::{Deserialize, Serialize};

/// Its name in settings.
pub const NAME: &str = "shade";

pub(crate) const ENTRY: Entry = Entry {
    name: NAME,
    title: "SHADE",
    description: "Differential evolution that learns from its successes, of Tanabe and Fukunaga",
    new: |setup| Ok(Box::new(Shade::new(setup))),
    generations: |settings| Some(settings.genetic.generations),
    words: |settings| format!("SHADE, population {}", settings.genetic.population),
};

/// Most entries of the history.
const MAX_HISTORY: usize = 1 << 12;

/// Settings of SHADE. Population, generations and patience are those of the genetic algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShadeSettings {
    /// Entries of the history of successful parameters (`H`), 1 to 4096.
    pub history: usize,
    /// Individuals of the archive of replaced parents, as a multiple of the population, 0 to 10.
    pub archive: f32,
    /// Largest share of the population that counts as its best (`p`), 0 to 1; two individuals do at least.
    pub best: f32,
    /// A population has settled when its scores differ by no more than this share of the lowest; below 0 none
    /// ever has.
    pub settled: f32,
    /// Populations one after another, 1 or more: each begins where the one before it has settled, at random,
    /// and the search ends with the last.
    pub starts: usize,
}

impl Default for ShadeSettings {
    fn default() -> Self {
        Self { history: 10, archive: 1.0, best: 0.2, settled: 3e-3, starts: 1 }
    }
}

impl ShadeSettings {
    /// The defaults without an end, for a search that runs as long as its caller wants.
    pub fn endless() -> Self {
        Self { starts: usize::MAX, ..Self::default() }
    }

    /// # Errors
    /// [`Error::Argument`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        let Self { history, starts, .. } = *self;
        if !(1..=MAX_HISTORY).contains(&history) {
            let fault = format!("shade.history is {history}: it must be 1 to {MAX_HISTORY}");
            return Err(Error::Argument(fault));
        }
        if starts == 0 {
            return Err(Error::Argument("shade.starts is 0: it must be 1 or more".into()));
        }
        within("shade.archive", self.archive, 0.0, 10.0)?;
        within("shade.best", self.best, 0.0, 1.0)?;
        within("shade.settled", self.settled, -1.0, 1.0)
    }
}

/// The two parameters of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Control {
    /// Probability with which an allele is the mutant's (`CR`).
    crossover: f32,
    /// Length of the differences that are added (`F`).
    factor: f32,
}

impl Control {
    const FIRST: Self = Self { crossover: 0.5, factor: 0.5 };
    /// Spread around an entry of the history: a standard deviation for `crossover`, a scale for `factor`.
    const SPREAD: f32 = 0.1;

    /// Parameters near these.
    fn vary(self, rng: &mut ChaCha8Rng) -> Self {
        let normal = Normal::new(self.crossover, Self::SPREAD);
        let crossover = normal.map_or(self.crossover, |n| n.sample(rng)).clamp(0.0, 1.0);
        let Ok(cauchy) = Cauchy::new(self.factor, Self::SPREAD) else { return self };
        loop {
            let factor = cauchy.sample(rng).min(1.0);
            if factor > 0.0 {
                return Self { crossover, factor };
            }
        }
    }

    /// What succeeded, each weighed by how much it gained: the mean of `crossover`, and the Lehmer mean of
    /// `factor`, which favours long steps.
    fn mean(successes: &[(Self, f64)]) -> Option<Self> {
        let sum = |value: fn(&Self) -> f64| -> f64 {
            successes.iter().map(|(control, gain)| gain * value(control)).sum()
        };
        let gains = sum(|_| 1.0);
        (gains > 0.0).then(|| Self {
            crossover: (sum(|c| f64::from(c.crossover)) / gains) as f32,
            factor: (sum(|c| f64::from(c.factor).powi(2)) / sum(|c| f64::from(c.factor))) as f32,
        })
    }
}

/// The search's state.
#[derive(Debug, Clone)]
pub struct Shade {
    settings: ShadeSettings,
    start: StartSettings,
    /// Generations, and those without a better individual, after which it ends.
    limits: (usize, usize),
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    /// Scored individuals; empty before the first scores of a population.
    population: Vec<Vec<f32>>,
    scores: Vec<f32>,
    /// Parents that a better child has replaced.
    archive: Vec<Vec<f32>>,
    history: Vec<Control>,
    /// The entry of the history that is overwritten next.
    oldest: usize,
    /// Individuals that wait for their scores: a new population, or a trial for each individual.
    asked: Vec<Vec<f32>>,
    /// The trials' parameters.
    controls: Vec<Control>,
    best: Best,
    /// Generations since the start, or since the scores were last renewed.
    generation: usize,
    /// The one of them that the best individual so far is from.
    improved: usize,
    /// The lowest score of each population that has settled.
    ends: Vec<f32>,
}

impl Shade {
    /// A search with settings that have passed their check.
    fn new(Setup { bounds, first, settings, mut rng }: Setup) -> Self {
        let genetic = &settings.genetic;
        let asked = population(bounds, first, genetic.population, &settings.start, &mut rng);
        Self {
            settings: settings.shade,
            start: settings.start,
            limits: (genetic.generations, genetic.patience),
            bounds: bounds.to_vec(),
            rng,
            population: Vec::new(),
            scores: Vec::new(),
            archive: Vec::new(),
            history: vec![Control::FIRST; settings.shade.history],
            oldest: 0,
            asked,
            controls: Vec::new(),
            best: Best::default(),
            generation: 0,
            improved: 0,
            ends: Vec::new(),
        }
    }

    fn finished(&self) -> bool {
        let (generations, patience) = self.limits;
        self.generation >= generations
            || (patience > 0 && self.generation - self.improved >= patience)
            || self.ends.len() >= self.settings.starts
    }

    /// The lowest score, where nothing is left to gain.
    fn settled(&self) -> Option<f32> {
        if self.scores.is_empty() {
            return None;
        }
        let low = self.scores.iter().copied().fold(f32::INFINITY, f32::min);
        let high = self.scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        (high - low <= self.settings.settled * low.abs()).then_some(low)
    }

    /// Asks for a new population: `first`, some scattered around it and the rest uniform, or all uniform.
    fn begin(&mut self, first: Option<Vec<f32>>) {
        let size = self.population.len().max(self.asked.len());
        let scattered = if first.is_some() { self.start.scattered } else { 0.0 };
        let start = StartSettings { scattered, ..self.start };
        let first = first.unwrap_or_else(|| {
            self.bounds.iter().map(|range| range.uniform(&mut self.rng)).collect()
        });
        self.asked = population(&self.bounds, first, size, &start, &mut self.rng);
        self.population.clear();
        self.archive.clear();
        self.controls.clear();
        (self.history, self.oldest) = (vec![Control::FIRST; self.settings.history], 0);
    }

    /// Each trial takes its parent's place where it is no worse; the parameters of those that are better
    /// enter the history.
    fn select(&mut self, scores: &[f32]) {
        let mut successes = Vec::new();
        let controls = std::mem::take(&mut self.controls);
        let trials = std::mem::take(&mut self.asked).into_iter().zip(scores).zip(controls);
        for (at, ((trial, &score), control)) in trials.enumerate() {
            let before = self.scores[at];
            if score <= before {
                let parent = std::mem::replace(&mut self.population[at], trial);
                self.scores[at] = score;
                if score < before {
                    let gain = (f64::from(before) - f64::from(score)).min(f64::from(f32::MAX));
                    successes.push((control, gain));
                    self.archive.push(parent);
                }
            }
        }
        let room = (self.settings.archive * self.population.len() as f32).round() as usize;
        while self.archive.len() > room {
            let one = self.rng.random_range(0..self.archive.len());
            self.archive.swap_remove(one);
        }
        if let Some(mean) = Control::mean(&successes) {
            self.history[self.oldest] = mean;
            self.oldest = (self.oldest + 1) % self.history.len();
        }
    }

    /// Asks for a trial of each individual.
    fn breed(&mut self) {
        let mut order: Vec<usize> = (0..self.population.len()).collect();
        order.sort_by(|&a, &b| self.scores[a].total_cmp(&self.scores[b]));
        for parent in 0..self.population.len() {
            let entry = self.rng.random_range(0..self.history.len());
            let control = self.history[entry].vary(&mut self.rng);
            let mutant = self.mutant(parent, control.factor, &order);
            let sure = self.rng.random_range(0..self.bounds.len().max(1));
            let mut trial = self.population[parent].clone();
            for (at, (allele, new)) in trial.iter_mut().zip(mutant).enumerate() {
                if self.rng.random::<f32>() < control.crossover || at == sure {
                    *allele = new;
                }
            }
            self.asked.push(trial);
            self.controls.push(control);
        }
    }

    /// The parent, moved towards one of the best and by the difference of two others (current-to-pbest/1).
    /// What would leave the box goes half of the way to its side.
    fn mutant(&mut self, parent: usize, factor: f32, order: &[usize]) -> Vec<f32> {
        let size = self.population.len();
        let least = 2.0 / size as f32;
        let share = least + self.rng.random::<f32>() * (self.settings.best - least).max(0.0);
        let among = ((share * size as f32).round() as usize).clamp(1, size);
        let best = order[self.rng.random_range(0..among)];
        let one = skip(self.rng.random_range(0..size - 1), [parent]);
        let others = size + self.archive.len() - 2;
        // In a population of two without an archive there is no third one.
        let other = match others {
            0 => parent,
            _ => skip(self.rng.random_range(0..others), [parent.min(one), parent.max(one)]),
        };
        let [from, best, one] = [parent, best, one].map(|at| &self.population[at]);
        let other = self.population.get(other).unwrap_or_else(|| &self.archive[other - size]);
        let allele = |at: usize| {
            let (range, x) = (&self.bounds[at], from[at]);
            let value = x + factor * (best[at] - x) + factor * (one[at] - other[at]);
            let side = range.nearest(value);
            if value == side { value } else { range.nearest(0.5 * (side + x)) }
        };
        (0..self.bounds.len()).map(allele).collect()
    }
}

/// The number `at` of those that are left without `out`, which ascend.
fn skip<const N: usize>(at: usize, out: [usize; N]) -> usize {
    out.into_iter().fold(at, |at, out| if at >= out { at + 1 } else { at })
}

impl Optimizer for Shade {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        let improved = self.best.offer_all(&self.asked, scores);
        // What is not a number is worse than all else.
        let number = |&score: &f32| if score.is_nan() { f32::INFINITY } else { score };
        let scores: Vec<f32> = scores.iter().map(number).collect();
        if self.population.is_empty() {
            (self.population, self.scores) = (std::mem::take(&mut self.asked), scores);
        } else {
            self.select(&scores);
        }
        self.generation += 1;
        if improved {
            self.improved = self.generation;
        }
        let settled = self.settled();
        self.ends.extend(settled);
        if self.finished() {
            return;
        }
        match settled {
            Some(_) => self.begin(None),
            None => self.breed(),
        }
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    /// Asks for the better half of the population and the trials of the others. Where a population has just
    /// settled it asks for one around the best so far, as the first was around its first individual.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        let best = self.best.get().map(|(best, _)| change(best));
        let settled = self.settled().is_some();
        let mut all = std::mem::take(&mut self.asked);
        if self.controls.is_empty() {
            all.append(&mut self.population);
        } else {
            let mut order: Vec<usize> = (0..all.len()).collect();
            order.sort_by(|&a, &b| self.scores[a].total_cmp(&self.scores[b]));
            for &at in &order[..all.len().div_ceil(2)] {
                std::mem::swap(&mut all[at], &mut self.population[at]);
            }
        }
        self.asked = all.iter().map(|individual| change(individual)).collect();
        self.archive.iter_mut().for_each(|parent| *parent = change(parent));
        self.population.clear();
        self.scores.clear();
        self.controls.clear();
        match best {
            Some(best) if settled => self.begin(Some(best)),
            Some(best) if !self.asked.contains(&best) => self.asked[0] = best,
            _ => {}
        }
        (self.generation, self.improved, self.best) = (0, 0, Best::default());
        self.ends.clear();
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }

    fn minima(&self) -> &[f32] {
        &self.ends
    }
}

#[cfg(test)]
mod tests;
