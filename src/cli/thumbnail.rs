//! `klieg thumbnail`: a small picture of a model under lights that were found for it.

use super::config::Settings;
use super::input::SceneFile;
use super::options::LookOptions;
use super::picture::PictureOptions;
use super::render::Place;
use super::session::{self, Loaded, Session, warn};
use super::values::{Device, Size};
use super::{designer, device};
use crate::design::profile;
use crate::report;
use crate::scene::view::shrunk;
use anyhow::Result;
use clap::Args;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Most pixels of a side of the pictures that are judged.
const JUDGED: u32 = 96;
/// Individuals of a generation.
const POPULATION: usize = 16;
/// Generations.
const GENERATIONS: usize = 24;
/// Directions along a side of the shadow table.
const SHADOW_SIDE: u32 = 15;

/// Draw a model under lights found for it
///
/// One picture: the whole model, or what the file's camera sees, under lights of a short search on the
/// CPU. The same file gives the same picture.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Scene: a .gltf or .glb file, or a .ply, .stl or .obj one; '-' for glTF on standard input
    scene: SceneFile,
    /// The picture, a PNG file, whose folder is created where absent; '-' for standard output
    out: PathBuf,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", default_value = "256x256")]
    size: Size,
    #[command(flatten)]
    picture: PictureOptions,
    #[command(flatten)]
    look: LookOptions,
}

pub(super) fn run(options: &Options) -> Result<()> {
    let begin = Instant::now();
    let mut settings = options.look.settings(profile::DEFAULT)?;
    options.picture.apply(&mut settings);
    shorten(&mut settings, options.size);
    settings.check()?;
    let settings = settings.steered()?;
    let genome = settings.genome()?;
    let loaded = Loaded::read(options.scene.path()?, &settings.loading())?;
    let inputs = session::inputs(&loaded.scene, options.look.config());
    let place = Place::new(&options.out, inputs)?;
    warn(&loaded.scene.warnings);
    let device = device::open(&settings.device, &settings)?;
    let mut session = Session::on(&device, loaded, settings, begin)?;
    let outcome =
        designer::search(&mut session, &genome, None, &mut |_| ControlFlow::Continue(()))?;
    session.settings.view.size = Some(options.size);
    let view = session::view(&session.scene, &session.settings.view)?;
    let drawn = session.render(&view, &[&outcome.rig])?;
    place.write(&report::picture::final_png(&drawn[0].image)?)
}

/// Lets the search be short, with pictures of the shape of `size`.
fn shorten(settings: &mut Settings, Size(size): Size) {
    settings.view.size = Some(Size(shrunk(size, JUDGED)));
    settings.device = Device::Cpu;
    settings.search.population = POPULATION;
    settings.search.generations = GENERATIONS;
    settings.shadows.side = settings.shadows.side.min(SHADOW_SIDE);
}
