//! Scenes from plain arrays: the same as the loaded ones, and every bad array refused.

use glam::{DMat4, DVec3, DVec4};
use klieg::Error;
use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::lighting::Population;
use klieg::lighting::presets::Preset;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, Shape};
use klieg::scene::build::{MeshData, SceneBuilder, TextureData};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Material, Scene, TextureRef, Vertex};

const SIZE: u32 = 96;

/// Three corners of a triangle.
const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn load(name: &str) -> Scene {
    let path = klieg_support::root().join(format!("scenes/{name}.glb"));
    klieg::scene::load::load(&path).unwrap()
}

/// What a test keeps of a scene's arrays.
#[derive(Clone, Copy)]
struct Keep {
    tangents: bool,
    /// Added to the x of every 16th vertex.
    shift: f32,
}

/// A scene again, from its arrays.
fn rebuilt(scene: &Scene, keep: Keep) -> Scene {
    let mut builder = SceneBuilder::default();
    for texture in &scene.textures {
        let full = &texture.levels[0];
        let data = TextureData {
            name: &texture.name,
            width: full.width,
            height: full.height,
            texels: &full.texels,
            srgb: texture.srgb,
            wrap: texture.wrap,
        };
        builder.add_texture(&data).unwrap();
    }
    let (default, materials) = scene.materials.split_last().unwrap();
    assert_eq!(default.name, "");
    for material in materials {
        builder.add_material(material.clone()).unwrap();
    }
    for mesh in &scene.meshes {
        let mut positions: Vec<_> = mesh.vertices.iter().map(|v| v.position).collect();
        positions.iter_mut().step_by(16).for_each(|position| position[0] += keep.shift);
        let normals: Vec<_> = mesh.vertices.iter().map(|v| v.normal).collect();
        let tangents: Vec<_> = mesh.vertices.iter().map(|v| v.tangent).collect();
        let uvs = [0, 1].map(|set| mesh.vertices.iter().map(|v| v.uv[set]).collect::<Vec<_>>());
        let colors: Vec<_> = mesh.vertices.iter().map(|v| v.color).collect();
        let data = MeshData {
            name: &mesh.name,
            positions: &positions,
            normals: Some(&normals),
            tangents: keep.tangents.then_some(&tangents),
            uvs: [Some(&uvs[0]), Some(&uvs[1])],
            colors: Some(&colors),
            indices: Some(&mesh.indices),
            material: Some(mesh.material).filter(|&m| (m as usize) < materials.len()),
        };
        builder.add_mesh(&data).unwrap();
    }
    for instance in &scene.instances {
        builder.add_instance(&instance.name, instance.mesh, instance.world).unwrap();
    }
    builder.finish("again").unwrap()
}

/// The maps of a scene's first view, and the scores of two rigs there.
fn measured(scene: &Scene, camera: &Camera) -> (Maps, Vec<f32>) {
    let view = View::new(scene, camera.clone(), SIZE, SIZE).unwrap();
    let objective = Objective::default();
    let maps = cpu::maps(cpu::visibility::draw(scene, &view), &objective);
    let mut evaluator =
        CpuEvaluator::new(maps.clone(), &view, objective, Shading::default()).unwrap();
    let scores = [Preset::ThreePoint, Preset::LightKit].map(|preset| {
        let mut score = [0.0];
        let rig = preset.rig();
        evaluator.evaluate(&Population::of([&rig[..]]).unwrap(), &mut score).unwrap();
        score[0]
    });
    (maps, scores.to_vec())
}

/// Whether two scenes give the same maps and scores, but for the rounding of normals.
fn same((a, scores_a): &(Maps, Vec<f32>), (b, scores_b): &(Maps, Vec<f32>)) -> bool {
    let close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6);
    let normals = [a, b].map(|maps| maps.surface.normal.as_flattened());
    let exact = |maps: &Maps| {
        let mut exact = maps.clone();
        exact.surface.normal.clear();
        exact.normal_detail = 0.0;
        exact.normal_gradient.clear();
        exact.shape = Shape::default();
        exact
    };
    exact(a) == exact(b)
        && close(normals[0], normals[1])
        && close(&[a.normal_detail], &[b.normal_detail])
        && close(&a.normal_gradient, &b.normal_gradient)
        && close(&a.shape.normal_covariance, &b.shape.normal_covariance)
        && close(scores_a, scores_b)
}

