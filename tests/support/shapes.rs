//! Scenes made in code.

use glam::{DMat4, DVec3, Vec3};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Instance, Material, Mesh, Scene, Vertex};

/// A material without highlights to speak of.
pub fn matt(base: f32) -> Material {
    Material { base_color: [base, base, base, 1.0], metallic: 0.0, ..Material::default() }
}

/// A vertex with a normal and texture coordinates.
pub fn vertex(position: Vec3, normal: Vec3, uv: [f32; 2]) -> Vertex {
    Vertex {
        position: position.to_array(),
        normal: normal.to_array(),
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv: [uv; 2],
        color: [255; 4],
    }
}

/// The rectangle -x..x, -y..y in the plane z = 0, facing +z.
pub fn rectangle(x: f32, y: f32) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corner = |[u, v]: [f32; 2]| {
        vertex(Vec3::new(x * u, y * v, 0.0), Vec3::Z, [(u + 1.0) / 2.0, (1.0 - v) / 2.0])
    };
    Mesh {
        vertices: corners.map(corner).to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

/// The unit sphere, its poles up and down, `2·rings` columns.
pub fn sphere(rings: u32) -> Mesh {
    let columns = 2 * rings;
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        for column in 0..=columns {
            let (u, v) = (column as f32 / columns as f32, ring as f32 / rings as f32);
            let (polar, around) = (v * std::f32::consts::PI, u * std::f32::consts::TAU);
            let n = Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
            mesh.vertices.push(vertex(n, n, [u, v]));
        }
    }
    for ring in 0..rings {
        for column in 0..columns {
            let a = ring * (columns + 1) + column;
            let b = a + columns + 1;
            mesh.indices.extend([a, b, b + 1, a, b + 1, a + 1]);
        }
    }
    mesh
}

/// A scene of meshes, each with its material and place.
pub fn scene(parts: impl IntoIterator<Item = (Mesh, Material, DMat4)>) -> Scene {
    let mut scene = Scene::default();
    for (mut mesh, material, world) in parts {
        let first_polygon = scene.polygons() + 1;
        mesh.material = scene.materials.len() as u32;
        let instance = Instance {
            name: format!("part {}", scene.instances.len()),
            mesh: scene.meshes.len() as u32,
            world,
            first_polygon,
        };
        scene.materials.push(material);
        scene.meshes.push(mesh);
        scene.instances.push(instance);
    }
    scene.materials.push(Material::default());
    scene
}

/// A camera at `eye` that looks along -z.
pub fn camera(eye: DVec3, projection: Projection) -> Camera {
    Camera {
        name: "test".to_owned(),
        eye,
        right: DVec3::X,
        up: DVec3::Y,
        back: DVec3::Z,
        projection,
        near: 0.01,
        far: None,
        designed: None,
    }
}

/// Parallel rays along -z; the picture is `2·half_height` high.
pub fn orthographic(scene: &Scene, half_height: f64, width: u32, height: u32) -> View {
    let lens = Projection::Orthographic { ymag: half_height };
    view(scene, camera(DVec3::new(0.0, 0.0, 10.0), lens), width, height)
}

/// A view of a scene that has one.
pub fn view(scene: &Scene, camera: Camera, width: u32, height: u32) -> View {
    View::new(scene, camera, width, height).expect("the scene has an extent")
}
