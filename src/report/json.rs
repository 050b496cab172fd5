//! Results for other programs. `docs/RESULT.md` is the reference of the schemas.

use super::text::visible_json;
use crate::design::profile::Profile;
use crate::design::{Intent, Outcome, Over};
use crate::evaluate::DeviceInfo;
use crate::lighting::{Color, Cone, Light, LightKind, Role, Stand};
use crate::objective::{Example, MeanTarget, Objective, Quality, Terms};
use crate::scene::Scene;
use crate::scene::view::{Projection, View};
use glam::DVec3;
use serde::Serialize;

/// What every result begins with.
#[derive(Debug, Clone, Serialize)]
pub struct Header {
    /// Name and version of the schema.
    pub schema: &'static str,
    /// klieg's version.
    pub klieg: &'static str,
    /// The profile that the settings started from.
    pub profile: &'static str,
    /// The scene's file, as it was given.
    pub scene: String,
    /// The camera.
    pub camera: CameraRecord,
    /// What computed.
    pub device: DeviceInfo,
    /// Width and height of the picture.
    pub size: [u32; 2],
}

impl Header {
    /// The beginning of a result of `schema`.
    pub fn new(
        schema: &'static str,
        profile: &Profile,
        (scene, view): (&Scene, &View),
        device: &DeviceInfo,
    ) -> Self {
        Self {
            schema,
            klieg: env!("CARGO_PKG_VERSION"),
            profile: profile.name,
            scene: scene.path.display().to_string(),
            camera: CameraRecord::new(view),
            device: device.clone(),
            size: [view.width, view.height],
        }
    }
}

/// A camera, in world units.
#[derive(Debug, Clone, Serialize)]
pub struct CameraRecord {
    /// Name.
    pub name: String,
    /// Lens.
    #[serde(flatten)]
    pub lens: Lens,
    /// Position.
    pub position: DVec3,
    /// Unit axes: to the right, up, and from the scene to the viewer.
    pub right: DVec3,
    /// See `right`.
    pub up: DVec3,
    /// See `right`.
    pub back: DVec3,
}

/// A camera's lens.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Lens {
    /// Vertical field of view, degrees.
    Perspective {
        /// Full angle.
        yfov_deg: f64,
    },
    /// Half of the picture's height, world units.
    Orthographic {
        /// Half height.
        ymag: f64,
    },
}

impl CameraRecord {
    /// That of a view.
    pub fn new(view: &View) -> Self {
        let camera = &view.camera;
        let lens = match camera.projection {
            Projection::Perspective { yfov } => Lens::Perspective { yfov_deg: yfov.to_degrees() },
            Projection::Orthographic { ymag } => Lens::Orthographic { ymag },
        };
        Self {
            name: camera.name.clone(),
            lens,
            position: camera.eye,
            right: camera.right,
            up: camera.up,
            back: camera.back,
        }
    }
}

/// The quality function's settings.
#[derive(Debug, Clone, Serialize)]
pub struct ObjectiveRecord {
    /// Weight of each term.
    pub weights: Terms,
    /// What the terms aim at.
    pub targets: Targets,
}

/// What the terms aim at: see [`Objective`].
#[derive(Debug, Clone, Serialize)]
pub struct Targets {
    /// Mean brightness.
    pub mean: MeanTarget,
    /// Stops by which that is moved.
    pub mean_stops: f32,
    /// Standard deviation of the brightness.
    pub spread: f32,
    /// Gradient of a fully distinct edge.
    pub edge_contrast: f32,
    /// Depth gradient of an edge.
    pub edge_sobel: f32,
    /// Depth curvature of an edge.
    pub edge_laplace: f32,
    /// The example's statistics; null where none was given.
    pub example: Option<Example>,
    /// Luminance behind the objects; null where none was given.
    pub background: Option<f32>,
}

impl From<&Objective> for ObjectiveRecord {
    fn from(objective: &Objective) -> Self {
        let &Objective {
            weights,
            mean_target: mean,
            mean_stops,
            spread_target: spread,
            edge_contrast,
            edge_sobel,
            edge_laplace,
            example,
            background,
        } = objective;
        let targets = Targets {
            mean,
            mean_stops,
            spread,
            edge_contrast,
            edge_sobel,
            edge_laplace,
            example,
            background,
        };
        Self { weights, targets }
    }
}

/// A light.
#[derive(Debug, Clone, Serialize)]
pub struct LightRecord {
    /// What it is for.
    pub role: Role,
    /// How it reaches the scene.
    pub kind: LightKind,
    /// Colour: a temperature (`5600K`) or the sRGB colour nearest to it (`#ffddaa`).
    pub color: Color,
    /// The same in linear RGB of luminance 1.
    pub color_rgb: [f32; 3],
    /// Elevation in the camera's frame, degrees.
    pub elevation_deg: f32,
    /// Azimuth in the camera's frame, degrees.
    pub azimuth_deg: f32,
    /// Distance from the scene's centre, scene radii; none for directional lights.
    pub distance: Option<f32>,
    /// Radius of the light itself, scene radii.
    pub size: f32,
    /// Half angles of a spot's cone, inner and outer, degrees; none for other lights.
    pub cone_deg: Option<[f32; 2]>,
    /// Diffuse intensity.
    pub diffuse: f32,
    /// Specular intensity.
    pub specular: f32,
    /// Position, world units; none for directional lights.
    pub position: Option<DVec3>,
    /// Unit axis of a spot's cone, world space, away from the light; none for other lights.
    pub axis: Option<DVec3>,
}