#[test]
fn a_scene_from_arrays_is_the_loaded_one() {
    let keep = Keep { tangents: true, shift: 0.0 };
    for name in ["elephant", "pair", "still-life"] {
        let loaded = load(name);
        let camera = &loaded.cameras[0];
        let again = rebuilt(&loaded, keep);
        assert_eq!((again.path.to_str(), again.polygons()), (Some("again"), loaded.polygons()));
        for (a, b) in loaded.textures.iter().zip(&again.textures) {
            assert!(a.levels.iter().zip(&b.levels).all(|(a, b)| a.texels == b.texels));
        }
        let expected = measured(&loaded, camera);
        assert!(same(&measured(&again, camera), &expected), "{name}");
        let computed = rebuilt(&loaded, Keep { tangents: false, ..keep });
        // Only one has a normal texture, and tangents of its own that are not quite MikkTSpace's.
        assert_eq!(same(&measured(&computed, camera), &expected), name != "still-life", "{name}");

        // Some vertices aside, another colour or another place are enough to tell.
        let mut others = vec![rebuilt(&loaded, Keep { shift: 0.02, ..keep }); 3];
        others[1] = again.clone();
        others[1].materials.iter_mut().for_each(|material| material.base_color[1] *= 0.9);
        others[2] = again.clone();
        others[2].instances[0].world.w_axis.y += 0.02;
        for (at, other) in others.iter().enumerate() {
            assert!(!same(&measured(other, camera), &expected), "{name}: {at}");
        }
    }
}

/// A scene of one mesh.
fn single(data: &MeshData) -> Scene {
    let mut builder = SceneBuilder::default();
    let mesh = builder.add_mesh(data).unwrap();
    builder.add_instance("", mesh, DMat4::IDENTITY).unwrap();
    builder.finish("").unwrap()
}

