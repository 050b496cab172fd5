//! The stage `visibility`: one draw of the scene that leaves the nearest polygon of each pixel, with
//! its position, normal and material, in the G-buffer.

use super::commands::{COMPUTE_READ, COPY_READ};
use super::geometry::{Draw, Geometry, draws};
use super::layout::Camera;
use super::memory::{Image, ImageDesc};
use super::pipeline::{DescriptorSet, MAIN, Pipeline, ShaderModule};
use super::textures::Textures;
use super::view::GBuffer;
use super::{Call, Context, shaders};
use crate::Result;
use crate::scene::view::View;
use crate::scene::{Scene, Vertex};
use ash::vk;
use std::mem::offset_of;
use std::sync::Arc;

/// Colour attachments: those of the [`GBuffer`].
const COLORS: usize = 5;

/// The scene on the device, ready to be drawn into a G-buffer. Not needed once that is done.
pub struct Visibility {
    geometry: Geometry,
    textures: Textures,
    draws: Vec<Draw>,
    camera: Camera,
    set: DescriptorSet,
    pipeline: Pipeline,
    target: Target,
    context: Arc<Context>,
}

impl Visibility {
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
        g_buffer: &GBuffer,
    ) -> Result<Self> {
        let draws = draws(scene)?;
        let geometry = Geometry::new(context, scene, view)?;
        let textures = Textures::new(context, scene)?;
        let (vertex, fragment) = (vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT);
        let storage = vk::DescriptorType::STORAGE_BUFFER;
        let bindings = [(0, storage, vertex | fragment), (1, storage, fragment)];
        let mut set = DescriptorSet::new(context, "visibility", &bindings)?;
        set.write_buffer(0, &geometry.instances);
        set.write_buffer(1, &geometry.materials);
        let target = Target::new(context, g_buffer, &[set.layout(), textures.layout()])?;
        let pipeline = pipeline(context, &target)?;
        let [x, y, z] = view.eye.to_array();
        let camera = Camera {
            clip_from_frame: view.clip_from_frame.to_cols_array_2d(),
            eye: [x, y, z, f32::from(u8::from(view.is_orthographic()))],
        };
        let context = Arc::clone(context);
        Ok(Self { geometry, textures, draws, camera, set, pipeline, target, context })
    }

    /// Records the draw. The G-buffer is then in layout `GENERAL` and visible to compute
    /// shaders and to copies.
    pub fn record(&self, cmd: vk::CommandBuffer) {
        let device = self.context.device();
        let layout = self.target.layout;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        // Everything is cleared to 0: no polygon, and with reversed depth the far plane.
        let clear = [vk::ClearValue::default(); COLORS + 1];
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.target.render_pass)
            .framebuffer(self.target.framebuffer)
            .render_area(self.target.extent.into())
            .clear_values(&clear);
        // SAFETY: `cmd` is being recorded on this device; everything bound belongs to `self` and
        // was made for this pipeline.
        unsafe {
            device.cmd_begin_render_pass(cmd, &begin, vk::SubpassContents::INLINE);
            device.cmd_bind_pipeline(cmd, graphics, self.pipeline.raw());
            device.cmd_bind_descriptor_sets(cmd, graphics, layout, 0, &[self.set.raw()], &[]);
            device.cmd_bind_vertex_buffers(cmd, 0, &[self.geometry.vertices.raw()], &[0]);
            let indices = self.geometry.indices.raw();
            device.cmd_bind_index_buffer(cmd, indices, 0, vk::IndexType::UINT32);
            device.cmd_push_constants(cmd, layout, stages, 0, bytemuck::bytes_of(&self.camera));
            for draw in &self.draws {
                let textures = [self.textures.set(draw.material)];
                device.cmd_bind_descriptor_sets(cmd, graphics, layout, 1, &textures, &[]);
                device.cmd_draw_indexed(
                    cmd,
                    draw.indices,
                    draw.instances,
                    draw.first_index,
                    draw.first_vertex,
                    draw.first_instance,
                );
            }
            device.cmd_end_render_pass(cmd);
        }
    }
}

/// What is drawn into, and the pipeline's layout.
struct Target {
    depth: Image,
    render_pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    layout: vk::PipelineLayout,
    extent: vk::Extent2D,
    context: Arc<Context>,
}

