//! Light for all objects but some, which are to stay dim.

use crate::Result;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::{Light, Population};
use crate::objective::maps::Maps;
use crate::objective::{Objective, Quality, Term, Terms};
use std::ops::DerefMut;

/// Weight of the term `target`, which is that of the objects that are to stay dim.
pub const DIM_WEIGHT: f32 = 0.5;

/// The brightness that they are to have, sRGB-encoded luminance.
pub const DIM_BRIGHTNESS: f32 = 0.12;

/// The term by which they are judged.
const TARGET: &str = "target";

/// Judges the pictures of a view by all of its objects but some, and by how far those are from dim: `F` is the sum, and the
/// term `target` is theirs.
pub struct Dimmed<E> {
    whole: E,
    lit: E,
    dim: E,
    scores: Vec<f32>,
}

impl<E> Dimmed<E> {
    /// Of the evaluators of the whole view, of the objects that are to be lit and of those that are to stay dim, all of one
    /// view: the maps of the others are those of [`crate::cpu::objects::of_objects`], the last ones' with a target picture of
    /// [`DIM_BRIGHTNESS`], and the objective of these is that of [`objective`].
    pub fn new(whole: E, lit: E, dim: E) -> Self {
        Self { whole, lit, dim, scores: Vec::new() }
    }

    /// The evaluator of the whole view.
    pub fn whole(&self) -> &E {
        &self.whole
    }

    /// The same, for good.
    pub fn into_whole(self) -> E {
        self.whole
    }

    /// The evaluators of the whole view, of the objects that are to be lit and of those that are to stay dim.
    pub fn parts_mut(&mut self) -> [&mut E; 3] {
        [&mut self.whole, &mut self.lit, &mut self.dim]
    }
}

/// What judges the objects that are to stay dim, beside all others that are judged by `others`.
///
/// # Errors
/// None in practice: the term is klieg's own.
pub fn objective(others: &Objective) -> Result<Objective> {
    let weights = Terms::named([(TARGET, DIM_WEIGHT)])?;
    Ok(Objective { weights, ..*others })
}

/// The quality of the lit objects and of the dim ones together.
///
/// # Errors
/// None in practice: the term is klieg's own.
pub fn sum(lit: Quality, dim: Quality) -> Result<Quality> {
    let mut terms = lit.terms;
    let target = Term::named(TARGET)?;
    terms.set(target, dim.terms.get(TARGET).unwrap_or_default())?;
    Ok(Quality { score: lit.score + dim.score, terms })
}

impl<E: DerefMut<Target = dyn Evaluator>> Evaluator for Dimmed<E> {
    fn device(&self) -> &DeviceInfo {
        self.whole.device()
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.scores.resize(scores.len(), 0.0);
        let [lit, dim] = [self.lit.begin(population)?, self.dim.begin(population)?];
        lit(scores)?;
        dim(&mut self.scores)?;
        scores.iter_mut().zip(&self.scores).for_each(|(score, dim)| *score += dim);
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        let lit = self.lit.qualities(population)?;
        let dim = self.dim.qualities(population)?;
        lit.into_iter().zip(dim).map(|(lit, dim)| sum(lit, dim)).collect()
    }

    /// The statistics and the picture are those of the whole view.
    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let whole = self.whole.inspect(rig)?;
        let lit = self.lit.inspect(rig)?.quality();
        let Quality { score, terms } = sum(lit, self.dim.inspect(rig)?.quality())?;
        Ok(Inspection { score, terms, ..whole })
    }

    /// Those of the whole view.
    fn maps(&mut self) -> Result<&Maps> {
        self.whole.maps()
    }
}
