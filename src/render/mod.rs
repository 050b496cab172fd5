//! Final pictures of a rig: anti-aliased, with exact shadows. The search's own pictures have one sample a
//! pixel; these are for people.
//!
//! The visible surface is drawn at several samples a pixel, tile by tile, so that memory does not grow with the
//! picture. Every sample is shaded as the search does it, and sees a light or not by one ray; radiances are
//! averaged before they are encoded.

mod background;
mod pattern;
mod pixel;
mod tile;
mod tone_mapping;

pub use background::{BACKGROUND, Background};
pub use tone_mapping::ToneMapping;

use crate::lighting::LightRecord;
use crate::lighting::shading::Shading;
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::{Error, Result};
use image::RgbaImage;
use pixel::Counts;
use serde::{Deserialize, Serialize};
use tile::Tile;

/// Most samples of a pixel.
pub const MAX_SAMPLES: u32 = 64;

/// Settings of a final picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What stands behind the objects; the default colour where absent. One that is given counts in what
    /// lights are judged by.
    pub background: Option<Background>,
    /// From radiance to colours.
    pub tone_mapping: ToneMapping,
    /// Samples of a pixel, a square number up to [`MAX_SAMPLES`]: they lie on a square grid.
    pub samples: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { background: None, tone_mapping: ToneMapping::None, samples: 16 }
    }
}

impl Settings {
    /// # Errors
    /// [`Error::Argument`] unless the number of samples is a square number of 1 to [`MAX_SAMPLES`].
    pub fn check(&self) -> Result<()> {
        let samples = self.samples;
        if (1..=MAX_SAMPLES).contains(&samples) && samples.isqrt().pow(2) == samples {
            return Ok(());
        }
        let fault = "it must be a square number from 1 to";
        Err(Error::Argument(format!("picture.samples is {samples}: {fault} {MAX_SAMPLES}")))
    }

    /// Samples of a pixel's side.
    fn side(&self) -> u32 {
        self.samples.isqrt()
    }
}

/// What is drawn: a scene in view, and how it is lit.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view; its size is the picture's.
    pub view: &'a View,
    /// How surfaces reflect.
    pub shading: &'a Shading,
    /// What casts shadows, in the view's light frame; without it nothing does.
    pub occluders: Option<&'a Occluders>,
}

/// A final picture, and what it shows in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// sRGB; alpha is straight, and below 255 only where the background is transparent.
    pub image: RgbaImage,
    /// Share of the picture that shows an object.
    pub object: f32,
    /// Share of the object whose radiance, before tone mapping, has a burnt-out channel
    /// ([`crate::objective::BURNT`]).
    pub burnt: f32,
    /// Share of the object that no light reaches ([`crate::objective::UNLIT`]), shadows included.
    pub unlit: f32,
}

/// The picture of a rig. Its bits do not depend on the number of threads.
///
/// A light of a [`size`](LightRecord::size) is a disc that faces what it lights, and casts soft shadows; that
/// of a directional light stands a scene radius away. Ambient light is shadowed too: its share is that of the
/// directions, weighed by the cosine, in which nothing stands.
///
/// # Errors
/// As [`Settings::check`], [`Scene::check`], [`View::check`] and [`Shading::check`].
pub fn draw(stage: &Stage, rig: &[LightRecord], settings: &Settings) -> Result<Picture> {
    Ok(draw_each(stage, &[rig], settings)?.swap_remove(0))
}

/// The picture of each rig, as [`draw`] makes it; what is seen is found once for all of them.
///
/// # Errors
/// As [`draw`].
pub fn draw_each(
    stage: &Stage,
    rigs: &[&[LightRecord]],
    settings: &Settings,
) -> Result<Vec<Picture>> {
    draw_each_while(stage, rigs, settings, &|| true)
}

/// As [`draw`], as long as `go_on` says so, which is asked for every row.
///
/// # Errors
/// As [`draw`], and [`Error::Interrupted`].
pub fn draw_while(
    stage: &Stage,
    rig: &[LightRecord],
    settings: &Settings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Picture> {
    Ok(draw_each_while(stage, &[rig], settings, go_on)?.swap_remove(0))
}

fn draw_each_while(
    stage: &Stage,
    rigs: &[&[LightRecord]],
    settings: &Settings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Picture>> {
    settings.check()?;
    stage.scene.check()?;
    stage.view.check()?;
    stage.shading.check()?;
    let (width, height) = (stage.view.width, stage.view.height);
    let mut drawn = vec![(RgbaImage::new(width, height), Counts::default()); rigs.len()];
    for tile in Tile::all([width, height], settings.side()) {
        tile.draw((stage, settings), rigs, go_on, &mut drawn)?;
    }
    let samples = u64::from(width) * u64::from(height) * u64::from(settings.samples);
    let share = |count: u64, of: u64| (count as f64 / of.max(1) as f64) as f32;
    let picture = |(image, counts): (RgbaImage, Counts)| Picture {
        image,
        object: share(counts.object, samples),
        burnt: share(counts.burnt, counts.object),
        unlit: share(counts.unlit, counts.object),
    };
    Ok(drawn.into_iter().map(picture).collect())
}
