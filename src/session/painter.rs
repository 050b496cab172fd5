//! `klieg design --target-picture`: the lights that make a given picture.

use super::designer::{first_rig, optimizer, within_time};
use super::intent;
use super::{Session, milliseconds};
use crate::Error;
use crate::design::paint::{Canvas, paint, places};
use crate::design::{Outcome, Progress};
use crate::lighting::genome::Genome;
use crate::scene::load::read_picture;
use anyhow::Result;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Searches the lights of the picture, `observe` being called after every generation, until the settings' time is over.
///
/// # Errors
/// [`Error::Input`] for a picture that cannot be used, and faults of the settings and the device.
pub fn search(
    session: &mut Session,
    genome: &Genome,
    path: &Path,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let start = Instant::now();
    let picture = read_picture(path)?;
    let rig = first_rig(session)?;
    let genome = intent::bound(session, places(session.complete(genome)?)?, None)?;
    let mut search = optimizer(session, (&genome, rig.as_deref()), 1)?;
    let kept = session.with_kept(Vec::new());
    let mut watch = within_time(session, start, observe);
    let shading = session.settings.shading;
    let view = session.view.clone();
    let maps = session.evaluator.maps()?;
    let canvas = Canvas::new((maps, &view, &shading), &picture, &kept)
        .map_err(|fault| Error::input(path, fault))?;
    let outcome = paint(&canvas, &genome, &mut *search, &mut watch)?;
    session.timing.search = milliseconds(start);
    Ok(outcome)
}
