//! All settings of a run: the defaults, what a TOML file changes, and their checks.
//! `docs/CONFIGURATION.md` is the reference.

use super::input;
use super::intent::Keep;
use super::optimizer::OptimizerName;
use super::profile::ProfileName;
use super::values::{Device, Lights, Times};
pub use super::view::{CameraKey, ViewSettings};
pub use super::views::{Cameras, ViewsSettings};
use crate::design::profile::{self, Profile};
use crate::design::{CoarseSettings, Intent};
use crate::error::within;
use crate::gpu::PipelineKind;
use crate::lighting::genome::{Boxes, Genome};
use crate::lighting::shading::Shading;
use crate::lighting::{Color, LightKind, Role};
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::optimize::{self, GeneticSettings, GreedySettings, ShadeSettings, StartSettings};
use crate::render::{self, Background};
use crate::scene::load::{FileAccess, LoadOptions, Moment, Orientation, Up};
use crate::{Error, Result};
use clap::ValueEnum;
use serde::de;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Most bytes of a configuration file.
const MAX_BYTES: u64 = 1 << 20;

/// Everything that a configuration file can say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What all others start from.
    pub profile: ProfileName,
    /// Seed of every random choice.
    pub seed: u64,
    /// What computes.
    pub device: Device,
    /// Whether scenes may name files outside their folders.
    pub allow_outside: bool,
    /// Metres of a unit in PLY, STL and OBJ files; the format's usual ones where absent.
    pub units: Option<f64>,
    /// The axis that points upwards in them; the format's usual one where absent.
    pub up: Option<Up>,
    /// Whether scenes may take much more memory and time than files of their size do.
    pub allow_large: bool,
    /// The moment of scenes' animations that is shown.
    pub pose: PoseSettings,
    /// How Vulkan devices make the pictures.
    pub pipeline: Pipeline,
    /// Memory of a Vulkan device for the pictures of a population, MiB; half of the device's where absent.
    pub memory: Option<u32>,
    /// Most seconds of a search, which then ends with its best; none where absent.
    pub time_limit: Option<f64>,
    /// Picture and camera.
    pub view: ViewSettings,
    /// Several views that one rig is designed for.
    pub views: ViewsSettings,
    /// The lights that are searched.
    pub lights: LightSettings,
    /// What light is wanted.
    pub intent: Intent,
    /// Names of the objects for which it is wanted most.
    pub focus: Vec<String>,
    /// Names of the objects that are to stay dim.
    pub dim: Vec<String>,
    /// The quality function.
    pub objective: Objective,
    /// The shading model.
    pub shading: Shading,
    /// Shadows.
    pub shadows: ShadowSettings,
    /// Final pictures.
    pub picture: render::Settings,
    /// The first population.
    pub start: StartSettings,
    /// Where the search begins.
    pub first: First,
    /// How the lights are searched.
    pub optimizer: OptimizerName,
    /// The genetic algorithm.
    pub search: GeneticSettings,
    /// SHADE.
    pub shade: ShadeSettings,
    /// Small pictures at first.
    pub coarse: CoarseSettings,
    /// The greedy descents.
    pub greedy: GreedySettings,
}

/// How Vulkan devices make the pictures of a population.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pipeline {
    /// The fastest for the device
    #[default]
    Auto,
    /// One batched draw that shades the stored surface
    Layered,
    /// One batched draw of the scene's geometry
    Forward,
    /// Compute shaders over the object's pixels
    Compute,
}

impl Pipeline {
    /// What is asked for; nothing where the device decides.
    pub fn kind(self) -> Option<PipelineKind> {
        match self {
            Self::Auto => None,
            Self::Layered => Some(PipelineKind::Layered),
            Self::Forward => Some(PipelineKind::Forward),
            Self::Compute => Some(PipelineKind::Compute),
        }
    }
}

/// The first individual of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum First {
    /// Lights in the directions of the clusters of the visible normals
    #[default]
    KMeans,
    /// A random rig
    Random,
    /// The scene's own lights
    Scene,
    /// One light from the viewer
    Headlight,
    /// VTK's LightKit: key, fill, two back lights and a headlight
    LightKit,
    /// The photographer's key, fill and back light
    ThreePoint,
}

