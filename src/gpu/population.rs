//! Draws that make a population's pictures, and the stage `population`: one instanced draw of N
//! layers, each layer the stored surface under the lights of its own individual.

use super::commands::{COLOR_WRITE, COMPUTE_READ, COPY_READ};
use super::layout::Chunk;
use super::memory::{Buffer, Image, ImageDesc};
use super::pipeline::{ByLights, Pipeline, ShaderModule, Specialization, shader_stage};
use super::view::{PUSH_STAGES, ViewMemory};
use super::{Call, Context, shaders};
use crate::Result;
use ash::vk;
use std::sync::Arc;

/// Format of the pictures: sRGB-encoded luminance, negative in the background.
pub const FORMAT: vk::Format = vk::Format::R32_SFLOAT;
/// What is done with the pictures.
pub const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::SAMPLED.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw(),
);

/// Makes the pictures of a chunk with a draw.
pub trait Draw {
    /// The stage's stem.
    fn stem(&self) -> &'static str;

    /// Bytes that each pixel of each picture takes.
    fn pixel_bytes(&self) -> u64;

    /// Most pictures of one draw, whatever the memory.
    fn most_pictures(&self) -> u32 {
        u32::MAX
    }

    /// Makes what rigs of `lights` lights need, unless it is there.
    ///
    /// # Errors
    /// What the device reports.
    fn prepare(&mut self, view: &ViewMemory, lights: usize) -> Result<()>;

    /// Whether that is there.
    fn prepared(&self, lights: usize) -> bool;

    /// Makes room for `count` pictures; the lights will be in `lights`.
    ///
    /// # Errors
    /// What the device reports.
    fn allocate(&mut self, size: [u32; 2], count: u32, lights: &Buffer) -> Result<()>;

    /// One layer for each picture; `SHADER_READ_ONLY_OPTIMAL` after the draw.
    fn pictures(&self) -> &Image;

    /// Records the draw of `count` individuals of a chunk.
    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        chunk: (&Chunk, u32),
        lights: usize,
    );
}

/// The pictures of a chunk of the population, as the draw's target.
struct Pictures {
    image: Image,
    framebuffer: vk::Framebuffer,
    context: Arc<Context>,
}

impl Drop for Pictures {
    fn drop(&mut self) {
        // SAFETY: owners wait for the draw before they drop its target.
        self.context
            .destroy(|device| unsafe { device.destroy_framebuffer(self.framebuffer, None) });
    }
}

/// The draw of the stored surface: its render pass and a pipeline for each number of lights seen.
pub struct StoredDraw {
    pictures: Option<Pictures>,
    pass: vk::RenderPass,
    vertex: ShaderModule,
    fragment: ShaderModule,
    pipelines: ByLights,
    context: Arc<Context>,
}

impl Drop for StoredDraw {
    fn drop(&mut self) {
        // SAFETY: owners wait for the draw before they drop it.
        self.context.destroy(|device| unsafe { device.destroy_render_pass(self.pass, None) });
    }
}

impl StoredDraw {
    /// # Errors
    /// What the device reports.
    pub fn new(context: &Arc<Context>) -> Result<Self> {
        Ok(Self {
            vertex: ShaderModule::new(context, shaders::POPULATION_VERT)?,
            fragment: ShaderModule::new(context, shaders::POPULATION_FRAG)?,
            pictures: None,
            pass: render_pass(context)?,
            pipelines: ByLights::default(),
            context: Arc::clone(context),
        })
    }

    fn target(&self) -> &Pictures {
        self.pictures.as_ref().expect("allocated before use")
    }

    fn pipeline(
        context: &Arc<Context>,
        [vertex, fragment]: [&ShaderModule; 2],
        pass: vk::RenderPass,
        view: &ViewMemory,
        lights: usize,
    ) -> Result<Pipeline> {
        let constants = [lights as u32];
        let specialization = Specialization::new(&constants);
        let specialization = specialization.info();
        let stages = [
            shader_stage(vk::ShaderStageFlags::VERTEX, vertex, &specialization),
            shader_stage(vk::ShaderStageFlags::FRAGMENT, fragment, &specialization),
        ];
        let [width, height] = view.size;
        let viewports = [vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: width as f32,
            height: height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        }];
        let scissors = [vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent: vk::Extent2D { width, height },
        }];
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewports(&viewports)
            .scissors(&scissors);
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let targets = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::R)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&targets);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .color_blend_state(&blend)
            .layout(view.layout.raw())
            .render_pass(pass);
        Pipeline::graphics(context, "population", info)
    }
}

