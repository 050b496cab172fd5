//! The place of klieg's camera among a file's own: the first one, through which viewers open a file.
//!
//! Only nodes name a camera by its index, and pointers of animations (KHR_animation_pointer). Where there are
//! such pointers, no index changes: the camera is then the last one.

use super::document::{Object, array};
use serde_json::Value;
use std::collections::BTreeSet;

/// Adds a camera and gives its index; `None` where the file's cameras are no array.
pub fn add(root: &mut Object, camera: Value) -> Option<usize> {
    let pointed = has_pointers(root);
    let cameras = array(root, "cameras")?;
    if pointed {
        cameras.push(camera);
        return Some(cameras.len() - 1);
    }
    cameras.insert(0, camera);
    renumber(root, |index| index + 1);
    Some(0)
}

/// Removes cameras that no node names; the array too once it is empty, as glTF has no empty arrays. Where
/// pointers name cameras, those before others stay.
pub fn remove(root: &mut Object, gone: &BTreeSet<usize>) {
    let pointed = has_pointers(root);
    let Some(cameras) = root.get_mut("cameras").and_then(Value::as_array_mut) else { return };
    let mut removed = BTreeSet::new();
    for index in (0..cameras.len()).rev() {
        if gone.contains(&index) {
            cameras.remove(index);
            removed.insert(index);
        } else if pointed {
            break;
        }
    }
    if cameras.is_empty() {
        root.shift_remove("cameras");
    }
    renumber(root, |index| index - removed.range(..index).count());
}

/// Whether any animation names a camera.
fn has_pointers(root: &Object) -> bool {
    root.get("animations").is_some_and(|all| all.to_string().contains("\"/cameras/"))
}

/// Gives the cameras of all nodes other numbers.
fn renumber(root: &mut Object, number: impl Fn(usize) -> usize) {
    let nodes = root.get_mut("nodes").and_then(Value::as_array_mut);
    for node in nodes.into_iter().flatten().filter_map(Value::as_object_mut) {
        let index = node.get("camera").and_then(Value::as_u64);
        if let Some(index) = index.and_then(|index| usize::try_from(index).ok()) {
            node.insert("camera".into(), number(index).into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn root(animations: Value) -> Object {
        let root = json!({
            "cameras": ["a", "b"],
            "nodes": [{ "camera": 1 }, {}, { "camera": 0 }],
            "animations": animations,
        });
        root.as_object().expect("an object").clone()
    }

    #[test]
    fn a_camera_comes_first_and_goes_again() {
        let mut file = root(json!([]));
        assert_eq!(add(&mut file, "klieg".into()), Some(0));
        assert_eq!(file["cameras"], json!(["klieg", "a", "b"]));
        assert_eq!(file["nodes"], json!([{ "camera": 2 }, {}, { "camera": 1 }]));
        remove(&mut file, &BTreeSet::from([0]));
        assert_eq!(file, root(json!([])));
        let mut only = json!({ "cameras": ["klieg"] }).as_object().expect("an object").clone();
        remove(&mut only, &BTreeSet::from([0]));
        assert!(only.is_empty());
    }

    #[test]
    fn where_an_animation_names_a_camera_no_index_changes() {
        let pointer = json!([{ "pointer": "/cameras/1/perspective/yfov" }]);
        let mut file = root(pointer.clone());
        assert_eq!(add(&mut file, "klieg".into()), Some(2));
        assert_eq!(file["nodes"], root(json!([]))["nodes"]);
        remove(&mut file, &BTreeSet::from([2]));
        assert_eq!(file, root(pointer.clone()));
        remove(&mut file, &BTreeSet::from([0]));
        assert_eq!(file, root(pointer));
    }
}
