//! How klieg behaves in a shell: streams, messages, completions, the manual, and widths.

use common::{Folder, ball, list};
use klieg_support::common;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn run(place: &Folder, arguments: &[&str], input: &[u8]) -> Output {
    let mut command = place.klieg(arguments);
    command.write_stdin(input).assert().success().get_output().clone()
}

const SMALL: [&str; 6] = ["--size", "24x20", "--generations", "2", "--population", "4"];
const SCORE: [&str; 4] = ["--preset", "headlight", "--size", "24x20"];

#[test]
fn scenes_lists_rigs_and_settings_come_from_standard_input() {
    let place = Folder::new();
    let scored = |scene: &str, input: &[u8]| {
        let output = run(&place, &[&["score", scene, "--json"], &SCORE[..]].concat(), input);
        serde_json::from_slice::<Value>(&output.stdout).unwrap()["score"].clone()
    };
    assert_eq!(scored("-", ball().to_string().as_bytes()), scored("ball.gltf", b""));
    let batch = [&["batch", "-", "-o", "lit"], &SMALL[..]].concat();
    run(&place, &batch, b"# a list\nball.gltf\n");
    assert_eq!(list(&place.path("lit")), ["ball", "batch.csv", "batch.json", "index.html"]);
    let rig = std::fs::read(place.path("lit/ball/result.json")).unwrap();
    run(&place, &["render", "ball.gltf", "--rig", "-", "-o", "a.png", "--size", "8x8"], &rig);
    let config = ["render", "ball.gltf", "--preset", "headlight", "--config", "-", "-o", "b.png"];
    run(&place, &config, b"[view]\nsize = \"12x8\"\n");
    assert_eq!(image::open(place.path("b.png")).unwrap().width(), 12);
    for arguments in [&["inspect", "-"][..], &["batch", "-", "-o", "no"]] {
        let output = place.klieg(arguments).write_stdin("").assert().code(2).get_output().clone();
        assert!(text(&output.stderr).contains("standard"), "{}", text(&output.stderr));
    }
    assert!(!place.path("no").exists());
}

#[test]
fn pictures_go_to_standard_output_alone() {
    let place = Folder::new();
    let render = ["render", "ball.gltf", "--preset", "headlight", "--size", "16x12", "-o"];
    let piped = run(&place, &[&render[..], &["-"]].concat(), b"").stdout;
    run(&place, &[&render[..], &["file.png"]].concat(), b"");
    assert_eq!(piped, std::fs::read(place.path("file.png")).unwrap());
    let thumbnail = run(&place, &["thumbnail", "ball.gltf", "-", "--size", "16x16"], b"").stdout;
    assert!(thumbnail.starts_with(b"\x89PNG"));
}

#[test]
fn it_says_more_or_less_as_asked() {
    let place = Folder::new();
    let mut warned = ball();
    warned["extensionsUsed"] = serde_json::json!(["EXAMPLE_unknown"]);
    std::fs::write(place.path("warned.gltf"), warned.to_string()).unwrap();
    let said = |more: &[&str]| {
        let output = run(&place, &[&["score", "warned.gltf"], &SCORE[..], more].concat(), b"");
        assert!(text(&output.stdout).contains("headlight"));
        text(&output.stderr)
    };
    let usual = said(&[]);
    assert!(usual.contains("klieg: warning: ") && usual.contains("device: "), "{usual}");
    assert!(!usual.contains("read warned.gltf"), "{usual}");
    let more = said(&["-v"]);
    assert!(more.contains(&usual) || more.contains("klieg: read warned.gltf: "), "{more}");
    assert!(more.lines().count() > usual.lines().count(), "{more}");
    assert_eq!(said(&["-q"]), "");
    let fault = place.klieg(&["score", "gone.glb", "-q"]).assert().code(2).get_output().clone();
    assert!(text(&fault.stderr).starts_with("klieg: error: "));
    place.klieg(&["score", "ball.gltf", "-q", "-v"]).assert().code(2);
}

#[test]
fn colours_are_for_terminals_and_those_who_force_them() {
    let place = Folder::new();
    let said = |name: &str, value: &str| {
        let mut command = place.klieg(&["score", "gone.glb"]);
        text(&command.env(name, value).assert().code(2).get_output().stderr)
    };
    assert!(said("CLICOLOR_FORCE", "1").contains("\u{1b}["));
    let plain = said("NO_COLOR", "1");
    assert!(plain.starts_with("klieg: error: ") && !plain.contains('\u{1b}'), "{plain}");
}

