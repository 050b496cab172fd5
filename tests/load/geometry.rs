//! Containers, accessors, primitives, normals and tangents.

use crate::file::*;
use base64::Engine;
use klieg::scene::{Mesh, Vertex};
use serde_json::json;

const A: [f64; 3] = [0., 0., 0.];
const B: [f64; 3] = [1., 0., 0.];
const C: [f64; 3] = [0., 1., 0.];
const D: [f64; 3] = [1., 1., 0.];

#[test]
fn every_container_gives_the_same_scene() {
    let file = File::square();
    let expected = vec![[A, B, C], [C, B, D]];
    assert_eq!(corners(&file.scene()), expected);

    let folder = Folder::new();
    folder.write("parts/my buffer.bin", &file.bin);
    let external = folder.load("scene.gltf", &file.gltf("parts/my%20buffer.bin")).unwrap();
    assert_eq!(corners(&external), expected);

    let data = base64::engine::general_purpose::STANDARD.encode(&file.bin);
    let uri = format!("data:application/octet-stream;base64,{data}");
    assert_eq!(corners(&folder.load("data.gltf", &file.gltf(&uri)).unwrap()), expected);
    // The content tells the container, not the name; a byte order mark does no harm.
    let marked = [b"\xef\xbb\xbf", &file.gltf(&uri)[..]].concat();
    assert_eq!(corners(&folder.load("data.glb", &marked).unwrap()), expected);
}

#[test]
fn all_index_types_and_none() {
    let indices: [u8; 6] = [0, 1, 2, 2, 1, 3];
    let expected = corners(&File::square().scene());
    for (component, bytes) in [
        (U8, indices.to_vec()),
        (U32, indices.iter().flat_map(|&i| u32::from(i).to_le_bytes()).collect()),
    ] {
        let mut file = File::square();
        let accessor = file.accessor(&bytes, "SCALAR", component, 6);
        file.primitive()["indices"] = json!(accessor);
        assert_eq!(corners(&file.scene()), expected);
    }
    let mut file = File::square();
    file.primitive().as_object_mut().unwrap().remove("indices");
    assert_eq!(corners(&file.scene()), [[A, B, C]], "the fourth vertex makes no triangle");
}

#[test]
fn strips_and_fans() {
    let mut file = File::square();
    file.primitive().as_object_mut().unwrap().remove("indices");
    file.primitive()["mode"] = json!(5);
    assert_eq!(corners(&file.scene()), [[A, B, C], [B, D, C]]);
    file.primitive()["mode"] = json!(6);
    assert_eq!(corners(&file.scene()), [[B, C, A], [C, D, A]]);

    let mut file = File::square();
    let stitched = file.accessor(&shorts(&[0, 1, 2, 2, 2, 1, 3]), "SCALAR", U16, 7);
    file.primitive()["indices"] = json!(stitched);
    file.primitive()["mode"] = json!(5);
    assert_eq!(corners(&file.scene()), [[A, B, C], [C, B, D]], "stitches are dropped");
}

