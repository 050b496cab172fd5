//! A gallery: its record, and the page on which its pictures stand side by side.

use super::html::environment;
use super::json::{CameraRecord, Header, LightRecord, ObjectiveRecord, SceneLights, Timing};
use super::picture;
use super::text::visible;
use crate::design::Intent;
use crate::design::gallery::rows;
use crate::lighting::{Light, Role};
use crate::objective::{Quality, Term};
use anyhow::{Context, Result};
use minijinja::context;
use minijinja::value::Serde;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Terms on a card: those in which the rigs differ most.
const TERMS: usize = 4;

/// Radius of the circle that stands for light from behind, pixels of a card's diagram.
const REACH: f32 = 44.0;

/// `gallery.json`.
#[derive(Debug, Clone, Serialize)]
pub struct GalleryRecord {
    /// Schema `klieg.gallery/1`.
    #[serde(flatten)]
    pub header: Header,
    /// Seed.
    pub seed: u64,
    /// What light was wanted.
    pub intent: Intent,
    /// Names of the objects for which it was wanted most.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub focus: Vec<String>,
    /// Names of the objects that were to stay dim.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dim: Vec<String>,
    /// Settings of the quality function.
    pub objective: ObjectiveRecord,
    /// The headlight's quality.
    pub headlight: Quality,
    /// Most that a score may lie above the lowest.
    pub slack: f32,
    /// The rig of another gallery around which this one is.
    pub picked: Option<Picked>,
    /// The scene's own lights.
    pub scene_lights: SceneLights,
    /// Rigs that were evaluated.
    pub evaluations: usize,
    /// The rigs, best first.
    pub rigs: Vec<RigRecord>,
    /// Distances of their pictures, a row for each: root mean square `ΔE*ab`, a difference of the mean lightness counting a
    /// quarter.
    pub distances: Vec<Vec<f32>>,
    /// Wall time.
    pub timing_ms: Timing,
}

impl GalleryRecord {
    /// The schema's name.
    pub const SCHEMA: &'static str = "klieg.gallery/1";
}

/// A rig of another gallery.
#[derive(Debug, Clone, Serialize)]
pub struct Picked {
    /// The gallery's folder.
    pub folder: PathBuf,
    /// The rig's number.
    pub number: usize,
}

/// A rig of a gallery.
#[derive(Debug, Clone, Serialize)]
pub struct RigRecord {
    /// Its number, from 1.
    pub number: usize,
    /// Whether the gallery was made around it.
    pub first: bool,
    /// Its quality.
    #[serde(flatten)]
    pub quality: Quality,
    /// Its lights.
    pub lights: Vec<LightRecord>,
    /// Its place on the map, in the unit of the distances.
    pub position: [f32; 2],
    /// The distance to the one that is most alike; null for a single one.
    pub nearest: Option<f32>,
    /// Its files.
    pub files: RigFiles,
}

/// Names of a rig's files.
#[derive(Debug, Clone, Serialize)]
pub struct RigFiles {
    /// The final picture.
    pub picture: String,
    /// The rig.
    pub rig: String,
    /// The lit scene.
    pub lit: String,
}

impl RigFiles {
    /// Those of a number from 1.
    pub fn of(number: usize) -> Self {
        let name = |ending| format!("{number:02}.{ending}");
        Self { picture: name("png"), rig: name("rig.json"), lit: name("glb") }
    }

    /// All of them.
    pub fn names(&self) -> [&str; 3] {
        [&self.picture, &self.rig, &self.lit]
    }
}

/// A rig's file, as `klieg render --rig` and a gallery read it.
#[derive(Debug, Clone, Serialize)]
pub struct RigFile<'a> {
    /// Schema `klieg.rig/1`.
    pub schema: &'static str,
    /// The scene's file, as it was given.
    pub scene: &'a str,
    /// The camera.
    pub camera: &'a CameraRecord,
    /// The rig's quality.
    #[serde(flatten)]
    pub quality: Quality,
    /// Its lights.
    pub lights: &'a [LightRecord],
}

impl<'a> RigFile<'a> {
    /// A rig of a gallery.
    pub fn of(record: &'a GalleryRecord, rig: &'a RigRecord) -> Self {
        let Header { scene, camera, .. } = &record.header;
        Self { schema: "klieg.rig/1", scene, camera, quality: rig.quality, lights: &rig.lights }
    }
}

/// What a page shows of a rig.
#[derive(Debug)]
pub struct Thumbnail<'a> {
    /// The rig.
    pub rig: &'a [Light],
    /// Its quality.
    pub quality: Quality,
    /// A small picture, a PNG file.
    pub png: Vec<u8>,
}