#[test]
fn a_batch_tells_of_each_design() {
    let place = Folder::new();
    std::fs::copy(place.path("ball.gltf"), place.path("other.gltf")).unwrap();
    let batch =
        [&["batch", "ball.gltf", "other.gltf", "gone.glb", "-o", "lit"], &SMALL[..]].concat();
    let output = place.klieg(&batch).assert().code(2).get_output().clone();
    let said = text(&output.stderr);
    for part in ["1 of 3: ball done in ", ", F 0.", "2 of 3: other done", "3 of 3: gone failed"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

/// The widest line.
fn width(text: &str) -> usize {
    text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
}

#[test]
fn tables_fit_eighty_columns() {
    let place = Folder::new();
    std::fs::copy(place.path("ball.gltf"), place.path(&format!("{}.gltf", "long-".repeat(20))))
        .unwrap();
    let design = [&["design", "ball.gltf", "-o", "o", "--lights", "3"], &SMALL[..]].concat();
    let bench = ["bench", "ball.gltf", "--runs", "1", "--warm-up", "0", "--population", "4"];
    let ablation = ["study", "ablation", "ball.gltf", "-o", "a", "--runs", "1"];
    for arguments in [
        &design[..],
        &[&["score", "ball.gltf"], &SCORE[..]].concat(),
        &[&["batch", ".", "-o", "lit"], &SMALL[..]].concat(),
        &[&bench[..], &["--size", "24x20", "--lights", "1,16"]].concat(),
        &[&ablation[..], &SMALL[..]].concat(),
        &[&["study", "optimizers", "ball.gltf", "-o", "p", "--runs", "2"], &SMALL[..]].concat(),
        &["terms"],
        &["devices"],
        &["devices", "--for", "ball.gltf", "--size", "64x48"],
        &["inspect", "ball.gltf"],
    ] {
        let shown = text(&run(&place, arguments, b"").stdout);
        assert!(width(&shown) <= 80 && !shown.is_empty(), "{arguments:?}\n{shown}");
    }
}

#[test]
fn faults_say_what_is_right() {
    let place = Folder::new();
    for (arguments, words) in [
        (&["--population", "1"][..], "population is 1: it must be 2 to 131072"),
        (&["--time-limit", "0"], "time_limit is 0: it must be more than 0"),
        (&["--lights", "17"], "17 lights: there must be 1 to 16"),
    ] {
        let design = [&["design", "ball.gltf", "-o", "out"], arguments].concat();
        let fault = place.klieg(&design).assert().code(2).get_output().clone();
        assert!(text(&fault.stderr).contains(words), "{}", text(&fault.stderr));
    }
}

#[test]
fn shells_and_man_know_all_commands() {
    let place = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = text(&run(&place, &["completions", shell], b"").stdout);
        assert!(["thumbnail", "keep-lights"].iter().all(|part| script.contains(part)), "{shell}");
    }
    assert!(text(&run(&place, &["man"], b"").stdout).contains(".TH klieg 1"));
    run(&place, &["man", "-o", "man1"], b"");
    let pages = list(&place.path("man1"));
    for page in ["klieg.1", "klieg-design.1", "klieg-study-sweep.1"] {
        assert!(pages.iter().any(|found| found == page), "{page}: {pages:?}");
    }
    assert!(!pages.iter().any(|page| page.contains("batch-item") || page.contains("help")));
    let page = std::fs::read_to_string(place.path("man1/klieg-design.1")).unwrap();
    assert!(page.contains("keep") && page.contains("klieg\\-design"), "{page}");
}

#[test]
fn make_installs_the_program_with_its_page_and_completions() {
    let place = Folder::new();
    let program = assert_cmd::cargo::cargo_bin("klieg");
    let made = Command::new("make")
        .args(["install-program", "PREFIX=/usr"])
        .arg(format!("DESTDIR={}", place.path("root").display()))
        .arg(format!("PROGRAM={}", program.display()))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", text(&made.stderr));
    for file in [
        "bin/klieg",
        "share/man/man1/klieg-design.1",
        "share/bash-completion/completions/klieg",
        "share/zsh/site-functions/_klieg",
        "share/fish/vendor_completions.d/klieg.fish",
    ] {
        let installed = place.path("root/usr").join(Path::new(file));
        assert!(installed.metadata().is_ok_and(|found| found.len() > 0), "{file}");
    }
}
