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
    assert!((29..29 + 10).contains(&made(&design("cma-es", &["--optimizer", "cma-es"]))));
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

#[test]
fn a_search_may_begin_on_small_pictures_and_tells_the_score_of_the_whole_one() {
    let place = Folder::new();
    for device in ["cpu", "vulkan"] {
        let design = |out: &str, coarse: &str| {
            let small = ["design", "ball.gltf", "--size", "80x64", "--device", device];
            let mut command = place.klieg(&small);
            command.args(["--generations", "12", "--population", "8"]);
            command.args(["--out", out, "--coarse", coarse]).assert().success();
            let table = std::fs::read_to_string(place.path(&format!("{out}/convergence.csv")));
            let table = table.unwrap();
            let best = |line: &str| line.split(',').nth(2).unwrap().parse().unwrap();
            let bests: Vec<f32> = table.lines().skip(1).map(best).collect();
            let of = |size: &str| table.lines().filter(|line| line.ends_with(size)).count();
            let small = [of(",1/4"), of(",1/2"), of(",whole")];
            // The first may end before their half is over.
            assert_eq!(small[0] > 0 && small[1] > 1 && small[2] > 3, coarse == "20", "{device}");
            assert_eq!(small == [0, 0, 12], coarse != "20", "{device}: {small:?}");
            let score = place.read_json(&format!("{out}/result.json"))["score"].as_f64().unwrap();
            (bests, score as f32)
        };
        let (coarse, score) = design("coarse", "20");
        let (whole, _) = design("whole", "0");
        assert_eq!((coarse.len(), whole.len()), (12, 12), "{device}");
        assert_ne!(coarse[0], whole[0], "{device}");
        assert_eq!(score, coarse[11], "{device}");
        // It is what the whole picture has under these lights, in lit.glb too.
        let mut command = place.klieg(&["score", "coarse/lit.glb", "--device", device, "--json"]);
        let output = command.output().unwrap();
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let told = told["score"].as_f64().unwrap() as f32;
        assert!((told - score).abs() < 2e-3, "{device}: {told} {score}");
        // A third of the picture's side is small; more is not.
        assert_eq!(design("third", "27").0, whole, "{device}");
    }
    let mut command = place.klieg(&["design", "ball.gltf", "--out", "out", "--coarse", "3"]);
    let output = command.assert().code(2).get_output().stderr.clone();
    assert!(String::from_utf8_lossy(&output).contains("coarse.side"));
}

#[test]
fn a_time_limit_ends_a_search_with_its_best() {
    let place = Folder::new();
    let size = ["--size", "16x16", "--optimizer", "ga"];
    let endless = [&size[..], &["--generations", "100000000", "--time-limit", "0.5"]].concat();
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
