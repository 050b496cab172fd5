//! All settings of a run: the defaults, what a TOML file changes, and their checks.
//! `docs/CONFIGURATION.md` is the reference.

use super::optimizer::OptimizerName;
use super::profile::ProfileName;
use super::values::{Device, Lights, Size};
use crate::design::profile::{self, Profile};
use crate::error::within;
use crate::gpu::PipelineKind;
use crate::lighting::LightKind;
use crate::lighting::genome::{Boxes, Genome};
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::optimize::{self, GeneticSettings, GreedySettings, StartSettings};
use crate::render;
use crate::scene::load::FileAccess;
use crate::{Error, Result};
use clap::ValueEnum;
use serde::de;
use serde::{Deserialize, Serialize};
use std::path::Path;

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
    /// How Vulkan devices make the pictures.
    pub pipeline: Pipeline,
    /// Memory of a Vulkan device for the pictures of a population, MiB; half of the device's where absent.
    pub memory: Option<u32>,
    /// Picture and camera.
    pub view: ViewSettings,
    /// The lights that are searched.
    pub lights: LightSettings,
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

/// Picture and camera. Angles in degrees; where any of the four of the framing is given, it takes the
/// place of the file's cameras.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ViewSettings {
    /// Picture size; 512x512, or the size that a lit scene names, where absent.
    pub size: Option<Size>,
    /// Name or index of one of the file's cameras.
    pub camera: Option<CameraKey>,
    /// Azimuth of the framing's camera, 0 on the +Z axis, positive to +X.
    pub azimuth: Option<f64>,
    /// Elevation of the framing's camera.
    pub elevation: Option<f64>,
    /// Vertical field of view of the framing.
    pub fov: Option<f64>,
    /// Share of the picture's height or width that the framing fills, 0..1.
    pub fill: Option<f64>,
}

impl ViewSettings {
    /// Whether the framing is asked for.
    pub fn framed(&self) -> bool {
        [self.azimuth, self.elevation, self.fov, self.fill].iter().any(Option::is_some)
    }

    /// Puts what `over` names in the place of these. A camera of the file and the framing displace
    /// each other.
    pub fn overlay(&mut self, over: &Self) {
        if over.camera.is_some() {
            (self.azimuth, self.elevation, self.fov, self.fill) = (None, None, None, None);
        }
        if over.framed() {
            self.camera = None;
        }
        self.size = over.size.or(self.size);
        self.camera = over.camera.clone().or(self.camera.take());
        self.azimuth = over.azimuth.or(self.azimuth);
        self.elevation = over.elevation.or(self.elevation);
        self.fov = over.fov.or(self.fov);
        self.fill = over.fill.or(self.fill);
    }
}

/// How a file names a camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CameraKey {
    /// By its place in the file.
    Index(usize),
    /// By its name.
    Name(String),
}

impl CameraKey {
    /// The text that stands for it on the command line.
    pub fn text(&self) -> String {
        match self {
            Self::Index(index) => index.to_string(),
            Self::Name(name) => name.clone(),
        }
    }
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
    /// The values that lights of each role may have.
    pub boxes: Boxes,
}

impl Default for Settings {
    fn default() -> Self {
        Self::of(profile::DEFAULT)
    }
}

impl Settings {
    /// The defaults of a profile.
    pub fn of(profile: &'static Profile) -> Self {
        let &Profile { roles, kind, .. } = profile;
        Self {
            profile: ProfileName(profile),
            seed: 0,
            device: Device::default(),
            allow_outside: false,
            pipeline: Pipeline::default(),
            memory: None,
            view: ViewSettings::default(),
            lights: LightSettings {
                roles: Lights(roles.to_vec()),
                kind,
                keep: false,
                boxes: (profile.boxes)(),
            },
            objective: (profile.objective)(),
            shading: (profile.shading)(),
            shadows: ShadowSettings { on: profile.shadows, ..ShadowSettings::default() },
            picture: render::Settings::default(),
            start: StartSettings::default(),
            first: First::default(),
            optimizer: OptimizerName::default(),
            search: GeneticSettings::default(),
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
        let text = std::fs::read_to_string(path).map_err(|e| Error::input(path, e))?;
        let fault = |e: toml::de::Error| Error::input(path, e.to_string().trim_end());
        Self::parse(&text, asked, usual).map_err(fault)
    }

    /// As [`Settings::read`], of a file's text.
    fn parse(
        text: &str,
        asked: Option<&'static Profile>,
        usual: &'static Profile,
    ) -> Result<Self, toml::de::Error> {
        // Read as a whole, the text tells the lines of its faults.
        let Self { profile: ProfileName(own), .. } = toml::from_str(text)?;
        let mut file: toml::Table = toml::from_str(text)?;
        let named = file.contains_key("profile");
        let profile = asked.unwrap_or(if named { own } else { usual });
        file.insert("profile".into(), profile.name.into());
        let mut table = toml::Table::try_from(Self::of(profile)).map_err(de::Error::custom)?;
        overlay(&mut table, file);
        table.try_into()
    }

    /// The files that scenes may name.
    pub fn access(&self) -> FileAccess {
        if self.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder }
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
        if self.memory == Some(0) {
            return Err(Error::Argument("memory is 0 MiB: pictures need 1 or more".into()));
        }
        self.view.check()?;
        self.objective.check()?;
        self.objective.check_without_target()?;
        self.shading.check()?;
        self.shadows.check()?;
        self.picture.check()?;
        self.optimizers().check()
    }

