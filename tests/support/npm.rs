//! Tools from npm. Each is a folder of `tests/` with a script and a `package.json` that pins its
//! dependencies, which are installed where they are not there yet.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// Runs a script of the folder `tests/<tool>` and gives what it prints.
pub fn run(tool: &str, script: &str, arguments: &[&Path]) -> Vec<u8> {
    let folder = installed(tool, script);
    output(Command::new("node").arg(folder.join(script)).args(arguments))
}

/// A copy of the project's folder `studio/` below the target folder, with the packages of its lock file, and no others.
pub fn studio() -> PathBuf {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let (source, folder) = (crate::root().join("studio"), crate::temporary().join("studio"));
    std::fs::create_dir_all(&folder).expect("a folder for the page's source");
    for name in ["src", "tests"] {
        let _ = std::fs::remove_dir_all(folder.join(name));
        copy_folder(&source.join(name), &folder.join(name));
    }
    for name in ["package.json", "package-lock.json", ".npmrc", "tsconfig.json", "build.mjs"] {
        std::fs::copy(source.join(name), folder.join(name)).expect("a file of the page's source");
    }
    let lock = std::fs::read(folder.join("package-lock.json")).expect("a lock file");
    let installed = folder.join("node_modules").join("installed.json");
    if std::fs::read(&installed).ok().as_ref() != Some(&lock) {
        output(Command::new("npm").arg("ci").current_dir(&folder));
        std::fs::write(installed, lock).expect("a copied lock file");
    }
    folder
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder of the page's source") {
        let entry = entry.expect("an entry of that folder");
        let copy = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &copy);
        } else {
            std::fs::copy(entry.path(), copy).expect("a copied file");
        }
    }
}

/// Runs a program and gives what it prints.
pub fn output(command: &mut Command) -> Vec<u8> {
    let output = command.output().unwrap_or_else(|error| {
        panic!("{command:?}: {error}; these tests need Node.js 18 or later and npm")
    });
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{complaint}", output.status);
    output.stdout
}

/// The folder with the tool, ready to run.
fn installed(tool: &str, script: &str) -> PathBuf {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(tool);
    let folder = crate::temporary().join(tool);
    std::fs::create_dir_all(&folder).expect("a folder for the tool");
    for name in ["package.json", script] {
        let text = std::fs::read(source.join(name)).expect("a file of the tool");
        // Another test may be reading the copy.
        if std::fs::read(folder.join(name)).ok().as_ref() != Some(&text) {
            std::fs::write(folder.join(name), text).expect("a copied file");
        }
    }
    let json = |path: PathBuf| -> Value {
        let text = std::fs::read(path).unwrap_or_else(|_| b"null".into());
        serde_json::from_slice(&text).expect("JSON")
    };
    let pinned = &json(folder.join("package.json"))["dependencies"];
    let pinned = pinned.as_object().expect("dependencies");
    let is_there = |(name, version): (&String, &Value)| {
        json(folder.join("node_modules").join(name).join("package.json"))["version"] == *version
    };
    if !pinned.iter().all(is_there) {
        let flags = ["install", "--no-package-lock", "--no-audit", "--no-fund"];
        output(Command::new("npm").args(flags).current_dir(&folder));
    }
    folder
}
