//! The C library as its users get it: installed, found by pkg-config and CMake, linked, and run.

#![cfg(target_os = "linux")]

use glam::{DMat4, DVec3, Vec3};
use klieg::cpu::CpuEvaluator;
use klieg::design::Designer;
use klieg::design::profile::{DEFAULT, NATURAL, PROFILES};
use klieg::design::start::first_of_surface;
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, ContextOptions, GpuEvaluator};
use klieg::lighting::genome::Genome;
use klieg::lighting::presets::Preset;
use klieg::lighting::{Color, Cone, Light, LightKind, Population, Role};
use klieg::objective::shadows::ShadowSettings;
use klieg::objective::terms::TERMS;
use klieg::objective::{Objective, Term};
use klieg::optimize::{GeneticSettings, Settings};
use klieg::scene::build::{MeshData, SceneBuilder, TextureData};
use klieg::scene::framing::{self, Framing};
use klieg::scene::load;
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Material, Scene, TextureRef, Wrap};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, OnceLock};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PREFIX: &str = "/opt/klieg";
const SEED: u64 = 7;
const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"];

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("c").join(name)
}

/// What the command prints; it must succeed.
fn run(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.output().expect("a command that starts");
    let (stdout, stderr) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{command:?}: {status}\n{stdout}\n{stderr}");
    stdout.into_owned()
}

/// The folder that the library is installed below.
fn installed() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = temporary("root");
        let _ = std::fs::remove_dir_all(&place);
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a target folder");
        run(Command::new("make")
            .args(["install-library", "PROFILE=dev", &format!("PREFIX={PREFIX}")])
            .arg(format!("DESTDIR={}", place.display()))
            .env("CARGO_TARGET_DIR", target)
            .current_dir(ROOT));
        place
    })
}

fn library_folder() -> PathBuf {
    installed().join(PREFIX.trim_start_matches('/')).join("lib")
}

/// Flags that pkg-config gives for a library that is not where it will be.
fn flags() -> Vec<String> {
    let found = run(Command::new("pkg-config")
        .args(["--cflags", "--libs", "klieg"])
        .env("PKG_CONFIG_PATH", library_folder().join("pkgconfig"))
        .env("PKG_CONFIG_SYSROOT_DIR", installed()));
    found.split_whitespace().map(String::from).collect()
}

/// Builds a program of tests/c against the installed library.
fn build(source: &str, name: &str, arguments: &[&str]) -> PathBuf {
    let program = temporary(name);
    run(Command::new("cc")
        .args(["-std=c11", "-O1", "-g"])
        .args(STRICT)
        .args(arguments)
        .arg(Path::new(ROOT).join("tests/c").join(source))
        .args(flags())
        .args(["-lvulkan", "-o"])
        .arg(&program));
    program
}

fn start(program: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).env("LD_LIBRARY_PATH", library_folder());
    command
}

#[test]
fn the_header_suits_c_and_cpp() {
    let include = installed().join(PREFIX.trim_start_matches('/')).join("include");
    for (compiler, arguments) in [("cc", ["-std=c11", "-xc"]), ("c++", ["-std=c++17", "-xc++"])] {
        run(Command::new(compiler)
            .args(arguments)
            .args(STRICT)
            .args(["-fsyntax-only", "-include", "klieg.h", "/dev/null", "-I"])
            .arg(&include));
    }
}

#[test]
fn the_library_exports_what_the_header_declares_and_no_more() {
    let library = library_folder().join("libklieg.so");
    let listed = run(Command::new("nm").args(["-D", "--defined-only"]).arg(&library));
    let exported: BTreeSet<&str> =
        listed.lines().filter_map(|line| line.split_whitespace().last()).collect();
    let header = std::fs::read_to_string(Path::new(ROOT).join("include/klieg.h")).unwrap();
    let declared: BTreeSet<&str> = header
        .lines()
        .filter(|line| !line.starts_with("//") && !line.starts_with([' ', '#', '}']))
        .filter_map(|line| line.split_once('(')?.0.split([' ', '*']).next_back())
        .collect();
    assert!(declared.len() > 50 && declared.iter().all(|name| name.starts_with("klieg_")));
    assert_eq!(exported, declared);
    let dynamic = run(Command::new("readelf").arg("-d").arg(&library));
    let soname = dynamic.lines().find(|line| line.contains("SONAME")).expect("a soname");
    assert!(soname.contains("[libklieg.so.0.2]"), "{soname}");
}

