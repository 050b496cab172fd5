//! A run of CMA-ES, which samples a normal distribution and moves, scales and turns it towards the better half of what
//! it sampled: Hansen (2016), *The CMA evolution strategy: a tutorial*, whose equations are named. Coordinates are the
//! searcher's own; [`super::bipop`] makes alleles of them.

use crate::math::eigen;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;

/// Most that the axes' variances may differ before a distribution is given up.
const CONDITION: f64 = 1e14;

/// Standard deviation along the longest axis below which coordinates, single precision in 0..1, no longer differ.
const FINEST: f64 = 1e-7;

/// Longest step, so that a landscape without slopes cannot take it beyond all numbers.
const LONGEST: f64 = 10.0;

/// How fast the distribution learns, of the number of dimensions and samples alone (table 1).
#[derive(Debug, Clone)]
struct Rates {
    /// Of each sample, the best first; those of the worse half are below 0.
    weights: Vec<f64>,
    /// How many samples the weighted mean is worth (`μ_eff`).
    worth: f64,
    /// Of the paths (`c_c`, `c_σ`), and the damping of the step (`d_σ`).
    path: f64,
    step_path: f64,
    damping: f64,
    /// Of the rank-one and the rank-μ update (`c_1`, `c_μ`).
    one: f64,
    all: f64,
}

impl Rates {
    fn new(dimensions: usize, samples: usize) -> Self {
        let n = dimensions as f64;
        let raw = |i: usize| ((samples as f64 + 1.0) / 2.0).ln() - ((i + 1) as f64).ln();
        let raw: Vec<f64> = (0..samples).map(raw).collect();
        let (better, worse) = raw.split_at(samples / 2);
        let sum = |w: &[f64]| w.iter().sum::<f64>();
        let worth_of = |w: &[f64]| sum(w).powi(2) / w.iter().map(|w| w * w).sum::<f64>();
        let (worth, negative) = (worth_of(better), worth_of(worse));
        let one = 2.0 / ((n + 1.3).powi(2) + worth);
        let all =
            (2.0 * (0.25 + worth + 1.0 / worth - 2.0) / ((n + 2.0).powi(2) + worth)).min(1.0 - one);
        // Equations 50 to 52: the matrix stays positive definite.
        let least = (1.0 + one / all)
            .min(1.0 + 2.0 * negative / (worth + 2.0))
            .min((1.0 - one - all) / (n * all));
        let weight = |&w: &f64| if w > 0.0 { w / sum(better) } else { least * w / -sum(worse) };
        let step_path = (worth + 2.0) / (n + worth + 5.0);
        Self {
            weights: raw.iter().map(weight).collect(),
            worth,
            path: (4.0 + worth / n) / (n + 4.0 + 2.0 * worth / n),
            step_path,
            damping: 1.0 + 2.0 * (((worth - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + step_path,
            one,
            all,
        }
    }

    /// Generations for which the axes may be kept.
    fn laziness(&self, dimensions: usize) -> usize {
        ((0.1 / (dimensions as f64 * (self.one + self.all))) as usize).max(1)
    }
}

/// The state of a run.
#[derive(Debug, Clone)]
pub struct Run {
    rates: Rates,
    mean: Vec<f64>,
    step: f64,
    /// The covariance matrix (`C`), row after row, its axes (`B`) and their standard deviations (`D`).
    covariance: Vec<f64>,
    axes: Vec<f64>,
    lengths: Vec<f64>,
    /// The evolution paths (`p_c`, `p_σ`).
    path: Vec<f64>,
    step_path: Vec<f64>,
    /// Standard normal numbers of each sample (`z`), and what they are in the distribution (`y`).
    normals: Vec<Vec<f64>>,
    steps: Vec<Vec<f64>>,
    generation: usize,
    /// Lowest scores of the last generations, and the highest score of the last one.
    lows: VecDeque<f32>,
    high: f32,
}

impl Run {
    /// A run around `mean`, `samples` (4 or more) a generation, with the first step `step`.
    pub fn new(mean: Vec<f64>, step: f64, samples: usize) -> Self {
        let n = mean.len();
        let mut unit = vec![0.0; n * n];
        (0..n).for_each(|i| unit[i * n + i] = 1.0);
        Self {
            rates: Rates::new(n.max(1), samples),
            mean,
            step,
            covariance: unit.clone(),
            axes: unit,
            lengths: vec![1.0; n],
            path: vec![0.0; n],
            step_path: vec![0.0; n],
            normals: Vec::new(),
            steps: Vec::new(),
            generation: 0,
            lows: VecDeque::new(),
            high: f32::INFINITY,
        }
    }

    /// The distribution's middle.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Goes on around another middle.
    pub fn move_to(&mut self, mean: Vec<f64>) {
        self.mean = mean;
        self.lows.clear();
    }

    /// Samples of a generation.
    pub fn samples(&self) -> usize {
        self.rates.weights.len()
    }

    /// Draws a generation (equations 38 to 40).
    pub fn sample(&mut self, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let n = self.mean.len();
        let mut normal = |_| (0..n).map(|_| StandardNormal.sample(rng)).collect::<Vec<f64>>();
        self.normals = (0..self.samples()).map(&mut normal).collect();
        self.steps = self.normals.iter().map(|z| self.turn(z, true)).collect();
        let place = |y: &Vec<f64>| (0..n).map(|i| self.mean[i] + self.step * y[i]).collect();
        self.steps.iter().map(place).collect()
    }

    /// `B D z`, or `B z`.
    fn turn(&self, z: &[f64], scaled: bool) -> Vec<f64> {
        let n = z.len();
        let length = |k: usize| if scaled { self.lengths[k] } else { 1.0 };
        let part = |i: usize| (0..n).map(|k| self.axes[i * n + k] * length(k) * z[k]).sum();
        (0..n).map(part).collect()
    }

    /// Learns from the scores of what was sampled last (equations 41 to 47).
    pub fn update(&mut self, scores: &[f32]) {
        let (n, samples) = (self.mean.len(), self.samples());
        let mut order: Vec<usize> = (0..samples).collect();
        order.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]));
        self.generation += 1;
        self.note(scores[order[0]], scores[order[samples - 1]]);

        let Rates { worth, path, step_path, damping, .. } = self.rates;
        let better = || std::iter::zip(&self.rates.weights, &order).take(samples / 2);
        let mean_of = |of: &[Vec<f64>], i: usize| better().map(|(w, &at)| w * of[at][i]).sum();
        let step: Vec<f64> = (0..n).map(|i| mean_of(&self.steps, i)).collect();
        let normal: Vec<f64> = (0..n).map(|i| mean_of(&self.normals, i)).collect();
        let white = self.turn(&normal, false);
        let gain = (step_path * (2.0 - step_path) * worth).sqrt();
        advance(&mut self.mean, 1.0, self.step, &step);
        advance(&mut self.step_path, 1.0 - step_path, gain, &white);
        let length = self.step_path.iter().map(|x| x * x).sum::<f64>().sqrt();
        let expected = expected_length(n);
        let started = 1.0 - (1.0 - step_path).powi(2 * self.generation.min(1 << 20) as i32);
        let stalls = length / started.sqrt() >= (1.4 + 2.0 / (n as f64 + 1.0)) * expected;
        let gain = if stalls { 0.0 } else { (path * (2.0 - path) * worth).sqrt() };
        advance(&mut self.path, 1.0 - path, gain, &step);
        self.learn(&order, if stalls { path * (2.0 - path) } else { 0.0 });
        let growth = ((step_path / damping) * (length / expected - 1.0)).exp();
        self.step = (self.step * growth).min(LONGEST);
        if self.generation.is_multiple_of(self.rates.laziness(n)) {
            self.find_axes();
        }
    }

