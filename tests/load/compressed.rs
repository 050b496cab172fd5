//! Meshes that are compressed or instanced, and streams that are broken.

use crate::file::*;
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute,
};
use klieg::scene::load::load;
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    IndexEncoding, VertexEncoding, encode_filter_color, encode_index_buffer, encode_index_sequence,
    encode_vertex_buffer,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;

/// The corners of [`File::square`].
fn square() -> Vec<[[f64; 3]; 3]> {
    corners(&File::square().scene())
}

/// Has a view of `file` stand for the stream `stream`, which decodes to `count` elements of `stride` bytes.
fn compress(file: &mut File, view: usize, name: &str, stream: &[u8], extension: Value) {
    let at = file.view(stream);
    let place = file.json["bufferViews"][at].clone();
    let mut extension = extension;
    for key in ["buffer", "byteOffset", "byteLength"] {
        extension[key] = place[key].clone();
    }
    let length = extension["count"].as_u64().unwrap() * extension["byteStride"].as_u64().unwrap();
    file.json["bufferViews"][view] =
        json!({"buffer": 1, "byteLength": length, "extensions": {name: extension}});
}

/// The square as meshoptimizer packs it, with indices as triangles or as a sequence.
fn packed(name: &str, version: u8, sequence: bool) -> File {
    let mut file = File::square();
    let workspace = &mut Workspace::default();
    for (view, values) in [(0, SQUARE), (1, FRONT)] {
        let encoding = VertexEncoding::new(version, 2).unwrap();
        let stream = encode_vertex_buffer(&floats(&values), 4, 12, encoding, workspace).unwrap();
        let what = json!({"byteStride": 12, "count": 4, "mode": "ATTRIBUTES"});
        compress(&mut file, view, name, &stream, what);
    }
    let indices = [0, 1, 2, 2, 1, 3];
    let encoding = IndexEncoding::new(version).unwrap();
    let (stream, mode) = match sequence {
        true => (encode_index_sequence(&indices, encoding, workspace), "INDICES"),
        false => (encode_index_buffer(&indices, encoding, workspace), "TRIANGLES"),
    };
    let what = json!({"byteStride": 2, "count": 6, "mode": mode, "filter": "NONE"});
    compress(&mut file, 2, name, &stream.unwrap(), what);
    file.json["buffers"] = json!([
        {"byteLength": file.bin.len()},
        {"byteLength": 1000, "extensions": {name: {"fallback": true}}},
    ]);
    file.json["extensionsRequired"] = json!([name]);
    file
}

#[test]
fn meshoptimizers_views_are_decoded() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        for (version, sequence) in [(0, false), (1, false), (1, true)] {
            let file = packed(name, version, sequence);
            let mut found = corners(&file.scene());
            // The codec may turn a triangle round, not over.
            for triangle in &mut found {
                let turns = (0..3).filter(|_| {
                    let is_there = square().contains(triangle);
                    if !is_there {
                        triangle.rotate_left(1);
                    }
                    !is_there
                });
                assert!(turns.count() < 3, "{name} {version} {sequence}");
            }
            assert_eq!(found, square(), "{name} {version} {sequence}");
            assert!(file.scene().warnings.is_empty());
        }
    }
}

#[test]
fn colors_go_through_their_filter() {
    let mut file = packed("KHR_meshopt_compression", 1, false);
    let workspace = &mut Workspace::default();
    let color = [0.25f32, 0.5, 0.75, 1.0].repeat(4);
    let filtered = encode_filter_color(4, 4, 8, &color, workspace).unwrap();
    let encoding = VertexEncoding::DEFAULT;
    let stream = encode_vertex_buffer(&filtered, 4, 4, encoding, workspace).unwrap();
    let accessor = file.accessor(&[0; 16], "VEC4", U8, 4);
    file.json["accessors"][accessor]["normalized"] = json!(true);
    let view = file.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    let what = json!({"byteStride": 4, "count": 4, "mode": "ATTRIBUTES", "filter": "COLOR"});
    compress(&mut file, view, "KHR_meshopt_compression", &stream, what);
    file.json["buffers"][0]["byteLength"] = json!(file.bin.len());
    file.primitive()["attributes"]["COLOR_0"] = json!(accessor);
    let found = file.scene().meshes[0].vertices[0].color;
    for (found, expected) in found.into_iter().zip([64u8, 128, 191, 255]) {
        assert!(found.abs_diff(expected) <= 2, "{found} {expected}");
    }
}

#[test]
fn views_that_claim_too_much_are_refused() {
    let change = |key: &str, value: Value| {
        let mut file = packed("EXT_meshopt_compression", 0, false);
        let view = &mut file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
        view[key] = value;
        file.fault()
    };
    let fault = change("count", json!(1u64 << 40));
    assert!(fault.contains("bufferViews[0]") && fault.contains("more than"), "{fault}");
    let fault = change("byteLength", json!(1u64 << 40));
    assert!(fault.contains("lies outside"), "{fault}");
    let fault = change("buffer", json!(7));
    assert!(fault.contains("buffers[7]"), "{fault}");
    let fault = change("mode", json!("OTHER"));
    assert!(fault.contains("EXT_meshopt_compression"), "{fault}");
    let fault = change("byteStride", json!(3));
    assert!(fault.contains("cannot be decoded"), "{fault}");
    let fault = change("byteLength", json!(5));
    assert!(fault.contains("cannot be decoded"), "{fault}");
}

