//! What the fuzz targets do with their bytes, and what must hold then. `make fuzz` runs them under libFuzzer;
//! klieg's own tests run them on the seeds in `seeds/`, and on bytes by chance.

mod mutation;

use klieg::cli::readers;
use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::lighting::presets::Preset;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::objective::shadows::ShadowSettings;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load::contents::Contents;
use klieg::scene::load::{LoadOptions, load_with};
use klieg::scene::view::View;
use klieg::scene::{Scene, lit};
use std::path::Path;
use std::sync::LazyLock;

/// A target: its name, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const TARGETS: [Target; 7] = [
    ("scene", scene),
    ("glb", glb),
    ("picture", picture),
    ("model", model),
    ("settings", settings),
    ("list", list),
    ("rig", rig),
];

/// A view of the sound scene, beside whose axes lights are told.
static VIEW: LazyLock<View> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bases = [path.join("bases/scene.gltf"), path.join("fuzz/bases/scene.gltf")];
    let base = bases.iter().find(|base| base.is_file()).expect("the sound scene");
    let scene = load_with(base, LoadOptions::default()).expect("a sound scene");
    let camera = frame(&scene, &Framing::default(), 1.0).expect("a camera");
    View::new(&scene, camera, 16, 16).expect("a view")
});

/// Most drawings and triangles of a scene that is drawn, so that a run takes no longer than a moment.
const SMALL: (usize, u32) = (1000, 10_000);

/// A glTF scene that was sound, with changes that the bytes tell: numbers, parts of its JSON, bytes of its buffer.
pub fn scene(data: &[u8]) {
    let (name, file) = mutation::scene(data);
    with_file(name, &file, |path| drop(judged(path)));
}

/// The bytes are a GLB.
pub fn glb(data: &[u8]) {
    with_file("scene.glb", data, |path| drop(judged(path)));
}

/// The bytes are the picture of a sound scene.
pub fn picture(data: &[u8]) {
    let file = mutation::with_picture(data);
    with_file("scene.gltf", &file, |path| drop(judged(path)));
}

/// The bytes are a model, of a format that the first of them tells.
pub fn model(data: &[u8]) {
    let Some((&format, data)) = data.split_first() else { return };
    let names = ["model.ply", "model.stl", "model.obj"];
    with_file(names[usize::from(format) % 3], data, |path| drop(judged(path)));
}

/// The bytes are a configuration file.
pub fn settings(data: &[u8]) {
    with_file("settings.toml", data, |path| drop(readers::settings(path)));
}

/// The bytes are a list for a batch: TOML or, after a 0, text.
pub fn list(data: &[u8]) {
    let (name, data) = match data {
        [0, data @ ..] => ("list.txt", data),
        data => ("list.toml", data),
    };
    with_file(name, data, |path| drop(readers::list(path)));
}

/// The bytes are lights in JSON, such as a `result.json`.
pub fn rig(data: &[u8]) {
    with_file("result.json", data, |path| drop(readers::rig(path, &VIEW)));
}

/// Gives a file of these bytes to `work`.
fn with_file(name: &str, bytes: &[u8], work: impl FnOnce(&Path)) {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    let folder = folder.expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    work(&path);
}

/// A file that loads can be looked at, scored and written with lights, and what is written loads again.
fn judged(path: &Path) -> klieg::Result<()> {
    let _ = Contents::read(path);
    let scene = load_with(path, LoadOptions::default())?;
    if scene.instances.len() > SMALL.0 || scene.polygons() > SMALL.1 {
        return Ok(());
    }
    let view = View::new(&scene, frame(&scene, &Framing::default(), 1.0)?, 16, 16)?;
    let rig = Preset::LightKit.rig();
    let score = scored(&scene, &view, &rig)?;
    assert!(score.is_finite(), "F is {score}");
    let out = path.with_file_name("lit.glb");
    lit::write(path, LoadOptions::default(), &view, &rig, &out)?;
    load_with(&out, LoadOptions::default()).expect("what klieg wrote loads");
    Ok(())
}

fn scored(scene: &Scene, view: &View, rig: &[klieg::lighting::Light]) -> klieg::Result<f32> {
    let (objective, shading) = (Objective::default(), Shading::default());
    let shadows = ShadowSettings { on: true, side: 9, ..ShadowSettings::default() };
    let maps = cpu::draw(scene, view, &objective, (&shadows, None))?;
    Ok(CpuEvaluator::new(maps, view, objective, shading)?.inspect(rig)?.score)
}
