//! An engine on wgpu that lets klieg design its lights: `cargo run --example engine_wgpu -- FOLDER`.
//!
//! It draws a small world headless and saves pictures of it before and after, and the scores that klieg
//! gave on the engine's device beside those that the native evaluator gives. It fails where they differ,
//! and where the validation layer has anything to say of wgpu's calls and klieg's.

mod design;
mod gpu;
mod handover;
mod picture;
mod pictures;
mod renderer;
mod surface;
mod world;

use design::{RIGS, SIZE, Scored, Stage};
use gpu::Gpu;
use renderer::Renderer;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, error, fs};
use world::World;

type Result<T> = std::result::Result<T, Box<dyn error::Error>>;

/// Largest difference between the scores of two evaluators.
const TOLERANCE: f32 = 1e-4;

fn main() -> Result<()> {
    let folder = PathBuf::from(env::args_os().nth(1).ok_or("name a folder for the pictures")?);
    fs::create_dir_all(&folder)?;
    let gpu = Gpu::new()?;
    let levels = run(&gpu, &folder)?;
    let messages = gpu.finish();
    if !messages.is_empty() {
        return Err(messages.join("\n\n").into());
    }
    let mut table = "level,klieg,native\n".to_owned();
    for (level, scores) in &levels {
        for [klieg, native] in scores {
            writeln!(table, "{level},{klieg},{native}")?;
        }
    }
    fs::write(folder.join("scores.csv"), table)?;
    let agree = |[klieg, native]: &Scored| (klieg - native).abs() <= TOLERANCE;
    match levels.iter().flat_map(|(_, scores)| scores).find(|&scores| !agree(scores)) {
        Some([klieg, native]) => {
            Err(format!("klieg says {klieg} in the engine, {native} natively").into())
        }
        None => Ok(()),
    }
}

/// Everything on the device, all of it gone at the end.
fn run(gpu: &Gpu, folder: &Path) -> Result<Vec<(&'static str, Vec<Scored>)>> {
    let world = World::new();
    let renderer = Renderer::new(gpu, &world, SIZE, RIGS);
    let context = handover::context(gpu)?;
    let stage = Stage { gpu, renderer: &renderer, bounds: world.bounds(), folder };
    Ok(vec![
        ("surface", surface::design(&stage, &context)?),
        ("pictures", pictures::design(&stage, &context)?),
    ])
}
