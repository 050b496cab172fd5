//! The pipeline `compute` for devices without fast shared memory: `shading` computes the brightness of
//! every object pixel for a block of individuals, `statistics` reduces it along runs of them.

use super::generation::{self, Measure};
use super::pixels::{FOUR_FLOATS, Pixels};
use crate::Result;
use crate::constants::{
    LIGHT_WINDOW as WINDOW, RUN_PIXELS as PIXELS, RUNS_BLOCK as BLOCK, STATISTICS_GROUP,
};
use crate::gpu::Context;
use crate::gpu::layout::{Chunk, pixel_binding};
use crate::gpu::shaders;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::view::records::Coloring;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE};
use crate::gpu::vulkan::memory::{Buffer, TexelBuffer};
use crate::gpu::vulkan::pipeline::{ByRigs, Pipeline, RigKind};
use crate::gpu::vulkan::staging;
use crate::gpu::vulkan::timer::StageTimer;
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of `shading`; each has a pixel.
const GROUP: u32 = 256;
const PIXEL_BYTES: u64 = size_of::<[f32; BLOCK as usize]>() as u64;
const LIGHT_BYTES: u32 = size_of::<LightRecord>() as u32;

/// The object pixels, the two stages and the memory between them.
pub struct Runs {
    shading: ByRigs,
    statistics: Pipeline,
    brightness: Option<TexelBuffer>,
    pixels: Pixels,
    size: [u32; 2],
    color: Option<Coloring>,
    /// What the offset of a window of lights is a multiple of, bytes.
    alignment: u32,
    context: Arc<Context>,
}

impl Runs {
    /// Whether the device's buffers and work groups can hold so many object pixels.
    pub fn fits(context: &Context, objects: u32) -> bool {
        let limits = context.limits();
        let pixels = u64::from(objects).next_multiple_of(GROUP.into());
        // The widest of what is written to storage buffers, then the brightness of one block.
        pixels * size_of::<[f32; 2]>() as u64 <= limits.max_storage_buffer_range.into()
            && pixels <= texels(context)
            && objects.div_ceil(GROUP) <= limits.max_compute_work_group_count[0]
    }

    /// For a view with at most `objects` object pixels, whose records and types are there.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when the object pixels are more than fit, and
    /// [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory, objects: u32) -> Result<Self> {
        if !Self::fits(context, objects) {
            let lacks = format!("pipeline compute for {objects} object pixels");
            return Err(context.unsupported(lacks));
        }
        let pixels = Pixels::new(context, view, objects, GROUP)?;
        let measured = generation::measured(view.objective.needs());
        let color = u32::from(view.color.is_some());
        let bins = HISTOGRAM_BINS as u32;
        let mut constants = vec![STATISTICS_GROUP, PIXELS, bins];
        constants.extend(measured);
        constants.push(color);
        let spirv = shaders::STATISTICS_COMP;
        let statistics =
            Pipeline::compute(context, "statistics", spirv, &pixels.layout, &constants)?;
        let alignment = context.limits().min_uniform_buffer_offset_alignment.max(1) as u32;
        let (size, color, context) = (view.size, view.color, Arc::clone(context));
        Ok(Self {
            shading: ByRigs::default(),
            statistics,
            brightness: None,
            pixels,
            size,
            color,
            alignment,
            context,
        })
    }

    fn block_bytes(&self) -> u64 {
        self.planes() * u64::from(self.pixels.stride) * PIXEL_BYTES
    }

    /// Texels of a pixel of a block: the brightness, and in colour the irradiance.
    fn planes(&self) -> u64 {
        if self.color.is_some() { 2 } else { 1 }
    }

    /// Work groups of `statistics` for each block.
    fn groups(&self) -> u32 {
        self.pixels.count.div_ceil(STATISTICS_GROUP * PIXELS)
    }
}

impl Measure for Runs {
    fn entries(&self) -> [u32; 2] {
        [self.groups() * STATISTICS_GROUP; 2]
    }

    fn block(&self) -> u32 {
        BLOCK
    }

    fn largest_chunk(&self, _view: &ViewMemory) -> Result<u32> {
        let limits = self.context.limits();
        let fit = texels(&self.context) / (self.planes() * u64::from(self.pixels.stride));
        let blocks = (self.context.picture_memory() / self.block_bytes())
            .max(1)
            .min(fit)
            .min(limits.max_compute_work_group_count[1].into());
        Ok(u32::try_from(blocks * u64::from(BLOCK)).unwrap_or(u32::MAX - BLOCK))
    }

