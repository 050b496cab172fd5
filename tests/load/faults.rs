//! Wrong files: each is an error that names the file and the fault, never a panic or a hang.

use crate::file::*;
use base64::Engine;
use klieg::scene::load::load;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::sync::OnceLock;

fn assert_fault(file: &File, words: &[&str]) {
    let fault = file.fault();
    assert!(words.iter().all(|word| fault.contains(word)), "{words:?} in: {fault}");
}

/// The square after a change to its JSON.
fn changed(change: impl FnOnce(&mut Value)) -> File {
    let mut file = File::square();
    change(&mut file.json);
    file
}

#[test]
fn the_right_file_is_right() {
    assert_eq!(changed(|_| ()).scene().polygons(), 2);
}

#[test]
fn files_that_are_not_there_or_not_files() {
    let folder = Folder::new();
    let name = folder.path("").file_name().unwrap().to_str().unwrap().to_owned();
    assert!(fault(load(&folder.path("")), &name).contains("directory"));
    assert!(fault(load(&folder.path("absent.glb")), "absent.glb").contains("not found"));
    assert!(fault(folder.load("empty.glb", b""), "empty.glb").contains("empty"));
    let text = b"solid not glTF at all";
    assert!(fault(folder.load("a.glb", text), "a.glb").contains("not glTF"));
    #[cfg(unix)]
    assert!(fault(load("/dev/zero".as_ref()), "zero").contains("regular"));
}

#[test]
fn broken_containers() {
    let glb = File::square().glb();
    let folder = Folder::new();
    let load = |bytes: &[u8]| fault(folder.load("a.glb", bytes), "a.glb");
    for end in (4..glb.len()).step_by(7) {
        assert!(load(&glb[..end]).contains("truncated"), "{end}");
    }
    let with = |at: usize, bytes: &[u8]| {
        let mut glb = glb.clone();
        glb[at..at + bytes.len()].copy_from_slice(bytes);
        load(&glb)
    };
    assert!(with(0, b"glTf").contains("not glTF"), "magic");
    assert!(with(4, &[1]).contains("version 1"));
    assert!(with(8, &[0xff; 4]).contains("truncated"));
    assert!(with(12, &[0xff; 4]).contains("truncated"));
    assert!(with(16, b"ABCD").contains("JSON chunk"));
    assert!(with(20, b"}").contains("JSON"));
    assert!(load(&[b'['; 4]).contains("not glTF"));
    assert!(load(&b"{\"a\":".repeat(100_000)).contains("JSON"), "deep nesting");
}

/// JSON takes many times its size once it is parsed; the file has no content on the disk.
#[test]
fn json_that_would_take_all_memory() {
    let folder = Folder::new();
    folder.write("a.gltf", b"{");
    let file = std::fs::File::options().write(true).open(folder.path("a.gltf")).unwrap();
    file.set_len((1 << 30) + 1).unwrap();
    let fault = fault(load(&folder.path("a.gltf")), "a.gltf");
    assert!(fault.contains("1073741825 bytes of JSON"), "{fault}");
}

#[test]
fn versions_and_extensions() {
    assert_fault(&changed(|j| j["asset"] = json!({"version": "1.0"})), &["version '1.0'"]);
    assert_fault(&changed(|j| j["asset"] = json!({})), &["version"]);
    let minimum = json!({"version": "2.1", "minVersion": "2.1"});
    assert_fault(&changed(|j| j["asset"] = minimum), &["2.1"]);
    let required =
        json!(["KHR_texture_transform", "KHR_example_packing", "EXT_meshopt_compression"]);
    let file = changed(|j| j["extensionsRequired"] = required);
    assert_fault(&file, &["'KHR_example_packing'"]);
    assert!(!file.fault().contains("transform") && !file.fault().contains("meshopt"));
}

#[test]
fn scenes_with_nothing_to_draw() {
    assert_fault(&File::new(), &["no triangles"]);
    assert_fault(&changed(|j| j["scenes"] = json!([{"nodes": []}])), &["no triangles"]);
    assert_fault(&changed(|j| j["scenes"] = json!([{}])), &["no triangles"]);
    let lines = changed(|j| j["meshes"][0]["primitives"][0]["mode"] = json!(1));
    assert_fault(&lines, &["no triangles"]);
    let mut point = File::square();
    point.bin[..48].fill(0);
    assert_fault(&point, &["extent"]);
}