#[test]
fn points_and_lines_are_left_out_with_one_warning() {
    let mut file = File::square();
    for mode in [0, 1, 2, 3] {
        let mut primitive = file.primitive().clone();
        primitive["mode"] = json!(mode);
        file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    let scene = file.scene();
    assert_eq!(scene.polygons(), 2);
    assert_eq!(scene.warnings, ["4 primitives of points or lines are left out"]);
}

#[test]
fn sparse_accessors_over_data_and_over_zeros() {
    for with_data in [true, false] {
        let mut file = File::square();
        let indices = file.view(&[1, 3]);
        let values = file.view(&floats(&[2., 0., 0., 3., 3., 3.]));
        file.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        if !with_data {
            file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        }
        let c = if with_data { C } else { A };
        let (b, d) = ([2., 0., 0.], [3., 3., 3.]);
        assert_eq!(corners(&file.scene()), [[A, b, c], [c, b, d]]);
    }
}

#[test]
fn interleaved_attributes() {
    let mut file = File::square();
    let row = |i: usize| floats(&[&SQUARE[3 * i..][..3], &FRONT[3 * i..][..3]].concat());
    let view = file.view(&(0..4).flat_map(row).collect::<Vec<_>>());
    file.json["bufferViews"][view]["byteStride"] = json!(24);
    for (accessor, offset) in [(0, 0), (1, 12)] {
        file.json["accessors"][accessor]["bufferView"] = json!(view);
        file.json["accessors"][accessor]["byteOffset"] = json!(offset);
    }
    let scene = file.scene();
    assert_eq!(corners(&scene), [[A, B, C], [C, B, D]]);
    assert!(scene.meshes[0].vertices.iter().all(|v| v.normal == [0., 0., 1.]));
}

#[test]
fn quantised_attributes() {
    // Positions of signed shorts with padding; the node scales them back.
    for (normalized, scale) in [(false, 1e-3), (true, 32.767)] {
        let mut file = File::square();
        let shorts: Vec<u8> = SQUARE
            .chunks(3)
            .flat_map(|p| [p[0], p[1], p[2], 0.0].map(|v| (v * 1000.0) as i16))
            .flat_map(i16::to_le_bytes)
            .collect();
        let position = file.accessor(&shorts, "VEC3", I16, 4);
        file.json["bufferViews"][position]["byteStride"] = json!(8);
        file.json["accessors"][position]["normalized"] = json!(normalized);
        file.primitive()["attributes"]["POSITION"] = json!(position);
        let normal = file.accessor(&[0, 0, 127, 0].repeat(4), "VEC3", I8, 4);
        file.json["bufferViews"][normal]["byteStride"] = json!(4);
        file.json["accessors"][normal]["normalized"] = json!(true);
        file.primitive()["attributes"]["NORMAL"] = json!(normal);
        file.json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let scene = file.scene();
        for (corner, expected) in corners(&scene).iter().flatten().zip([A, B, C, C, B, D]) {
            for (value, expected) in corner.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-6, "{corner:?} is not {expected:?}");
            }
        }
        assert!(scene.meshes[0].vertices.iter().all(|v| v.normal == [0., 0., 1.]));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[test]
fn vertex_colours_of_every_type() {
    let white = File::square().scene();
    assert!(white.meshes[0].vertices.iter().all(|v| v.color == [255; 4]));
    let cases: [(&str, u32, Vec<u8>, [u8; 4]); 4] = [
        ("VEC3", F32, floats(&[1.0, 0.5, 0.0].repeat(4)), [255, 128, 0, 255]),
        ("VEC4", F32, floats(&[2.0, -1.0, 0.2, 0.4].repeat(4)), [255, 0, 51, 102]),
        ("VEC4", U8, [1, 2, 3, 4].repeat(4), [1, 2, 3, 4]),
        ("VEC4", U16, shorts(&[65535, 0, 257, 514].repeat(4)), [255, 0, 1, 2]),
    ];
    for (kind, component, bytes, expected) in cases {
        let mut file = File::square();
        let color = file.accessor(&bytes, kind, component, 4);
        file.json["accessors"][color]["normalized"] = json!(component != F32);
        file.primitive()["attributes"]["COLOR_0"] = json!(color);
        assert_eq!(file.scene().meshes[0].vertices[3].color, expected);
    }
}

#[test]
fn missing_normals_are_flat() {
    let mut file = File::new();
    // Two triangles that share an edge at a right angle.
    let position =
        file.accessor(&floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]), "VEC3", F32, 4);
    let indices = file.accessor(&[0, 1, 2, 0, 2, 3], "SCALAR", U8, 6);
    file.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let mesh = &file.scene().meshes[0];
    assert_eq!(mesh.vertices.len(), 6, "every triangle has its own vertices");
    let normals: Vec<_> = mesh.indices.iter().map(|&i| mesh.vertices[i as usize].normal).collect();
    assert_eq!(normals[..3], [[0., 0., 1.]; 3]);
    assert_eq!(normals[3..], [[1., 0., 0.]; 3]);
}

#[test]
fn unusable_normals_are_replaced_and_others_made_unit() {
    let mut file = File::square();
    let normals = [0., 0., 0., f32::NAN, 0., 1., 0., 0., 1e-30, 3., 0., 4.];
    let normal = file.accessor(&floats(&normals), "VEC3", F32, 4);
    file.primitive()["attributes"]["NORMAL"] = json!(normal);
    let vertices = &file.scene().meshes[0].vertices;
    assert!(vertices[..3].iter().all(|v| v.normal == [0., 0., 1.]));
    assert_eq!(vertices[3].normal, [0.6, 0., 0.8]);
}

#[test]
fn vertices_that_are_not_used_are_not_kept() {
    let mut file = File::square();
    let indices = file.accessor(&[3, 2, 1], "SCALAR", U8, 3);
    file.primitive()["indices"] = json!(indices);
    let scene = file.scene();
    assert_eq!(scene.meshes[0].vertices.len(), 3);
    assert_eq!(corners(&scene), [[D, C, B]]);

    // A small part of a large buffer.
    let many = [&[9.0; 300], &SQUARE[..]].concat();
    let position = file.accessor(&floats(&many), "VEC3", F32, 104);
    let normal = file.accessor(&floats(&FRONT.repeat(26)), "VEC3", F32, 104);
    file.primitive()["attributes"] = json!({"POSITION": position, "NORMAL": normal});
    let indices = file.accessor(&[103, 102, 101, 102, 100, 101], "SCALAR", U8, 6);
    file.primitive()["indices"] = json!(indices);
    let scene = file.scene();
    assert_eq!(scene.meshes[0].vertices.len(), 4);
    assert_eq!(corners(&scene), [[D, C, B], [C, A, B]]);
}

