//! What the engine shows: a floor, spheres and a torus, all made of arrays.

use crate::Result;
use klieg::glam::dcamera::rh::{proj, view};
use klieg::glam::{DMat4, DVec3};
use klieg::math::color::srgb_decode;
use klieg::scene::build::{MeshData, SceneBuilder};
use klieg::scene::engine::EngineCamera;
use klieg::scene::view::{Camera, Projection, bounds};
use klieg::scene::{Material, Scene};
use std::f64::consts::TAU;

const YFOV: f64 = 0.7;
const NEAR: f64 = 0.05;

/// Triangles as the engine holds them.
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
}

/// A mesh somewhere, of some material: in 8 bits each, as textures have them.
pub struct Thing {
    pub name: &'static str,
    pub mesh: usize,
    pub world_from_mesh: DMat4,
    /// sRGB-encoded.
    pub base_color: [u8; 3],
    pub roughness: u8,
    pub metallic: u8,
}

impl Thing {
    /// Linear base colour, roughness and metallic factor.
    pub fn material(&self) -> ([f32; 3], f32, f32) {
        let share = |byte| f32::from(byte) / 255.0;
        let base_color = self.base_color.map(|byte| srgb_decode(share(byte)));
        (base_color, share(self.roughness), share(self.metallic))
    }
}

pub struct World {
    pub meshes: Vec<Mesh>,
    pub things: Vec<Thing>,
}

impl World {
    pub fn new() -> Self {
        let floor =
            surface(24, 24, |u, v| (DVec3::new(3.0 * u - 1.5, 0.0, 1.5 - 3.0 * v), DVec3::Y));
        let sphere = surface(48, 24, |u, v| {
            let (sin, cos) = (TAU * u).sin_cos();
            let (r, y) = (TAU / 2.0 * v).sin_cos();
            let n = DVec3::new(r * sin, -y, r * cos);
            (n, n)
        });
        let torus = surface(64, 32, |u, v| {
            let (sin, cos) = (TAU * u).sin_cos();
            let (s, c) = (TAU * v).sin_cos();
            let n = DVec3::new(c * sin, s, c * cos);
            (DVec3::new(sin, 0.0, cos) + 0.35 * n, n)
        });
        let at = |x, y, z| DMat4::from_translation(DVec3::new(x, y, z));
        let sized = |size| DMat4::from_scale(DVec3::splat(size));
        let thing = |name, mesh, world_from_mesh, base_color, roughness, metallic| Thing {
            name,
            mesh,
            world_from_mesh,
            base_color,
            roughness,
            metallic,
        };
        let lying = at(0.6, 0.62, -0.35) * DMat4::from_rotation_x(1.1) * sized(0.45);
        let things = vec![
            thing("floor", 0, DMat4::IDENTITY, [150, 146, 140], 220, 0),
            thing("clay", 1, at(-0.7, 0.6, -0.1) * sized(0.6), [200, 137, 108], 150, 0),
            thing("copper", 1, at(0.35, 0.35, 0.7) * sized(0.35), [230, 180, 150], 120, 200),
            thing("pearl", 1, at(-0.35, 0.22, 0.9) * sized(0.22), [220, 220, 213], 100, 0),
            thing("torus", 2, lying, [124, 170, 196], 128, 0),
        ];
        Self { meshes: vec![floor, sphere, torus], things }
    }

    /// The same for klieg's level 1. A mesh of klieg's has one material, as in glTF.
    pub fn scene(&self) -> Result<Scene> {
        let mut builder = SceneBuilder::default();
        for thing in &self.things {
            let ([r, g, b], roughness, metallic) = thing.material();
            let material = builder.add_material(Material {
                base_color: [r, g, b, 1.0],
                roughness,
                metallic,
                ..Material::default()
            })?;
            let mesh = &self.meshes[thing.mesh];
            let mesh = builder.add_mesh(&MeshData {
                positions: &mesh.positions,
                normals: Some(&mesh.normals),
                indices: Some(&mesh.indices),
                material: Some(material),
                ..MeshData::default()
            })?;
            builder.add_instance(thing.name, mesh, thing.world_from_mesh)?;
        }
        Ok(builder.finish("engine_ash")?)
    }
}

/// A grid of `columns` by `rows` quads bent by `place`, which gives position and normal at (u, v) in
/// 0..1; fronts are where u goes right and v up.
fn surface(columns: u32, rows: u32, place: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Mesh {
    let (mut positions, mut normals, mut indices) = (vec![], vec![], vec![]);
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
            let (position, normal) = place(u, v);
            positions.push(position.as_vec3().to_array());
            normals.push(normal.as_vec3().to_array());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let low = row * (columns + 1) + column;
            let high = low + columns + 1;
            indices.extend([low, low + 1, high + 1, low, high + 1, high]);
        }
    }
    Mesh { positions, normals, indices }
}

/// The engine's camera, turned about the scene by `turn` radians: reversed depth without a far plane.
pub fn camera(scene: &Scene, turn: f64, [width, height]: [u32; 2]) -> Result<EngineCamera> {
    let (center, radius) = bounds(scene)?;
    let (sin, cos) = (turn + 0.3).sin_cos();
    let eye = DVec3::new(3.9 * sin, 1.9, 3.9 * cos);
    let aspect = f64::from(width) / f64::from(height);
    Ok(EngineCamera {
        view: view::look_at_mat4(eye, DVec3::new(0.0, 0.35, 0.0), DVec3::Y),
        projection: proj::vulkan::perspective_infinite_reverse(YFOV, aspect, NEAR),
        center,
        radius,
    })
}

/// The same camera for klieg's level 1.
pub fn lens(camera: &EngineCamera) -> Result<Camera> {
    Ok(Camera::from_view(&camera.view, Projection::Perspective { yfov: YFOV }, NEAR, None)?)
}
