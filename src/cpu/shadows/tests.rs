use super::*;
use crate::cpu::visibility;
use crate::math::frame::Frame;
use crate::objective::shadows::{place, row_words};
use crate::scene::build::{MeshData, SceneBuilder, TextureData};
use crate::scene::framing::{Framing, frame};
use crate::scene::occluders::Node;
use crate::scene::view::View;
use crate::scene::{Material, Scene, TextureRef};
use glam::{DMat4, DVec3};

/// A closed box of half the given size around the origin.
fn cuboid(builder: &mut SceneBuilder, [x, y, z]: [f32; 3], material: Option<u32>) -> u32 {
    let mut positions = Vec::new();
    let half = Vec3::new(x, y, z);
    for axis in 0..3 {
        for sign in [-1.0f32, 1.0] {
            let n = Vec3::AXES[axis] * sign;
            let (a, b) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3] * sign);
            let corner = |u: f32, v: f32| ((n + a * u + b * v) * half).to_array();
            let [p, q, r, s] =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            positions.extend([p, q, r, p, r, s]);
        }
    }
    builder.add_mesh(&MeshData { positions: &positions, material, ..MeshData::default() }).unwrap()
}

fn at(builder: &mut SceneBuilder, mesh: u32, [x, y, z]: [f64; 3]) {
    let world = DMat4::from_translation(DVec3::new(x, y, z));
    builder.add_instance("", mesh, world).unwrap();
}

/// Boxes that touch each other, a thin wall between two of them, and a floor.
fn boxes() -> Scene {
    let mut builder = SceneBuilder::default();
    let cube = cuboid(&mut builder, [0.5, 0.5, 0.5], None);
    let wall = cuboid(&mut builder, [0.02, 1.0, 1.0], None);
    let floor = cuboid(&mut builder, [3.0, 0.05, 3.0], None);
    at(&mut builder, cube, [-1.0, 0.5, 0.0]);
    at(&mut builder, cube, [-1.0, 1.5, 0.0]);
    at(&mut builder, cube, [1.2, 0.5, 0.3]);
    at(&mut builder, wall, [0.0, 1.0, 0.0]);
    at(&mut builder, floor, [0.0, -0.05, 0.0]);
    builder.finish("boxes").unwrap()
}

fn seen(scene: &Scene, side: u32) -> (View, Surface, Arc<Occluders>) {
    let framing = Framing { azimuth: -0.6, elevation: 0.7, ..Framing::default() };
    let camera = frame(scene, &framing, 1.0).unwrap();
    let view = View::new(scene, camera, side, side).unwrap();
    let surface = visibility::draw(scene, &view);
    let occluders = Arc::new(Occluders::new(scene, &view).unwrap());
    (view, surface, occluders)
}

fn settings(side: u32) -> ShadowSettings {
    ShadowSettings { on: true, side, ..ShadowSettings::default() }
}

#[test]
fn beams_find_what_single_rays_find() {
    let (_, surface, occluders) = seen(&boxes(), 61);
    for side in [7, 31, 35] {
        let fast = table(&surface, occluders.clone(), &settings(side));
        let plain = reference(&surface, occluders.clone(), side);
        assert!(fast == plain, "side {side}");
        assert_eq!(fast.openness(), plain.openness());
        let closed = |shadows: &Shadows| shadows.blocks().contains(&0);
        assert!(closed(&fast), "something is in the shadow of whole rows");
    }
    let mut fewer = (*occluders).clone();
    fewer.triangles[7].corner[0] += 0.5;
    assert!(table(&surface, Arc::new(fewer), &settings(31)) != reference(&surface, occluders, 31));
}

/// A sheet with hills, of many more triangles than pixels.
fn hills() -> Scene {
    let side = 160;
    let place = |at: u32| 2.0 * at as f32 / (side - 1) as f32 - 1.0;
    let height = |x: f32, y: f32| 0.2 * (9.0 * x).sin() * (7.0 * y).cos();
    let positions: Vec<_> =
        grid(side).map(|at| at.map(place)).map(|[x, y]| [x, height(x, y), y]).collect();
    let quad = |[x, y]: [u32; 2]| {
        let at = y * side + x;
        [at, at + side, at + 1, at + 1, at + side, at + side + 1]
    };
    let indices: Vec<u32> = grid(side - 1).flat_map(quad).collect();
    let mut builder = SceneBuilder::default();
    let mesh = MeshData { positions: &positions, indices: Some(&indices), ..MeshData::default() };
    let mesh = builder.add_mesh(&mesh).unwrap();
    at(&mut builder, mesh, [0.0; 3]);
    builder.finish("hills").unwrap()
}