#[test]
fn buffers_that_are_missing_or_short() {
    let file = File::square();
    let folder = Folder::new();
    let load = |uri: &str| fault(folder.load("a.gltf", &file.gltf(uri)), "a.gltf");
    let missing = load("no%20such.bin");
    assert!(missing.contains("no%20such.bin") && missing.contains("not found"), "{missing}");
    folder.write("short.bin", &file.bin[..file.bin.len() - 1]);
    let short = load("short.bin");
    assert!(short.contains("'short.bin'") && short.contains("bytes"), "{short}");
    assert!(load("https://example.org/a.bin").contains("relative"));
    assert!(load("/etc/hostname").contains("leads out"));
    assert!(load("data:application/octet-stream;base64,AA==").contains("bytes"));
    folder.write("folder/x", b"");
    assert!(load("folder").contains("directory"));
    let no_uri = changed(|j| {
        j["buffers"] = json!([{"byteLength": 4}, {"byteLength": 4}]);
        j["bufferViews"][0]["buffer"] = json!(1);
    });
    assert_fault(&no_uri, &["buffers[1]", "URI"]);
    assert_fault(&changed(|j| j["buffers"] = json!([{"byteLength": 9999}])), &["buffers[0]"]);
}

#[test]
fn accessors_out_of_their_bounds() {
    type Change = fn(&mut Value);
    let cases: [(Change, &[&str]); 15] = [
        (|j| j["accessors"][0]["count"] = json!(5), &["accessors[0]", "fit"]),
        (|j| j["accessors"][0]["count"] = json!(u64::MAX), &["accessors[0]"]),
        (|j| j["accessors"][0]["byteOffset"] = json!(4), &["accessors[0]", "fit"]),
        (|j| j["accessors"][0]["byteOffset"] = json!(u64::MAX), &["accessors[0]"]),
        (|j| j["accessors"][0]["type"] = json!("VEC2"), &["accessors[0]", "Vec2"]),
        (|j| j["accessors"][0]["type"] = json!("VEC5"), &["accessors[0]", "type"]),
        (|j| j["accessors"][0]["componentType"] = json!(5124), &["accessors[0]", "type"]),
        (|j| j["accessors"][0]["componentType"] = json!(U32), &["accessors[0]", "U32"]),
        (|j| j["accessors"][2]["componentType"] = json!(F32), &["indices", "F32"]),
        (|j| j["accessors"][1]["count"] = json!(3), &["NORMAL", "POSITION"]),
        (|j| j["bufferViews"][0]["byteLength"] = json!(9999), &["bufferViews[0]", "outside"]),
        (|j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["bufferViews[0]", "outside"]),
        (|j| j["bufferViews"][0]["byteStride"] = json!(0), &["byteStride of 0"]),
        (|j| j["bufferViews"][0]["byteStride"] = json!(8), &["overlap"]),
        (|j| j["bufferViews"][0]["byteStride"] = json!(1u64 << 62), &["fit"]),
    ];
    for (change, words) in cases {
        assert_fault(&changed(change), words);
    }
}

#[test]
fn indices_out_of_range() {
    type Change = fn(&mut Value);
    let cases: [Change; 9] = [
        |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9),
        |j| j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(9),
        |j| j["meshes"][0]["primitives"][0]["indices"] = json!(9),
        |j| j["meshes"][0]["primitives"][0]["material"] = json!(9),
        |j| j["nodes"][0]["mesh"] = json!(9),
        |j| j["nodes"][0]["children"] = json!([9]),
        |j| j["bufferViews"][0]["buffer"] = json!(9),
        |j| j["accessors"][0]["bufferView"] = json!(9),
        |j| j["scene"] = json!(9),
    ];
    for change in cases {
        assert_fault(&changed(change), &["out of range"]);
    }
    let mut file = File::square();
    let indices = file.accessor(&[0, 1, 4], "SCALAR", U8, 3);
    file.primitive()["indices"] = json!(indices);
    assert_fault(&file, &["mesh 'shape', primitive 0", "index 4"]);
}

