//! Stages that make a population's pictures, and the stage `population`: one instanced draw of N
//! layers, each layer the stored surface under the lights of its own individual.

use crate::Result;
use crate::gpu::Context;
use crate::gpu::layout::Chunk;
use crate::gpu::shaders;
use crate::gpu::view::memory::{PUSH_STAGES, ViewMemory};
use crate::gpu::view::records::Coloring;
use crate::gpu::vulkan::commands::{COLOR_WRITE, COMPUTE_READ, COPY_READ};
use crate::gpu::vulkan::graphics::{
    Framebuffer, GraphicsPipeline, RenderPass, VertexInput, attachment,
};
use crate::gpu::vulkan::memory::{Buffer, Image, ImageDesc};
use crate::gpu::vulkan::pipeline::{ByRigs, RigKind};
use ash::vk;
use std::sync::Arc;

/// Format of pictures that klieg draws: sRGB-encoded luminance, negative in the background; in colour the
/// irradiance beside it (`encoded` of `shaders/include/color.glsl`).
pub fn format(color: Option<Coloring>) -> vk::Format {
    if color.is_some() { vk::Format::R32G32_SFLOAT } else { vk::Format::R32_SFLOAT }
}

/// Numbers in a texel of pictures.
pub fn channels(format: vk::Format) -> usize {
    match format {
        vk::Format::R32_SFLOAT => 1,
        vk::Format::R32G32_SFLOAT => 2,
        _ => 4,
    }
}

/// What is done with the pictures once they are made.
const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::SAMPLED.as_raw() | vk::ImageUsageFlags::TRANSFER_SRC.as_raw(),
);

/// Makes the pictures of a chunk.
pub trait PictureStage {
    /// The stage's stem.
    fn stem(&self) -> &'static str;

    /// Format of the pictures.
    fn format(&self) -> vk::Format;

    /// Bytes that each pixel of each picture takes.
    fn pixel_bytes(&self) -> u64;

    /// How the stage writes the pictures.
    fn written(&self) -> vk::ImageUsageFlags;

    /// Most pictures that it makes at once, whatever the memory.
    fn most_pictures(&self) -> u32;

    /// Makes what such rigs need, unless it is there. Pictures that come without their
    /// lights have rigs of none.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn prepare(&mut self, view: &ViewMemory, rigs: RigKind) -> Result<()>;

    /// Whether that is there.
    fn prepared(&self, rigs: RigKind) -> bool;

    /// Makes room for `count` pictures; the lights will be in `lights`.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn allocate(&mut self, size: [u32; 2], count: u32, lights: &Buffer) -> Result<()>;

    /// One layer for each picture; `SHADER_READ_ONLY_OPTIMAL` after the stage.
    fn pictures(&self) -> &Image;

    /// Records the making of the pictures of `count` individuals of a chunk; compute shaders and
    /// copies see them then.
    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        chunk: (&Chunk, u32),
        rigs: RigKind,
    );
}

/// The pictures of a chunk of the population, as the draw's target.
struct Pictures {
    framebuffer: Framebuffer,
    image: Image,
}

/// The draw of the stored surface: its render pass and a pipeline for each number of lights seen.
pub struct StoredDraw {
    pictures: Option<Pictures>,
    pass: RenderPass,
    pipelines: ByRigs,
    color: Option<Coloring>,
    context: Arc<Context>,
}

impl StoredDraw {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        let pass = render_pass(context, format(view.color))?;
        let (color, context) = (view.color, Arc::clone(context));
        Ok(Self { pictures: None, pass, pipelines: ByRigs::default(), color, context })
    }

    fn target(&self) -> &Pictures {
        self.pictures.as_ref().expect("allocated before use")
    }
}