    /// The covariance's update (equation 47); `lost` makes up for a path that stood still.
    fn learn(&mut self, order: &[usize], lost: f64) {
        let n = self.mean.len();
        let Rates { one, all, weights, .. } = &self.rates;
        let kept = 1.0 + one * lost - one - all * weights.iter().sum::<f64>();
        self.covariance.iter_mut().for_each(|c| *c *= kept);
        let mut add = |weight: f64, y: &[f64]| {
            for i in 0..n {
                for j in 0..n {
                    self.covariance[i * n + j] += weight * y[i] * y[j];
                }
            }
        };
        add(*one, &self.path);
        for (&weight, &at) in std::iter::zip(weights, order) {
            let length2: f64 = self.normals[at].iter().map(|z| z * z).sum();
            let weight =
                if weight > 0.0 { weight } else { weight * n as f64 / length2.max(1e-300) };
            add(all * weight, &self.steps[at]);
        }
    }

    fn find_axes(&mut self) {
        let (values, axes) = eigen::symmetric(self.covariance.clone(), self.mean.len());
        self.lengths = values.iter().map(|value| value.max(1e-300).sqrt()).collect();
        self.axes = axes;
    }

    fn note(&mut self, low: f32, high: f32) {
        self.high = high;
        self.lows.push_back(low);
        // Ten generations and 30 n/λ, as TolHistFun of Hansen (2009).
        let span = 10 + (30 * self.mean.len()).div_ceil(self.samples());
        while self.lows.len() > span {
            self.lows.pop_front();
        }
        self.lows.shrink_to(span);
    }

    /// Whether nothing is left to gain: the scores of the last generation, or the lowest ones of those before it, differ
    /// by no more than `share` of the lowest; or the distribution is too small or too thin.
    pub fn has_ended(&self, share: f32) -> bool {
        let Some(&low) = self.lows.back() else { return false };
        let span = 10 + (30 * self.mean.len()).div_ceil(self.samples());
        let most = self.lows.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let least = self.lows.iter().copied().fold(f32::INFINITY, f32::min);
        let close = |low: f32, high: f32| high - low <= share * low.abs();
        let long = self.lengths.iter().copied().fold(0.0, f64::max);
        let short = self.lengths.iter().copied().fold(f64::INFINITY, f64::min);
        close(low, self.high)
            || (self.lows.len() >= span && close(least, most))
            || self.step * long < FINEST
            || long * long > CONDITION * short * short
    }
}

/// `a = keep·a + gain·b`.
fn advance(a: &mut [f64], keep: f64, gain: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a = keep * *a + gain * b);
}

/// Expected length of a standard normal vector.
fn expected_length(dimensions: usize) -> f64 {
    let n = dimensions.max(1) as f64;
    n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n))
}

#[cfg(test)]
mod tests;
