//! One rig for many views.

use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::{Light, LightRecord, Population, Role, Stand};
use crate::math::frame::{Change, Frame};
use crate::objective::maps::Maps;
use crate::objective::{Quality, Term};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::DerefMut;
use std::str::FromStr;

/// How the scores of all views become one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Their mean.
    #[default]
    Mean,
    /// The highest, which is the worst.
    Worst,
}

impl FromStr for Over {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = [Self::Mean, Self::Worst];
        let named = all.into_iter().find(|one| one.name() == text);
        named.ok_or_else(|| format!("'{text}' is neither {} nor {}", all[0].name(), all[1].name()))
    }
}

impl Over {
    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Worst => "worst",
        }
    }

    /// The quality of a rig over all views: the means of score and terms, or those of the first of the worst views.
    fn combined(self, first: Quality, others: &[Quality]) -> Quality {
        let worse = |a: Quality, b: &Quality| if b.score > a.score { *b } else { a };
        if self == Self::Worst {
            return others.iter().fold(first, worse);
        }
        let mean = |own: f32, value: &dyn Fn(&Quality) -> f32| {
            others.iter().fold(own, |sum, other| sum + value(other)) / (1 + others.len()) as f32
        };
        let of = |term: &Term, own| mean(own, &|other| other.terms.get(term.name).unwrap_or(own));
        Quality { score: mean(first.score, &|other| other.score), terms: first.terms.map(of) }
    }
}

/// Judges rigs by several views at once, each with an evaluator of its own. Rigs are told in the light frame of the first
/// view. All views may be of one scene, or of moments of it whose light frames differ in centre and radius too.
pub struct Views<E> {
    views: Vec<(E, Change)>,
    stand: Stand,
    over: Over,
    /// Lights at the end of each rig that stand in the world in any case.
    fixed: usize,
    scores: Vec<f32>,
}

impl<E> Views<E> {
    /// Of each view's evaluator and light frame. The last `fixed` lights of every rig are the scene's own and stand in the
    /// world, whatever the others do.
    ///
    /// # Errors
    /// [`Error::Argument`] without any view, and for a frame without finite axes, centre and positive radius.
    pub fn new(views: Vec<(E, Frame)>, stand: Stand, over: Over, fixed: usize) -> Result<Self> {
        views.iter().try_for_each(|(_, frame)| frame.check())?;
        let Some(&(_, first)) = views.first() else {
            return Err(Error::Argument("there are no views".into()));
        };
        let change = |(evaluator, frame): (E, Frame)| (evaluator, first.change_to(&frame));
        let views = views.into_iter().map(change).collect();
        Ok(Self { views, stand, over, fixed, scores: Vec::new() })
    }

    /// The evaluator of the first view.
    pub fn first(&self) -> &E {
        &self.views[0].0
    }

    /// The evaluator of each view, in order.
    pub fn evaluators(&mut self) -> impl Iterator<Item = &mut E> {
        self.views.iter_mut().map(|(evaluator, _)| evaluator)
    }
}

/// A population of the first view's light frame in another one's: all lights stand in the world, or the last `fixed` of each
/// rig alone.
fn turned<'a>(
    population: &'a Population,
    change: &Change,
    (stand, fixed): (Stand, usize),
) -> Result<Cow<'a, Population>> {
    if *change == Change::NONE {
        return Ok(Cow::Borrowed(population));
    }
    let lights = population.lights();
    let free = match stand {
        Stand::World => 0,
        Stand::Camera => lights.saturating_sub(fixed),
    };
    let light = |(at, light): (usize, &LightRecord)| match at % lights < free {
        true => *light,
        false => light.moved(change),
    };
    let records = population.records().iter().enumerate().map(light).collect();
    Population::of_records(lights, records).map(Cow::Owned)
}

/// The lights of a rig that is told in the light frame `first` as they stand in that of another view; [`Role::Scene`]
/// stands in the world in any case.
pub fn in_view(rig: &[Light], stand: Stand, first: &Frame, view: &Frame) -> Vec<LightRecord> {
    let change = first.change_to(view);
    let light = |light: &Light| match stand == Stand::Camera && light.role != Role::Scene {
        true => light.record(),
        false => light.record().moved(&change),
    };
    match change == Change::NONE {
        true => rig.iter().map(Light::record).collect(),
        false => rig.iter().map(light).collect(),
    }
}

impl<E: DerefMut<Target = dyn Evaluator>> Views<E> {
    /// Calls `judge` with each view's evaluator and the population in its light frame.
    fn each(
        &mut self,
        population: &Population,
        stand: (Stand, usize),
        judge: &mut dyn FnMut(&mut dyn Evaluator, &Population) -> Result<()>,
    ) -> Result<()> {
        self.views.iter_mut().try_for_each(|(evaluator, change)| {
            judge(&mut **evaluator, &*turned(population, change, stand)?)
        })
    }

    /// The quality of a rig that stands in world or camera over all views, and in each of them. Its lights of
    /// [`Role::Scene`], which come last, stand in the world.
    ///
    /// # Errors
    /// As [`Evaluator::qualities`].
    pub fn judge(&mut self, rig: &[Light], stand: Stand) -> Result<(Quality, Vec<Quality>)> {
        let fixed = rig.iter().rev().take_while(|light| light.role == Role::Scene).count();
        let mut views = Vec::new();
        self.each(&Population::of([rig])?, (stand, fixed), &mut |evaluator, population| {
            views.append(&mut evaluator.qualities(population)?);
            Ok(())
        })?;
        Ok((self.over.combined(views[0], &views[1..]), views))
    }
}

impl<E: DerefMut<Target = dyn Evaluator>> Evaluator for Views<E> {
    fn device(&self) -> &DeviceInfo {
        self.views[0].0.device()
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        let (over, stand) = (self.over, (self.stand, self.fixed));
        let count = self.views.len() as f32;
        let of_view = |(_, change): &(E, Change)| turned(population, change, stand);
        let populations = self.views.iter().map(of_view).collect::<Result<Vec<_>>>()?;
        // The device works on all views before the first one's scores are waited for.
        let begun = self.views.iter_mut().zip(&populations);
        let begun = begun.map(|((evaluator, _), population)| evaluator.begin(population));
        let mut begun = begun.collect::<Result<Vec<_>>>()?.into_iter();
        begun.next().map_or(Ok(()), |first| first(scores))?;
        self.scores.resize(scores.len(), 0.0);
        for other in begun {
            other(&mut self.scores)?;
            scores.iter_mut().zip(&self.scores).for_each(|(score, &other)| match over {
                Over::Mean => *score += other,
                Over::Worst => *score = score.max(other),
            });
        }
        if over == Over::Mean {
            scores.iter_mut().for_each(|score| *score /= count);
        }
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        let mut views = Vec::new();
        self.each(population, (self.stand, self.fixed), &mut |evaluator, population| {
            views.push(evaluator.qualities(population)?);
            Ok(())
        })?;
        let combined = |rig: usize| {
            let others: Vec<_> = views[1..].iter().map(|view| view[rig]).collect();
            self.over.combined(views[0][rig], &others)
        };
        Ok((0..population.len()).map(combined).collect())
    }

    /// The statistics and the picture are those of the first view.
    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let (Quality { score, terms }, _) = self.judge(rig, self.stand)?;
        Ok(Inspection { score, terms, ..self.views[0].0.inspect(rig)? })
    }

    /// Those of the first view.
    fn maps(&mut self) -> Result<&Maps> {
        self.views[0].0.maps()
    }
}

#[cfg(test)]
mod tests;
