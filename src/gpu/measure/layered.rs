//! The pipelines `layered` and `forward`, and the measuring of an engine's own pictures: a stage makes
//! the pictures, `histogram`, `moments` and `gradient` reduce them.

use super::generation::{self, Measure};
use super::population::{self, PictureStage};
use crate::Result;
use crate::constants::{HISTOGRAM_ROWS, SUM_ROWS};
use crate::gpu::Context;
use crate::gpu::layout::{Chunk, binding};
use crate::gpu::shaders;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::vulkan::commands::{COPY_READ, COPY_WRITE, Commands, HOST_READ};
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::{Pipeline, RigKind};
use crate::gpu::vulkan::timer::StageTimer;
use crate::objective::HISTOGRAM_BINS;
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of the reductions, along a row.
const COLUMNS: u32 = 64;

/// The stage that makes the pictures, and their reductions.
pub struct Layered<S> {
    /// Makes the pictures.
    pub stage: S,
    reductions: Vec<(&'static str, Pipeline, [u32; 2])>,
    size: [u32; 2],
    context: Arc<Context>,
}

impl<S: PictureStage> Layered<S> {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory, stage: S) -> Result<Self> {
        let reduction = |stem, spirv, rows, constants: &[u32]| {
            let pipeline = Pipeline::compute(context, stem, spirv, &view.layout, constants)?;
            let [width, height] = view.size;
            Ok((stem, pipeline, [width.div_ceil(COLUMNS), height.div_ceil(rows)]))
        };
        let needs = view.objective.needs();
        let [lights, detail, target, outline, curvature] = generation::measured(needs);
        let bins = [COLUMNS, HISTOGRAM_ROWS, HISTOGRAM_BINS as u32, curvature];
        let sums = [COLUMNS, SUM_ROWS];
        let mut reductions = vec![
            reduction("histogram", shaders::HISTOGRAM_COMP, HISTOGRAM_ROWS, &bins)?,
            reduction("moments", shaders::MOMENTS_COMP, SUM_ROWS, &sums)?,
            reduction("gradient", shaders::GRADIENT_COMP, SUM_ROWS, &sums)?,
        ];
        if needs.sums() {
            let constants = [COLUMNS, SUM_ROWS, lights, detail, target, outline];
            let spirv = shaders::APPEARANCE_COMP;
            reductions.push(reduction("appearance", spirv, SUM_ROWS, &constants)?);
        }
        Ok(Self { stage, reductions, size: view.size, context: Arc::clone(context) })
    }
}

impl<S: PictureStage> Measure for Layered<S> {
    fn entries(&self) -> [u32; 2] {
        [HISTOGRAM_ROWS, SUM_ROWS].map(|rows| self.size[0] * self.size[1].div_ceil(rows))
    }

    /// What layers, image size and memory allow.
    fn largest_chunk(&self, _view: &ViewMemory) -> Result<u32> {
        let image = population::limits(&self.context, self.stage.format(), self.stage.written())?;
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let memory = self.context.picture_memory().min(image.max_resource_size);
        let groups = self.context.limits().max_compute_work_group_count[2];
        let most = self.stage.most_pictures().min(image.max_array_layers).min(groups);
        Ok(u64::from(most).min((memory / (self.stage.pixel_bytes() * pixels)).max(1)) as u32)
    }

    fn prepare(&mut self, view: &ViewMemory, rigs: RigKind) -> Result<()> {
        self.stage.prepare(view, rigs)
    }

    fn prepared(&self, rigs: RigKind) -> bool {
        self.stage.prepared(rigs)
    }

    fn allocate(&mut self, view: &mut ViewMemory, chunk: u32, lights: &Buffer) -> Result<()> {
        self.stage.allocate(self.size, chunk, lights)?;
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        view.set.write_image(binding::PICTURES, self.stage.pictures(), layout);
        Ok(())
    }

    fn record_view(&self, _cmd: vk::CommandBuffer, _view: &ViewMemory) {}

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        timer: &mut StageTimer,
        (chunk, count): (&Chunk, u32),
        rigs: RigKind,
    ) {
        timer.stage(cmd, self.stage.stem(), || {
            self.stage.record(cmd, view, (chunk, count), rigs);
        });
        for (stem, pipeline, [x, y]) in &self.reductions {
            timer.stage(cmd, stem, || view.dispatch(cmd, pipeline, [*x, *y, count], chunk));
        }
    }

    fn first_picture(&self, _view: &ViewMemory) -> Result<Vec<f32>> {
        let pixels = self.size[0] as usize * self.size[1] as usize;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let channels = population::channels(self.stage.format());
        let size = 4 * (channels * pixels) as u64;
        let out = Buffer::new(&self.context, "picture", size, usage, Access::Readback)?;
        Commands::once(&self.context, |cmd| {
            let image = self.stage.pictures();
            // The stage leaves the pictures to shaders.
            let shader = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
            let copy = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            self.context.transition(cmd, image, (shader, copy), COPY_READ, COPY_READ);
            self.context.download(cmd, (image, copy, 0), &out);
            self.context.transition(cmd, image, (copy, shader), COPY_READ, COPY_READ);
            self.context.barrier(cmd, COPY_WRITE, HOST_READ);
            Ok(())
        })?;
        let mut texels = vec![0.0f32; channels * pixels];
        out.read(&mut texels)?;
        // The device marks the background by a negative value.
        Ok(texels.iter().step_by(channels).map(|value| value.max(0.0)).collect())
    }
}
