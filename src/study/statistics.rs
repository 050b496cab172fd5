//! What the studies say about samples: quartiles, and the Wilcoxon signed-rank test for pairs.

use serde::Serialize;

/// Least, quartiles and greatest value of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quartiles {
    /// The least value.
    pub low: f32,
    /// A quarter of the sample lies below.
    pub first: f32,
    /// The median.
    pub median: f32,
    /// Three quarters of the sample lie below.
    pub third: f32,
    /// The greatest value.
    pub high: f32,
}

impl Quartiles {
    /// Of a sample; between two values they are interpolated (Hyndman and Fan 1996, type 7). Not a
    /// number for an empty one.
    pub fn of(sample: &[f32]) -> Self {
        let mut sorted = sample.to_vec();
        sorted.sort_by(f32::total_cmp);
        let at = |share: f32| {
            let Some(last) = sorted.len().checked_sub(1) else { return f32::NAN };
            let place = share * last as f32;
            let below = place as usize;
            let above = (below + 1).min(last);
            sorted[below] + (place - below as f32) * (sorted[above] - sorted[below])
        };
        let [low, first, median, third, high] = [0.0, 0.25, 0.5, 0.75, 1.0].map(at);
        Self { low, first, median, third, high }
    }
}

/// Index of the sample's median, the lower of two.
pub fn median_index(sample: &[f32]) -> usize {
    let mut order: Vec<usize> = (0..sample.len()).collect();
    order.sort_by(|&a, &b| sample[a].total_cmp(&sample[b]));
    order.get(sample.len().saturating_sub(1) / 2).copied().unwrap_or(0)
}

/// p-value below which a difference is not put down to chance.
pub const LEVEL: f64 = 0.05;

/// The lowest p-value that [`wilcoxon`] can give for so many pairs: that of differences of one sign.
pub fn least_p_value(pairs: usize) -> f64 {
    (2.0 * 0.5f64.powf(pairs as f64)).min(1.0)
}

/// Two-sided p-value of the Wilcoxon signed-rank test (Wilcoxon 1945): how likely pairs that differ by
/// chance alone are to differ as consistently as `a` and `b` do. Exact, by counting sign patterns;
/// pairs without a difference are left out and equal differences share their ranks' mean. 1 when no
/// pair differs.
pub fn wilcoxon(a: &[f32], b: &[f32]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| f64::from(*a) - f64::from(*b));
    let mut differences: Vec<f64> = differences.filter(|d| *d != 0.0).collect();
    differences.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    // Doubled ranks, so that the mean of two is whole.
    let ranks: Vec<usize> = differences
        .chunk_by(|a, b| a.abs() == b.abs())
        .scan(0, |before, ties| {
            let rank = 2 * *before + ties.len() + 1;
            *before += ties.len();
            Some(std::iter::repeat_n(rank, ties.len()))
        })
        .flatten()
        .collect();
    let signed = |positive: bool| {
        let pairs = ranks.iter().zip(&differences);
        pairs.filter(|(_, d)| (**d > 0.0) == positive).map(|(rank, _)| rank).sum::<usize>()
    };
    let least = signed(true).min(signed(false));
    // The share of sign patterns whose positive ranks have each sum.
    let mut shares = vec![0.0; ranks.iter().sum::<usize>() + 1];
    shares[0] = 1.0;
    let mut reach = 0;
    for &rank in &ranks {
        for sum in (0..=reach).rev() {
            shares[sum] /= 2.0;
            shares[sum + rank] += shares[sum];
        }
        reach += rank;
    }
    (2.0 * shares[..=least].iter().sum::<f64>()).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_numpy_s() {
        let quartiles = Quartiles::of(&[7.0, 1.0, 3.0, 2.0]);
        assert_eq!(
            quartiles,
            Quartiles { low: 1.0, first: 1.75, median: 2.5, third: 4.0, high: 7.0 }
        );
        assert_eq!(Quartiles::of(&[4.0]).third, 4.0);
        assert!(Quartiles::of(&[]).median.is_nan());
    }

    #[test]
    fn the_median_run_is_one_of_the_runs() {
        assert_eq!(median_index(&[0.3, 0.1, 0.2]), 2);
        assert_eq!(median_index(&[0.3, 0.1, 0.2, 0.4]), 2);
        assert_eq!(median_index(&[0.5]), 0);
    }

    /// Pairs whose differences have the ranks 1 to `n`, the first of them negative.
    fn pairs(n: usize, negative: &[usize]) -> (Vec<f32>, Vec<f32>) {
        let sign = |rank: usize| if negative.contains(&rank) { -1.0 } else { 1.0 };
        ((1..=n).map(|rank| sign(rank) * rank as f32).collect(), vec![0.0; n])
    }

    /// The critical values of published tables (Wilcoxon and Wilcox 1964; two-sided 5 % and 1 %): the
    /// largest rank sum that is still significant.
    #[test]
    fn it_agrees_with_published_tables() {
        let table = [
            (6, Some(0), None),
            (7, Some(2), None),
            (8, Some(3), Some(0)),
            (9, Some(5), Some(1)),
            (10, Some(8), Some(3)),
            (11, Some(10), Some(5)),
            (12, Some(13), Some(7)),
            (15, Some(25), Some(15)),
            (20, Some(52), Some(37)),
            (25, Some(89), Some(68)),
            (30, Some(137), Some(109)),
        ];
        // Ranks, greedily the largest first, whose sum is `sum`.
        let with_sum = |n: usize, mut sum: usize| {
            let mut ranks = Vec::new();
            for rank in (1..=n).rev() {
                if rank <= sum {
                    ranks.push(rank);
                    sum -= rank;
                }
            }
            ranks
        };
        let p = |n: usize, sum: usize| {
            let (a, b) = pairs(n, &with_sum(n, sum));
            wilcoxon(&a, &b)
        };
        for (n, five, one) in table {
            for (level, critical) in [(0.05, five), (0.01, one)] {
                if let Some(critical) = critical {
                    assert!(p(n, critical) <= level, "{n} {critical}: {}", p(n, critical));
                    assert!(p(n, critical + 1) > level, "{n} {critical}");
                } else {
                    assert!(p(n, 0) > level, "{n}");
                }
            }
        }
    }

    #[test]
    fn exact_values() {
        let (a, b) = pairs(10, &[]);
        assert_eq!(wilcoxon(&a, &b), 2.0 / 1024.0);
        assert_eq!(wilcoxon(&b, &a), 2.0 / 1024.0);
        // 32 of the 256 sign patterns have a lesser sum of 9 or less.
        let (a, b) = pairs(8, &[3, 6]);
        assert!((wilcoxon(&a, &b) - 0.25).abs() < 1e-12, "{}", wilcoxon(&a, &b));
        // Ties share ranks: of 8 patterns of three equal differences, 2 are as extreme.
        assert_eq!(wilcoxon(&[1.0; 3], &[0.0; 3]), 0.25);
        assert_eq!(wilcoxon(&[1.0, 5.0], &[1.0, 4.0]), 1.0);
        assert_eq!(wilcoxon(&[1.0; 5], &[1.0; 5]), 1.0);
        assert_eq!(wilcoxon(&[], &[]), 1.0);
        for n in 0..12 {
            let (a, b) = pairs(n, &[]);
            assert_eq!(wilcoxon(&a, &b), least_p_value(n));
        }
    }
}