#[test]
fn counts_that_would_take_all_memory() {
    // Zeros without data: a count alone must not become gigabytes.
    for count in [1u64 << 33, u64::MAX] {
        let mut file = changed(|j| {
            j["accessors"] = json!([
                {"type": "VEC3", "componentType": F32, "count": count}
            ]);
            j["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}});
        });
        assert_fault(&file, &["no triangles"]);
        let values = file.view(&floats(&[0.0; 3]));
        file.json["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": values, "componentType": U8},
            "values": {"bufferView": values}});
        assert_fault(&file, &["GiB more memory"]);
    }
    // One mesh of 50,000 points, drawn as 1,000 primitives.
    let mut file = changed(|_| {});
    let points = file.accessor(&vec![0; 12 * 50_000], "VEC3", F32, 50_000);
    let primitives = vec![json!({"attributes": {"POSITION": points}}); 1_000];
    file.json["meshes"][0]["primitives"] = json!(primitives);
    assert_fault(&file, &["more vertices"]);
}

/// A single element has no neighbour, so its stride says nothing, however large.
#[test]
fn strides_beyond_the_file_take_no_memory() {
    for stride in [1 << 20, 1 << 41, 1 << 62, (1u64 << 63) + 4, u64::MAX] {
        let mut file = File::square();
        let position = file.accessor(&floats(&[0.5; 3]), "VEC3", F32, 1);
        let view = file.json["accessors"][position]["bufferView"].as_u64().unwrap() as usize;
        file.json["bufferViews"][view]["byteStride"] = json!(stride);
        file.mesh(json!({"attributes": {"POSITION": position}}));
        assert_eq!(file.scene().polygons(), 2, "{stride}");
        // The same out of memory, and as the base of a sparse accessor.
        let folder = Folder::new();
        let data = base64::engine::general_purpose::STANDARD.encode(&file.bin);
        let uri = format!("data:application/octet-stream;base64,{data}");
        folder.load("a.gltf", &file.gltf(&uri)).unwrap();
        let indices = file.view(&[0]);
        let values = file.view(&floats(&[0.25; 3]));
        for view in [indices, values] {
            file.json["bufferViews"][view]["byteStride"] = json!(stride);
        }
        file.json["accessors"][position]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values}});
        assert_eq!(file.scene().polygons(), 2, "{stride}");
        // Two elements at such a distance do not fit.
        let mut file = File::square();
        file.json["bufferViews"][0]["byteStride"] = json!(stride);
        assert_fault(&file, &["accessors[0]", "fit"]);
    }
}

/// Images may share a buffer view, each then reading all of it.
#[test]
fn images_that_read_the_file_over_and_over() {
    let mut file = File::textured(json!({}));
    let mut image = png(1, 1, &[99; 4]);
    image.resize(1 << 20, 0);
    let view = file.view(&image);
    for number in 0..2000 {
        file.push("images", json!({"bufferView": view}));
        file.push("textures", json!({"source": number}));
        let texture = json!({"baseColorTexture": {"index": number}});
        file.push("materials", json!({"pbrMetallicRoughness": texture}));
        let mut primitive = file.primitive().clone();
        primitive["material"] = json!(number + 1);
        file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    assert_fault(&file, &["image 16", "too often"]);
}

#[test]
fn images_that_are_larger_than_klieg_reads() {
    // The header alone of a PNG, as its size is refused before anything is decoded.
    let header = |width: u32, height: u32| {
        let mut bytes = png(1, 1, &[99; 4]);
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let sum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&sum.to_be_bytes());
        bytes
    };
    for (width, height) in [(1, 1 << 15), (1 << 15, 1), (1 << 20, 1 << 20)] {
        let texture = json!({"baseColorTexture": {"index": 0}});
        let mut file = File::textured(json!({"pbrMetallicRoughness": texture}));
        let view = file.view(&header(width, height));
        file.push("images", json!({"bufferView": view}));
        file.push("textures", json!({"source": 0}));
        assert_fault(&file, &["image 0", &format!("{width}x{height} pixels")]);
    }
}

/// The checksum of a PNG's chunk.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum: u32, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ ((sum & 1) * 0xedb8_8320))
    })
}

