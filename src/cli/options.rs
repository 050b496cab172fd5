//! Options that several subcommands share, and how they change the settings.

use super::config::{CameraKey, First, Pipeline, PoseSettings, Settings, ViewSettings};
use super::input::SceneFile;
use super::intent::IntentOptions;
use super::lights::{Intensities, LightOptions, kinds};
use super::optimizer::OptimizerName;
use super::picture::PictureOptions;
use super::profile::ProfileOptions;
use super::values::{Device, Lights, Size, Times, Weights};
use super::views::ViewsOptions;
use crate::Result;
use crate::design::profile::Profile;
use crate::lighting::LightKind;
use crate::lighting::shading::Brdf;
use crate::scene::load::Up;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// The scene, how it is looked at, and how pictures are judged.
#[derive(Debug, Args)]
pub(super) struct SceneOptions {
    /// Scene: a .gltf or .glb file, or a .ply, .stl or .obj one; '-' for glTF on standard input
    scene: SceneFile,
    #[command(flatten)]
    look: LookOptions,
    /// Print JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// How scenes are looked at, and how pictures are judged.
#[derive(Debug, Args)]
pub(super) struct LookOptions {
    /// A camera of the scene [default: the one klieg wrote, else the first, else a framing of the
    /// whole scene]
    #[arg(long, value_name = "NAME|INDEX", conflicts_with_all = ["azimuth", "elevation", "fov"])]
    camera: Option<String>,
    /// Azimuth of the framing's camera in degrees: 0 on the +Z axis, positive to +X. Like the next
    /// two, it asks for the framing even where the scene has cameras [framing's default: 30]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    azimuth: Option<f64>,
    /// Elevation of the framing's camera in degrees [framing's default: 15]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    elevation: Option<f64>,
    /// Vertical field of view of the framing in degrees [framing's default: 35]
    #[arg(long, value_name = "DEGREES")]
    fov: Option<f64>,
    #[command(flatten)]
    profile: ProfileOptions,
    /// Weights of the terms in 'klieg terms', such as grad=0.5,relief=0.2: they are set, all others stay.
    /// Five numbers are those of the paper's terms edge,mean,grad,var,hist, which alone then count
    /// [default: the profile's]
    #[arg(long, value_name = "WEIGHTS", allow_hyphen_values = true)]
    weights: Option<Weights>,
    /// How surfaces reflect [default: the profile's]
    #[arg(long, value_name = "BRDF")]
    brdf: Option<Reflection>,
    /// Let scenes name files outside their own folders too: by '..', by absolute paths or 'file:'
    /// URIs, or over symbolic links; what they name may come to stand in lit.glb
    #[arg(long)]
    allow_outside: bool,
    /// Metres of a unit in a PLY, STL or OBJ file [default: 1; STL: 0.001]
    #[arg(long, value_name = "METRES")]
    units: Option<f64>,
    /// The axis that points upwards in a PLY, STL or OBJ file [default: y; STL: z]
    #[arg(long, value_name = "y|z")]
    up: Option<UpAxis>,
    /// Take scenes that need much more memory and time than files of their size do
    #[arg(long)]
    allow_large: bool,
    #[command(flatten)]
    pose: PoseOptions,
    /// Read settings from a TOML file, '-' for standard input; options on the command line override the file
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Whether lights cast shadows [default: the profile's; natural: on]
    #[arg(long, value_name = "on|off")]
    shadows: Option<Shadows>,
}

/// The axis that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum UpAxis {
    /// As in glTF
    Y,
    /// As in most programs that construct
    Z,
}

impl From<UpAxis> for Up {
    fn from(axis: UpAxis) -> Self {
        match axis {
            UpAxis::Y => Self::Y,
            UpAxis::Z => Self::Z,
        }
    }
}

/// The moment in which animated scenes are shown.
#[derive(Debug, Args)]
struct PoseOptions {
    /// An animation of the scene [default: the first one, at its beginning]
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "rest")]
    animation: Option<String>,
    /// The moment of the animation that is shown, in seconds [default: 0]. Several, such as 0:2:0.25 for every quarter of
    /// the first two seconds, are views that 'design', 'batch' and 'score' judge a rig by together
    #[arg(
        long,
        value_name = "SECONDS|START:END:STEP",
        conflicts_with = "rest",
        allow_hyphen_values = true
    )]
    time: Option<Times>,
    /// Show the scene as its nodes stand in the file, whatever its animations are
    #[arg(long)]
    rest: bool,
}

