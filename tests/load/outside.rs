//! Files that a scene names: only those in its own folder, unless all are allowed, and only those that
//! anything uses.

use crate::file::*;
use klieg::scene::load::{FileAccess, load, load_with};
use serde_json::json;

/// A folder with the square's buffer, and beside it the folder `scene`, which has it too.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("square.bin", &File::square().bin);
    folder.write("scene/square.bin", &File::square().bin);
    folder
}

/// Loads the square with its buffer at `uri`; gives the fault, if any.
fn with_buffer(folder: &Folder, uri: &str, access: FileAccess) -> Option<String> {
    folder.write("scene/a.gltf", &File::square().gltf(uri));
    let path = folder.path("scene/a.gltf");
    let result = load_with(&path, access);
    if access == FileAccess::SceneFolder {
        assert_eq!(load(&path).is_ok(), result.is_ok(), "{uri}");
    }
    result.is_err().then(|| fault(result, "a.gltf"))
}

fn assert_refused(folder: &Folder, uri: &str) {
    let fault = with_buffer(folder, uri, FileAccess::SceneFolder).expect(uri);
    let named = uri.replace('\\', "\\\\");
    let words = ["buffers[0]", &named[..], "leads out of the scene's folder", "--allow-outside"];
    assert!(words.iter().all(|word| fault.contains(word)), "{words:?} in: {fault}");
}

#[test]
fn what_leads_out_of_the_scene_s_folder_is_refused() {
    let folder = folder();
    let absolute = folder.path("square.bin").to_str().unwrap().to_owned();
    let inside = folder.path("scene/square.bin").to_str().unwrap().to_owned();
    for uri in [
        "../square.bin",
        "./../square.bin",
        "x/../../square.bin",
        "%2e%2e%2fsquare.bin",
        "%2E./square.bin",
        "..\\square.bin",
        "..%5Csquare.bin",
        &absolute,
        &inside,
        &format!("file://{absolute}"),
        &format!("file://localhost{absolute}"),
        &format!("FILE:{absolute}"),
    ] {
        assert_refused(&folder, uri);
    }
    // Whether such a file is there is not told.
    for uri in
        ["../absent.bin", "C:\\square.bin", "c:/square.bin", "C%3A/square.bin", "\\\\host\\a"]
    {
        assert_refused(&folder, uri);
    }
    for uri in ["../square.bin", "%2e%2e%2fsquare.bin", "..\\square.bin", &absolute] {
        assert_eq!(with_buffer(&folder, uri, FileAccess::Anywhere), None, "{uri}");
    }
    let uri = format!("file://{absolute}");
    assert_eq!(with_buffer(&folder, &uri, FileAccess::Anywhere), None);
    for uri in ["https://example.org/a.bin", "file://host/a.bin", "../absent.bin"] {
        assert!(with_buffer(&folder, uri, FileAccess::Anywhere).is_some(), "{uri}");
    }
}

#[test]
fn what_stays_in_the_scene_s_folder_is_read() {
    let folder = folder();
    folder.write("scene/parts/square.bin", &File::square().bin);
    folder.write("scene/%+5/%2e%2e/100%/square.bin", &File::square().bin);
    for uri in [
        "square.bin",
        "./square.bin",
        "parts/../square.bin",
        "parts\\square.bin",
        "p%61rts%2Fsquare.bin",
        "%+5/%252e%252e/100%/square.bin",
    ] {
        assert_eq!(with_buffer(&folder, uri, FileAccess::SceneFolder), None, "{uri}");
    }
    for (uri, word) in [("%00", "NUL"), ("a%ff.bin", "UTF-8"), ("%5", "not found")] {
        let fault = with_buffer(&folder, uri, FileAccess::SceneFolder).expect(uri);
        assert!(fault.contains(uri) && fault.contains(word), "{fault}");
    }
}

#[cfg(unix)]
#[test]
fn links_count_as_what_they_lead_to() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    symlink("../square.bin", folder.path("scene/out.bin")).unwrap();
    symlink("..", folder.path("scene/up")).unwrap();
    symlink("square.bin", folder.path("scene/in.bin")).unwrap();
    for uri in ["out.bin", "up/square.bin"] {
        assert_refused(&folder, uri);
        assert_eq!(with_buffer(&folder, uri, FileAccess::Anywhere), None, "{uri}");
    }
    for uri in ["in.bin", "up/scene/square.bin"] {
        assert_eq!(with_buffer(&folder, uri, FileAccess::SceneFolder), None, "{uri}");
    }
    // The folder may itself be reached over a link.
    symlink("scene", folder.path("link")).unwrap();
    load(&folder.path("link/a.gltf")).unwrap();
}

#[test]
fn images_outside_are_refused_too() {
    let texture = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let mut file = File::textured(texture);
    file.push("images", json!({"uri": "../a.png"}));
    file.push("textures", json!({"source": 0}));
    let folder = Folder::new();
    folder.write("a.png", &png(1, 1, &[99; 4]));
    let fault = fault(folder.load("scene/a.glb", &file.glb()), "a.glb");
    assert!(fault.contains("image 0 '../a.png'") && fault.contains("--allow-outside"), "{fault}");
    let scene = load_with(&folder.path("scene/a.glb"), FileAccess::Anywhere).unwrap();
    assert_eq!((scene.textures.len(), scene.files.len()), (1, 2));
}

#[test]
fn what_nothing_uses_is_not_looked_at() {
    let mut file = File::square();
    let (length, folder) = (file.bin.len(), folder());
    file.json["buffers"] = json!([
        {"byteLength": 4, "uri": "../square.bin"}, {"byteLength": 1, "uri": "absent.bin"},
        {"byteLength": length, "uri": "square.bin"}, {"byteLength": 9},
    ]);
    for view in file.json["bufferViews"].as_array_mut().unwrap() {
        view["buffer"] = json!(2);
    }
    file.push("bufferViews", json!({"buffer": 0, "byteLength": 1}));
    file.push("images", json!({"uri": "../square.bin"}));
    let scene = folder.load("scene/a.gltf", &serde_json::to_vec(&file.json).unwrap()).unwrap();
    assert_eq!(scene.files, ["scene/a.gltf", "scene/square.bin"].map(|name| folder.path(name)));
}
