//! Scenes from plain arrays, as engines hold them.

use super::assemble::{DEFAULT, Tangents, Triangles, affine, check_indices, label, quoted};
use super::mips::{MAX_PIXELS, MAX_SIDE, mips};
use super::{Material, Mesh, Parsed, Scene, Texture, TextureLevel, TextureRef, Vertex, Wrap};
use crate::{Error, Result};
use glam::DMat4;

/// Makes a [`Scene`] of an engine's meshes, materials and transforms, with what glTF asks for where
/// something is missing: flat normals, tangents by MikkTSpace, the default material.
///
/// ```
/// use glam::{DMat4, DVec3};
/// use klieg::scene::Material;
/// use klieg::scene::build::{MeshData, SceneBuilder};
///
/// let mut builder = SceneBuilder::default();
/// let red = Material { base_color: [0.8, 0.1, 0.1, 1.0], metallic: 0.0, ..Material::default() };
/// let red = builder.add_material(red)?;
/// let triangle = builder.add_mesh(&MeshData {
///     positions: &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     material: Some(red),
///     ..MeshData::default()
/// })?;
/// for x in [0.0, 2.0] {
///     builder.add_instance("", triangle, DMat4::from_translation(DVec3::X * x))?;
/// }
/// assert_eq!(builder.finish("two triangles")?.polygons(), 2);
/// # Ok::<(), klieg::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct SceneBuilder {
    scene: Scene,
    /// Pixels of all textures so far.
    pixels: u64,
}

/// A mesh's arrays; each attribute has one entry for each vertex.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeshData<'a> {
    /// Name, for people.
    pub name: &'a str,
    /// Positions in the mesh's own space.
    pub positions: &'a [[f32; 3]],
    /// Normals, of any length; without them every triangle is flat, and a vertex whose normal has no
    /// direction takes that of its triangles.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Tangents and the bitangents' signs. Only a material with a normal texture uses them, and only
    /// beside normals; it has them computed otherwise.
    pub tangents: Option<&'a [[f32; 4]]>,
    /// Texture coordinate sets 0 and 1, `(0, 0)` at the texture's first texel.
    pub uvs: [Option<&'a [[f32; 2]]>; 2],
    /// Linear vertex colours, RGBA, 255 = 1; white where there are none.
    pub colors: Option<&'a [[u8; 4]]>,
    /// Three for each triangle, counter-clockwise seen from the front; without them every three
    /// vertices are a triangle.
    pub indices: Option<&'a [u32]>,
    /// Number of the material; glTF's default material where `None`.
    pub material: Option<u32>,
}

/// A texture's texels and how they are read.
#[derive(Debug, Clone, Copy, Default)]
pub struct TextureData<'a> {
    /// Name, for people.
    pub name: &'a str,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, 8 bits each, rows from the top: `width · height` of them.
    pub texels: &'a [[u8; 4]],
    /// Whether RGB is sRGB-encoded, as base colours and emitted light usually are.
    pub srgb: bool,
    /// Horizontal and vertical wrap.
    pub wrap: [Wrap; 2],
}

impl SceneBuilder {
    /// Adds a texture, with its mip chain; gives its number for [`TextureRef::texture`].
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of texels than the size says, or too large a size.
    pub fn add_texture(&mut self, data: &TextureData) -> Result<u32> {
        let number = self.scene.textures.len();
        self.texture(data).map_err(|fault| refused("texture", number, data.name, &fault))?;
        Ok(number as u32)
    }

    /// Adds a material; gives its number for [`MeshData::material`]. Its factors are brought into their
    /// ranges.
    ///
    /// # Errors
    /// [`Error::Argument`] for a factor that is not finite, a texture that was not added before, a
    /// normal or metallic-roughness texture that is sRGB-encoded, a coordinate set beyond 1.
    pub fn add_material(&mut self, material: Material) -> Result<u32> {
        let number = self.scene.materials.len();
        let name = label(Some(&material.name));
        let checked = self.check_textures(&material).and_then(|()| material.checked());
        let material = checked.map_err(|fault| refused("material", number, &name, &fault))?;
        self.scene.materials.push(Material { name, ..material });
        Ok(number as u32)
    }