impl PictureStage for StoredDraw {
    fn stem(&self) -> &'static str {
        "population"
    }

    fn format(&self) -> vk::Format {
        format(self.color)
    }

    fn pixel_bytes(&self) -> u64 {
        4 * channels(self.format()) as u64
    }

    fn written(&self) -> vk::ImageUsageFlags {
        vk::ImageUsageFlags::COLOR_ATTACHMENT
    }

    fn most_pictures(&self) -> u32 {
        self.context.report().max_layers
    }

    fn prepare(&mut self, view: &ViewMemory, rigs: RigKind) -> Result<()> {
        let plain = ("population", [shaders::POPULATION_VERT, shaders::POPULATION_FRAG]);
        let colored =
            ("population_color", [shaders::POPULATION_COLOR_VERT, shaders::POPULATION_COLOR_FRAG]);
        let (stem, shaders) = if self.color.is_some() { colored } else { plain };
        let constants = draw_constants(rigs, self.color);
        let pipeline = GraphicsPipeline {
            stem,
            shaders,
            vertices: VertexInput::default(),
            constants: &constants,
            layout: view.layout,
            pass: self.pass,
        };
        self.pipelines.prepare(rigs, || pipeline.create(&self.context))
    }

    fn prepared(&self, rigs: RigKind) -> bool {
        self.pipelines.has(rigs)
    }

    fn allocate(&mut self, [width, height]: [u32; 2], count: u32, _lights: &Buffer) -> Result<()> {
        // The old pictures go first, so that the two need not fit together.
        self.pictures = None;
        let layers = target_layers(count);
        let texels = (self.format(), [width, height]);
        let image = pictures(&self.context, texels, layers, self.written())?;
        let of = (image.extent(), layers);
        let framebuffer = Framebuffer::new(&self.context, self.pass, &[image.view()], of)?;
        self.pictures = Some(Pictures { framebuffer, image });
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
        rigs: RigKind,
    ) {
        let device = self.context.recorder();
        self.pass.begin(cmd, &self.target().framebuffer, &[], self.pipelines.of(rigs));
        let (point, layout) = (vk::PipelineBindPoint::GRAPHICS, view.layout.raw());
        // SAFETY: `cmd` is being recorded on this device; everything bound is alive and was made
        // for this pass and layout.
        unsafe {
            device.cmd_bind_descriptor_sets(cmd, point, layout, 0, &[view.set.raw()], &[]);
            device.cmd_push_constants(cmd, layout, PUSH_STAGES, 0, bytemuck::bytes_of(chunk));
            device.cmd_draw(cmd, 3, count, 0, 0);
            device.cmd_end_render_pass(cmd);
        }
    }
}

/// Layers of the target of a draw of `count` pictures: at least two, as the validation layer calls the
/// layer that a vertex shader writes undefined where the framebuffer has but one.
pub fn target_layers(count: u32) -> u32 {
    count.max(2)
}

/// Specialisation constants of the draws that make pictures.
pub fn draw_constants(rigs: RigKind, color: Option<Coloring>) -> Vec<u32> {
    let color = color.map(|color| color.constants(rigs.near));
    std::iter::once(rigs.lights as u32).chain(color.into_iter().flatten()).collect()
}

/// Layers and bytes that an image of pictures can have at most, `written` in this way.
///
/// # Errors
/// [Device errors](crate::Error::is_device).
pub fn limits(
    context: &Context,
    format: vk::Format,
    written: vk::ImageUsageFlags,
) -> Result<vk::ImageFormatProperties> {
    context.image_limits(format, USAGE | written)
}

/// An image of `count` pictures, `written` in this way.
///
/// # Errors
/// [Device errors](crate::Error::is_device).
pub fn pictures(
    context: &Arc<Context>,
    (format, [width, height]): (vk::Format, [u32; 2]),
    count: u32,
    written: vk::ImageUsageFlags,
) -> Result<Image> {
    let layers = Some(count);
    let (name, usage) = ("pictures", USAGE | written);
    Image::new(context, &ImageDesc { name, format, width, height, layers, mips: 1, usage })
}

/// One colour attachment, wholly overwritten, that compute shaders read next.
fn render_pass(context: &Context, format: vk::Format) -> Result<RenderPass> {
    let operations = (vk::AttachmentLoadOp::DONT_CARE, vk::AttachmentStoreOp::STORE);
    let color = attachment(format, operations, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
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
    RenderPass::new(context, "population", &[color], false, &dependencies)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::gpu::vulkan::memory::Access;
    use crate::lighting::shading::Shading;
    use crate::objective::Objective;

    #[test]
    fn the_target_of_one_picture_is_layered_too() {
        let context = testing::context();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let lights = Buffer::new(&context, "lights", 64, usage, Access::Upload).unwrap();
        let (maps, view) = testing::maps(4, 3);
        let (objective, shading) = (Objective::default(), Shading::default());
        let memory =
            ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                .unwrap();
        let mut draw = StoredDraw::new(&context, &memory).unwrap();
        for (count, layers) in [(1, 2), (2, 2), (5, 5)] {
            draw.allocate([4, 3], count, &lights).unwrap();
            assert_eq!(draw.pictures().range().layer_count, layers);
        }
        testing::assert_valid(&context);
    }
}