    /// The settings of all optimisers.
    pub fn optimizers(&self) -> optimize::Settings {
        optimize::Settings { start: self.start, genetic: self.search, greedy: self.greedy }
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

impl ViewSettings {
    fn check(&self) -> Result<()> {
        if self.camera.is_some() && self.framed() {
            let fault = "a camera of the file and the angles of a framing exclude each other";
            return Err(Error::Argument(fault.into()));
        }
        let value = |x: Option<f64>, fallback: f64| x.unwrap_or(fallback) as f32;
        within("azimuth", value(self.azimuth, 0.0), -360.0, 360.0)?;
        within("elevation", value(self.elevation, 0.0), -90.0, 90.0)?;
        within("fov", value(self.fov, 35.0), 1.0, 170.0)?;
        within("fill", value(self.fill, 0.85), 0.01, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::profile::{NATURAL, PAPER};
    use crate::objective::terms::TERMS;

    /// The TOML blocks of the reference, of those that begin with `fence`.
    fn documented(fence: &str) -> String {
        let page = include_str!("../../docs/CONFIGURATION.md");
        let fence = format!("```{fence}\n");
        let blocks = page.split(&fence).skip(1);
        blocks.filter_map(|block| block.split("```").next()).collect()
    }

    fn parse(text: &str) -> Settings {
        Settings::parse(text, None, profile::DEFAULT).unwrap()
    }

    /// All keys of a table, dotted.
    fn keys(table: &toml::Table, prefix: &str, out: &mut Vec<String>) {
        for (key, value) in table {
            let name = format!("{prefix}{key}");
            match value {
                toml::Value::Table(inner) => keys(inner, &format!("{name}."), out),
                _ => out.push(name),
            }
        }
    }

    #[test]
    fn the_documented_defaults_are_the_paper_s_and_complete() {
        let text = documented("toml");
        let settings = parse(&text);
        assert_eq!(settings, Settings::of(&PAPER));
        settings.check().unwrap();
        let (mut written, mut all) = (Vec::new(), Vec::new());
        keys(&toml::from_str(&text).unwrap(), "", &mut written);
        keys(&toml::Table::try_from(&settings).unwrap(), "", &mut all);
        written.sort();
        all.sort();
        assert_eq!(written, all);
    }

    #[test]
    fn the_documented_profile_natural_is_all_that_differs_from_the_paper_s() {
        let text = documented("toml natural");
        let natural = parse(&text);
        assert_eq!(natural, Settings::of(&NATURAL));
        assert_eq!(parse("profile = \"natural\""), natural);
        natural.check().unwrap();
        // Without its first line the block still says everything, over the paper's.
        let rest = text.replace("profile = \"natural\"\n", "");
        let Settings { profile, .. } = Settings::of(&PAPER);
        assert_eq!(parse(&rest), Settings { profile, ..natural });
    }

    #[test]
    fn a_file_starts_from_the_profile_that_it_names_or_is_asked_for() {
        let text = "profile = \"natural\"\nseed = 7\n[objective]\nedge_contrast = 0.1\n\
                    [shading]\nambient = 0.5\n[lights]\nkind = \"spot\"\n";
        let mut natural = Settings::of(&NATURAL);
        natural.seed = 7;
        natural.objective.edge_contrast = 0.1;
        natural.shading.ambient = 0.5;
        natural.lights.kind = LightKind::SPOT;
        assert_eq!(parse(text), natural);
        assert_eq!(Settings::parse(text, None, &PAPER).unwrap(), natural);
        let paper = Settings::parse(text, Some(&PAPER), &NATURAL).unwrap();
        assert_eq!((paper.profile, paper.seed), (ProfileName(&PAPER), 7));
        assert_eq!(paper.objective.weights, Objective::default().weights);
        assert_eq!(paper.objective.edge_contrast, 0.1);
        assert_eq!(Settings::parse("", None, &NATURAL).unwrap(), Settings::of(&NATURAL));
        // Weights and boxes that are given are taken whole.
        let text = "[objective.weights]\nedge = 1\n[lights.boxes.fill]\nelevation = [0, 1]\n\
                    azimuth = [0, 1]\ndiffuse = [0, 1]\ndistance = [1, 2]\n";
        let given = Settings::parse(text, None, &NATURAL).unwrap();
        assert!(given.objective.weights.names().eq(["edge"]));
        assert!(!given.lights.boxes.fill.share_of_key);
        assert_eq!(given.lights.boxes.rim, natural.lights.boxes.rim);
        assert_eq!(given.objective.mean_target, natural.objective.mean_target);
        let fault = Settings::parse("seed = 1\nprofile = \"film\"", None, &PAPER).unwrap_err();
        let fault = fault.to_string();
        assert!(fault.contains("line 2") && fault.contains("paper, natural"), "{fault}");
    }

    #[test]
    fn the_documented_view_keys_are_known() {
        // A comment of the form `# key = value` is a key that is absent by default.
        let uncomment = |line: &str| {
            let key = line.strip_prefix("# ").filter(|rest| rest.split(' ').nth(1) == Some("="));
            format!("{}\n", key.unwrap_or(line))
        };
        let text = documented("toml");
        let lines = text.lines().filter(|line| !line.starts_with("# camera"));
        let text: String = lines.map(uncomment).collect();
        let settings = parse(&text);
        assert!(settings.view.framed() && settings.view.size == Some(Size([512, 512])));
        settings.check().unwrap();
    }

    #[test]
    fn faults_name_file_line_and_key() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "seed = 1\n[search]\npopulatoin = 3\n").unwrap();
        let fault = Settings::read(file.path(), None, profile::DEFAULT).unwrap_err();
        let text = fault.to_string();
        assert!(fault.is_input());
        assert!(text.contains(&file.path().display().to_string()), "{text}");
        assert!(text.contains("line 3") && text.contains("populatoin"), "{text}");
    }

    #[test]
    fn weights_are_those_of_any_terms() {
        let read =
            |text: &str| Settings::parse(text, None, &PAPER).map(|settings| settings.objective);
        let objective = read("[objective.weights]\nrelief = 0.5\nedge = 0\nmean = 0.25").unwrap();
        let weights: Vec<_> = objective.weights.iter().map(|(t, w)| (t.name, w)).collect();
        assert_eq!(weights, [("edge", 0.0), ("mean", 0.25), ("relief", 0.5)]);
        let all: String = TERMS.iter().map(|term| format!("{} = 0.1\n", term.name)).collect();
        let objective = read(&format!("[objective.weights]\n{all}")).unwrap();
        assert!(objective.weights.names().eq(TERMS.iter().map(|term| term.name)));
        let fault = read("[objective]\n[objective.weights]\nedge = 1\nreleif = 1\n").unwrap_err();
        let fault = fault.to_string();
        for said in ["line 2", "no term 'releif'", "relief, direction, target"] {
            assert!(fault.contains(said), "{fault}");
        }
        assert!(read("[objective.weights]\nedge = true").is_err());
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in [
            "[objective]\nmean_target = nan",
            "[objective]\nmean_target = -1",
            "[objective]\nedge_contrast = 0.0",
            "[objective.weights]\nedge = -1.0\nmean = 1.0\ngrad = 1.0\nvar = 1.0\nhist = 1.0",
            "[objective.weights]\nedge = 0.0\nmean = 0.0\ngrad = 0.0\nvar = 0.0\nhist = 0.0",
            "[objective.weights]\ntarget = 1.0",
            "[objective.weights]",
            "[shading]\nambient = inf",
            "[view]\nfov = 180.0",
            "[view]\ncamera = 0\nfov = 35.0",
            "[search]\npopulation = 1",
            "[greedy]\nstarts = 0",
            "[greedy]\nstarts = 1025",
        ] {
            let settings = parse(text);
            assert!(settings.check().is_err(), "{text}");
        }
        for text in ["[view]\nsize = \"0x5\"", "[lights]\nroles = 17", "device = true"] {
            assert!(toml::from_str::<Settings>(text).is_err(), "{text}");
        }
    }
}
