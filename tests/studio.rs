//! `klieg studio` as a page sees it: pictures, judgements, searches and files.

use klieg::design::{Intent, Mood, profile};
use klieg::lighting::{Light, Role};
use klieg::session::Session;
use klieg::session::config::Settings;
use klieg_support::common::Folder;
use klieg_support::studio::{Page, Said, Server, look, with};
use serde_json::{Value, json};

const BALL: &[&str] = &["ball.gltf"];

/// The largest picture of a quality, and the judgement of that quality.
fn found(said: &[Said], wanted: u32) -> (Option<Vec<u8>>, Option<f64>) {
    let picture = said.iter().rev().find_map(|said| match said {
        Said::Picture { quality, pixels, .. } if *quality == wanted => Some(pixels.clone()),
        _ => None,
    });
    let judged = said.iter().rev().find_map(|said| match said {
        Said::Answer(value) if value["quality"] == wanted => value["score"].as_f64(),
        _ => None,
    });
    (picture, judged)
}

#[test]
fn what_is_shown_is_what_the_command_line_judges() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let terms: Vec<&str> =
        opened["terms"].as_array().unwrap().iter().map(|t| t["name"].as_str().unwrap()).collect();
    assert!(terms.contains(&"detail") && !terms.contains(&"target") && !terms.contains(&"outline"));

    let id = page.send("draw", with(&shown, json!({ "at_rest": true, "rest": [128, 96] })));
    let said = page.drawn(id, 2);
    let (coarse, full, rest) = (found(&said, 0), found(&said, 1), found(&said, 2));
    let full = (full.0.expect("a whole picture"), full.1.expect("its judgement"));
    assert!(coarse.0.is_some() && rest.0.expect("a final picture").len() == 4 * 128 * 96);
    assert!(full.0.chunks_exact(4).any(|pixel| pixel[..3] != [58, 60, 66]), "no object");
    assert!(full.0.chunks_exact(4).all(|pixel| pixel[3] == 255));

    // The same lights, as the command line judges and draws them.
    let save = json!({ "document": with(&shown, json!({ "page": null })) }).to_string();
    let (_, _, lit) = server.request("POST", "/save/glb", save.as_bytes());
    std::fs::write(place.path("lit.glb"), lit).unwrap();
    let output = place.klieg(&["score", "lit.glb", "--json"]).assert().success();
    let score: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let score = score["score"].as_f64().unwrap();
    assert!((score - full.1).abs() < 1e-3, "{score} and {}", full.1);
    let (status, head, rig) = server.request("POST", "/save/rig", save.as_bytes());
    assert!(status == 200 && head.contains("filename=\"ball.rig.json\""), "{head}");
    std::fs::write(place.path("rig.json"), rig).unwrap();
    let render =
        ["render", "ball.gltf", "--out", "rig.png", "--rig", "rig.json", "--size", "64x48"];
    place.klieg(&render).assert().success();
}

#[test]
fn the_newest_request_wins() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let light = |strength: f64| {
        let mut lights = shown["lights"].clone();
        lights[0]["diffuse"] = strength.into();
        json!({ "lights": lights, "at_rest": false })
    };
    let id = page.send("draw", with(&shown, light(1.0)));
    let before = found(&page.drawn(id, 1), 1);
    let mut last = 0;
    for step in 0..400 {
        last = page.send("draw", with(&shown, light(f64::from(step) / 100.0)));
    }
    let said = page.drawn(last, 1);
    let answered = said.iter().filter(|said| matches!(said, Said::Answer(_))).count();
    assert!(answered < 400, "every one of 400 requests was answered");
    let after = found(&said, 1);
    assert!(before.0 != after.0 && before.1 != after.1);
}

