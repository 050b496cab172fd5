//! Which of the files that a scene names come to stand in the lit scene.

use super::fixtures::{
    SECRET, glb, parse_glb, png, positions, rig, triangle, views, with_unused_files, write,
};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use klieg::scene::load::{FileAccess, LoadOptions, Orientation, Up, load, load_with};
use klieg::scene::{Scene, lit};
use serde_json::json;

#[test]
fn what_the_scene_does_not_use_is_neither_read_nor_taken_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = with_unused_files(folder.path());
    let source = write(folder.path(), "a.gltf", root.to_string().as_bytes());
    let out = folder.path().join("out.glb");
    let light = |access| lit::write(&source, access, &views()[0], &rig(), &out);
    light(FileAccess::SceneFolder).expect("a lit scene");
    let bytes = std::fs::read(&out).expect("the lit scene");
    let has = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
    // A part of the base64 text that does not hang on where the secret begins.
    let encoded = STANDARD.encode(&SECRET[..36]);
    assert!(!has(&SECRET[..8]) && !has(encoded.as_bytes()) && has(&png()));
    let (root, binary) = parse_glb(&bytes);
    assert_eq!((root["buffers"][0]["name"].as_str(), binary[0]), (Some("first"), 0));
    let encoded = STANDARD.encode(positions());
    let uri = format!("data:application/octet-stream;base64,{encoded}");
    assert_eq!(root["buffers"][1], json!({ "uri": uri, "byteLength": 36 }));
    assert_eq!(root["buffers"][2]["byteLength"], 1);
    assert_eq!(root["bufferViews"][1], json!({ "buffer": 2, "byteLength": 1 }));
    for image in root["images"].as_array().expect("images") {
        assert_eq!((image.get("uri"), &image["mimeType"]), (None, &json!("image/png")));
        let view = &root["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
        let number = |key: &str| view[key].as_u64().expect("a number") as usize;
        let picture = &binary[number("byteOffset")..][..number("byteLength")];
        assert_eq!(image::load_from_memory(picture).expect("a picture").width(), 1);
    }
    // Nothing needs the unused files, and the lit scene needs no file at all.
    for name in ["secret.txt", "unused.png"] {
        std::fs::remove_file(folder.path().join(name)).expect("a file");
    }
    light(FileAccess::SceneFolder).expect("a lit scene");
    for name in ["positions.bin", "used.png", "a.gltf"] {
        std::fs::remove_file(folder.path().join(name)).expect("a file");
    }
    assert_eq!(load(&out).expect("the lit scene").files, [out]);
}

#[test]
fn files_outside_the_scene_s_folder_are_taken_in_only_where_allowed() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "positions.bin", &positions());
    write(folder.path(), "a.png", &png());
    let scene = folder.path().join("scene");
    std::fs::create_dir(&scene).expect("a folder");
    write(&scene, "positions.bin", &positions());
    let out = scene.join("out.glb");
    for (buffer, picture) in [("../positions.bin", "a.png"), ("positions.bin", "..%2Fa.png")] {
        let mut root = triangle();
        root["buffers"][0]["uri"] = buffer.into();
        root["images"] = json!([{ "uri": picture }]);
        root["textures"] = json!([{ "source": 0 }]);
        let source = write(&scene, "a.gltf", root.to_string().as_bytes());
        let light = |access| lit::write(&source, access, &views()[0], &rig(), &out);
        let error = light(FileAccess::SceneFolder).expect_err("outside");
        let text = error.to_string();
        let uri = if buffer.starts_with("..") { buffer } else { picture };
        assert!(error.is_input() && text.contains("a.gltf") && text.contains(uri), "{text}");
        assert!(text.contains("--allow-outside") && !out.exists(), "{text}");
        write(&scene, "a.png", &png());
        light(FileAccess::Anywhere).expect("a lit scene");
        load(&out).expect("the lit scene");
        std::fs::remove_file(&out).expect("the lit scene");
    }
}

