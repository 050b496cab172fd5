//! `klieg bench`: a row for each combination, honest baselines, files.

use common::Folder;
use klieg::evaluate::Evaluator;
use klieg::gpu::ReadbackEvaluator;
use klieg::lighting::LightKind;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::view::View;
use klieg_support::{common, gpu};
use serde_json::Value;

/// Few and short measurements.
const SHORT: [&str; 6] = ["--runs", "7", "--warm-up", "1", "--seconds", "0.1"];

fn bench(place: &Folder, arguments: &[&str]) -> Value {
    let all = [&["bench", "--json"][..], arguments, &SHORT].concat();
    let run = place.klieg(&all).assert().success();
    serde_json::from_slice(&run.get_output().stdout).unwrap()
}

fn positive(row: &Value, key: &str) -> f64 {
    let number = row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"));
    assert!(number > 0.0 && number.is_finite(), "{key} of {row}");
    number
}

/// What every row promises.
fn check(row: &Value) {
    let (median, p95) = (positive(row, "median_ms"), positive(row, "p95_ms"));
    assert!(p95 >= median && (1.0..=7.0).contains(&positive(row, "runs")), "{row}");
    if let Some(ends) = row["median_interval_ms"].as_array() {
        assert!(ends[0].as_f64().unwrap() <= median && ends[1].as_f64().unwrap() >= median);
    }
    let population = positive(row, "population");
    let light_pixels = population * positive(row, "lights") * positive(row, "object_pixels");
    for (key, count) in
        [("evaluations_per_second", population), ("light_pixels_per_second", light_pixels)]
    {
        assert!((positive(row, key) * median / count / 1e3 - 1.0).abs() < 1e-9, "{key} of {row}");
    }
    for key in ["maps_ms", "first_ms", "gflops", "triangles"] {
        positive(row, key);
    }
    if cfg!(target_os = "linux") {
        positive(row, "host_bytes");
    }
    // Wherever tests run, cores compute or a GPU whose data sheet may not be known.
    if !row["ceiling"].is_null() {
        positive(&row["ceiling"], "plain");
        let share = positive(row, "floor_share");
        assert!(share < 2.0, "{row}");
    }
    let native = row["pipeline"] == "native";
    assert!(!native || row["ceiling"].is_object(), "{row}");
    assert_eq!(native, row["threads"].is_u64());
    assert_eq!(native, row["device_bytes"].is_null());
    assert_eq!(native, row["stages_ms"].as_object().unwrap().is_empty());
    if !native {
        positive(row, "device_bytes");
        let stages = row["stages_ms"].as_object().unwrap();
        let sum: f64 = stages.values().map(|time| time.as_f64().unwrap()).sum();
        assert!(sum > 0.0 && positive(row, "gpu_ms") > 0.0, "{row}");
    }
}

#[test]
fn there_is_a_row_for_each_combination() {
    let place = Folder::new();
    let sweep = [
        ["--size", "16x16,24x16"],
        ["--lights", "1,3"],
        ["--population", "4,5"],
        ["--rigs", "uniform,skewed"],
    ];
    let sweep = sweep.as_flattened();
    let bench = bench(&place, &[&["ball.gltf"][..], sweep].concat());
    assert_eq!(bench["schema"], "klieg.bench/2");
    let rows = bench["rows"].as_array().unwrap();
    rows.iter().for_each(check);
    let key = |row: &Value| {
        ["size", "lights", "population", "rigs"].map(|key| row[key].to_string()).join(" ")
    };
    let mut keys: Vec<_> = rows.iter().map(key).collect();
    keys.sort();
    keys.dedup();
    assert_eq!((rows.len(), keys.len()), (16, 16));
}

#[test]
fn the_shadow_table_is_timed() {
    let place = Folder::new();
    let what = ["ball.gltf", "--size", "16x16", "--lights", "1", "--population", "2"];
    for (device, shadows, timed) in
        [("vulkan", "on", true), ("vulkan", "off", false), ("cpu", "on", false)]
    {
        let how = ["--device", device, "--shadows", shadows];
        let bench = bench(&place, &[&what[..], &how].concat());
        let row = &bench["rows"][0];
        check(row);
        assert_eq!(row["shadows_ms"].is_f64(), timed, "{row}");
    }
}

