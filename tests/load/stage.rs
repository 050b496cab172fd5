//! Nodes, poses, cameras and lights.

use crate::file::*;
use glam::DVec3;
use klieg::lighting::{Cone, LightKind};
use klieg::scene::Scene;
use klieg::scene::camera::choose;
use klieg::scene::view::Projection;
use serde_json::{Value, json};

/// All corners of a scene.
fn points(scene: &Scene) -> Vec<DVec3> {
    corners(scene).into_iter().flatten().map(DVec3::from).collect()
}

fn assert_points(scene: &Scene, expected: &[[f64; 3]]) {
    let points = points(scene);
    assert_eq!(points.len(), expected.len());
    for (point, &expected) in points.iter().zip(expected) {
        assert!(point.abs_diff_eq(expected.into(), 1e-5), "{points:?}");
    }
}

#[test]
fn hierarchies_of_matrices_and_trs() {
    let mut file = File::square();
    let parent = file
        .push("nodes", json!({"children": [0], "matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 10,0,0,1]}));
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    file.json["nodes"][0]["rotation"] = json!([0, 0, turn, turn]);
    file.json["nodes"][0]["translation"] = json!([0, 0, 1]);
    file.push("scenes", json!({"nodes": [parent]}));
    // (x, y) turns to (−y, x), moves, doubles and moves again.
    let [a, b, c, d] = [[10., 0., 2.], [10., 2., 2.], [8., 0., 2.], [8., 2., 2.]];
    assert_points(&file.scene(), &[a, b, c, c, b, d]);
}

#[test]
fn instances_share_their_mesh() {
    let mut file = File::square();
    file.push("nodes", json!({"mesh": 0, "name": "second", "scale": [-1, 1, 1]}));
    let scene = file.scene();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let firsts: Vec<_> = scene.instances.iter().map(|i| i.first_polygon).collect();
    assert_eq!(firsts, [1, 3]);
    assert_eq!(scene.instances[1].name, "second");
    // The mirrored one still shows its front.
    let [a, b, c] = scene.corners(1, 0);
    assert_eq!((b - a).cross(c - a), DVec3::Z);
}

#[test]
fn the_default_scene_or_the_first_or_all() {
    let mut file = File::square();
    file.push("nodes", json!({"mesh": 0, "translation": [5, 0, 0]}));
    assert_eq!(file.scene().instances.len(), 2, "no scenes: all nodes");
    file.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    assert_eq!(points(&file.scene())[0], DVec3::ZERO, "no default: the first");
    file.json["scene"] = json!(1);
    assert_eq!(points(&file.scene())[0], DVec3::X * 5.0);
}

#[test]
fn what_is_scaled_to_nothing_is_left_out() {
    let mut file = File::square();
    file.push("nodes", json!({"mesh": 0, "scale": [0, 0, 0], "name": "hidden"}));
    let scene = file.scene();
    assert_eq!(scene.instances.len(), 1);
    assert!(scene.warnings[0].contains("'hidden'"), "{:?}", scene.warnings);
}

#[test]
fn a_deep_chain_of_nodes() {
    let mut file = File::square();
    let depth = 100_000;
    let nodes: Vec<Value> = (1..=depth).map(|i| json!({"children": [i - 1]})).collect();
    file.json["nodes"].as_array_mut().unwrap().extend(nodes);
    file.push("scenes", json!({"nodes": [depth]}));
    assert_eq!(file.scene().polygons(), 2);
}

#[test]
fn morph_targets_take_their_default_weights() {
    let mut file = File::square();
    let delta = file.accessor(&floats(&[0., 0., 4.].repeat(4)), "VEC3", F32, 4);
    file.primitive()["targets"] = json!([{"POSITION": delta}, {"POSITION": delta}]);
    assert_eq!(points(&file.scene())[0], DVec3::ZERO);
    file.json["meshes"][0]["weights"] = json!([0.5, 0.0]);
    // The node's weights win; a second node keeps the mesh's.
    file.json["nodes"][0]["weights"] = json!([0.25, 1.0]);
    file.push("nodes", json!({"mesh": 0}));
    let scene = file.scene();
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!(points(&scene)[0], DVec3::Z * 5.0);
    assert_eq!(points(&scene)[6], DVec3::Z * 2.0);
    assert_eq!(scene.warnings, [""; 0]);
}

/// The square held by two joints: the left edge by a resting one, the right one by a lifted one.
fn skinned() -> File {
    let mut file = File::square();
    let joints = file.accessor(&[[0, 0, 0, 0], [1, 0, 0, 0]].repeat(2).concat(), "VEC4", U8, 4);
    let weights = file.accessor(&floats(&[1., 0., 0., 0.].repeat(4)), "VEC4", F32, 4);
    file.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    file.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    let identity = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let mut moved = identity;
    moved[12] = -1.0;
    let bind = file.accessor(&floats(&[identity, moved].concat()), "MAT4", F32, 2);
    // An armature as exporters write it: scaled, and beside it the mesh with a transform of its own.
    file.push("nodes", json!({"children": [2, 3], "scale": [0.01, 0.01, 0.01]}));
    file.push("nodes", json!({}));
    file.push("nodes", json!({"translation": [1, 0, 7]}));
    file.push("skins", json!({"joints": [2, 3], "inverseBindMatrices": bind}));
    file.json["nodes"][0]["skin"] = json!(0);
    file.json["nodes"][0]["translation"] = json!([100, 100, 100]);
    file
}

#[test]
fn skins_stand_as_their_joints_do() {
    let scene = skinned().scene();
    let [a, b, c, d] = [[0., 0., 0.], [0.01, 0., 0.07], [0., 0.01, 0.], [0.01, 0.01, 0.07]];
    assert_points(&scene, &[a, b, c, c, b, d]);
    assert!(scene.meshes[0].vertices.iter().all(|v| v.normal == [0., 0., 1.]));
    assert_eq!(scene.warnings, [""; 0]);
    // A joint that is not there.
    let mut file = skinned();
    file.json["skins"][0]["joints"] = json!([2]);
    let fault = file.fault();
    assert!(fault.contains("joint 1"), "{fault}");
}

fn with_camera(camera: Value) -> File {
    let mut file = File::square();
    file.push("cameras", camera);
    file.push("nodes", json!({"camera": 0, "translation": [0, 0, 5], "scale": [3, 3, 3]}));
    file
}

#[test]
fn cameras_of_both_kinds() {
    let lens = json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}});
    let mut file = with_camera(lens);
    file.push(
        "cameras",
        json!({"name": "flat", "type": "orthographic",
        "orthographic": {"xmag": 4.0, "ymag": 3.0, "znear": 0.0, "zfar": 10.0}}),
    );
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    file.push("nodes", json!({"camera": 1, "rotation": [0, turn, 0, turn]}));
    file.push(
        "nodes",
        json!({"camera": 1, "name": "named",
        "extras": {"klieg": {"camera": {"size": [640, 480]}}}}),
    );
    let scene = file.scene();
    let names: Vec<_> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["camera 0", "flat", "named"]);

    let camera = choose(&scene, "camera 0").unwrap();
    assert_eq!(camera.eye, DVec3::Z * 5.0);
    assert_eq!((camera.right, camera.up, camera.back), (DVec3::X, DVec3::Y, DVec3::Z));
    assert_eq!(camera.projection, Projection::Perspective { yfov: 0.5 });
    assert!((camera.near - 0.1).abs() < 1e-6 && camera.far.is_none());

    let camera = choose(&scene, "1").unwrap();
    assert_eq!(camera.projection, Projection::Orthographic { ymag: 3.0 });
    assert!(camera.back.abs_diff_eq(DVec3::X, 1e-6) && camera.right.abs_diff_eq(-DVec3::Z, 1e-6));
    assert_eq!((camera.near, camera.far), (0.0, Some(10.0)));
    assert_eq!(camera.designed, None);
    assert_eq!(choose(&scene, "named").unwrap().designed.unwrap().size, [640, 480]);

    let message = choose(&scene, "3").unwrap_err().to_string();
    assert!(names.iter().all(|name| message.contains(name)), "{message}");
    assert!(choose(&File::square().scene(), "0").unwrap_err().is_input());
}

