//! `klieg inspect`: what is in a file, and what klieg does with it.

use super::options::LookOptions;
use super::print;
use crate::design::profile;
use crate::report::json;
use crate::scene::load::contents::Contents;
use crate::scene::view::bounds;
use crate::scene::{Scene, load};
use crate::{Error, Result};
use clap::Args;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Say what is in a scene, and what klieg does with it
///
/// Reads the file as all commands do and tells what it draws, what it leaves out and why, and where it
/// cannot use the file, what can be done about that.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// The scene: a .gltf, .glb, .ply, .stl or .obj file
    scene: PathBuf,
    #[command(flatten)]
    look: LookOptions,
    /// Print JSON, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

/// `klieg inspect --json`.
#[derive(Debug, Serialize)]
struct Inspection {
    schema: &'static str,
    klieg: &'static str,
    /// The file, as it was given.
    file: String,
    /// What the file holds, used or not.
    contents: Contents,
    /// What klieg draws of it; none where it cannot use the file.
    drawn: Option<Drawn>,
    /// What is left out or replaced.
    left_out: Vec<String>,
    /// Why klieg cannot use the file.
    fault: Option<String>,
}

/// What is drawn.
#[derive(Debug, Serialize)]
struct Drawn {
    triangles: u32,
    /// Drawings of meshes.
    instances: usize,
    materials: usize,
    /// Width and height of each texture.
    textures: Vec<[u32; 2]>,
    cameras: Vec<String>,
    lights: Vec<String>,
    /// Of the ball round all that is drawn, world units.
    radius: f64,
    /// The moment of the file's animations that is shown.
    pose: String,
    /// All files that were read.
    files: Vec<PathBuf>,
}

pub(super) fn run(options: &Options) -> anyhow::Result<()> {
    let settings = options.look.settings(profile::DEFAULT)?;
    settings.check()?;
    let contents = Contents::read(&options.scene)?;
    let loading = settings.loading();
    let scene = load::load_with(&options.scene, loading.clone());
    let pose = loading.moment.in_words(&contents.animations);
    let (drawn, left_out, fault) = match scene {
        Ok(scene) => (Some(Drawn::of(&scene, pose)?), scene.warnings, None),
        Err(fault) => (None, Vec::new(), Some(fault)),
    };
    let inspection = Inspection {
        schema: "klieg.inspect/1",
        klieg: env!("CARGO_PKG_VERSION"),
        file: options.scene.display().to_string(),
        contents,
        drawn,
        left_out,
        fault: fault.as_ref().map(reason),
    };
    if options.json {
        print::out(json::text(&inspection)?)?
    } else {
        print::out(inspection.show())?
    }
    match fault {
        Some(fault) => Err(fault.into()),
        None => Ok(()),
    }
}

/// A fault without the file's name.
fn reason(fault: &Error) -> String {
    match fault {
        Error::Input { fault, .. } => fault.clone(),
        other => other.to_string(),
    }
}

impl Drawn {
    fn of(scene: &Scene, pose: String) -> Result<Self> {
        let (_, radius) = bounds(scene)?;
        let size = |texture: &crate::scene::Texture| {
            texture.levels.first().map_or([0; 2], |level| [level.width, level.height])
        };
        let light = |light: &crate::scene::SceneLight| format!("{} ({})", light.name, light.kind);
        Ok(Self {
            triangles: scene.polygons(),
            instances: scene.instances.len(),
            // The last one is glTF's default material.
            materials: scene.materials.len() - 1,
            textures: scene.textures.iter().map(size).collect(),
            cameras: scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
            lights: scene.lights.iter().map(light).collect(),
            radius,
            pose,
            files: scene.files.clone(),
        })
    }

    /// For people.
    fn show(&self) -> String {
        let Self { triangles, instances, materials, radius, pose, .. } = self;
        let mut text = format!(
            "klieg draws\n  {triangles} triangles in {instances} drawings of meshes, {materials} materials\n  \
             a scene of radius {radius:.3}\n  pose: {pose}\n"
        );
        let sizes: Vec<_> = self.textures.iter().map(|[w, h]| format!("{w}x{h}")).collect();
        let of_view = match &self.cameras[..] {
            [] => vec!["klieg's own framing".to_owned()],
            cameras => cameras.to_vec(),
        };
        for (name, list) in
            [("textures", &sizes), ("cameras", &of_view), ("lights of its own", &self.lights)]
        {
            if !list.is_empty() {
                line(&mut text, name, list);
            }
        }
        text
    }
}

/// A list on a line, its first entries.
fn line(text: &mut String, name: &str, list: &[String]) {
    const SHOWN: usize = 8;
    let shown: Vec<_> = list.iter().take(SHOWN).map(|entry| print::name(entry)).collect();
    let more = list.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    // Writing to a string does not fail.
    let _ = writeln!(text, "  {name}: {}{more}", shown.join(", "));
}

impl Inspection {
    /// For people.
    fn show(&self) -> String {
        let Contents { container, bytes, version, generator, counts, .. } = &self.contents;
        let mut text = format!("{}: {container} {version}, {bytes} bytes", print::name(&self.file));
        if !generator.is_empty() {
            text += &format!(", by {}", print::name(generator));
        }
        text += "\nit holds\n";
        let number = |(name, count): (&String, &usize)| format!("{count} {name}");
        let counts: Vec<_> = counts.iter().filter(|(_, count)| **count > 0).map(number).collect();
        text += &format!("  {}\n", counts.join(", "));
        let images: Vec<_> = self.contents.images.iter().map(number).collect();
        let animation = |animation: &load::contents::AnimationInfo| {
            let name = if animation.name.is_empty() { "unnamed" } else { &animation.name };
            format!("{name} ({:.2} s)", animation.seconds)
        };
        let animations: Vec<_> = self.contents.animations.iter().map(animation).collect();
        for (name, list) in [
            ("images", &images),
            ("animations", &animations),
            ("extensions", &self.contents.extensions_used),
        ] {
            if !list.is_empty() {
                line(&mut text, name, list);
            }
        }
        text += &self.drawn.as_ref().map(Drawn::show).unwrap_or_default();
        if !self.left_out.is_empty() {
            text += "klieg leaves out or replaces\n";
            text.extend(self.left_out.iter().map(|warning| format!("  {warning}\n")));
        }
        if let Some(fault) = &self.fault {
            text += &format!("klieg cannot use it\n  {fault}\n");
        }
        if self.fault.is_some() && !self.contents.extensions_required.is_empty() {
            text += "  Export it without the extensions that klieg does not read, or let a tool such as\n  \
                     'gltf-transform copy' write it anew without them.\n";
        }
        text
    }
}