impl LightRecord {
    /// The light as it stands in the world of `view`.
    pub fn new(light: &Light, view: &View) -> Self {
        let reach = light.reach();
        let Cone { inner, outer } = light.cone;
        let cone = light.kind.cone.then(|| [inner, outer].map(f32::to_degrees));
        let place = |reach| {
            let direction = light.direction().as_dvec3();
            view.frame.point_to_world(direction * f64::from(reach))
        };
        Self {
            role: light.role,
            kind: light.kind,
            elevation_deg: light.elevation.to_degrees(),
            azimuth_deg: light.azimuth.to_degrees(),
            distance: reach,
            diffuse: light.diffuse,
            specular: light.specular,
            position: reach.map(place),
            color: light.color,
            color_rgb: light.color.linear(),
            size: light.size,
            cone_deg: cone,
            axis: cone.map(|_| view.frame.direction_to_world(light.axis().as_dvec3())),
        }
    }

    /// All lights of a rig.
    pub fn rig(rig: &[Light], view: &View) -> Vec<Self> {
        rig.iter().map(|light| Self::new(light, view)).collect()
    }
}

/// What became of the scene's own lights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct SceneLights {
    /// How many there are.
    pub count: usize,
    /// Whether they stay in the lit scene and count in all scores, rather than neither.
    pub kept: bool,
}

impl SceneLights {
    /// For people; nothing where there are none.
    pub fn in_words(&self) -> Option<String> {
        let (lights, verb) = match self.count {
            0 => return None,
            1 => ("light".into(), "is"),
            count => (format!("{count} lights"), "are"),
        };
        Some(if self.kept {
            format!("The scene's own {lights} {verb} kept and counted in all scores.")
        } else {
            format!(
                "The scene's own {lights} {verb} taken out of the lit scene and counted in no score; \
                 --keep-lights keeps what the scene has."
            )
        })
    }
}

/// Wall time of a run's parts, milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Reading the scene.
    pub load: f64,
    /// Setting the device up, drawing the view and making its maps.
    pub maps: f64,
    /// The search.
    pub search: f64,
    /// All until the files were written.
    pub total: f64,
}

/// `result.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Design {
    /// Schema `klieg.result/1`.
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
    /// Whether strokes said where highlights and shadows were to lie.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub strokes: bool,
    /// Settings of the quality function.
    pub objective: ObjectiveRecord,
    /// The best rig's quality.
    #[serde(flatten)]
    pub quality: Quality,
    /// The headlight's quality.
    pub headlight: Quality,
    /// The best rig.
    pub lights: Vec<LightRecord>,
    /// Of a rig for several views what these are: `F` and the terms above are those over all of them. The lights stand as in
    /// the first one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewsRecord>,
    /// Other rigs, good and different, best first, where any were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Alternative>,
    /// The scene's own lights.
    pub scene_lights: SceneLights,
    /// Generations that were run.
    pub generations: usize,
    /// Rigs that were evaluated.
    pub evaluations: usize,
    /// Wall time.
    pub timing_ms: Timing,
}

impl Design {
    /// The schema's name.
    pub const SCHEMA: &'static str = "klieg.result/1";

    /// What a search found.
    pub fn new(
        header: Header,
        (seed, objective): (u64, &Objective),
        (quality, headlight): (Quality, Quality),
        outcome: &Outcome,
        view: &View,
    ) -> Self {
        Self {
            header,
            seed,
            intent: Intent::default(),
            focus: Vec::new(),
            dim: Vec::new(),
            strokes: false,
            objective: objective.into(),
            quality,
            headlight,
            lights: LightRecord::rig(&outcome.rig, view),
            views: None,
            alternatives: Vec::new(),
            scene_lights: SceneLights::default(),
            generations: outcome.history.len(),
            evaluations: outcome.evaluations(),
            timing_ms: Timing::default(),
        }
    }
}

/// Several views.
#[derive(Debug, Clone, Serialize)]
pub struct ViewsRecord {
    /// What the rig stands in.
    pub rig: Stand,
    /// How the scores became one.
    pub over: Over,
    /// The views, in order.
    pub each: Vec<ViewRecord>,
}

/// One of several views.
#[derive(Debug, Clone, Serialize)]
pub struct ViewRecord {
    /// What it shows, for people.
    pub title: String,
    /// The camera.
    pub camera: CameraRecord,
    /// The moment, seconds; none where there is one alone.
    pub time: Option<f32>,
    /// The rig's quality in it.
    #[serde(flatten)]
    pub quality: Quality,
    /// The headlight's, which goes with the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub headlight: Option<Quality>,
}

/// A rig that is as good as a design's, or nearly, and looks different.
#[derive(Debug, Clone, Serialize)]
pub struct Alternative {
    /// Its quality.
    #[serde(flatten)]
    pub quality: Quality,
    /// Its lights.
    pub lights: Vec<LightRecord>,
}

/// What `klieg score --json` prints.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// Schema `klieg.score/1`.
    #[serde(flatten)]
    pub header: Header,
    /// Settings of the quality function.
    pub objective: ObjectiveRecord,
    /// The rig's quality.
    #[serde(flatten)]
    pub quality: Quality,
    /// The views, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewsRecord>,
    /// Where the rig is from: `scene`, `options` or a preset's name.
    pub rig: &'static str,
    /// The rig.
    pub lights: Vec<LightRecord>,
}

impl Score {
    /// The schema's name.
    pub const SCHEMA: &'static str = "klieg.score/1";
}

/// Indented JSON with a line break at its end; control characters in names are escaped.
///
/// # Errors
/// None in practice: the results have string keys alone.
pub fn text(value: &impl Serialize) -> serde_json::Result<String> {
    serde_json::to_string_pretty(value).map(|text| visible_json(&text).into_owned() + "\n")
}
