//! `F_hist`, evenness of the histogram (Ha and Olivier 2006, section 3): `1 − H / ln 32` with the entropy
//! `H` in nats.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};
use crate::objective::HISTOGRAM_BINS;

/// See the module.
pub static TERM: Term = Term {
    name: "hist",
    title: "Histogram",
    meaning: "how unevenly the brightnesses are used",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    1.0 - entropy(&picture.histogram) / (HISTOGRAM_BINS as f32).ln()
}

/// Entropy of a histogram, nats.
fn entropy(histogram: &[u32]) -> f32 {
    let total: u32 = histogram.iter().sum();
    let share = |&count: &u32| count as f32 / total as f32;
    -histogram.iter().filter(|&&count| count > 0).map(share).map(|p| p * p.ln()).sum::<f32>()
}