fn tetrahedra() -> Scene {
    let mut builder = SceneBuilder::default();
    let (light, dark) = ([255; 4], [64, 64, 64, 255]);
    let texture = TextureData {
        name: "chequers",
        width: 2,
        height: 2,
        texels: &[light, dark, dark, light],
        srgb: true,
        wrap: [Wrap::Repeat, Wrap::Clamp],
    };
    let texture = builder.add_texture(&texture).unwrap();
    let red = Material {
        base_color: [1.0, 0.25, 0.25, 1.0],
        metallic: 0.0,
        roughness: 0.5,
        base_color_texture: Some(TextureRef::new(texture)),
        ..Material::default()
    };
    let material = Some(builder.add_material(red).unwrap());
    let mesh = MeshData {
        positions: &[[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]],
        uvs: [Some(&[[0., 0.], [1., 0.], [0., 1.], [1., 1.]]), None],
        indices: Some(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]),
        material,
        ..MeshData::default()
    };
    let mesh = builder.add_mesh(&mesh).unwrap();
    let there = DMat4::from_translation(DVec3::new(1.5, 0.5, 0.0));
    let small = there * DMat4::from_scale(DVec3::splat(0.5));
    builder.add_instance("large", mesh, DMat4::IDENTITY).unwrap();
    builder.add_instance("small", mesh, small).unwrap();
    builder.finish("two tetrahedra").unwrap()
}

fn line(name: &str, values: &[f32]) -> String {
    let bits = values.iter().map(|value| format!(" {:08x}", value.to_bits()));
    name.to_owned() + &bits.collect::<String>()
}

fn light_lines(name: &str, rig: &[Light]) -> Vec<String> {
    let numbers = |l: &Light| [l.elevation, l.azimuth, l.distance, l.diffuse, l.specular];
    rig.iter().map(|light| line(name, &numbers(light))).collect()
}

fn quality_lines(name: &str, evaluator: &mut GpuEvaluator, preset: Preset) -> [String; 2] {
    let population = Population::of([&preset.rig()[..]]).unwrap();
    let quality = evaluator.qualities(&population).unwrap()[0];
    let names: Vec<_> = quality.terms.names().collect();
    let values: Vec<_> = [quality.score].into_iter().chain(quality.terms.values()).collect();
    [format!("{name} of {}", names.join(" ")), line(name, &values)]
}

fn term_line(term: &Term) -> String {
    let Term { name, title, meaning, needs, .. } = term;
    let needs: Vec<_> = needs.names().collect();
    format!("term {name}, {title}: {meaning}; {}", needs.join(" "))
}

/// What a design prints that starts from the profile `natural`.
fn by_profile(context: &Arc<Context>, scene: &Scene, view: &View) -> Vec<String> {
    let listed = PROFILES.iter().map(|p| format!("profile {}: {}", p.name, p.meaning));
    let mut lines: Vec<String> = listed.collect();
    let objective = Objective { background: Some(0.5), ..(NATURAL.objective)() };
    let both = (objective, (NATURAL.shading)());
    let shadows = ShadowSettings { on: true, side: 15, ..ShadowSettings::default() };
    let mut evaluator = GpuEvaluator::with_shadows(context, scene, view, both, &shadows).unwrap();
    let mut unshadowed = GpuEvaluator::new(context, scene, view, both.0, both.1).unwrap();
    let without = quality_lines("natural", &mut unshadowed, Preset::ThreePoint);
    assert_ne!(without, quality_lines("natural", &mut evaluator, Preset::ThreePoint));
    lines.extend(quality_lines("natural", &mut evaluator, Preset::ThreePoint));
    let genome = Genome::new(&[Role::Key, Role::Fill], NATURAL.kind, &(NATURAL.boxes)()).unwrap();
    let search = NATURAL.optimizer.name;
    let mut designer = Designer::new(genome, search, &NATURAL.endless(), None, 0).unwrap();
    designer.advance(&mut evaluator, 2).unwrap();
    lines.extend(light_lines("natural", &designer.best().unwrap().0));
    lines
}

