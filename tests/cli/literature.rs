//! `klieg design --one-by-one` and `--collage`, from the command line to the picture.

use image::RgbaImage;
use klieg_support::common::Folder;
use serde_json::Value;
use std::path::Path;

const SMALL: [&str; 6] = ["--device", "cpu", "--size", "96x96", "--coarse", "0"];

/// Designs the elephant into `out`.
fn design(place: &Folder, out: &str, more: &[&str]) -> Value {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/elephant.glb");
    let arguments = ["design", scene.to_str().unwrap(), "--out", out];
    place.klieg(&[&arguments[..], &SMALL, more].concat()).assert().success();
    place.read_json(&format!("{out}/result.json"))
}

#[test]
fn lights_that_are_added_one_by_one_leave_those_before_as_they_are() {
    let place = Folder::new();
    let weights = "edge=0,hist=0,detail=0,relief=0,direction=0,outline=0,entropy=1";
    let common = ["--weights", weights, "--generations", "12"];
    let key = design(&place, "key", &[&common[..], &["--lights", "key"]].concat());
    let both = design(&place, "both", &[&common[..], &["--one-by-one"]].concat());
    let together = design(&place, "together", &common);
    assert_eq!(both["lights"][0], key["lights"][0]);
    assert_ne!(together["lights"][0], key["lights"][0]);
    let [one, two] = [&key, &both].map(|result| result["generations"].as_u64().unwrap());
    assert!(two > one && both["terms"]["entropy"].as_f64().unwrap() < 1.0, "{both}");
}

/// Encoded brightness of the object's pixels, by their places.
fn brightness(picture: &RgbaImage) -> Vec<f32> {
    picture.pixels().map(|pixel| pixel.0[1].into()).collect()
}

/// Pearson's correlation over the places that both show.
fn correlation(a: &RgbaImage, b: &RgbaImage) -> f32 {
    let shown: Vec<bool> =
        a.pixels().zip(b.pixels()).map(|(a, b)| a.0[3] == 255 && b.0[3] == 255).collect();
    let of = |picture: &RgbaImage| -> Vec<f32> {
        let values = brightness(picture).into_iter().zip(&shown);
        let values: Vec<f32> = values.filter(|(_, shown)| **shown).map(|(i, _)| i).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        values.iter().map(|value| value - mean).collect()
    };
    let (a, b) = (of(a), of(b));
    let dot = |a: &[f32], b: &[f32]| std::iter::zip(a, b).map(|(a, b)| a * b).sum::<f32>();
    dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
}

#[test]
fn a_rig_comes_near_a_collage_and_more_lights_nearer() {
    let place = Folder::new();
    let common = ["--collage", "--background", "transparent", "--generations", "40"];
    let distance = |out: &str| {
        let rows = std::fs::read_to_string(place.path(out).join("convergence.csv")).unwrap();
        let last = rows.lines().last().unwrap().split(',').nth(2).unwrap().to_owned();
        last.parse::<f32>().unwrap()
    };
    design(&place, "two", &common);
    design(&place, "four", &[&common[..], &["--lights", "key,fill,rim,fill"]].concat());
    design(&place, "usual", &["--background", "transparent", "--generations", "15"]);
    let open = |file: &str| image::open(place.path(file)).unwrap().to_rgba8();
    let collage = open("two/collage.png");
    assert_eq!(collage, open("four/collage.png"));
    assert_eq!(collage.dimensions(), (96, 96));
    assert!(distance("four") < distance("two"), "{} {}", distance("four"), distance("two"));
    let [two, usual] =
        ["two", "usual"].map(|out| correlation(&collage, &open(&format!("{out}/best.png"))));
    assert!(two > usual + 0.05, "{two} {usual}");
    assert!(!place.path("usual/collage.png").exists());
}

#[test]
fn what_does_not_go_together_is_refused() {
    let place = Folder::new();
    for (more, said) in [
        (&["--one-by-one", "--alternatives", "2"][..], "--one-by-one goes with"),
        (&["--one-by-one", "--collage"], "--one-by-one goes with"),
        (&["--one-by-one", "--keep", "key", "--first", "three-point"], "does not go with --keep"),
        (&["--collage", "--views", "2"], "look at one view"),
        (&["--collage", "--strokes", "a.png"], "cannot be used with"),
    ] {
        let fault = place.design("out", more).assert().code(2).get_output().stderr.clone();
        let fault = String::from_utf8(fault).unwrap();
        assert!(fault.contains(said), "{more:?}: {fault}");
    }
}