#[test]
fn rays_of_a_pixel_find_what_single_rays_find() {
    let (_, surface, occluders) = seen(&hills(), 61);
    for side in [7, 31, 35] {
        let squares = squares(side);
        let plain = reference(&surface, occluders.clone(), side);
        let fast = table(&surface, occluders.clone(), &settings(side));
        assert!(fast == plain, "side {side}");
        for pixels in tiles(&surface) {
            let tile = Tile::new(&surface, &pixels);
            let bits = rays::trace(&tile, &occluders, &squares, words(side));
            for (lane, &at) in pixels.iter().enumerate() {
                let number = plain.number(at as usize).unwrap();
                let of_lane = bits.chunks_exact(tile::LANES).map(|word| word[lane]);
                assert!(of_lane.eq((0..words(side)).map(|word| plain.word(number, word))));
            }
        }
        assert!(plain.openness().iter().any(|&open| open < 0.9), "hills shadow valleys");
    }
}

#[test]
fn occluders_of_one_view_serve_another_when_they_are_turned() {
    for scene in [boxes(), hills()] {
        let (first, _, occluders) = seen(&scene, 61);
        let framing = Framing { azimuth: 1.9, elevation: 0.2, ..Framing::default() };
        let view = View::new(&scene, frame(&scene, &framing, 1.0).unwrap(), 61, 61).unwrap();
        let surface = visibility::draw(&scene, &view);
        let own = Arc::new(Occluders::new(&scene, &view).unwrap());
        let turned = occluders.turned(first.frame.change_to(&view.frame).turn);
        assert_eq!(
            (turned.triangles.len(), turned.nodes.len()),
            (own.triangles.len(), occluders.nodes.len())
        );
        let fast = table(&surface, Arc::new(turned), &settings(31));
        let expected = table(&surface, own, &settings(31));
        let differ =
            std::iter::zip(fast.blocks(), expected.blocks()).map(|(a, b)| (a ^ b).count_ones());
        let (differ, all) = (differ.sum::<u32>(), 32 * expected.blocks().len());
        // Rounding moves what just touches an edge.
        assert!((differ as usize) < all / 5000, "{differ} of {all}");
        let unturned = table(&surface, occluders, &settings(31));
        assert!(unturned != expected);
    }
}

#[test]
fn wide_nodes_have_every_leaf_once() {
    for scene in [boxes(), hills()] {
        let (_, _, occluders) = seen(&scene, 16);
        let tree = Tree::new(&occluders);
        let children = tree.nodes.iter().flat_map(|boxes| boxes.iter().map(|(_, child)| child));
        let (mut leaves, mut inner) = (Vec::new(), vec![0]);
        children.for_each(|child| match child {
            wide::Child::Leaf(first, count) => leaves.push(first..first + count),
            wide::Child::Inner(at) => inner.push(at),
        });
        leaves.sort_unstable_by_key(|leaf| leaf.start);
        let ranges = occluders.nodes.iter().map(Node::range).filter(|range| !range.is_empty());
        assert!(ranges.eq(leaves.iter().map(|leaf| leaf.start as usize..leaf.end as usize)));
        inner.sort_unstable();
        assert!((0..tree.nodes.len() as u32).eq(inner));
    }
}

/// A point of the world and the pixel that shows the nearest of the surface to it.
fn pixel(surface: &Surface, frame: &Frame, [x, y, z]: [f64; 3]) -> usize {
    let p = frame.from_world().transform_point3(DVec3::new(x, y, z)).as_vec3();
    let distance = |&at: &usize| (Vec3::from(surface.position[at]) - p).length();
    let object = (0..surface.code.len()).filter(|&at| surface.code[at] != 0);
    let nearest = object.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
    assert!(distance(&nearest) < 0.05, "no pixel shows {x} {y} {z}");
    nearest
}

#[test]
fn contacts_neither_leak_nor_speckle() {
    let scene = boxes();
    let (view, surface, occluders) = seen(&scene, 128);
    let shadows = table(&surface, occluders, &settings(31));
    let turned = |d: [f64; 3]| {
        let into = view.frame.from_world();
        into.transform_vector3(DVec3::from(d)).normalize().as_vec3()
    };
    let sees = |p: [f64; 3], d: [f64; 3]| {
        let number = shadows.number(pixel(&surface, &view.frame, p)).unwrap();
        shadows.towards(number, turned(d))
    };
    // Top of the upper cube: open to all sides, up to the horizon.
    for d in [[0.0, 1.0, 0.0], [1.0, 0.3, 0.2], [-1.0, 0.3, 0.5]] {
        assert_eq!(sees([-1.0, 2.0, 0.0], d), 1.0, "{d:?}");
    }
    // Floor beside the wall, up to the very contact, with the light behind the wall.
    let (behind, before) = (turned([1.0, 0.4, 0.0]), turned([-0.3, 1.0, 0.6]));
    let object = (0..surface.code.len()).filter(|&at| surface.code[at] != 0);
    let beside: Vec<usize> = object
        .filter(|&at| {
            let p = view.frame.point_to_world(Vec3::from(surface.position[at]).as_dvec3());
            p.y.abs() < 1e-4 && (-0.5..-0.02).contains(&p.x) && (0.5..0.9).contains(&p.z)
        })
        .map(|at| shadows.number(at).unwrap())
        .collect();
    assert!(beside.len() > 20);
    assert!(beside.iter().all(|&number| shadows.towards(number, behind) == 0.0));
    assert!(beside.iter().all(|&number| shadows.towards(number, before) == 1.0));
    // Floor in front of a cube's foot, the light behind the cube.
    assert_eq!(sees([-1.0, 0.0, 0.75], [0.0, 0.5, -1.0]), 0.0);
    // Dark specks: in the open, every neighbour is as light as the next.
    let up = turned([0.3, 1.0, 0.4]);
    let lit = |at: usize| shadows.towards(shadows.number(at).unwrap(), up);
    let top = (0..surface.code.len()).filter(|&at| surface.code[at] != 0);
    let tops = top.filter(|&at| {
        let p = view.frame.point_to_world(Vec3::from(surface.position[at]).as_dvec3());
        p.y > 1.99
    });
    assert!(tops.clone().count() > 100 && tops.into_iter().all(|at| lit(at) == 1.0));
}

