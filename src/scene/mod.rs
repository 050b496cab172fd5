//! The scene as it is drawn: triangles, materials, textures, cameras and lights, all in world space.

mod assemble;
pub mod build;
pub mod camera;
mod check;
pub mod engine;
pub mod framing;
pub mod lights;
pub mod lit;
pub mod load;
mod memory;
mod mips;
pub mod occluders;
mod tangents;
pub(crate) mod texture;
pub mod view;

use crate::lighting::{Cone, LightKind};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};
use std::ops::Range;
use std::path::PathBuf;

/// What making a part of a scene gives; the fault is put behind the name of what it is a part of.
type Parsed<T> = std::result::Result<T, String>;

/// A scene, ready to be drawn. Loaded from glTF by [`load::load`], or made from an engine's arrays by
/// [`build::SceneBuilder`].
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The file that it came from; the name of a scene that was made from arrays.
    pub path: PathBuf,
    /// All files that it was read from, `path` first; none of a scene that was made from arrays.
    pub files: Vec<PathBuf>,
    /// All files that its file names, read or not.
    pub named: Vec<PathBuf>,
    /// Triangle meshes, one for each glTF primitive, stored once however often they are drawn.
    pub meshes: Vec<Mesh>,
    /// Materials; a mesh names one by its index. Never empty: glTF's default material stands last.
    pub materials: Vec<Material>,
    /// Images with their sampling, decoded.
    pub textures: Vec<Texture>,
    /// What is drawn, in order of first polygon number.
    pub instances: Vec<Instance>,
    /// The file's cameras that stand in the scene.
    pub cameras: Vec<view::Camera>,
    /// The file's lights (KHR_lights_punctual) that stand in the scene.
    pub lights: Vec<SceneLight>,
    /// What was left out or replaced in loading, for people to read.
    pub warnings: Vec<String>,
}

/// A vertex, 60 bytes; the GPU reads the same bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Position in the mesh's own space.
    pub position: [f32; 3],
    /// Unit normal; computed where the file has none.
    pub normal: [f32; 3],
    /// Unit tangent and the bitangent's sign (±1); zero where the material has no normal texture.
    pub tangent: [f32; 4],
    /// Texture coordinate sets 0 and 1.
    pub uv: [[f32; 2]; 2],
    /// Linear vertex colour, RGBA, 255 = 1; white where the file has none.
    pub color: [u8; 4],
}

/// An indexed list of triangles.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// The glTF mesh's name, for people.
    pub name: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three for each triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

impl Mesh {
    /// Number of triangles.
    pub fn triangles(&self) -> u32 {
        (self.indices.len() / 3) as u32
    }
}

/// One drawing of a mesh.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The node's name, for people.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// World from mesh space.
    pub world: DMat4,
    /// Colour code of the instance's first triangle; triangle `t` has `first_polygon + t`. The
    /// scene's first is 1, as 0 is the background.
    pub first_polygon: u32,
}

/// glTF metallic-roughness material.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name, for people.
    pub name: String,
    /// Linear base colour and alpha, multiplied by texture and vertex colour.
    pub base_color: [f32; 4],
    /// 0..1, multiplied by the texture's blue channel.
    pub metallic: f32,
    /// 0..1, multiplied by the texture's green channel.
    pub roughness: f32,
    /// Linear emitted radiance (KHR_materials_emissive_strength multiplied in).
    pub emissive: [f32; 3],
    /// sRGB base colour and linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// Linear; roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear tangent-space normals.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// Pixels whose alpha is below this are not drawn; 0 for opaque materials. Blended materials
    /// have 0.5: what is more than half transparent shows what stands behind.
    pub alpha_cutoff: f32,
    /// Whether back faces are drawn.
    pub double_sided: bool,
}

impl Default for Material {
    /// glTF's default material.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            metallic: 1.0,
            roughness: 1.0,
            emissive: [0.0; 3],
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive_texture: None,
            alpha_cutoff: 0.0,
            double_sided: false,
        }
    }
}

/// A material's use of a texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::textures`].
    pub texture: u32,
    /// Which of the vertex's coordinate sets, 0 or 1.
    pub uv_set: u32,
    /// KHR_texture_transform as the rows of a 2×3 matrix: `u' = m[0]·(u, v, 1)`, `v' = m[1]·(u, v, 1)`.
    pub transform: [[f32; 3]; 2],
}

impl TextureRef {
    /// No transform of the coordinates.
    pub const UNMOVED: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// A texture by coordinate set 0, unmoved.
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: Self::UNMOVED }
    }
}