/// A card of the page.
#[derive(Debug, Serialize)]
pub(super) struct Card {
    number: usize,
    source: String,
    score: f32,
    /// Titles and values of some terms.
    terms: Vec<(&'static str, f32)>,
    marks: Vec<Mark>,
}

/// A light of a card.
#[derive(Debug, Serialize)]
struct Mark {
    role: Role,
    /// Where it stands, seen from the viewer, pixels from the diagram's centre: light from the viewer in the middle, light
    /// from the sides on the inner circle, light from behind on the outer one.
    at: [f32; 2],
    words: String,
}

impl Mark {
    fn of(light: &Light) -> Self {
        let [x, y, z] = light.direction().to_array();
        let off = REACH * z.clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
        let across = x.hypot(y);
        let at = if across > 1e-6 { [off * x / across, -off * y / across] } else { [off, 0.0] };
        let side = |degrees: f32, [up, down]: [&str; 2]| {
            let degrees = degrees.round();
            format!("{}° {}", degrees.abs(), if degrees < 0.0 { down } else { up })
        };
        let turn = light.azimuth.to_degrees();
        let turn = turn - 360.0 * (turn / 360.0).round();
        let up = side(light.elevation.to_degrees(), ["up", "down"]);
        let words = format!("{} {up}, {}", light.role.name(), side(turn, ["right", "left"]));
        Self { role: light.role, at, words }
    }
}

/// Cards of rigs that are shown together, numbered from 1.
pub(super) fn cards(thumbnails: &[Thumbnail], objective: &ObjectiveRecord) -> Vec<Card> {
    let terms = differing(thumbnails, objective);
    let card = |(at, thumbnail): (usize, &Thumbnail)| {
        let value =
            |term: &&'static Term| Some((term.title, thumbnail.quality.terms.get(term.name)?));
        Card {
            number: 1 + at,
            source: picture::uri(&thumbnail.png),
            score: thumbnail.quality.score,
            terms: terms.iter().filter_map(value).collect(),
            marks: thumbnail.rig.iter().map(Mark::of).collect(),
        }
    };
    thumbnails.iter().enumerate().map(card).collect()
}

/// The terms in which the rigs differ most, as much as they weigh.
fn differing(thumbnails: &[Thumbnail], objective: &ObjectiveRecord) -> Vec<&'static Term> {
    let Some(one) = thumbnails.first() else { return Vec::new() };
    let spread = |term: &Term| {
        let values = || thumbnails.iter().filter_map(|rig| rig.quality.terms.get(term.name));
        let (low, high) = values()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        objective.weights.get(term.name).unwrap_or(0.0) * (high - low)
    };
    let mut terms: Vec<(&'static Term, f32)> =
        one.quality.terms.iter().map(|(term, _)| (term, spread(term))).collect();
    terms.retain(|(term, _)| objective.weights.get(term.name).is_some_and(|weight| weight > 0.0));
    terms.sort_by(|a, b| b.1.total_cmp(&a.1));
    terms.into_iter().take(TERMS).map(|(term, _)| term).collect()
}

/// The page: the rigs with their small pictures in the order of the record, and a map on which neighbours are alike.
///
/// # Errors
/// None in practice: the template is the program's own.
pub fn page(record: &GalleryRecord, thumbnails: &[Thumbnail], settings: &str) -> Result<String> {
    let mut environment = environment()?;
    environment.add_template("gallery.html", include_str!("gallery.html.j2"))?;
    let positions: Vec<[f32; 2]> = record.rigs.iter().map(|rig| rig.position).collect();
    let columns = ((positions.len() as f32 * 1.4).sqrt().ceil() as usize).max(1);
    let title = Path::new(&record.header.scene).file_name();
    let nearest = record.rigs.iter().filter_map(|rig| rig.nearest).fold(f32::INFINITY, f32::min);
    let page = context! {
        title => title.map_or("scene".into(), |name| name.to_string_lossy()),
        gallery => Serde(record),
        cards => Serde(cards(thumbnails, &record.objective)),
        map => Serde(rows(&positions, columns)),
        columns => columns,
        least => Serde(nearest.is_finite().then_some(nearest)),
        settings => settings,
    };
    let page = environment.get_template("gallery.html")?.render(page);
    Ok(visible(&page.context("the gallery's template")?).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_is_marked_where_the_viewer_sees_it_come_from() {
        let mark = |elevation: f32, azimuth: f32| {
            let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
            Mark::of(&Light { elevation, azimuth, ..Light::default() })
        };
        let close = |mark: &Mark, x: f32, y: f32| {
            (mark.at[0] - x).abs() < 1e-3 && (mark.at[1] - y).abs() < 1e-3
        };
        assert!(close(&mark(0.0, 0.0), 0.0, 0.0));
        assert!(close(&mark(0.0, 90.0), 0.5 * REACH, 0.0));
        assert!(close(&mark(90.0, 0.0), 0.0, -0.5 * REACH));
        assert!(close(&mark(0.0, -135.0), -0.75 * REACH, 0.0));
        assert_eq!(mark(30.4, -45.0).words, "key 30° up, 45° left");
        assert_eq!(mark(-10.0, 200.0).words, "key 10° down, 160° left");
    }
}
