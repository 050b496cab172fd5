//! Light for some objects more than for all others.

use crate::Result;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::{Light, Population};
use crate::objective::maps::Maps;
use crate::objective::{Quality, Term};
use std::ops::DerefMut;

/// What the objects in focus count for; the whole picture counts for the rest.
pub const FOCUS_SHARE: f32 = 0.75;

/// Judges the pictures of a view by some of its objects and by all of it: `F` and every term are the weighted means
/// of the two. Both evaluators are of the same view; the maps of the second are those of
/// [`crate::cpu::objects::of_objects`].
pub struct Focused<E> {
    whole: E,
    part: E,
    scores: Vec<f32>,
}

impl<E> Focused<E> {
    /// Of the evaluators of the whole view and of the objects in focus.
    pub fn new(whole: E, part: E) -> Self {
        Self { whole, part, scores: Vec::new() }
    }

    /// The evaluator of the whole view.
    pub fn whole(&self) -> &E {
        &self.whole
    }

    /// The same, for good.
    pub fn into_whole(self) -> E {
        self.whole
    }

    /// The evaluators of the whole view and of the objects in focus.
    pub fn parts_mut(&mut self) -> [&mut E; 2] {
        [&mut self.whole, &mut self.part]
    }
}

/// The mean of what the whole view and the objects in focus have.
fn mean(whole: f32, part: f32) -> f32 {
    whole + FOCUS_SHARE * (part - whole)
}

/// The quality of the whole view and of the objects in focus together.
pub fn mean_quality(whole: Quality, part: Quality) -> Quality {
    let of_part = |term: &Term, whole| part.terms.get(term.name).unwrap_or(whole);
    let terms = whole.terms.map(|term, whole| mean(whole, of_part(term, whole)));
    Quality { score: mean(whole.score, part.score), terms }
}

impl<E: DerefMut<Target = dyn Evaluator>> Evaluator for Focused<E> {
    fn device(&self) -> &DeviceInfo {
        self.whole.device()
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.scores.resize(scores.len(), 0.0);
        let [whole, part] = [self.whole.begin(population)?, self.part.begin(population)?];
        whole(scores)?;
        part(&mut self.scores)?;
        scores.iter_mut().zip(&self.scores).for_each(|(score, &part)| *score = mean(*score, part));
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        let whole = self.whole.qualities(population)?;
        let part = self.part.qualities(population)?;
        Ok(whole.into_iter().zip(part).map(|(whole, part)| mean_quality(whole, part)).collect())
    }

    /// The statistics and the picture are those of the whole view.
    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let whole = self.whole.inspect(rig)?;
        let Quality { score, terms } =
            mean_quality(whole.quality(), self.part.inspect(rig)?.quality());
        Ok(Inspection { score, terms, ..whole })
    }

    /// Those of the whole view.
    fn maps(&mut self) -> Result<&Maps> {
        self.whole.maps()
    }
}
