//! How often a generation is measured, and what the times say.

use crate::Result;
use std::time::{Duration, Instant};

/// Generations, at least, before the median is trusted.
const LEAST: usize = 20;
/// Chance that the median's interval misses it.
const MISS: f64 = 0.05;
/// Warming up goes on at least so long, so that clocks have risen.
const WARM: Duration = Duration::from_millis(100);

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Generations before the measured ones, at least.
    pub warm_up: u32,
    /// Most measured generations.
    pub runs: u32,
    /// Most time for warming up and for measuring, each; a generation that has begun is ended.
    pub limit: Duration,
    /// Half-width of the median's 95 % interval, as a share of it, that is enough.
    pub precision: f64,
}

/// The measured wall times of generations, milliseconds.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Ascending; never empty.
    pub sorted: Vec<f64>,
}

impl Plan {
    /// Calls `generation`, which gives its wall time in milliseconds, to warm up, and then again
    /// until the median is known. `keep` is told before each call whether it counts.
    ///
    /// # Errors
    /// What `generation` returns.
    pub fn sample(&self, mut generation: impl FnMut(bool) -> Result<f64>) -> Result<Sample> {
        let (begin, mut warm) = (Instant::now(), 0);
        while warm < self.warm_up.max(1) || begin.elapsed() < WARM.min(self.limit) {
            generation(false)?;
            warm += 1;
            if begin.elapsed() >= self.limit {
                break;
            }
        }
        let begin = Instant::now();
        let mut sample = Sample { sorted: Vec::with_capacity(self.runs as usize) };
        loop {
            let time = generation(true)?;
            let place = sample.sorted.partition_point(|&other| other <= time);
            sample.sorted.insert(place, time);
            let count = sample.sorted.len();
            let enough = count >= LEAST && sample.spread().is_some_and(|s| s <= self.precision);
            if enough || count >= self.runs as usize || begin.elapsed() >= self.limit {
                return Ok(sample);
            }
        }
    }
}

impl Sample {
    pub fn median(&self) -> f64 {
        median(&self.sorted)
    }

    /// The nearest-rank percentile.
    pub fn percentile(&self, share: f64) -> f64 {
        let rank = (share * self.sorted.len() as f64).ceil() as usize;
        self.sorted[rank.max(1) - 1]
    }

    /// A 95 % confidence interval of the median by order statistics, which asks nothing of the
    /// times' distribution: the `k`-th lowest and highest times miss the median with the chance that a
    /// fair coin shows one side less than `k` times. None for fewer than six times.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let n = self.sorted.len();
        let (mut chance, mut tail, mut k) = (0.5f64.powi(n as i32), 0.0, 0);
        while k < n && tail + chance <= MISS / 2.0 {
            tail += chance;
            k += 1;
            chance *= (n - k + 1) as f64 / k as f64;
        }
        Some([self.sorted[k.checked_sub(1)?], self.sorted[n - k]])
    }

    /// Half-width of the interval, as a share of the median.
    pub fn spread(&self) -> Option<f64> {
        self.interval().map(|[low, high]| (high - low) / 2.0 / self.median())
    }
}

/// Median of sorted values, at least one.
pub fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(count: u32) -> Sample {
        Sample { sorted: (1..=count).map(f64::from).collect() }
    }

    #[test]
    fn medians_and_percentiles() {
        assert_eq!(median(&[1.0, 2.0, 3.0]), 2.0);
        assert_eq!(median(&[1.0, 2.0, 3.0, 4.0]), 2.5);
        assert_eq!(sample(20).percentile(0.95), 19.0);
        assert_eq!(sample(1).percentile(0.95), 1.0);
    }

    #[test]
    fn intervals_have_the_ranks_of_the_tables() {
        // Table A-3 of Hahn and Meeker, Statistical Intervals; the chance is at least 95 %.
        for (count, ranks) in [(6, [1, 6]), (10, [2, 9]), (20, [6, 15]), (100, [40, 61])] {
            assert_eq!(sample(count).interval(), Some(ranks.map(f64::from)), "{count}");
        }
        assert_eq!(sample(5).interval(), None);
        let [low, high] = sample(1000).interval().unwrap();
        assert!((low - 469.0).abs() <= 1.0 && (high - 532.0).abs() <= 1.0, "{low} {high}");
    }

    #[test]
    fn measuring_ends_when_the_median_is_known_or_the_budget_is_spent() {
        let limit = Duration::from_secs(60);
        let plan = Plan { warm_up: 3, runs: 300, limit, precision: 0.02 };
        let runs = |plan: &Plan, time: &dyn Fn(usize) -> f64| {
            let (mut cold, mut warm) = (0usize, 0);
            let sample = plan.sample(|counts| {
                let calls = if counts { &mut warm } else { &mut cold };
                *calls += 1;
                Ok(time(*calls))
            });
            assert!(cold >= plan.warm_up.max(1) as usize);
            assert_eq!(sample.unwrap().sorted.len(), warm);
            warm
        };
        assert_eq!(runs(&plan, &|_| 1.0), LEAST);
        assert_eq!(runs(&plan, &|call| 1.0 + (call % 2) as f64), 300);
        assert_eq!(runs(&Plan { runs: 4, ..plan }, &|_| 1.0), 4);
        let slow = |_| {
            std::thread::sleep(Duration::from_millis(10));
            10.0
        };
        // A sleep lasts at least as long as asked for, so that three of them reach the limit.
        let short = Plan { limit: Duration::from_millis(30), warm_up: 1, ..plan };
        assert!((1..=3).contains(&runs(&short, &slow)));
        let none = Plan { limit: Duration::ZERO, warm_up: 1, ..plan };
        assert_eq!(runs(&none, &|_| 1.0), 1);
    }
}
