//! What page and server say to each other: JSON in text frames of a WebSocket. `studio/src/messages.ts` is made of these
//! types; `docs/STUDIO_PROTOCOL.md` says when each is sent.
//!
//! Pictures are binary frames: `PICTURE_HEADER` bytes, then RGBA rows from the top.

use crate::design::Intent;
use crate::lighting::{LightKind, Role};
use crate::objective::Terms;
use serde::{Deserialize, Serialize};
use serde_json::Value;

#[cfg(test)]
use ts_rs::TS;

/// The first number of a picture's header, "KLGS" in the bytes of a big-endian number.
pub const PICTURE_MAGIC: u32 = 0x4b4c_4753;

/// Bytes of a picture's header: eight little-endian 32-bit numbers, which are `PICTURE_MAGIC`, the request's id, width
/// and height in pixels, kind (0 picture, 1 thumbnail), the thumbnail's index, `Fineness` and microseconds that it took.
pub const PICTURE_HEADER: usize = 32;

/// A camera that looks at a point, in world space with +Y upwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Camera {
    /// The point in the middle of the picture, world units.
    pub target: [f64; 3],
    /// From where it looks, degrees: 0 on the +Z axis, positive to +X.
    pub azimuth: f64,
    /// The same upwards, degrees, -90 to 90.
    pub elevation: f64,
    /// From the target, scene radii.
    pub distance: f64,
    /// Vertical field of view, degrees; of an orthographic one, what the target's plane shows of it.
    pub yfov: f64,
    /// Whether all rays of the view are parallel.
    pub orthographic: bool,
    /// A camera of the file, which then stands in the place of all else that is said here.
    #[serde(default)]
    pub named: Option<String>,
}

/// A light in the light frame: the camera's axes (x to the right, y upwards, z to the viewer) at the scene's centre,
/// lengths in scene radii.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Light {
    /// What it is for. One of role `scene` stands in the file already, and no search changes it.
    #[cfg_attr(test, ts(type = "'key' | 'fill' | 'rim' | 'scene'"))]
    pub role: Role,
    /// How it reaches the scene.
    #[cfg_attr(test, ts(type = "'point' | 'directional' | 'spot'"))]
    pub kind: LightKind,
    /// From the scene's centre towards the light; any length.
    pub direction: [f32; 3],
    /// From the scene's centre; a directional light has one too, and ignores it.
    pub distance: f32,
    /// Diffuse intensity.
    pub diffuse: f32,
    /// Specular intensity.
    pub specular: f32,
    /// Linear RGB; its luminance does not count, the server's has 1.
    pub color: [f32; 3],
    /// Radius of the light itself.
    pub size: f32,
    /// Half angles of a spot's cone, inner and outer, degrees.
    pub cone: [f32; 2],
    /// Unit axis of a spot's cone, away from the light; towards the scene's centre where null.
    #[serde(default)]
    pub aim: Option<[f32; 3]>,
    /// Whether searches leave it as it is.
    #[serde(default)]
    pub locked: bool,
}

/// What terms aim at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Targets {
    /// Mean brightness, sRGB-encoded, 0 to 1; that of the scene's own colours where null.
    pub mean: Option<f32>,
    /// Photographic stops by which that is moved, -4 to 4.
    pub stops: f32,
    /// Standard deviation of the brightness, sRGB-encoded, 0 to 0.5.
    pub spread: f32,
}

/// A view under lights, and how it is judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Look {
    /// From where the scene is seen.
    pub camera: Camera,
    /// 1 to 16 lights.
    pub lights: Vec<Light>,
    /// Weight of each term, by name; a term without one has 0.
    #[cfg_attr(test, ts(type = "Record<string, number>"))]
    pub weights: Terms,
    /// What they aim at.
    pub targets: Targets,
    /// What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
    /// they are, whatever it says.
    #[serde(default)]
    pub intent: Intent,
    /// Names of the objects for which it is wanted most.
    #[serde(default)]
    pub focus: Vec<String>,
    /// Names of the objects that are to stay dim.
    #[serde(default)]
    pub dim: Vec<String>,
}

/// What a page holds and a session file keeps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Document {
    /// The scene's id; it holds as long as the server runs.
    #[serde(default)]
    pub scene: Option<String>,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The view and its lights.
    #[serde(flatten)]
    pub look: Look,
    /// Whatever else the page keeps.
    #[serde(default)]
    #[cfg_attr(test, ts(type = "unknown"))]
    pub page: Value,
}

/// What `POST /save/…` is sent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Save {
    /// What is saved.
    pub document: Document,
    /// Width of the picture; that of the document where null. So are the next two.
    #[serde(default)]
    pub width: Option<u32>,
    /// Its height.
    #[serde(default)]
    pub height: Option<u32>,
    /// Samples of a pixel, a square number up to 64; 16 where null.
    #[serde(default)]
    pub samples: Option<u32>,
}

/// What a search is told to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// To begin at the lights as they stand, whatever it did before; it goes on as it was where neither they nor anything
    /// else has changed since it paused.
    Start,
    /// To wait, and keep what it has.
    Pause,
    /// One generation, then to wait.
    Step,
    /// To end.
    Stop,
}