/// The moment in which animated scenes are shown; the first animation's beginning, where there is one and
/// nothing is given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseSettings {
    /// Name or index of an animation; the first one where absent.
    pub animation: Option<String>,
    /// Seconds from its beginning; several moments are as many views.
    pub time: Option<Times>,
    /// Whether no animation moves anything.
    pub rest: bool,
}

/// The lights that are searched.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightSettings {
    /// How many, or their roles.
    pub roles: Lights,
    /// Point, directional or spot.
    pub kind: LightKind,
    /// Whether the scene's own lights stay and count.
    pub keep: bool,
    /// Lights, or values of lights, of the first rig that stay as they are.
    pub hold: Vec<Keep>,
    /// Whether each light is searched as the best addition to those before it.
    pub one_by_one: bool,
    /// The values that lights of each role may have.
    pub boxes: Boxes,
}

impl LightSettings {
    /// Gives every light one intensity, as lamps have, or a diffuse and a specular one; a specular range that is missing
    /// is that of the diffuse intensity.
    pub fn set_intensities(&mut self, one: bool) {
        for space in self.boxes.all_mut() {
            space.specular = if one { None } else { space.specular.or(Some(space.diffuse)) };
        }
    }

    /// Gives lights of `role`, or of all roles, a colour.
    ///
    /// # Errors
    /// As [`Boxes::of_mut`].
    pub fn set_color(&mut self, role: Option<Role>, color: Color) -> Result<()> {
        match role {
            Some(role) => self.boxes.of_mut(role)?.color = color,
            None => self.boxes.all_mut().into_iter().for_each(|space| space.color = color),
        }
        Ok(())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::of(profile::DEFAULT)
    }
}

impl Settings {
    /// The defaults of a profile.
    pub fn of(profile: &'static Profile) -> Self {
        let &Profile { roles, kind, ref optimizer, population, coarse, .. } = profile;
        Self {
            profile: ProfileName(profile),
            seed: 0,
            device: Device::default(),
            allow_outside: false,
            units: None,
            up: None,
            allow_large: false,
            pose: PoseSettings::default(),
            pipeline: Pipeline::default(),
            memory: None,
            time_limit: None,
            view: ViewSettings::default(),
            views: ViewsSettings::default(),
            lights: LightSettings {
                roles: Lights(roles.to_vec()),
                kind,
                keep: false,
                hold: Vec::new(),
                one_by_one: false,
                boxes: (profile.boxes)(),
            },
            intent: Intent::default(),
            focus: Vec::new(),
            dim: Vec::new(),
            objective: (profile.objective)(),
            shading: (profile.shading)(),
            shadows: ShadowSettings { on: profile.shadows, ..ShadowSettings::default() },
            picture: render::Settings::default(),
            start: StartSettings::default(),
            first: First::default(),
            optimizer: OptimizerName(optimizer),
            search: GeneticSettings { population, ..GeneticSettings::default() },
            shade: ShadeSettings::default(),
            coarse,
            greedy: GreedySettings::default(),
        }
    }

    /// The settings of a TOML file. What it does not name is as the profile has it that is `asked` for, else
    /// the file's own, else the `usual` one.
    ///
    /// # Errors
    /// [`Error::Input`] with file, line and key.
    pub fn read(
        path: &Path,
        asked: Option<&'static Profile>,
        usual: &'static Profile,
    ) -> Result<Self> {
        Self::read_over(path, toml::Table::new(), asked, usual)
    }

    /// As [`Settings::read`], with the tables `over` in the place of what the file says.
    ///
    /// # Errors
    /// As [`Settings::read`], and as [`Settings::of_table`].
    pub fn read_over(
        path: &Path,
        over: toml::Table,
        asked: Option<&'static Profile>,
        usual: &'static Profile,
    ) -> Result<Self> {
        let text = input::text(path, MAX_BYTES)?;
        let fault = |e: toml::de::Error| Error::input(input::name(path), e.to_string().trim_end());
        Self::parse(&text, over, asked, usual).map_err(fault)
    }

