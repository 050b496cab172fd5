//! `klieg gallery` and `klieg design --alternatives`: many lights, their files and pages.

use common::Folder;
use klieg_support::{browser, common};
use serde_json::Value;

const SMALL: [&str; 6] = ["--size", "48x40", "--generations", "6", "--population", "8"];

/// A small gallery into `out`; gives its record, which is what it printed, and what it said besides.
fn gallery(place: &Folder, out: &str, more: &[&str]) -> (Value, String) {
    let mut command = place.klieg(&["gallery", "ball.gltf", "--out", out, "--json"]);
    let output = command.args(SMALL).args(more).assert().success().get_output().clone();
    let record = place.read_json(&format!("{out}/gallery.json"));
    assert_eq!(record, serde_json::from_slice::<Value>(&output.stdout).unwrap());
    (record, String::from_utf8(output.stderr).unwrap())
}

fn numbers(record: &Value, key: &str) -> Vec<f64> {
    let rigs = record["rigs"].as_array().unwrap().iter();
    rigs.map(|rig| rig[key].as_f64().unwrap()).collect()
}

/// What a text of standard error says.
fn refused(place: &Folder, arguments: &[&str]) -> String {
    let fault = place.klieg(arguments).args(SMALL).assert().code(2).get_output().clone();
    String::from_utf8(fault.stderr).unwrap()
}

#[test]
fn a_gallery_has_the_files_of_each_rig_and_a_page_of_all() {
    let place = Folder::new();
    let (record, _) = gallery(&place, "out", &["--count", "5"]);
    let mut files: Vec<String> = (1..=5)
        .flat_map(|number| ["glb", "png", "rig.json"].map(|end| format!("0{number}.{end}")))
        .collect();
    files.extend(["gallery.json", "index.html"].map(str::to_owned));
    assert_eq!(place.list("out"), files);

    assert_eq!(
        (&record["schema"], &record["profile"]),
        (&"klieg.gallery/1".into(), &"natural".into())
    );
    let scores = numbers(&record, "score");
    assert!(scores.is_sorted() && scores[4] <= scores[0] + 0.12, "{scores:?}");
    assert_eq!(numbers(&record, "number"), [1.0, 2.0, 3.0, 4.0, 5.0]);
    let first = record["rigs"].as_array().unwrap().iter().filter(|rig| rig["first"] == true);
    assert_eq!(first.count(), 1);
    for (at, nearest) in numbers(&record, "nearest").into_iter().enumerate() {
        let row = record["distances"][at].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        let others = row.enumerate().filter(|(other, _)| *other != at).map(|(_, x)| x);
        assert_eq!(others.fold(f64::INFINITY, f64::min), nearest);
        assert!(nearest > 0.0);
    }

    // A rig's file makes its picture again, and its lit scene has its score.
    let rig = place.read_json("out/03.rig.json");
    assert_eq!(
        (&rig["score"], &rig["lights"]),
        (&record["rigs"][2]["score"], &record["rigs"][2]["lights"])
    );
    let render = [
        "render",
        "ball.gltf",
        "--rig",
        "out/03.rig.json",
        "--out",
        "again.png",
        "--size",
        "48x40",
    ];
    std::fs::write(place.path("four.toml"), "[picture]\nsamples = 4\n").unwrap();
    place.klieg(&[&render[..], &["--config", "four.toml"]].concat()).assert().success();
    let pixels = |name: &str| image::open(place.path(name)).unwrap().to_rgb8();
    let differ = std::iter::zip(pixels("again.png").into_raw(), pixels("out/03.png").into_raw());
    assert!(differ.into_iter().all(|(a, b)| a.abs_diff(b) <= 1));
    let score =
        place.klieg(&["score", "out/03.glb", "--json"]).assert().success().get_output().clone();
    let score: Value = serde_json::from_slice(&score.stdout).unwrap();
    assert!((score["score"].as_f64().unwrap() - scores[2]).abs() < 1e-3, "{score} {scores:?}");

    let report = browser::check(&place.path("out/index.html"));
    assert_eq!(report.faults(), [""; 0]);
    // On a card and on the map.
    assert_eq!(report.pictures, 10);
}

#[test]
fn the_same_seed_gives_the_same_gallery() {
    let place = Folder::new();
    for (out, seed) in [("a", "3"), ("b", "3"), ("c", "4")] {
        gallery(&place, out, &["--count", "3", "--seed", seed]);
    }
    let same = |a: &str, b: &str, name: &str| {
        let read = |out: &str| std::fs::read(place.path(out).join(name)).unwrap();
        read(a) == read(b)
    };
    for name in ["index.html", "01.png", "02.rig.json", "03.glb"] {
        assert!(same("a", "b", name), "{name}");
    }
    assert!(!same("a", "c", "02.rig.json"));
}

