//! Scenes of any number of triangles that look the same: a square sheet in relief, seen from the
//! front by a parallel camera. It hides nothing of itself and its outline is the same square, so that
//! the object pixels are the same whatever the number of triangles.

use crate::scene::view::{Camera, Projection};
use crate::scene::{Instance, Material, Mesh, Scene, Vertex};
use glam::{DMat4, DVec3, Vec3};
use std::f32::consts::PI;
use std::fmt::{self, Display};
use std::str::FromStr;

/// Tiles of a side; the relief repeats in each.
const TILES: u32 = 4;
/// The sheet goes from −1 to 1.
const SIDE: f32 = 2.0;
/// Share of the picture's height that the sheet fills: 70 % of a square picture.
const FILL: f64 = 0.84;
/// Least and most triangles.
const RANGE: std::ops::RangeInclusive<u32> = 100..=100_000_000;

/// A number of triangles, such as `10k` or `1M`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Triangles(pub u32);

impl FromStr for Triangles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = match text.strip_suffix(['k', 'K']) {
            Some(number) => (number, 1e3),
            None => text.strip_suffix(['m', 'M']).map_or((text, 1.0), |number| (number, 1e6)),
        };
        let count = number.parse().map_or(f64::NAN, |number: f64| (number * unit).round());
        match (f64::from(*RANGE.start())..=f64::from(*RANGE.end())).contains(&count) {
            true => Ok(Self(count as u32)),
            false => Err(format!("'{text}' is not a number of triangles from 100 to 100M")),
        }
    }
}

impl Display for Triangles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// The sheet of about so many triangles: one mesh, or one tile drawn 16 times.
pub fn scene(Triangles(triangles): Triangles, instanced: bool) -> Scene {
    let tiles = if instanced { TILES } else { 1 };
    let quads = f64::from(triangles / (2 * tiles * tiles)).max(1.0);
    let columns = quads.sqrt().round().max(1.0);
    let rows = (quads / columns).round().max(1.0);
    let side = SIDE / tiles as f32;
    let mesh = mesh([columns as u32, rows as u32], side);
    let each = mesh.triangles();
    let place = |tile: u32| {
        let corner = |tile: u32| f64::from(tile as f32 * side - SIDE / 2.0);
        DMat4::from_translation(DVec3::new(corner(tile % tiles), corner(tile / tiles), 0.0))
    };
    let instances = (0..tiles * tiles).map(|tile| Instance {
        name: format!("tile {tile}"),
        mesh: 0,
        world: place(tile),
        first_polygon: 1 + tile * each,
    });
    let material = Material {
        base_color: [0.7, 0.7, 0.7, 1.0],
        metallic: 0.0,
        roughness: 0.5,
        ..Material::default()
    };
    Scene {
        path: "relief".into(),
        instances: instances.collect(),
        meshes: vec![mesh],
        materials: vec![material],
        cameras: vec![camera()],
        ..Scene::default()
    }
}

fn camera() -> Camera {
    Camera {
        name: "front".into(),
        eye: DVec3::Z * 2.0,
        right: DVec3::X,
        up: DVec3::Y,
        back: DVec3::Z,
        projection: Projection::Orthographic { ymag: f64::from(SIDE) / 2.0 / FILL },
        near: 0.1,
        far: Some(4.0),
        designed: None,
    }
}

/// A grid of quads, two triangles each, from 0 to `side`.
fn mesh([columns, rows]: [u32; 2], side: f32) -> Mesh {
    let mut mesh = Mesh {
        name: "relief".into(),
        vertices: Vec::with_capacity((columns as usize + 1) * (rows as usize + 1)),
        indices: Vec::with_capacity(6 * columns as usize * rows as usize),
        material: 0,
    };
    for row in 0..=rows {
        for column in 0..=columns {
            mesh.vertices.push(vertex(
                side * (column as f32 / columns as f32),
                side * (row as f32 / rows as f32),
            ));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let low = row * (columns + 1) + column;
            let high = low + columns + 1;
            mesh.indices.extend([low, low + 1, high, high, low + 1, high + 1]);
        }
    }
    mesh
}

/// A point of the relief, `z = Σ h·sin(mx)·sin(ny)` with whole numbers of waves in a tile, and its
/// normal.
fn vertex(x: f32, y: f32) -> Vertex {
    let (mut z, mut slope_x, mut slope_y) = (0.0, 0.0, 0.0);
    for (height, m, n) in [(0.05, 1.0, 1.0), (0.012, 3.0, 2.0), (0.003, 10.0, 11.0)] {
        let turn = 2.0 * PI * TILES as f32 / SIDE;
        let (sin_x, cos_x) = (m * turn * x).sin_cos();
        let (sin_y, cos_y) = (n * turn * y).sin_cos();
        z += height * sin_x * sin_y;
        slope_x += height * m * turn * cos_x * sin_y;
        slope_y += height * n * turn * sin_x * cos_y;
    }
    Vertex {
        position: [x, y, z],
        normal: Vec3::new(-slope_x, -slope_y, 1.0).normalize().to_array(),
        tangent: [0.0; 4],
        uv: [[0.0; 2]; 2],
        color: [255; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::scene::view::View;

    #[test]
    fn numbers_of_triangles_have_units() {
        for (text, count) in [("100", 100), ("10k", 10_000), ("2.5K", 2500), ("20M", 20_000_000)] {
            assert_eq!(text.parse(), Ok(Triangles(count)));
        }
        for text in ["", "k", "99", "101M", "-5k", "nan", "inf", "1e9", "10kk"] {
            assert!(text.parse::<Triangles>().is_err(), "{text}");
        }
    }

    #[test]
    fn every_number_of_triangles_has_the_same_object_pixels() {
        let look = |triangles: u32, instanced| {
            let scene = scene(Triangles(triangles), instanced);
            assert!(f64::from(scene.polygons().abs_diff(triangles)) < 0.15 * f64::from(triangles));
            let last = scene.instances.last().unwrap();
            assert_eq!(scene.polygon(scene.polygons()).unwrap().0, scene.instances.len() - 1);
            assert_eq!(scene.polygon_range(last).end - 1, scene.polygons());
            let view = View::new(&scene, scene.cameras[0].clone(), 61, 50).unwrap();
            cpu::visibility::draw(&scene, &view)
        };
        let objects = |triangles, instanced| {
            let surface = look(triangles, instanced);
            surface.code.iter().map(|&code| code != 0).collect::<Vec<_>>()
        };
        let expected = objects(200, false);
        assert_eq!(expected.iter().filter(|&&object| object).count(), 42 * 42);
        for (triangles, instanced) in [(1000, false), (30_000, false), (1000, true), (30_000, true)]
        {
            assert!(objects(triangles, instanced) == expected, "{triangles} {instanced}");
        }
        // The tiles together are the sheet.
        let (whole, tiled) = (look(32 * 100, false), look(32 * 100, true));
        let pairs = whole.normal.iter().zip(&tiled.normal);
        assert!(pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).all(|d| d.abs() < 1e-3));
    }
}
