//! The lit scene: what it keeps of the original, and what comes back from it.

mod files;
mod fixtures;
mod own;
mod standing;
mod validator;

use fixtures::{glb, parse_glb, png, positions, rig, scene, triangle, views, write, write_all};
use glam::{DQuat, DVec3};
use klieg::lighting::{Cone, Light, LightKind};
use klieg::math::color::luminance;
use klieg::scene::load::FileAccess::SceneFolder;
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Scene, SceneLight, lights, lit, load};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Lights a file and gives JSON and binary chunk of the result.
fn light(source: &Path, view: &View, rig: &[Light]) -> (Value, Vec<u8>) {
    let out = source.with_file_name("out.glb");
    lit::write(source, SceneFolder, view, rig, &out).expect("a lit scene");
    parse_glb(&std::fs::read(out).expect("the lit scene"))
}

/// Takes the last `count` elements off an array, and the array too when it is empty then.
fn chop(object: &mut Map<String, Value>, key: &str, count: usize) {
    let array = object[key].as_array_mut().expect("an array");
    array.truncate(array.len() - count);
    if array.is_empty() {
        object.remove(key);
    }
}

/// The scene without what klieg has to append for a rig of `lights` lights, if that is all of it.
fn without_klieg(mut root: Value, lights: usize, scene: usize, had_lights: bool) -> Value {
    let object = root.as_object_mut().expect("an object");
    chop(object, "nodes", lights + 1);
    let cameras = object["cameras"].as_array_mut().expect("cameras");
    cameras.remove(0);
    if cameras.is_empty() {
        object.remove("cameras");
    }
    for node in object["nodes"].as_array_mut().into_iter().flatten() {
        if let Some(index) = node["camera"].as_u64() {
            node["camera"] = (index - 1).into();
        }
    }
    let scene = object["scenes"][scene].as_object_mut().expect("a scene");
    scene["nodes"].as_array_mut().expect("nodes").remove(0);
    chop(scene, "nodes", lights);
    let extension = &mut object["extensions"]["KHR_lights_punctual"];
    chop(extension.as_object_mut().expect("an object"), "lights", lights);
    if !had_lights {
        chop(object, "extensionsUsed", 1);
        let extensions = object["extensions"].as_object_mut().expect("an object");
        extensions.remove("KHR_lights_punctual");
        if extensions.is_empty() {
            object.remove("extensions");
        }
    }
    root
}

#[test]
fn the_original_scene_is_unchanged() {
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    for (name, scene) in [("plain.glb", 0), ("lit.glb", 1), ("unknown.glb", 0)] {
        let path = folder.path().join(name);
        let (before, binary_before) = parse_glb(&std::fs::read(&path).expect("a fixture"));
        let (after, binary) = light(&path, &views()[0], &own::with_sun());
        assert_ne!(before, after, "{name}");
        let mut kept = without_klieg(after, rig().len(), scene, name == "lit.glb");
        assert_eq!(kept.to_string(), before.to_string(), "{name}");
        assert_eq!(binary, binary_before, "{name}");
        kept["asset"]["generator"] = "Another".into();
        assert_ne!(kept.to_string(), before.to_string(), "{name}");
    }
}

#[test]
fn a_file_without_scenes_gets_one_of_its_roots() {
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    let (root, _) = light(&folder.path().join("no-scenes.glb"), &views()[0], &rig());
    assert_eq!(root["scenes"], json!([{ "nodes": [8, 1, 2, 3, 4, 5, 6, 7] }]));
    assert_eq!(root["scene"], 0);
}

