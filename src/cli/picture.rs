//! Options of final pictures.

use super::config::Settings;
use crate::render::{Background, ToneMapping};
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
