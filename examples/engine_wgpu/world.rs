//! What the engine shows: a relief with three balls and a ring on it, and a camera that moves.

use bytemuck::{Pod, Zeroable};
use glam::dcamera::rh::{proj::directx, view};
use glam::{DMat4, DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// A corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Vertex {
    /// World units, y up.
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub material: Material,
}

/// What an object is made of, and its number from 1.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Material {
    /// Linear RGB.
    pub base_color: [f32; 3],
    pub roughness: f32,
    pub metallic: f32,
    pub object: u32,
}

/// A ball of the world.
pub struct Ball {
    pub object: u32,
    pub center: Vec3,
    pub radius: f32,
}

pub const BALLS: [Ball; 3] = [
    Ball { object: 2, center: Vec3::new(-0.8, 0.45, -0.2), radius: 0.45 },
    Ball { object: 3, center: Vec3::new(0.75, 0.35, 0.35), radius: 0.35 },
    Ball { object: 4, center: Vec3::new(0.5, 0.6, -0.8), radius: 0.6 },
];

/// All objects as one list of triangles.
pub struct World {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
}

impl World {
    pub fn new() -> Self {
        let mut world = Self { vertices: Vec::new(), indices: Vec::new() };
        world.grid(1, ([0.45, 0.4, 0.34], 0.8, 0.0), [48, 48], |u, v| {
            let (x, z) = (3.6 * u - 1.8, 3.6 * v - 1.8);
            Vec3::new(x, 0.06 * (4.0 * x).sin() * (3.0 * z + 1.0).cos(), z)
        });
        let rough = ([0.7, 0.25, 0.2], 0.6, 0.0);
        let glossy = ([0.2, 0.45, 0.7], 0.25, 0.0);
        let metal = ([0.9, 0.75, 0.45], 0.4, 1.0);
        for (Ball { object, center, radius }, material) in BALLS.iter().zip([rough, glossy, metal])
        {
            world.grid(*object, material, [32, 16], |u, v| {
                let ((sin, cos), (y, ring)) = ((TAU * u).sin_cos(), polar(v));
                *center + *radius * Vec3::new(ring * cos, y, ring * sin)
            });
        }
        world.grid(5, ([0.6, 0.6, 0.55], 0.5, 0.0), [48, 16], |u, v| {
            let ((sin, cos), (tube_sin, tube_cos)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            let ring = 0.42 + 0.14 * tube_cos;
            Vec3::new(-0.2 + ring * cos, 0.18 + 0.14 * tube_sin, 0.75 + ring * sin)
        });
        world
    }

    /// Centre of the bounding box, and the largest distance of a vertex from it.
    pub fn bounds(&self) -> (DVec3, f64) {
        let points = || self.vertices.iter().map(|v| Vec3::from(v.position).as_dvec3());
        let lowest = points().fold(DVec3::INFINITY, DVec3::min);
        let highest = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let center = (lowest + highest) / 2.0;
        (center, points().map(|p| p.distance(center)).fold(0.0, f64::max))
    }

    /// A surface over 0..=1 squared: `cells` squares of two triangles each.
    fn grid(
        &mut self,
        object: u32,
        (base_color, roughness, metallic): ([f32; 3], f32, f32),
        cells: [u32; 2],
        point: impl Fn(f32, f32) -> Vec3,
    ) {
        let first = self.vertices.len() as u32;
        let material = Material { base_color, roughness, metallic, object };
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let (u, v) = (i as f32 / cells[0] as f32, j as f32 / cells[1] as f32);
                let step = 1e-3;
                let along_u = point(u + step, v) - point(u - step, v);
                let along_v = point(u, v + step) - point(u, v - step);
                let normal = along_v.cross(along_u).normalize_or(Vec3::Y).to_array();
                let position = point(u, v).to_array();
                self.vertices.push(Vertex { position, normal, material });
            }
        }
        let row = cells[0] + 1;
        for corner in (0..cells[1]).flat_map(|j| (0..cells[0]).map(move |i| j * row + i)) {
            let [a, b, c, d] = [0, 1, row, row + 1].map(|k| first + corner + k);
            self.indices.extend([a, c, b, b, c, d]);
        }
    }
}

/// Height and radius of the ring of a unit ball at `v` from its bottom (0) to its top (1).
fn polar(v: f32) -> (f32, f32) {
    // The poles are a little inside, where the ball still has two directions.
    let (sin, cos) = (PI * v.clamp(2e-3, 1.0 - 2e-3)).sin_cos();
    (-cos, sin)
}

/// Where the engine looks from.
pub struct Camera {
    pub eye: DVec3,
    /// Eye from world: right-handed, looking along -z.
    pub view: DMat4,
    /// Clip from eye: y up, depth 1 at the near plane and 0 at infinity.
    pub projection: DMat4,
}

impl Camera {
    /// On a circle around the world, `turn` radians from the front.
    pub fn orbit(turn: f64, aspect: f64) -> Self {
        let eye = DVec3::new(4.2 * turn.sin(), 2.2, 4.2 * turn.cos());
        Self {
            eye,
            view: view::look_at_mat4(eye, DVec3::new(0.0, 0.25, 0.0), DVec3::Y),
            projection: directx::perspective_infinite_reverse(0.75, aspect, 0.1),
        }
    }

    pub fn clip_from_world(&self) -> DMat4 {
        self.projection * self.view
    }
}
