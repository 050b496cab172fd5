//! Animations: the moment in which nodes, skins and morph targets are shown.

use crate::file::{F32, File, Folder, U8, corners, floats};
use klieg::scene::Scene;
use klieg::scene::load::{LoadOptions, Moment, load_with};
use serde_json::{Value, json};

/// Loads a file at a moment.
fn shown(file: &File, moment: Moment) -> klieg::Result<Scene> {
    let folder = Folder::new();
    folder.write("scene.glb", &file.glb());
    load_with(&folder.path("scene.glb"), LoadOptions { moment, ..LoadOptions::default() })
}

fn at(animation: &str, time: f32) -> Moment {
    Moment::At { animation: Some(animation.into()), time }
}

/// The square's corner at its origin, at a moment.
fn corner(file: &File, moment: Moment) -> [f64; 3] {
    corners(&shown(file, moment).unwrap())[0][0]
}

/// Gives a file an animation of one channel.
fn animate(
    file: &mut File,
    name: &str,
    times: &[f32],
    values: &[f32],
    channel: (&str, &str, Value),
) {
    let (kind, interpolation, target) = channel;
    let width = if kind == "SCALAR" { 1 } else { kind[3..].parse().unwrap() };
    let input = file.accessor(&floats(times), "SCALAR", F32, times.len());
    let output = file.accessor(&floats(values), kind, F32, values.len() / width);
    file.push(
        "animations",
        json!({"name": name, "channels": [{"sampler": 0, "target": target}], "samplers":
            [{"input": input, "output": output, "interpolation": interpolation}]}),
    );
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn nodes_move_between_key_frames_and_stand_still_outside_them() {
    let mut file = File::square();
    file.json["nodes"][0]["translation"] = json!([9.0, 0.0, 0.0]);
    let target = json!({"node": 0, "path": "translation"});
    let values = [1., 0., 0., 3., 2., 0.];
    animate(&mut file, "line", &[1.0, 3.0], &values, ("VEC3", "LINEAR", target.clone()));
    animate(&mut file, "step", &[1.0, 3.0], &values, ("VEC3", "STEP", target.clone()));
    // In-tangent, value, out-tangent of each key frame.
    let spline = [0., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 3., 2., 0., 0., 0., 0.];
    animate(&mut file, "spline", &[1.0, 3.0], &spline, ("VEC3", "CUBICSPLINE", target));
    for (moment, expected) in [
        (Moment::Rest, [9.0, 0.0, 0.0]),
        (Moment::Start, [1.0, 0.0, 0.0]),
        (Moment::At { animation: None, time: 1.5 }, [1.5, 0.5, 0.0]),
        (at("line", 0.0), [1.0, 0.0, 0.0]),
        (at("line", 2.0), [2.0, 1.0, 0.0]),
        (at("line", 3.0), [3.0, 2.0, 0.0]),
        (at("line", 100.0), [3.0, 2.0, 0.0]),
        (at("step", 2.9), [1.0, 0.0, 0.0]),
        (at("1", 3.0), [3.0, 2.0, 0.0]),
        // At half way 1/2 of both values, and 1/8 of the tangents' difference times 2 s.
        (at("spline", 2.0), [2.0, 1.0, 0.0]),
        // At 1/4: weights 0.84375, 0.140625, 0.15625, -0.046875.
        (at("spline", 1.5), [0.84375 + 0.28125 + 0.46875 - 0.09375, 0.3125, 0.0]),
    ] {
        let found = corner(&file, moment.clone());
        assert!(close(found, expected), "{moment:?}: {found:?}");
    }
}

#[test]
fn rotations_take_the_short_way_round_and_a_matrix_keeps_what_is_not_moved() {
    let mut file = File::square();
    file.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]);
    // A quarter turn about z, the second quaternion negated: still a quarter turn.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let values = [0., 0., 0., 1., 0., 0., -half, -half];
    let target = json!({"node": 0, "path": "rotation"});
    animate(&mut file, "turn", &[0.0, 1.0], &values, ("VEC4", "LINEAR", target));
    for (time, turned) in [(0.0, 0.0f64), (0.5, 45.0), (1.0, 90.0)] {
        let scene = shown(&file, at("turn", time)).unwrap();
        let [origin, second, _] = corners(&scene)[0];
        let (sin, cos) = turned.to_radians().sin_cos();
        assert!(close(origin, [5.0, 0.0, 0.0]), "{origin:?}");
        assert!(close(second, [5.0 + cos, sin, 0.0]), "{time}: {second:?}");
    }
}

