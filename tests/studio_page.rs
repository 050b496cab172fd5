//! The page of `klieg studio`: what its source builds, and how it does in a real browser.

use klieg_support::{browser, npm, root};
use std::path::Path;
use std::process::Command;

/// Names and contents of a folder's files.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = klieg_support::common::list(folder);
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).unwrap();
        (name, bytes)
    };
    names.into_iter().map(read).collect()
}

#[test]
fn what_is_checked_in_is_what_the_source_builds() {
    let folder = npm::studio();
    npm::output(Command::new("npm").args(["run", "--silent", "check"]).current_dir(&folder));
    let built = tempfile::tempdir().unwrap();
    let mut build = Command::new("npm");
    build.args(["run", "--silent", "build", "--"]).arg(built.path()).current_dir(&folder);
    npm::output(&mut build);
    let (fresh, kept) = (files(built.path()), files(&root().join("studio/dist")));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&fresh), names(&kept));
    for ((name, fresh), (_, kept)) in fresh.iter().zip(&kept) {
        assert!(fresh == kept, "studio/dist/{name} is old: cd studio && npm ci && npm run build");
    }
}

#[test]
fn nothing_in_the_page_needs_the_network_or_what_the_policy_forbids() {
    for (name, bytes) in files(&root().join("studio/dist")) {
        let text = String::from_utf8(bytes).unwrap();
        let harmless = ["http://www.w3.org/", "http://127.0.0.1"];
        for (at, _) in text.match_indices("http") {
            let rest = &text[at..];
            let address = rest.starts_with("http://") || rest.starts_with("https://");
            let known = harmless.iter().any(|start| rest.starts_with(start));
            assert!(!address || known, "{name}: {}", &rest[..rest.len().min(60)]);
        }
        for forbidden in ["eval(", "new Function", "style=\"", "onclick=\""] {
            assert!(!text.contains(forbidden), "{name} has {forbidden}");
        }
    }
}

#[test]
fn people_light_a_model_in_the_browser() {
    let folder = npm::studio();
    let place = tempfile::tempdir().unwrap();
    let mut run = Command::new("node");
    run.arg(folder.join("tests").join("all.mjs"))
        .arg(browser::chromium())
        .arg(env!("CARGO_BIN_EXE_klieg"))
        .arg(root().join("scenes/elephant.glb"))
        .arg(place.path())
        .env("XDG_CACHE_HOME", klieg_support::temporary());
    let output = run.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}");
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}{complaint}");
    assert!(said.contains("median"), "latency is measured: {said}");
}