fn normal_mapped() -> File {
    let mut file = File::textured(json!({"normalTexture": {"index": 0}}));
    let view = file.view(&png(1, 1, &[128, 128, 255, 255]));
    file.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    file.push("textures", json!({"source": 0}));
    file
}

/// Bitangents as the shaders make them.
fn bitangents(mesh: &Mesh) -> Vec<glam::Vec3> {
    let bitangent = |vertex: &Vertex| {
        let [x, y, z, sign] = vertex.tangent;
        sign * glam::Vec3::from(vertex.normal).cross(glam::Vec3::new(x, y, z))
    };
    mesh.vertices.iter().map(bitangent).collect()
}

#[test]
fn tangents_are_computed_for_normal_textures_alone() {
    let mut file = normal_mapped();
    let scene = file.scene();
    assert_eq!(scene.meshes[0].vertices.len(), 4);
    assert!(scene.meshes[0].vertices.iter().all(|v| v.tangent == [1., 0., 0., 1.]));
    assert!(bitangents(&scene.meshes[0]).iter().all(|b| b.abs_diff_eq(glam::Vec3::Y, 1e-6)));
    assert!(scene.materials[0].normal_texture.is_some());

    // Mirrored: u runs to the left, the picture still stands upright.
    let mirrored: Vec<f32> = UVS.chunks(2).flat_map(|uv| [1.0 - uv[0], uv[1]]).collect();
    let uv = file.accessor(&floats(&mirrored), "VEC2", F32, 4);
    file.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    let scene = file.scene();
    assert!(scene.meshes[0].vertices.iter().all(|v| v.tangent == [-1., 0., 0., -1.]));
    assert!(bitangents(&scene.meshes[0]).iter().all(|b| b.abs_diff_eq(glam::Vec3::Y, 1e-6)));

    let plain = File::textured(json!({})).scene();
    assert!(plain.meshes[0].vertices.iter().all(|v| v.tangent[..3] == [0.; 3]));
}

#[test]
fn vertices_are_doubled_where_tangents_part() {
    let mut file = normal_mapped();
    // The second triangle's u runs the other way round from the shared edge on.
    let uv = file.accessor(&floats(&[0., 1., 1., 1., 0., 0., -1., 0.]), "VEC2", F32, 4);
    file.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    let mesh = &file.scene().meshes[0];
    assert!(mesh.vertices.len() > 4, "{}", mesh.vertices.len());
    let sign = |corner: usize| mesh.vertices[mesh.indices[corner] as usize].tangent[3];
    assert_ne!(sign(0), sign(5));
    assert!(mesh.vertices.iter().all(|v| v.tangent[3].abs() == 1.0));
}

#[test]
fn the_files_tangents_are_kept_and_repaired() {
    let mut file = normal_mapped();
    let tangents = [0., 2., 0., -1., 1., 0., 0., 1., 0., 0., 0., 1., f32::NAN, 0., 0., 0.];
    let tangent = file.accessor(&floats(&tangents), "VEC4", F32, 4);
    file.primitive()["attributes"]["TANGENT"] = json!(tangent);
    let vertices = &file.scene().meshes[0].vertices;
    assert_eq!(vertices[0].tangent, [0., 1., 0., -1.]);
    assert_eq!(vertices[1].tangent, [1., 0., 0., 1.]);
    for vertex in &vertices[2..] {
        let [x, y, z, sign] = vertex.tangent;
        assert_eq!((z, sign), (0.0, 1.0), "perpendicular to the normal");
        assert!((x.hypot(y) - 1.0).abs() < 1e-6);
    }
}

/// As many primitives as fit in 200, each a triangle of one large buffer of vertices; accessor `k` of
/// the positions begins at vertex `k · shift`.
fn many_triangles_of_one_buffer(shift: usize) -> File {
    let vertices = 1000 + 200 * shift;
    let mut file = File::new();
    let positions = file.view(&floats(&SQUARE.repeat(vertices / 4)));
    let indices = file.accessor(&shorts(&[0, 1, 2]), "SCALAR", U16, 3);
    let primitive = |k: usize| {
        let position = file.push(
            "accessors",
            json!({
                "bufferView": positions, "byteOffset": 12 * shift * k, "type": "VEC3",
                "componentType": F32, "count": 1000
            }),
        );
        json!({"attributes": {"POSITION": position}, "indices": indices})
    };
    let primitives: Vec<_> = (0..200).map(primitive).collect();
    file.push("meshes", json!({"primitives": primitives}));
    file.push("nodes", json!({"mesh": 0}));
    file
}

#[test]
fn what_many_primitives_share_is_read_once() {
    let scene = many_triangles_of_one_buffer(0).scene();
    assert_eq!(scene.meshes.len(), 200);
    // Were it read anew for each of them, it would be read more often than a file's bytes may be.
    let fault = many_triangles_of_one_buffer(4).fault();
    assert!(fault.contains("overlap too often"), "{fault}");
}