/// What of a light falls on the place that is pointed at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "lowercase")]
pub enum What {
    /// Its highlight: the normal stands between light and viewer.
    Highlight,
    /// Its brightest shading: the normal points to the light.
    Shading,
    /// Its rim: the light grazes the place from behind.
    Rim,
}

/// To begin.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Open {
    /// Number of the request, which its answers carry.
    pub id: u32,
    /// A scene that was posted; that of the command line, if any, where null.
    #[serde(default)]
    pub scene: Option<String>,
}

/// To show and to judge.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Draw {
    /// See `Open`.
    pub id: u32,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What is shown.
    #[serde(flatten)]
    pub look: Look,
    /// Whether the final picture is wanted too.
    pub at_rest: bool,
    /// Width and height of that, pixels, of the same shape; those of `size` where null.
    #[serde(default)]
    pub rest: Option<[u32; 2]>,
}

/// To judge one light in all directions.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Map {
    /// See `Open`.
    pub id: u32,
    /// Which light.
    pub light: u32,
    /// Cells side by side, up to 129.
    pub columns: u32,
    /// Cells above each other, up to 129.
    pub rows: u32,
    /// Width and height of the whole picture, whose shape the judged ones have.
    pub size: [u32; 2],
    /// What is judged.
    #[serde(flatten)]
    pub look: Look,
}

/// To put a light where something of it falls on a pixel.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Place {
    /// See `Open`.
    pub id: u32,
    /// Which light.
    pub light: u32,
    /// What of it.
    pub what: What,
    /// Pixel of the picture, from the left and from the top; fractions count.
    pub pixel: [f32; 2],
    /// Width and height of that picture.
    pub size: [u32; 2],
    /// From where it is seen.
    pub camera: Camera,
    /// The lights as they stand.
    pub lights: Vec<Light>,
}

/// To tell what is under the pointer.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Pick {
    /// See `Open`.
    pub id: u32,
    /// Pixel of the picture, from the left and from the top.
    pub pixel: [f32; 2],
    /// Width and height of that picture.
    pub size: [u32; 2],
    /// From where it is seen.
    pub camera: Camera,
}

/// To search.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Search {
    /// See `Open`.
    pub id: u32,
    /// What to do.
    pub action: Action,
    /// Width and height of the picture that is judged.
    pub size: [u32; 2],
    /// Where the search begins, and what it looks for.
    #[serde(flatten)]
    pub look: Look,
    /// Name of an optimiser; that of the settings where null.
    #[serde(default)]
    pub optimizer: Option<String>,
    /// Of every random choice; that of the settings where null.
    #[serde(default)]
    pub seed: Option<u32>,
}

/// To find other lights that are as good.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Alternatives {
    /// See `Open`.
    pub id: u32,
    /// How many, 2 to 24.
    pub count: u32,
    /// Width and height of the picture that is judged.
    pub size: [u32; 2],
    /// What they are for; locked lights stay.
    #[serde(flatten)]
    pub look: Look,
}

/// To name lights that do not depend on the scene, or `design`: the best that the last search has found.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Preset {
    /// See `Open`.
    pub id: u32,
    /// Name of a preset.
    pub name: String,
}

/// To keep lights where they are in the world while the camera moves.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Follow {
    /// See `Open`.
    pub id: u32,
    /// The camera in whose frame the lights are told.
    pub from: Camera,
    /// The camera in whose frame they are wanted.
    pub to: Camera,
    /// The lights.
    pub lights: Vec<Light>,
}

/// To say what light is wanted.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Steer {
    /// See `Open`.
    pub id: u32,
    /// What was wanted before.
    pub from: Intent,
    /// What is wanted.
    pub to: Intent,
    /// The lights.
    pub lights: Vec<Light>,
}

/// What the page asks. A newer request takes the place of an unanswered older one of its type.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Request {
    /// Answered by `Answer::Opened`.
    Open(Open),
    /// Answered by pictures, and `Answer::Judged` for each but the final one.
    Draw(Draw),
    /// Answered by `Answer::Mapped`.
    Map(Map),
    /// Answered by `Answer::Placed` or `Answer::Missed`.
    Place(Place),
    /// Answered by `Answer::Picked`.
    Pick(Pick),
    /// Answered by `Answer::Progress`, at most ten a second.
    Search(Search),
    /// Answered by `Answer::Alternative` with a thumbnail each, then `Answer::AlternativesDone`.
    Alternatives(Alternatives),
    /// Answered by `Answer::Rig`.
    Preset(Preset),
    /// Answered by `Answer::Rig`.
    Follow(Follow),
    /// Answered by `Answer::Steered`.
    Steer(Steer),
}

impl Request {
    /// Its number.
    pub fn id(&self) -> u32 {
        match self {
            Self::Open(Open { id, .. })
            | Self::Draw(Draw { id, .. })
            | Self::Map(Map { id, .. })
            | Self::Place(Place { id, .. })
            | Self::Pick(Pick { id, .. })
            | Self::Search(Search { id, .. })
            | Self::Alternatives(Alternatives { id, .. })
            | Self::Preset(Preset { id, .. })
            | Self::Follow(Follow { id, .. })
            | Self::Steer(Steer { id, .. }) => *id,
        }
    }
}
