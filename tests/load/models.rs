//! PLY, STL and OBJ.

use crate::file::*;
use klieg::scene::Scene;
use klieg::scene::load::{LoadOptions, Orientation, Up, load, load_with};
use proptest::prelude::*;

/// The unit square as text, with colours.
const PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\n\
    property double x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
    property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 255 0 0\n1 0 0 188 0 0\n1 1 0 0 0 255\n0 1 0 255 255 255\n4 0 1 2 3\n";

const STL: &str = "solid square\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex 1 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\n\
    vertex 0 1 0\nendloop\nendfacet\nendsolid square\n";

const OBJ: &str = "mtllib missing.mtl\no front\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n\
    usemtl red\nf 1//1 2//1 3//1 4//1\no back\nv 0 0 -1\nv 1 0 -1\nv 1 1 -1\nf -3 -2 -1\n";

/// The same as binary PLY, with normals and without colours.
fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\n\
         property float y\nproperty float z\nproperty float nx\nproperty float ny\n\
         property float nz\nelement edge 1\nproperty int vertex1\nelement face 2\n\
         property list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut words = Vec::new();
    for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        words.extend([x, y, 0.0, 0.0, 0.0, 1.0].map(f32::to_bits));
    }
    words.push(7);
    let put = |bytes: &mut Vec<u8>, word: u32| match big {
        true => bytes.extend(word.to_be_bytes()),
        false => bytes.extend(word.to_le_bytes()),
    };
    words.iter().for_each(|&word| put(&mut bytes, word));
    for face in [[0, 1, 2], [0, 2, 3]] {
        bytes.push(3);
        face.iter().for_each(|&corner| put(&mut bytes, corner));
    }
    bytes
}

/// The same as binary STL, whose header begins as text does.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid made by a program that should not say so".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2u32.to_le_bytes());
    for triangle in [[[0., 0.], [1., 0.], [1., 1.]], [[0., 0.], [1., 1.], [0., 1.]]] {
        bytes.extend(floats(&[0., 0., 1.]));
        for [x, y] in triangle {
            bytes.extend(floats(&[x, y, 0.]));
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// Loads a file as it stands, in metres and with Y upwards.
fn plain(name: &str, bytes: &[u8]) -> Scene {
    let folder = Folder::new();
    folder.write(name, bytes);
    let orientation = Orientation { units: Some(1.0), up: Some(Up::Y) };
    let reading = LoadOptions { orientation, ..LoadOptions::default() };
    load_with(&folder.path(name), reading).unwrap_or_else(|error| panic!("{error}"))
}

const TRIANGLES: [[[f64; 3]; 3]; 2] =
    [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]], [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]];

#[test]
fn every_format_gives_its_triangles() {
    let files: [(&str, Vec<u8>); 6] = [
        ("a.ply", PLY.into()),
        ("named.otherwise", binary_ply(false)),
        ("big.ply", binary_ply(true)),
        ("a.stl", STL.into()),
        ("A.STL", binary_stl()),
        ("a.obj", OBJ.into()),
    ];
    for (name, bytes) in files {
        let scene = plain(name, &bytes);
        assert_eq!(corners(&scene)[..2], TRIANGLES, "{name}");
        let material = &scene.materials[scene.meshes[0].material as usize];
        assert_eq!((material.metallic, material.double_sided), (0.0, true), "{name}");
        // OBJ names a library that is not there.
        let warnings = usize::from(name == "a.obj");
        assert_eq!(scene.warnings.len(), warnings, "{name}: {:?}", scene.warnings);
        for vertex in &scene.meshes[0].vertices {
            assert_eq!(vertex.normal, [0.0, 0.0, 1.0], "{name}");
        }
    }
}

#[test]
fn objects_and_colors_are_kept() {
    let scene = plain("a.obj", OBJ.as_bytes());
    let names: Vec<_> = scene.instances.iter().map(|instance| &*instance.name).collect();
    assert_eq!((names, scene.polygons()), (vec!["front", "back"], 3));
    let scene = plain("a.ply", PLY.as_bytes());
    let material = &scene.materials[scene.meshes[0].material as usize];
    assert_eq!(material.base_color, [1.0; 4]);
    let colors: Vec<_> = scene.meshes[0].vertices.iter().map(|vertex| vertex.color).collect();
    // 188 in sRGB is half the light.
    assert_eq!(colors[..3], [[255, 0, 0, 255], [128, 0, 0, 255], [0, 0, 255, 255]]);
}