/// A picture that nobody can show is no fault of the lights: it stays as it is.
#[test]
fn pictures_in_no_known_format_are_taken_in_as_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "positions.bin", &positions());
    write(folder.path(), "odd.bin", b"no picture");
    let mut root = triangle();
    root["buffers"][0]["uri"] = "positions.bin".into();
    root["images"] = json!([{ "uri": "odd.bin" }]);
    root["textures"] = json!([{ "source": 0 }]);
    let source = write(folder.path(), "a.gltf", root.to_string().as_bytes());
    let out = folder.path().join("out.glb");
    lit::write(&source, FileAccess::SceneFolder, &views()[0], &rig(), &out).expect("a lit scene");
    let (root, _) = parse_glb(&std::fs::read(&out).expect("the lit scene"));
    let encoded = STANDARD.encode(b"no picture");
    assert_eq!(root["images"][0]["uri"], format!("data:application/octet-stream;base64,{encoded}"));
    load(&out).expect("the lit scene");
}

/// Files of triangles become glTF that stands where they were scored.
#[test]
fn triangles_become_gltf() {
    let folder = tempfile::tempdir().expect("a folder");
    let orientation = Orientation { units: Some(0.25), up: Some(Up::Z) };
    let options = LoadOptions { orientation, ..LoadOptions::default() };
    let obj = b"o plate\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 1\nf 1 2 3 4\n";
    let source = write(folder.path(), "plate.obj", obj);
    let out = folder.path().join("out.glb");
    lit::write(&source, options.clone(), &views()[0], &rig(), &out).expect("a lit scene");
    let (scene, lit_scene) = (load_with(&source, options).expect("a scene"), load(&out));
    let corners = |scene: &Scene| -> Vec<_> { (0..2).map(|t| scene.corners(0, t)).collect() };
    let lit_scene = lit_scene.expect("the lit scene");
    assert_eq!(corners(&scene), corners(&lit_scene));
    assert_eq!(lit_scene.lights.len(), rig().len());
    let reports = super::validator::validate(&[out]);
    assert_eq!(super::validator::codes(&reports[0], 1), Vec::<&str>::new(), "{reports:#?}");
}
/// A buffer whose views read beyond the length that the file gives it: viewers read on, and so does klieg.
#[test]
fn a_buffer_longer_than_the_file_says_is_whole_and_its_length_right() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out.glb");
    let mut root = triangle();
    root["buffers"][0]["byteLength"] = 8.into();
    let binary = glb(&root, Some(&positions()));
    root["buffers"][0]["uri"] = "positions.bin".into();
    write(folder.path(), "positions.bin", &positions());
    let mut second = root.clone();
    second["buffers"] = json!([{ "byteLength": 4, "uri": "data:;base64,AAAAAA==" }, {
        "byteLength": 8,
        "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(positions())),
    }]);
    second["bufferViews"][0]["buffer"] = 1.into();
    for (name, bytes, index) in [
        ("chunk.glb", binary, 0),
        ("file.gltf", root.to_string().into_bytes(), 0),
        ("data.gltf", second.to_string().into_bytes(), 1),
    ] {
        let source = write(folder.path(), name, &bytes);
        lit::write(&source, FileAccess::SceneFolder, &views()[0], &rig(), &out).expect("a scene");
        let (root, _) = parse_glb(&std::fs::read(&out).expect("the lit scene"));
        assert_eq!(root["buffers"][index]["byteLength"], 36, "{name}");
        load(&out).expect("the lit scene");
    }
}

/// What the drawn scene does not need may be missing, used by something in the file or not.
#[test]
fn a_missing_image_that_is_not_drawn_is_a_pixel() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut root = triangle();
    root["images"] = json!([{ "uri": "gone.png" }]);
    root["textures"] = json!([{ "source": 0 }]);
    let source = write(folder.path(), "a.glb", &glb(&root, Some(&positions())));
    let out = folder.path().join("out.glb");
    lit::write(&source, FileAccess::SceneFolder, &views()[0], &rig(), &out).expect("a lit scene");
    let (root, _) = parse_glb(&std::fs::read(&out).expect("the lit scene"));
    assert_eq!(root["images"][0]["mimeType"], "image/png");
    load(&out).expect("the lit scene");
}
