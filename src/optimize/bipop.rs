//! BIPOP-CMA-ES: runs of CMA-ES one after another, with ever larger populations and, as long, with small ones and short
//! steps: Hansen (2009), *Benchmarking a BI-population CMA-ES on the BBOB-2009 function testbed*.

use super::cma::Run;
use super::{Best, Entry, Optimizer, Setup};
use crate::math::range::Range;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Its name in settings.
pub const NAME: &str = "cma-es";

pub(super) const ENTRY: Entry = Entry {
    name: NAME,
    title: "BIPOP-CMA-ES",
    description: "A normal distribution that learns its shape, with restarts, of Hansen",
    new: |setup| Ok(Box::new(Bipop::new(setup))),
    generations: |_| None,
    words: |settings| format!("BIPOP-CMA-ES, {} evaluations", settings.genetic.budget()),
};

/// First standard deviation as a share of each range.
const STEP: f64 = 0.2;

/// A run has ended when its scores differ by no more than this share of the lowest.
const SETTLED: f32 = 1e-4;

/// Most samples of a generation.
const LARGEST: usize = 1024;

/// Parts of a range at its sides within which samples are drawn towards them.
const MARGIN: f64 = 0.05;

/// What the population of a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Regime {
    /// The default one: the first run.
    First,
    /// Twice that of the last large run, up to [`LARGEST`].
    Large,
    /// Between the default one and half of the last large one.
    Small,
}

/// The search's state.
#[derive(Debug, Clone)]
pub struct Bipop {
    bounds: Vec<Range>,
    rng: ChaCha8Rng,
    /// Evaluations after which it ends; [`usize::MAX`] for never.
    budget: usize,
    evaluations: usize,
    run: Run,
    regime: Regime,
    /// Evaluations of the present run, and after how many it ends at the latest.
    made: usize,
    limit: usize,
    /// Samples of the last large run, and its evaluations.
    large: (usize, usize),
    /// Evaluations of the large runs and of the small ones.
    spent: [usize; 2],
    /// A run's samples; the best so far is the last where all scores have become void.
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
    /// Lowest score of the present run, and of each before it.
    low: f32,
    ends: Vec<f32>,
    best: Best,
}

impl Bipop {
    /// A search around `first`. It ends with the generation in which it has made as many evaluations as the genetic
    /// algorithm would.
    fn new(Setup { bounds, first, settings, rng }: Setup) -> Self {
        let samples = default_samples(bounds.len());
        let mut search = Self {
            bounds: bounds.to_vec(),
            rng,
            budget: settings.genetic.budget(),
            evaluations: 0,
            run: Run::new(into_unit(bounds, &first), STEP, samples),
            regime: Regime::First,
            made: 0,
            limit: usize::MAX,
            large: (samples, 0),
            spent: [0; 2],
            asked: Vec::new(),
            scores: Vec::new(),
            low: f32::INFINITY,
            ends: Vec::new(),
            best: Best::default(),
        };
        search.draw();
        search
    }

    fn draw(&mut self) {
        let points = self.run.sample(&mut self.rng);
        self.asked = points.iter().map(|point| out_of_unit(&self.bounds, point)).collect();
    }

    /// Begins the next run, at random: a small one where small ones have had fewer evaluations than large ones.
    fn restart(&mut self) {
        match self.regime {
            Regime::First | Regime::Large => self.large.1 = self.made,
            Regime::Small => {}
        }
        match self.regime {
            Regime::First => {}
            Regime::Large => self.spent[0] += self.made,
            Regime::Small => self.spent[1] += self.made,
        }
        self.ends.push(self.low);
        let default = default_samples(self.bounds.len());
        let (large, evaluations) = self.large;
        let small = self.regime != Regime::First && self.spent[1] < self.spent[0];
        let (samples, step) = if small {
            let [size, step] = [self.rng.random::<f64>(), self.rng.random()];
            let most = 0.5 * large as f64 / default as f64;
            let samples = default as f64 * most.max(1.0).powf(size * size);
            (self.regime, self.limit) = (Regime::Small, evaluations / 2);
            (samples as usize, STEP * 10f64.powf(-2.0 * step))
        } else {
            let samples = (2 * large).min(LARGEST);
            (self.regime, self.limit, self.large.0) = (Regime::Large, usize::MAX, samples);
            (samples, STEP)
        };
        let mean = self.bounds.iter().map(|_| self.rng.random()).collect();
        self.run = Run::new(mean, step, samples);
        (self.made, self.low) = (0, f32::INFINITY);
    }
}

/// Samples of a generation of CMA-ES, of the number of dimensions.
fn default_samples(dimensions: usize) -> usize {
    4 + (3.0 * (dimensions.max(1) as f64).ln()) as usize
}

impl Optimizer for Bipop {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        if self.evaluations < self.budget { &self.asked } else { &[] }
    }

    fn tell(&mut self, scores: &[f32]) {
        self.best.offer_all(&self.asked, scores);
        // What is not a number is worse than all else.
        let number = |&score: &f32| if score.is_nan() { f32::INFINITY } else { score };
        self.scores = scores.iter().map(number).take(self.run.samples()).collect();
        self.low = self.scores.iter().copied().fold(self.low, f32::min);
        self.evaluations += scores.len();
        self.made += scores.len();
        self.run.update(&self.scores);
        if self.run.has_ended(SETTLED) || self.made >= self.limit {
            self.restart();
        }
        self.draw();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    /// Goes on with the present distribution, which takes its middle along, and asks for the best so far besides.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        let best = self.best.get().map(|(best, _)| change(best));
        let middle = change(&out_of_unit(&self.bounds, self.run.mean()));
        self.run.move_to(into_unit(&self.bounds, &middle));
        self.draw();
        self.asked.extend(best);
        (self.evaluations, self.made, self.low) = (0, 0, f32::INFINITY);
        (self.best, self.scores) = (Best::default(), Vec::new());
        self.ends.clear();
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }

    fn minima(&self) -> &[f32] {
        &self.ends
    }
}

/// Alleles of a point whose coordinates are shares of the ranges. Points are free, so that the distribution keeps its
/// shape: near a side and beyond it they fold back over a parabola, as `BoundTransform` of Hansen's pycma has it.
fn out_of_unit(bounds: &[Range], point: &[f64]) -> Vec<f32> {
    bounds.iter().zip(point).map(|(range, &x)| range.at(fold(x) as f32)).collect()
}

/// The share of a range that a coordinate stands for, 0..=1.
fn fold(x: f64) -> f64 {
    // Mirrored at both ends, it comes again after two turns.
    let width = 1.0 + 2.0 * MARGIN;
    let along = (x + MARGIN).rem_euclid(2.0 * width);
    let x = along.min(2.0 * width - along) - MARGIN;
    let near = |distance: f64| (distance + MARGIN).powi(2) / (4.0 * MARGIN);
    let share = if x < MARGIN {
        near(x)
    } else if x > 1.0 - MARGIN {
        1.0 - near(1.0 - x)
    } else {
        x
    };
    share.clamp(0.0, 1.0)
}

/// The point of a chromosome.
fn into_unit(bounds: &[Range], chromosome: &[f32]) -> Vec<f64> {
    let near = |share: f64| (4.0 * MARGIN * share).sqrt() - MARGIN;
    let coordinate = |(range, &x): (&Range, &f32)| match f64::from(range.share(x)) {
        share if share < MARGIN => near(share),
        share if share > 1.0 - MARGIN => 1.0 - near(1.0 - share),
        share => share,
    };
    bounds.iter().zip(chromosome).map(coordinate).collect()
}

#[cfg(test)]
mod tests;
