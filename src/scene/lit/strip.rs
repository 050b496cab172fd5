//! Takes out of a scene the lights and the camera that klieg added to it before, and its own lights.
//!
//! Nodes and lights are named by their indices from many places, so only the last elements of these arrays can
//! go; they are klieg's unless another program has rewritten the file. Klieg's nodes further up are emptied and
//! taken out of the node hierarchy.

use super::cameras;
use super::document::Object;
use super::{EXTENSION, EXTRAS};
use serde_json::Value;
use std::collections::BTreeSet;

/// Removes what klieg added to the scene with this root object.
pub fn strip(root: &mut Object) {
    let own = own_nodes(root);
    if own.is_empty() {
        return;
    }
    let pinned = pinned_nodes(root);
    let mut lights = BTreeSet::new();
    let mut own_cameras = BTreeSet::new();
    let mut gone = BTreeSet::new();
    let mut nodes = objects(root, "nodes");
    for &index in &own {
        let node = &mut nodes[index];
        lights.extend(light_of(node));
        own_cameras.extend(node.get("camera").and_then(index_of));
        node.shift_remove("camera");
        remove_within(node, &["extensions", EXTENSION]);
        remove_within(node, &["extras", EXTRAS]);
        // Lights that go with klieg's camera are its children, and stand before it.
        let children = node.get("children").and_then(Value::as_array).into_iter().flatten();
        let alone = children.filter_map(index_of).all(|child| gone.contains(&child));
        if alone && !pinned.contains(&index) {
            gone.insert(index);
        }
    }
    for node in nodes {
        drop_indices(node, "children", &gone);
    }
    for scene in objects(root, "scenes") {
        drop_indices(scene, "nodes", &gone);
    }
    pop(root, "nodes", &gone);
    for node in objects(root, "nodes") {
        if let Some(light) = light_of(node) {
            lights.remove(&light);
        }
        if let Some(camera) = node.get("camera").and_then(index_of) {
            own_cameras.remove(&camera);
        }
    }
    cameras::remove(root, &own_cameras);
    pop_lights(root, &lights);
}

/// Removes all lights of the scene with this root object. Their definitions stay where an animation names
/// one, as its pointer would lead nowhere.
pub fn strip_lights(root: &mut Object) {
    for node in objects(root, "nodes") {
        if light_of(node).is_some() {
            remove_within(node, &["extensions", EXTENSION]);
        }
    }
    if root.get("animations").is_some_and(|all| all.to_string().contains(EXTENSION)) {
        return;
    }
    let lights = root.get("extensions").and_then(|all| all.get(EXTENSION)?.get("lights"));
    let count = lights.and_then(Value::as_array).map_or(0, Vec::len);
    pop_lights(root, &(0..count).collect());
}

/// Indices of the nodes that klieg wrote.
fn own_nodes(root: &Object) -> Vec<usize> {
    let nodes = root.get("nodes").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    // Others may use the name too: a node of klieg's carries what its block tells of, and no mesh.
    let is_own = |node: &Value| {
        let block = &node["extras"][EXTRAS];
        let light = block["light"].is_object() && !node["extensions"][EXTENSION]["light"].is_null();
        let camera = block["camera"].is_object() && !node["camera"].is_null();
        (light || camera) && node.get("mesh").is_none()
    };
    if nodes.iter().any(|node| !node.is_object()) {
        return Vec::new();
    }
    (0..nodes.len()).filter(|&index| is_own(&nodes[index])).collect()
}

/// Nodes that animations and skins name; these have to stay.
fn pinned_nodes(root: &mut Object) -> BTreeSet<usize> {
    let mut pinned = BTreeSet::new();
    for animation in objects(root, "animations") {
        for channel in objects(animation, "channels") {
            let target = channel.get("target").and_then(|target| target.get("node"));
            pinned.extend(target.and_then(index_of));
        }
    }
    for skin in objects(root, "skins") {
        pinned.extend(skin.get("skeleton").and_then(index_of));
        let joints = skin.get("joints").and_then(Value::as_array);
        pinned.extend(joints.into_iter().flatten().filter_map(index_of));
    }
    pinned
}

/// The objects in the array `key`.
fn objects<'a>(object: &'a mut Object, key: &str) -> Vec<&'a mut Object> {
    let array = object.get_mut(key).and_then(Value::as_array_mut);
    array.into_iter().flatten().filter_map(Value::as_object_mut).collect()
}

fn index_of(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// The light that a node carries.
fn light_of(node: &Object) -> Option<usize> {
    index_of(node.get("extensions")?.get(EXTENSION)?.get("light")?)
}

/// Removes `path[1]` from the object `path[0]`, and that too once it is empty.
fn remove_within(object: &mut Object, path: &[&str; 2]) {
    let Some(inner) = object.get_mut(path[0]).and_then(Value::as_object_mut) else { return };
    inner.shift_remove(path[1]);
    if inner.is_empty() {
        object.shift_remove(path[0]);
    }
}

/// Removes `gone` from the array of indices `key`, and that too once it is empty, as glTF has no
/// empty arrays.
fn drop_indices(object: &mut Object, key: &str, gone: &BTreeSet<usize>) {
    let Some(indices) = object.get_mut(key).and_then(Value::as_array_mut) else { return };
    indices.retain(|index| index_of(index).is_none_or(|index| !gone.contains(&index)));
    if indices.is_empty() {
        object.shift_remove(key);
    }
}

/// Removes the last elements of the array `key` as long as they are among `gone`, and the array too
/// once it is empty.
fn pop(object: &mut Object, key: &str, gone: &BTreeSet<usize>) {
    let Some(array) = object.get_mut(key).and_then(Value::as_array_mut) else { return };
    while array.len().checked_sub(1).is_some_and(|last| gone.contains(&last)) {
        array.pop();
    }
    if array.is_empty() {
        object.shift_remove(key);
    }
}

/// [`pop`] for the lights; the last one takes the extension with it.
fn pop_lights(root: &mut Object, gone: &BTreeSet<usize>) {
    let extension = root.get_mut("extensions").and_then(|all| all.get_mut(EXTENSION));
    let Some(extension) = extension.and_then(Value::as_object_mut) else { return };
    pop(extension, "lights", gone);
    if extension.contains_key("lights") {
        return;
    }
    remove_within(root, &["extensions", EXTENSION]);
    for key in ["extensionsUsed", "extensionsRequired"] {
        let Some(names) = root.get_mut(key).and_then(Value::as_array_mut) else { continue };
        names.retain(|name| name != EXTENSION);
        if names.is_empty() {
            root.shift_remove(key);
        }
    }
}
