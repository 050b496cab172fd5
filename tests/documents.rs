//! What the pages show is what the tests compile and run.
//!
//! Rust, C and CMake stand, line for line, in programs that the tests build and run: `tests/embedding.rs`,
//! `tests/c/`, `tests/extend_optimizer.rs`, `tests/documents/`. Commands are run here, one page after the other, in a
//! folder that has the files that they name. `cli::config` reads the blocks of `docs/CONFIGURATION.md`.

use clap::{CommandFactory, Parser};
use common::{Folder, ball};
use klieg::cli::Cli;
use klieg::lighting::Role;
// The pages' term says `crate::objective`, where it will stand.
use klieg::objective;
use klieg_support::common;
use pulldown_cmark::{CodeBlockKind, Event, Parser as Markdown, Tag, TagEnd};
use serde_json::json;
use std::path::Path;
use std::process::Command;

#[path = "documents/outside.rs"]
mod outside;
#[path = "documents/term.rs"]
mod term;

const PAGES: [&str; 9] = [
    "README.md",
    "CONTRIBUTING.md",
    "docs/CONFIGURATION.md",
    "docs/EMBEDDING.md",
    "docs/EXTENDING.md",
    "docs/FILES.md",
    "docs/LIMITS.md",
    "docs/PORTABILITY.md",
    "docs/RESULT.md",
];

/// Programs that other tests build and run.
const PROGRAMS: [&str; 7] = [
    "tests/embedding.rs",
    "tests/extend_optimizer.rs",
    "tests/documents/outside.rs",
    "tests/documents/term.rs",
    "tests/c/light.c",
    "tests/c/page.c",
    "tests/c/CMakeLists.txt",
];

fn read(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A block of code, and what its fence says.
struct Block {
    language: String,
    text: String,
}

/// The blocks of code of a page; the language of what has no fence is `indented`.
fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open = false;
    for event in Markdown::new(text) {
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                let language = match kind {
                    CodeBlockKind::Fenced(language) => language.into_string(),
                    CodeBlockKind::Indented => "indented".into(),
                };
                blocks.push(Block { language, text: String::new() });
                open = true;
            }
            Event::End(TagEnd::CodeBlock) => open = false,
            Event::Text(text) if open => blocks.last_mut().expect("a block").text.push_str(&text),
            _ => {}
        }
    }
    blocks
}

/// Lines without indentation, and without those that are empty.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// Whether `program` has all lines of `text`, one after the other.
fn has(program: &str, text: &str) -> bool {
    let (program, text) = (lines(program), lines(text));
    !text.is_empty() && program.windows(text.len()).any(|window| window == text)
}

#[test]
fn a_program_has_a_text_whatever_its_indentation() {
    let program = "fn main() {\n    one();\n\n    if two() {\n        three();\n    }\n}\n";
    assert!(has(program, "one();\nif two() {\n    three();\n}\n"));
    assert!(!has(program, "one();\nthree();\n") && !has(program, ""));
    let page =
        "text\n\n```c\nint a;\n```\n\n1. item\n\n   ```rust\n   b();\n   ```\n\n    indented\n";
    let found: Vec<_> = blocks(page).into_iter().map(|b| (b.language, b.text)).collect();
    let expected = [("c", "int a;\n"), ("rust", "b();\n")].map(|(a, b)| (a.into(), b.into()));
    assert_eq!(found[..2], expected);
}

