//! Pages that klieg writes, in a real browser.

use common::Folder;
use klieg_support::{browser, common, npm};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The sheet of a design, and that with something put in at its end.
struct Sheet {
    place: Folder,
    text: String,
}

impl Sheet {
    fn new() -> Self {
        let place = Folder::new();
        place.design("out", &[]).assert().success();
        let text = std::fs::read_to_string(place.path("out/report.html")).unwrap();
        Self { place, text }
    }

    fn with(&self, name: &str, fault: &str) -> PathBuf {
        let (before, after) = self.text.split_once("</main>").unwrap();
        let path = self.place.path(name);
        std::fs::write(&path, format!("{before}{fault}</main>{after}")).unwrap();
        path
    }
}

#[test]
fn the_sheet_of_a_design_is_sound_at_every_width_and_in_both_schemes() {
    let sheet = Sheet::new();
    let report = browser::check(&sheet.place.path("out/report.html"));
    assert_eq!(report.faults(), [""; 0]);
    // Four rigs, two of them under the wiper, and a map for each of two lights.
    assert_eq!(report.pictures, 8);
    let layouts: Vec<_> =
        report.layouts.iter().map(|layout| (layout.scheme.as_str(), layout.width)).collect();
    assert_eq!(layouts, [("light", 390), ("light", 1280), ("dark", 390), ("dark", 1280)]);
    let background = |index: usize| &report.layouts[index].background;
    assert_eq!(background(0), background(1));
    assert_ne!(background(0), background(2));
}

#[test]
fn a_wiper_compares_the_design_with_each_usual_rig() {
    let sheet = Sheet::new();
    let page = sheet.place.path("out/report.html");
    let printed = npm::run("browser", "wiper.mjs", &[&browser::chromium(), &page]);
    let said: Value = serde_json::from_slice(&printed).unwrap();
    let at = |state: usize| said["states"][state]["at"].as_f64().unwrap();
    let shown = |state: usize| said["states"][state]["shown"].clone();
    // At first in the middle, then where it was dragged to, then by the keyboard at the end.
    assert!((at(0) - 50.0).abs() < 0.5 && (at(1) - 25.0).abs() < 0.5 && at(2) > 99.5, "{said}");
    // The headlight is the first picture, the design the second, the last one the last usual rig.
    assert_eq!((shown(0), shown(2), shown(3)), (json!([0, 1]), json!([0, 1]), json!([3, 1])));
    assert_eq!(said["choices"].as_array().unwrap().len(), 3);
    assert_eq!(said["withoutScripts"], true);
}

#[test]
fn planted_faults_are_found() {
    let sheet = Sheet::new();
    let check = |name: &str, fault: &str| browser::check(&sheet.with(name, fault));

    let report = check("picture.html", "<img src=\"missing.png\">");
    assert!(report.broken.len() == 1 && report.broken[0].ends_with("/missing.png"), "{report:?}");
    assert!(report.requests[0].ends_with("/missing.png"), "{report:?}");
    let broken = "<svg><image href=\"data:image/png;base64,iVBORw0KGgo=\"/></svg>";
    let report = check("svg.html", broken);
    assert_eq!(report.broken, ["data:image/png;base64,iVBORw0KGgo="]);
    assert_eq!((report.pictures, report.requests.len()), (9, 0));

    let scripts = "<script>console.error('planted')</script><script>throw Error('thrown')</script>";
    let report = check("script.html", scripts);
    assert_eq!(report.errors.len(), 2, "{report:?}");
    assert!(report.errors[0] == "planted" && report.errors[1].contains("thrown"), "{report:?}");
    assert_eq!(report.faults().len(), 2);

    let report = check("wide.html", "<div style=\"width: 600px\">wide</div>");
    let scrolls: Vec<_> = report.layouts.iter().map(|layout| layout.scrolls).collect();
    assert_eq!(scrolls, [true, false, true, false]);
    assert_eq!(report.faults().len(), 2);

    let style = "<link rel=\"stylesheet\" href=\"https://example.org/style.css\">";
    let report = check("network.html", style);
    assert_eq!(report.requests, ["https://example.org/style.css"]);
}