#[test]
fn a_gallery_goes_on_from_one_of_another() {
    let place = Folder::new();
    let (wide, _) = gallery(&place, "wide", &["--count", "4"]);
    let pick = ["--from", "wide", "--pick", "2", "--count", "4"];
    let (near, _) = gallery(&place, "near", &pick);
    assert_eq!((&near["picked"]["folder"], &near["picked"]["number"]), (&"wide".into(), &2.into()));
    assert_eq!(wide["picked"], Value::Null);
    let angle = |light: &Value, key: &str| light[key].as_f64().unwrap();
    let picked = &wide["rigs"][1]["lights"][0];
    let rigs = near["rigs"].as_array().unwrap();
    for rig in rigs {
        let key = &rig["lights"][0];
        // No further than 0.15 of the box, 180° wide.
        assert!((angle(key, "azimuth_deg") - angle(picked, "azimuth_deg")).abs() < 28.0, "{key}");
    }
    let first = rigs.iter().find(|rig| rig["first"] == true).unwrap();
    assert!(
        (angle(&first["lights"][0], "azimuth_deg") - angle(picked, "azimuth_deg")).abs() < 1e-3
    );
    let spread =
        |record: &Value| numbers(record, "nearest").into_iter().fold(f64::INFINITY, f64::min);
    assert!(spread(&near) < spread(&wide), "{near} {wide}");
    // Not over what it is made from.
    let over = ["gallery", "ball.gltf", "--out", "wide", "--from", "wide", "--pick", "2"];
    assert!(refused(&place, &over).contains("would be overwritten"));
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_written() {
    let place = Folder::new();
    std::fs::create_dir(place.path("empty")).unwrap();
    std::fs::create_dir(place.path("other")).unwrap();
    std::fs::write(place.path("other/gallery.json"), "{\"schema\": \"x\", \"rigs\": []}").unwrap();
    gallery(&place, "good", &["--count", "2"]);
    for (more, words) in [
        (&["--count", "1"][..], "count is 1"),
        (&["--count", "100"], "count is 100"),
        (&["--slack", "-0.1"], "slack is -0.1"),
        (&["--slack", "NaN"], "slack is NaN"),
        (&["--pick", "2"], "--from"),
        (&["--from", "good"], "--pick"),
        (&["--from", "empty", "--pick", "1"], "gallery.json"),
        (&["--from", "other", "--pick", "1"], "klieg.gallery/1"),
        (&["--from", "good", "--pick", "3"], "has no rig 3: it has 1 to 2"),
        (&["--from", "good", "--pick", "0"], "has no rig 0"),
        (&["--from", "good", "--pick", "1", "--lights", "3"], "2 lights"),
    ] {
        let said = refused(&place, &[&["gallery", "ball.gltf", "--out", "out"], more].concat());
        assert!(said.contains(words), "{more:?}: {said}");
        assert!(!place.path("out").exists(), "{more:?}");
    }
    for (number, words) in [("0", "1 to 98"), ("99", "1 to 98")] {
        let said =
            refused(&place, &["design", "ball.gltf", "--out", "out", "--alternatives", number]);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_gallery_without_slack_is_small_and_says_so() {
    let place = Folder::new();
    let (record, said) = gallery(&place, "out", &["--count", "4", "--slack", "0"]);
    assert!(record["rigs"].as_array().unwrap().len() < 4);
    assert!(said.contains("in place of 4"), "{said}");
}

#[test]
fn a_design_shows_alternatives_where_they_are_wanted() {
    let place = Folder::new();
    place.design("plain", &[]).assert().success();
    place.design("out", &["--alternatives", "3"]).assert().success();
    let [mut plain, mut design] =
        ["plain", "out"].map(|out| place.read_json(&format!("{out}/result.json")));
    for result in [&mut plain, &mut design] {
        result.as_object_mut().unwrap().remove("timing_ms");
    }
    let others = design.as_object_mut().unwrap().remove("alternatives").unwrap();
    // The design itself is the same.
    assert_eq!(plain, design);
    let others = others.as_array().unwrap();
    assert_eq!(others.len(), 3);
    for other in others {
        assert_eq!(other["lights"].as_array().unwrap().len(), 2);
        assert_ne!(other["lights"], design["lights"]);
    }
    let report = browser::check(&place.path("out/report.html"));
    assert_eq!(report.faults(), [""; 0]);
    // Besides the alternatives four rigs, two of them under the wiper, and a map for each of two lights.
    assert_eq!(report.pictures, 3 + 8);
}