#[test]
fn every_block_of_code_is_a_part_of_a_program_or_a_command() {
    let programs = PROGRAMS.map(read);
    let mut faults = Vec::new();
    for page in PAGES {
        for Block { language, text } in blocks(&read(page)) {
            let shown = match language.as_str() {
                "rust" | "c" | "cmake" => programs.iter().any(|program| has(program, &text)),
                "toml" | "toml natural" | "toml list" => page == "docs/CONFIGURATION.md",
                // The tests of the Python package run that page.
                "python" => has(&read("docs/PYTHON.md"), &text),
                "sh" | "text" => true,
                _ => false,
            };
            if !shown {
                faults.push(format!("{page}, a block of {language:?} that no test runs:\n{text}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn what_the_pages_add_from_outside_works() {
    let weights = outside::term().unwrap().weights;
    assert_eq!(weights.get(term::TERM.name), Some(0.5));
    assert_eq!(outside::kind(&[Role::Key, Role::Fill]).unwrap().bounds().len(), 8);
    let (mut picture, mut view) = Default::default();
    for (number, dark) in [(4, 0.25), (16, 1.0)] {
        let statistics: &mut objective::Statistics = &mut picture;
        statistics.histogram[7] = number;
        let of_view: &mut objective::maps::ViewStatistics = &mut view;
        of_view.counts.surface = 16;
        let found = (term::TERM.formula)(statistics, of_view, &objective::Objective::default());
        assert_eq!(found, dark);
    }
}

/// All lines of commands of all pages that name this program, without comments.
fn commands(program: &str) -> Vec<(&'static str, String)> {
    let of_page = |page: &'static str| {
        let shell = blocks(&read(page)).into_iter().filter(|block| block.language == "sh");
        let lines = shell.flat_map(|b| b.text.lines().map(String::from).collect::<Vec<_>>());
        lines.map(move |line| (page, line)).collect::<Vec<_>>()
    };
    let bare = |line: &str| line.split(" #").next().unwrap_or_default().trim().to_owned();
    let all = PAGES.into_iter().flat_map(of_page).map(|(page, line)| (page, bare(&line)));
    let names = |line: &str| line.split('|').any(|part| part.trim().starts_with(program));
    all.filter(|(_, line)| names(line)).collect()
}

/// Options that make a command cheap, where it has them.
const SMALL: [(&str, &str); 10] = [
    ("--size", "24x20"),
    ("--generations", "2"),
    ("--population", "4"),
    ("--device", "cpu"),
    ("--grid", "3x2"),
    ("--runs", "2"),
    ("--budget", "30"),
    ("--pipeline", ""),
    ("--baseline", ""),
    ("--warm-up", "0"),
];

/// A command of klieg in small. It must be one.
fn small(given: &str) -> String {
    let words: Vec<&str> = given.split_whitespace().collect();
    let end = words.iter().position(|word| *word == ">").unwrap_or(words.len());
    if let Err(fault) = Cli::try_parse_from(&words[..end]) {
        panic!("{given}: {fault}");
    }
    let mut command = Cli::command();
    command.build();
    let mut place = &command;
    for word in &words {
        place = place.find_subcommand(word).unwrap_or(place);
    }
    let (given, redirected) = words.split_at(end);
    let mut small = given.to_vec();
    for (name, value) in SMALL {
        let known = place.get_arguments().any(|argument| argument.get_long() == Some(&name[2..]));
        if let Some(at) = small.iter().position(|word| *word == name) {
            small.drain(at..at + 2);
        }
        let with = [&small[..], &[name, value]].concat();
        // Some ask for others, such as `klieg devices --size` for `--for`.
        if known && !value.is_empty() && Cli::try_parse_from(&with).is_ok() {
            small = with;
        }
    }
    small.extend(redirected);
    small.join(" ")
}

/// The files that the commands name.
fn furnish(place: &Folder) {
    let mut model = ball();
    model["animations"] = json!([{
        "name": "Walk",
        "samplers": [{"input": 2, "output": 3}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
    }]);
    let times = [0f32, 1.0].map(f32::to_le_bytes).concat();
    let places = [[0.9f32, 0.5, -0.9], [0.9, 0.5, 0.9]].concat();
    let places: Vec<u8> = places.into_iter().flat_map(f32::to_le_bytes).collect();
    std::fs::write(place.path("walk.bin"), [times, places].concat()).unwrap();
    let push = |model: &mut serde_json::Value, list: &str, value| {
        model[list].as_array_mut().unwrap().push(value);
    };
    push(&mut model, "buffers", json!({"byteLength": 32, "uri": "walk.bin"}));
    push(&mut model, "bufferViews", json!({"buffer": 1, "byteOffset": 0, "byteLength": 8}));
    push(&mut model, "bufferViews", json!({"buffer": 1, "byteOffset": 8, "byteLength": 24}));
    let input = json!({"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR",
                       "min": [0.0], "max": [1.0]});
    push(&mut model, "accessors", input);
    let output = json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"});
    push(&mut model, "accessors", output);
    std::fs::write(place.path("model.glb"), model.to_string()).unwrap();
    for folder in ["models", "scenes", "chairs"] {
        std::fs::create_dir(place.path(folder)).unwrap();
    }
    for scene in ["models/one.gltf", "scenes/elephant.glb", "chairs/oak.glb"] {
        std::fs::write(place.path(scene), ball().to_string()).unwrap();
    }
    let lists = blocks(&read("docs/CONFIGURATION.md"));
    let list = lists.into_iter().find(|block| block.language == "toml list").expect("a list");
    std::fs::write(place.path("views.toml"), list.text).unwrap();
}

#[test]
fn every_command_of_the_pages_runs() {
    let place = Folder::new();
    furnish(&place);
    let program = assert_cmd::cargo::cargo_bin("klieg");
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", program.parent().expect("a folder").display());
    let commands = commands("klieg");
    assert!(commands.len() > 15, "{}", commands.len());
    for (page, line) in commands {
        let reduced = |part: &str| {
            if part.trim().starts_with("klieg ") { small(part) } else { part.to_owned() }
        };
        let script = line.split('|').map(reduced).collect::<Vec<_>>().join(" | ");
        // One reproduces whole experiments, which tests/pages.rs does in small; the other serves until it is stopped, and
        // tests/studio_server.rs does so. Both have been read as commands by now.
        if line.starts_with("klieg paper") || line.starts_with("klieg studio") {
            continue;
        }
        let output = Command::new("sh")
            .args(["-c", &format!("set -e; {script}")])
            .env("PATH", &path)
            .env("XDG_CACHE_HOME", klieg_support::temporary())
            .current_dir(place.path("."))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{page}: {line}\n{script}\n{said}");
    }
}

#[test]
fn every_target_of_make_that_the_pages_name_is_there() {
    let targets = commands("make");
    assert!(targets.len() > 3, "{}", targets.len());
    for (page, line) in targets {
        let made = Command::new("make")
            .arg("-n")
            .args(line.split_whitespace().skip(1))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&made.stderr);
        assert!(made.status.success(), "{page}: {line}\n{said}");
    }
}