    /// Adds a mesh; gives its number for [`SceneBuilder::add_instance`]. Vertices that no triangle uses
    /// are left out.
    ///
    /// # Errors
    /// [`Error::Argument`] names the mesh and what is wrong: no triangles, arrays of different lengths,
    /// an index out of range or not three for each triangle, a position that is not finite, a material
    /// that was not added before, or one with textures whose coordinates the mesh lacks.
    pub fn add_mesh(&mut self, data: &MeshData) -> Result<u32> {
        let number = self.scene.meshes.len();
        let mesh = self.mesh(data).map_err(|fault| refused("mesh", number, data.name, &fault))?;
        self.scene.meshes.push(mesh);
        Ok(number as u32)
    }

    /// Draws a mesh once more, `world` being the transform from its own space into the world. What is
    /// scaled to nothing is left out, with a warning in [`Scene::warnings`].
    ///
    /// # Errors
    /// [`Error::Argument`] names the instance and what is wrong: a mesh that was not added before, a
    /// transform that is not finite or not affine, or more triangles or instances than klieg can tell
    /// apart.
    pub fn add_instance(&mut self, name: &str, mesh: u32, world: DMat4) -> Result<()> {
        let number = self.scene.instances.len();
        self.instance(name, mesh, world).map_err(|fault| refused("instance", number, name, &fault))
    }

    /// The scene; `name` stands in [`Scene::path`].
    ///
    /// # Errors
    /// [`Error::Argument`] when nothing is drawn, or nothing that has any extent.
    pub fn finish(self, name: &str) -> Result<Scene> {
        let mut scene = self.scene;
        scene.path = label(Some(name)).into();
        scene.add_default_material();
        match super::view::bounds(&scene) {
            Ok(_) => Ok(scene),
            Err(fault) => Err(Error::Argument(fault.to_string())),
        }
    }

    fn texture(&mut self, data: &TextureData) -> Parsed<()> {
        let &TextureData { width, height, texels, srgb, wrap, .. } = data;
        if width == 0 || height == 0 || width.max(height) > MAX_SIDE {
            return Err(format!("its size is {width}x{height}: it is 1 to {MAX_SIDE} a side"));
        }
        let wanted = u64::from(width) * u64::from(height);
        if texels.len() as u64 != wanted {
            return Err(format!("{} texels for a size of {width}x{height}", texels.len()));
        }
        let pixels = self.pixels + wanted;
        if pixels > MAX_PIXELS {
            return Err(format!("the textures have more than {MAX_PIXELS} texels together"));
        }
        let full = TextureLevel { width, height, texels: texels.to_vec() };
        let (name, levels) = (label(Some(data.name)), mips(full, srgb));
        self.scene.textures.push(Texture { name, srgb, wrap, levels });
        self.pixels = pixels;
        Ok(())
    }

    fn check_textures(&self, material: &Material) -> Parsed<()> {
        for (what, texture, linear) in textures(material) {
            let TextureRef { texture: number, uv_set, transform } = texture;
            let Some(texture) = self.scene.textures.get(number as usize) else {
                return Err(format!("its {what} texture {number} is not there"));
            };
            if linear && texture.srgb {
                return Err(format!("its {what} texture {number} is sRGB-encoded: it is linear"));
            }
            if uv_set > 1 {
                return Err(format!(
                    "its {what} texture uses coordinate set {uv_set}; klieg reads sets 0 and 1"
                ));
            }
            if !transform.as_flattened().iter().all(|value| value.is_finite()) {
                return Err(format!("the transform of its {what} texture is not finite"));
            }
        }
        Ok(())
    }

    fn mesh(&self, data: &MeshData) -> Parsed<Mesh> {
        let count = check_lengths(data)?;
        let corners = match data.indices {
            Some(indices) => indices.to_vec(),
            None => (0..count).collect(),
        };
        if corners.is_empty() || corners.len() % 3 != 0 || corners.len() > u32::MAX as usize {
            let what = if data.indices.is_some() { "indices" } else { "vertices without indices" };
            let fault = "triangles have three each, 4,294,967,295 in all at most";
            return Err(format!("{} {what}: {fault}", corners.len()));
        }
        check_indices(&corners, count as usize)?;
        let tangents = match self.normal_uv(data)? {
            None => Tangents::Unused,
            Some(_) if data.normals.is_some() && data.tangents.is_some() => Tangents::Given,
            Some(uv_set) => Tangents::Computed { uv_set: uv_set as usize },
        };
        let triangles = Triangles::new(corners, count as usize, data.normals.is_some());
        let mesh = triangles.mesh(tangents, |at| vertex(data, at))?;
        Ok(Mesh {
            name: label(Some(data.name)),
            material: data.material.unwrap_or(DEFAULT),
            ..mesh
        })
    }