#[test]
fn sparse_indices_out_of_range() {
    for (index, count, word) in [(4, 1, "index 4"), (0, 9, "fit"), (0, u64::MAX, "fit")] {
        let mut file = File::square();
        let indices = file.view(&[index]);
        let values = file.view(&floats(&[0.0; 3]));
        file.json["accessors"][0]["sparse"] = json!({
            "count": count,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        assert_fault(&file, &["accessors[0]", "sparse", word]);
    }
}

#[test]
fn positions_that_are_not_finite() {
    for value in [f32::NAN, f32::INFINITY] {
        let mut file = File::square();
        file.bin[..4].copy_from_slice(&value.to_le_bytes());
        assert_fault(&file, &["mesh 'shape', primitive 0", "not finite"]);
    }
}

#[test]
fn node_graphs_that_are_no_trees() {
    assert_fault(&changed(|j| j["nodes"][0]["children"] = json!([0])), &["ancestor"]);
    let cycle = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
    assert_fault(&changed(|j| j["nodes"] = cycle), &["ancestor"]);
    let shared = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]);
    assert_fault(&changed(|j| j["nodes"] = shared), &["node 0", "two parents"]);
    assert_fault(&changed(|j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0])), &["rotation"]);
    assert_fault(&changed(|j| j["nodes"][0]["scale"] = json!([1e60, 1, 1])), &["finite"]);
    let matrix = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    assert_fault(&changed(|j| j["nodes"][0]["matrix"] = matrix), &["last row"]);
}

/// A file with everything in it.
fn rich() -> &'static [u8] {
    static GLB: OnceLock<Vec<u8>> = OnceLock::new();
    GLB.get_or_init(|| {
        let mut file = File::textured(json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 0}, "alphaMode": "MASK",
        }));
        let view = file.view(&png(3, 3, &[99; 36]));
        file.push("images", json!({"bufferView": view}));
        file.push("textures", json!({"source": 0}));
        let indices = file.view(&[1]);
        let values = file.view(&floats(&[1., 0., 0.]));
        file.json["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values}});
        file.primitive()["targets"] = json!([{"POSITION": 0, "NORMAL": 1}]);
        file.json["meshes"][0]["weights"] = json!([0.5]);
        let joints = file.accessor(&[0; 16], "VEC4", U8, 4);
        let weights = file.accessor(&floats(&[0.25; 16]), "VEC4", F32, 4);
        file.primitive()["attributes"]["JOINTS_0"] = json!(joints);
        file.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
        file.json["nodes"][0]["skin"] = json!(0);
        file.push("skins", json!({"joints": [1]}));
        let perspective = json!({"yfov": 0.5, "znear": 0.1});
        file.push("cameras", json!({"type": "perspective", "perspective": perspective}));
        file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        file.push("nodes", json!({"camera": 0, "children": [2]}));
        let light = json!({"KHR_lights_punctual": {"light": 0}});
        file.push("nodes", json!({"mesh": 0, "rotation": [0, 0, 0, 1], "extensions": light}));
        file.scene();
        file.glb()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is wrong, there is an answer.
    #[test]
    fn damaged_files_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        end in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut glb = rich().to_vec();
        for (at, value) in flips {
            let at = at.index(glb.len());
            glb[at] = value;
        }
        if let Some(end) = end {
            glb.truncate(end.index(glb.len()));
            let length = (glb.len() as u32).to_le_bytes();
            if let Some(field) = glb.get_mut(8..12) {
                field.copy_from_slice(&length);
            }
        }
        if let Err(error) = Folder::new().load("damaged.glb", &glb) {
            prop_assert!(error.is_input());
        }
    }

    /// The same for digits in the JSON, which reach further in.
    #[test]
    fn damaged_numbers_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), b'0'..=b'9'), 1..6),
    ) {
        let mut glb = rich().to_vec();
        let json = 20 + u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
        let digits: Vec<_> = (20..json).filter(|&at| glb[at].is_ascii_digit()).collect();
        for (at, value) in flips {
            glb[*at.get(&digits)] = value;
        }
        if let Err(error) = Folder::new().load("damaged.glb", &glb) {
            prop_assert!(error.is_input());
        }
    }
}
