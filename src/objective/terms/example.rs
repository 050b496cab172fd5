//! Distance from an example (Ha and Olivier 2007, *Perception-based lighting-by-example*): three quarters of the mean
//! distance of its percentiles of brightness from the picture's, as a share of a quarter of the range, and a quarter of
//! the relative distance of the gradients. The first is the first Wasserstein distance of the histograms: mean,
//! range and evenness are part of it. 0 without an example.

use crate::constants::{EXAMPLE_GRADIENT, EXAMPLE_RANGE, GRAD_FLAT};
use crate::objective::maps::ViewStatistics;
use crate::objective::{HISTOGRAM_BINS, Needs, Objective, Statistics, Term};

/// See the module.
pub static TERM: Term = Term {
    name: "example",
    title: "Example",
    meaning: "how far the brightnesses and gradients are from the example's",
    needs: Needs::EXAMPLE,
    formula,
};

fn formula(picture: &Statistics, view: &ViewStatistics, objective: &Objective) -> f32 {
    let Some(example) = &objective.example else { return 0.0 };
    let (mut below, mut apart) = (0, 0.0);
    for (count, wanted) in std::iter::zip(picture.histogram, example.cumulative()) {
        below += count;
        apart += (below as f32 / view.counts.object().max(1) as f32 - wanted).abs();
    }
    let brightness = (apart / HISTOGRAM_BINS as f32 / EXAMPLE_RANGE).min(1.0);
    let most = picture.gradient.max(example.gradient).max(GRAD_FLAT);
    let gradient = (picture.gradient - example.gradient).abs() / most;
    brightness + EXAMPLE_GRADIENT * (gradient - brightness)
}
