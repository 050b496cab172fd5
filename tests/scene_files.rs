//! The files of `scenes/` are what their generator makes, byte for byte, and what they promise.

#[path = "../examples/scenes/generator/mod.rs"]
mod generator;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use gltf::Gltf;
use gltf::camera::Projection;

use generator::elephant::Elephant;
use generator::pair;

static ELEPHANT: LazyLock<Elephant> = LazyLock::new(Elephant::new);

const NAMES: [&str; 3] = ["elephant.glb", "pair.glb", "still-life.glb"];

/// Surfaces that must be closed and free of seams; the turned ones have a seam of equal positions.
const CLOSED: [&str; 5] = ["elephant skin", "ivory", "eyes", "glaze", "pewter"];

fn stored(name: &str) -> Vec<u8> {
    let path = klieg_support::root().join("scenes").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A primitive's data, read by the `gltf` crate.
struct Primitive {
    material: String,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<[f32; 4]>,
    triangles: Vec<[u32; 3]>,
}

/// Every primitive of every mesh node, so that instances count each time.
fn primitives(document: &Gltf) -> Vec<Primitive> {
    let blob = document.blob.as_deref().expect("the file has a binary chunk");
    let mut list = Vec::new();
    for mesh in document.nodes().filter_map(|node| node.mesh()) {
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(blob));
            let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
            list.push(Primitive {
                material: primitive.material().name().expect("a named material").into(),
                positions: reader.read_positions().expect("positions").map(Vec3::from).collect(),
                normals: reader.read_normals().expect("normals").map(Vec3::from).collect(),
                tangents: reader.read_tangents().into_iter().flatten().collect(),
                triangles: indices.as_chunks().0.to_vec(),
            });
        }
    }
    list
}

impl Primitive {
    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|i| self.positions[i as usize].as_dvec3())
    }

    /// Positive when the triangles run counter-clockwise seen from outside.
    fn volume(&self) -> f64 {
        let signed = |t: &[u32; 3]| {
            let [a, b, c] = self.corners(*t);
            a.dot(b.cross(c)) / 6.0
        };
        self.triangles.iter().map(signed).sum()
    }

    /// Every edge is used once in each direction.
    fn is_closed(&self) -> bool {
        let mut uses: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for [a, b, c] in &self.triangles {
            for edge in [(*a, *b), (*b, *c), (*c, *a)] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        uses.iter().all(|(&(a, b), &count)| count == 1 && uses.get(&(b, a)) == Some(&1))
    }

    /// The smallest height of a triangle over its longest side, as a share of that side.
    fn worst_triangle(&self) -> f64 {
        let flatness = |t: &[u32; 3]| {
            let [a, b, c] = self.corners(*t);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() / (longest * longest)
        };
        self.triangles.iter().map(flatness).fold(f64::INFINITY, f64::min)
    }

    fn has_unit_normals(&self) -> bool {
        self.normals.len() == self.positions.len()
            && self.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5)
    }

    /// The share of triangles that face against their corners' mean normal.
    fn contrary(&self) -> f64 {
        let contrary = self.triangles.iter().filter(|triangle| {
            let [a, b, c] = self.corners(**triangle);
            let normal: Vec3 = triangle.iter().map(|&i| self.normals[i as usize]).sum();
            (b - a).cross(c - a).dot(normal.as_dvec3()) <= 0.0
        });
        contrary.count() as f64 / self.triangles.len() as f64
    }
}

#[test]
fn generator_reproduces_every_file() {
    for (name, bytes) in generator::files(&ELEPHANT) {
        // Not assert_eq: megabytes of bytes help nobody.
        assert!(bytes == stored(name), "scenes/{name} is not what its generator makes");
    }
}

#[test]
fn a_millimetre_changes_the_bytes() {
    let moved = pair::PLACE + DVec3::new(0.001, 0.0, 0.0);
    assert!(pair::scene(&ELEPHANT, moved) != stored("pair.glb"));
}

