//! The stage `forward`: one batched draw of the scene's own geometry, N instances of every mesh, each
//! picture with its own depth. It costs N times the triangles; it checks that the stored surface is
//! right, and is what the other pipelines are measured against.

use super::population::{self, PictureStage, channels, format};
use crate::Result;
use crate::constants::{MAX_LIGHTS, NO_OBJECT};
use crate::gpu::Context;
use crate::gpu::layout::Chunk;
use crate::gpu::scene::drawable::{Drawable, VERTICES};
use crate::gpu::shaders;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::view::records::Coloring;
use crate::gpu::vulkan::commands::{COLOR_WRITE, COMPUTE_READ, COPY_READ};
use crate::gpu::vulkan::graphics::{DEPTH, Framebuffer, GraphicsPipeline, RenderPass, attachment};
use crate::gpu::vulkan::memory::{Buffer, Image, ImageDesc};
use crate::gpu::vulkan::pipeline::{ByRigs, DescriptorSet, PipelineLayout, RigKind};
use ash::vk;
use std::sync::Arc;

/// Components that the vertices hand to the fragments, 24 of the surface and six of each light, and
/// behind them those of the position and the layer.
const COMPONENTS: u32 = 24 + 6 * MAX_LIGHTS;
const BUILT_IN: u32 = 5;

/// Bindings of set 2 behind the lights: the records for shading in colour, and the five of
/// [`ShadowMemory::write`](crate::gpu::view::shadows::ShadowMemory::write).
const COLORS: u32 = 1;
const SHADOWS: u32 = 2;

/// The draw, with a pipeline for each number of lights seen.
pub struct ForwardDraw {
    target: Option<Target>,
    pipelines: ByRigs,
    pass: RenderPass,
    layout: PipelineLayout,
    /// The lights and, in colour, what shadows are made of.
    set: DescriptorSet,
    scene: Arc<Drawable>,
    color: Option<Coloring>,
    context: Arc<Context>,
}

/// The pictures of a chunk with their depths.
struct Target {
    framebuffer: Framebuffer,
    pictures: Image,
    _depth: Image,
}

impl ForwardDraw {
    /// # Errors
    /// [`crate::Error::Unsupported`] when the device cannot hand so much to the fragments, and
    /// [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory, scene: Arc<Drawable>) -> Result<Self> {
        let limits = context.limits();
        let components = limits
            .max_fragment_input_components
            .min(limits.max_vertex_output_components - BUILT_IN);
        if components < COMPONENTS {
            let lacks = format!("{COMPONENTS} varying components (it has {components})");
            return Err(context.unsupported(lacks));
        }
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let fragment = vk::ShaderStageFlags::FRAGMENT;
        let (image, storage) =
            (vk::DescriptorType::SAMPLED_IMAGE, vk::DescriptorType::STORAGE_BUFFER);
        let bindings = [
            (0, storage, stages),
            (COLORS, image, fragment),
            (SHADOWS, image, fragment),
            (SHADOWS + 1, storage, fragment),
            (SHADOWS + 2, storage, fragment),
            (SHADOWS + 3, storage, fragment),
            (SHADOWS + 4, vk::DescriptorType::UNIFORM_BUFFER, fragment),
        ];
        let mut set = DescriptorSet::new(context, "forward", &bindings)?;
        set.write_image(COLORS, &view.colors, vk::ImageLayout::GENERAL);
        view.shadows.write(&mut set, SHADOWS);
        Ok(Self {
            target: None,
            pipelines: ByRigs::default(),
            pass: render_pass(context, format(view.color))?,
            layout: scene.layout(&[set.layout()])?,
            set,
            scene,
            color: view.color,
            context: Arc::clone(context),
        })
    }

    fn target(&self) -> &Target {
        self.target.as_ref().expect("allocated before use")
    }
}

