//! Coarse first: most of a search looks at small pictures, in which rigs rank nearly as in whole ones, then at larger ones,
//! and the rest of it at whole ones. Scores of pictures of different sizes are never compared.

use super::{Outcome, Progress, Run, without_score};
use crate::Result;
use crate::error::within;
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::objective::{Example, Objective};
use crate::optimize::Optimizer;
use crate::scene::view::View;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Least side of small pictures that are smaller than asked for, pixels.
const LEAST_THIRD: u32 = 64;

/// Share of the generations after those on the smallest pictures that looks at larger ones.
const BETWEEN: f64 = 0.4;

/// How a search begins on small pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoarseSettings {
    /// Longest side of the smallest pictures, pixels, 16 or more; 0 for none. They are of every so-manieth pixel, so that
    /// they may be smaller. Where it is more than a third of the whole picture's it is that third, and where that is
    /// below 64 there are none: they would save too little.
    pub side: u32,
    /// Share of a search's generations that looks at the smallest pictures at most, 0 to 1.
    pub share: f32,
    /// It stops earlier when the population's scores differ by no more than this share of the lowest, 0 to 1: small
    /// pictures do not tell what differs so little.
    pub settled: f32,
    /// Searches side by side on the smallest pictures, 1 to 64, of which the best goes on.
    pub searches: u32,
}

impl Default for CoarseSettings {
    fn default() -> Self {
        Self::NONE
    }
}

impl CoarseSettings {
    /// Without small pictures.
    pub const NONE: Self = Self { side: 0, share: 0.5, settled: 0.1, searches: 1 };

    /// # Errors
    /// [`crate::Error::Argument`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        if self.side > 0 {
            within("coarse.side", self.side as f32, 16.0, 16384.0)?;
        }
        within("coarse.share", self.share, 0.0, 1.0)?;
        within("coarse.searches", self.searches as f32, 1.0, 64.0)?;
        within("coarse.settled", self.settled, 0.0, 1.0)
    }

    /// Of every how manieth pixel along both sides the small pictures are, the smallest first, where whole ones are of
    /// such width and height; empty where there are no small ones.
    pub fn steps(&self, [width, height]: [u32; 2]) -> Vec<u32> {
        let longest = width.max(height);
        let third = longest / 3;
        if self.side == 0 || self.share == 0.0 || self.side > third && third < LEAST_THIRD {
            return Vec::new();
        }
        let first = longest.div_ceil(self.side).max(3);
        vec![first, f64::from(first).sqrt().round() as u32]
    }
}

/// What judges `small` pictures as `objective` judges those of `whole`: from pixel to pixel depth changes by more, and
/// smooth surfaces must not count as edges. So does brightness, and an example's with it.
pub fn objective(objective: &Objective, whole: &View, small: &View) -> Objective {
    let scale = whole.width.max(whole.height) as f32 / small.width.max(small.height) as f32;
    Objective {
        edge_sobel: scale * objective.edge_sobel,
        edge_laplace: scale * objective.edge_laplace,
        example: objective
            .example
            .map(|example| Example { gradient: (scale * example.gradient).min(1.0), ..example }),
        ..*objective
    }
}

/// What measures small pictures.
pub struct Small<E> {
    /// They are of every `step`-th pixel along both sides.
    pub step: u32,
    /// What measures them.
    pub evaluator: E,
}