impl Draw for StoredDraw {
    fn stem(&self) -> &'static str {
        "population"
    }

    fn pixel_bytes(&self) -> u64 {
        4
    }

    fn prepare(&mut self, view: &ViewMemory, lights: usize) -> Result<()> {
        let shaders = [&self.vertex, &self.fragment];
        let make = || Self::pipeline(&self.context, shaders, self.pass, view, lights);
        self.pipelines.prepare(lights, make)
    }

    fn prepared(&self, lights: usize) -> bool {
        self.pipelines.has(lights)
    }

    fn allocate(&mut self, [width, height]: [u32; 2], count: u32, _lights: &Buffer) -> Result<()> {
        // The old pictures go first, so that the two need not fit together.
        self.pictures = None;
        let image = pictures(&self.context, [width, height], count)?;
        let views = [image.view()];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(self.pass)
            .attachments(&views)
            .width(width)
            .height(height)
            .layers(count);
        // SAFETY: pass and view are alive; the pictures keep the view.
        let framebuffer = unsafe { self.context.device().create_framebuffer(&info, None) }
            .call("vkCreateFramebuffer")?;
        self.pictures = Some(Pictures { image, framebuffer, context: Arc::clone(&self.context) });
        Ok(())
    }

    fn pictures(&self) -> &Image {
        &self.target().image
    }

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        (chunk, count): (&Chunk, u32),
        lights: usize,
    ) {
        let to = self.target();
        let device = self.context.device();
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: to.image.extent() };
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(to.framebuffer)
            .render_area(area);
        let (point, layout) = (vk::PipelineBindPoint::GRAPHICS, view.layout.raw());
        // SAFETY: `cmd` is being recorded on this device; everything bound is alive and was made
        // for this pass and layout.
        unsafe {
            device.cmd_begin_render_pass(cmd, &begin, vk::SubpassContents::INLINE);
            device.cmd_bind_pipeline(cmd, point, self.pipelines.of(lights).raw());
            device.cmd_bind_descriptor_sets(cmd, point, layout, 0, &[view.set.raw()], &[]);
            device.cmd_push_constants(cmd, layout, PUSH_STAGES, 0, bytemuck::bytes_of(chunk));
            device.cmd_draw(cmd, 3, count, 0, 0);
            device.cmd_end_render_pass(cmd);
        }
    }
}

/// An image of `count` pictures.
///
/// # Errors
/// What the device reports.
pub fn pictures(context: &Arc<Context>, [width, height]: [u32; 2], count: u32) -> Result<Image> {
    let layers = Some(count);
    let (name, format, usage) = ("pictures", FORMAT, USAGE);
    Image::new(context, &ImageDesc { name, format, width, height, layers, mips: 1, usage })
}

/// One colour attachment, wholly overwritten, that compute shaders read next.
fn render_pass(context: &Arc<Context>) -> Result<vk::RenderPass> {
    let attachments = [vk::AttachmentDescription::default()
        .format(FORMAT)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::DONT_CARE)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
    let targets = [vk::AttachmentReference {
        attachment: 0,
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
    }];
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&targets)];
    let dependencies = [
        // The chunk before has been read.
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(COMPUTE_READ.0 | COPY_READ.0)
            .src_access_mask(COMPUTE_READ.1 | COPY_READ.1)
            .dst_stage_mask(COLOR_WRITE.0)
            .dst_access_mask(COLOR_WRITE.1),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(COLOR_WRITE.0)
            .src_access_mask(COLOR_WRITE.1)
            .dst_stage_mask(COMPUTE_READ.0 | COPY_READ.0)
            .dst_access_mask(COMPUTE_READ.1 | COPY_READ.1),
    ];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: the device is alive; `info` is complete.
    unsafe { context.device().create_render_pass(&info, None) }.call("vkCreateRenderPass")
}
