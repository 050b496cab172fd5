//! What the server answers: the other half of [`super::messages`].

use super::messages::{Camera, Document, Light, Targets};
use crate::design::Intent;
use crate::evaluate::DeviceInfo;
use crate::objective::Terms;
use serde::Serialize;

#[cfg(test)]
use ts_rs::TS;

/// How fine a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(TS))]
#[cfg_attr(test, ts(type = "0 | 1 | 2"))]
#[serde(into = "u32")]
pub enum Fineness {
    /// Smaller than asked for, or with fewer directions of light in its shadow table.
    Coarse = 0,
    /// What a search judges.
    Full = 1,
    /// Anti-aliased, with exact shadows.
    AtRest = 2,
}

impl From<Fineness> for u32 {
    fn from(fineness: Fineness) -> Self {
        fineness as Self
    }
}

/// A camera of the file.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct NamedCamera {
    /// Its name.
    pub name: String,
    /// It, with the nearest that an orbit about the scene's centre has.
    pub camera: Camera,
}

/// A scene that is there.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct SceneInfo {
    /// What later requests call it.
    pub id: String,
    /// The file's name.
    pub name: String,
    /// Triangles.
    pub triangles: u32,
    /// The scene's centre, world units.
    pub center: [f64; 3],
    /// The largest distance of a vertex from it, world units.
    pub radius: f64,
    /// The names of its objects, each once; of very many none.
    pub objects: Vec<String>,
    /// The file's cameras.
    pub cameras: Vec<NamedCamera>,
    /// Where a page begins to look from.
    pub camera: Camera,
    /// Width and height of the picture that it begins with, pixels.
    pub size: [u32; 2],
    /// The file's own lights, or those that klieg wrote; told in the frame of `camera`.
    pub lights: Vec<Light>,
    /// What a session file kept.
    pub document: Option<Document>,
    /// What was left out in loading, for people.
    pub warnings: Vec<String>,
}

/// What a page begins with where it has nothing of its own.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Defaults {
    /// Where a search would begin; none without a scene.
    pub lights: Vec<Light>,
    /// Weights of the terms.
    #[cfg_attr(test, ts(type = "Record<string, number>"))]
    pub weights: Terms,
    /// What they aim at.
    pub targets: Targets,
    /// What light is wanted; weights and targets come of it.
    pub intent: Intent,
    /// Names of the objects for which it is wanted most.
    pub focus: Vec<String>,
    /// Names of the objects that are to stay dim.
    pub dim: Vec<String>,
    /// Name of the optimiser.
    pub optimizer: String,
    /// Seed of every random choice.
    #[cfg_attr(test, ts(type = "number"))]
    pub seed: u64,
}

/// What has a name and, for people, a title.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Titled {
    /// What requests call it.
    pub name: String,
    /// What people call it.
    pub title: String,
}

/// A term that pictures are judged by.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct TermInfo {
    /// Its name in weights and judgements.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// What it says of a picture: a sentence without its subject.
    pub meaning: String,
    /// Its weight in the settings.
    pub weight: f32,
}

/// What computes.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Device {
    /// The device's own name.
    pub name: String,
    /// `cpu`, `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
}

impl From<&DeviceInfo> for Device {
    fn from(info: &DeviceInfo) -> Self {
        Self { name: info.name.clone(), kind: info.kind.into() }
    }
}

/// All that a page needs to begin.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Opened {
    /// Number of the request.
    pub id: u32,
    /// The scene; null where there is none yet.
    pub scene: Option<SceneInfo>,
    /// Where to begin.
    pub defaults: Defaults,
    /// Lights that do not depend on the scene, and `design`.
    pub presets: Vec<Titled>,
    /// The terms, in their order.
    pub terms: Vec<TermInfo>,
    /// Ways to search.
    pub optimizers: Vec<Titled>,
    /// What computes.
    pub device: Device,
    /// klieg's version.
    pub version: String,
}

