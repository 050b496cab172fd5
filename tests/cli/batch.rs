//! `klieg batch`: many designs, what fails among them, and what a second run leaves alone.

use assert_cmd::Command;
use common::{Folder, ball};
use klieg_support::common;
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

const SMALL: [&str; 6] = ["--size", "48x40", "--generations", "3", "--population", "8"];

/// A batch of small designs into `out`.
fn batch(place: &Folder, inputs: &[&str], more: &[&str]) -> Command {
    let mut command = place.klieg(&[&["batch"], inputs, &["--out", "out"], more].concat());
    command.args(SMALL);
    command
}

/// Runs a batch; gives its record, which is what it printed, and what it said besides.
fn run(place: &Folder, inputs: &[&str], more: &[&str], code: i32) -> (Value, String) {
    let mut command = batch(place, inputs, more);
    let output = command.arg("--json").assert().code(code).get_output().clone();
    let record = place.read_json("out/batch.json");
    assert_eq!(record, serde_json::from_slice::<Value>(&output.stdout).unwrap());
    (record, String::from_utf8(output.stderr).unwrap())
}

/// Names and states of all items.
fn states(record: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let items = record["items"].as_array().unwrap().iter();
    items.map(|item| (text(&item["name"]), text(&item["state"]))).collect()
}

fn pairs(expected: &[(&str, &str)]) -> Vec<(String, String)> {
    expected.iter().map(|&(name, state)| (name.to_owned(), state.to_owned())).collect()
}

