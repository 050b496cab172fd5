//! The seam between search and measurement: populations of rigs in, scores out.

use crate::lighting::{Light, LightRecord, Population};
use crate::objective::maps::Maps;
use crate::objective::{Quality, Statistics, Terms};
use crate::{Error, Result};
use serde::Serialize;

/// What computes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// The device's own name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` (a Vulkan device without a GPU), `cpu` (the
    /// native evaluator) or `other`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Driver's name and version; klieg's own for the native evaluator.
    pub driver: String,
}

/// What is known of one individual.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// `F`.
    pub score: f32,
    /// Its terms.
    pub terms: Terms,
    /// What they were made from.
    pub statistics: Statistics,
    /// The picture `I` that was judged: sRGB-encoded luminance 0..=1, 0 in the background, one entry
    /// a pixel, rows from the top.
    pub picture: Vec<f32>,
}

impl Inspection {
    /// `F` and the terms.
    pub fn quality(&self) -> Quality {
        Quality { score: self.score, terms: self.terms }
    }
}

/// Waits for what a device measures of a population, and gives `F` of every rig as [`Evaluator::evaluate`] does.
pub type Pending<'a> = Box<dyn FnOnce(&mut [f32]) -> Result<()> + 'a>;

/// Measures populations of rigs against one view of one scene.
pub trait Evaluator {
    /// What computes.
    fn device(&self) -> &DeviceInfo;

    /// `F` of every rig: `scores[i]` belongs to the `i`-th rig.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] unless `scores` has one place for each rig, and
    /// [device errors](crate::Error::is_device).
    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()>;

    /// Begins what [`Evaluator::evaluate`] does and returns what ends it. Where a device works beside its host, it does so
    /// in between: several evaluators that are all begun before the first is ended let it work without a pause. An
    /// evaluator that has no such device measures at the end.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`], of what is begun; the end has those of the rest.
    fn begin<'a>(&'a mut self, population: &'a Population) -> Result<Pending<'a>> {
        Ok(Box::new(|scores| self.evaluate(population, scores)))
    }

    /// `F` and the terms of every rig, in order. `F` has the bits that [`Evaluator::evaluate`] gives.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>>;

    /// The terms and the picture of one rig.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection>;

    /// The view's maps; read back from the device at the first call.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn maps(&mut self) -> Result<&Maps>;
}

/// # Errors
/// [`Error::Argument`] unless there is one place for the score of each rig.
pub(crate) fn check_places(population: &Population, scores: &[f32]) -> Result<()> {
    let (rigs, places) = (population.len(), scores.len());
    match rigs == places {
        true => Ok(()),
        false => Err(Error::Argument(format!("{places} places for the scores of {rigs} rigs"))),
    }
}

/// # Errors
/// [`Error::NotANumber`] that tells the first rig whose score is none.
pub(crate) fn check_scores(population: &Population, scores: &[f32]) -> Result<()> {
    let none = population.rigs().zip(scores).find(|(_, score)| score.is_nan());
    none.map_or(Ok(()), |(rig, _)| Err(Error::NotANumber { rig: in_words(rig) }))
}

fn in_words(rig: &[LightRecord]) -> String {
    let light = |light: &LightRecord| {
        let LightRecord { position: [x, y, z], radius2, diffuse, specular, .. } = light;
        let place = if *radius2 > 0.0 { "at" } else { "from" };
        format!("a light {place} ({x}, {y}, {z}) of diffuse {diffuse} and specular {specular}")
    };
    rig.iter().map(light).collect::<Vec<_>>().join(", ")
}
