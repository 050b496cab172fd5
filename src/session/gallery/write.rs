//! The files of a gallery, and the way back from them to a rig.

use super::{Gallery, MOST, Shown};
use crate::lighting::presets::Preset;
use crate::lighting::{Light, Rig};
use crate::objective::Quality;
use crate::render::Picture;
use crate::report::gallery::{
    GalleryRecord, Picked, RigFile, RigFiles, RigRecord, Thumbnail, page,
};
use crate::report::json::{self, LightRecord};
use crate::report::{Staging, picture};
use crate::scene;
use crate::scene::view::{View, shrunk};
use crate::session::config::Settings;
use crate::session::designer::in_words;
use crate::session::{Session, input, rig};
use crate::{Error, Result as Checked};
use anyhow::Result;
use image::imageops::{FilterType, resize};
use serde::Deserialize;
use std::path::Path;

/// The record.
pub const RECORD: &str = "gallery.json";

/// The page.
const PAGE: &str = "index.html";

/// Longest side of the page's pictures, pixels.
const THUMBNAIL: u32 = 320;

/// Most samples of a pixel of the pictures.
const SAMPLES: u32 = 4;

/// Most bytes of a record.
const MAX_BYTES: u64 = 16 << 20;

/// Names of all files of a gallery of that many rigs.
pub fn names(count: usize) -> Vec<String> {
    let rigs = (1..=count).flat_map(|number| RigFiles::of(number).names().map(str::to_owned));
    rigs.chain([PAGE, RECORD].map(str::to_owned)).collect()
}

/// What is read of a record.
#[derive(Deserialize)]
struct Read {
    schema: String,
    rigs: Vec<serde::de::IgnoredAny>,
}

/// The rig of that number, from 1, of the gallery in a folder, in the light frame of `view`.
///
/// # Errors
/// [`Error::Input`] for a folder without a gallery, one that cannot be read, and a number that it does not have.
pub fn picked(folder: &Path, number: usize, view: &View) -> Checked<Rig> {
    let path = folder.join(RECORD);
    let text = input::text(&path, MAX_BYTES)?;
    let read = serde_json::from_str(&text);
    let read: Read =
        read.map_err(|error| Error::input(&path, format!("is no record of a gallery: {error}")))?;
    if read.schema != GalleryRecord::SCHEMA {
        let fault = format!("is of schema {}, not {}", read.schema, GalleryRecord::SCHEMA);
        return Err(Error::input(&path, fault));
    }
    let count = read.rigs.len().min(MOST);
    if !(1..=count).contains(&number) {
        return Err(Error::input(&path, format!("has no rig {number}: it has 1 to {count}")));
    }
    rig::read(&folder.join(RigFiles::of(number).rig), view)
}

/// Writes all files of a gallery; gives its record, the last of them.
///
/// # Errors
/// What the device reports, and files that cannot be written.
pub fn write(
    session: &mut Session,
    gallery: &Gallery,
    (slack, picked): (f32, Option<Picked>),
    staging: &mut Staging,
) -> Result<GalleryRecord> {
    let mut record = record(session, gallery, (slack, picked))?;
    let rigs: Vec<&[Light]> = gallery.rigs.iter().map(|shown| &*shown.rig).collect();
    let pictures = drawn(session, &rigs)?;
    let (source, options) = (&session.scene.path, session.settings.loading());
    for (made, (rig, lights)) in pictures.iter().zip(record.rigs.iter().zip(&rigs)) {
        staging.write(&rig.files.picture, picture::final_png(&made.image)?)?;
        staging.write(&rig.files.rig, json::text(&RigFile::of(&record, rig))?)?;
        let lit = staging.path(&rig.files.lit);
        scene::lit::write(source, options.clone(), &session.view, lights, &lit)?;
    }
    let settings = in_words(&session.settings);
    staging.write(PAGE, page(&record, &thumbnails(&gallery.rigs, &pictures)?, &settings)?)?;
    record.timing_ms = session.finish();
    staging.write(RECORD, json::text(&record)?)?;
    Ok(record)
}

/// The final pictures of many rigs, with fewer samples a pixel than those of one.
pub(in crate::session) fn drawn(session: &mut Session, rigs: &[&[Light]]) -> Result<Vec<Picture>> {
    let view = session.view.clone();
    let samples = session.settings.picture.samples;
    session.settings.picture.samples = samples.min(SAMPLES);
    let pictures = session.render(&view, rigs);
    session.settings.picture.samples = samples;
    pictures
}

/// Small pictures of rigs, of their final ones.
pub(in crate::session) fn thumbnails<'a>(
    rigs: &'a [Shown],
    pictures: &[Picture],
) -> Result<Vec<Thumbnail<'a>>> {
    let thumbnail = |(shown, made): (&'a Shown, &Picture)| {
        let (width, height) = made.image.dimensions();
        let [width, height] = shrunk([width, height], THUMBNAIL);
        let small = resize(&made.image, width, height, FilterType::Triangle);
        let png = picture::final_png(&small)?;
        Ok(Thumbnail { rig: &shown.rig, quality: shown.quality, png })
    };
    rigs.iter().zip(pictures).map(thumbnail).collect()
}

fn record(
    session: &mut Session,
    gallery: &Gallery,
    (slack, picked): (f32, Option<Picked>),
) -> Result<GalleryRecord> {
    let headlight = session.with_kept(Preset::Headlight.rig());
    let headlight: Quality = session.evaluator.inspect(&headlight)?.quality();
    let (distances, positions) = (gallery.distances(), gallery.positions());
    let nearest = |at: usize| {
        let others = distances[at].iter().enumerate().filter(|(other, _)| *other != at);
        others.map(|(_, distance)| *distance).reduce(f32::min)
    };
    let rig = |(at, shown): (usize, &Shown)| RigRecord {
        number: at + 1,
        first: shown.first,
        quality: shown.quality,
        lights: LightRecord::rig(&shown.rig, &session.view),
        position: positions[at],
        nearest: nearest(at),
        files: RigFiles::of(at + 1),
    };
    let rigs = gallery.rigs.iter().enumerate().map(rig).collect();
    let Settings { seed, intent, focus, dim, objective, .. } = &session.settings;
    Ok(GalleryRecord {
        header: session.header(GalleryRecord::SCHEMA),
        seed: *seed,
        intent: *intent,
        focus: focus.clone(),
        dim: dim.clone(),
        objective: objective.into(),
        headlight,
        slack,
        picked,
        scene_lights: session.scene_lights(),
        evaluations: gallery.evaluations,
        rigs,
        distances,
        timing_ms: session.timing,
    })
}
