//! `klieg score`: the quality of a given rig.

use super::options::{Kind, SceneOptions, TargetOptions};
use super::print;
use super::session::{Session, warn};
use super::values::LightArg;
use crate::lighting::presets::Preset;
use crate::lighting::{LightKind, Rig, Role, check_number};
use crate::report::json::{self, LightRecord, Score};
use crate::scene;
use anyhow::Result;
use clap::{Args, ValueEnum};

/// Score given lights
///
/// Without --light and --preset, the scene's own lights (KHR_lights_punctual) are scored.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// A light: elevation and azimuth in degrees in the camera's frame, distance in scene radii,
    /// diffuse and specular intensity; up to 16 times
    #[arg(long = "light", value_name = "EL,AZ,R,ID,IS", allow_hyphen_values = true)]
    lights: Vec<LightArg>,
    /// Kind of these lights [default: point]
    #[arg(long, requires = "lights")]
    kind: Option<Kind>,
    /// A usual rig
    #[arg(long, conflicts_with = "lights")]
    preset: Option<PresetName>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PresetName {
    /// One light from the viewer
    Headlight,
    /// VTK's LightKit: key, fill, two back lights and a headlight
    LightKit,
    /// The photographer's key, fill and back light
    ThreePoint,
}

impl From<PresetName> for Preset {
    fn from(name: PresetName) -> Self {
        match name {
            PresetName::Headlight => Self::Headlight,
            PresetName::LightKit => Self::LightKit,
            PresetName::ThreePoint => Self::ThreePoint,
        }
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    // None is no fault: the scene's own lights or a preset are meant then.
    check_number(options.lights.len().max(1))?;
    let mut settings = options.scene.settings()?;
    options.target.apply(&mut settings);
    let kind = options.kind.map_or(settings.lights.kind, Into::into);
    let mut session = Session::open(&options.scene.scene, settings)?;
    let (source, rig) = rig(options, kind, &session)?;
    let inspection = session.evaluator.inspect(&rig)?;
    let score = Score {
        header: session.header(Score::SCHEMA),
        objective: (&session.settings.objective).into(),
        quality: inspection.quality(),
        rig: source,
        lights: LightRecord::rig(&rig, &session.view),
    };
    if options.scene.json {
        print::out(json::text(&score)?)
    } else {
        print::out(print::score(&score))
    }
}

/// The rig and where it is from.
fn rig(options: &Options, kind: LightKind, session: &Session) -> Result<(&'static str, Rig)> {
    if let Some(name) = options.preset {
        let preset = Preset::from(name);
        return Ok((preset.name(), preset.rig()));
    }
    if options.lights.is_empty() {
        let (rig, warnings) = scene::lights::rig(&session.scene, &session.view)?;
        warn(&warnings);
        return Ok(("scene", rig));
    }
    let role = |i| if i == 0 { Role::Key } else { Role::Fill };
    let lights = options.lights.iter().enumerate();
    Ok(("options", lights.map(|(i, light)| light.light(kind, role(i))).collect()))
}
