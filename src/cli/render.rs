//! `klieg render`: a final picture of a lit scene.

use super::input::{self, SceneFile};
use super::options::LookOptions;
use super::picture::PictureOptions;
use super::print;
use super::rig;
use super::score::PresetName;
use super::session::{self, picture, warn};
use super::values::Size;
use crate::design::profile;
use crate::lighting::Rig;
use crate::lighting::presets::Preset;
use crate::report::{self, Inputs, Staging};
use crate::scene::view::View;
use crate::scene::{self, Scene};
use crate::{Error, Result};
use clap::Args;
use std::ffi::OsString;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// Render a lit scene
///
/// Writes a picture of any size with smooth edges and exact shadows: under the scene's own lights
/// (KHR_lights_punctual), those of a result.json, or a usual rig.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Scene: a .gltf or .glb file, or a .ply, .stl or .obj one; '-' for glTF on standard input
    scene: SceneFile,
    /// The picture, a PNG file, whose folder is created where absent; '-' for standard output
    #[arg(short, long, value_name = "FILE.png")]
    out: PathBuf,
    /// Picture size in pixels [default: 512x512, or the size stored with a camera klieg wrote]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Lights from a file: a result.json, or an array of lights as it has them; '-' for standard input. They
    /// stand where it says in the camera's frame and in scene radii, of whatever scene
    #[arg(long, value_name = "FILE.json", conflicts_with = "preset")]
    rig: Option<PathBuf>,
    /// A usual rig
    #[arg(long)]
    preset: Option<PresetName>,
    #[command(flatten)]
    picture: PictureOptions,
    #[command(flatten)]
    look: LookOptions,
}

pub(super) fn run(options: &Options) -> anyhow::Result<()> {
    let mut settings = options.look.settings(profile::DEFAULT)?;
    settings.view.size = options.size.or(settings.view.size);
    options.picture.apply(&mut settings);
    settings.check()?;
    let scene = session::load(options.scene.path()?, &settings.loading())?;
    let view = session::view(&scene, &settings.view)?;
    let rig = lights(options, &scene, &view)?;
    let mut inputs = session::inputs(&scene, options.look.config());
    inputs.extend(Inputs::new(&options.rig));
    let place = Place::new(&options.out, inputs)?;
    let occluders = picture::occluders(&scene, &view, &settings)?;
    let drawn = picture::draw((&scene, &view), occluders.as_ref(), &settings, &[&rig])?;
    let picture = &drawn[0];
    if picture.object == 0.0 {
        return Err(session::sees_nothing(&scene, &view).into());
    }
    place.write(&report::picture::final_png(&picture.image)?)
}

/// The lights that the options name.
fn lights(options: &Options, scene: &Scene, view: &View) -> Result<Rig> {
    if let Some(preset) = options.preset {
        return Ok(Preset::from(preset).rig());
    }
    if let Some(path) = &options.rig {
        return rig::read(path, view);
    }
    if scene.lights.is_empty() {
        let fault = "has no lights: give some with --rig or --preset";
        return Err(Error::input(&scene.path, fault));
    }
    let (rig, warnings) = scene::lights::rig(scene, view)?;
    warn(&warnings);
    Ok(rig)
}

/// Where a picture goes.
pub(super) enum Place {
    /// Standard output.
    Output,
    /// A file, which appears whole or not at all.
    File { folder: PathBuf, name: OsString, inputs: Inputs },
}

impl Place {
    /// Standard output, or the file at `path`, which must not replace any of `inputs`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a path that names no file, or an input, and for a terminal.
    pub fn new(path: &Path, inputs: Inputs) -> Result<Self> {
        if input::is_standard(path) {
            if std::io::stdout().is_terminal() {
                let fault = "a terminal shows no picture: name a file, or redirect standard output";
                return Err(Error::Argument(fault.into()));
            }
            return Ok(Self::Output);
        }
        let fault = || Error::Argument(format!("{} names no file", path.display()));
        let name = path.file_name().ok_or_else(fault)?;
        if path.is_dir() {
            return Err(fault());
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        inputs.spare(folder, [name])?;
        Ok(Self::File { folder: folder.into(), name: name.into(), inputs })
    }

    /// Writes the picture and tells the file; its folder is created where absent.
    ///
    /// # Errors
    /// [`Error::Output`], and standard output that cannot be written to.
    pub fn write(&self, contents: &[u8]) -> anyhow::Result<()> {
        let Self::File { folder, name, inputs } = self else { return print::bytes(contents) };
        let mut staging = Staging::new(folder)?.sparing(inputs.clone());
        staging.write(name, contents)?;
        print::out(print::written(&staging.publish()?))
    }
}
