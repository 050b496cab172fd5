//! The scene as the draws of its geometry need it, and what their pipelines have in common.

use super::geometry::{Draw, Geometry, draws};
use super::layout::Camera;
use super::pipeline::{DescriptorSet, Pipeline, ShaderModule, Specialization, shader_stage};
use super::textures::Textures;
use super::{Call, Context};
use crate::Result;
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
    /// [`crate::Error::Input`] when it has more vertices than Vulkan can address, and what the
    /// device reports.
    pub fn new(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        shading: &Shading,
    ) -> Result<Self> {
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
    pub fn layout(&self, more: &[vk::DescriptorSetLayout]) -> Result<vk::PipelineLayout> {
        let mut sets = vec![self.set.layout(), self.textures.layout()];
        sets.extend(more);
        let push = [vk::PushConstantRange {
            stage_flags: PUSH_STAGES,
            offset: 0,
            size: size_of::<Camera>() as u32,
        }];
        let info =
            vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
        // SAFETY: the device and all that the info names are alive.
        unsafe { self.context.device().create_pipeline_layout(&info, None) }
            .call("vkCreatePipelineLayout")
    }

    /// Records the draws of all instances, `individuals` times over, in a render pass with its
    /// pipeline bound. The first light is for populations alone, and so is more than one individual.
    pub fn record(
        &self,
        cmd: vk::CommandBuffer,
        layout: vk::PipelineLayout,
        (first_light, individuals): (u32, Option<u32>),
    ) {
        let device = self.context.device();
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

/// What the pipelines that draw a scene differ in.
pub struct DrawPipeline<'a> {
    /// The stage's stem.
    pub stem: &'a str,
    /// Vertex and fragment shader.
    pub shaders: [&'a [u32]; 2],
    /// Specialisation constants of both.
    pub constants: &'a [u32],
    /// Of the scene's sets and others.
    pub layout: vk::PipelineLayout,
    /// A pass with so many colour attachments.
    pub pass: (vk::RenderPass, usize),
    /// Size of the picture.
    pub extent: vk::Extent2D,
}

impl DrawPipeline<'_> {
    /// Makes the pipeline: reversed depth, and no culling, as that depends on the material.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn create(&self, context: &Arc<Context>) -> Result<Pipeline> {
        let [vertex, fragment] = self.shaders;
        let (vertex, fragment) =
            (ShaderModule::new(context, vertex)?, ShaderModule::new(context, fragment)?);
        let specialization = Specialization::new(self.constants);
        let specialization = specialization.info();
        let stages = [
            shader_stage(vk::ShaderStageFlags::VERTEX, &vertex, &specialization),
            shader_stage(vk::ShaderStageFlags::FRAGMENT, &fragment, &specialization),
        ];
        let (bindings, attributes) = vertex_layout();
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let vk::Extent2D { width, height } = self.extent;
        let viewports =
            [vk::Viewport::default().width(width as f32).height(height as f32).max_depth(1.0)];
        let scissors = [self.extent.into()];
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewports(&viewports)
            .scissors(&scissors);
        // Back faces are sorted out in the fragment shader: it depends on the material.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(vk::CompareOp::GREATER);
        let blend = vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let blend = vec![blend; self.pass.1];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(self.layout)
            .render_pass(self.pass.0);
        Pipeline::graphics(context, self.stem, info)
    }
}

/// [`Vertex`], as the vertex shader reads it.
fn vertex_layout()
-> ([vk::VertexInputBindingDescription; 1], [vk::VertexInputAttributeDescription; 5]) {
    let binding = vk::VertexInputBindingDescription {
        binding: 0,
        stride: size_of::<Vertex>() as u32,
        input_rate: vk::VertexInputRate::VERTEX,
    };
    let attribute = |location, format, offset: usize| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format,
        offset: offset as u32,
    };
    let (vec3, vec4) = (vk::Format::R32G32B32_SFLOAT, vk::Format::R32G32B32A32_SFLOAT);
    let attributes = [
        attribute(0, vec3, offset_of!(Vertex, position)),
        attribute(1, vec3, offset_of!(Vertex, normal)),
        attribute(2, vec4, offset_of!(Vertex, tangent)),
        attribute(3, vec4, offset_of!(Vertex, uv)),
        attribute(4, vk::Format::R8G8B8A8_UNORM, offset_of!(Vertex, color)),
    ];
    ([binding], attributes)
}

/// An attachment of a pass that draws geometry: cleared first, and left in `layout`.
pub fn attachment(
    format: vk::Format,
    store: vk::AttachmentStoreOp,
    layout: vk::ImageLayout,
) -> vk::AttachmentDescription {
    vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .store_op(store)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(layout)
}
