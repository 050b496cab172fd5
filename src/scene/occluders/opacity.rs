//! Alpha masks as cells of triangles, in which neither walks on the host nor those on a device need any
//! texture.

use crate::constants::OPAQUE;
use crate::scene::{Instance, Material, Mesh, Scene, TextureRef, Vertex, texture};
use glam::{Vec2, Vec3};

/// Most cells along an edge of a triangle.
const MAX_CELLS: f32 = 128.0;
/// Most words of all cells: 256 MiB. What comes later has a single cell for each triangle.
const MAX_WORDS: usize = 1 << 26;

/// Cells of triangles; see [`super::Occluders::opacity`].
#[derive(Debug, Default)]
pub struct Opacity {
    pub words: Vec<u32>,
    /// Where the cells of a mesh's triangles begin, by the mesh.
    known: Vec<(u32, Vec<u32>)>,
}

impl Opacity {
    /// Where the cells of each triangle of an instance begin.
    pub fn of(&mut self, scene: &Scene, instance: &Instance) -> Vec<u32> {
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        if material.alpha_cutoff <= 0.0 {
            return vec![OPAQUE; mesh.triangles() as usize];
        }
        if let Some((_, cells)) = self.known.iter().find(|(known, _)| *known == instance.mesh) {
            return cells.clone();
        }
        let triangle = |t| self.add(scene, material, corners(mesh, t));
        let cells: Vec<u32> = (0..mesh.triangles()).map(triangle).collect();
        self.known.push((instance.mesh, cells.clone()));
        cells
    }

    /// Adds a triangle's cells, if it is not opaque all over.
    fn add(&mut self, scene: &Scene, material: &Material, corners: [&Vertex; 3]) -> u32 {
        let map = material.base_color_texture.as_ref();
        let n = match self.words.len() < MAX_WORDS {
            true => map.map_or(1, |map| cells(scene, map, corners)),
            false => 1,
        };
        let first = self.words.len();
        self.words.push(n);
        self.words.resize(first + 1 + (2 * n * n).div_ceil(32) as usize, 0);
        let mut opaque = true;
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            for beyond in 0..2u32 {
                // Centroid of the half cell.
                let off = if beyond == 1 { 2.0 / 3.0 } else { 1.0 / 3.0 };
                let (u, v) = ((i as f32 + off) / n as f32, (j as f32 + off) / n as f32);
                if u + v > 1.0 {
                    continue;
                }
                let alpha = alpha(scene, material, corners, Vec3::new(1.0 - u - v, u, v));
                let bit = 2 * (i * n + j) + beyond;
                let blocks = alpha >= material.alpha_cutoff;
                self.words[first + 1 + (bit / 32) as usize] |= u32::from(blocks) << (bit % 32);
                opaque &= blocks;
            }
        }
        if opaque {
            self.words.truncate(first);
            return OPAQUE;
        }
        first as u32
    }
}

fn corners(mesh: &Mesh, triangle: u32) -> [&Vertex; 3] {
    let at = 3 * triangle as usize;
    [0, 1, 2].map(|k| &mesh.vertices[mesh.indices[at + k] as usize])
}

fn uv(map: &TextureRef, vertex: &Vertex) -> Vec2 {
    let at = Vec2::from(vertex.uv[map.uv_set as usize & 1]).extend(1.0);
    let [u, v] = map.transform.map(Vec3::from);
    Vec2::new(u.dot(at), v.dot(at))
}

/// Cells along an edge, so that a cell is about a texel.
fn cells(scene: &Scene, map: &TextureRef, corners: [&Vertex; 3]) -> u32 {
    let full = &scene.textures[map.texture as usize].levels[0];
    let size = Vec2::new(full.width as f32, full.height as f32);
    let [a, b, c] = corners.map(|vertex| uv(map, vertex) * size);
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    longest.ceil().clamp(1.0, MAX_CELLS) as u32
}

fn alpha(scene: &Scene, material: &Material, corners: [&Vertex; 3], weights: Vec3) -> f32 {
    let blend = |value: &dyn Fn(&Vertex) -> f32| weights.dot(corners.map(value).into());
    let vertex = blend(&|vertex| f32::from(vertex.color[3]) / 255.0);
    let image = material.base_color_texture.as_ref().map_or(1.0, |map| {
        let at = Vec2::new(blend(&|vertex| uv(map, vertex).x), blend(&|vertex| uv(map, vertex).y));
        texture::sample(&scene.textures[map.texture as usize], at, Vec2::ZERO, Vec2::ZERO).w
    });
    material.base_color[3] * vertex * image
}
