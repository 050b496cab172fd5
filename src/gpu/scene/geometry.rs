//! The scene's triangles and materials as the visibility draw reads them.

use crate::gpu::Context;
use crate::gpu::layout::{
    DOUBLE_SIDED, InstanceRecord, MATERIAL_TEXTURES, MaterialRecord, NORMAL_MAPPED, TextureUse,
};
use crate::gpu::vulkan::memory::Buffer;
use crate::gpu::vulkan::staging::Uploader;
use crate::scene::view::View;
use crate::scene::{Instance, Material, Scene, TextureRef, Vertex};
use crate::{Error, Result};
use ash::vk;
use bytemuck::Zeroable;
use std::sync::Arc;

impl InstanceRecord {
    fn new(scene: &Scene, view: &View, instance: &Instance) -> Self {
        let frame_from_mesh = view.frame_from_mesh(&instance.world);
        let (normal, mirrored) = view.normal_from_mesh(&instance.world);
        Self {
            frame_from_mesh: frame_from_mesh.as_mat4().to_cols_array_2d(),
            normal_from_mesh: normal.as_mat3().to_cols_array_2d().map(|[x, y, z]| [x, y, z, 0.0]),
            first_polygon: instance.first_polygon,
            material: scene.meshes[instance.mesh as usize].material,
            mirrored: mirrored.into(),
            padding: 0,
        }
    }
}

impl MaterialRecord {
    fn new(material: &Material) -> Self {
        let [r, g, b] = material.emissive;
        let mut flags = 0;
        if material.double_sided {
            flags |= DOUBLE_SIDED;
        }
        if material.normal_texture.is_some() {
            flags |= NORMAL_MAPPED;
        }
        Self {
            base_color: material.base_color,
            emissive_normal_scale: [r, g, b, material.normal_scale],
            metallic: material.metallic,
            roughness: material.roughness,
            alpha_cutoff: material.alpha_cutoff,
            flags,
            textures: texture_slots(material).map(TextureUse::new),
        }
    }
}

impl TextureUse {
    fn new(texture: Option<TextureRef>) -> Self {
        let Some(TextureRef { uv_set, transform: [u, v], .. }) = texture else {
            return Self::zeroed();
        };
        Self { u: [u[0], u[1], u[2], uv_set as f32], v: [v[0], v[1], v[2], 0.0] }
    }
}

/// A material's textures in the order of their bindings.
pub fn texture_slots(material: &Material) -> [Option<TextureRef>; MATERIAL_TEXTURES as usize] {
    [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emissive_texture,
    ]
}

/// Consecutive instances of one mesh, drawn together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draw {
    /// Index into the scene's materials.
    pub material: u32,
    /// Where the mesh's indices start.
    pub first_index: u32,
    /// Three for each triangle.
    pub indices: u32,
    /// Where the mesh's vertices start.
    pub first_vertex: i32,
    /// Index of the first instance.
    pub first_instance: u32,
    /// How many there are.
    pub instances: u32,
}

/// The draws in the order of the polygons' numbers, which decides between equal depths.
///
/// # Errors
/// [`Error::Input`] when there are more vertices or indices than Vulkan can address.
pub fn draws(scene: &Scene) -> Result<Vec<Draw>> {
    let too_large = || Error::input(&scene.path, "more than 2^31 vertices or 2^32 indices");
    let (mut starts, mut vertex, mut index) = (Vec::new(), 0usize, 0usize);
    for mesh in &scene.meshes {
        let first_vertex = i32::try_from(vertex).map_err(|_| too_large())?;
        starts.push((first_vertex, u32::try_from(index).map_err(|_| too_large())?));
        vertex += mesh.vertices.len();
        index += mesh.indices.len();
    }
    let mut first_instance = 0;
    let draws = scene.instances.chunk_by(|a, b| a.mesh == b.mesh).map(|same| {
        let mesh = same[0].mesh as usize;
        let draw = Draw {
            material: scene.meshes[mesh].material,
            first_index: starts[mesh].1,
            indices: 3 * scene.meshes[mesh].triangles(),
            first_vertex: starts[mesh].0,
            first_instance,
            instances: same.len() as u32,
        };
        first_instance += draw.instances;
        draw
    });
    Ok(draws.collect())
}

/// The scene in device memory, without its textures.
pub struct Geometry {
    /// Every mesh's [`Vertex`]es.
    pub vertices: Buffer,
    /// Every mesh's indices, `u32`.
    pub indices: Buffer,
    /// [`InstanceRecord`] of each instance.
    pub instances: Buffer,
    /// [`MaterialRecord`] of each material.
    pub materials: Buffer,
}

impl Geometry {
    /// Uploads the scene as it stands in the light frame of `view`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] when a buffer is more than the device can take, and
    /// [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, scene: &Scene, view: &View) -> Result<Self> {
        let instances: Vec<_> =
            scene.instances.iter().map(|i| InstanceRecord::new(scene, view, i)).collect();
        let materials: Vec<_> = scene.materials.iter().map(MaterialRecord::new).collect();
        let (vertices, indices) = scene.meshes.iter().fold((0, 0), |(vertices, indices), mesh| {
            (vertices + mesh.vertices.len() as u64, indices + mesh.indices.len() as u64)
        });
        check_index_range(context, scene)?;
        let geometry = Self {
            vertices: Buffer::device(
                context,
                "vertices",
                vertices * size_of::<Vertex>() as u64,
                vk::BufferUsageFlags::VERTEX_BUFFER,
            )?,
            indices: Buffer::device(
                context,
                "indices",
                indices * 4,
                vk::BufferUsageFlags::INDEX_BUFFER,
            )?,
            instances: Buffer::storage(context, "instances", size_of_val(&instances[..]) as u64)?,
            materials: Buffer::storage(context, "materials", size_of_val(&materials[..]) as u64)?,
        };
        let mut uploader = Uploader::new(context)?;
        let (mut vertex, mut index) = (0, 0);
        for mesh in &scene.meshes {
            let (vertices, indices): (&[u8], &[u8]) =
                (bytemuck::cast_slice(&mesh.vertices), bytemuck::cast_slice(&mesh.indices));
            uploader.buffer(&geometry.vertices, vertex, vertices)?;
            uploader.buffer(&geometry.indices, index, indices)?;
            vertex += vertices.len() as u64;
            index += indices.len() as u64;
        }
        uploader.buffer(&geometry.instances, 0, bytemuck::cast_slice(&instances))?;
        uploader.buffer(&geometry.materials, 0, bytemuck::cast_slice(&materials))?;
        uploader.finish()?;
        Ok(geometry)
    }
}

fn check_index_range(context: &Context, scene: &Scene) -> Result<()> {
    let largest = context.limits().max_draw_indexed_index_value as usize;
    match scene.meshes.iter().find(|mesh| mesh.vertices.len() > largest) {
        Some(mesh) => Err(context.unsupported(format!(
            "mesh '{}' has {} vertices (an index may be {largest})",
            mesh.name,
            mesh.vertices.len()
        ))),
        None => Ok(()),
    }
}
