//! The stage `visibility`: one draw of the scene that leaves the nearest polygon of each pixel, with
//! its position, normal and material, in the G-buffer.

use super::g_buffer::{BASE_COLOR_LAYER, EMISSIVE_LAYER, GBuffer};
use crate::Result;
use crate::gpu::Context;
use crate::gpu::scene::drawable::{Drawable, VERTICES};
use crate::gpu::shaders;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COPY_READ};
use crate::gpu::vulkan::graphics::{DEPTH, Framebuffer, GraphicsPipeline, RenderPass, attachment};
use crate::gpu::vulkan::memory::{Image, ImageDesc, LayerView};
use crate::gpu::vulkan::pipeline::{Pipeline, PipelineLayout};
use ash::vk;
use std::sync::Arc;

/// Colour attachments: the surface of the [`GBuffer`], its material layer by layer.
const COLORS: usize = 5;

/// The draw into a G-buffer. Not needed once that is done.
pub struct Visibility {
    pipeline: Pipeline,
    layout: PipelineLayout,
    pass: RenderPass,
    target: Framebuffer,
    _depth: Image,
    _layers: [LayerView; 2],
    context: Arc<Context>,
}

impl Visibility {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, scene: &Drawable, g_buffer: &GBuffer) -> Result<Self> {
        let GBuffer { code, position_roughness, normal_metallic, material, .. } = g_buffer;
        let extent = code.extent();
        let depth = depth(context, extent)?;
        let colors = [code, position_roughness, normal_metallic, material, material];
        let pass = render_pass(context, colors.map(Image::format))?;
        let layers = [BASE_COLOR_LAYER, EMISSIVE_LAYER].map(|layer| material.layer_view(layer));
        let [base_color, emissive] = layers;
        let layers = [base_color?, emissive?];
        let [base_color, emissive] = &layers;
        let views = [
            code.view(),
            position_roughness.view(),
            normal_metallic.view(),
            base_color.raw(),
            emissive.raw(),
            depth.view(),
        ];
        let target = Framebuffer::new(context, pass, &views, (extent, 1))?;
        let layout = scene.layout(&[])?;
        let pipeline = GraphicsPipeline {
            stem: "visibility",
            shaders: [shaders::VISIBILITY_VERT, shaders::VISIBILITY_FRAG],
            vertices: VERTICES,
            constants: &[],
            layout,
            pass,
        };
        let pipeline = pipeline.create(context)?;
        let (_depth, _layers, context) = (depth, layers, Arc::clone(context));
        Ok(Self { pipeline, layout, pass, target, _depth, _layers, context })
    }

    /// Records the draw. The G-buffer is then in layout `GENERAL` and visible to compute
    /// shaders and to copies.
    pub fn record(&self, cmd: vk::CommandBuffer, scene: &Drawable) {
        // Everything is cleared to 0: no polygon, and with reversed depth the far plane.
        let clear = [vk::ClearValue::default(); COLORS + 1];
        self.pass.begin(cmd, &self.target, &clear, &self.pipeline);
        scene.record(cmd, self.layout, (0, None));
        // SAFETY: `cmd` is being recorded on this device, in the pass that has begun.
        unsafe { self.context.recorder().cmd_end_render_pass(cmd) };
    }
}

/// What the draw compares depths in.
fn depth(context: &Arc<Context>, extent: vk::Extent2D) -> Result<Image> {
    let depth = ImageDesc {
        name: "visibility depth",
        format: DEPTH,
        width: extent.width,
        height: extent.height,
        layers: None,
        mips: 1,
        usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
    };
    Image::new(context, &depth)
}

/// A pass that clears and writes the G-buffer and a depth image.
fn render_pass(context: &Context, colors: [vk::Format; COLORS]) -> Result<RenderPass> {
    let operations = (vk::AttachmentLoadOp::CLEAR, vk::AttachmentStoreOp::STORE);
    let color = |format| attachment(format, operations, vk::ImageLayout::GENERAL);
    RenderPass::new(context, "visibility", &colors.map(color), true, &dependencies())
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