#[test]
fn what_is_missing_is_what_gltf_asks_for() {
    // Two triangles that share an edge at right angles.
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let indices = [0, 1, 2, 0, 2, 3];
    let flat = MeshData { positions: &positions, indices: Some(&indices), ..Default::default() };
    let scene = single(&flat);
    let normals = |scene: &Scene| -> Vec<[f32; 3]> {
        let mesh = &scene.meshes[0];
        mesh.indices.iter().map(|&i| mesh.vertices[i as usize].normal).collect()
    };
    let (z, x) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    assert_eq!(normals(&scene), [z, z, z, x, x, x]);
    assert!(scene.meshes[0].vertices.iter().all(|v| v.color == [255; 4] && v.uv == [[0.0; 2]; 2]));
    let default = &scene.materials[scene.meshes[0].material as usize];
    assert_eq!((default.base_color, default.metallic), ([1.0; 4], 1.0));

    // Normals of any length are made unit ones; one without a direction is that of its triangles.
    let given = [[0.0, 3.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
    let scene = single(&MeshData { normals: Some(&given), ..flat });
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (y, between) = ([0.0, 1.0, 0.0], [half, 0.0, half]);
    assert_eq!(normals(&scene), [y, y, between, y, between, x]);

    // Without indices every three vertices are a triangle; vertices that none uses are left out.
    assert_eq!(single(&MeshData { positions: &CORNERS, ..Default::default() }).polygons(), 1);
    let part = MeshData { indices: Some(&indices[..3]), normals: Some(&given), ..flat };
    assert_eq!(single(&part).meshes[0].vertices.len(), 3);
}

#[test]
fn numbers_of_polygons_run_on_and_what_is_scaled_to_nothing_is_left_out() {
    let mut builder = SceneBuilder::default();
    let mesh = MeshData { positions: &CORNERS, ..Default::default() };
    let mesh = builder.add_mesh(&mesh).unwrap();
    builder.add_instance("a", mesh, DMat4::IDENTITY).unwrap();
    builder.add_instance("hidden", mesh, DMat4::from_scale(DVec3::ZERO)).unwrap();
    builder.add_instance("b", mesh, DMat4::from_translation(DVec3::X)).unwrap();
    let scene = builder.finish("").unwrap();
    let numbers: Vec<_> = scene.instances.iter().map(|i| (&i.name[..], i.first_polygon)).collect();
    assert_eq!(numbers, [("a", 1), ("b", 2)]);
    assert_eq!(scene.warnings, ["instance 1 'hidden' is scaled to nothing: left out"]);
}

/// Whether `result` is a fault of the caller that is told with `words`.
#[track_caller]
fn refused<T: std::fmt::Debug>(result: klieg::Result<T>, words: &str) {
    let fault = result.unwrap_err();
    assert!(matches!(fault, Error::Argument(_)), "{fault:?}");
    assert!(fault.to_string().contains(words), "{fault}");
}

#[test]
fn bad_meshes_are_refused() {
    let good = MeshData { name: "cube", positions: &CORNERS, ..Default::default() };
    let add = |data: &MeshData| SceneBuilder::default().add_mesh(data);
    add(&good).unwrap();
    let refused = |data: MeshData, words: &str| {
        refused(add(&data), &format!("mesh 0 'cube': {words}"));
    };
    refused(MeshData { positions: &[], ..good }, "0 vertices without indices");
    refused(MeshData { positions: &CORNERS[..2], ..good }, "2 vertices without indices");
    refused(MeshData { indices: Some(&[]), ..good }, "0 indices");
    refused(MeshData { indices: Some(&[0, 1, 2, 0]), ..good }, "4 indices");
    refused(MeshData { indices: Some(&[0, 1, 3]), ..good }, "indices: index 3 at 2");
    let two = [[0.0; 3]; 2];
    refused(MeshData { normals: Some(&two), ..good }, "2 normals for 3 positions");
    refused(MeshData { tangents: Some(&[[0.0; 4]; 4]), ..good }, "4 tangents for 3");
    let uvs: &[[f32; 2]] = &[[0.0; 2]; 1];
    refused(MeshData { uvs: [Some(uvs), None], ..good }, "1 texture coordinates of set 0");
    refused(MeshData { uvs: [None, Some(uvs)], ..good }, "1 texture coordinates of set 1");
    refused(MeshData { colors: Some(&[]), ..good }, "0 colours for 3 positions");
    for value in [f32::NAN, f32::INFINITY] {
        let mut positions = CORNERS;
        positions[1][2] = value;
        refused(MeshData { positions: &positions, ..good }, "position of vertex 1");
    }
    refused(MeshData { material: Some(0), ..good }, "its material 0 is not there");
}

#[test]
fn bad_instances_and_empty_scenes_are_refused() {
    let mut builder = SceneBuilder::default();
    let data = MeshData { positions: &CORNERS, ..Default::default() };
    let mesh = builder.add_mesh(&data).unwrap();
    let mut add = |mesh, world| builder.add_instance("lamp", mesh, world);
    refused(add(1, DMat4::IDENTITY), "instance 0 'lamp': its mesh 1 is not there");
    refused(add(mesh, DMat4::NAN), "instance 0 'lamp': its transform is not finite");
    refused(add(mesh, DMat4::from_scale(DVec3::splat(1e300))), "not finite");
    let mut projective = DMat4::IDENTITY;
    projective.x_axis = DVec4::new(1.0, 0.0, 0.0, 0.5);
    refused(add(mesh, projective), "last row");
    refused(builder.finish("stage"), "stage: nothing to draw");

    let mut builder = SceneBuilder::default();
    let point = MeshData { positions: &[[1.0; 3]; 3], ..Default::default() };
    let mesh = builder.add_mesh(&point).unwrap();
    builder.add_instance("", mesh, DMat4::IDENTITY).unwrap();
    refused(builder.finish("stage"), "stage: nothing to draw has any extent");
}

#[test]
fn more_polygons_than_numbers_are_refused() {
    const TRIANGLES: usize = 1 << 20;
    let indices = [0u32, 1, 2].repeat(TRIANGLES);
    let normals = [[0.0, 0.0, 1.0]; 3];
    let mut builder = SceneBuilder::default();
    let many = MeshData {
        positions: &CORNERS,
        normals: Some(&normals),
        indices: Some(&indices),
        ..Default::default()
    };
    let many = builder.add_mesh(&many).unwrap();
    for _ in 0..4095 {
        builder.add_instance("", many, DMat4::IDENTITY).unwrap();
    }
    refused(builder.add_instance("", many, DMat4::IDENTITY), "more triangles than 32-bit");
    // What still has a number is taken.
    let one = MeshData { positions: &CORNERS, ..Default::default() };
    let one = builder.add_mesh(&one).unwrap();
    builder.add_instance("", one, DMat4::IDENTITY).unwrap();
}

#[test]
fn bad_materials_and_textures_are_refused() {
    let mut builder = SceneBuilder::default();
    let texels = [[128, 128, 255, 255]; 6];
    let good = TextureData { width: 3, height: 2, texels: &texels, ..Default::default() };
    let named = TextureData { name: "brick", ..good };
    let mut texture = |data| builder.add_texture(&data);
    refused(texture(TextureData { width: 2, ..named }), "texture 0 'brick': 6 texels");
    refused(texture(TextureData { width: 0, texels: &[], ..good }), "texture 0: its size is 0x2");
    refused(texture(TextureData { width: 16_385, ..good }), "16385x2");
    let linear = texture(good).unwrap();
    let srgb = texture(TextureData { srgb: true, ..good }).unwrap();

    let plain = Material { name: "wall".into(), ..Default::default() };
    let with = |texture| Material { normal_texture: Some(texture), ..plain.clone() };
    let mut add = |material| builder.add_material(material);
    let use_of = TextureRef::new;
    refused(add(with(use_of(2))), "material 0 'wall': its normal texture 2 is not there");
    refused(add(with(use_of(srgb))), "its normal texture 1 is sRGB-encoded");
    let metal = Material { metallic_roughness_texture: Some(use_of(srgb)), ..plain.clone() };
    refused(add(metal), "metallic-roughness texture 1 is sRGB-encoded");
    refused(add(with(TextureRef { uv_set: 2, ..use_of(linear) })), "coordinate set 2");
    let transform = [[f32::NAN; 3]; 2];
    refused(add(with(TextureRef { transform, ..use_of(linear) })), "transform");
    let roughness = f32::INFINITY;
    refused(add(Material { roughness, ..plain.clone() }), "a factor is not finite");

    let bumpy = add(with(use_of(linear))).unwrap();
    let colored = Material { base_color_texture: Some(use_of(srgb)), roughness: 7.0, ..plain };
    let colored = add(colored).unwrap();
    for (material, what) in [(bumpy, "normal"), (colored, "base colour")] {
        let material = Some(material);
        let bare = MeshData { positions: &CORNERS, material, ..Default::default() };
        refused(
            builder.add_mesh(&bare),
            &format!("mesh 0: it lacks coordinate set 0 of its {what}"),
        );
    }
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let (uvs, material) = ([Some(&uvs[..]), None], Some(bumpy));
    let whole = MeshData { positions: &CORNERS, uvs, material, ..Default::default() };
    let mesh = builder.add_mesh(&whole).unwrap();
    builder.add_instance("", mesh, DMat4::IDENTITY).unwrap();
    let scene = builder.finish("").unwrap();
    // v runs downwards, so that the tangent is +x and the bitangent's sign negative.
    let tangents: Vec<_> = scene.meshes[0].vertices.iter().map(|v: &Vertex| v.tangent).collect();
    assert_eq!(tangents, [[1.0, 0.0, 0.0, -1.0]; 3]);
    assert_eq!(scene.materials[colored as usize].roughness, 1.0);
}

#[test]
fn an_engines_camera_sees_what_the_files_does() {
    let scene = load("elephant");
    let file = &scene.cameras[0];
    let Projection::Perspective { .. } = file.projection else { panic!("a perspective camera") };
    let target = file.eye - file.back * 3.0;
    let look = Camera::look_at(file.eye, target, file.up, file.projection).unwrap();
    let look = Camera { near: file.near, far: file.far, ..look };
    let (expected, _) = measured(&scene, file);
    assert_eq!(measured(&scene, &look).0.surface.code, expected.surface.code);
    let aside = Camera { eye: file.eye + file.right * 0.1, ..look };
    assert_ne!(measured(&scene, &aside).0.surface.code, expected.surface.code);
}