impl PoseOptions {
    /// Puts these options in the place of `pose`.
    fn apply(&self, pose: &mut PoseSettings) {
        if self.rest {
            *pose = PoseSettings { rest: true, ..PoseSettings::default() };
        }
        if self.animation.is_some() || self.time.is_some() {
            pose.rest = false;
        }
        pose.animation = self.animation.clone().or(pose.animation.take());
        pose.time = self.time.or(pose.time);
    }
}

/// Whether lights cast shadows.
#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
pub(super) enum Shadows {
    /// They do
    On,
    /// Nothing blocks light
    Off,
}

/// How surfaces reflect.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Reflection {
    /// Lambert, and a Blinn-Phong lobe of the material's width
    BlinnPhong,
    /// As glTF 2.0 has it and its viewers show it: Lambert under GGX
    Gltf,
    /// The same with what rough surfaces scatter more than once, as path tracers and viewers have it
    GltfScattering,
}

impl From<Reflection> for Brdf {
    fn from(reflection: Reflection) -> Self {
        match reflection {
            Reflection::BlinnPhong => Self::BlinnPhong,
            Reflection::Gltf => Self::Gltf,
            Reflection::GltfScattering => Self::GltfScattering,
        }
    }
}

/// One picture size and one device.
#[derive(Debug, Args)]
pub(super) struct TargetOptions {
    /// Picture size in pixels [default: 512x512, or the size stored with a camera klieg wrote]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// auto, vulkan, cpu, or the number or a part of the name of a device in 'klieg devices'
    /// [default: auto]
    #[arg(long)]
    device: Option<Device>,
    /// How a Vulkan device makes the pictures [default: auto]
    #[arg(long, value_name = "PIPELINE")]
    pipeline: Option<Pipeline>,
    /// Memory of a Vulkan device for the pictures of a population; one that needs more is evaluated in
    /// parts, with the same scores [default: half of the device's memory]
    #[arg(long, value_name = "MIB")]
    memory: Option<u32>,
}

/// What is searched, and how.
#[derive(Debug, Args)]
pub(super) struct SearchOptions {
    /// The lights: roles such as key,fill,rim, or a number from 1 to 16 (a key, a fill, a rim, then
    /// fills and rims in turn) [default: the profile's, key,fill]
    #[arg(long, value_name = "ROLES|NUMBER")]
    lights: Option<Lights>,
    /// Kind of the lights [default: the profile's, point]
    #[arg(long, value_parser = kinds())]
    kind: Option<LightKind>,
    /// Intensities of each light [default: the profile's; paper: two]
    #[arg(long, value_name = "NUMBER")]
    intensities: Option<Intensities>,
    #[command(flatten)]
    look: LightOptions,
    /// Individuals of a generation, 2 or more [default: the profile's; natural: 20, paper: 30]
    #[arg(long, value_name = "N")]
    population: Option<usize>,
    /// Generations, 1 or more; a search may end before [default: 100]
    #[arg(long, value_name = "N")]
    generations: Option<usize>,
    /// End the search with its best after so many seconds, whatever is left of it; the generation at work
    /// is finished
    #[arg(long, value_name = "SECONDS")]
    time_limit: Option<f64>,
    /// How the lights are searched [default: the profile's; natural: shade, paper: ga]
    #[arg(long, value_name = "NAME", value_parser = OptimizerName::parser())]
    optimizer: Option<OptimizerName>,
    /// Longest side of the small pictures that the search begins with; 0 for none
    /// [default: the profile's; natural: 128, paper: 0]
    #[arg(long, value_name = "PIXELS")]
    coarse: Option<u32>,
    /// Where the search begins [default: k-means]
    #[arg(long, value_name = "RIG")]
    first: Option<First>,
    /// Seed of every random choice [default: 0]
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    intent: IntentOptions,
}

/// The settings with the options of what searches lights and draws final pictures.
///
/// # Errors
/// As [`SearchOptions::apply`].
pub(super) fn completed(
    mut settings: Settings,
    (target, search, picture): (&TargetOptions, &SearchOptions, &PictureOptions),
) -> Result<Settings> {
    target.apply(&mut settings);
    search.apply(&mut settings)?;
    picture.apply(&mut settings);
    Ok(settings)
}

