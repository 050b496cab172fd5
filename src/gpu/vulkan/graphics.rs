//! What the draws have in common: render passes, what they draw into, and graphics pipelines, whose
//! viewport is dynamic, so that one serves pictures of every size.

use super::cache::PipelineKey;
use super::pipeline::{Pipeline, PipelineLayout, ShaderModule, Specialization, shader_stage};
use crate::Result;
use crate::gpu::Context;
use crate::gpu::vulkan::Call;
use ash::vk;
use std::sync::Arc;

/// Format of depths. They are reversed: 0 is the far plane.
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// A render pass of one subpass, which the context keeps.
#[derive(Clone, Copy)]
pub struct RenderPass {
    raw: vk::RenderPass,
    colors: usize,
}

impl RenderPass {
    /// The pass of the stage `stem`: its colour attachments and, with `depth`, behind them a depth
    /// that is cleared and not kept.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Context,
        stem: &'static str,
        colors: &[vk::AttachmentDescription],
        depth: bool,
        dependencies: &[vk::SubpassDependency],
    ) -> Result<Self> {
        let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        let (clear, drop) = (vk::AttachmentLoadOp::CLEAR, vk::AttachmentStoreOp::DONT_CARE);
        let depth = depth.then(|| attachment(DEPTH, (clear, drop), depth_layout));
        let attachments: Vec<_> = colors.iter().copied().chain(depth).collect();
        let reference = |attachment: usize, layout| vk::AttachmentReference {
            attachment: attachment as u32,
            layout,
        };
        let color = |i| reference(i, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        let color_references: Vec<_> = (0..colors.len()).map(color).collect();
        let depth_reference = reference(colors.len(), depth_layout);
        let mut subpass = vk::SubpassDescription::default()
            .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
            .color_attachments(&color_references);
        if depth.is_some() {
            subpass = subpass.depth_stencil_attachment(&depth_reference);
        }
        let info = vk::RenderPassCreateInfo::default()
            .attachments(&attachments)
            .subpasses(std::slice::from_ref(&subpass))
            .dependencies(dependencies);
        let formats = attachments.iter().map(|attachment| attachment.format).collect();
        let raw = context.cache().passes.get((stem, formats), || {
            let device = context.device()?;
            // SAFETY: the device is alive; `info` is complete.
            unsafe { device.create_render_pass(&info, None) }.call("vkCreateRenderPass")
        })?;
        Ok(Self { raw, colors: colors.len() })
    }

    /// Begins the pass over the whole of `target`, with `pipeline` bound.
    pub fn begin(
        &self,
        cmd: vk::CommandBuffer,
        target: &Framebuffer,
        clear: &[vk::ClearValue],
        pipeline: &Pipeline,
    ) {
        let device = target.context.recorder();
        let area: vk::Rect2D = target.extent.into();
        let viewport = vk::Viewport::default()
            .width(area.extent.width as f32)
            .height(area.extent.height as f32)
            .max_depth(1.0);
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.raw)
            .framebuffer(target.raw)
            .render_area(area)
            .clear_values(clear);
        // SAFETY: `cmd` is being recorded on this device; target and pipeline are alive and were
        // made for this pass.
        unsafe {
            device.cmd_begin_render_pass(cmd, &begin, vk::SubpassContents::INLINE);
            device.cmd_bind_pipeline(cmd, vk::PipelineBindPoint::GRAPHICS, pipeline.raw());
            device.cmd_set_viewport(cmd, 0, &[viewport]);
            device.cmd_set_scissor(cmd, 0, &[area]);
        }
    }
}

/// An attachment whose old content is of no use, left in `layout`.
pub fn attachment(
    format: vk::Format,
    (load, store): (vk::AttachmentLoadOp, vk::AttachmentStoreOp),
    layout: vk::ImageLayout,
) -> vk::AttachmentDescription {
    vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(load)
        .store_op(store)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(layout)
}

/// The images that a pass draws into; their owner keeps them for as long.
pub struct Framebuffer {
    raw: vk::Framebuffer,
    extent: vk::Extent2D,
    context: Arc<Context>,
}

impl Framebuffer {
    /// Of `layers` layers of each of the pass's attachments, views in their order, of `extent`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        pass: RenderPass,
        attachments: &[vk::ImageView],
        (extent, layers): (vk::Extent2D, u32),
    ) -> Result<Self> {
        if context.is_dry() {
            return Ok(Self { raw: vk::Framebuffer::null(), extent, context: Arc::clone(context) });
        }
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass.raw)
            .attachments(attachments)
            .width(extent.width)
            .height(extent.height)
            .layers(layers);
        // SAFETY: pass and views are alive.
        let raw = unsafe { context.device()?.create_framebuffer(&info, None) }
            .call("vkCreateFramebuffer")?;
        Ok(Self { raw, extent, context: Arc::clone(context) })
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        // SAFETY: owners wait for the draw before they drop its target.
        self.context.unless_gone(|device| unsafe { device.destroy_framebuffer(self.raw, None) });
    }
}

/// How a draw's vertices lie in their buffers; by default it reads none.
#[derive(Clone, Copy, Default)]
pub struct VertexInput {
    /// The buffers.
    pub bindings: &'static [vk::VertexInputBindingDescription],
    /// What the vertex shader reads of them.
    pub attributes: &'static [vk::VertexInputAttributeDescription],
}

/// What the draws' pipelines differ in.
pub struct GraphicsPipeline<'a> {
    /// The stage's stem.
    pub stem: &'static str,
    /// Vertex and fragment shader, always the same for a stem.
    pub shaders: [&'a [u32]; 2],
    /// What the vertex shader reads, always the same for a stem.
    pub vertices: VertexInput,
    /// Specialisation constants of both shaders.
    pub constants: &'a [u32],
    /// Sets and push constants.
    pub layout: PipelineLayout,
    /// The pass, whose depth, if it has one, is tested and written.
    pub pass: RenderPass,
}

impl GraphicsPipeline<'_> {
    /// The pipeline, made now unless the context has it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn create(&self, context: &Arc<Context>) -> Result<Pipeline> {
        let key = PipelineKey {
            stem: self.stem,
            constants: self.constants.to_vec(),
            layout: self.layout.raw(),
            pass: self.pass.raw,
        };
        Pipeline::cached(context, key, || self.make(context))
    }

    fn make(&self, context: &Arc<Context>) -> Result<vk::Pipeline> {
        let [vertex, fragment] = self.shaders;
        let (vertex, fragment) =
            (ShaderModule::new(context, vertex)?, ShaderModule::new(context, fragment)?);
        let specialization = Specialization::new(self.constants);
        let specialization = specialization.info();
        let stages = [
            shader_stage(vk::ShaderStageFlags::VERTEX, &vertex, &specialization),
            shader_stage(vk::ShaderStageFlags::FRAGMENT, &fragment, &specialization),
        ];
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(self.vertices.bindings)
            .vertex_attribute_descriptions(self.vertices.attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
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
        let blend = vec![blend; self.pass.colors];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .dynamic_state(&dynamic)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(self.layout.raw())
            .render_pass(self.pass.raw)];
        let cache = context.cache().compiled.raw;
        // SAFETY: everything that `info` names is alive, and the shaders were written for the
        // layout and the pass.
        let made = unsafe { context.device()?.create_graphics_pipelines(cache, &info, None) };
        made.map(|made| made[0]).map_err(|(_, result)| result).call("vkCreateGraphicsPipelines")
    }
}