/// The square as Draco packs it.
fn draco(sequential: bool) -> File {
    let attribute = |kind, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, 3, DataType::Float32, false, 4);
        attribute.buffer_mut().update(&floats(values), None);
        attribute
    };
    let mut mesh = Mesh::new();
    mesh.set_num_points(4);
    mesh.set_num_faces(2);
    mesh.add_attribute(attribute(GeometryAttributeType::Position, &SQUARE));
    mesh.add_attribute(attribute(GeometryAttributeType::Normal, &FRONT));
    mesh.set_faces_from_flat_indices(&[0, 1, 2, 2, 1, 3]);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut options = EncoderOptions::new();
    options.set_encoding_method(i32::from(!sequential));
    let mut stream = EncoderBuffer::new();
    encoder.encode(&options, &mut stream).unwrap();

    let mut file = File::square();
    file.bin.clear();
    file.json["bufferViews"] = json!([]);
    for accessor in file.json["accessors"].as_array_mut().unwrap() {
        accessor.as_object_mut().unwrap().remove("bufferView");
    }
    let view = file.view(stream.data());
    let extension = json!({"bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1}});
    file.primitive()["extensions"] = json!({"KHR_draco_mesh_compression": extension});
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

#[test]
fn dracos_primitives_are_decoded() {
    for sequential in [false, true] {
        let scene = draco(sequential).scene();
        assert_eq!(scene.polygons(), 2);
        let mut area = 0.0;
        for [a, b, c] in corners(&scene) {
            let [a, b, c] = [a, b, c].map(glam::DVec3::from);
            area += (b - a).cross(c - a).z / 2.0;
        }
        assert!((area - 1.0).abs() < 1e-3, "{area}");
        for vertex in &scene.meshes[0].vertices {
            assert!(vertex.normal[2] > 0.99, "{:?}", vertex.normal);
        }
    }
}

#[test]
fn dracos_faults_name_the_primitive() {
    let mut file = draco(false);
    file.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] =
        json!(9);
    let fault = file.fault();
    assert!(
        fault.contains("primitive 0: KHR_draco_mesh_compression") && fault.contains("9"),
        "{fault}"
    );
    let mut file = draco(false);
    file.json["bufferViews"][0]["byteLength"] = json!(30);
    assert!(file.fault().contains("primitive 0: KHR_draco_mesh_compression"));
}

#[test]
fn instances_stand_where_their_attributes_say() {
    let mut file = File::square();
    let translations = file.accessor(&floats(&[1., 0., 0., 0., 5., 0.]), "VEC3", F32, 2);
    let half = (FRAC_PI_2 / 2.0).sin();
    let turns = floats(&[0., 0., 0., 1., 0., 0., half, half]);
    let rotations = file.accessor(&turns, "VEC4", F32, 2);
    let scales = file.accessor(&floats(&[2., 2., 2., 1., 1., 1.]), "VEC3", F32, 2);
    let attributes = json!({"TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales,
        "_COLOR_0": scales});
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    file.json["nodes"][0]["translation"] = json!([0, 0, 7]);
    let scene = file.scene();
    assert_eq!((scene.instances.len(), scene.meshes.len()), (2, 1));
    let found: Vec<[[f64; 3]; 3]> = corners(&scene);
    // The square's corner at (1, 0): doubled and moved, and turned by a right angle and moved.
    for (triangle, expected) in [(0, [3.0, 0.0, 7.0]), (2, [0.0, 6.0, 7.0])] {
        for (found, expected) in found[triangle][1].into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
    // Zeros, for as many instances as a small file may not have.
    let mut many = file.clone();
    for accessor in [translations, rotations, scales] {
        many.json["accessors"][accessor].as_object_mut().unwrap().remove("bufferView");
        many.json["accessors"][accessor]["count"] = json!(1_000_000);
    }
    assert!(many.fault().contains("more vertices and indices than klieg reads"));
    file.json["accessors"][scales]["count"] = json!(1);
    let fault = file.fault();
    assert!(
        fault.contains("node 0: EXT_mesh_gpu_instancing") && fault.contains("differ"),
        "{fault}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is wrong with a stream, there is an answer.
    #[test]
    fn broken_streams_never_panic(
        which in 0..4,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        end in prop::option::weighted(0.5, any::<prop::sample::Index>()),
    ) {
        let mut file = match which {
            0 => packed("EXT_meshopt_compression", 0, false),
            1 => packed("KHR_meshopt_compression", 1, true),
            2 => draco(false),
            _ => draco(true),
        };
        for (at, value) in flips {
            let at = at.index(file.bin.len());
            file.bin[at] = value;
        }
        if let Some(end) = end {
            // What is cut off is zero.
            let end = end.index(file.bin.len());
            file.bin[end..].fill(0);
        }
        let folder = Folder::new();
        folder.write("broken.glb", &file.glb());
        if let Err(error) = load(&folder.path("broken.glb")) {
            prop_assert!(error.is_input() && error.to_string().contains("broken.glb"), "{error}");
        }
    }
}
