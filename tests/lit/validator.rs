//! Lit scenes pass the Khronos glTF validator, which runs on Node.js (`tests/validator/`).

use super::fixtures::{glb, positions, rig, triangle, views, write, write_all};
use super::own::with_sun;
use klieg::scene::lit;
use klieg::scene::load::FileAccess::SceneFolder;
use klieg_support::npm;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The validator's reports on some files.
pub fn validate(files: &[PathBuf]) -> Vec<Value> {
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    serde_json::from_slice(&npm::run("validator", "validate.mjs", &files)).expect("JSON")
}

/// Codes of a report's issues up to a severity: 0 errors, 1 warnings, 2 and 3 hints.
pub fn codes(report: &Value, severity: u64) -> Vec<&str> {
    let messages = report["messages"].as_array().expect("messages");
    let mut codes: Vec<_> = messages
        .iter()
        .filter(|message| message["severity"].as_u64().is_some_and(|level| level <= severity))
        .map(|message| message["code"].as_str().expect("a code"))
        .collect();
    codes.sort_unstable();
    codes
}

#[test]
fn lit_scenes_are_as_valid_as_the_originals() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = write_all(folder.path());
    let scenes = std::fs::read_dir(klieg_support::root().join("scenes"));
    for entry in scenes.into_iter().flatten() {
        let path = entry.expect("a scene").path();
        sources.extend(path.extension().is_some_and(|kind| kind == "glb").then_some(path));
    }
    let mut lit = Vec::new();
    for (index, source) in sources.iter().enumerate() {
        for (number, view) in views().iter().enumerate() {
            let [out, again] = ["out", "again"]
                .map(|name| folder.path().join(format!("{name}-{index}-{number}.glb")));
            let rig = if number == 0 { with_sun() } else { rig() };
            lit::write(source, SceneFolder, view, &rig, &out).expect("a lit scene");
            // Once more, to see what the removal of the first lights leaves.
            lit::write(&out, SceneFolder, view, &rig[..2], &again).expect("a lit scene");
            lit.extend([out, again]);
        }
    }
    let (before, after) = (validate(&sources), validate(&lit));
    for (index, report) in after.iter().enumerate() {
        let original = &before[index / (2 * views().len())];
        let mut found = codes(report, 1);
        // A GLB has one binary chunk: buffers beyond the first can only be data URIs in it.
        found.retain(|&code| code != "DATA_URI_GLB");
        assert_eq!(found, codes(original, 1), "{original:#}\n{report:#}");
        let unused = |report| codes(report, 3).iter().filter(|&&c| c == "UNUSED_OBJECT").count();
        assert!(unused(report) <= unused(original), "{report:#}");
    }
}

#[test]
fn the_validator_finds_faults() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut root = triangle();
    root["nodes"][0]["rotation"] = serde_json::json!([0.0, 0.0, 0.0, 0.5]);
    let path = write(folder.path(), "bad.glb", &glb(&root, Some(&positions())));
    assert_eq!(codes(&validate(&[path])[0], 0), ["ROTATION_NON_UNIT"]);
}
