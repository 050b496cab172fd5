//! The scene as the draws of its geometry need it.

use super::geometry::{Draw, Geometry, draws};
use super::textures::Textures;
use crate::Result;
use crate::gpu::Context;
use crate::gpu::layout::Camera;
use crate::gpu::vulkan::graphics::VertexInput;
use crate::gpu::vulkan::pipeline::{DescriptorSet, PipelineLayout};
use crate::lighting::shading::Shading;
use crate::scene::view::View;
use crate::scene::{Scene, Vertex};
use ash::vk;
use bytemuck::Zeroable;
use std::mem::offset_of;
use std::sync::Arc;

/// Who reads [`Camera`], the draws' push constants.
const PUSH_STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);

/// The scene on the device: set 0 of `shaders/include/visibility.glsl`, its textures, and its draws.
pub struct Drawable {
    geometry: Geometry,
    textures: Textures,
    draws: Vec<Draw>,
    camera: Camera,
    set: DescriptorSet,
    context: Arc<Context>,
}

impl Drawable {
    /// Uploads the scene.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when something of the scene is more than the device can take,
    /// [`crate::Error::Input`] when it has more vertices than Vulkan can address and as
    /// [`Scene::check`], and [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        shading: &Shading,
    ) -> Result<Self> {
        scene.check()?;
        let draws = draws(scene)?;
        let geometry = Geometry::new(context, scene, view)?;
        let textures = Textures::new(context, scene)?;
        let fragment = vk::ShaderStageFlags::FRAGMENT;
        let storage = vk::DescriptorType::STORAGE_BUFFER;
        let bindings = [(0, storage, PUSH_STAGES), (1, storage, fragment)];
        let mut set = DescriptorSet::new(context, "scene", &bindings)?;
        set.write_buffer(0, &geometry.instances);
        set.write_buffer(1, &geometry.materials);
        let [x, y, z] = view.eye.to_array();
        let camera = Camera {
            clip_from_frame: view.clip_from_frame.to_cols_array_2d(),
            eye: [x, y, z, f32::from(u8::from(view.is_orthographic()))],
            shading: [shading.ambient, shading.dielectric, shading.max_shininess],
            ..Camera::zeroed()
        };
        Ok(Self { geometry, textures, draws, camera, set, context: Arc::clone(context) })
    }

    /// A pipeline layout of the scene's sets and `more` behind them.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn layout(&self, more: &[vk::DescriptorSetLayout]) -> Result<PipelineLayout> {
        let mut sets = vec![self.set.layout(), self.textures.layout()];
        sets.extend(more);
        PipelineLayout::new(&self.context, &sets, PUSH_STAGES, size_of::<Camera>() as u32)
    }

    /// Records the draws of all instances, `individuals` times over, in a render pass with its
    /// pipeline bound. The first light is for populations alone, and so is more than one individual.
    pub fn record(
        &self,
        cmd: vk::CommandBuffer,
        layout: PipelineLayout,
        (first_light, individuals): (u32, Option<u32>),
    ) {
        let (device, layout) = (self.context.recorder(), layout.raw());
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: `cmd` is being recorded on this device; everything bound belongs to `self`, and
        // the layout came from it.
        unsafe {
            device.cmd_bind_descriptor_sets(cmd, graphics, layout, 0, &[self.set.raw()], &[]);
            device.cmd_bind_vertex_buffers(cmd, 0, &[self.geometry.vertices.raw()], &[0]);
            let indices = self.geometry.indices.raw();
            device.cmd_bind_index_buffer(cmd, indices, 0, vk::IndexType::UINT32);
        }
        for draw in &self.draws {
            let textures = [self.textures.set(draw.material)];
            let camera = Camera {
                first_light,
                first_instance: draw.first_instance,
                instances_of_picture: draw.instances,
                ..self.camera
            };
            let (first, count) = match individuals {
                Some(individuals) => (0, draw.instances * individuals),
                None => (draw.first_instance, draw.instances),
            };
            // SAFETY: as above.
            unsafe {
                device.cmd_bind_descriptor_sets(cmd, graphics, layout, 1, &textures, &[]);
                device.cmd_push_constants(cmd, layout, PUSH_STAGES, 0, bytemuck::bytes_of(&camera));
                device.cmd_draw_indexed(
                    cmd,
                    draw.indices,
                    count,
                    draw.first_index,
                    draw.first_vertex,
                    first,
                );
            }
        }
    }

    /// Most instances of one draw in one picture.
    pub fn most_instances(&self) -> u32 {
        self.draws.iter().map(|draw| draw.instances).max().unwrap_or(0)
    }
}

/// [`Vertex`], as the vertex shaders read it.
pub const VERTICES: VertexInput = {
    const fn attribute(
        location: u32,
        format: vk::Format,
        offset: usize,
    ) -> vk::VertexInputAttributeDescription {
        vk::VertexInputAttributeDescription { location, binding: 0, format, offset: offset as u32 }
    }
    const VEC3: vk::Format = vk::Format::R32G32B32_SFLOAT;
    const VEC4: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
    VertexInput {
        bindings: &[vk::VertexInputBindingDescription {
            binding: 0,
            stride: size_of::<Vertex>() as u32,
            input_rate: vk::VertexInputRate::VERTEX,
        }],
        attributes: &[
            attribute(0, VEC3, offset_of!(Vertex, position)),
            attribute(1, VEC3, offset_of!(Vertex, normal)),
            attribute(2, VEC4, offset_of!(Vertex, tangent)),
            attribute(3, VEC4, offset_of!(Vertex, uv)),
            attribute(4, vk::Format::R8G8B8A8_UNORM, offset_of!(Vertex, color)),
        ],
    }
};