#[test]
fn files_beside_the_scene_are_taken_in() {
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    let (root, binary) = light(&folder.path().join("files.gltf"), &views()[0], &rig());
    assert_eq!(root["buffers"][0]["name"], "first");
    assert_eq!(root["buffers"][0]["byteLength"].as_u64(), Some(binary.len() as u64));
    assert_eq!(root["buffers"][0].get("uri"), None);
    assert_eq!(binary[..36], positions());
    let second = &root["buffers"][1];
    assert_eq!(second["uri"], "data:application/octet-stream;base64,AQIDBAU=");
    assert_eq!(root["buffers"][2]["uri"], "data:application/octet-stream;base64,AQIDBA==");
    assert_eq!(root["images"][0]["name"], "first");
    for image in root["images"].as_array().expect("images") {
        assert_eq!((image.get("uri"), &image["mimeType"]), (None, &json!("image/png")));
        let view = &root["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
        let number = |key: &str| view[key].as_u64().expect("a number") as usize;
        let (offset, length) = (number("byteOffset"), number("byteLength"));
        assert_eq!((number("buffer"), offset % 4), (0, 0));
        assert_eq!(binary[offset..offset + length], png());
    }
    let (_, binary) = light(&folder.path().join("data.gltf"), &views()[0], &rig());
    assert_eq!(binary, positions());
}

#[test]
fn an_image_alone_makes_the_first_buffer() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "a.png", &png());
    let root = json!({ "asset": { "version": "2.0" }, "nodes": [{}], "images": [{ "uri": "a.png" }],
            "textures": [{ "source": 0 }] });
    let path = write(folder.path(), "a.gltf", root.to_string().as_bytes());
    let (root, binary) = light(&path, &views()[0], &rig());
    assert_eq!(root["images"], json!([{ "mimeType": "image/png", "bufferView": 0 }]));
    assert_eq!(root["buffers"], json!([{ "byteLength": png().len() }]));
    assert_eq!(binary[..png().len()], png());
}

#[test]
fn lighting_again_replaces_the_lights() {
    let folder = tempfile::tempdir().expect("a folder");
    let (one, two) = (folder.path().join("one.glb"), folder.path().join("two.glb"));
    for source in write_all(folder.path()) {
        let write = |source, rig: &[Light], out: &Path| {
            lit::write(source, SceneFolder, &views()[0], rig, out).expect("a lit scene");
            std::fs::read(out).expect("the lit scene")
        };
        let (four, single) = (write(&source, &rig(), &one), write(&source, &rig()[..1], &two));
        assert_ne!(four, single);
        assert_eq!(write(&source, &rig(), &two), four, "{source:?}: not the same bytes");
        assert_eq!(write(&one, &rig(), &two), four, "{source:?}: the same rig again");
        assert_eq!(write(&one, &rig()[..1], &two), single, "{source:?}: a smaller rig");
        assert_eq!(write(&one, &rig(), &one), four, "{source:?}: in place");
    }
}

#[test]
fn klieg_nodes_that_others_moved_leave_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "a.glb", &glb(&triangle(), Some(&positions())));
    let (mut root, binary) = light(&path, &views()[0], &rig()[..2]);
    // Another program appends a node, hangs a klieg light below it, and animates another.
    let nodes = root["nodes"].as_array_mut().expect("nodes");
    nodes.push(json!({ "name": "Later", "children": [2] }));
    root["scenes"][0]["nodes"] = json!([0, 1, 3, 4]);
    root["animations"] = json!([{ "channels": [{ "target": { "node": 1 } }] }]);
    let path = write(folder.path(), "b.glb", &glb(&root, Some(&binary)));
    let (root, _) = light(&path, &views()[0], &rig()[..1]);
    assert_eq!(root["scenes"][0]["nodes"], json!([6, 0, 1, 4, 5]));
    assert_eq!(root["nodes"][4], json!({ "name": "Later" }));
    assert_eq!(
        root["nodes"][2],
        json!({ "name": "klieg fill", "rotation": root["nodes"][2]["rotation"] })
    );
    assert_eq!(root["nodes"][1].get("extensions"), None);
    assert_eq!(root["nodes"][5]["name"], "klieg key");
    assert_eq!(
        root["extensions"]["KHR_lights_punctual"]["lights"].as_array().map(Vec::len),
        Some(1)
    );
    assert_eq!(root["cameras"].as_array().map(Vec::len), Some(1));
}