#[test]
fn cameras_that_cannot_be_used_are_errors() {
    for (lens, word) in [
        (json!({"yfov": 0.0, "znear": 0.1}), "yfov"),
        (json!({"yfov": 3.2, "znear": 0.1}), "yfov"),
        (json!({"yfov": 1e60, "znear": 0.1}), "yfov"),
        (json!({"yfov": 0.5, "znear": -0.1}), "znear"),
        (json!({"yfov": 0.5, "znear": 1.0, "zfar": 0.5}), "zfar"),
    ] {
        let fault = with_camera(json!({"type": "perspective", "perspective": lens})).fault();
        assert!(fault.contains(word) && fault.contains("node 1"), "{fault}");
    }
    for (lens, word) in [
        (json!({"xmag": 1.0, "ymag": 0.0, "znear": 0.1, "zfar": 1.0}), "ymag"),
        (json!({"xmag": 1.0, "ymag": 1.0, "znear": -1.0, "zfar": 1.0}), "znear"),
        (json!({"xmag": 1.0, "ymag": 1.0, "znear": 1.0, "zfar": 1.0}), "zfar"),
    ] {
        let fault = with_camera(json!({"type": "orthographic", "orthographic": lens})).fault();
        assert!(fault.contains(word), "{fault}");
    }
    assert!(with_camera(json!({"type": "orthographic"})).fault().contains("neither"));
    assert!(with_camera(json!({"type": "fisheye"})).fault().contains("neither"));
}