#[test]
fn a_new_camera_is_shown_coarse_first() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let mut shown = with(&look(&opened), json!({ "at_rest": false, "size": [256, 192] }));
    for azimuth in [10.0, 60.0] {
        shown["camera"]["azimuth"] = azimuth.into();
        let id = page.send("draw", shown.clone());
        let said = page.drawn(id, 1);
        let sizes: Vec<[u32; 2]> = said
            .iter()
            .filter_map(|said| match said {
                Said::Picture { size, id: of, .. } if *of == id => Some(*size),
                _ => None,
            })
            .collect();
        assert_eq!((sizes.first(), sizes.last()), (Some(&[128, 96]), Some(&[256, 192])));
    }
    // Lights stay where they are in the world.
    let to = with(&shown["camera"], json!({ "azimuth": 240.0 }));
    let request = json!({ "from": shown["camera"], "to": to, "lights": shown["lights"] });
    let moved = page.ask("follow", request, "rig");
    let number = |lights: &Value, axis: usize| lights[0]["direction"][axis].as_f64().unwrap();
    assert!((number(&moved["lights"], 0) + number(&shown["lights"], 0)).abs() < 0.3);
    assert_ne!(moved["lights"], shown["lights"]);
}

#[test]
fn lights_are_placed_and_mapped_where_the_page_points() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let at =
        |x: f64, y: f64| with(&shown, json!({ "pixel": [x, y], "light": 0, "what": "shading" }));
    let picked = page.ask("pick", at(28.0, 24.0), "picked");
    assert_eq!(picked["name"], "large");
    let placed = page.ask("place", at(28.0, 24.0), "placed");
    assert_eq!(placed["lit"]["distance"], shown["lights"][0]["distance"]);
    // The way from the place to the light is its normal.
    let vector = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let (position, normal) = (vector(&picked["position"]), vector(&picked["normal"]));
    let (way, far) =
        (vector(&placed["lit"]["direction"]), placed["lit"]["distance"].as_f64().unwrap());
    let to: Vec<f64> = (0..3).map(|axis| way[axis] * far - position[axis]).collect();
    let length = to.iter().map(|x| x * x).sum::<f64>().sqrt();
    let cosine: f64 = (0..3).map(|axis| to[axis] / length * normal[axis]).sum();
    assert!(cosine > 0.9999, "{cosine}");
    page.ask("place", at(1.0, 1.0), "missed");
    assert_eq!(page.ask("pick", at(1.0, 1.0), "picked")["name"], Value::Null);

    let map = with(&shown, json!({ "light": 0, "columns": 17, "rows": 17 }));
    let mapped = page.ask("map", map.clone(), "mapped");
    let values = mapped["values"].as_array().unwrap();
    let inside: Vec<f64> = values.iter().filter_map(Value::as_f64).collect();
    assert!(values.len() == 17 * 17 && values[0].is_null() && inside.len() > 200);
    let lowest = inside.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = inside.iter().copied().fold(0.0, f64::max);
    assert!(lowest < highest - 0.05, "a level landscape");
    // Other weights make another landscape.
    let mean = with(&map, json!({ "weights": { "mean": 1.0 } }));
    assert_ne!(page.ask("map", mean, "mapped")["values"], mapped["values"]);
}

/// Waits for the end of a search.
fn finished(page: &mut Page, id: u32) -> Value {
    loop {
        let progress = page.until("progress", id);
        if progress["finished"] == true {
            return progress;
        }
    }
}

#[test]
fn a_search_starts_pauses_steps_and_goes_on_from_dragged_lights() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let mut shown = with(&look(&opened), json!({ "at_rest": false }));
    let fault = page.ask("preset", json!({ "name": "design" }), "fault");
    assert!(fault["message"].as_str().unwrap().contains("no search"), "{fault}");
    shown["lights"][1]["locked"] = true.into();
    let first = {
        let id = page.send("draw", shown.clone());
        found(&page.drawn(id, 1), 1).1.unwrap()
    };

    let step = page.ask("search", with(&shown, json!({ "action": "step" })), "progress");
    assert_eq!(step["generation"], 0);
    let step = page.until("progress", page.id);
    assert_eq!((&step["generation"], &step["running"]), (&json!(1), &json!(false)));
    // It goes on where it was, with the lights that it has told.
    let lights = json!({ "lights": step["lights"], "action": "step" });
    let id = page.send("search", with(&shown, lights));
    let next = page.until("progress", id);
    assert_eq!(next["generation"], 1);
    assert_eq!(page.until("progress", id)["generation"], 2);

    // From lights that were dragged it begins anew.
    shown["lights"][0]["direction"] = json!([0.6, 0.7, 0.4]);
    let id = page.send("search", with(&shown, json!({ "action": "start" })));
    assert_eq!(page.until("progress", id)["generation"], 0);
    let end = finished(&mut page, id);
    assert_eq!((&end["running"], &end["lights"][1]), (&json!(false), &shown["lights"][1]));
    let design = page.ask("preset", json!({ "name": "design" }), "rig");
    assert_eq!(design["lights"], end["lights"]);
    let lit = with(&shown, json!({ "lights": end["lights"] }));
    let id = page.send("draw", lit);
    let last = found(&page.drawn(id, 1), 1).1.unwrap();
    assert!(last < first, "{last} after {first}");

    let all = with(&shown, json!({ "lights": [shown["lights"][1]], "action": "start" }));
    let fault = page.ask("search", all, "fault");
    assert!(fault["message"].as_str().unwrap().contains("nothing is left"), "{fault}");
}

