//! What becomes of the scene's own lights.

use super::fixtures::{glb, parse_glb, positions, rig, triangle, views, write, write_all};
use super::light;
use klieg::lighting::{Cone, Light, LightKind, Role};
use serde_json::{Value, json};

/// The rig with a light of the scene's own.
pub fn with_sun() -> Vec<Light> {
    // What stands in the file already need not be a light that klieg would write.
    let cone = Cone { inner: 1.0, outer: 1.0 };
    let sun = Light { role: Role::Scene, kind: LightKind::SPOT, cone, ..Light::default() };
    [rig(), vec![sun]].concat()
}

#[test]
fn the_scene_s_own_lights_stay_only_where_the_rig_has_them() {
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    let path = folder.path().join("lit.glb");
    let (before, _) = parse_glb(&std::fs::read(&path).expect("a fixture"));
    let lights = |root: &Value| {
        let of_node = |node: &Value| node["extensions"]["KHR_lights_punctual"]["light"].as_u64();
        let nodes = root["nodes"].as_array().expect("nodes");
        let defined = &root["extensions"]["KHR_lights_punctual"]["lights"];
        let used: Vec<_> = nodes.iter().filter_map(of_node).collect();
        (used, defined.as_array().map_or(0, Vec::len))
    };
    assert_eq!(lights(&before), (vec![0], 1));
    let (kept, _) = light(&path, &views()[0], &with_sun());
    assert_eq!(lights(&kept), ((0..7).collect(), 7));
    let (taken, _) = light(&path, &views()[0], &rig());
    assert_eq!(lights(&taken), ((0..6).collect(), 6));
    // The node stays, without its light.
    assert_eq!(taken["nodes"][1], json!({ "name": "Sun" }));
    // What an animation points at stays defined, and lights nothing.
    let mut animated = before;
    let pointer = json!({ "pointer": "/extensions/KHR_lights_punctual/lights/0/intensity" });
    animated["animations"] = json!([{ "channels": [{ "target": {
        "path": "pointer", "extensions": { "KHR_animation_pointer": pointer },
    } }] }]);
    let path = write(folder.path(), "animated.glb", &glb(&animated, Some(&positions())));
    let (taken, _) = light(&path, &views()[0], &rig());
    assert_eq!(lights(&taken), ((1..7).collect(), 7));
}

#[test]
fn nodes_of_the_scene_stay_whatever_their_extras_say() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut root = triangle();
    for block in [json!({ "light": 1 }), json!({ "light": {}, "camera": {} })] {
        root["nodes"][0]["extras"] = json!({ "klieg": block, "other": 2 });
        let path = write(folder.path(), "a.gltf", root.to_string().as_bytes());
        let (after, _) = light(&path, &views()[0], &rig());
        assert_eq!(after["nodes"][0], root["nodes"][0]);
        let roots = after["scenes"][0]["nodes"].as_array().expect("nodes");
        assert!(roots.contains(&json!(0)), "{roots:?}");
    }
}
