//! Small scenes, the view and the rig that they are lit with.

use glam::{DMat4, DQuat, DVec3, Vec3};
use klieg::lighting::{Cone, Light, LightKind, Role};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Instance, Material, Mesh, Scene, Vertex};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Corners of the triangle that every fixture draws.
pub const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 1.0]];

/// A picture of one pixel.
pub fn png() -> Vec<u8> {
    picture(1)
}

fn picture(width: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(width, 1).write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
    bytes.into_inner()
}

/// The triangle's positions.
pub fn positions() -> Vec<u8> {
    CORNERS.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
}

/// A scene of one triangle at the origin; its positions are buffer 0.
pub fn triangle() -> Value {
    json!({
        "asset": { "version": "2.0", "generator": "A generator" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "Triangle" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0.0, 0.0, 0.0], "max": [4.0, 3.0, 1.0],
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36 }],
    })
}

/// The bytes of a GLB.
pub fn glb(root: &Value, binary: Option<&[u8]>) -> Vec<u8> {
    let mut chunks = Vec::new();
    let mut chunk = |kind: &[u8], data: &[u8], padding| {
        let mut data = data.to_vec();
        data.resize(data.len().next_multiple_of(4), padding);
        chunks.extend_from_slice(&(data.len() as u32).to_le_bytes());
        chunks.extend_from_slice(kind);
        chunks.extend(data);
    };
    chunk(b"JSON", root.to_string().as_bytes(), b' ');
    if let Some(binary) = binary {
        chunk(b"BIN\0", binary, 0);
    }
    let length = (chunks.len() as u32 + 12).to_le_bytes();
    [&b"glTF\x02\0\0\0"[..], &length, &chunks].concat()
}

/// JSON and binary chunk of a GLB.
pub fn parse_glb(bytes: &[u8]) -> (Value, Vec<u8>) {
    let glb = gltf::binary::Glb::from_slice(bytes).expect("a GLB");
    assert_eq!(glb.header.length as usize, bytes.len());
    let root = serde_json::from_slice(&glb.json).expect("JSON");
    (root, glb.bin.map(|bin| bin.into_owned()).unwrap_or_default())
}

/// Writes all fixtures into `folder` and gives their paths.
pub fn write_all(folder: &Path) -> Vec<PathBuf> {
    let fixtures = [
        ("plain.glb", glb(&triangle(), Some(&positions()))),
        ("lit.glb", glb(&with_own_lights(), Some(&positions()))),
        ("no-scenes.glb", glb(&without_scenes(), Some(&positions()))),
        ("unknown.glb", glb(&with_unknown_parts(), Some(&positions()))),
        ("files.gltf", with_files(folder).to_string().into_bytes()),
        ("data.gltf", with_data_uri().to_string().into_bytes()),
        ("unused.gltf", with_unused_files(folder).to_string().into_bytes()),
    ];
    fixtures.map(|(name, bytes)| write(folder, name, &bytes)).to_vec()
}

/// Writes a file and gives its path.
pub fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("a file in a temporary folder");
    path
}

fn with_own_lights() -> Value {
    let mut root = triangle();
    root["scenes"] = json!([{ "name": "Other", "nodes": [0] }, { "nodes": [0, 1, 2] }]);
    root["scene"] = 1.into();
    root["nodes"] = json!([
        { "mesh": 0 },
        { "name": "Sun", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "name": "Camera", "camera": 0, "translation": [0, 0, 5] },
    ]);
    root["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    root["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 3 }] } });
    root
}

fn without_scenes() -> Value {
    let mut root = triangle();
    root["nodes"] = json!([{ "mesh": 0 }, { "children": [0], "scale": [1, 1, 1] }]);
    for key in ["scene", "scenes"] {
        root.as_object_mut().expect("an object").remove(key);
    }
    root
}

fn with_unknown_parts() -> Value {
    let mut root = triangle();
    root["extensionsUsed"] = json!(["EXAMPLE_unknown"]);
    root["extensions"] = json!({ "EXAMPLE_unknown": { "z": 1, "a": [0.1, 1e-300, -0.0, "ü"] } });
    // Numbers whose last digit a careless reader gets wrong.
    root["extras"] =
        json!({ "exact": [0.1, 1.7976931348623157e308, 8.41e21, 9007199254740993_u64] });
    root["nodes"][0]["extras"] = json!({ "klieger": 1, "klieg": { "other": 2 } });
    root["meshes"][0]["extensions"] = json!({ "EXAMPLE_unknown": { "bufferView": 0 } });
    root
}