/// How a texture continues outside 0..1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Tiled.
    #[default]
    Repeat,
    /// Tiled, every other tile mirrored.
    Mirror,
    /// The border's texel.
    Clamp,
}

/// A decoded image with its mip chain. Sampling is trilinear.
#[derive(Debug, Clone)]
pub struct Texture {
    /// Name, for people.
    pub name: String,
    /// Whether RGB is sRGB-encoded (alpha never is).
    pub srgb: bool,
    /// Horizontal and vertical wrap.
    pub wrap: [Wrap; 2],
    /// Mip levels, the full picture first, each half of the one before (rounded down, at least 1).
    pub levels: Vec<TextureLevel>,
}

/// One mip level: `width × height` RGBA texels, rows from the top.
#[derive(Debug, Clone)]
pub struct TextureLevel {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, 8 bits each; `width · height` of them.
    pub texels: Vec<[u8; 4]>,
}

/// A KHR_lights_punctual light that stands in the scene.
#[derive(Debug, Clone)]
pub struct SceneLight {
    /// The node's or the light's name.
    pub name: String,
    /// Where it stands (point, spot), world units.
    pub position: DVec3,
    /// Unit vector from the light into the scene (directional, spot).
    pub direction: DVec3,
    /// Kind.
    pub kind: LightKind,
    /// Cone of a spot light.
    pub cone: Cone,
    /// Linear colour.
    pub color: [f32; 3],
    /// Candela (point, spot) or lux (directional).
    pub intensity: f32,
    /// World units beyond which it counts as dark; `None` where it reaches everywhere.
    pub range: Option<f32>,
    /// The klieg block of the light's `extras`, where klieg wrote it.
    pub klieg: Option<serde_json::Value>,
}

impl Scene {
    /// Number of drawn triangles, instances counted each.
    pub fn polygons(&self) -> u32 {
        self.instances.last().map_or(0, |i| self.polygon_range(i).end - 1)
    }

    /// Colour codes of an instance.
    pub fn polygon_range(&self, instance: &Instance) -> Range<u32> {
        instance.first_polygon
            ..instance.first_polygon + self.meshes[instance.mesh as usize].triangles()
    }

    /// The table from colour code to object and polygon: index of the instance, and of the triangle
    /// within its mesh. `None` for the background (0) and for numbers that no polygon has.
    pub fn polygon(&self, code: u32) -> Option<(usize, u32)> {
        let instance =
            self.instances.partition_point(|i| i.first_polygon <= code).checked_sub(1)?;
        let range = self.polygon_range(&self.instances[instance]);
        range.contains(&code).then(|| (instance, code - range.start))
    }

    /// World-space corners of a polygon, counter-clockwise seen from its front; a mirroring
    /// transform (negative determinant) does not turn the front away.
    pub fn corners(&self, instance: usize, triangle: u32) -> [DVec3; 3] {
        let instance = &self.instances[instance];
        let mesh = &self.meshes[instance.mesh as usize];
        let at = 3 * triangle as usize;
        let mut corners = [0, 1, 2].map(|k| {
            let vertex = mesh.vertices[mesh.indices[at + k] as usize];
            instance.world.transform_point3(Vec3::from(vertex.position).as_dvec3())
        });
        if instance.world.determinant() < 0.0 {
            corners.swap(1, 2);
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let vertex = |x: f32, y: f32| Vertex { position: [x, y, 0.0], ..Vertex::zeroed() };
        let mesh = Mesh {
            vertices: vec![vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0), vertex(1.0, 1.0)],
            indices: vec![0, 1, 2, 2, 1, 3],
            ..Mesh::default()
        };
        let instance =
            |first_polygon, world| Instance { name: String::new(), mesh: 0, world, first_polygon };
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        Scene {
            meshes: vec![mesh],
            materials: vec![Material::default()],
            instances: vec![instance(1, DMat4::IDENTITY), instance(3, mirror)],
            ..Scene::default()
        }
    }

    #[test]
    fn the_polygon_table_inverts_the_numbering() {
        let scene = scene();
        assert_eq!(scene.polygons(), 4);
        let table: Vec<_> = (0..6).map(|code| scene.polygon(code)).collect();
        let expected = [None, Some((0, 0)), Some((0, 1)), Some((1, 0)), Some((1, 1)), None];
        assert_eq!(table, expected);
    }

    #[test]
    fn a_mirrored_instance_keeps_its_front() {
        let scene = scene();
        for instance in 0..2 {
            let [a, b, c] = scene.corners(instance, 0);
            assert_eq!((b - a).cross(c - a), DVec3::Z);
        }
    }
}
