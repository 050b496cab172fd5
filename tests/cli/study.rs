//! `klieg study`, from a scene to the files that it leaves.

use common::Folder;
use klieg_support::common;
use serde_json::Value;

/// Runs a study on the small scene and gives its figures.
fn study(place: &Folder, name: &str, out: &str, more: &[&str]) -> Value {
    let mut command = place.klieg(&["study", name, "ball.gltf", "--out", out]);
    command.args(["--size", "40x32"]).args(more).assert().success();
    let figures = place.read_json(&format!("{out}/{name}.json"));
    assert_eq!(figures["schema"], "klieg.study/1");
    assert_eq!(figures["study"], name);
    assert_eq!(figures["device"]["type"], "cpu");
    figures
}

/// Rows of a table, split.
fn rows(place: &Folder, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(place.path(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_landscape_has_every_position_its_minima_and_their_pictures() {
    let place = Folder::new();
    let figures = study(&place, "landscape", "out", &["--grid", "13x7", "--role", "fill"]);
    let table = rows(&place, "out/landscape.csv");
    let header =
        ["elevation_deg", "azimuth_deg", "score", "edge", "mean", "grad", "var", "hist", "minimum"];
    assert_eq!(table[0], header);
    assert_eq!(table.len(), 1 + 13 * 7);
    assert!(table[1][0].starts_with("-30.0") && table[1][1].starts_with("-90.0"));
    let scores: Vec<f64> = table[1..].iter().map(|row| row[2].parse().unwrap()).collect();
    let lowest = scores.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((number(&figures["best"]["score"]) - lowest).abs() < 1e-6);
    // Equal weights: the score is the terms' mean.
    for row in &table[1..] {
        let values: Vec<f64> = row[2..8].iter().map(|text| text.parse().unwrap()).collect();
        assert!((values[0] - values[1..].iter().sum::<f64>() / 5.0).abs() < 1e-6, "{row:?}");
    }
    let marked = table[1..].iter().filter(|row| row[8] == "1").count();
    let minima = figures["minima"].as_array().unwrap();
    assert!(marked >= 1 && marked == minima.len() && figures["local_minima"] == marked);
    for (i, _) in minima.iter().enumerate() {
        let picture = image::open(place.path(&format!("out/minimum-{:02}.png", i + 1))).unwrap();
        assert_eq!((picture.width(), picture.height()), (40, 32));
    }
    for name in ["best.png", "worst.png", "landscape.svg", "surface.svg", "term-hist.svg"] {
        assert!(place.path("out").join(name).exists(), "{name}");
    }
    assert_ne!(
        std::fs::read(place.path("out/best.png")).unwrap(),
        std::fs::read(place.path("out/worst.png")).unwrap()
    );
}

#[test]
fn descents_go_down_from_where_they_are_told_to_start() {
    let place = Folder::new();
    let from = ["--from", "70,-80", "--from", "5,60", "--grid", "7x4"];
    let figures = study(&place, "starts", "out", &from);
    let descents = figures["descents"].as_array().unwrap();
    assert_eq!(descents.len(), 2);
    let start = &descents[0]["start"];
    assert!((number(&start["elevation_deg"]) - 70.0).abs() < 1e-3, "{start}");
    assert!((number(&start["azimuth_deg"]) + 80.0).abs() < 1e-3, "{start}");
    let table = rows(&place, "out/starts.csv");
    for (i, descent) in descents.iter().enumerate() {
        let own = table[1..].iter().filter(|row| row[0] == (i + 1).to_string());
        let scores: Vec<f64> = own.map(|row| row[4].parse().unwrap()).collect();
        assert!(scores.len() > 1 && scores.is_sorted_by(|a, b| a > b), "{scores:?}");
        assert_eq!(number(&descent["steps"]) as usize + 1, scores.len());
    }
    assert!(place.path("out/start-2.png").exists() && place.path("out/end-2.png").exists());
    // Without given starts there are four, one in each quarter of the box.
    let figures = study(&place, "starts", "other", &["--grid", "5x3"]);
    let descents = figures["descents"].as_array().unwrap();
    let quarter = |d: &Value| {
        let start = &d["start"];
        (number(&start["elevation_deg"]) < 45.0, number(&start["azimuth_deg"]) < 0.0)
    };
    let quarters: Vec<_> = descents.iter().map(quarter).collect();
    assert_eq!(quarters, [(false, true), (false, false), (true, true), (true, false)]);
}

const SHORT: [&str; 6] = ["--runs", "5", "--generations", "6", "--population", "10"];

#[test]
fn courses_fall_and_searches_are_paired_by_seed() {
    let place = Folder::new();
    let courses = study(&place, "convergence", "a", &SHORT);
    // 10 individuals, then 9 new ones in each of 5 generations.
    assert_eq!(courses["budget"], 55);
    let methods = courses["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 3);
    for method in methods {
        let mean: Vec<f64> = method["mean"].as_array().unwrap().iter().map(number).collect();
        assert_eq!(mean.len(), 6);
        assert!(mean.is_sorted_by(|a, b| a >= b), "{mean:?}");
    }
    let chosen = [&SHORT[..], &["--optimizers", "greedy,ga"]].concat();
    let others = study(&place, "convergence", "c", &chosen);
    let names = |courses: &Value| {
        let names = courses["methods"].as_array().unwrap().iter();
        names.map(|m| m["method"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(&courses), ["genetic", "greedy", "random"]);
    assert_eq!(names(&others), ["descents", "genetic"]);
    assert_eq!(others["methods"][1], methods[0]);
    let pairs = study(&place, "compare", "b", &SHORT);
    for (method, side) in ["genetic", "greedy"].into_iter().enumerate() {
        // The same seeds give the same runs in both studies.
        let (one, other) = (&methods[method]["last"], &pairs[side]["quartiles"]);
        assert_eq!(one, other, "{side}");
        assert_eq!(pairs[side]["scores"].as_array().unwrap().len(), 5);
    }
    let table = rows(&place, "b/compare.csv");
    let won = table[1..].iter().filter(|row| {
        let score = |at: usize| row[at].parse::<f64>().unwrap();
        score(1) < score(2)
    });
    assert_eq!(number(&pairs["comparison"]["won"]), won.count() as f64 / 5.0);
    assert!(place.path("b/genetic.png").exists() && place.path("b/greedy.png").exists());
}

#[test]
fn five_runs_are_too_few_to_tell() {
    let place = Folder::new();
    let verdict = |runs: &str| {
        let options = ["--generations", "3", "--population", "8", "--runs", runs];
        study(&place, "compare", runs, &options)["comparison"]["verdict"].clone()
    };
    assert_eq!(verdict("5"), "too-few-runs");
    assert_ne!(verdict("6"), "too-few-runs");
}

#[test]
fn optimizers_are_measured_over_scenes_and_numbers_of_lights() {
    let place = Folder::new();
    let arguments = ["study", "optimizers", "ball.gltf", "ball.gltf", "--out", "out", "--json"];
    let mut command = place.klieg(&arguments);
    command.args(["--size", "40x32", "--lights", "1,2", "--optimizers", "ga,shade,random"]);
    command.args(["--runs", "3", "--generations", "6", "--population", "10", "--longer", "3"]);
    let printed = command.assert().success().get_output().stdout.clone();
    let figures: Value = serde_json::from_slice(&printed).unwrap();
    assert_eq!(figures, place.read_json("out/optimizers.json"));
    assert_eq!(place.list("out").len(), 4);
    assert_eq!(
        (&figures["schema"], &figures["budget"]),
        (&"klieg.optimizers/1".into(), &55.into())
    );
    let standings = figures["standings"].as_array().unwrap();
    assert_eq!(standings.len(), 2 * 3);
    for standing in standings {
        let gaps = &standing["gaps"];
        let gap = |name: &str| number(&gaps[name]);
        assert!(gap("low") >= 0.0 && gap("first") <= gap("median") && gap("median") <= gap("high"));
        assert_eq!(standing["within"].as_array().unwrap().len(), 6);
    }
    // Both scenes are the same one: so are their runs.
    let table = rows(&place, "out/optimizers.csv");
    assert_eq!(table.len(), 1 + 2 * 2 * 3 * 3);
    let half = (table.len() - 1) / 2;
    assert_eq!(table[1..=half], table[half + 1..]);
    let lowest = number(&figures["cases"][0]["lowest"]);
    for row in table[1..].iter().filter(|row| row[1] == "1") {
        let (score, gap): (f64, f64) = (row[5].parse().unwrap(), row[6].parse().unwrap());
        assert!((gap - 100.0 * (score / lowest - 1.0)).abs() < 0.01, "{row:?}");
    }
}

#[test]
fn a_run_among_others_has_the_scores_of_the_run_alone() {
    let place = Folder::new();
    for device in ["cpu", "vulkan"] {
        let scores = |out: &str, runs: &str, seed: &str| -> Vec<Value> {
            let run = ["study", "compare", "ball.gltf", "--out", out, "--device", device];
            let options = ["--generations", "4", "--runs", runs, "--seed", seed];
            let mut command = place.klieg(&run);
            command.args(["--size", "40x32"]).args(options).assert().success();
            let figures = place.read_json(&format!("{out}/compare.json"));
            assert_eq!(figures["device"]["type"] == "cpu", device == "cpu");
            let side = |name: &str| figures[name]["scores"].as_array().unwrap().clone();
            side("genetic").into_iter().chain(side("greedy")).collect()
        };
        let together = scores("together", "3", "7");
        let alone: Vec<_> = ["7", "8", "9"].iter().map(|seed| scores("alone", "1", seed)).collect();
        let expected: Vec<_> =
            (0..2).flat_map(|side| alone.iter().map(move |a| &a[side])).collect();
        assert_eq!(together.iter().collect::<Vec<_>>(), expected, "{device}");
        assert!(together[0] != together[1], "{device}");
    }
}

#[test]
fn a_sweep_tries_every_value_and_compares_with_the_standard() {
    let place = Folder::new();
    let figures = study(&place, "sweep", "out", &SHORT);
    let trials = figures["trials"].as_array().unwrap();
    assert_eq!(trials.len(), 4 * 5);
    assert_eq!(rows(&place, "out/sweep.csv").len(), 1 + 4 * 5);
    let standard: Vec<_> = trials.iter().filter(|trial| trial["standard"] == true).collect();
    assert_eq!(standard.len(), 4);
    for trial in &standard {
        assert_eq!(trial["last"], standard[0]["last"]);
        assert_eq!(number(&trial["against_standard"]["p_value"]), 1.0);
    }
    assert!(trials.iter().any(|trial| trial["last"] != standard[0]["last"]));
    assert!(place.path("out/sweep.svg").exists());
}

#[test]
fn an_ablation_changes_one_number_at_a_time() {
    let place = Folder::new();
    let figures = study(&place, "ablation", "out", &SHORT);
    let variants = figures["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 19);
    assert_eq!(variants[0]["name"], "unchanged");
    assert_eq!(rows(&place, "out/ablation.csv").len(), 1 + 19);
    let without = variants.iter().find(|v| v["name"] == "without F_mean").unwrap();
    assert_eq!(number(&without["changed"]["weights"]["mean"]), 0.0);
    assert!(number(&without["change"]) > 0.0);
    assert_eq!(place.list("out").iter().filter(|name| name.ends_with(".png")).count(), 19);
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_written() {
    let place = Folder::new();
    let cases: [(&[&str], &str); 7] = [
        (&["landscape", "--grid", "1x9"], "1x9"),
        (&["landscape", "--grid", "9"], "COLUMNSxROWS"),
        (&["landscape", "--grid", "99999x99999"], "1048576"),
        (&["starts", "--from", "95,0"], "elevation"),
        (&["starts", "--from", "1,2,3"], "2 (el,az)"),
        (&["compare", "--runs", "0"], "runs is 0"),
        (&["sweep", "--lights", "17"], "17 lights"),
    ];
    for (arguments, fault) in cases {
        let mut command = place.klieg(&["study", arguments[0]]);
        command.args(&arguments[1..]).args(["ball.gltf", "--out", "out"]);
        let output = command.assert().code(2).get_output().clone();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(fault), "{text}");
        assert!(!place.path("out").exists() || place.list("out").is_empty());
    }
}
