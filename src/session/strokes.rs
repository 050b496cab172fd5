//! `klieg design --strokes`: where highlights and shadows are to lie.

use super::Session;
use super::config::Settings;
use super::device::Opened;
use super::engine::{Engine, evaluator_of};
use crate::design::intent::insist_on_mean;
use crate::design::strokes::{SHADOW_WEIGHT, Strokes};
use crate::lighting::genome::Genome;
use crate::objective::maps::Maps;
use crate::objective::{Objective, Term};
use crate::scene::TextureLevel;
use crate::scene::load::read_picture;
use crate::scene::view::View;
use crate::{Error, Result as Checked};
use anyhow::Result;
use std::path::Path;

/// Strokes on the whole picture, and the picture that they were drawn in, for smaller ones.
pub(super) struct Drawn {
    picture: TextureLevel,
    strokes: Strokes,
}

impl Drawn {
    /// The strokes on another view's maps.
    ///
    /// # Errors
    /// As [`Strokes::of`].
    pub fn on(&self, maps: &Maps) -> Checked<Strokes> {
        Strokes::of(&self.picture, maps)
    }
}

impl Session {
    /// Takes the strokes of a picture: its search holds the lights of the highlights in their places, and the evaluator
    /// judges the shadows too.
    ///
    /// # Errors
    /// [`Error::Input`] for a picture that cannot be used, and what the device reports.
    pub fn stroke(&mut self, path: &Path) -> Result<()> {
        if !self.settings.dim.is_empty() {
            let fault = "strokes do not go with objects that are to stay dim: draw shadows on them";
            return Err(Error::Argument(fault.into()).into());
        }
        let picture = read_picture(path)?;
        let fault = |fault| Error::input(path, fault);
        let strokes = Strokes::of(&picture, self.evaluator.maps()?).map_err(fault)?;
        if strokes.has_shadows() {
            weigh_target(&mut self.settings.objective, SHADOW_WEIGHT)?;
            // Without that, darkness everywhere would do for a shadow.
            insist_on_mean(&mut self.settings.objective)?;
        }
        let seen = (&self.device, &self.view);
        if let Some(marked) = marked(&mut self.evaluator, &strokes, seen, &self.settings)? {
            self.evaluator = marked;
        }
        self.strokes = Some(Drawn { picture, strokes });
        Ok(())
    }

    /// A genome with the lights of the highlights in their places.
    pub(super) fn with_highlights(&mut self, genome: Genome) -> Result<Genome> {
        let Some(Drawn { strokes, .. }) = &self.strokes else { return Ok(genome) };
        Ok(strokes.hold(genome, self.evaluator.maps()?, &self.view)?)
    }
}

/// Gives the term that compares with a target picture a weight.
pub(super) fn weigh_target(objective: &mut Objective, weight: f32) -> Checked<()> {
    objective.weights.set(Term::named("target")?, weight)
}

/// The settings for an evaluator that compares with no target.
pub(super) fn unmarked(strokes: Option<&Drawn>, settings: &Settings) -> Checked<Settings> {
    let mut settings = settings.clone();
    if strokes.is_some() || !settings.dim.is_empty() {
        weigh_target(&mut settings.objective, 0.0)?;
    }
    Ok(settings)
}

/// An evaluator that judges the shadows of strokes besides what the given one does; none where no shadow is drawn.
pub(super) fn marked(
    evaluator: &mut Engine,
    strokes: &Strokes,
    (device, view): (&Opened, &View),
    settings: &Settings,
) -> Checked<Option<Engine>> {
    let maps = evaluator.maps()?;
    let Some(target) = strokes.target(maps.types.len()) else { return Ok(None) };
    let mut maps = maps.clone();
    maps.set_target(target)?;
    Ok(Some(evaluator_of(device, (maps, view), settings)?))
}
