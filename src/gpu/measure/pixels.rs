//! The surface without its background: the list of object pixels that the stages of `compute` visit.
//! `pixel_rows` and `pixels` make it once for each view; `shaders/include/pixels.glsl` declares its
//! set.

use crate::Result;
use crate::gpu::Context;
use crate::gpu::layout::{Chunk, pixel_binding, pixel_bindings};
use crate::gpu::shaders;
use crate::gpu::view::memory::{PUSH_BYTES, PUSH_STAGES, ViewMemory, push_constants};
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ, Commands};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Buffer, TexelBuffer};
use crate::gpu::vulkan::pipeline::{DescriptorSet, Pipeline, PipelineLayout};
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of `pixel_rows` and `pixels`: one for each row.
const ROW_GROUP: u32 = 32;

/// Texels of four numbers, and their bytes.
pub const FOUR_UINTS: (vk::Format, u64) = (vk::Format::R32G32B32A32_UINT, 16);
/// The same.
pub const FOUR_FLOATS: (vk::Format, u64) = (vk::Format::R32G32B32A32_SFLOAT, 16);
const TWO_FLOATS: (vk::Format, u64) = (vk::Format::R32G32_SFLOAT, 8);

/// The object pixels of a view, row after row, on the device.
pub struct Pixels {
    /// How many there are at most.
    pub count: u32,
    /// For how many there is memory: the next multiple of what was asked for.
    pub stride: u32,
    /// Set 1 of the stages that visit object pixels.
    pub set: DescriptorSet,
    /// Layout of these stages: the view's set and this.
    pub layout: PipelineLayout,
    /// Their places in the picture: `y·width + x`.
    pub places: Buffer,
    stages: [Pipeline; 2],
    _rows: Buffer,
    _texels: [TexelBuffer; 4],
    context: Arc<Context>,
}