    /// The coordinate set of the normal texture of a mesh's material; the mesh must have those of all
    /// its textures.
    fn normal_uv(&self, data: &MeshData) -> Parsed<Option<u32>> {
        let Some(number) = data.material else { return Ok(None) };
        let Some(material) = self.scene.materials.get(number as usize) else {
            return Err(format!("its material {number} is not there"));
        };
        for (what, texture, _) in textures(material) {
            if data.uvs[texture.uv_set as usize].is_none() {
                let set = texture.uv_set;
                return Err(format!("it lacks coordinate set {set} of its {what} texture"));
            }
        }
        Ok(material.normal_texture.map(|texture| texture.uv_set))
    }

    fn instance(&mut self, name: &str, mesh: u32, world: DMat4) -> Parsed<()> {
        if mesh as usize >= self.scene.meshes.len() {
            return Err(format!("its mesh {mesh} is not there"));
        }
        if !world.as_mat4().is_finite() {
            return Err("its transform is not finite".into());
        }
        let (world, name) = (affine(world)?, label(Some(name)));
        let title = title("instance", self.scene.instances.len(), &name);
        self.scene.place(&name, mesh, world, || title)
    }
}

/// A part of the scene, for messages.
fn title(what: &str, number: usize, name: &str) -> String {
    match name {
        "" => format!("{what} {number}"),
        _ => format!("{what} {number} {}", quoted(name)),
    }
}

fn refused(what: &str, number: usize, name: &str, fault: &str) -> Error {
    Error::Argument(format!("{}: {fault}", title(what, number, name)))
}

/// The textures that a material uses, and whether each must be linear.
fn textures(material: &Material) -> impl Iterator<Item = (&'static str, TextureRef, bool)> {
    let Material { base_color_texture, emissive_texture, normal_texture, .. } = *material;
    let all = [
        ("base colour", base_color_texture, false),
        ("metallic-roughness", material.metallic_roughness_texture, true),
        ("normal", normal_texture, true),
        ("emissive", emissive_texture, false),
    ];
    all.into_iter().filter_map(|(what, texture, linear)| Some((what, texture?, linear)))
}

/// The number of vertices, which all attributes have.
fn check_lengths(data: &MeshData) -> Parsed<u32> {
    let count = data.positions.len();
    let [uv0, uv1] = data.uvs;
    for (name, length) in [
        ("normals", data.normals.map(<[_]>::len)),
        ("tangents", data.tangents.map(<[_]>::len)),
        ("texture coordinates of set 0", uv0.map(<[_]>::len)),
        ("texture coordinates of set 1", uv1.map(<[_]>::len)),
        ("colours", data.colors.map(<[_]>::len)),
    ] {
        if let Some(length) = length.filter(|&length| length != count) {
            return Err(format!("{length} {name} for {count} positions"));
        }
    }
    u32::try_from(count).map_err(|_| format!("{count} vertices are more than indices can name"))
}

/// Vertex `at` of the arrays.
fn vertex(data: &MeshData, at: usize) -> Parsed<Vertex> {
    // glTF 2.0, 3.7.2.1: tangents without normals are ignored.
    let tangents = data.tangents.filter(|_| data.normals.is_some());
    let vertex = Vertex {
        position: data.positions[at],
        normal: data.normals.map_or([0.0; 3], |normals| normals[at]),
        tangent: tangents.map_or([0.0; 4], |tangents| tangents[at]),
        uv: data.uvs.map(|set| set.map_or([0.0; 2], |set| set[at])),
        color: data.colors.map_or([255; 4], |colors| colors[at]),
    };
    vertex.checked(at)
}