fn with_files(folder: &Path) -> Value {
    // Longer than the buffer, as files may be.
    write(folder, "the triangle.bin", &[positions(), vec![9; 5]].concat());
    write(folder, "second.bin", &[1, 2, 3, 4, 5]);
    write(folder, "ä.png", &png());
    let mut root = triangle();
    root["buffers"] = json!([
        { "uri": "the%20triangle.bin", "byteLength": 36, "name": "first" },
        { "uri": "second.bin", "byteLength": 5 },
        { "uri": "data:application/octet-stream;base64,AQIDBA==", "byteLength": 4 },
    ]);
    let views = root["bufferViews"].as_array_mut().expect("an array");
    views.push(json!({ "buffer": 1, "byteLength": 5 }));
    views.push(json!({ "buffer": 2, "byteLength": 4 }));
    for (view, count) in [(1, 5), (2, 4)] {
        let accessors = root["accessors"].as_array_mut().expect("an array");
        let bytes = json!({ "bufferView": view, "componentType": 5121, "type": "SCALAR" });
        accessors.push(bytes);
        accessors[view]["count"] = count.into();
    }
    root["images"] = json!([{ "uri": "%C3%A4.png", "name": "first" }, { "uri": "ä.png" }]);
    root["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    root
}

/// What stands in the files that nothing in `unused.gltf` uses.
pub const SECRET: &[u8] = b"a secret that no part of the scene uses";

/// The second of three buffers is used, and the last of three images.
pub fn with_unused_files(folder: &Path) -> Value {
    write(folder, "secret.txt", SECRET);
    write(folder, "positions.bin", &positions());
    write(folder, "used.png", &png());
    write(folder, "unused.png", &picture(3));
    let mut root = triangle();
    root["bufferViews"][0]["buffer"] = 1.into();
    root["buffers"] = json!([
        { "uri": "secret.txt", "byteLength": 39, "name": "first" },
        { "uri": "positions.bin", "byteLength": 36 },
        { "uri": "secret.txt", "byteLength": 38 },
    ]);
    let views = root["bufferViews"].as_array_mut().expect("an array");
    views.push(json!({ "buffer": 2, "byteOffset": 4, "byteStride": 4, "byteLength": 34 }));
    root["images"] =
        json!([{ "uri": "unused.png" }, { "uri": "unused.png" }, { "uri": "used.png" }]);
    root["textures"] = json!([{ "source": 2 }]);
    root
}

fn with_data_uri() -> Value {
    let mut root = triangle();
    root["buffers"][0]["uri"] = format!(
        "data:application/octet-stream;base64,{}",
        base64::Engine::encode(&base64::engine::general_purpose::STANDARD, positions())
    )
    .into();
    root
}

/// The triangle, as it is drawn.
pub fn scene() -> Scene {
    let vertex = |position| Vertex { position, ..bytemuck::Zeroable::zeroed() };
    let mesh =
        Mesh { vertices: CORNERS.map(vertex).to_vec(), indices: vec![0, 1, 2], ..Mesh::default() };
    let instance =
        Instance { name: String::new(), mesh: 0, world: DMat4::IDENTITY, first_polygon: 1 };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        instances: vec![instance],
        ..Scene::default()
    }
}

/// Views of the triangle from a place without symmetry.
pub fn views() -> [View; 3] {
    let rotation = DQuat::from_euler(glam::EulerRot::YXZ, 0.7, -0.4, 0.2);
    let camera = |projection, far| Camera {
        name: "klieg camera".into(),
        eye: DVec3::new(6.0, 5.0, 7.0),
        right: rotation * DVec3::X,
        up: rotation * DVec3::Y,
        back: rotation * DVec3::Z,
        projection,
        near: 0.25,
        far,
        designed: None,
    };
    [
        camera(Projection::Perspective { yfov: 0.6 }, Some(40.0)),
        camera(Projection::Perspective { yfov: 0.6 }, None),
        camera(Projection::Orthographic { ymag: 2.5 }, Some(40.0)),
    ]
    .map(|camera| View::new(&scene(), camera, 320, 200).expect("a view"))
}

/// One light of each sort: several of a role, a directional one, one without diffuse light, and coloured
/// spots, aimed at the scene's centre and elsewhere.
pub fn rig() -> Vec<Light> {
    let light = |role, kind, elevation, azimuth, distance, diffuse, specular| Light {
        role,
        kind,
        elevation,
        azimuth,
        distance,
        diffuse,
        specular,
        ..Light::default()
    };
    let (point, directional) = (LightKind::POINT, LightKind::DIRECTIONAL);
    vec![
        light(Role::Key, point, 0.8, -0.5, 2.25, 1.3, 0.7),
        light(Role::Fill, directional, -0.3, 1.1, 1.0, 0.4, 0.1),
        light(Role::Rim, point, 0.2, 3.6, 4.5, 0.0, 0.9),
        light(Role::Fill, point, 1.2, 0.0, 1.5, 0.123_456_79, 0.0),
        Light {
            color: "#ffcc88".parse().expect("a colour"),
            cone: Cone { inner: 0.25, outer: 0.5 },
            ..light(Role::Rim, LightKind::SPOT, 0.6, -2.9, 3.0, 0.75, 0.75)
        },
        Light {
            color: "8000K".parse().expect("a colour"),
            size: 0.25,
            cone: Cone { inner: 0.0, outer: std::f32::consts::FRAC_PI_2 },
            aim: Some(Vec3::new(0.48, -0.6, 0.64)),
            ..light(Role::Fill, LightKind::SPOT, -0.2, 0.4, 2.0, 0.5, 0.1)
        },
    ]
}
