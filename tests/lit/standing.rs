//! Rigs that go with klieg's camera.

use crate::fixtures::{glb, parse_glb, positions, rig, triangle, views, write};
use klieg::lighting::Stand;
use klieg::scene::load::{FileAccess, load};
use klieg::scene::{lights, lit};
use serde_json::Value;

#[test]
fn lights_that_go_with_the_camera_are_its_children_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let source = write(folder.path(), "triangle.glb", &glb(&triangle(), Some(&positions())));
    let (view, rig) = (&views()[0], rig());
    let read = |stand: Stand| {
        let out = folder.path().join(format!("{}.glb", stand.name()));
        let standing = (view, &rig[..], stand);
        lit::write_standing(&source, FileAccess::SceneFolder, standing, &out).unwrap();
        (out.clone(), lights::rig(&load(&out).unwrap(), view).unwrap().0)
    };
    let (_, world) = read(Stand::World);
    let (out, camera) = read(Stand::Camera);
    for (a, b) in world.iter().zip(&camera) {
        let near =
            a.direction().distance(b.direction()) < 1e-4 && (a.distance - b.distance).abs() < 1e-4;
        assert!(near && a.axis().distance(b.axis()) < 1e-4, "{a:?} {b:?}");
        assert_eq!(
            (a.role, a.diffuse, a.specular, a.size),
            (b.role, b.diffuse, b.specular, b.size)
        );
    }
    let (root, _) = parse_glb(&std::fs::read(&out).unwrap());
    let nodes = root["nodes"].as_array().unwrap();
    let camera = nodes.iter().find(|node| node["name"] == "klieg camera").unwrap();
    let children: Vec<&Value> = camera["children"].as_array().unwrap().iter().collect();
    assert_eq!(children.len(), rig.len());
    let roots = root["scenes"][0]["nodes"].as_array().unwrap();
    assert!(children.iter().all(|child| !roots.contains(child)));
    // Where the camera moves to, they go.
    let moved = klieg::scene::view::View {
        frame: klieg::math::frame::Frame { center: view.frame.center + 1.0, ..view.frame },
        ..view.clone()
    };
    let mut text = root.clone();
    let place = nodes.iter().position(|node| node["name"] == "klieg camera").unwrap();
    for axis in 0..3 {
        let old = text["nodes"][place]["translation"][axis].as_f64().unwrap();
        text["nodes"][place]["translation"][axis] = (old + 1.0).into();
    }
    let (_, binary) = parse_glb(&std::fs::read(&out).unwrap());
    let path = folder.path().join("moved.glb");
    std::fs::write(&path, glb(&text, Some(&binary))).unwrap();
    let followed = lights::rig(&load(&path).unwrap(), &moved).unwrap().0;
    for (a, b) in world.iter().zip(&followed) {
        assert!(a.direction().distance(b.direction()) < 1e-4, "{a:?} {b:?}");
    }
}

#[test]
fn lighting_again_leaves_nothing_of_a_rig_on_the_camera() {
    let folder = tempfile::tempdir().unwrap();
    let source = write(folder.path(), "triangle.glb", &glb(&triangle(), Some(&positions())));
    let (view, rig) = (&views()[0], rig());
    let [first, again] = ["first.glb", "again.glb"].map(|name| folder.path().join(name));
    let standing = (view, &rig[..], Stand::Camera);
    lit::write_standing(&source, FileAccess::SceneFolder, standing, &first).unwrap();
    lit::write(&first, FileAccess::SceneFolder, view, &rig, &again).unwrap();
    let direct = folder.path().join("direct.glb");
    lit::write(&source, FileAccess::SceneFolder, view, &rig, &direct).unwrap();
    let root = |path| parse_glb(&std::fs::read(path).unwrap()).0;
    assert_eq!(root(&again), root(&direct));
}