/// The nodes below a scene's roots that klieg wrote, as the loader gives them.
fn read_back(root: &Value) -> (Vec<SceneLight>, Camera, [u64; 2]) {
    let vector = |node: &Value, key: &str| {
        let values = node[key].as_array().cloned().unwrap_or_default();
        values.iter().map(|value| value.as_f64().expect("a number")).collect::<Vec<_>>()
    };
    let (mut lights, mut found) = (Vec::new(), None);
    for node in root["nodes"].as_array().expect("nodes") {
        let klieg = &node["extras"]["klieg"];
        let translation = vector(node, "translation");
        let position =
            if translation.is_empty() { DVec3::ZERO } else { DVec3::from_slice(&translation) };
        let rotation = vector(node, "rotation");
        let rotation =
            if rotation.is_empty() { DQuat::IDENTITY } else { DQuat::from_slice(&rotation) };
        if klieg.get("light").is_some() {
            let index =
                node["extensions"]["KHR_lights_punctual"]["light"].as_u64().expect("a light");
            let light = &root["extensions"]["KHR_lights_punctual"]["lights"][index as usize];
            lights.push(SceneLight {
                name: node["name"].as_str().expect("a name").into(),
                position,
                direction: rotation * -DVec3::Z,
                kind: LightKind::named(light["type"].as_str().expect("a type")).expect("a kind"),
                cone: light.get("spot").map_or(Cone::default(), |spot| {
                    let angle = |key: &str| spot[key].as_f64().expect("an angle") as f32;
                    Cone { inner: angle("innerConeAngle"), outer: angle("outerConeAngle") }
                }),
                color: light.get("color").map_or([1.0; 3], |color| {
                    [0, 1, 2].map(|i| color[i].as_f64().expect("a channel") as f32)
                }),
                intensity: light["intensity"].as_f64().expect("an intensity") as f32,
                range: None,
                klieg: Some(klieg.clone()),
            });
        } else if klieg.get("camera").is_some() {
            let lens = &root["cameras"][node["camera"].as_u64().expect("a camera") as usize];
            let size = [0, 1].map(|i| klieg["camera"]["size"][i].as_u64().expect("a size"));
            found = Some((camera(node, lens, position, rotation), size));
        }
    }
    let (camera, size) = found.expect("klieg's camera");
    (lights, camera, size)
}

fn camera(node: &Value, lens: &Value, eye: DVec3, rotation: DQuat) -> Camera {
    let values = &lens[lens["type"].as_str().expect("a type")];
    let number = |key: &str| values[key].as_f64().expect("a number");
    Camera {
        name: node["name"].as_str().expect("a name").into(),
        eye,
        right: rotation * DVec3::X,
        up: rotation * DVec3::Y,
        back: rotation * DVec3::Z,
        projection: match lens["type"].as_str() {
            Some("perspective") => {
                assert_eq!(number("aspectRatio"), 1.6);
                Projection::Perspective { yfov: number("yfov") }
            }
            _ => {
                assert_eq!(number("xmag"), 1.6 * number("ymag"));
                Projection::Orthographic { ymag: number("ymag") }
            }
        },
        near: number("znear"),
        far: values.get("zfar").and_then(Value::as_f64),
        designed: None,
    }
}

/// Largest difference of two rigs, the azimuths taken round the circle.
fn difference(a: &[Light], b: &[Light]) -> f32 {
    assert_eq!(a.len(), b.len());
    let of_two = |(a, b): (&Light, &Light)| {
        assert_eq!((a.role, a.kind), (b.role, b.kind));
        let places = (a.direction() - b.direction()).length();
        let axes = (a.axis() - b.axis()).length();
        let [red, green, blue] = [0, 1, 2].map(|i| a.color.linear()[i] - b.color.linear()[i]);
        let cones = [a.cone.inner - b.cone.inner, a.cone.outer - b.cone.outer, a.size - b.size];
        let values = [a.distance - b.distance, a.diffuse - b.diffuse, a.specular - b.specular];
        let all = values.into_iter().chain([axes, red, green, blue]).chain(cones);
        all.map(f32::abs).fold(places, f32::max)
    };
    a.iter().zip(b).map(of_two).fold(0.0, f32::max)
}