/// Two strips, as old scans have them: of a square, the second with a corner that comes twice.
#[test]
fn strips_of_triangles_are_read() {
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let text = PLY.replace(faces, strips).replace("4 0 1 2 3\n", "10 0 1 3 2 -1 0 1 1 2 3\n");
    let scene = plain("a.ply", text.as_bytes());
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let triangles = [[0, 1, 3], [3, 1, 2], [1, 2, 3]];
    assert_eq!(corners(&scene), triangles.map(|triangle| triangle.map(|corner| square[corner])));
    let folder = Folder::new();
    let out = text.replace("-1", "-2");
    assert!(fault(folder.load("b.ply", out.as_bytes()), "b.ply").contains("out of range"));
    for none in [PLY.replace(faces, strips), PLY.to_owned()] {
        let none = none.replace("4 0 1 2 3\n", "2 0 1\n");
        assert!(fault(folder.load("c.ply", none.as_bytes()), "c.ply").contains("no triangles"));
    }
}

#[test]
fn units_and_the_axis_upwards_follow_the_format_or_what_is_asked() {
    let folder = Folder::new();
    let stl = folder.load("a.stl", STL.as_bytes()).unwrap();
    let top = corners(&stl)[1][2];
    for (found, expected) in top.into_iter().zip([0.0, 0.0, -0.001]) {
        assert!((found - expected).abs() < 1e-9, "{top:?}");
    }
    assert_eq!(corners(&folder.load("a.ply", PLY.as_bytes()).unwrap())[1][2], [0.0, 1.0, 0.0]);
    let orientation = Orientation { units: Some(0.5), up: Some(Up::Z) };
    let reading = LoadOptions { orientation, ..LoadOptions::default() };
    let top = corners(&load_with(&folder.path("a.ply"), reading).unwrap())[1][2];
    for (found, expected) in top.into_iter().zip([0.0, 0.0, -0.5]) {
        assert!((found - expected).abs() < 1e-9, "{top:?}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new();
    let fault_of = |name: &str, bytes: &[u8]| fault(folder.load(name, bytes), name);
    let points = PLY.replace("element face 1", "element face 0").replace("4 0 1 2 3\n", "");
    assert!(fault_of("a.ply", points.as_bytes()).contains("no faces"));
    let out = PLY.replace("4 0 1 2 3", "4 0 1 2 9");
    assert!(fault_of("a.ply", out.as_bytes()).contains("out of range"));
    let many = PLY.replace("element vertex 4", "element vertex 4000000000000000");
    assert!(fault_of("a.ply", many.as_bytes()).contains("not valid PLY"));
    let nothing = PLY.replace(
        "element face 1\nproperty list uchar int vertex_indices\n",
        "element face 9000000000000\n",
    );
    assert!(fault_of("a.ply", nothing.as_bytes()).contains("not valid PLY"));
    let mut stl = binary_stl();
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    stl[0] = b'S';
    assert!(fault_of("a.stl", &stl).contains("truncated"));
    assert!(fault_of("a.stl", b"solid nothing\nendsolid nothing\n").contains("no triangles"));
    assert!(fault_of("a.obj", b"v 0 0 0\nf 1 2 3\n").contains("not valid OBJ"));
    assert!(fault_of("a.obj", b"v 0 0 0\n").contains("no triangles"));
    let mut endless = binary_stl();
    endless[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(fault_of("a.stl", &endless).contains("vertex 0 is not finite"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Whatever is wrong with a file, there is an answer.
    #[test]
    fn broken_files_never_panic(
        which in 0..6,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        end in prop::option::weighted(0.4, any::<prop::sample::Index>()),
    ) {
        let (name, mut bytes) = match which {
            0 => ("a.ply", PLY.into()),
            1 => ("a.ply", binary_ply(false)),
            2 => ("a.ply", binary_ply(true)),
            3 => ("a.stl", STL.into()),
            4 => ("a.stl", binary_stl()),
            _ => ("a.obj", OBJ.into()),
        };
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(end) = end {
            bytes.truncate(end.index(bytes.len()));
        }
        let folder = Folder::new();
        folder.write(name, &bytes);
        if let Err(error) = load(&folder.path(name)) {
            prop_assert!(error.is_input() && error.to_string().contains(name), "{error}");
        }
    }
}