impl Target {
    fn new(
        context: &Arc<Context>,
        g_buffer: &GBuffer,
        sets: &[vk::DescriptorSetLayout],
    ) -> Result<Self> {
        let extent = g_buffer.code.extent();
        let depth = ImageDesc {
            name: "visibility depth",
            format: vk::Format::D32_SFLOAT,
            width: extent.width,
            height: extent.height,
            layers: None,
            mips: 1,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        };
        let mut target = Self {
            depth: Image::new(context, &depth)?,
            render_pass: vk::RenderPass::null(),
            framebuffer: vk::Framebuffer::null(),
            layout: vk::PipelineLayout::null(),
            extent,
            context: Arc::clone(context),
        };
        let colors = [
            &g_buffer.code,
            &g_buffer.position_roughness,
            &g_buffer.normal_metallic,
            &g_buffer.base_color,
            &g_buffer.emissive,
        ];
        target.render_pass = render_pass(context, colors.map(Image::format))?;
        let views: Vec<_> = colors.iter().map(|c| c.view()).chain([target.depth.view()]).collect();
        let framebuffer = vk::FramebufferCreateInfo::default()
            .render_pass(target.render_pass)
            .attachments(&views)
            .width(extent.width)
            .height(extent.height)
            .layers(1);
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
            offset: 0,
            size: size_of::<Camera>() as u32,
        }];
        let layout =
            vk::PipelineLayoutCreateInfo::default().set_layouts(sets).push_constant_ranges(&push);
        let device = context.device();
        // SAFETY: the device and all that the infos name are alive; `target` owns what is made.
        unsafe {
            target.framebuffer =
                device.create_framebuffer(&framebuffer, None).call("vkCreateFramebuffer")?;
            target.layout =
                device.create_pipeline_layout(&layout, None).call("vkCreatePipelineLayout")?;
        }
        Ok(target)
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        let device = self.context.device();
        // SAFETY: owners wait for the work that uses the target; null handles are allowed.
        unsafe {
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_framebuffer(self.framebuffer, None);
            device.destroy_render_pass(self.render_pass, None);
        }
    }
}

/// A pass that clears and writes the G-buffer and a depth image.
fn render_pass(context: &Context, colors: [vk::Format; COLORS]) -> Result<vk::RenderPass> {
    let attachment = |format, store, layout| {
        vk::AttachmentDescription::default()
            .format(format)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(store)
            .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
            .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
            .initial_layout(vk::ImageLayout::UNDEFINED)
            .final_layout(layout)
    };
    let color = |format| attachment(format, vk::AttachmentStoreOp::STORE, vk::ImageLayout::GENERAL);
    let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let depth = attachment(vk::Format::D32_SFLOAT, vk::AttachmentStoreOp::DONT_CARE, depth_layout);
    let attachments: Vec<_> = colors.into_iter().map(color).chain([depth]).collect();
    let reference = |attachment, layout| vk::AttachmentReference { attachment, layout };
    let color_references: Vec<_> = (0..COLORS as u32)
        .map(|i| reference(i, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL))
        .collect();
    let depth_reference = reference(COLORS as u32, depth_layout);
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&color_references)
        .depth_stencil_attachment(&depth_reference)];
    let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
    let dependencies = dependencies();
    let info = info.dependencies(&dependencies);
    // SAFETY: the device is alive; `info` is complete.
    unsafe { context.device().create_render_pass(&info, None) }.call("vkCreateRenderPass")
}

/// The images' first use before the draw, and the readers of what it leaves.
fn dependencies() -> [vk::SubpassDependency; 2] {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let tests = Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    let writers = Stage::COLOR_ATTACHMENT_OUTPUT | tests;
    let writes = Access::COLOR_ATTACHMENT_WRITE | Access::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let readers = [COMPUTE_READ, COPY_READ];
    let before = vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .dst_subpass(0)
        .src_stage_mask(Stage::TRANSFER | writers)
        .src_access_mask(Access::TRANSFER_WRITE | writes)
        .dst_stage_mask(writers)
        .dst_access_mask(writes | Access::DEPTH_STENCIL_ATTACHMENT_READ);
    let after = vk::SubpassDependency::default()
        .src_subpass(0)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(writers)
        .src_access_mask(writes)
        .dst_stage_mask(readers.iter().fold(Stage::empty(), |all, scope| all | scope.0))
        .dst_access_mask(readers.iter().fold(Access::empty(), |all, scope| all | scope.1));
    [before, after]
}

fn pipeline(context: &Arc<Context>, target: &Target) -> Result<Pipeline> {
    let vertex = ShaderModule::new(context, shaders::VISIBILITY_VERT)?;
    let fragment = ShaderModule::new(context, shaders::VISIBILITY_FRAG)?;
    let stage = |stage, module: &ShaderModule| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw()).name(MAIN)
    };
    let stages = [
        stage(vk::ShaderStageFlags::VERTEX, &vertex),
        stage(vk::ShaderStageFlags::FRAGMENT, &fragment),
    ];
    let (bindings, attributes) = vertex_layout();
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let vk::Extent2D { width, height } = target.extent;
    let viewports =
        [vk::Viewport::default().width(width as f32).height(height as f32).max_depth(1.0)];
    let scissors = [target.extent.into()];
    let viewport =
        vk::PipelineViewportStateCreateInfo::default().viewports(&viewports).scissors(&scissors);
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
    let blend = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA); COLORS];
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
        .layout(target.layout)
        .render_pass(target.render_pass);
    Pipeline::graphics(context, "visibility", info)
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