#[test]
fn files_are_small_valid_and_have_a_camera() {
    for name in NAMES {
        let bytes = stored(name);
        assert!(bytes.len() < 1_500_000, "{name}: {} bytes", bytes.len());
        let document = Gltf::from_slice(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        let seen_by =
            document.nodes().find_map(|node| Some((node.name()?.to_owned(), node.camera()?)));
        let (_, camera) = seen_by.unwrap_or_else(|| panic!("{name}: no named camera"));
        assert!(matches!(camera.projection(), Projection::Perspective(_)), "{name}");
        assert!(document.nodes().all(|node| node.light().is_none()), "{name}");
    }
}

#[test]
fn surfaces_are_sound() {
    for name in NAMES {
        let document = Gltf::from_slice(&stored(name)).expect("a valid file");
        for primitive in primitives(&document) {
            let what = format!("{name}: {}", primitive.material);
            assert!(primitive.has_unit_normals(), "{what}");
            assert!(primitive.worst_triangle() > 1e-3, "{what}: {}", primitive.worst_triangle());
            assert!(primitive.contrary() < 1e-3, "{what}: {}", primitive.contrary());
            if CLOSED.contains(&primitive.material.as_str()) {
                assert!(primitive.is_closed(), "{what}");
                assert!(primitive.volume() > 0.0, "{what}");
            }
        }
    }
}

#[test]
fn faults_in_a_surface_are_seen() {
    let document = Gltf::from_slice(&stored("elephant.glb")).expect("a valid file");
    let fresh = || primitives(&document).swap_remove(1);
    assert!(fresh().is_closed() && fresh().has_unit_normals());

    let mut open = fresh();
    open.triangles.pop();
    assert!(!open.is_closed());

    let mut inside_out = fresh();
    inside_out.triangles.iter_mut().for_each(|triangle| triangle.reverse());
    assert!(inside_out.volume() < 0.0 && inside_out.contrary() > 0.99);

    let mut stretched = fresh();
    stretched.normals[0] *= 1.001;
    assert!(!stretched.has_unit_normals());

    let mut flat = fresh();
    let [a, b, _] = flat.triangles[0];
    flat.positions[a as usize] = flat.positions[b as usize];
    assert!(flat.worst_triangle() < 1e-3);
}

#[test]
fn elephant_stands_on_the_ground_and_is_fine_enough() {
    for name in ["elephant.glb", "pair.glb"] {
        let document = Gltf::from_slice(&stored(name)).expect("a valid file");
        let skin = primitives(&document).swap_remove(0);
        assert_eq!(skin.material, "elephant skin");
        assert!(skin.triangles.len() >= 8_000, "{}", skin.triangles.len());
        let lowest = skin.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
        assert!(lowest.abs() < 0.01, "{lowest}");
    }
    let pair = Gltf::from_slice(&stored("pair.glb")).expect("a valid file");
    assert_eq!(pair.nodes().filter(|node| node.mesh().is_some()).count(), 2);
}

#[test]
fn still_life_has_every_kind_of_material() {
    let document = Gltf::from_slice(&stored("still-life.glb")).expect("a valid file");
    let materials: Vec<_> = document.materials().collect();
    let surfaces: Vec<_> = materials.iter().map(|m| m.pbr_metallic_roughness()).collect();
    assert!(surfaces.iter().any(|s| s.metallic_factor() == 1.0));
    assert!(surfaces.iter().any(|s| s.roughness_factor() < 0.1));
    assert!(surfaces.iter().any(|s| s.roughness_factor() > 0.9));
    assert!(surfaces.iter().any(|s| s.base_color_texture().is_some()));
    assert!(materials.iter().any(|m| m.double_sided()));

    let bumpy = materials.iter().find(|m| m.normal_texture().is_some()).expect("a normal texture");
    let meshes = primitives(&document);
    let pot = meshes.iter().find(|p| Some(p.material.as_str()) == bumpy.name()).expect("its mesh");
    assert_eq!(pot.tangents.len(), pot.positions.len());
    for (tangent, normal) in pot.tangents.iter().zip(&pot.normals) {
        let along = Vec3::new(tangent[0], tangent[1], tangent[2]);
        assert!((along.length() - 1.0).abs() < 1e-5 && along.dot(*normal).abs() < 1e-5);
    }

    let coloured = document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
    assert!(coloured.into_iter().any(|p| p.get(&gltf::Semantic::Colors(0)).is_some()));
    let objects: BTreeSet<usize> =
        document.nodes().filter_map(|node| Some(node.mesh()?.index())).collect();
    assert!(objects.len() >= 6, "{}", objects.len());
    let plums = document.nodes().filter(|n| n.mesh().is_some_and(|m| m.name() == Some("plum")));
    assert_eq!(plums.count(), 3);
}