#[test]
fn values_are_read_as_they_are_shown() {
    let sheet = Sheet::new();
    let values = "<b data-value=\"best.score\"> 0.2478 </b><i data-value=\"runs\">1<u>0</u></i>";
    let report = browser::check(&sheet.with("values.html", values));
    let expected = [("best.score", "0.2478"), ("runs", "10")];
    assert_eq!(report.values, expected.map(|(name, text)| (name.to_string(), text.to_string())));
    assert_eq!(report.faults(), [""; 0]);
}

/// Numbers of the page that are not those of the JSON, in words.
fn differences(values: &[(String, String)], figures: &Value) -> Vec<String> {
    let differs = |(pointer, text): &(String, String)| {
        let Some(number) = figures.pointer(pointer).and_then(Value::as_f64) else {
            return Some(format!("no figure {pointer}"));
        };
        let Ok(shown) = text.parse::<f64>() else {
            return Some(format!("{pointer} shows '{text}'"));
        };
        // Shares are shown in percent.
        let number = if pointer.ends_with("/won") { 100.0 * number } else { number };
        let digits = text.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        let rounding = 0.5 * 10f64.powi(-(digits as i32)) + 1e-6;
        let far = (shown - number).abs() > rounding;
        far.then(|| format!("{pointer} is {number}, the page shows {text}"))
    };
    values.iter().filter_map(differs).collect()
}

fn quick(device: &str) -> Value {
    let place = Folder::new();
    let arguments = ["paper", "--quick", "--device", device, "--out", "out"];
    place.klieg(&arguments).assert().success();
    assert_eq!(place.list("out"), ["index.html", "paper.json"]);
    let figures = place.read_json("out/paper.json");
    let report = browser::check(&place.path("out/index.html"));
    assert_eq!(report.faults(), [""; 0]);
    // Three maps, best, worst, eight ends, two medians twice or more, seven heat maps and one more.
    assert!(report.pictures > 40, "{}", report.pictures);
    assert!(report.values.len() > 80, "{}", report.values.len());
    assert_eq!(differences(&report.values, &figures), [""; 0]);

    let mut planted = report.values;
    planted[7].1.push('7');
    planted[20].0.push('x');
    planted[30].1 = "–".into();
    assert_eq!(differences(&planted, &figures).len(), 3);
    figures
}

#[test]
fn the_page_stands_alone_and_shows_the_figures_of_the_json() {
    let cpu = quick("cpu");
    assert_eq!((&cpu["schema"], &cpu["profile"]), (&"klieg.paper/1".into(), &"paper".into()));
    let names: Vec<_> = cpu["scenes"].as_array().unwrap().iter().map(|s| &s["name"]).collect();
    assert_eq!(names, ["elephant", "pair"]);
    assert_eq!(cpu["claims"].as_array().unwrap().len(), 6);

    // Scenes without textures: both devices see the same landscape.
    let vulkan = quick("vulkan");
    assert_ne!(vulkan["device"]["type"], "cpu");
    for scene in 0..2 {
        let best = |figures: &Value| {
            let best = &figures["scenes"][scene]["landscape"]["best"];
            ["elevation_deg", "azimuth_deg", "score"].map(|key| best[key].as_f64().unwrap())
        };
        for (a, b) in best(&cpu).into_iter().zip(best(&vulkan)) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let place = Folder::new();
    let run = |out: &str, seed: &str| {
        let options = ["--out", out, "--seed", seed, "--runs", "2", "--size", "48x48"];
        let mut command = place.klieg(&["paper", "--quick"]);
        command.args(options).assert().success();
        let read = |name| std::fs::read(place.path(out).join(name)).unwrap();
        (read("index.html"), read("paper.json"))
    };
    let first = run("a", "5");
    assert!(first == run("b", "5"));
    let other = run("c", "6");
    assert!(first.0 != other.0 && first.1 != other.1);
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_written() {
    let place = Folder::new();
    for ([option, value], fault) in [
        (["--runs", "0"], "runs is 0"),
        (["--runs", "1001"], "runs is 1001"),
        (["--device", "no-such-device"], "no-such-device"),
    ] {
        let mut command = place.klieg(&["paper", "--quick", "--out", "out", option, value]);
        let output = command.assert().code(2).get_output().clone();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(fault), "{text}");
        assert!(!place.path("out").exists() || place.list("out").is_empty());
    }
}