/// What was measured in a picture, beside what is aimed at.
#[derive(Debug, Clone, Copy, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Measured {
    /// Mean brightness, sRGB-encoded.
    pub mean: f32,
    /// What is aimed at.
    pub mean_target: f32,
    /// Standard deviation of the brightness.
    pub spread: f32,
    /// What is aimed at.
    pub spread_target: f32,
    /// Share of the object that is burnt out.
    pub burnt: f32,
    /// Share of the object that no light reaches.
    pub unlit: f32,
}

/// How good a picture is.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Judged {
    /// Number of the request.
    pub id: u32,
    /// `F`; lower is better.
    pub score: f32,
    /// Every term that can be measured, 0 to 1, whatever its weight; lower is better.
    #[cfg_attr(test, ts(type = "Record<string, number>"))]
    pub terms: Terms,
    /// What they were made from.
    pub measured: Measured,
    /// Of the picture that was judged.
    pub quality: Fineness,
}

/// How good a light is in every direction.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Mapped {
    /// Number of the request.
    pub id: u32,
    /// Which light.
    pub light: u32,
    /// Cells side by side.
    pub columns: u32,
    /// Cells above each other.
    pub rows: u32,
    /// `F` of each cell, row by row from the top; null outside the disc. Lambert's azimuthal equal-area projection, the
    /// viewer in its centre and the opposite direction on its rim.
    pub values: Vec<Option<f32>>,
    /// The direction of the lowest of those in which a search may put the light.
    pub best: [f32; 3],
    /// Unit vector upwards, light frame, where searches may put no light below the horizon.
    pub up: Option<[f32; 3]>,
}

/// How a search stands.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Progress {
    /// Number of the last request of the search.
    pub id: u32,
    /// Generations so far.
    pub generation: u32,
    /// Rigs that were judged.
    pub evaluations: u32,
    /// `F` of the best rig in the pictures that the search looks at.
    pub best: f32,
    /// The best rig.
    pub lights: Vec<Light>,
    /// Whether it looks at small pictures still.
    pub small: bool,
    /// Whether it goes on by itself.
    pub running: bool,
    /// Whether it has come to its end.
    pub finished: bool,
}

/// What the server answers; `id` is that of the request.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Answer {
    /// All that a page needs to begin.
    Opened(Box<Opened>),
    /// How good a picture is.
    Judged(Box<Judged>),
    /// How good a light is in every direction.
    Mapped(Mapped),
    /// A light at its new place.
    #[allow(missing_docs, reason = "as the request's")]
    Placed { id: u32, light: u32, lit: Light },
    /// There is no object under the pixel.
    #[allow(missing_docs, reason = "as the request's")]
    Missed { id: u32 },
    /// What is under a pixel.
    Picked {
        /// Number of the request.
        id: u32,
        /// The object's name; null where there is none.
        name: Option<String>,
        /// Its normal there, light frame.
        normal: Option<[f32; 3]>,
        /// The place, light frame.
        position: Option<[f32; 3]>,
    },
    /// How a search stands.
    Progress(Progress),
    /// One of several good rigs; its thumbnail follows.
    #[allow(missing_docs, reason = "as the request's")]
    Alternative { id: u32, index: u32, lights: Vec<Light>, score: f32 },
    /// There are no more.
    #[allow(missing_docs, reason = "as the request's")]
    AlternativesDone { id: u32, count: u32 },
    /// Lights.
    #[allow(missing_docs, reason = "as the request's")]
    Rig { id: u32, lights: Vec<Light> },
    /// What comes of what is wanted.
    Steered {
        /// Number of the request.
        id: u32,
        /// Weights of the terms.
        #[cfg_attr(test, ts(type = "Record<string, number>"))]
        weights: Box<Terms>,
        /// What they aim at.
        targets: Targets,
        /// Radius of each light: that of the new mood, where it has another softness than the old one and the light is
        /// searched.
        sizes: Vec<f32>,
    },
    /// What went wrong, for people; the id is null where the request could not be read.
    #[allow(missing_docs, reason = "as the request's")]
    Fault { id: Option<u32>, message: String },
}
