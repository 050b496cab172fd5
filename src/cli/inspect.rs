//! `klieg inspect`: what is in a file, and what klieg does with it.

use super::input::SceneFile;
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
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

/// Say what is in a scene, and what klieg does with it
///
/// Reads the file as all commands do and tells what it draws, what it leaves out and why, and where it
/// cannot use the file, what can be done about that.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Scene: a .gltf or .glb file, or a .ply, .stl or .obj one; '-' for glTF on standard input
    scene: SceneFile,
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
    let path = options.scene.path()?;
    let contents = Contents::read(path)?;
    let loading = settings.loading();
    let scene = load::load_with(path, loading.clone());
    let pose = loading.moment.in_words(&contents.animations);
    let (drawn, left_out, fault) = match scene {
        Ok(scene) => (Some(Drawn::of(&scene, pose)?), scene.warnings, None),
        Err(fault) => (None, Vec::new(), Some(fault)),
    };
    let inspection = Inspection {
        schema: "klieg.inspect/1",
        klieg: env!("CARGO_PKG_VERSION"),
        file: path.display().to_string(),
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
        let instances = counted(*instances, "drawing", "drawings");
        let materials = counted(*materials, "material", "materials");
        let triangles = counted(*triangles as usize, "triangle", "triangles");
        let mut text = String::from("\nWhat klieg draws\n");
        line(&mut text, "geometry", &format!("{triangles} in {instances} of meshes, {materials}"));
        line(&mut text, "textures", &sizes(&self.textures));
        line(&mut text, "extent", &format!("a ball of radius {radius:.3} holds it"));
        line(&mut text, "pose", pose);
        let camera = match &self.cameras[..] {
            [] => "klieg's own framing, which shows all of it: the file has none".to_owned(),
            [only] => print::name(only),
            [first, ..] => {
                format!("{}, the first of {}", print::name(first), listed(&self.cameras))
            }
        };
        line(&mut text, "camera", &camera);
        if !self.lights.is_empty() {
            let lights = listed(&self.lights);
            line(
                &mut text,
                "lights",
                &format!("{lights}; 'design' replaces them, --keep-lights keeps them"),
            );
        }
        text
    }
}

/// A number of things in words.
fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// How many textures there are of each size.
fn sizes(textures: &[[u32; 2]]) -> String {
    let mut sizes: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    textures.iter().for_each(|size| *sizes.entry(*size).or_default() += 1);
    let each =
        |([width, height], count): (&[u32; 2], &usize)| format!("{count} of {width}x{height}");
    sizes.iter().rev().map(each).collect::<Vec<_>>().join(", ")
}

/// The first entries of a list.
fn listed(list: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<_> = list.iter().take(SHOWN).map(|entry| print::name(entry)).collect();
    let more = list.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

/// What is said of something, where anything is.
fn line(text: &mut String, name: &str, value: &str) {
    if !value.is_empty() {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {name:<11} {value}");
    }
}

/// What people call glTF's lists; those that mean nothing to them are left out.
const LISTS: [(&str, &str, &str); 8] = [
    ("nodes", "node", "nodes"),
    ("meshes", "mesh", "meshes"),
    ("primitives", "primitive", "primitives"),
    ("morphTargets", "morph target", "morph targets"),
    ("skins", "skin", "skins"),
    ("materials", "material", "materials"),
    ("cameras", "camera", "cameras"),
    ("lights", "light", "lights"),
];

impl Inspection {
    /// For people.
    fn show(&self) -> String {
        let Contents { container, bytes, version, generator, counts, .. } = &self.contents;
        let name = print::name(&self.file);
        let mut text = format!("{name}: {container} {version}, {}", print::bytes_in_words(*bytes));
        if !generator.is_empty() {
            text += &format!(", written by {}", print::name(generator));
        }
        text += "\n\nWhat the file holds\n";
        let part = |&(key, one, many): &(&str, &str, &str)| {
            let count = counts.get(key).copied().filter(|&count| count > 0)?;
            Some(counted(count, one, many))
        };
        let parts: Vec<_> = LISTS.iter().filter_map(part).collect();
        line(&mut text, "parts", &parts.join(", "));
        let kind = |(name, count): (&String, &usize)| format!("{count} {name}");
        let images: Vec<_> = self.contents.images.iter().map(kind).collect();
        line(&mut text, "images", &images.join(", "));
        let animation = |animation: &load::contents::AnimationInfo| {
            let name = if animation.name.is_empty() { "unnamed" } else { &animation.name };
            format!("{name} ({:.2} s)", animation.seconds)
        };
        let animations: Vec<_> = self.contents.animations.iter().map(animation).collect();
        line(&mut text, "animations", &listed(&animations));
        line(&mut text, "extensions", &listed(&self.contents.extensions_used));
        text += &self.drawn.as_ref().map(Drawn::show).unwrap_or_default();
        if !self.left_out.is_empty() {
            text += "\nWhat klieg leaves out or replaces\n";
            text.extend(self.left_out.iter().map(|warning| format!("  {warning}\n")));
        }
        if let Some(fault) = &self.fault {
            text += &format!("\nklieg cannot use it\n  {fault}\n");
        }
        if self.fault.is_some() && !self.contents.extensions_required.is_empty() {
            text += "  Export it without the extensions that klieg does not read, or let a tool such as\n  \
                     'gltf-transform copy' write it anew without them.\n";
        }
        text
    }
}
