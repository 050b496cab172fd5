//! `klieg score`: the quality of a given rig.

use super::lights::{LightOptions, kinds};
use super::options::{SceneOptions, TargetOptions};
use super::print;
use super::session::{Session, warn};
use super::values::LightArg;
use super::views::ViewsOptions;
use crate::design::profile;
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
    #[command(flatten)]
    views: ViewsOptions,
    /// A light: elevation and azimuth in degrees in the camera's frame, distance in scene radii,
    /// diffuse and specular intensity; up to 16 times
    #[arg(long = "light", value_name = "EL,AZ,R,ID,IS", allow_hyphen_values = true)]
    lights: Vec<LightArg>,
    /// Kind of these lights; the cone of a spot has a half angle of 45° [default: point]
    #[arg(long, requires = "lights", value_parser = kinds())]
    kind: Option<LightKind>,
    /// A usual rig
    #[arg(long, conflicts_with = "lights")]
    preset: Option<PresetName>,
    #[command(flatten)]
    look: LightOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum PresetName {
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
    let mut settings = options.scene.settings_of(profile::DEFAULT, &options.views)?;
    options.target.apply(&mut settings);
    options.look.apply(&mut settings)?;
    if options.look.colored() && options.lights.is_empty() && options.preset.is_none() {
        let fault =
            "--color goes with --light or --preset: the scene's own lights have their colours";
        return Err(crate::Error::Argument(fault.into()).into());
    }
    let kind = options.kind.unwrap_or(settings.lights.kind);
    let mut session = Session::open(options.scene.path()?, settings)?;
    let (source, rig) = rig(options, kind, &session)?;
    let (quality, each) = session.evaluator.judge(&rig, session.settings.views.rig)?;
    let score = Score {
        header: session.header(Score::SCHEMA),
        objective: (&session.settings.objective).into(),
        quality,
        views: session.views_record(&each, &[]),
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
    let (source, mut rig) = if let Some(name) = options.preset {
        let preset = Preset::from(name);
        (preset.name(), preset.rig())
    } else if options.lights.is_empty() {
        let (rig, warnings) = scene::lights::rig(&session.scene, &session.view)?;
        warn(&warnings);
        return Ok(("scene", rig));
    } else {
        let role = |i| if i == 0 { Role::Key } else { Role::Fill };
        let lights = options.lights.iter().enumerate();
        ("options", lights.map(|(i, light)| light.light(kind, role(i))).collect())
    };
    for light in &mut rig {
        light.color = session.settings.lights.boxes.of(light.role)?.color;
    }
    Ok((source, session.with_kept(rig)))
}