/// Judges by an objective; all else is the default profile's.
fn with_defaults(
    context: &Arc<Context>,
    scene: &Scene,
    view: &View,
    objective: Objective,
) -> GpuEvaluator {
    let shadows = ShadowSettings { on: DEFAULT.shadows, ..ShadowSettings::default() };
    let both = (objective, (DEFAULT.shading)());
    GpuEvaluator::with_shadows(context, scene, view, both, &shadows).unwrap()
}

/// What `embed.c`, whose seed is [`SEED`], prints, by the Rust interface.
fn expected(seed: u64) -> Vec<String> {
    let scene = tetrahedra();
    let (eye, lens) = (DVec3::new(3.0, 2.5, 5.0), Projection::Perspective { yfov: 0.7 });
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, lens).unwrap();
    let view = View::new(&scene, camera, 96, 64).unwrap();
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mut evaluator = with_defaults(&context, &scene, &view, (DEFAULT.objective)());
    let presets: Vec<_> = Preset::ALL
        .into_iter()
        .flat_map(|preset| quality_lines("preset", &mut evaluator, preset))
        .collect();
    let light = Light {
        elevation: 0.5,
        azimuth: 0.25,
        distance: 2.0,
        diffuse: 1.5,
        specular: 0.5,
        ..Light::default()
    };
    let frame = &view.frame;
    let place = light.to_world(frame).truncate();
    let direction = (frame.center - place).normalize();
    let (intensity, distance) = (light.intensity(frame), 2.0 * frame.radius);
    let numbers = [place.x, place.y, place.z, direction.x, intensity, distance];
    let mut lines: Vec<String> = TERMS.iter().map(|term| term_line(term)).collect();
    let mut other = Objective::default();
    for (name, weight) in [("edge", 0.0), ("mean", 0.5), ("range", 0.25)] {
        other.weights.set(Term::named(name).unwrap(), weight).unwrap();
    }
    let mut judge = with_defaults(&context, &scene, &view, other);
    lines.extend(quality_lines("judged", &mut judge, Preset::Headlight));
    lines.extend(by_profile(&context, &scene, &view));
    lines.extend(presets.clone());
    lines.push(line("world", &numbers.map(|number| number as f32)));
    let spot = Light {
        kind: LightKind::SPOT,
        color: Color::of_linear([1.0, 0.5, 0.25]).unwrap(),
        size: 0.125,
        cone: Cone { inner: 0.25, outer: 0.5 },
        aim: Some(Vec3::new(0.0, -0.6, -0.8).normalize()),
        ..light
    };
    let axis = frame.direction_to_world(spot.axis().as_dvec3()).as_vec3().to_array();
    let size = (0.125 * frame.radius) as f32;
    let numbers = [&axis[..], &spot.color.linear(), &[0.25, 0.5, size]].concat();
    lines.push(line("spot", &numbers));
    let scores = [light, spot].map(|light| {
        let population = Population::of([&[light][..]]).unwrap();
        evaluator.qualities(&population).unwrap()[0].score
    });
    lines.push(line("scores", &scores));

    let genome = Genome::new(&[Role::Key, Role::Rim], DEFAULT.kind, &(DEFAULT.boxes)()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = first_of_surface(evaluator.maps().unwrap(), &genome, &mut rng);
    lines.extend(light_lines("first", &genome.decode(&first)));
    let genetic = GeneticSettings { population: 12, ..GeneticSettings::endless() };
    let settings = Settings { genetic, ..DEFAULT.endless() };
    let search = DEFAULT.optimizer.name;
    let mut designer = Designer::new(genome, search, &settings, Some(first), seed).unwrap();
    let progress = designer.advance(&mut evaluator, 4).unwrap();
    lines.push(line("progress", &[progress.best, progress.mean, progress.worst]));
    let (rig, score) = designer.best().unwrap();
    lines.push(line("best", &[score]));
    lines.extend(light_lines("best", &rig));
    lines.extend(presets);
    lines
}