#[test]
fn a_paused_search_waits() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let id = page.send("search", with(&shown, json!({ "action": "start" })));
    page.until("progress", id);
    let paused = page.ask("search", with(&shown, json!({ "action": "pause" })), "progress");
    assert_eq!(paused["running"], false);
    // Whatever comes after is of other requests.
    let id = page.send("draw", with(&shown, json!({ "at_rest": false })));
    let said = page.drawn(id, 1);
    let progress =
        |said: &&Said| matches!(said, Said::Answer(value) if value["type"] == "progress");
    assert_eq!(said.iter().filter(progress).count(), 0);
}

#[test]
fn alternatives_come_with_their_thumbnails() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let mut shown = look(&opened);
    shown["lights"][1]["locked"] = true.into();
    let id = page.send("alternatives", with(&shown, json!({ "count": 3 })));
    let (mut rigs, mut thumbnails) = (Vec::new(), Vec::new());
    loop {
        match page.read() {
            Said::Answer(value) if value["type"] == "alternative" => rigs.push(value),
            Said::Picture { id: of, kind: 1, index, .. } if of == id => thumbnails.push(index),
            Said::Answer(value) if value["type"] == "alternatives_done" => break,
            other => panic!("{other:?}"),
        }
    }
    assert!(rigs.len() >= 2 && thumbnails == (0..rigs.len() as u32).collect::<Vec<_>>());
    assert!(rigs.iter().all(|rig| rig["lights"][1] == shown["lights"][1]));
    assert_ne!(rigs[0]["lights"][0], rigs[1]["lights"][0]);
}

#[test]
fn files_are_saved_and_a_session_is_opened_again() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (_, opened) = server.page();
    let wanted = json!({ "brightness": 0.5, "contrast": -1.0, "mood": "dramatic", "below": false });
    let page = json!({ "scene": null, "page": { "history": [1, 2] }, "intent": wanted });
    let document = with(&look(&opened), page);
    let save = |kind: &str, more: Value| {
        let body = with(&json!({ "document": document }), more).to_string();
        server.request("POST", &format!("/save/{kind}"), body.as_bytes())
    };
    let (_, head, glb) = save("glb", json!({}));
    assert!(head.contains("filename=\"ball.lit.glb\""), "{head}");
    let (status, info) = server.post("lit.glb", &glb);
    assert!(status == 200 && info["document"].is_null(), "{info}");
    assert_eq!(info["lights"].as_array().unwrap().len(), 2);
    std::fs::write(place.path("lit.glb"), &glb).unwrap();
    place.klieg(&["score", "lit.glb"]).assert().success();

    let (_, _, session) = save("session", json!({}));
    let (status, info) = server.post("again.glb", &session);
    let again = with(&document, json!({ "scene": info["id"] }));
    assert!(status == 200 && info["document"] == again, "{info}");
    // A lit scene saved of that session has none of it.
    let save_again = json!({ "document": again }).to_string();
    let (_, _, plain) = server.request("POST", "/save/glb", save_again.as_bytes());
    assert!(server.post("plain.glb", &plain).1["document"].is_null());

    let (_, _, png) = save("png", json!({ "width": 80, "height": 60, "samples": 4 }));
    let picture = image::load_from_memory(&png).unwrap();
    assert_eq!((picture.width(), picture.height()), (80, 60));
    for (kind, more) in [
        ("film", json!({})),
        ("png", json!({ "samples": 3 })),
        ("png", json!({ "width": 100_000, "height": 100_000 })),
    ] {
        let (status, _, body) = save(kind, more);
        let body = String::from_utf8(body).unwrap();
        assert!(status == 400 && body.contains("error"), "{status} {body}");
    }
}