impl SceneOptions {
    /// As [`LookOptions::settings`].
    ///
    /// # Errors
    /// The same.
    pub fn settings(&self, usual: &'static Profile) -> Result<Settings> {
        self.look.settings(usual)
    }

    /// As [`LookOptions::settings_of`].
    ///
    /// # Errors
    /// The same.
    pub fn settings_of(&self, usual: &'static Profile, views: &ViewsOptions) -> Result<Settings> {
        self.look.settings_of(usual, views)
    }

    /// The configuration file.
    pub fn config(&self) -> Option<&Path> {
        self.look.config()
    }

    /// As [`SceneFile::path`].
    ///
    /// # Errors
    /// The same.
    pub fn path(&self) -> Result<&Path> {
        self.scene.path()
    }
}

impl LookOptions {
    /// The configuration file.
    pub fn config(&self) -> Option<&Path> {
        self.config.as_deref()
    }

    /// The configuration file's settings, or the defaults, with these options in their place. The `usual`
    /// profile is that of a command where nobody names one.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the file cannot be used, and [`crate::Error::Argument`] where several views are asked
    /// for.
    pub fn settings(&self, usual: &'static Profile) -> Result<Settings> {
        let settings = self.all_settings(usual)?;
        settings.one_view()?;
        Ok(settings)
    }

    /// The same of a command that knows several views.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the file cannot be used.
    pub fn settings_of(&self, usual: &'static Profile, views: &ViewsOptions) -> Result<Settings> {
        let mut settings = self.all_settings(usual)?;
        views.apply(&mut settings);
        Ok(settings)
    }

    fn all_settings(&self, usual: &'static Profile) -> Result<Settings> {
        let asked = self.profile.asked();
        let mut settings = match &self.config {
            Some(path) => Settings::read(path, asked, usual)?,
            None => Settings::of(asked.unwrap_or(usual)),
        };
        settings.view.overlay(&ViewSettings {
            camera: self.camera.clone().map(CameraKey::Name),
            azimuth: self.azimuth,
            elevation: self.elevation,
            fov: self.fov,
            ..ViewSettings::default()
        });
        settings.allow_outside |= self.allow_outside;
        settings.units = self.units.or(settings.units);
        settings.up = self.up.map(Up::from).or(settings.up);
        settings.allow_large |= self.allow_large;
        self.pose.apply(&mut settings.pose);
        if let Some(brdf) = self.brdf {
            settings.shading.brdf = brdf.into();
        }
        if let Some(shadows) = self.shadows {
            settings.shadows.on = shadows == Shadows::On;
        }
        if let Some(weights) = &self.weights {
            weights.apply(&mut settings.objective.weights)?;
        }
        Ok(settings)
    }
}

impl TargetOptions {
    /// Puts these options in the place of `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        settings.view.size = self.size.or(settings.view.size);
        if let Some(device) = &self.device {
            settings.device = device.clone();
        }
        settings.pipeline = self.pipeline.unwrap_or(settings.pipeline);
        settings.memory = self.memory.or(settings.memory);
    }
}

impl SearchOptions {
    /// The picture that they name.
    pub fn picture(&self) -> Option<&Path> {
        self.intent.picture()
    }

    /// Puts these options in the place of `settings`.
    ///
    /// # Errors
    /// As [`LightOptions::apply`].
    pub fn apply(&self, settings: &mut Settings) -> Result<()> {
        if let Some(lights) = &self.lights {
            settings.lights.roles = lights.clone();
        }
        settings.lights.kind = self.kind.unwrap_or(settings.lights.kind);
        if let Some(intensities) = self.intensities {
            settings.lights.set_intensities(intensities == Intensities::One);
        }
        self.intent.apply(settings)?;
        self.look.apply(settings)?;
        let search = &mut settings.search;
        search.population = self.population.unwrap_or(search.population);
        search.generations = self.generations.unwrap_or(search.generations);
        settings.time_limit = self.time_limit.or(settings.time_limit);
        settings.optimizer = self.optimizer.unwrap_or(settings.optimizer);
        settings.coarse.side = self.coarse.unwrap_or(settings.coarse.side);
        settings.first = self.first.unwrap_or(settings.first);
        settings.seed = self.seed.unwrap_or(settings.seed);
        Ok(())
    }
}