impl PictureStage for ForwardDraw {
    fn stem(&self) -> &'static str {
        "forward"
    }

    fn format(&self) -> vk::Format {
        format(self.color)
    }

    fn pixel_bytes(&self) -> u64 {
        4 * (channels(self.format()) as u64 + 1) // with the depth
    }

    fn written(&self) -> vk::ImageUsageFlags {
        vk::ImageUsageFlags::COLOR_ATTACHMENT
    }

    fn most_pictures(&self) -> u32 {
        // A draw's instances are counted in 32 bits.
        let most = u32::MAX / self.scene.most_instances().max(1);
        most.min(self.context.report().max_layers)
    }

    fn prepare(&mut self, _view: &ViewMemory, rigs: RigKind) -> Result<()> {
        let plain = ("forward", [shaders::FORWARD_VERT, shaders::FORWARD_FRAG]);
        let colored = ("forward_color", [shaders::FORWARD_COLOR_VERT, shaders::FORWARD_COLOR_FRAG]);
        let (stem, shaders) = if self.color.is_some() { colored } else { plain };
        let mut constants = population::draw_constants(rigs, self.color);
        if let Some(color) = self.color {
            // This shader makes the reflectances too, which differ between the two forms of glTF's.
            constants[1] = color.brdf.number();
        }
        let pipeline = GraphicsPipeline {
            stem,
            shaders,
            vertices: VERTICES,
            constants: &constants,
            layout: self.layout,
            pass: self.pass,
        };
        self.pipelines.prepare(rigs, || pipeline.create(&self.context))
    }

    fn prepared(&self, rigs: RigKind) -> bool {
        self.pipelines.has(rigs)
    }

    fn allocate(&mut self, [width, height]: [u32; 2], count: u32, lights: &Buffer) -> Result<()> {
        // The old pictures go first, so that the two need not fit together.
        self.target = None;
        let layers = population::target_layers(count);
        let texels = (self.format(), [width, height]);
        let pictures = population::pictures(&self.context, texels, layers, self.written())?;
        let depth = ImageDesc {
            name: "forward depth",
            format: DEPTH,
            width,
            height,
            layers: Some(layers),
            mips: 1,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        };
        let depth = Image::new(&self.context, &depth)?;
        let (views, of) = ([pictures.view(), depth.view()], (pictures.extent(), layers));
        let framebuffer = Framebuffer::new(&self.context, self.pass, &views, of)?;
        self.target = Some(Target { framebuffer, pictures, _depth: depth });
        self.set.write_buffer(0, lights);
        Ok(())
    }

    fn pictures(&self) -> &Image {
        &self.target().pictures
    }

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        _view: &ViewMemory,
        (chunk, count): (&Chunk, u32),
        rigs: RigKind,
    ) {
        let background = vk::ClearColorValue { float32: [NO_OBJECT, 0.0, 0.0, 0.0] };
        // With reversed depth 0 is the far plane.
        let clear = [vk::ClearValue { color: background }, vk::ClearValue::default()];
        let (pass, pipeline) = (self.pass, self.pipelines.of(rigs));
        pass.begin(cmd, &self.target().framebuffer, &clear, pipeline);
        let (device, layout) = (self.context.recorder(), self.layout.raw());
        let (point, set) = (vk::PipelineBindPoint::GRAPHICS, [self.set.raw()]);
        // SAFETY: `cmd` is being recorded on this device, in the pass that has begun; the set is
        // alive and was made for this layout.
        unsafe {
            device.cmd_bind_descriptor_sets(cmd, point, layout, 2, &set, &[]);
            self.scene.record(cmd, self.layout, (chunk.first * rigs.lights as u32, Some(count)));
            device.cmd_end_render_pass(cmd);
        }
    }
}

/// A cleared colour attachment that compute shaders read next, and a depth that is only tested.
fn render_pass(context: &Context, format: vk::Format) -> Result<RenderPass> {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let operations = (vk::AttachmentLoadOp::CLEAR, vk::AttachmentStoreOp::STORE);
    let color = attachment(format, operations, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    let tests = Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    let depth_write = Access::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let dependencies = [
        // The chunk before has been read, and its depth written.
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(COMPUTE_READ.0 | COPY_READ.0 | tests)
            .src_access_mask(COMPUTE_READ.1 | COPY_READ.1 | depth_write)
            .dst_stage_mask(COLOR_WRITE.0 | tests)
            .dst_access_mask(COLOR_WRITE.1 | depth_write | Access::DEPTH_STENCIL_ATTACHMENT_READ),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(COLOR_WRITE.0)
            .src_access_mask(COLOR_WRITE.1)
            .dst_stage_mask(COMPUTE_READ.0 | COPY_READ.0)
            .dst_access_mask(COMPUTE_READ.1 | COPY_READ.1),
    ];
    RenderPass::new(context, "forward", &[color], true, &dependencies)
}
