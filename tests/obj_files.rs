//! OBJ files with the materials that they name.

use klieg::lighting::presets::Preset;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load::{LoadOptions, load};
use klieg::scene::view::View;
use klieg::scene::{Scene, lit};
use std::path::Path;

const MATERIALS: &str = "newmtl wood\nKd 0 0 0\nNs 225\nmap_Kd -s 1 1 1 wood grain.png\nnorm missing.png\n\
    newmtl glass\nKd 0.2 0.4 0.6\nd 0.75\nPr 0.1\nPm 0.9\nKe 0 1 0\n\
    newmtl leaf\nmap_Kd wood grain.png\nmap_d wood grain.png\nTr 1\n";

/// Three quads, one above another; a comment that is not UTF-8, a line in two parts and a material without a name.
fn quads(library: &str) -> Vec<u8> {
    let mut text = b"# caf\xe9\nmtllib ".to_vec();
    text.extend(library.bytes());
    text.extend(b"\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl \n");
    for (row, material) in ["wood", "glass", "leaf"].iter().enumerate() {
        let (at, top) = (4 * row, row + 1);
        text.extend(format!("v 0 {row} 0\nv 1 {row} 0\nv 1 {top} 0\nv 0 {top} 0\n").bytes());
        let corner = |k: usize| format!("{}/{k}", at + k);
        let [a, b, c, d] = [1, 2, 3, 4].map(corner);
        text.extend(format!("o {material}\nusemtl {material}\nf {a} {b} \\\n {c} {d}\n").bytes());
    }
    text
}

fn written(folder: &Path, library: &str) -> Scene {
    std::fs::write(folder.join("quads.obj"), quads(library)).unwrap();
    load(&folder.join("quads.obj")).unwrap()
}

#[test]
fn materials_are_those_of_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let textures = folder.path().join("textures");
    std::fs::create_dir(&textures).unwrap();
    std::fs::write(textures.join("a.mtl"), MATERIALS).unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([200, 100, 50, 255]))
        .save(textures.join("wood grain.png"))
        .unwrap();
    let scene = written(folder.path(), "textures\\a.mtl");
    let material = |name: &str| scene.materials.iter().find(|m| m.name == name).unwrap();

    let wood = material("wood");
    assert_eq!((wood.base_color, wood.metallic, wood.roughness), ([1.0; 4], 0.0, 0.5));
    assert!(wood.base_color_texture.is_some() && wood.normal_texture.is_none());
    assert!(
        scene.warnings.iter().any(|warning| warning.contains("missing.png")),
        "{:?}",
        scene.warnings
    );
    let glass = material("glass");
    assert_eq!((glass.base_color, glass.emissive), ([0.2, 0.4, 0.6, 0.75], [0.0, 1.0, 0.0]));
    assert_eq!((glass.metallic, glass.roughness), (0.9, 0.1));
    assert!(glass.alpha_cutoff > 0.0);
    let leaf = material("leaf");
    assert!(leaf.alpha_cutoff > 0.0 && leaf.base_color[3] == 1.0);
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(scene.files.len(), 3);

    // The lower left corner has v = 0 there, and 1 in glTF.
    let corner = scene.meshes[0].vertices.iter().find(|v| v.position == [0.0; 3]).unwrap();
    assert_eq!(corner.uv[0], [0.0, 1.0]);
    assert_eq!(scene.polygons(), 6);

    let (source, lit) = (folder.path().join("quads.obj"), folder.path().join("lit.glb"));
    let view = View::new(&scene, frame(&scene, &Framing::default(), 1.0).unwrap(), 16, 16).unwrap();
    lit::write(&source, LoadOptions::default(), &view, &Preset::Headlight.rig(), &lit).unwrap();
    std::fs::remove_dir_all(textures).unwrap();
    let again = load(&lit).unwrap();
    assert_eq!((again.polygons(), again.textures.len()), (6, 1));
}

#[test]
fn libraries_that_cannot_be_read_leave_grey_surfaces_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("a.mtl"), MATERIALS).unwrap();
    std::fs::write(inner.join("bad.mtl"), "newmtl a\nKd red\n").unwrap();
    for (library, reason) in [
        ("../a.mtl", "leads out of the scene's folder"),
        ("none.mtl", "file not found"),
        ("bad.mtl", "parse error"),
    ] {
        let scene = written(&inner, library);
        let [warning] = &scene.warnings[..] else { panic!("{library}: {:?}", scene.warnings) };
        assert!(warning.contains(library) && warning.contains(reason), "{warning}");
        assert!(scene.materials.iter().any(|m| m.base_color == [0.5, 0.5, 0.5, 1.0]));
    }
}