    fn prepare(&mut self, _view: &ViewMemory, rigs: RigKind) -> Result<()> {
        let bytes = BLOCK * rigs.lights as u32 * LIGHT_BYTES;
        let aligned = bytes.is_multiple_of(self.alignment);
        let mut constants = vec![GROUP, rigs.lights as u32, aligned.into()];
        let (stem, spirv) = match self.color {
            None => ("shading", shaders::SHADING_COMP),
            Some(color) => {
                constants.extend(color.constants(rigs.near));
                ("shading_color", shaders::SHADING_COLOR_COMP)
            }
        };
        let layout = &self.pixels.layout;
        let make = || Pipeline::compute(&self.context, stem, spirv, layout, &constants);
        self.shading.prepare(rigs, make)
    }

    fn prepared(&self, rigs: RigKind) -> bool {
        self.shading.has(rigs)
    }

    fn allocate(&mut self, _view: &mut ViewMemory, chunk: u32, lights: &Buffer) -> Result<()> {
        // The old memory goes first, so that the two need not fit together.
        self.brightness = None;
        let count =
            self.planes() * u64::from(chunk.div_ceil(BLOCK)) * u64::from(self.pixels.stride);
        let usage = vk::BufferUsageFlags::STORAGE_TEXEL_BUFFER;
        let brightness = TexelBuffer::new(&self.context, "brightness", count, FOUR_FLOATS, usage)?;
        let (set, brightness) = (&mut self.pixels.set, self.brightness.insert(brightness));
        set.write_texels(pixel_binding::BRIGHTNESS_OUT, brightness);
        set.write_texels(pixel_binding::BRIGHTNESS, brightness);
        set.write_window(pixel_binding::WINDOW, lights, u64::from(WINDOW * LIGHT_BYTES));
        Ok(())
    }

    fn record_view(&self, cmd: vk::CommandBuffer, view: &ViewMemory) {
        self.pixels.record(cmd, view);
    }

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        timer: &mut StageTimer,
        (chunk, count): (&Chunk, u32),
        rigs: RigKind,
    ) {
        let shading = self.shading.of(rigs);
        let blocks = count.div_ceil(BLOCK);
        timer.stage(cmd, "shading", || {
            for block in 0..blocks {
                let byte = (chunk.first + block * BLOCK) * rigs.lights as u32 * LIGHT_BYTES;
                let window = byte - byte % self.alignment;
                let push = Chunk { block, light: (byte - window) / LIGHT_BYTES, ..*chunk };
                let groups = [self.pixels.count.div_ceil(GROUP), 1, 1];
                self.pixels.dispatch_lit(cmd, view, shading, groups, (&push, window));
            }
        });
        self.context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
        timer.stage(cmd, "statistics", || {
            let groups = [self.groups(), blocks, 1];
            self.pixels.dispatch(cmd, view, &self.statistics, groups, chunk);
        });
    }

    fn first_picture(&self, view: &ViewMemory) -> Result<Vec<f32>> {
        let count = view.read_statistics()?.objects() as usize;
        let brightness = self.brightness.as_ref().expect("allocated before use");
        let of_block: Vec<[f32; BLOCK as usize]> =
            staging::read_buffer(&self.context, brightness.buffer(), count)?;
        let at: Vec<u32> = staging::read_buffer(&self.context, &self.pixels.places, count)?;
        let mut picture = vec![0.0; self.size[0] as usize * self.size[1] as usize];
        for (value, place) in of_block.iter().zip(at) {
            picture[place as usize] = value[0];
        }
        Ok(picture)
    }
}

/// Texels that a buffer can have, and a shader's `int` can count.
fn texels(context: &Context) -> u64 {
    u64::from(context.limits().max_texel_buffer_elements).min(i32::MAX as u64)
}

/// Bytes behind the lights of a population that a window of lights may reach over.
pub const LIGHT_MARGIN: u64 = (WINDOW * LIGHT_BYTES) as u64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::lighting::shading::Shading;
    use crate::objective::Objective;

    #[test]
    fn windows_that_begin_before_their_lights_give_the_same_bits() {
        const INDIVIDUALS: u32 = 11;
        const LIGHTS: usize = 3;
        let context = testing::context();
        let (maps, view) = testing::maps(37, 29);
        let lights = testing::lights(INDIVIDUALS as usize * LIGHTS);
        let scores = |alignment: u32| {
            let (objective, shading) = (Objective::default(), Shading::default());
            let mut memory =
                ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                    .unwrap();
            let mut runs = Runs::new(&context, &memory, maps.counts.object()).unwrap();
            assert!(alignment.is_multiple_of(runs.alignment));
            runs.alignment = alignment;
            testing::scores(&context, (&mut memory, &mut runs), (INDIVIDUALS, &lights))
        };
        // The most that Vulkan lets a device ask for, and a block's lights.
        let [before, with] = [256, BLOCK * LIGHTS as u32 * LIGHT_BYTES].map(scores);
        assert_eq!(before, with);
        assert!(with.iter().all(|score| score.is_finite()) && with[0] != with[5]);
        testing::assert_valid(&context);
    }
}