#[test]
fn lights_and_camera_come_back() {
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    for view in views() {
        let (root, _) = light(&folder.path().join("lit.glb"), &view, &rig());
        let (lights, camera, size) = read_back(&root);
        let names: Vec<_> = lights.iter().map(|light| light.name.as_str()).collect();
        let expected = ["key", "fill 1", "rim 1", "fill 2", "rim 2", "fill 3"];
        assert_eq!(names, expected.map(|name| format!("klieg {name}")));
        assert_eq!(size, [320, 200]);
        let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-12;
        assert!(near(camera.right, view.camera.right) && near(camera.up, view.camera.up));
        assert!(near(camera.back, view.camera.back) && camera.eye == view.camera.eye);
        assert_eq!(camera.projection, view.camera.projection);
        assert_eq!(root["cameras"].as_array().map(Vec::len), Some(2));
        let first =
            &root["nodes"][root["scenes"][1]["nodes"][0].as_u64().expect("a node") as usize];
        assert_eq!((&first["name"], &first["camera"]), (&json!("klieg camera"), &json!(0)));
        // There is room to move round the scene.
        let (distance, radius) = ((camera.eye - view.frame.center).length(), view.frame.radius);
        assert!(camera.near <= 0.01 * distance, "{camera:?}");
        assert!(camera.far.is_none_or(|far| far >= distance + 10.0 * radius), "{camera:?}");
        let mut lit_scene = Scene { lights, ..scene() };
        let (rig_read, warnings) = lights::rig(&lit_scene, &view).expect("a rig");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(difference(&rig_read, &rig()) < 1e-5, "{rig_read:?}");
        // Brighter by 1 %, or moved by 1 % of the scene's radius, it is another rig.
        lit_scene.lights[0].intensity *= 1.01;
        let (rig_read, _) = lights::rig(&lit_scene, &view).expect("a rig");
        assert!(difference(&rig_read, &rig()) > 1e-2);
        lit_scene.lights[0].intensity /= 1.01;
        lit_scene.lights[0].position.x += 0.01 * view.frame.radius;
        let (rig_read, _) = lights::rig(&lit_scene, &view).expect("a rig");
        assert!(difference(&rig_read, &rig()) > 1e-3);
    }
}

#[test]
fn clipping_planes_that_cut_the_scene_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "a.glb", &glb(&triangle(), Some(&positions())));
    let mut view = views()[0].clone();
    let distance = (view.camera.eye - view.frame.center).dot(view.camera.back);
    view.camera.near = distance;
    let lens = |view: &View| light(&path, view, &rig()).0["cameras"][0]["perspective"].clone();
    assert_eq!(lens(&view)["znear"].as_f64(), Some(distance));
    assert_eq!(lens(&view)["zfar"].as_f64(), view.camera.far);
    // A framing cuts nothing off, as close as its planes may be.
    view.camera.name = "framing".into();
    assert!(lens(&view)["znear"].as_f64() < Some(0.02 * distance));
}

#[test]
fn a_light_with_a_size_tells_its_radius() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "a.glb", &glb(&triangle(), Some(&positions())));
    let view = &views()[0];
    let soft = Light { size: 0.25, ..Light::default() };
    let (root, _) = light(&path, view, &[soft, Light::default()]);
    let lights = &root["extensions"]["KHR_lights_punctual"]["lights"];
    let radius = lights[0]["extras"]["klieg"]["radius"].as_f64().expect("a radius");
    assert!((radius - 0.25 * view.frame.radius).abs() < 1e-6, "{radius}");
    assert_eq!(lights[1].get("extras"), None);
}

#[test]
fn a_lit_file_loads_with_its_rig_and_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out.glb");
    for source in write_all(folder.path()) {
        for view in views() {
            lit::write(&source, SceneFolder, &view, &rig(), &out).expect("a lit scene");
            let mut lit_scene = load::load(&out).expect("the lit scene");
            let is_own = |camera: &&Camera| camera.designed.is_some();
            let cameras: Vec<_> = lit_scene.cameras.iter().filter(is_own).cloned().collect();
            let [camera] = &cameras[..] else { panic!("{cameras:?}") };
            assert_eq!(camera.designed.map(|view| view.size), Some([320, 200]));
            let again = View::new(&lit_scene, camera.clone(), 320, 200).expect("a view");
            assert!(again.clip_from_frame.abs_diff_eq(view.clip_from_frame, 1e-5), "{camera:?}");
            assert!(again.eye.abs_diff_eq(view.eye, 1e-5));
            assert_eq!((camera.near, camera.far), (view.camera.near, view.camera.far));
            let (rig_read, warnings) = lights::rig(&lit_scene, &again).expect("a rig");
            assert!(warnings.is_empty(), "{warnings:?}");
            assert!(difference(&rig_read, &rig()) < 1e-5, "{rig_read:?}");
            for light in &mut lit_scene.lights {
                light.intensity *= 1.01;
            }
            let (rig_read, _) = lights::rig(&lit_scene, &again).expect("a rig");
            assert!(difference(&rig_read, &rig()) > 1e-2);
        }
    }
}

