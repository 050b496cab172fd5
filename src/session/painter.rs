//! `klieg design --target-picture` and `--collage`: the lights that make a given picture.

use super::designer::{first_rig, optimizer, within_time};
use super::intent;
use super::{Session, milliseconds};
use crate::Error;
use crate::cpu;
use crate::design::collage::{Collage, SAMPLES};
use crate::design::paint::{Canvas, paint, places};
use crate::design::{Outcome, Progress};
use crate::lighting::genome::Genome;
use crate::objective::shadows::ShadowSettings;
use crate::report::picture;
use crate::scene::TextureLevel;
use crate::scene::load::read_picture;
use crate::scene::view::View;
use anyhow::Result;
use image::{Rgba, RgbaImage};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// The picture of a light collage.
pub const COLLAGE: &str = "collage.png";

/// What lights are to make.
pub struct Target<'a> {
    /// The picture.
    pub picture: TextureLevel,
    /// The file that it is of.
    file: Option<&'a Path>,
}

impl<'a> Target<'a> {
    /// The picture of a file.
    ///
    /// # Errors
    /// [`Error::Input`] for one that cannot be used.
    pub fn read(file: &'a Path) -> crate::Result<Self> {
        Ok(Self { picture: read_picture(file)?, file: Some(file) })
    }

    /// The view under a collage of lights, each patch of the surface under its own.
    ///
    /// # Errors
    /// [`Error::Argument`] for a view that is too large to be drawn at several samples a pixel.
    pub fn collage(session: &mut Session) -> crate::Result<Self> {
        let settings = &session.settings;
        let mean = settings.objective.mean_of(&session.evaluator.maps()?.statistics());
        let View { width, height, camera, .. } = session.view.clone();
        let large = View::new(&session.scene, camera, width * SAMPLES, height * SAMPLES)?;
        let off = ShadowSettings { on: false, ..settings.shadows };
        let maps = cpu::draw(&session.scene, &large, &settings.objective, (&off, None))?;
        let made = Collage::new((&maps, &large, &settings.shading), mean);
        tracing::info!("{} patches of the surface have a light of their own", made.patches);
        Ok(Self { picture: made.picture, file: None })
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// When the picture is too large for PNG.
    pub fn png(&self) -> Result<Vec<u8>> {
        let TextureLevel { width, height, texels } = &self.picture;
        let pixel = |x, y| Rgba(texels[(y * width + x) as usize]);
        Ok(picture::final_png(&RgbaImage::from_fn(*width, *height, pixel))?)
    }
}

/// Searches the lights of the picture, `observe` being called after every generation, until the settings' time is over.
///
/// # Errors
/// [`Error::Input`] for a picture that cannot be used, and faults of the settings and the device.
pub fn search(
    session: &mut Session,
    genome: &Genome,
    target: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let start = Instant::now();
    let rig = first_rig(session)?;
    let genome = intent::bound(session, places(session.complete(genome)?)?, None)?;
    let mut search = optimizer(session, (&genome, rig.as_deref()), 1)?;
    let kept = session.with_kept(Vec::new());
    let mut watch = within_time(session, start, observe);
    let shading = session.settings.shading;
    let view = session.view.clone();
    let maps = session.evaluator.maps()?;
    let canvas = Canvas::new((maps, &view, &shading), &target.picture, &kept);
    let canvas = canvas.map_err(|fault| match target.file {
        Some(file) => Error::input(file, fault),
        None => fault,
    })?;
    let outcome = paint(&canvas, &genome, &mut *search, &mut watch)?;
    session.timing.search = milliseconds(start);
    Ok(outcome)
}