#[test]
fn c_programs_get_the_bits_that_rust_gets() {
    let printed = run(&mut start(&build("embed.c", "embed", &[]), &[]));
    let printed: Vec<_> = printed.lines().collect();
    assert_eq!(printed, expected(SEED));
    assert_ne!(printed, expected(SEED + 1));
}

#[test]
fn cmake_finds_both_libraries() {
    let folder = temporary("cmake");
    let _ = std::fs::remove_dir_all(&folder);
    let found = format!("-DCMAKE_PREFIX_PATH={}{PREFIX}", installed().display());
    run(Command::new("cmake")
        .args(["-S"])
        .arg(Path::new(ROOT).join("tests/c"))
        .arg("-B")
        .arg(&folder)
        .arg(&found));
    run(Command::new("cmake").arg("--build").arg(&folder));
    for program in ["shared", "static"] {
        let mut command = Command::new(folder.join(program));
        assert_eq!(run(&mut command).lines().collect::<Vec<_>>(), expected(SEED), "{program}");
    }
    let too_new = Command::new("cmake")
        .args(["-DVERSION=0.3", "-S"])
        .arg(Path::new(ROOT).join("tests/c"))
        .arg("-B")
        .arg(temporary("cmake-too-new"))
        .arg(&found)
        .output()
        .unwrap();
    assert!(!too_new.status.success());
}

#[test]
fn nothing_leaks_and_nothing_is_overrun() {
    let suppressions = Path::new(ROOT).join("tests/c/leaks-of-mesa.txt");
    let options = format!("suppressions={}:print_suppressions=0", suppressions.display());
    for source in ["embed", "borrow"] {
        let name = format!("{source}-checked");
        let program = build(&format!("{source}.c"), &name, &["-fsanitize=address,undefined"]);
        run(start(&program, &[]).env("LSAN_OPTIONS", &options));
        let leaking = start(&program, &["leak"]).env("LSAN_OPTIONS", &options).output().unwrap();
        let said = String::from_utf8_lossy(&leaking.stderr);
        assert!(!leaking.status.success() && said.contains("klieg_"), "{said}");
    }
}

/// The numbers of a line of the program's report.
fn numbers(report: &str, name: &str) -> [i64; 2] {
    let line = report.lines().find_map(|line| line.strip_prefix(name)).expect("a line");
    let numbers: Vec<i64> = line.split_whitespace().map(|n| n.parse().unwrap()).collect();
    numbers.try_into().expect("two numbers")
}

/// Kilobytes that the heap may grow by its own ways of keeping memory.
const SLACK: i64 = 1024;

#[test]
fn a_thousand_lives_leave_no_memory_behind() {
    let program = build("embed.c", "cycles", &[]);
    let report = run(&mut start(&program, &["cycles", "1000"]));
    let [before, after] = numbers(&report, "resident");
    assert!(after - before < SLACK, "{report}");
    for same in ["memory", "pipelines"] {
        let [before, after] = numbers(&report, same);
        assert_eq!(before, after, "{report}");
    }
    let report = run(&mut start(&program, &["contexts", "1000"]));
    let [before, after] = numbers(&report, "resident");
    assert!(after - before < SLACK, "{report}");
    let [before, after] =
        numbers(&run(&mut start(&program, &["cycles", "1000", "leak"])), "resident");
    assert!(after - before > SLACK, "a leak is not seen: {before} to {after} kB");
}