#[test]
fn two_pages_do_not_meet() {
    let place = Folder::new();
    let server = Server::start(&place, &[]);
    let (mut empty, opened) = server.page();
    assert!(opened["scene"].is_null() && opened["defaults"]["lights"] == json!([]));
    let scene = std::fs::read(place.path("ball.gltf")).unwrap();
    let (status, info) = server.post("mine.gltf", &scene);
    assert_eq!((status, &info["name"]), (200, &json!("mine.gltf")));
    let mut page = server.connect(&server.token).unwrap();
    let opened = page.ask("open", json!({ "scene": info["id"] }), "opened");
    let shown = with(&look(&opened), json!({ "at_rest": false }));
    let fault = empty.ask("draw", shown.clone(), "fault");
    assert!(fault["message"].as_str().unwrap().contains("no scene"), "{fault}");
    let id = page.send("draw", shown);
    assert!(found(&page.drawn(id, 1), 1).0.is_some());
    let fault = page.ask("open", json!({ "scene": "gone" }), "fault");
    assert!(fault["message"].as_str().unwrap().contains("post it again"), "{fault}");
}

/// The direction upwards of the page's first camera in its light frame.
fn up(shown: &Value) -> [f64; 3] {
    let elevation = shown["camera"]["elevation"].as_f64().unwrap().to_radians();
    [0.0, elevation.cos(), elevation.sin()]
}

/// How far a direction lies above the horizon.
fn rise(direction: &Value, up: [f64; 3]) -> f64 {
    (0..3).map(|axis| direction[axis].as_f64().unwrap() * up[axis]).sum()
}

#[test]
fn what_is_wanted_makes_weights_targets_and_sizes() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let mut shown = look(&opened);
    shown["lights"][1]["locked"] = true.into();
    let plain = shown["intent"].clone();
    assert_eq!(
        plain,
        json!({ "brightness": 0.0, "contrast": 0.0, "mood": "natural", "below": true })
    );
    let number = |value: &Value| value.as_f64().unwrap() as f32;
    let asked = |to: &Value| json!({ "from": plain, "to": to, "lights": shown["lights"] });
    for intent in [
        Intent { mood: Mood::Dramatic, ..Intent::default() },
        Intent { brightness: 1.5, contrast: -1.0, ..Intent::default() },
        Intent { mood: Mood::Soft, below: false, ..Intent::default() },
    ] {
        let to = serde_json::to_value(intent).unwrap();
        let steered = page.ask("steer", asked(&to), "steered");
        let profile = profile::DEFAULT;
        let (mut objective, mut boxes) = ((profile.objective)(), (profile.boxes)());
        intent.steer(&mut objective, &mut boxes).unwrap();
        let weights: Value =
            serde_json::from_str(&serde_json::to_string(&objective.weights).unwrap()).unwrap();
        assert_eq!(steered["weights"], weights);
        assert_eq!(number(&steered["targets"]["stops"]), objective.mean_stops);
        assert_eq!(number(&steered["targets"]["spread"]), objective.spread_target);
        let [key, fill] = [0, 1].map(|light| steered["sizes"][light].as_f64().unwrap());
        let distance = shown["lights"][0]["distance"].as_f64().unwrap();
        let softness = 2.0 * (key / distance).atan().to_degrees();
        assert!((softness - f64::from(boxes.key.softness)).abs() < 1e-3, "{softness}");
        assert_eq!(fill, shown["lights"][1]["size"].as_f64().unwrap(), "it is locked");
    }
    let bright = with(&plain, json!({ "brightness": 3.0 }));
    let fault = page.ask("steer", asked(&bright), "fault");
    assert!(fault["message"].as_str().unwrap().contains("brightness is 3"), "{fault}");
    let fault =
        page.ask("draw", with(&shown, json!({ "intent": bright, "at_rest": false })), "fault");
    assert!(fault["message"].as_str().unwrap().contains("brightness is 3"), "{fault}");
}

