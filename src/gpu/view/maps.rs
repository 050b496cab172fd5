//! The compute stages that make a view's maps from its G-buffer, once for each view, in order:
//! `depth_range`, `edges`, `pixel_types`, `visible`, `normal_detail` and `normal_detail_total`.

use super::g_buffer::GBuffer;
use super::memory::{PIXEL_GROUP, ViewMemory};
use crate::Result;
use crate::constants::MAP_STRIP as STRIP;
use crate::gpu::Context;
use crate::gpu::layout::{self, ShapePart};
use crate::gpu::shaders;
use crate::gpu::vulkan::commands::{COMPUTE_WRITE, COPY_WRITE, Scope};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::Buffer;
use crate::gpu::vulkan::pipeline::{Binding, DescriptorSet, Pipeline, PipelineLayout};
use crate::gpu::vulkan::timer::StageTimer;
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of the stages that count or sum: side by side, so that each row is
/// read in order.
const STRIP_GROUP: [u32; 2] = [64, 1];
/// Invocations of the one work group that adds up what the strips have; a power of two.
const TOTAL_GROUP: u32 = 128;

/// What one invocation of a stage is for.
#[derive(Clone, Copy)]
enum Reach {
    Pixel,
    Strip,
    Picture,
}

/// The stages by their stems, in order.
const STAGES: [(&str, &[u32], Reach); 6] = [
    ("depth_range", shaders::DEPTH_RANGE_COMP, Reach::Strip),
    ("edges", shaders::EDGES_COMP, Reach::Pixel),
    ("pixel_types", shaders::PIXEL_TYPES_COMP, Reach::Strip),
    ("visible", shaders::VISIBLE_COMP, Reach::Strip),
    ("normal_detail", shaders::NORMAL_DETAIL_COMP, Reach::Strip),
    ("normal_detail_total", shaders::NORMAL_DETAIL_TOTAL_COMP, Reach::Picture),
];

/// Bindings of set 1: the scratch buffers, and from here on the depth's maps and the pixel types.
const FIRST_IMAGE: u32 = 3;

fn bindings() -> Vec<Binding> {
    let buffer = (vk::DescriptorType::STORAGE_BUFFER, vk::ShaderStageFlags::COMPUTE);
    let buffers = (0..FIRST_IMAGE).map(|number| (number, buffer.0, buffer.1));
    buffers.chain(layout::written_images(FIRST_IMAGE, 4)).collect()
}

/// The stages with their scratch memory and the maps that they write, set 1 of `shaders/include/maps.glsl`.
pub struct MapStages {
    stages: Vec<(&'static str, Pipeline, [u32; 3])>,
    set: DescriptorSet,
    layout: PipelineLayout,
    depth_range: Buffer,
    /// A bit for each colour code, set where it occurs; `u32` words. One word where codes may have any
    /// value, and no stage sets bits.
    pub visible: Buffer,
    _partials: Buffer,
    context: Arc<Context>,
}

impl MapStages {
    /// For a view with a G-buffer, whose colour codes are at most `polygons`, or have any value.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when there are more polygons or pixels than the device can
    /// take, and [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory, polygons: Option<u32>) -> Result<Self> {
        let mut set = DescriptorSet::new(context, "maps", &bindings())?;
        let sets = [view.set.layout(), set.layout()];
        let layout = PipelineLayout::new(context, &sets, vk::ShaderStageFlags::empty(), 0)?;
        let [width, height] = view.size;
        let strips = u64::from(width) * u64::from(height.div_ceil(STRIP));
        let words = u64::from(polygons.unwrap_or(0) / 32) + 1;
        let depth_range = Buffer::storage(context, "depth range", 4)?;
        let visible = Buffer::storage(context, "visible polygons", 4 * words)?;
        let partials =
            Buffer::storage(context, "partial sums", size_of::<ShapePart>() as u64 * strips)?;
        for (number, buffer) in (0..).zip([&depth_range, &visible, &partials]) {
            set.write_buffer(number, buffer);
        }
        let depth_maps = view.g_buffer.iter().flat_map(GBuffer::depth_maps);
        for (number, image) in (FIRST_IMAGE..).zip(depth_maps.chain([&view.types])) {
            set.write_image(number, image, vk::ImageLayout::GENERAL);
        }
        let stage = |(stem, spirv, reach): (&'static str, &[u32], Reach)| {
            let ([x, y], rows) = match reach {
                Reach::Pixel => (PIXEL_GROUP, 1),
                Reach::Strip => (STRIP_GROUP, STRIP),
                Reach::Picture => ([TOTAL_GROUP, 1], STRIP),
            };
            let groups = match reach {
                Reach::Picture => [1; 3],
                _ => [width.div_ceil(x), height.div_ceil(y * rows), 1],
            };
            let constants = [x, y, STRIP];
            Ok((stem, Pipeline::compute(context, stem, spirv, &layout, &constants)?, groups))
        };
        let made = |&(stem, ..): &(&str, &[u32], Reach)| polygons.is_some() || stem != "visible";
        let stages = STAGES.into_iter().filter(made).map(stage).collect::<Result<_>>()?;
        let (_partials, context) = (partials, Arc::clone(context));
        Ok(Self { stages, set, layout, depth_range, visible, _partials, context })
    }

    /// Records the stages. The G-buffer must be visible to compute shaders; what they leave is too,
    /// and to copies.
    pub fn record(&self, cmd: vk::CommandBuffer, view: &ViewMemory, timer: &mut StageTimer) {
        let device = self.context.recorder();
        for buffer in [&self.depth_range, &self.visible, &view.statistics] {
            // SAFETY: `cmd` is being recorded, and the buffers, of whole words, are alive.
            unsafe { device.cmd_fill_buffer(cmd, buffer.raw(), 0, vk::WHOLE_SIZE, 0) };
        }
        self.context.barrier(cmd, COPY_WRITE, COMPUTE_READ_WRITE);
        let (layout, sets) = (self.layout, [view.set.raw(), self.set.raw()]);
        for &(stem, ref pipeline, groups) in &self.stages {
            timer.stage(cmd, stem, || {
                let run =
                    Dispatch { pipeline, layout, sets: &sets, offsets: &[], push: None, groups };
                self.context.dispatch(cmd, &run);
                self.context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ_WRITE);
            });
        }
    }
}

/// Compute shaders read and write.
const COMPUTE_READ_WRITE: Scope = (
    vk::PipelineStageFlags::COMPUTE_SHADER,
    vk::AccessFlags::from_raw(
        vk::AccessFlags::SHADER_READ.as_raw() | vk::AccessFlags::SHADER_WRITE.as_raw(),
    ),
);
