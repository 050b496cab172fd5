//! The stage `visibility`: one draw of the scene that leaves the nearest polygon of each pixel, with
//! its position, normal and material, in the G-buffer.

use super::commands::{COMPUTE_READ, COPY_READ};
use super::drawable::{DrawPipeline, Drawable, attachment};
use super::memory::{Image, ImageDesc};
use super::pipeline::Pipeline;
use super::view::GBuffer;
use super::{Call, Context, shaders};
use crate::Result;
use ash::vk;
use std::sync::Arc;

/// Colour attachments: those of the [`GBuffer`].
const COLORS: usize = 5;

/// The draw into a G-buffer. Not needed once that is done.
pub struct Visibility {
    pipeline: Pipeline,
    target: Target,
    context: Arc<Context>,
}

impl Visibility {
    /// # Errors
    /// What the device reports.
    pub fn new(context: &Arc<Context>, scene: &Drawable, g_buffer: &GBuffer) -> Result<Self> {
        let target = Target::new(context, g_buffer, scene)?;
        let pipeline = DrawPipeline {
            stem: "visibility",
            shaders: [shaders::VISIBILITY_VERT, shaders::VISIBILITY_FRAG],
            constants: &[],
            layout: target.layout,
            pass: (target.render_pass, COLORS),
            extent: target.extent,
        };
        let pipeline = pipeline.create(context)?;
        Ok(Self { pipeline, target, context: Arc::clone(context) })
    }

    /// Records the draw. The G-buffer is then in layout `GENERAL` and visible to compute
    /// shaders and to copies.
    pub fn record(&self, cmd: vk::CommandBuffer, scene: &Drawable) {
        let device = self.context.device();
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
            device.cmd_bind_pipeline(cmd, vk::PipelineBindPoint::GRAPHICS, self.pipeline.raw());
            scene.record(cmd, self.target.layout, (0, None));
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
    fn new(context: &Arc<Context>, g_buffer: &GBuffer, scene: &Drawable) -> Result<Self> {
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
        target.layout = scene.layout(&[])?;
        let device = context.device();
        // SAFETY: the device and all that the infos name are alive; `target` owns what is made.
        unsafe {
            target.framebuffer =
                device.create_framebuffer(&framebuffer, None).call("vkCreateFramebuffer")?;
        }
        Ok(target)
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the target; null handles are allowed.
        self.context.destroy(|device| unsafe {
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_framebuffer(self.framebuffer, None);
            device.destroy_render_pass(self.render_pass, None);
        });
    }
}

/// A pass that clears and writes the G-buffer and a depth image.
fn render_pass(context: &Context, colors: [vk::Format; COLORS]) -> Result<vk::RenderPass> {
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