#[test]
fn a_page_begins_with_what_the_command_line_wants() {
    let place = Folder::new();
    let plain = Server::start(&place, BALL);
    let moody = Server::start(&place, &["ball.gltf", "--mood", "dramatic", "--no-below"]);
    let ((_, usual), (mut page, opened)) = (plain.page(), moody.page());
    let (defaults, usual) = (&opened["defaults"], &usual["defaults"]);
    assert_eq!(
        (&defaults["intent"]["mood"], &defaults["intent"]["below"]),
        (&json!("dramatic"), &json!(false))
    );
    assert!(defaults["targets"]["stops"].as_f64().unwrap() < -0.8, "{defaults}");
    let size = |lights: &Value| lights[0]["size"].as_f64().unwrap();
    assert!(size(&defaults["lights"]) < 0.5 * size(&usual["lights"]), "{defaults}");
    // What is wanted counts from the settings, not from what was wanted before.
    let to =
        json!({ "from": defaults["intent"], "to": usual["intent"], "lights": defaults["lights"] });
    let back = page.ask("steer", to, "steered");
    assert_eq!((&back["weights"], &back["targets"]), (&usual["weights"], &usual["targets"]));
}

#[test]
fn a_search_stays_in_what_is_wanted() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let share = |page: &mut Page, mood: &str| {
        let intent = with(&shown["intent"], json!({ "mood": mood }));
        let asked = json!({ "from": shown["intent"], "to": intent, "lights": shown["lights"] });
        let steered = page.ask("steer", asked, "steered");
        let wanted = json!({
            "action": "start", "intent": intent,
            "weights": steered["weights"], "targets": steered["targets"],
        });
        let id = page.send("search", with(&shown, wanted));
        let end = finished(page, id);
        let strength = |light: usize| end["lights"][light]["diffuse"].as_f64().unwrap();
        strength(1) / strength(0)
    };
    let [dramatic, soft] = ["dramatic", "soft"].map(|mood| share(&mut page, mood));
    assert!(dramatic <= 0.0601 && (0.4499..=0.9001).contains(&soft), "{dramatic} {soft}");
}

#[test]
fn no_light_is_searched_or_praised_below_the_horizon_where_none_is_wanted() {
    let place = Folder::new();
    // Boxes that only have low places.
    let low = concat!(env!("CARGO_MANIFEST_DIR"), "/tools/intent/low.toml");
    let server = Server::start(&place, &["ball.gltf", "--config", low]);
    let (mut page, opened) = server.page();
    let shown = look(&opened);
    let up = up(&shown);
    let wanted = |below: bool| with(&shown["intent"], json!({ "below": below }));
    let lowest = |page: &mut Page, below: bool| {
        let asked = with(&shown, json!({ "action": "start", "intent": wanted(below) }));
        let id = page.send("search", asked);
        let end = finished(page, id);
        let lights = end["lights"].as_array().unwrap().iter();
        lights.map(|light| rise(&light["direction"], up)).fold(1.0, f64::min)
    };
    assert!(lowest(&mut page, true) < -0.1 && lowest(&mut page, false) > -1e-3);
    // Judged by darkness alone, the best place is behind and below.
    let map = |page: &mut Page, below: bool| {
        let more = json!({
            "light": 0, "columns": 17, "rows": 17, "intent": wanted(below),
            "weights": { "mean": 1.0 }, "targets": { "mean": 0.05, "stops": 0.0, "spread": 0.2 },
        });
        page.ask("map", with(&shown, more), "mapped")
    };
    let (free, bound) = (map(&mut page, true), map(&mut page, false));
    assert!(free["up"].is_null() && (rise(&bound["up"], up) - 1.0).abs() < 1e-5, "{bound}");
    assert!(rise(&free["best"], up) < 0.0 && rise(&bound["best"], up) >= 0.0);
    assert_eq!(free["values"], bound["values"]);
}