    /// As [`Settings::read_over`], of a file's text.
    fn parse(
        text: &str,
        over: toml::Table,
        asked: Option<&'static Profile>,
        usual: &'static Profile,
    ) -> Result<Self, toml::de::Error> {
        // Read as a whole, the text tells the lines of its faults.
        let Self { profile: ProfileName(own), .. } = toml::from_str(text)?;
        let mut file: toml::Table = toml::from_str(text)?;
        let named = file.contains_key("profile");
        overlay(&mut file, over);
        Self::of_table(file, asked.unwrap_or(if named { own } else { usual }))
    }

    /// The settings of the tables of a configuration file. What they do not name is as the profile has it, in the place
    /// of any that they name themselves.
    ///
    /// # Errors
    /// The first key that there is not, or value that it cannot have.
    pub fn of_table(
        mut tables: toml::Table,
        profile: &'static Profile,
    ) -> Result<Self, toml::de::Error> {
        tables.insert("profile".into(), profile.name.into());
        let mut table = toml::Table::try_from(Self::of(profile)).map_err(de::Error::custom)?;
        overlay(&mut table, tables);
        let mut settings: Self = table.try_into()?;
        settings.judge_background();
        Ok(settings)
    }

    /// Lets the background of final pictures count, where it is a colour that was given.
    pub fn judge_background(&mut self) {
        self.objective.background = self.picture.background.and_then(Background::luminance);
    }

    /// How scenes are loaded: in the first of the moments, where there are several.
    pub fn loading(&self) -> LoadOptions {
        self.loading_at(self.pose.time.map(|times| times.first()))
    }

    /// As [`Settings::loading`], in another moment.
    pub fn loading_at(&self, time: Option<f32>) -> LoadOptions {
        let PoseSettings { animation, rest, .. } = self.pose.clone();
        let moment = match (rest, &animation, time) {
            (true, ..) => Moment::Rest,
            (false, None, None) => Moment::Start,
            _ => Moment::At { animation, time: time.unwrap_or(0.0) },
        };
        let access =
            if self.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder };
        let orientation = Orientation { units: self.units, up: self.up };
        LoadOptions { access, orientation, moment, large: self.allow_large }
    }

    /// The genome of the lights that are searched.
    ///
    /// # Errors
    /// As [`Genome::new`].
    pub fn genome(&self) -> Result<Genome> {
        Genome::new(&self.lights.roles.0, self.lights.kind, &self.lights.boxes)
    }

    /// # Errors
    /// [`Error::Argument`] that names the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        if self.units.is_some_and(|units| !(units.is_finite() && units > 0.0)) {
            return Err(Error::Argument(
                "units must be more than 0: it is how many metres a unit has".into(),
            ));
        }
        if self.memory == Some(0) {
            return Err(Error::Argument("memory is 0 MiB: it must be 1 or more".into()));
        }
        self.view.check()?;
        self.check_views()?;
        within("time_limit", self.time_limit.unwrap_or(1.0) as f32, f32::MIN_POSITIVE, f32::MAX)?;
        within("time", self.pose.time.map_or(0.0, |times| times.first()), 0.0, f32::MAX)?;
        self.objective.check()?;
        self.objective.check_without_target()?;
        self.check_intent()?;
        self.shading.check()?;
        self.shadows.check()?;
        self.picture.check()?;
        self.coarse.check()?;
        self.optimizers().check()
    }

    /// The settings of all optimisers.
    pub fn optimizers(&self) -> optimize::Settings {
        let &Self { start, search: genetic, shade, greedy, .. } = self;
        optimize::Settings { start, genetic, shade, greedy }
    }
}

/// Tables of a file that take the place of the defaults' as a whole.
const WHOLE: [&str; 4] = ["weights", "key", "fill", "rim"];

/// Puts what `over` names in the place of what is there.
fn overlay(table: &mut toml::Table, over: toml::Table) {
    for (name, value) in over {
        match (table.get_mut(&name), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(over))
                if !WHOLE.contains(&name.as_str()) =>
            {
                overlay(inner, over);
            }
            (_, value) => drop(table.insert(name, value)),
        }
    }
}

#[cfg(test)]
mod tests;