impl Pixels {
    /// Lists the object pixels, at most `count`, of a view whose records and types are there, with room
    /// for a multiple of `multiple`.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when the list is more than the device's buffers can hold, and
    /// [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        view: &ViewMemory,
        count: u32,
        multiple: u32,
    ) -> Result<Self> {
        let stride = count.max(1).next_multiple_of(multiple);
        let rows = Buffer::storage(context, "pixel rows", 4 * u64::from(view.size[1]))?;
        let places = Buffer::storage(context, "pixel places", 4 * u64::from(stride))?;
        let texels =
            |name, of, written| TexelBuffer::new(context, name, stride.into(), of, written);
        let (as_texels, as_words) =
            (vk::BufferUsageFlags::STORAGE_TEXEL_BUFFER, vk::BufferUsageFlags::STORAGE_BUFFER);
        let taps = texels("pixel taps", FOUR_UINTS, as_texels)?;
        let positions = texels("pixel positions", FOUR_FLOATS, as_texels)?;
        let normals = texels("pixel normals", FOUR_FLOATS, as_texels)?;
        let looks = texels("pixel looks", TWO_FLOATS, as_words)?;
        let mut set = DescriptorSet::new(context, "pixels", &pixel_bindings())?;
        set.write_buffer(pixel_binding::ROW_COUNTS, &rows);
        set.write_buffer(pixel_binding::PLACES, &places);
        set.write_buffer(pixel_binding::LOOKS_OUT, looks.buffer());
        for (number, texels) in [
            (pixel_binding::TAPS_OUT, &taps),
            (pixel_binding::POSITIONS_OUT, &positions),
            (pixel_binding::NORMALS_OUT, &normals),
            (pixel_binding::TAPS, &taps),
            (pixel_binding::POSITIONS, &positions),
            (pixel_binding::NORMALS, &normals),
            (pixel_binding::LOOKS, &looks),
        ] {
            set.write_texels(number, texels);
        }
        let sets = [view.set.layout(), set.layout()];
        let layout = PipelineLayout::new(context, &sets, PUSH_STAGES, PUSH_BYTES)?;
        let (_rows, _texels) = (rows, [taps, positions, normals, looks]);
        let stage = |stem, spirv| Pipeline::compute(context, stem, spirv, &layout, &[ROW_GROUP]);
        let stages = [
            stage("pixel_rows", shaders::PIXEL_ROWS_COMP)?,
            stage("pixels", shaders::PIXELS_COMP)?,
        ];
        let context = Arc::clone(context);
        let pixels = Self { count, stride, set, layout, places, stages, _rows, _texels, context };
        Commands::once(&pixels.context, |cmd| {
            pixels.record(cmd, view);
            Ok(())
        })?;
        Ok(pixels)
    }

    /// Records the listing. Records and types must be visible to compute shaders; the list is then,
    /// and to copies.
    pub fn record(&self, cmd: vk::CommandBuffer, view: &ViewMemory) {
        let groups = [view.size[1].div_ceil(ROW_GROUP), 1, 1];
        let [rows, pixels] = &self.stages;
        self.dispatch(cmd, view, rows, groups, &Chunk::default());
        self.context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
        self.dispatch(cmd, view, pixels, groups, &Chunk::default());
        let readers = (COMPUTE_READ.0 | COPY_READ.0, COMPUTE_READ.1 | COPY_READ.1);
        self.context.barrier(cmd, COMPUTE_WRITE, readers);
    }

    /// Records a stage that does not read the lights.
    pub fn dispatch(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        pipeline: &Pipeline,
        groups: [u32; 3],
        push: &Chunk,
    ) {
        self.dispatch_lit(cmd, view, pipeline, groups, (push, 0));
    }

    /// Records a stage that reads the lights from the given byte of their buffer on.
    pub fn dispatch_lit(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        pipeline: &Pipeline,
        groups: [u32; 3],
        (push, window): (&Chunk, u32),
    ) {
        let run = Dispatch {
            pipeline,
            layout: self.layout,
            sets: &[view.set.raw(), self.set.raw()],
            offsets: &[window],
            push: push_constants(push),
            groups,
        };
        self.context.dispatch(cmd, &run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::gpu::vulkan::staging;
    use crate::lighting::shading::Shading;
    use crate::objective::Objective;
    use crate::objective::maps::{Maps, PixelType};

    /// The device's list in the form of the reference's.
    fn listed(context: &Arc<Context>, maps: &Maps, view: &ViewMemory) -> Vec<cpu::pixels::Pixel> {
        let count = maps.counts.object();
        let pixels = Pixels::new(context, view, count, 64).unwrap();
        let [taps, ..] = &pixels._texels;
        let taps: Vec<[u32; 4]> =
            staging::read_buffer(context, taps.buffer(), count as usize).unwrap();
        let places: Vec<u32> =
            staging::read_buffer(context, &pixels.places, count as usize).unwrap();
        let pixel = |(number, (at, &place)): (usize, (&[u32; 4], &u32))| {
            let &[up, down, present, kind] = at;
            let (number, bit) = (number as u32, |k: u32| present >> k & 1);
            let row = |middle: u32, k: u32| [middle.wrapping_sub(1), middle, middle + bit(k)];
            let rows = [row(up, 1), [number.wrapping_sub(1), number, number + 1], row(down, 7)];
            let all = rows.as_flattened();
            let kind = if kind == 2 { PixelType::Edge } else { PixelType::Surface };
            let or_own = |k: usize| if bit(k as u32) != 0 { all[k] } else { number };
            cpu::pixels::Pixel { place, kind, neighbours: std::array::from_fn(or_own) }
        };
        taps.iter().zip(&places).enumerate().map(pixel).collect()
    }

    #[test]
    fn the_device_lists_the_pixels_that_the_reference_lists() {
        let context = testing::context();
        let (objective, shading) = (Objective::default(), Shading::default());
        for (width, height) in [(37, 19), (1, 1), (3, 200), (129, 65)] {
            let (mut maps, view) = testing::maps(width, height);
            // Holes of one pixel, and pixels alone.
            for at in (0..maps.types.len()).step_by(5) {
                let object = maps.types[at] != PixelType::Background;
                maps.types[at] = if object { PixelType::Background } else { PixelType::Edge };
                maps.surface.code[at] = u32::from(!object);
            }
            let count = |kind| maps.types.iter().filter(|&&k| k == kind).count() as u32;
            maps.counts.surface = count(PixelType::Surface);
            maps.counts.edge = count(PixelType::Edge);
            let memory =
                ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                    .unwrap();
            let references = cpu::pixels::pixels(&maps.types, width, height);
            assert_eq!(listed(&context, &maps, &memory), references, "{width}x{height}");
        }
        testing::assert_valid(&context);
    }
}