#[test]
fn intensities_are_physical() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "a.glb", &glb(&triangle(), Some(&positions())));
    let view = &views()[0];
    let (root, _) = light(&path, view, &rig());
    let (lights, ..) = read_back(&root);
    for (scene_light, light) in lights.iter().zip(rig()) {
        assert!(scene_light.color.iter().all(|channel| (0.0..=1.0).contains(channel)));
        let luminance = luminance(scene_light.color.into());
        let intensity = f64::from(scene_light.intensity * luminance);
        let illuminance = match light.reach() {
            Some(reach) => {
                let distance = scene_light.position.distance(view.frame.center);
                assert!((distance / view.frame.radius - f64::from(reach)).abs() < 1e-6);
                intensity / distance.powi(2)
            }
            None => intensity,
        };
        let radiance = illuminance / std::f64::consts::PI; // of a white diffuse surface
        assert!((radiance - f64::from(light.diffuse)).abs() < 1e-6, "{radiance} {light:?}");
    }
}

#[test]
fn what_cannot_be_written_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let view = &views()[0];
    let path = write(folder.path(), "a.glb", &glb(&triangle(), Some(&positions())));
    let missing = folder.path().join("missing/out.glb");
    let error = lit::write(&path, SceneFolder, view, &rig(), &missing).expect_err("no such folder");
    assert!(!error.is_input() && error.to_string().contains("out.glb"), "{error}");
    let error = lit::write(&path, SceneFolder, view, &rig(), folder.path()).expect_err("a folder");
    assert!(!error.is_input(), "{error}");

    let out = folder.path().join("out.glb");
    let mut endless = rig();
    endless[0].diffuse = f32::INFINITY;
    let mut central = rig();
    central[0].distance = 0.0;
    let spot = |light: &mut Light| light.kind = LightKind::SPOT;
    let mut hard = rig();
    spot(&mut hard[0]);
    hard[0].cone = Cone { inner: 0.5, outer: 0.5 };
    let mut aimless = rig();
    spot(&mut aimless[0]);
    aimless[0].aim = Some(glam::Vec3::ZERO);
    for rig in [endless, central, hard, aimless] {
        let error = lit::write(&path, SceneFolder, view, &rig, &out).expect_err("a light");
        assert!(error.is_input(), "{error}");
    }
    let broken = |change: &dyn Fn(&mut Value), fault: &str| {
        let mut root = triangle();
        root["buffers"][0]["uri"] = "short.bin".into();
        change(&mut root);
        let source = write(folder.path(), "broken.gltf", root.to_string().as_bytes());
        let error = lit::write(&source, SceneFolder, view, &rig(), &out).expect_err(fault);
        let text = error.to_string();
        assert!(error.is_input() && text.contains("broken.gltf") && text.contains(fault), "{text}");
    };
    broken(&|_| (), "short.bin");
    write(folder.path(), "short.bin", &[0; 35]);
    broken(&|_| (), "35 bytes");
    write(folder.path(), "short.bin", &[0; 36]);
    broken(&|root| root["nodes"] = 1.into(), "nodes");
    broken(&|root| root["scene"] = 7.into(), "scene 7");
    broken(&|root| root["extensions"] = json!([]), "KHR_lights_punctual");
    for bytes in [&b"glTF"[..], b"{", b"[]", b""] {
        let source = write(folder.path(), "bytes.glb", bytes);
        assert!(
            lit::write(&source, SceneFolder, view, &rig(), &out)
                .is_err_and(|error| error.is_input())
        );
    }
    assert!(!out.exists());
    let names = std::fs::read_dir(folder.path()).expect("the folder");
    assert_eq!(names.count(), 4, "a temporary file is left");
}
