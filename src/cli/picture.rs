//! Final pictures: their options, and how they are made.

use super::config::Settings;
use crate::Result;
use crate::lighting::{Light, Population};
use crate::render::{self, Background, Picture, Stage, ToneMapping};
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use clap::Args;

/// How final pictures are made.
#[derive(Debug, Args)]
pub(super) struct PictureOptions {
    /// Behind the objects of the final pictures: an sRGB colour such as '#3a3c42', from which profile natural
    /// makes the objects stand out, or 'transparent' [default: #3a3c42, which does not count]
    #[arg(long, value_name = "COLOR|transparent")]
    background: Option<Background>,
    /// From radiance to colours in the final pictures [default: none]
    #[arg(long, value_name = "MAPPING")]
    tone_mapping: Option<ToneMapping>,
}

impl PictureOptions {
    /// Puts these options in the place of `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        let picture = &mut settings.picture;
        picture.background = self.background.or(picture.background);
        picture.tone_mapping = self.tone_mapping.unwrap_or(picture.tone_mapping);
        settings.judge_background();
    }
}

/// What casts shadows in final pictures; nothing where the settings have none.
///
/// # Errors
/// As [`Occluders::new`].
pub(super) fn occluders(
    scene: &Scene,
    view: &View,
    settings: &Settings,
) -> Result<Option<Occluders>> {
    settings.shadows.on.then(|| Occluders::new(scene, view)).transpose()
}

/// The final picture of each rig.
///
/// # Errors
/// As [`render::draw`].
pub(super) fn draw(
    (scene, view): (&Scene, &View),
    occluders: Option<&Occluders>,
    settings: &Settings,
    rigs: &[&[Light]],
) -> Result<Vec<Picture>> {
    let rigs = rigs.iter().map(|rig| Population::of([*rig])).collect::<Result<Vec<_>>>()?;
    let records: Vec<_> = rigs.iter().map(Population::records).collect();
    let stage = Stage { scene, view, shading: &settings.shading, occluders };
    render::draw_each(&stage, &records, &settings.picture)
}
