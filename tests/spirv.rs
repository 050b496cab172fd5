//! The checked-in SPIR-V of `src/gpu/spirv/`, which builds without a shader compiler take, against what
//! this build has compiled.
#![cfg(feature = "shaderc")]

#[path = "../src/hash.rs"]
mod hash;

use hash::{FNV_START, fnv1a};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The files of a folder by their names.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let Ok(entries) = fs::read_dir(folder) else { return Files::new() };
    let file = |path: &Path| {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        (name, fs::read(path).expect("a file"))
    };
    entries.map(|entry| file(&entry.expect("an entry").path())).collect()
}

fn stored_folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu/spirv")
}

fn built() -> Files {
    files(&Path::new(env!("OUT_DIR")).join("spirv"))
}

/// A line of the manifest, by its first word.
fn told(files: &Files, what: &str) -> String {
    let manifest = files.get("manifest").cloned().unwrap_or_default();
    let manifest = String::from_utf8(manifest).expect("UTF-8");
    let found = manifest.lines().find_map(|line| line.strip_prefix(what));
    found.map(|rest| rest.trim().to_owned()).unwrap_or_default()
}

fn modules(files: &Files) -> impl Iterator<Item = (&String, &Vec<u8>)> {
    files.iter().filter(|(name, _)| *name != "manifest")
}

/// What is wrong with the checked-in files. Compilers of other versions give other bytes, so these are
/// compared only where the compiler is known to be the same.
fn faults(stored: &Files, built: &Files) -> Vec<String> {
    let mut faults = Vec::new();
    if told(stored, "sources") != told(built, "sources") {
        faults.push("made of other sources".to_owned());
    }
    let hash = modules(stored).fold(FNV_START, |hash, (_, bytes)| fnv1a(hash, bytes));
    if told(stored, "modules") != format!("{hash:016x}") {
        faults.push("not the files of the manifest".to_owned());
    }
    if !stored.keys().eq(built.keys()) {
        faults.push("other files than there are shaders".to_owned());
    }
    let compiler = told(built, "compiler");
    if compiler != "unknown" && compiler == told(stored, "compiler") {
        let other = modules(built).filter(|(name, bytes)| stored.get(*name) != Some(bytes));
        faults.extend(other.map(|(name, _)| format!("{name} is not what {compiler} gives")));
    }
    faults
}

#[test]
fn the_checked_in_spirv_is_up_to_date() {
    let folder = stored_folder();
    let built = built();
    if std::env::var_os("KLIEG_WRITE_SPIRV").is_some() {
        let _ = fs::remove_dir_all(&folder); // may not be there
        fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in &built {
            fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let faults = faults(&files(&folder), &built);
    assert!(faults.is_empty(), "src/gpu/spirv is {faults:?}; `make spirv` makes it anew");
}

#[test]
fn what_is_compiled_is_what_the_library_has() {
    let built = built();
    assert_eq!(modules(&built).count(), klieg::gpu::shaders::ALL.len());
    for (name, words) in klieg::gpu::shaders::ALL {
        assert!(built[&format!("{name}.spv")] == bytemuck::cast_slice::<u32, u8>(words), "{name}");
    }
}

/// The faults of a good folder after a change of one of its files.
fn faults_with(name: &str, change: impl Fn(&mut Vec<u8>)) -> usize {
    let built = built();
    let mut stored = built.clone();
    change(stored.get_mut(name).expect("a file"));
    faults(&stored, &built).len()
}

fn manifest_with(what: &'static str, value: &'static str) -> impl Fn(&mut Vec<u8>) {
    move |bytes| {
        let text = String::from_utf8(bytes.clone()).expect("UTF-8");
        let line = |line: &str| match line.starts_with(what) {
            true => format!("{what} {value}\n"),
            false => format!("{line}\n"),
        };
        *bytes = text.lines().map(line).collect::<String>().into_bytes();
    }
}

#[test]
fn every_fault_is_noticed_and_another_compiler_is_none() {
    assert_eq!(faults_with("manifest", |_| ()), 0);
    assert_eq!(faults_with("manifest", manifest_with("sources", "0123456789abcdef")), 1);
    assert_eq!(faults_with("manifest", manifest_with("modules", "0123456789abcdef")), 1);
    assert_eq!(faults_with("manifest", manifest_with("compiler", "shaderc 1999.9")), 0);
    assert!(faults_with("tiles.comp.spv", |bytes| bytes[40] ^= 1) >= 1);

    let built = built();
    let mut fewer = built.clone();
    fewer.remove("tiles.comp.spv");
    assert!(faults(&fewer, &built).len() >= 2);
    assert!(faults(&Files::new(), &built).len() >= 3);
}

/// What cargo prints, without the network.
fn cargo(arguments: &[&str]) -> String {
    let mut cargo = std::process::Command::new(env!("CARGO"));
    let output = cargo
        .args(arguments)
        .arg("--offline")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn builds_without_default_features_need_no_shader_compiler() {
    let tree = |features: &[&str]| {
        cargo(&[&["tree", "--edges", "normal,build", "--prefix", "none"], features].concat())
    };
    let needs_compiler = |tree: String| tree.lines().any(|line| line.starts_with("shaderc"));
    assert!(needs_compiler(tree(&[])));
    assert!(!needs_compiler(tree(&["--no-default-features"])));
    assert!(!needs_compiler(tree(&["--no-default-features", "--features", "c,cli"])));
}

#[test]
fn the_package_has_all_that_a_build_reads() {
    let packaged = cargo(&["package", "--list", "--allow-dirty"]);
    let packaged: Vec<_> = packaged.lines().collect();
    let stored = files(&stored_folder()).into_keys();
    for file in stored.map(|name| format!("src/gpu/spirv/{name}")).chain([
        "build/main.rs".into(),
        "build/stored.rs".into(),
        "src/constants.rs".into(),
        "shaders/include/layout.glsl".into(),
    ]) {
        assert!(packaged.contains(&file.as_str()), "{file}");
    }
}