/// What the library says of a page's lights, by the wishes of the settings for objects.
fn judged_by_library(place: &Folder, shown: &Value, [focus, dim]: [&[String]; 2]) -> f32 {
    let mut settings = Settings { focus: focus.to_vec(), dim: dim.to_vec(), ..Settings::default() };
    settings.device = "cpu".parse().unwrap();
    settings.view.size = Some("64x48".parse().unwrap());
    let mut session = Session::open(&place.path("ball.gltf"), settings).unwrap();
    let number = |value: &Value| value.as_f64().unwrap() as f32;
    let light = |(light, role): (&Value, Role)| {
        let [x, y, z] = [0, 1, 2].map(|axis| number(&light["direction"][axis]));
        let (elevation, azimuth) = (y.atan2(x.hypot(z)), x.atan2(z));
        let [diffuse, specular, distance] =
            ["diffuse", "specular", "distance"].map(|name| number(&light[name]));
        Light { role, elevation, azimuth, diffuse, specular, distance, ..Light::default() }
    };
    let lights = shown["lights"].as_array().unwrap().iter();
    let rig: Vec<Light> = lights.zip([Role::Key, Role::Fill]).map(light).collect();
    session.evaluator.inspect(&rig).unwrap().score
}

#[test]
fn objects_are_lit_first_or_stay_dim_as_the_library_has_it() {
    let place = Folder::new();
    let server = Server::start(&place, BALL);
    let (mut page, opened) = server.page();
    assert_eq!(opened["scene"]["objects"], json!(["large", "small"]));
    let shown = with(&look(&opened), json!({ "at_rest": false }));
    let (small, large, none) = (vec!["small".to_owned()], vec!["large".to_owned()], Vec::new());
    let mut scores = Vec::new();
    for (focus, dim) in [(&none, &none), (&small, &none), (&none, &large), (&small, &large)] {
        let wished = with(&shown, json!({ "focus": focus, "dim": dim }));
        let id = page.send("draw", wished.clone());
        let score = found(&page.drawn(id, 1), 1).1.unwrap() as f32;
        let library = judged_by_library(&place, &shown, [focus, dim]);
        assert!((score - library).abs() < 1e-3, "{focus:?} {dim:?}: {score} and {library}");
        scores.push(score);
        // The landscape and a search judge so too.
        let map = with(&wished, json!({ "light": 0, "columns": 5, "rows": 5 }));
        let mapped = page.ask("map", map, "mapped");
        let step = page.ask("search", with(&wished, json!({ "action": "step" })), "progress");
        let best = page.until("progress", step["id"].as_u64().unwrap() as u32);
        scores.push(mapped["values"][12].as_f64().unwrap() as f32);
        scores.push(best["best"].as_f64().unwrap() as f32);
    }
    for of in 0..3 {
        let different = |a: usize, b: usize| (scores[3 * a + of] - scores[3 * b + of]).abs() > 1e-4;
        assert!(different(0, 1) && different(0, 2) && different(1, 2), "{of}: {scores:?}");
    }
    let fault = page.ask("draw", with(&shown, json!({ "focus": ["nobody"] })), "fault");
    assert!(fault["message"].as_str().unwrap().contains("no object is named 'nobody'"), "{fault}");
    // What is not seen has no say.
    let mut away = with(&shown, json!({ "focus": small }));
    away["camera"]["target"] = json!([0.0, 0.0, 0.0]);
    away["camera"]["distance"] = 0.4.into();
    let id = page.send("draw", away);
    assert!(found(&page.drawn(id, 1), 1).1.is_some());
}

#[test]
fn a_page_begins_with_the_command_line_s_wishes_for_objects() {
    let place = Folder::new();
    let server = Server::start(&place, &["ball.gltf", "--focus", "sma", "--dim", "LARGE"]);
    let (_, opened) = server.page();
    let defaults = &opened["defaults"];
    assert_eq!((&defaults["focus"], &defaults["dim"]), (&json!(["small"]), &json!(["large"])));
    let mut refused =
        place.klieg(&["studio", "ball.gltf", "--no-open", "--device", "cpu", "--focus", "teapot"]);
    let output = refused.assert().code(2).get_output().clone();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("no object is named 'teapot'"), "{text}");
}
