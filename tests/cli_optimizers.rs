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
    // 8 individuals, then 7 new ones in each of 3 generations; trials and random ones are new in all 4.
    let made = |design: &serde_json::Value| design["evaluations"].as_u64().unwrap();
    let standard = design("standard", &[]);
    let shade = design("shade", &["--optimizer", "shade"]);
    assert_eq!((made(&shade), &shade["score"]), (32, &standard["score"]));
    let paper = design("paper", &["--profile", "paper"]);
    let genetic = design("genetic", &["--profile", "paper", "--optimizer", "ga"]);
    assert_eq!((made(&genetic), &genetic["score"]), (29, &paper["score"]));
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
    let arguments =
        ["--size", "48x40", "--generations", "30", "--config", "none.toml", "--optimizer", "ga"];
    place.klieg(&["design", "ball.gltf", "--out", "out"]).args(arguments).assert().success();
    let table = std::fs::read_to_string(place.path("out/convergence.csv")).unwrap();
    let best = table.lines().skip(1).map(|line| line.split(',').nth(2).unwrap().parse().unwrap());
    let best: Vec<f32> = best.collect();
    assert!(best.len() == 30 && best.is_sorted_by(|a, b| a >= b), "{best:?}");
    let score = place.read_json("out/result.json")["score"].as_f64().unwrap();
    assert_eq!(score as f32, best[29]);
}

#[test]
fn a_search_that_has_nothing_left_to_gain_ends_by_itself() {
    let place = Folder::new();
    std::fs::write(place.path("never.toml"), "[shade]\nsettled = -1.0\n").unwrap();
    let design = |out: &str, more: &[&str]| {
        let small = ["design", "ball.gltf", "--size", "48x40", "--lights", "key", "--out", out];
        let mut command = place.klieg(&small);
        command.args(["--generations", "300", "--shadows", "off"]).args(more).assert().success();
        let result = place.read_json(&format!("{out}/result.json"));
        (result["generations"].as_u64().unwrap(), result["score"].as_f64().unwrap())
    };
    let (settled, whole) = (design("settled", &[]), design("whole", &["--config", "never.toml"]));
    assert!(settled.0 < 200 && whole.0 == 300, "{settled:?} {whole:?}");
    assert!(settled.1 < 1.01 * whole.1, "{settled:?} {whole:?}");
}