#[test]
fn an_alpha_mask_lets_light_through_where_it_is_cut_out() {
    let mut builder = SceneBuilder::default();
    let texels = [[255, 255, 255, 255], [255, 255, 255, 0]];
    let half = TextureData { width: 2, height: 1, texels: &texels, ..TextureData::default() };
    let half = builder.add_texture(&half).unwrap();
    let material = Material {
        base_color_texture: Some(TextureRef::new(half)),
        alpha_cutoff: 0.5,
        double_sided: true,
        ..Material::default()
    };
    let masked = builder.add_material(material).unwrap();
    let corners = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let sheet = builder
        .add_mesh(&MeshData {
            positions: &corners,
            uvs: [Some(&uvs), None],
            indices: Some(&[0, 2, 1, 0, 3, 2]),
            material: Some(masked),
            ..MeshData::default()
        })
        .unwrap();
    let floor = cuboid(&mut builder, [2.0, 0.1, 2.0], None);
    at(&mut builder, sheet, [0.0, 1.0, 0.0]);
    at(&mut builder, floor, [0.0, -0.1, 0.0]);
    let scene = builder.finish("sheet").unwrap();
    let (view, surface, occluders) = seen(&scene, 96);
    let fast = table(&surface, occluders.clone(), &settings(15));
    assert!(fast == reference(&surface, occluders.clone(), 15));
    let up = view.frame.from_world().transform_vector3(DVec3::Y).normalize().as_vec3();
    let open = |x: f64| {
        let p = view.frame.from_world().transform_point3(DVec3::new(x, 0.0, 0.8)).as_vec3();
        !occluders.blocked(p + 0.001 * up, up, f32::INFINITY)
    };
    assert!(!open(-0.5) && open(0.5) && open(1.5));
}

#[test]
fn a_table_is_given_up_when_nobody_wants_it() {
    let scene = boxes();
    let (_, surface, occluders) = seen(&scene, 32);
    let made =
        |go_on: bool| table_while(&surface, Arc::clone(&occluders), &settings(15), &|| go_on);
    assert!(made(true).unwrap() == table(&surface, Arc::clone(&occluders), &settings(15)));
    assert!(matches!(made(false), Err(Error::Interrupted)));
}

#[test]
fn directions_have_their_places() {
    for side in [3, 15, 31, 63] {
        for (at, d) in (0..side * side).map(|at| ([at % side, at / side], at)) {
            let [u, v] = place(direction(side, at)).map(|c| c * (side - 1) as f32);
            let [x, y] = at.map(|c| c as f32);
            // On the map's border every direction has two places.
            let border = at.iter().any(|&c| c == 0 || c == side - 1);
            assert!(border || (u - x).abs() + (v - y).abs() < 1e-3, "{d}: {u} {v}");
        }
        let solid = |at: u32| solid_angle(side, [at % side, at / side]);
        let all: f32 = (0..side * side).map(solid).sum();
        let cell = 4.0 / ((side - 1) * (side - 1)) as f32;
        // dΩ = du·dv / (|u|² + |v|² + z²)^(3/2) on the octahedron's faces.
        let sphere = all * cell / (4.0 * std::f32::consts::PI);
        assert!(side == 3 || (sphere - 1.0).abs() < 0.02, "{side}: {sphere}");
    }
    assert_eq!([31, 32, 33, 63].map(row_words), [1, 1, 2, 2]);
}

#[test]
fn a_table_takes_no_more_than_its_memory() {
    let settings = ShadowSettings { on: true, side: 31, memory: 1 };
    assert_eq!(settings.fitting_side(1000), 31);
    assert_eq!(settings.fitting_side(20_000), 13);
    assert_eq!(settings.fitting_side(1 << 30), 3);
}