/// Runs a search that counts generations: its first ones on small pictures, the smallest first, which `small` measures, the
/// others on whole ones. From one size to the next it goes on with what it holds, all scored anew. `generations` are
/// those of all together.
///
/// The history has the scores as they were, and says of which pictures they are; the outcome's is that of the whole one.
///
/// # Errors
/// As [`run`](super::run).
pub fn run_coarse_first<E: Evaluator>(
    search: &mut dyn Optimizer,
    genome: &Genome,
    (small, evaluator): (&mut [Small<E>], &mut dyn Evaluator),
    (settings, generations): (&CoarseSettings, usize),
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let mut run = Run::new(genome)?;
    let mut stopped = false;
    for (number, Small { step, evaluator: small }) in small.iter_mut().enumerate() {
        let made = run.history.len();
        let (share, settled) = match number {
            0 => (f64::from(settings.share), settings.settled),
            _ => (BETWEEN, 0.0),
        };
        let last = made + ((generations - made) as f64 * share) as usize;
        if stopped || last == made {
            continue;
        }
        run.step = *step;
        run.go(search, small, &mut |progress| {
            stopped = observe(progress).is_break();
            let spread = progress.worst - progress.best;
            let settled = spread <= settled * progress.best.abs();
            if stopped || settled || progress.generation >= last {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })?;
        if !stopped {
            search.refine();
        }
    }
    run.step = 1;
    if stopped {
        let (best, _) = search.best().ok_or_else(|| without_score(search))?;
        let (rig, best) = (genome.decode(best), [best.to_vec()]);
        run.batch.clear();
        run.batch.add(search, &best)?;
        let score = run.batch.evaluate(evaluator)?[0];
        return Ok(Outcome { rig, score, history: run.history, stopped });
    }
    run.go(search, evaluator, &mut |progress| {
        stopped = observe(progress).is_break();
        if stopped || progress.generation >= generations {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })?;
    run.finish(search, genome, stopped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::testing::{Hills, genome, height};
    use crate::lighting::Light;
    use crate::math::range::Range;
    use crate::optimize::{self, Settings, Setup, shade};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn search(genome: &Genome) -> Box<dyn Optimizer> {
        let (bounds, settings) = (genome.bounds(), &Settings::default());
        let first = bounds.iter().map(Range::middle).collect();
        let setup = Setup { bounds, first, settings, rng: ChaCha8Rng::seed_from_u64(1) };
        optimize::create(shade::NAME, setup).unwrap()
    }

    /// The outcome, and how often the evaluator of each size was called. Small pictures score 10 more.
    fn run(settings: CoarseSettings, steps: &[u32], stop: usize) -> (Outcome, Vec<usize>) {
        let genome = genome();
        let hills = || Hills { base: 10.0, ..Hills::default() };
        let mut small: Vec<_> =
            steps.iter().map(|&step| Small { step, evaluator: hills() }).collect();
        let mut whole = Hills::default();
        let outcome = run_coarse_first(
            &mut *search(&genome),
            &genome,
            (&mut small, &mut whole),
            (&settings, 40),
            &mut |progress| match progress.generation == stop {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            },
        );
        let calls = small.iter().map(|small| small.evaluator.calls).chain([whole.calls]);
        (outcome.unwrap(), calls.collect())
    }

    fn score(outcome: &Outcome) -> f32 {
        height(&outcome.rig.iter().map(Light::record).collect::<Vec<_>>())
    }

    const SHARE: CoarseSettings =
        CoarseSettings { side: 16, share: 0.6, settled: 0.0, searches: 1 };

    #[test]
    fn the_first_generations_look_at_small_pictures_and_the_score_is_of_whole_ones() {
        let (outcome, calls) = run(SHARE, &[4], usize::MAX);
        assert_eq!((calls, outcome.history.len(), outcome.stopped), (vec![24, 16], 40, false));
        let bests: Vec<f32> = outcome.history.iter().map(|progress| progress.best).collect();
        assert!(bests[..24].iter().all(|&best| best > 5.0) && bests[24..].iter().all(|&b| b < 5.0));
        assert!(bests[24..].is_sorted_by(|a, b| a >= b));
        let step = |generation| if generation <= 24 { 4 } else { 1 };
        assert!(outcome.history.iter().all(|p| p.step == step(p.generation)));
        assert_eq!(outcome.score, bests[39]);
        assert_eq!(score(&outcome), outcome.score);
        assert_eq!(outcome.evaluations(), 40 * 30);
        // What was learnt on small pictures counts: the same number of whole ones alone ends higher.
        assert!(bests[24] < bests[0] - 10.0 - 0.1, "{bests:?}");
    }

    #[test]
    fn larger_pictures_come_between() {
        let (outcome, calls) = run(SHARE, &[4, 2], usize::MAX);
        assert_eq!((calls, outcome.stopped), (vec![24, 6, 10], false));
        let steps: Vec<u32> = outcome.history.iter().map(|progress| progress.step).collect();
        assert_eq!(steps, [vec![4; 24], vec![2; 6], vec![1; 10]].concat());
        let best = |at: usize| outcome.history[at].best;
        assert!(best(29) <= best(24) && best(29) > 5.0 && best(39) < 5.0);
        assert_eq!((score(&outcome), outcome.score), (outcome.score, best(39)));
        let (outcome, calls) = run(SHARE, &[4, 2], 30);
        assert_eq!((calls, outcome.history.len(), outcome.stopped), (vec![24, 6, 1], 30, true));
        assert_eq!(score(&outcome), outcome.score);
        assert_eq!(run(SHARE, &[4, 2], 5).1, [5, 0, 1]);
        assert_eq!(run(CoarseSettings { share: 1.0, ..SHARE }, &[4, 2], usize::MAX).1, [40, 0, 1]);
    }

    #[test]
    fn sizes_follow_from_that_of_the_whole_picture() {
        let natural = CoarseSettings { side: 128, ..CoarseSettings::NONE };
        let steps = |settings: CoarseSettings, width, height| settings.steps([width, height]);
        for (width, height, expected) in [
            (512, 512, vec![4, 2]),
            (384, 200, vec![3, 2]),
            (200, 385, vec![4, 2]),
            (192, 192, vec![3, 2]),
            (1920, 1080, vec![15, 4]),
            (191, 191, vec![]),
        ] {
            assert_eq!(steps(natural, width, height), expected, "{width}x{height}");
        }
        let tiny = CoarseSettings { side: 16, ..natural };
        assert_eq!((steps(tiny, 60, 60), steps(tiny, 40, 40)), (vec![4, 2], vec![]));
        assert!(steps(CoarseSettings::NONE, 512, 512).is_empty());
        assert!(steps(CoarseSettings { share: 0.0, ..natural }, 512, 512).is_empty());
    }

    #[test]
    fn small_pictures_end_where_they_tell_no_more() {
        let (_, calls) = run(CoarseSettings { settled: 0.3, ..SHARE }, &[4], usize::MAX);
        assert!(calls[0] < 24 && calls[0] + calls[1] == 40, "{calls:?}");
        assert_eq!(run(CoarseSettings { share: 0.0, ..SHARE }, &[4], usize::MAX).1, [0, 40]);
        assert_eq!(run(CoarseSettings { share: 1.0, ..SHARE }, &[4], usize::MAX).1, [40, 1]);
    }

    #[test]
    fn a_search_that_is_stopped_has_the_score_of_the_whole_picture() {
        for (stop, calls) in [(5, vec![5, 1]), (30, vec![24, 6])] {
            let (outcome, made) = run(SHARE, &[4], stop);
            assert_eq!((made, outcome.history.len(), outcome.stopped), (calls, stop, true));
            assert_eq!(score(&outcome), outcome.score);
        }
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        for (settings, name) in [
            (CoarseSettings { side: 15, ..SHARE }, "coarse.side"),
            (CoarseSettings { share: 1.1, ..SHARE }, "coarse.share"),
            (CoarseSettings { settled: -0.1, ..SHARE }, "coarse.settled"),
        ] {
            assert!(settings.check().unwrap_err().to_string().contains(name));
        }
        CoarseSettings::default().check().unwrap();
    }
}