#[test]
fn lights_of_every_kind() {
    let mut file = File::square();
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "name": "lamp", "extras": {"anything": [1]}},
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 3},
        {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}, "range": 7},
        {"type": "spot", "spot": {}},
    ]}});
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    let block = json!({"light": {"role": "key", "diffuse": 1.5}});
    for (light, name) in [(0, None), (1, Some("sun")), (2, None), (3, None)] {
        let mut node = json!({
            "translation": [1, 2, 3], "rotation": [-turn, 0, 0, turn],
            "extensions": {"KHR_lights_punctual": {"light": light}},
        });
        if let Some(name) = name {
            node["name"] = json!(name);
            node["extras"] = json!({"klieg": block, "other": 1});
        }
        file.push("nodes", node);
    }
    let lights = file.scene().lights;
    let kinds: Vec<_> = lights.iter().map(|light| light.kind).collect();
    assert_eq!(kinds, [LightKind::POINT, LightKind::DIRECTIONAL, LightKind::SPOT, LightKind::SPOT]);
    assert_eq!((lights[2].cone, lights[2].range), (Cone { inner: 0.25, outer: 0.5 }, Some(7.0)));
    assert_eq!((lights[3].cone, lights[3].range), (Cone::default(), None));
    assert_eq!((lights[0].name.as_str(), lights[1].name.as_str()), ("lamp", "sun"));
    assert_eq!((lights[0].color, lights[0].intensity), ([1.0; 3], 1.0));
    assert_eq!((lights[1].color, lights[1].intensity), ([1.0, 0.5, 0.0], 3.0));
    for light in &lights {
        assert_eq!(light.position, DVec3::new(1.0, 2.0, 3.0));
        assert!(light.direction.abs_diff_eq(-DVec3::Y, 1e-6), "{}", light.direction);
    }
    assert_eq!(lights[1].klieg, Some(block));
    assert_eq!(lights[0].klieg, None);
}
