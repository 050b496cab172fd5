//! The project's scenes as the usual tools write them (`tests/corpus/`): each variant scores as its original,
//! and lights put into it leave it as valid as it was.

#[path = "load/file.rs"]
#[allow(dead_code, reason = "shared with the tests of loading")]
mod file;

use klieg::cpu::{self, CpuEvaluator};
use klieg::design::profile::PROFILES;
use klieg::evaluate::Evaluator;
use klieg::lighting::{Light, LightKind};
use klieg::scene::load::{FileAccess, load};
use klieg::scene::view::View;
use klieg::scene::{Scene, lit};
use klieg_support::gpu::{population, rigs};
use klieg_support::{npm, temporary};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Largest difference of a score where the geometry is all that is compressed, and where pictures are too.
const CLOSE: f32 = 2e-3;
const LOSSY: f32 = 5e-3;

/// The variants, and how far their scores may be from the original's. `optimized` leaves triangles out.
const VARIANTS: [(&str, f32); 13] = [
    ("quantized", CLOSE),
    ("meshopt", CLOSE),
    ("filtered", LOSSY),
    ("draco", CLOSE),
    ("sequential", CLOSE),
    ("instanced", CLOSE),
    ("webp", CLOSE),
    ("etc1s", LOSSY),
    ("uastc", LOSSY),
    ("optimized", LOSSY),
    ("optimized-draco", LOSSY),
    ("packed", LOSSY),
    ("packed-khr", LOSSY),
];

const SCENES: [&str; 2] = ["still-life", "pair"];

/// Side of the pictures that are scored.
const SIDE: u32 = 256;

fn original(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.glb"))
}

/// The folder with all variants, `SCENE-VARIANT.glb`.
static CORPUS: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = temporary().join("corpus");
    // Nothing of another run may pass for what this one makes.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let scenes = SCENES.map(original);
    let mut arguments = vec![folder.as_path()];
    arguments.extend(scenes.iter().map(PathBuf::as_path));
    npm::run("corpus", "make.mjs", &arguments);
    folder
});

fn variants() -> impl Iterator<Item = (&'static str, PathBuf, f32)> {
    SCENES.into_iter().flat_map(|scene| {
        VARIANTS.into_iter().map(move |(variant, within)| {
            (scene, CORPUS.join(format!("{scene}-{variant}.glb")), within)
        })
    })
}

fn some_rigs() -> Vec<Vec<Light>> {
    let pairs = [(1, LightKind::POINT), (2, LightKind::DIRECTIONAL), (3, LightKind::POINT)];
    pairs.into_iter().flat_map(|(lights, kind)| rigs(lights as u64, 2, lights, kind)).collect()
}

/// Scores of some rigs by every profile, as the camera of `original` sees `scene`.
fn scores(scene: &Scene, original: &Scene) -> Vec<f32> {
    let view = View::new(scene, original.cameras[0].clone(), SIDE, SIDE).expect("a view");
    let surface = cpu::visibility::draw(scene, &view);
    let of_profile = |profile: &&klieg::design::profile::Profile| {
        let (objective, shading) = ((profile.objective)(), (profile.shading)());
        let maps = cpu::maps(surface.clone(), &objective);
        let mut native = CpuEvaluator::new(maps, &view, objective, shading).expect("maps");
        let score = |rig| {
            let mut score = [0.0];
            native.evaluate(&population(&[rig]), &mut score).expect("a score");
            score[0]
        };
        some_rigs().into_iter().map(score).collect::<Vec<_>>()
    };
    PROFILES.iter().flat_map(of_profile).collect()
}

