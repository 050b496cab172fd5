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

/// Runs a program and gives what it prints.
fn output(command: &mut Command) -> Vec<u8> {
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
