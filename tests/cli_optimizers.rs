//! Designs with each of the optimisers.

use klieg_support::common::Folder;

#[test]
fn a_greedy_search_descends_and_repeats_itself() {
    let place = Folder::new();
    let arguments = ["design", "ball.gltf", "--size", "48x40", "--optimizer", "greedy"];
    std::fs::write(place.path("starts.toml"), "[greedy]\nstarts = 3\n").unwrap();
    for out in ["one", "two", "three"] {
        let mut command = place.klieg(&arguments);
        command.args(["--out", out]);
        if out == "three" {
            command.args(["--config", "starts.toml"]);
        }
        command.assert().success();
    }
    let score = |out: &str| place.read_json(&format!("{out}/result.json"))["score"].as_f64();
    assert_eq!(score("one"), score("two"));
    assert!(score("three") <= score("one"), "the first of three starts is the only one of one");
    let table = std::fs::read_to_string(place.path("one/convergence.csv")).unwrap();
    let best: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
        .collect();
    assert!(best.is_sorted_by(|a, b| a >= b) && best[best.len() - 1] < best[0], "{best:?}");
}

#[test]
fn every_optimizer_is_chosen_by_its_name() {
    let place = Folder::new();
    std::fs::write(place.path("random.toml"), "optimizer = \"random\"\n").unwrap();
    let small = ["--size", "48x40", "--generations", "4", "--population", "8", "--json"];
    let design = |out: &str, arguments: &[&str]| {
        let mut command = place.klieg(&["design", "ball.gltf", "--out", out]);
        let output = command.args(small).args(arguments).output().unwrap();
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    // 8 individuals, then 7 new ones in each of 3 generations; random ones are new in all 4.
    let made = |design: &serde_json::Value| design["evaluations"].as_u64().unwrap();
    let standard = design("standard", &[]);
    let genetic = design("genetic", &["--optimizer", "ga"]);
    assert_eq!((made(&genetic), &genetic["score"]), (29, &standard["score"]));
    assert_eq!(made(&design("random", &["--optimizer", "random"])), 32);
    let named = design("named", &["--config", "random.toml"]);
    assert_eq!(named["score"], place.read_json("random/result.json")["score"]);
    let restarts = made(&design("restarts", &["--optimizer", "restarts"]));
    assert!((29..29 + 20).contains(&restarts), "{restarts}");
}

#[test]
fn without_elites_the_best_is_still_the_best_of_all() {
    let place = Folder::new();
    std::fs::write(place.path("none.toml"), "[search]\nelitism = 0.0\n").unwrap();
    let arguments = ["--size", "48x40", "--generations", "30", "--config", "none.toml"];
    place.klieg(&["design", "ball.gltf", "--out", "out"]).args(arguments).assert().success();
    let table = std::fs::read_to_string(place.path("out/convergence.csv")).unwrap();
    let best = table.lines().skip(1).map(|line| line.split(',').nth(2).unwrap().parse().unwrap());
    let best: Vec<f32> = best.collect();
    assert!(best.len() == 30 && best.is_sorted_by(|a, b| a >= b), "{best:?}");
    let score = place.read_json("out/result.json")["score"].as_f64().unwrap();
    assert_eq!(score as f32, best[29]);
}

#[test]
fn a_time_limit_ends_a_search_with_its_best() {
    let place = Folder::new();
    let endless = ["--size", "16x16", "--generations", "100000000", "--time-limit", "0.5"];
    let design = [&["design", "ball.gltf", "--out", "out"][..], &endless].concat();
    let output = place.klieg(&design).assert().success().get_output().clone();
    assert!(String::from_utf8(output.stderr).unwrap().contains("stopped after"));
    let generations = |name: &str| place.read_json(name)["generations"].as_u64().unwrap();
    assert!((1..100_000_000).contains(&generations("out/result.json")));
    // Each design of a batch has as much time, and is done.
    std::fs::copy(place.path("ball.gltf"), place.path("other.gltf")).unwrap();
    let batch = [&["batch", "ball.gltf", "other.gltf", "--out", "lit"][..], &endless].concat();
    place.klieg(&batch).assert().success();
    assert_eq!(place.read_json("lit/batch.json")["done"], 2);
    for limit in ["0", "-1", "nan"] {
        let design = ["design", "ball.gltf", "--out", "out", "--time-limit", limit];
        place.klieg(&design).assert().code(2);
    }
}