/// A square that a joint moves, and that a morph target lifts.
fn puppet() -> File {
    let mut file = File::square();
    let joints = file.accessor(&[0; 16], "VEC4", U8, 4);
    let weights = file.accessor(&floats(&[1., 0., 0., 0.].repeat(4)), "VEC4", F32, 4);
    file.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    file.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    let lift = file.accessor(&floats(&[0., 0., 1.].repeat(4)), "VEC3", F32, 4);
    file.primitive()["targets"] = json!([{"POSITION": lift}]);
    file.json["meshes"][0]["weights"] = json!([0.5]);
    file.push("nodes", json!({"name": "bone"}));
    file.push("skins", json!({"joints": [1]}));
    file.json["nodes"][0]["skin"] = json!(0);
    let target = json!({"node": 1, "path": "translation"});
    animate(&mut file, "walk", &[0.0, 2.0], &[0., 1., 0., 4., 1., 0.], ("VEC3", "LINEAR", target));
    let target = json!({"node": 0, "path": "weights"});
    animate(&mut file, "blink", &[0.0, 1.0], &[1.0, 0.0], ("SCALAR", "LINEAR", target));
    file
}

#[test]
fn skins_and_morph_targets_are_posed() {
    let file = puppet();
    for (moment, expected) in [
        (Moment::Rest, [0.0, 0.0, 0.5]),
        (Moment::Start, [0.0, 1.0, 0.5]),
        (at("walk", 1.0), [2.0, 1.0, 0.5]),
        (at("blink", 0.0), [0.0, 0.0, 1.0]),
        (at("blink", 0.25), [0.0, 0.0, 0.75]),
        (at("blink", 7.0), [0.0, 0.0, 0.0]),
    ] {
        let found = corner(&file, moment.clone());
        assert!(close(found, expected), "{moment:?}: {found:?}");
    }
    assert_eq!(shown(&file, Moment::Start).unwrap().warnings, [""; 0]);
}

#[test]
fn animations_that_are_not_there_or_broken_are_told() {
    let fault = |file: &File, moment| shown(file, moment).unwrap_err().to_string();
    let message = fault(&puppet(), at("run", 0.0));
    assert!(message.contains("'run'") && message.contains("0 'walk', 1 'blink'"), "{message}");
    assert!(fault(&File::square(), at("run", 0.0)).contains("no animations"));
    for time in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(fault(&puppet(), at("walk", time)).contains("time"));
    }
    // One that was not asked for moves nothing.
    let mut file = puppet();
    let samplers = &mut file.json["animations"][0]["samplers"];
    samplers[0]["output"] = samplers[0]["input"].clone();
    assert!(fault(&file, at("walk", 0.0)).contains("'walk'"));
    let scene = shown(&file, Moment::Start).unwrap();
    assert!(close(corners(&scene)[0][0], [0.0, 0.0, 0.5]));
    assert!(scene.warnings[0].contains("first animation cannot be read"), "{:?}", scene.warnings);
    // Nor do those whose channels move no node, as pointers to materials.
    let mut file = puppet();
    file.json["animations"][0]["channels"][0]["target"] = json!({"path": "pointer"});
    assert!(close(corner(&file, Moment::Start), [0.0, 0.0, 0.5]));
}