/// Puts a scene at `name`, its balls in this red.
fn put(place: &Folder, name: &str, red: f64) {
    let mut scene = ball();
    scene["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0] = red.into();
    write(place, name, &scene.to_string());
}

fn write(place: &Folder, name: &str, text: &str) {
    let path = place.path(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

/// Panics unless two folders hold the same design, but for its times.
fn same_design(place: &Folder, design: &str, item: &str) {
    let names: Vec<_> = place.list(item).into_iter().filter(|name| name != "item.json").collect();
    assert_eq!(names, place.list(design));
    for name in names {
        let [a, b] = [design, item].map(|folder| format!("{folder}/{name}"));
        if name == "result.json" {
            let [mut a, mut b] = [a, b].map(|path| place.read_json(&path));
            for result in [&mut a, &mut b] {
                result.as_object_mut().unwrap().remove("timing_ms").unwrap();
            }
            assert_eq!(a, b);
        } else {
            let read = |path: &str| std::fs::read(place.path(path)).unwrap();
            assert!(read(&a) == read(&b), "{name}");
        }
    }
}

#[test]
fn an_item_has_the_bytes_of_a_design() {
    for device in ["cpu", "vulkan"] {
        let place = Folder::new();
        put(&place, "models/a.gltf", 0.2);
        put(&place, "models/deep/er/b.gltf", 0.9);
        let more = ["--device", device, "--lights", "3", "--seed", "7"];
        let (record, said) = run(&place, &["models"], &more, 0);
        assert_eq!(states(&record), pairs(&[("a", "done"), ("deep-er-b", "done")]));
        assert_eq!(said.matches("device: ").count(), 1, "{said}");
        assert_eq!(record["device"]["type"] == "cpu", device == "cpu");
        for (scene, item) in
            [("models/a.gltf", "out/a"), ("models/deep/er/b.gltf", "out/deep-er-b")]
        {
            let design = [&["design", scene, "--out", "design"], &more[..]].concat();
            place.klieg(&design).args(SMALL).assert().success();
            same_design(&place, "design", item);
        }
        let differ = std::panic::catch_unwind(|| same_design(&place, "design", "out/a"));
        assert!(differ.is_err(), "the comparison cannot fail");
    }
}

#[test]
fn the_record_says_how_it_went() {
    let place = Folder::new();
    put(&place, "models/a.gltf", 0.2);
    let (record, _) = run(&place, &["models", "ball.gltf"], &[], 0);
    assert_eq!(record["schema"], "klieg.batch/1");
    assert_eq!(record["klieg"], env!("CARGO_PKG_VERSION"));
    for (key, count) in [("done", 2), ("skipped", 0), ("failed", 0), ("waiting", 0)] {
        assert_eq!(record[key], count, "{key}");
    }
    let rate = record["designs_per_minute"].as_f64().unwrap();
    let minutes = record["milliseconds"].as_f64().unwrap() / 60e3;
    assert!((rate * minutes - 2.0).abs() < 1e-9, "{record}");
    for item in record["items"].as_array().unwrap() {
        let result =
            place.read_json(&format!("out/{}/result.json", item["name"].as_str().unwrap()));
        assert_eq!(item["scene"], result["scene"]);
        assert_eq!(item["score"], result["score"]);
        assert_eq!(item["headlight"], result["headlight"]["score"]);
        assert_eq!(item["milliseconds"], result["timing_ms"]["total"]);
    }
    // People read the same.
    put(&place, "models/b.gltf", 0.4);
    let output = batch(&place, &["models"], &[]).assert().success().get_output().clone();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("1 done, 1 skipped, 0 failed in "), "{text}");
    assert!(text.contains(" designs a minute"), "{text}");
}

#[test]
fn a_failure_does_not_stop_the_rest() {
    let place = Folder::new();
    put(&place, "models/a.gltf", 0.2);
    write(&place, "models/b.gltf", "{\"asset\": {\"version\": \"2.0\"}}");
    write(&place, "models/c.glb", "no glTF");
    put(&place, "models/d.gltf", 0.5);
    let (record, said) = run(&place, &["models", "gone.glb"], &[], 2);
    let expected =
        [("a", "done"), ("b", "failed"), ("c", "failed"), ("d", "done"), ("gone", "failed")];
    // `gone.glb` is named as a scene: it fails as one.
    assert_eq!(states(&record), pairs(&expected));
    assert_eq!((&record["done"], &record["failed"]), (&2.into(), &3.into()));
    assert!(record["items"][2]["reason"].as_str().unwrap().contains("models/c.glb"), "{record}");
    assert!(said.contains("klieg: error: 3 of 5 designs failed"), "{said}");
    for name in ["b", "c", "gone"] {
        assert!(!place.path("out").join(name).exists(), "{name}");
    }
    // A folder that cannot be written to is the machine's fault.
    std::fs::write(place.path("out/models-a"), "").unwrap();
    let (record, _) = run(&place, &["models/a.gltf", "models/c.glb"], &[], 1);
    assert!(record["items"][0]["reason"].as_str().unwrap().contains("cannot write"), "{record}");
    // The item's name follows from the path as it is given.
    assert_eq!(record["items"][0]["name"], "models-a");
}

#[test]
fn a_second_run_makes_only_what_is_missing_or_changed() {
    let place = Folder::new();
    for (name, red) in [("a", 0.2), ("b", 0.5), ("c", 0.8)] {
        put(&place, &format!("models/{name}.gltf"), red);
    }
    let seen = |more: &[&str]| {
        let (record, _) = run(&place, &["models"], more, 0);
        states(&record).into_iter().map(|(_, state)| state).collect::<Vec<_>>()
    };
    assert_eq!(seen(&[]), ["done"; 3]);
    let first = place.read_json("out/batch.json");
    assert_eq!(seen(&[]), ["skipped"; 3]);
    let second = place.read_json("out/batch.json");
    for (a, b) in first["items"].as_array().unwrap().iter().zip(second["items"].as_array().unwrap())
    {
        assert_eq!((&a["score"], &a["headlight"]), (&b["score"], &b["headlight"]));
    }

    // The scene, the result, one of its files, or all of it.
    put(&place, "models/a.gltf", 0.21);
    assert_eq!(seen(&[]), ["done", "skipped", "skipped"]);
    let whole = std::fs::read(place.path("out/b/result.json")).unwrap();
    std::fs::write(place.path("out/b/result.json"), &whole[..whole.len() / 2]).unwrap();
    assert_eq!(seen(&[]), ["skipped", "done", "skipped"]);
    std::fs::remove_file(place.path("out/c/lit.glb")).unwrap();
    assert_eq!(seen(&[]), ["skipped", "skipped", "done"]);
    std::fs::remove_dir_all(place.path("out/c")).unwrap();
    assert_eq!(seen(&[]), ["skipped", "skipped", "done"]);
    // Another design in the same folder.
    let other = ["design", "models/b.gltf", "--out", "out/b", "--seed", "9"];
    place.klieg(&other).args(SMALL).assert().success();
    assert_eq!(seen(&[]), ["skipped", "done", "skipped"]);

    assert_eq!(seen(&["--seed", "4"]), ["done"; 3]);
    assert_eq!(place.read_json("out/a/result.json")["seed"], 4);
    assert_eq!(seen(&["--seed", "4"]), ["skipped"; 3]);
    assert_eq!(seen(&["--seed", "4", "--force"]), ["done"; 3]);
}

#[test]
fn a_change_in_a_file_that_the_scene_names_is_seen() {
    let place = Folder::new();
    let mut scene = ball();
    let uri = scene["buffers"][0]["uri"].as_str().unwrap().to_owned();
    use base64::Engine;
    let data = uri.split_once(',').unwrap().1;
    let mut data = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
    scene["buffers"][0]["uri"] = "ball.bin".into();
    write(&place, "models/ball.gltf", &scene.to_string());
    std::fs::write(place.path("models/ball.bin"), &data).unwrap();
    let state = || states(&run(&place, &["models"], &[], 0).0)[0].1.clone();
    assert_eq!([state(), state()], ["done", "skipped"]);
    data[..4].copy_from_slice(&0.25f32.to_le_bytes());
    std::fs::write(place.path("models/ball.bin"), &data).unwrap();
    assert_eq!([state(), state()], ["done", "skipped"]);
}

#[test]
fn a_list_gives_items_settings_of_their_own() {
    let place = Folder::new();
    put(&place, "lists/models/a.gltf", 0.4);
    let text = "[[item]]\nscene = \"models/a.gltf\"\nazimuth = -40\nelevation = 20.0\n\n\
                [[item]]\nscene = \"models/a.gltf\"\nname = \"other\"\nsize = \"32x24\"\nseed = 5\n\
                lights = [\"key\", \"rim\"]\nkind = \"directional\"\n\n\
                [[item]]\nscene = \"models/a.gltf\"\n\n\
                [[item]]\nscene = \"models/../models/a.gltf\"\n";
    write(&place, "lists/all.toml", text);
    let (record, _) = run(&place, &["lists/all.toml"], &[], 0);
    let names = ["models-a-azimuth-40-elevation20", "other", "models-a"];
    // The last item is the third once more.
    assert_eq!(states(&record), names.map(|name| (name.to_owned(), "done".to_owned())));
    let other = place.read_json("out/other/result.json");
    assert_eq!((&other["size"], &other["seed"]), (&serde_json::json!([32, 24]), &5.into()));
    assert_eq!(
        (&other["lights"][1]["role"], &other["lights"][1]["kind"]),
        (&"rim".into(), &"directional".into())
    );
    let design = ["design", "lists/models/a.gltf", "--out", "design"];
    let view = ["--azimuth", "-40", "--elevation", "20"];
    place.klieg(&design).args(view).args(SMALL).assert().success();
    same_design(&place, "design", &format!("out/{}", names[0]));

    write(&place, "lists/all.txt", "# the same\r\n\r\nmodels/a.gltf\r\n");
    let (record, _) = run(&place, &["lists/all.txt"], &[], 0);
    assert_eq!(states(&record), pairs(&[("models-a", "skipped")]));
}

#[test]
fn lists_and_folders_with_faults_are_refused_before_any_work() {
    let place = Folder::new();
    std::fs::create_dir(place.path("empty")).unwrap();
    write(&place, "no.txt", "\n# nothing\n");
    write(&place, "what.bin", "");
    let item = |rest: &str| {
        format!("[[item]]\nscene = \"ball.gltf\"\n\n[[item]]\nscene = \"ball.gltf\"\n{rest}\n")
    };
    for (list, text, parts) in [
        ("key.toml", item("azimut = 3"), ["key.toml", "line 6", "azimut"]),
        ("top.toml", format!("out = 3\n{}", item("")), ["top.toml", "line 1", "out"]),
        ("value.toml", item("size = \"0x5\""), ["value.toml", "line 6", "0x5"]),
        ("range.toml", item("elevation = 91.0"), ["range.toml", "line 4", "elevation"]),
        ("both.toml", item("camera = 0\nfov = 35.0"), ["both.toml", "line 4", "camera"]),
        ("name.toml", item("name = \"../up\""), ["name.toml", "line 4", "../up"]),
        ("scene.toml", "[[item]]\nseed = 3\n".into(), ["scene.toml", "line 1", "scene"]),
        ("none.toml", "item = []\n".into(), ["none.toml", "no scene", ""]),
    ] {
        write(&place, list, &text);
        let output = batch(&place, &[list], &[]).assert().code(2).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        for part in parts {
            assert!(message.contains(part), "{list}: {message}");
        }
    }
    for (input, part) in [
        ("empty", "no .gltf, .glb, .ply, .stl or .obj file"),
        ("absent", "not found"),
        ("absent.toml", "absent.toml"),
        ("no.txt", "no scene"),
        ("what.bin", "neither"),
    ] {
        let output = batch(&place, &[input], &[]).assert().code(2).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(input) && message.contains(part), "{message}");
    }
    batch(&place, &["ball.gltf"], &["--elevation", "91"]).assert().code(2);
    batch(&place, &["ball.gltf"], &["--device", "no such device"]).assert().code(2);
    assert!(!place.path("out").exists());
    batch(&place, &[], &[]).assert().code(2);
}

#[test]
fn names_do_not_collide() {
    let place = Folder::new();
    for name in
        ["m/x.gltf", "m/x.GLTF", "m/a/b.gltf", "m/a-b.gltf", "m/batch.json.gltf", "m/A/B.gltf"]
    {
        put(&place, name, 0.5);
    }
    write(&place, "m/.hidden.gltf", "");
    write(&place, "m/.git/x.gltf", "");
    let (record, _) = run(&place, &["m"], &[], 0);
    let mut names: Vec<String> = states(&record).into_iter().map(|(name, _)| name).collect();
    let all = names.len();
    names.sort();
    names.dedup_by_key(|name| name.to_lowercase());
    assert_eq!((names.len(), all), (6, 6), "{record}");
    assert!(names.contains(&"batch.json-2".into()), "{names:?}");
    for item in record["items"].as_array().unwrap() {
        let result =
            place.read_json(&format!("out/{}/result.json", item["name"].as_str().unwrap()));
        assert_eq!(result["scene"], item["scene"]);
    }
    let (again, _) = run(&place, &["m"], &[], 0);
    assert_eq!(again["skipped"], 6);
}

#[test]
fn the_results_are_no_scenes_of_the_next_run() {
    let place = Folder::new();
    put(&place, "out/models/a.gltf", 0.5);
    let message = batch(&place, &["out"], &[]).assert().code(2).get_output().clone();
    assert!(String::from_utf8(message.stderr).unwrap().contains("another --out"));
    std::fs::rename(place.path("out/models"), place.path("models")).unwrap();
    for state in ["done", "skipped"] {
        let mut command = place.klieg(&["batch", "models", "--out", "models/lit", "--json"]);
        let output = command.args(SMALL).assert().success().get_output().clone();
        let record: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(states(&record), pairs(&[("a", state)]));
    }
    // A scene is never overwritten by its own lit one.
    let before = std::fs::read(place.path("models/lit/a/lit.glb")).unwrap();
    write(&place, "own.toml", "[[item]]\nscene = \"models/lit/a/lit.glb\"\nname = \"a\"\n");
    let mut command = place.klieg(&["batch", "own.toml", "--out", "models/lit", "--json"]);
    command.args(SMALL).assert().code(2);
    assert_eq!(std::fs::read(place.path("models/lit/a/lit.glb")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_their_loops_end() {
    let place = Folder::new();
    put(&place, "models/a.gltf", 0.5);
    put(&place, "elsewhere/b.gltf", 0.5);
    let link =
        |to: &str, at: &str| std::os::unix::fs::symlink(place.path(to), place.path(at)).unwrap();
    link("models", "models/loop");
    link("elsewhere", "models/more");
    link("models", "elsewhere/back");
    link("models/a.gltf", "models/z.gltf");
    let (record, _) = run(&place, &["models"], &[], 0);
    assert_eq!(states(&record), pairs(&[("a", "done"), ("more-b", "done")]));
}

/// Names of all files below a folder that are not in their final place.
fn hidden(folder: &Path) -> Vec<String> {
    common::list(folder).into_iter().filter(|name| name.starts_with('.')).collect()
}

/// Ctrl-C: finished designs stay, the running one leaves nothing, and the next run goes on.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_finished_designs() {
    let place = Folder::new();
    put(&place, "models/a.gltf", 0.5);
    let text = "[[item]]\nscene = \"models/a.gltf\"\nname = \"quick\"\nsize = \"8x8\"\n\
                [[item]]\nscene = \"models/a.gltf\"\nname = \"slow\"\nsize = \"2048x2048\"\n\
                [[item]]\nscene = \"ball.gltf\"\nname = \"never\"\n";
    write(&place, "list.toml", text);
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("klieg"))
        .current_dir(place.path(""))
        .args(["batch", "list.toml", "--out", "out", "--device", "cpu", "--generations", "400"])
        .args(["--optimizer", "ga"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    while !place.path("out/quick/item.json").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(500));
    let interrupt = ["-INT", &child.id().to_string()];
    assert!(std::process::Command::new("kill").args(interrupt).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let record = place.read_json("out/batch.json");
    let expected = [("quick", "done"), ("slow", "waiting"), ("never", "waiting")];
    assert_eq!(states(&record), pairs(&expected));
    assert_eq!(place.list("out"), ["batch.csv", "batch.json", "index.html", "quick"]);
    assert!(hidden(&place.path("out/quick")).is_empty());
    place.read_json("out/quick/result.json");

    let again = ["batch", "list.toml", "--out", "out", "--generations", "400", "--json"];
    let again = [&again[..], &["--optimizer", "ga"]].concat();
    write(
        &place,
        "list.toml",
        &text.replace("2048x2048", "9x9").replace("\"never\"", "\"never\"\nsize = \"8x8\""),
    );
    let output = place.klieg(&again).assert().success().get_output().clone();
    let record: Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = [("quick", "skipped"), ("slow", "done"), ("never", "done")];
    assert_eq!(states(&record), pairs(&expected));
}

#[test]
fn shards_share_the_work_and_a_run_without_makes_the_whole_record() {
    let place = Folder::new();
    ["a", "b", "c"].iter().for_each(|name| put(&place, &format!("in/{name}.gltf"), 0.5));
    for (shard, made) in [("1/2", &["a", "c"][..]), ("array/2", &["b"])] {
        let mut command = batch(&place, &["in"], &["--shard", shard, "--device", "cpu", "--json"]);
        let output =
            command.env("JOB_COMPLETION_INDEX", "1").assert().success().get_output().clone();
        let record: Value = serde_json::from_slice(&output.stdout).unwrap();
        let made: Vec<_> = made.iter().map(|&name| (name, "done")).collect();
        assert_eq!(states(&record), pairs(&made));
    }
    let record = place.read_json("out/batch-2-of-2.json");
    assert_eq!(states(&record), pairs(&[("b", "done")]));
    assert!(!place.path("out/batch.json").exists());

    let (record, _) = run(&place, &["in"], &["--device", "cpu"], 0);
    assert_eq!(states(&record), pairs(&["a", "b", "c"].map(|name| (name, "skipped"))));
    let table = std::fs::read_to_string(place.path("out/batch.csv")).unwrap();
    assert_eq!(table.lines().count(), 4);
    let page = std::fs::read_to_string(place.path("out/index.html")).unwrap();
    assert!(page.contains("3 of 3 designs") && page.contains("src=\"b/best.png\""));

    let refused = |shard: &str| batch(&place, &["in"], &["--shard", shard]).assert().code(2);
    ["0/2", "3/2", "2"].into_iter().for_each(|shard| drop(refused(shard)));
}
