//! The files that comments and documents name are there.

use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Where names are looked for.
const READ: [&str; 12] = [
    ".ci",
    "CHANGELOG.md",
    "Cargo.toml",
    "Makefile",
    "README.md",
    "benches",
    "build.rs",
    "docs",
    "examples",
    "shaders",
    "src",
    "tests",
];
/// The folders whose files are named from the root.
const NAMED: [&str; 8] =
    ["benches/", "docs/", "examples/", "include/", "scenes/", "shaders/", "src/", "tests/"];
/// Named, but made by a run and not stored.
const MADE: [&str; 1] = ["tests/failed"];

/// The paths that a text names from the root: those that begin with one of the root's folders and
/// hold no placeholders. Of a pattern such as `src/*/mod.rs` the part before it counts.
fn named(text: &str) -> Vec<&str> {
    let part = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let mut found = Vec::new();
    for (at, _) in NAMED.iter().flat_map(|folder| text.match_indices(folder)) {
        let longer = text[..at].chars().next_back().is_some_and(|c| part(c) || "}$~".contains(c));
        if longer {
            continue;
        }
        let rest = &text[at..];
        let end = rest.find(|c| !part(c)).unwrap_or(rest.len());
        let path = match rest[end..].starts_with(['{', '*', '<', '$']) {
            true => &rest[..rest[..end].rfind('/').map_or(end, |slash| slash)],
            false => rest[..end].trim_end_matches(['.', '/', '-']),
        };
        found.push(path);
    }
    found
}

/// Every text file at `path` and below.
fn texts(path: &Path, found: &mut Vec<(PathBuf, String)>) {
    if path.is_dir() && !path.ends_with("node_modules") && !path.ends_with("target") {
        for entry in std::fs::read_dir(path).expect("a folder of the project") {
            texts(&entry.expect("an entry").path(), found);
        }
    } else if let Ok(text) = std::fs::read_to_string(path) {
        found.push((path.to_owned(), text));
    }
}

/// What a file names that is neither below the root nor, as in an example of several files, below
/// the file's own folder.
fn missing<'a>(file: &Path, text: &'a str) -> Vec<&'a str> {
    let beside = file.parent().expect("a folder");
    let there = |path: &&str| {
        let placeholder = path.contains("/NAME.");
        placeholder
            || MADE.contains(path)
            || [Path::new(ROOT), beside].iter().any(|from| from.join(path).exists())
    };
    named(text).into_iter().filter(|path| !there(path)).collect()
}

#[test]
fn every_file_that_is_named_exists() {
    let mut files = Vec::new();
    for start in READ {
        texts(&Path::new(ROOT).join(start), &mut files);
    }
    let own = Path::new(ROOT).join(file!());
    let (mut count, mut faults) = (0, Vec::new());
    for (file, text) in files.iter().filter(|(file, _)| *file != own) {
        count += named(text).len();
        let missing = missing(file, text);
        faults.extend(missing.iter().map(|path| format!("{}: {path}", file.display())));
    }
    assert!(count > 100, "only {count} names were found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_name_of_nothing_is_noticed() {
    let file = Path::new(ROOT).join("docs/METHOD.md");
    let text =
        "Reference: src/cpu/gone.rs. See (`shaders/tiles.comp`), src/gpu/, scenes/{name}.glb,
        target/src/gone.rs and ../src/gone.rs; tests/gone/";
    assert_eq!(
        named(text),
        ["scenes", "shaders/tiles.comp", "src/cpu/gone.rs", "src/gpu", "tests/gone"]
    );
    assert_eq!(missing(&file, text), ["src/cpu/gone.rs", "tests/gone"]);
}