/// The largest difference of scores.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn variants_score_as_their_originals() {
    let mut failures = Vec::new();
    for name in SCENES {
        let scene = load(&original(name)).expect("a scene of the project");
        let expected = scores(&scene, &scene);
        for (_, path, within) in variants().filter(|(of, ..)| *of == name) {
            let variant = load(&path).unwrap_or_else(|error| panic!("{error}"));
            assert!(variant.warnings.is_empty(), "{}: {:?}", path.display(), variant.warnings);
            let apart = difference(&scores(&variant, &scene), &expected);
            println!("{apart:.5} of {within} {}", path.display());
            if apart.is_nan() || apart > within {
                failures.push(format!("{} is {apart} off", path.display()));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// A scene in another place scores differently, so that the comparison above means something.
#[test]
fn what_is_moved_scores_differently() {
    let scene = load(&original("still-life")).expect("a scene of the project");
    let mut moved = scene.clone();
    moved.instances[0].world.w_axis.y += 0.02;
    assert!(difference(&scores(&moved, &scene), &scores(&scene, &scene)) > LOSSY);
}

/// JSON and binary chunk of a GLB.
fn parts(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).expect("a file");
    let glb = gltf::binary::Glb::from_slice(&bytes).expect("a GLB");
    let root = serde_json::from_slice(&glb.json).expect("JSON");
    (root, glb.bin.map(|bin| bin.into_owned()).unwrap_or_default())
}

/// Codes of the errors and warnings that the validator finds, and of how many objects nothing uses.
fn issues(report: &Value) -> Vec<&str> {
    let messages = report["messages"].as_array().expect("messages");
    let serious = messages.iter().filter(|message| message["severity"].as_u64() <= Some(1));
    serious.map(|message| message["code"].as_str().expect("a code")).collect()
}

#[test]
fn lights_leave_what_is_compressed_as_it_was() {
    let sources: Vec<PathBuf> = variants().map(|(_, path, _)| path).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let mut all = sources.clone();
    for source in &sources {
        let scene = load(source).unwrap_or_else(|error| panic!("{error}"));
        let view = View::new(&scene, scene.cameras[0].clone(), 64, 64).expect("a view");
        let out = folder.path().join(source.file_name().expect("a name"));
        lit::write(source, FileAccess::SceneFolder, &view, &some_rigs()[0], &out)
            .expect("a lit file");
        let ((before, data), (after, lit_data)) = (parts(source), parts(&out));
        assert!(data == lit_data, "{}", source.display());
        for key in ["buffers", "bufferViews", "accessors", "meshes", "images", "textures"] {
            assert_eq!(before[key], after[key], "{}: {key}", source.display());
        }
        let lit_scene = load(&out).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scores(&lit_scene, &scene), scores(&scene, &scene), "{}", source.display());
        all.push(out);
    }
    let files: Vec<&Path> = all.iter().map(PathBuf::as_path).collect();
    let reports = npm::run("validator", "validate.mjs", &files);
    let reports: Vec<Value> = serde_json::from_slice(&reports).expect("JSON");
    let (before, after) = reports.split_at(sources.len());
    for (before, after) in before.iter().zip(after) {
        assert_eq!(issues(before), issues(after), "{before:#}\n{after:#}");
    }
}

/// The textured square with the first picture of a variant.
fn pictured(variant: &str) -> (file::File, std::ops::Range<usize>) {
    let (root, data) = parts(&CORPUS.join(format!("still-life-{variant}.glb")));
    let view = root["images"][1]["bufferView"].as_u64().expect("a view") as usize;
    let number = |key: &str| root["bufferViews"][view][key].as_u64().unwrap_or(0) as usize;
    let picture = &data[number("byteOffset")..][..number("byteLength")];
    let texture = json!({"baseColorTexture": {"index": 0}});
    let mut file = file::File::textured(json!({"pbrMetallicRoughness": texture}));
    let view = file.view(picture);
    file.push("images", json!({"bufferView": view}));
    file.push("textures", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    let end = file.bin.len();
    (file, end - picture.len()..end)
}

#[test]
fn broken_pictures_have_their_warning() {
    for variant in ["etc1s", "uastc"] {
        let (whole, place) = pictured(variant);
        assert_eq!(whole.scene().textures.len(), 1, "{variant}");
        for part in 0..60 {
            let mut file = whole.clone();
            let view = file.json["bufferViews"].as_array_mut().expect("views").last_mut();
            view.expect("a view")["byteLength"] = json!(place.len() * part / 60);
            let scene = file.scene();
            assert!(scene.textures.is_empty() && scene.warnings[0].contains("image 0"), "{part}");
        }
        let mut random = ChaCha8Rng::seed_from_u64(7);
        for _ in 0..200 {
            let mut file = whole.clone();
            for _ in 0..random.random_range(1..6) {
                // Headers and tables more often than pixels.
                let end = if random.random() { place.len() } else { 400 };
                file.bin[place.start + random.random_range(12..end)] = random.random();
            }
            if let Err(error) = file.load() {
                assert!(error.is_input(), "{error}");
            }
        }
    }
}

#[test]
fn the_program_designs_lights_for_what_gltf_transform_makes() {
    for variant in ["optimized", "optimized-draco"] {
        let source = CORPUS.join(format!("still-life-{variant}.glb"));
        let out = tempfile::tempdir().expect("a folder");
        let program = assert_cmd::Command::cargo_bin("klieg")
            .expect("the program")
            .arg("design")
            .arg(source)
            .args(["--size", "64x64", "--device", "cpu", "--generations", "2", "--population", "6"])
            .arg("--out")
            .arg(out.path())
            .assert()
            .success();
        let said = String::from_utf8_lossy(&program.get_output().stderr).into_owned();
        assert!(!said.contains("warning"), "{said}");
        load(&out.path().join("lit.glb")).expect("a lit scene");
    }
}
