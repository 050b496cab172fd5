//! The engine of `examples/engine_cpp`, built against the installed library as its users do and run
//! under the validation layer and under sanitizers.

#![cfg(target_os = "linux")]

use image::RgbaImage;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
// A static runtime does not mind a library that is loaded before it.
const SANITIZED: &str =
    "-fsanitize=address,leak,undefined -fno-sanitize-recover=all -static-libasan";

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("engine_cpp").join(name)
}

/// What the command prints, its complaints last, and whether it succeeds.
fn outcome(command: &mut Command) -> (bool, String) {
    let Output { status, stdout, stderr } = command.output().expect("a command that starts");
    let text = String::from_utf8_lossy(&stdout) + String::from_utf8_lossy(&stderr);
    (status.success(), text.into_owned())
}

fn run(command: &mut Command) -> String {
    let (success, said) = outcome(command);
    assert!(success, "{command:?}\n{said}");
    said
}

/// The folder that the library is installed in.
fn prefix() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = temporary("prefix");
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a target folder");
        run(Command::new("make")
            .args(["install-library", "PROFILE=dev", &format!("PREFIX={}", place.display())])
            .env("CARGO_TARGET_DIR", target)
            .current_dir(ROOT));
        place
    })
}

/// Builds the sources in `from` into a folder of this name.
fn build(from: &Path, name: &str, flags: &str) -> PathBuf {
    let folder = temporary(name);
    run(Command::new("cmake")
        .arg("-S")
        .arg(from)
        .arg("-B")
        .arg(&folder)
        .arg(format!("-DCMAKE_PREFIX_PATH={}", prefix().display()))
        .arg(format!("-DCMAKE_CXX_FLAGS={flags} -Werror")));
    run(Command::new("cmake").args(["--build"]).arg(&folder).args(["--parallel", "2"]));
    folder
}

/// The engine with small pictures, which it saves in its folder.
fn engine(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(folder.join("engine"));
    command.args(["--size", "128x96", "--out"]).arg(folder).args(arguments);
    command
}

/// The engine as it is.
fn plain() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| build(&example(), "plain", "-O1"))
}

fn example() -> PathBuf {
    Path::new(ROOT).join("examples/engine_cpp")
}

/// Mean difference of two pictures' channels, of 255.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let all = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    all.sum::<f64>() / a.as_raw().len() as f64
}

#[test]
fn the_engine_finds_better_lights_at_both_levels() {
    let folder = plain();
    let report = run(&mut engine(folder, &["--validate", "--generations", "6"]));
    assert!(report.contains("levels 1 and 2 agree"), "{report}");
    let [before, surface, pictures] = ["headlight", "surface", "pictures"]
        .map(|name| image::open(folder.join(format!("{name}.png"))).unwrap().into_rgba8());
    let brightest = before.pixels().map(|pixel| pixel.0[..3].iter().copied().max().unwrap_or(0));
    assert!(brightest.max() > Some(100), "the picture is dark");
    for after in [&surface, &pictures] {
        assert!(difference(&before, after) > 5.0, "other lights make another picture");
    }
    assert!(difference(&surface, &pictures) > 0.5, "so do the engine's own shadows");
}

#[test]
fn device_and_klieg_go_in_either_order() {
    for order in ["klieg-first", "device-first"] {
        let arguments = ["--validate", "--generations", "1", "--cycles", "2", "--order", order];
        run(&mut engine(plain(), &arguments));
    }
}

/// A library that keeps all others loaded to the end, so that the leaks of a driver bear its name.
fn holder() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| {
        let (source, library) = (temporary("holder.c"), temporary("libholder.so"));
        std::fs::create_dir_all(temporary("")).unwrap();
        std::fs::write(&source, "int dlclose(void *library) { return library == 0; }\n").unwrap();
        run(Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&library, &source]));
        library
    })
}

/// The engine under sanitizers; leaks of the driver's own do not count.
fn watched(folder: &Path, arguments: &[&str], options: &str) -> Command {
    let mut command = engine(folder, arguments);
    let suppressions = Path::new(ROOT).join("tests/c/leaks-of-mesa.txt");
    command
        .env("LD_PRELOAD", holder())
        .env("ASAN_OPTIONS", options)
        .env("LSAN_OPTIONS", format!("suppressions={}", suppressions.display()));
    command
}

#[test]
fn nothing_leaks_and_nothing_is_overrun() {
    let folder = build(&example(), "sanitized", SANITIZED);
    run(&mut watched(&folder, &["--generations", "2"], ""));
    // What klieg had on a device that has gone is left there.
    let arguments = ["--generations", "1", "--order", "device-first"];
    run(&mut watched(&folder, &arguments, "detect_leaks=0"));
}

/// Copies the example with faults in it: each replaces what stands in a file once.
fn with_faults(faults: &[(&str, &str, &str)]) -> PathBuf {
    let place = temporary("faulty-source");
    let _ = std::fs::remove_dir_all(&place);
    for folder in ["", "shaders"] {
        std::fs::create_dir_all(place.join(folder)).unwrap();
        for entry in std::fs::read_dir(example().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                std::fs::copy(&path, place.join(folder).join(path.file_name().unwrap())).unwrap();
            }
        }
    }
    for (name, right, wrong) in faults {
        let path = place.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(right).count(), 1, "{name}: {right}");
        std::fs::write(&path, text.replace(right, wrong)).unwrap();
    }
    place
}

#[test]
fn faults_of_an_engine_are_noticed() {
    let faulty = with_faults(&[
        // Two components are mistaken for each other.
        ("lighting.cpp", "roughness_channel = 0", "roughness_channel = 1"),
        // klieg is told of a layout that the images are not in.
        ("lighting.cpp", "Renderer::READ_LAYOUT", "VK_IMAGE_LAYOUT_GENERAL"),
        // The copy of a picture does not wait for the change of its layout.
        ("renderer.cpp", "COPIED, SHADER_READ, COPY_READ", "COPIED, SHADER_READ, SHADER_READ"),
        // A scene is never given back.
        ("lighting.cpp", "out(scene_evaluator)));", "out(scene_evaluator)));\n    made.release();"),
    ]);
    let folder = build(&faulty, "faulty", SANITIZED);
    let arguments = ["--validate", "--generations", "1"];
    let (success, said) = outcome(&mut watched(&folder, &arguments, "detect_leaks=0"));
    assert!(!success, "{said}");
    for complaint in ["levels 1 and 2 differ", "imageLayout", "SYNC-HAZARD-READ"] {
        assert!(said.contains(complaint), "{complaint} is missing: {said}");
    }
    // Of the last scene the stack may still hold the address, not of the first.
    let arguments = ["--generations", "1", "--cycles", "2"];
    let (success, said) = outcome(&mut watched(&folder, &arguments, ""));
    assert!(!success && said.contains("klieg_scene_create"), "{said}");
}
