//! Options that say what light is wanted.

use crate::design::{Look, Mood};
use crate::scene::load::read_picture;
use crate::session::SIZE;
use crate::session::config::Settings;
use crate::session::intent::Keep;
use crate::session::values::Size;
use crate::{Error, Result};
use clap::Args;
use std::path::{Path, PathBuf};

/// What light is wanted.
#[derive(Debug, Args)]
#[command(next_help_heading = "What light")]
pub(super) struct IntentOptions {
    /// Steps darker or brighter than usual, -2 to 2 [default: 0]
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true)]
    brightness: Option<f32>,
    /// Steps of less or more contrast than usual, -2 to 2 [default: 0]
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true)]
    contrast: Option<f32>,
    /// The character of the light: soft, natural or dramatic [default: natural]
    #[arg(long)]
    mood: Option<Mood>,
    /// Let no light stand below the horizon of the scene's centre
    #[arg(long)]
    no_below: bool,
    /// Light some objects best, by the names of nodes or meshes: they count for three quarters of F, the whole picture
    /// for the rest
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    focus: Vec<String>,
    /// Leave some objects dim, by the names of nodes or meshes: all others are lit as if these were none of them
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    dim: Vec<String>,
    /// Light like that of a picture, a PNG, JPEG or WebP file, transparent where it shows nothing of the kind: its
    /// brightnesses and gradients, and the tints of its lights and shadows
    #[arg(long, value_name = "PICTURE")]
    like: Option<PathBuf>,
    /// Keep a light of the rig that --first names as it is, by its role or its number from 0, or one value of it, as in
    /// fill.azimuth. Several times for several
    #[arg(long = "keep", value_name = "LIGHT[.VALUE]")]
    keeps: Vec<Keep>,
    /// Add the lights one after another: each is the best addition to those before it, which stay as they are
    #[arg(long)]
    one_by_one: bool,
}

impl IntentOptions {
    /// The picture that they name.
    pub fn picture(&self) -> Option<&Path> {
        self.like.as_deref()
    }

    /// Puts these options in the place of `settings`.
    ///
    /// # Errors
    /// [`Error::Input`] for a picture that cannot be used.
    pub fn apply(&self, settings: &mut Settings) -> Result<()> {
        if let Some(path) = &self.like {
            let Size([width, height]) = settings.view.size.unwrap_or(SIZE);
            let look = Look::of(&read_picture(path)?, width.max(height));
            let look = look.map_err(|fault| Error::input(path, fault))?;
            look.steer(&mut settings.objective, &mut settings.lights.boxes)?;
        }
        let intent = &mut settings.intent;
        intent.brightness = self.brightness.unwrap_or(intent.brightness);
        intent.contrast = self.contrast.unwrap_or(intent.contrast);
        intent.mood = self.mood.unwrap_or(intent.mood);
        intent.below &= !self.no_below;
        settings.lights.one_by_one |= self.one_by_one;
        if !self.focus.is_empty() {
            settings.focus.clone_from(&self.focus);
        }
        if !self.dim.is_empty() {
            settings.dim.clone_from(&self.dim);
        }
        if !self.keeps.is_empty() {
            settings.lights.hold.clone_from(&self.keeps);
        }
        Ok(())
    }
}