#[test]
fn an_engine_in_c_lends_its_device() {
    let program = build("borrow.c", "borrow", &[]);
    let report = run(&mut start(&program, &["validate"]));
    assert!(!report.contains("complaint"), "{report}");
    // What the layer says when a barrier is missing and when klieg leaves its objects behind: it does look.
    for (fault, rule) in [
        ("hazard", "complaint SYNC-HAZARD-WRITE-AFTER-WRITE"),
        ("forget", "complaint VUID-vkDestroyDevice-device-"),
    ] {
        let report = run(&mut start(&program, &["validate", fault]));
        assert!(report.contains(rule), "{report}");
    }
}

/// klieg's scene of two objects.
fn pair() -> PathBuf {
    Path::new(ROOT).join("scenes/pair.glb")
}

/// A driver that is not there, for the Vulkan loader to find nothing else.
const NO_DRIVER: [(&str, &str); 2] =
    [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];

/// What `cpu.c` prints, by the Rust interface.
fn expected_on_the_cpu() -> Vec<String> {
    let scene = load::load(&pair()).unwrap();
    let camera = framing::frame(&scene, &Framing::default(), 1.5).unwrap();
    let view = View::new(&scene, camera, 96, 64).unwrap();
    let (objective, shading) = ((DEFAULT.objective)(), (DEFAULT.shading)());
    let shadows = ShadowSettings { on: DEFAULT.shadows, ..ShadowSettings::default() };
    let maps = klieg::cpu::draw(&scene, &view, &objective, (&shadows, None)).unwrap();
    let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading).unwrap();
    let genome = DEFAULT.genome().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let first = first_of_surface(evaluator.maps().unwrap(), &genome, &mut rng);
    let search = DEFAULT.optimizer.name;
    let mut designer =
        Designer::new(genome, search, &DEFAULT.endless(), Some(first), SEED).unwrap();
    designer.advance(&mut evaluator, 4).unwrap();
    let (rig, score) = designer.best().unwrap();
    [vec![line("score", &[score])], light_lines("light", &rig)].concat()
}

#[test]
fn without_vulkan_c_programs_design_on_the_cpu_and_write_the_lit_scene() {
    let folder = temporary("lit");
    std::fs::create_dir_all(&folder).unwrap();
    let program = build("cpu.c", "cpu", &["-fsanitize=address,undefined"]);
    let arguments = [pair(), folder.clone()];
    let printed = run(start(&program, &[]).args(&arguments).envs(NO_DRIVER));
    assert_eq!(printed.lines().collect::<Vec<_>>(), expected_on_the_cpu());
    assert_eq!(load::load(&folder.join("lit.glb")).unwrap().lights.len(), 2);
}

#[test]
fn the_program_of_the_page_lights_a_file_with_and_without_vulkan() {
    let program = build("light.c", "light", &[]);
    for (name, environment) in [("vulkan.glb", &NO_DRIVER[..0]), ("cpu.glb", &NO_DRIVER)] {
        let lit = temporary(name);
        let _ = std::fs::remove_file(&lit);
        let command = &mut start(&program, &[]);
        let told = run(command.arg(pair()).arg(&lit).envs(environment.iter().copied()));
        assert_eq!(told.matches("a light of ").count(), 2, "{told}");
        assert_eq!(load::load(&lit).unwrap().lights.len(), 2);
    }
    let absent = start(&program, &["absent.glb", "lit.glb"]).output().unwrap();
    let said = String::from_utf8_lossy(&absent.stderr);
    assert!(absent.status.code() == Some(1) && said.contains("absent.glb"), "{said}");
}

#[test]
fn an_engine_does_as_the_page_says() {
    run(&mut start(&build("page.c", "page", &[]), &[]));
}