#[test]
fn every_pipeline_and_baseline_is_measured_on_reliefs_and_written() {
    let place = Folder::new();
    let what = ["--triangles", "200,3k", "--instanced", "--size", "24x20", "--population", "2,5"];
    let how = ["--device", "cpu,vulkan", "--pipeline", "layered,forward,compute,auto"];
    let more = ["--baseline", "readback,cpu", "--lights", "1,2", "--out", "out"];
    let bench = bench(&place, &[&what[..], &how, &more].concat());
    let rows = bench["rows"].as_array().unwrap();
    rows.iter().for_each(check);
    let scenes = bench["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), 2);
    for (scene, triangles) in scenes.iter().zip([200.0, 3000.0]) {
        assert_eq!(scene["instances"], 16);
        assert!((positive(scene, "triangles") / triangles - 1.0).abs() < 0.2, "{scene}");
    }
    // Seven ways: native on one core and on all, read-back, four pipelines.
    assert_eq!(rows.len(), 2 * 7 * 4);
    let ways = |pipeline: &str| rows.iter().filter(|row| row["pipeline"] == pipeline).count();
    assert_eq!(["native", "readback", "layered", "forward"].map(ways), [16, 8, 8, 8]);
    assert!(rows.iter().all(|row| row["object_pixels"] == rows[0]["object_pixels"]));
    let alone = rows.iter().filter(|row| row["threads"] == 1).count();
    assert!(alone >= 8);

    let expected = [
        "bench.csv",
        "bench.json",
        "lights.svg",
        "pipelines.svg",
        "population.svg",
        "triangles.svg",
    ];
    assert_eq!(place.list("out"), expected);
    assert_eq!(place.read_json("out/bench.json"), bench);
    let mut table = csv::Reader::from_path(place.path("out/bench.csv")).unwrap();
    let names = table.headers().unwrap().clone();
    let median = names.iter().position(|name| name == "median_ms").unwrap();
    let medians: Vec<f64> =
        table.records().map(|line| line.unwrap()[median].parse().unwrap()).collect();
    let expected: Vec<_> = rows.iter().map(|row| positive(row, "median_ms")).collect();
    assert_eq!(medians, expected);
    for stage in ["forward_ms", "readback_ms", "population_ms", "fitness_ms"] {
        assert!(names.iter().any(|name| name == stage), "{stage}");
    }
}

#[test]
fn the_table_tells_times_costs_and_stages() {
    let place = Folder::new();
    let arguments =
        ["bench", "ball.gltf", "--size", "16x16", "--lights", "2", "--device", "vulkan"];
    let run = place.klieg(&[&arguments[..], &SHORT].concat()).assert().success();
    let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    for part in ["median", "16x16", "evaluations", "object pixels", "fitness", "device"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn wrong_sweeps_are_refused() {
    let place = Folder::new();
    for (arguments, part) in [
        (&["--triangles", "10"][..], "100"),
        (&["--triangles", "200M"], "200M"),
        (&["--triangles", "1k", "ball.gltf"], "--triangles"),
        (&[], "SCENE"),
        (&["ball.gltf", "--instanced"], "--instanced"),
        (&["ball.gltf", "--pipeline", "fast"], "fast"),
        (&["ball.gltf", "--baseline", "jax"], "jax"),
        (&["ball.gltf", "--seconds", "nan"], "seconds"),
        (&["ball.gltf", "--seconds", "1e9"], "seconds"),
        (&["ball.gltf", "--precision", "-1"], "-1"),
        (&["ball.gltf", "--precision", "2"], "precision"),
        (&["ball.gltf", "--runs", "1001"], "1001"),
        (&["ball.gltf", "--device", "no such device"], "no such device"),
        (&["ball.gltf", "--lights", "1,17"], "17"),
        (&["absent.gltf"], "absent.gltf"),
    ] {
        let arguments = [&["bench", "--out", "out"][..], arguments].concat();
        let run = place.klieg(&arguments).assert().code(2);
        let message = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert!(run.get_output().stdout.is_empty());
    }
}

/// The view of `place`'s ball, and the paper's way to measure it.
fn readback(place: &Folder) -> (ReadbackEvaluator, View) {
    let scene = klieg::scene::load::load(&place.path("ball.gltf")).unwrap();
    let camera = frame(&scene, &Framing::default(), 37.0 / 29.0).unwrap();
    let view = View::new(&scene, camera, 37, 29).unwrap();
    let (objective, shading) = (Objective::default(), Shading::default());
    let context = gpu::context();
    (ReadbackEvaluator::new(&context, &scene, &view, objective, shading).unwrap(), view)
}

#[test]
fn the_paper_s_way_gives_the_same_scores() {
    let place = Folder::new();
    let (mut evaluator, view) = readback(&place);
    for (lights, kind) in
        [(1, LightKind::POINT), (3, LightKind::DIRECTIONAL), (16, LightKind::POINT)]
    {
        let rigs = gpu::rigs(5, 4, lights, kind);
        let population = gpu::population(&rigs);
        let mut scores = vec![0.0; rigs.len()];
        evaluator.evaluate(&population, &mut scores).unwrap();
        let maps = evaluator.maps().unwrap().clone();
        let (objective, shading) = (Objective::default(), Shading::default());
        let reference = |rig| klieg::cpu::fitness::fitness(&maps, &view, &objective, &shading, rig);
        let references: Vec<_> = population.rigs().map(reference).collect();
        let far = |scores: &[f32]| {
            scores
                .iter()
                .zip(&references)
                .any(|(score, reference)| (score - reference.score).abs() > 1e-4)
        };
        assert!(!far(&scores), "{lights} lights: {scores:?}");
        let qualities = evaluator.qualities(&population).unwrap();
        assert!(qualities.iter().zip(&scores).all(|(quality, score)| quality.score == *score));
        // Scores of other rigs are not taken for these.
        scores.rotate_left(1);
        assert!(far(&scores));
        let close = evaluator.inspect(&rigs[2]).unwrap();
        assert_eq!(close.score, qualities[2].score);
        let pairs = close.picture.iter().zip(&references[2].picture);
        assert!(pairs.fold(0.0f32, |most, (a, b)| most.max((a - b).abs())) < 1e-3);
    }
    gpu::assert_valid(evaluator.context());
}

#[test]
fn the_paper_s_way_reads_whole_pictures_and_makes_nothing_anew() {
    let place = Folder::new();
    let (mut evaluator, view) = readback(&place);
    let population = gpu::population(&gpu::rigs(1, 6, 2, LightKind::POINT));
    let mut scores = [0.0; 6];
    evaluator.evaluate(&population, &mut scores).unwrap();
    let before = evaluator.context().counters();
    evaluator.evaluate(&population, &mut scores).unwrap();
    let after = evaluator.context().counters();
    let pictures = 6 * 4 * u64::from(view.width * view.height);
    assert_eq!(after.bytes_read - before.bytes_read, pictures);
    let made = |c: klieg::gpu::Counters| (c.allocations, c.pipelines, c.descriptors);
    assert_eq!(made(after), made(before));
    let stages: Vec<_> = evaluator.timings().iter().map(|row| row.0).collect();
    assert_eq!(stages, ["forward", "readback"]);
    gpu::assert_valid(evaluator.context());
}
