//! A generation on the device: a pipeline measures the pictures of a chunk of the population, `fitness`
//! makes the scores. A population larger than what the pipeline can hold at once goes in chunks.

use super::runs::LIGHT_MARGIN;
use crate::gpu::Context;
use crate::gpu::layout::{Chunk, Detail, GradientPart, MomentPart, binding};
use crate::gpu::shaders;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ, HOST_READ, StageTimer};
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::Pipeline;
use crate::gpu::vulkan::staging;
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of `fitness`.
const FITNESS_GROUP: u32 = 128;
/// Stages of a chunk, at most.
const STAGES: u32 = 5;

/// Where a recorded evaluation leaves its scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScoreTarget {
    /// In klieg's mapped memory, for `read_scores` of the evaluator.
    Mapped,
    /// In a buffer of the engine, an `f32` for each individual in order.
    Buffer {
        /// The buffer.
        buffer: vk::Buffer,
        /// Where the first score goes, bytes from its front.
        offset: u64,
    },
}

/// Makes and measures the pictures of a chunk: what differs between the pipelines.
pub trait Measure {
    /// Partial results of each picture: histograms; moments and gradients.
    fn entries(&self) -> [u32; 2];

    /// Bits of a bin of a partial histogram.
    fn bin_bits(&self) -> u32 {
        8
    }

    /// Individuals that are measured together; their partial results are always written.
    fn block(&self) -> u32 {
        1
    }

    /// Pictures that it can hold, a multiple of the block; 0 when it cannot hold any.
    ///
    /// # Errors
    /// What the device reports.
    fn largest_chunk(&self) -> Result<u32>;

    /// Makes what rigs of `lights` lights need, unless it is there.
    ///
    /// # Errors
    /// What the device reports.
    fn prepare(&mut self, view: &ViewMemory, lights: usize) -> Result<()>;

    /// Whether that is there.
    fn prepared(&self, lights: usize) -> bool;

    /// Makes room for `chunk` pictures; the lights will be in `lights`.
    ///
    /// # Errors
    /// What the device reports.
    fn allocate(&mut self, view: &mut ViewMemory, chunk: u32, lights: &Buffer) -> Result<()>;

    /// Records what has to be known of a view whose maps the commands before have made, visible to
    /// compute shaders; what it leaves is too.
    fn record_view(&self, cmd: vk::CommandBuffer, view: &ViewMemory);

    /// Records the stages that leave the partial results of a chunk of `count` rigs of `lights`
    /// lights.
    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        timer: &mut StageTimer,
        chunk: (&Chunk, u32),
        lights: usize,
    );

    /// The first picture of the last chunk: `I`, 0 in the background, rows from the top.
    ///
    /// # Errors
    /// What the device reports.
    fn first_picture(&self, view: &ViewMemory) -> Result<Vec<f32>>;
}

/// The stage `fitness`.
pub struct Fitness(Pipeline);

impl Fitness {
    /// # Errors
    /// What the device reports.
    pub fn new(context: &Arc<Context>, view: &ViewMemory, measure: &dyn Measure) -> Result<Self> {
        let constants = [FITNESS_GROUP, HISTOGRAM_BINS as u32, measure.bin_bits()];
        let spirv = shaders::FITNESS_COMP;
        Pipeline::compute(context, "fitness", spirv, &view.layout, &constants).map(Self)
    }
}

/// The device memory of a generation; it only ever grows.
pub struct GenerationMemory {
    /// The lights of all individuals; the host writes.
    pub lights: Buffer,
    /// `F` of all individuals; the host reads.
    pub scores: Buffer,
    /// [`Detail`] of all individuals.
    details: Buffer,
    /// Times of the last run.
    pub timer: StageTimer,
    /// Labels the stages of an engine's recordings.
    untimed: StageTimer,
    /// Individuals that are measured at once.
    chunk: u32,
    individuals: u32,
    records: usize,
    entries: [u32; 2],
    _parts: [Buffer; 3],
}

impl GenerationMemory {
    /// Memory for `individuals` and `records` lights in all, put into the view's set.
    ///
    /// # Errors
    /// [`Error::Argument`] when these or the picture are more than the device's buffers can hold,
    /// and what the device reports.
    pub fn new(
        context: &Arc<Context>,
        view: &mut ViewMemory,
        measure: &mut dyn Measure,
        (individuals, records): (u32, usize),
    ) -> Result<Self> {
        let entries = measure.entries();
        let chunk =
            chunk(context, view.size, measure)?.min(individuals.next_multiple_of(measure.block()));
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let device = |name, bytes| Buffer::new(context, name, bytes, storage, Access::Device);
        let [histogram, moments, gradient] = part_bytes(measure).map(|b| b * u64::from(chunk));
        let parts = [
            device("histogram parts", histogram)?,
            device("moment parts", moments)?,
            device("gradient parts", gradient)?,
        ];
        let lights = (records * size_of::<LightRecord>()) as u64 + LIGHT_MARGIN;
        let details = u64::from(individuals) * size_of::<Detail>() as u64;
        let largest = u64::from(context.limits().max_storage_buffer_range);
        if lights.max(details) > largest {
            return Err(Error::Argument(format!(
                "{individuals} individuals are more than the device's buffers can hold"
            )));
        }
        let lights_usage =
            storage | vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let details_usage = storage | vk::BufferUsageFlags::TRANSFER_SRC;
        let scores = u64::from(individuals) * 4;
        let memory = Self {
            lights: Buffer::new(context, "lights", lights, lights_usage, Access::Upload)?,
            scores: Buffer::new(context, "scores", scores, details_usage, Access::Readback)?,
            details: Buffer::new(context, "details", details, details_usage, Access::Device)?,
            timer: StageTimer::new(context, STAGES * individuals.div_ceil(chunk))?,
            untimed: StageTimer::new(context, 0)?,
            chunk,
            individuals,
            records,
            entries,
            _parts: parts,
        };
        measure.allocate(view, chunk, &memory.lights)?;
        let [histogram, moments, gradient] = &memory._parts;
        for (number, buffer) in [
            (binding::LIGHTS, &memory.lights),
            (binding::HISTOGRAM, histogram),
            (binding::MOMENTS, moments),
            (binding::GRADIENT, gradient),
            (binding::SCORES, &memory.scores),
            (binding::DETAILS, &memory.details),
        ] {
            view.set.write_buffer(number, buffer);
        }
        Ok(memory)
    }

    /// Makes memory for `wanted` individuals and lights in all, and for what was `held` before, unless
    /// that has enough; whether it did.
    ///
    /// # Errors
    /// As [`GenerationMemory::new`].
    pub fn grow(
        held: &mut Option<Self>,
        context: &Arc<Context>,
        (view, measure): (&mut ViewMemory, &mut dyn Measure),
        (individuals, records): (u32, usize),
    ) -> Result<bool> {
        if held.as_ref().is_some_and(|g| g.holds(individuals, records)) {
            return Ok(false);
        }
        let (old, old_records) = held.as_ref().map_or((0, 0), |g| (g.individuals, g.records));
        // The old memory goes first, so that the two need not fit together.
        *held = None;
        let capacity = (individuals.max(old).max(1), records.max(old_records));
        *held = Some(Self::new(context, view, measure, capacity)?);
        Ok(true)
    }

    /// Whether it holds so many individuals and lights.
    pub fn holds(&self, individuals: u32, records: usize) -> bool {
        individuals <= self.individuals && records <= self.records
    }

    /// Records a generation of `individuals` rigs of `lights` lights, which klieg submits itself and
    /// times, or which an engine submits.
    pub fn record(
        &mut self,
        cmd: vk::CommandBuffer,
        context: &Context,
        (view, measure, fitness): (&ViewMemory, &dyn Measure, &Fitness),
        (individuals, lights): (u32, usize),
        timed: bool,
    ) {
        let timer = if timed { &mut self.timer } else { &mut self.untimed };
        timer.reset(cmd);
        let [histogram_entries, entries] = self.entries;
        for first in (0..individuals).step_by(self.chunk as usize) {
            if first > 0 {
                // The last chunk's `fitness` has read what this one's stages write.
                context.barrier(cmd, COMPUTE_READ, COMPUTE_WRITE);
            }
            let count = self.chunk.min(individuals - first);
            let chunk = Chunk { first, histogram_entries, entries, ..Chunk::default() };
            measure.record(cmd, view, timer, (&chunk, count), lights);
            context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
            timer.stage(cmd, "fitness", || {
                view.dispatch(cmd, &fitness.0, [count, 1, 1], &chunk);
            });
        }
        context.barrier(cmd, COMPUTE_WRITE, (HOST_READ.0 | COPY_READ.0, HOST_READ.1 | COPY_READ.1));
    }

    /// Records the way of `count` scores to where an engine wants them.
    ///
    /// # Safety
    /// `cmd` is being recorded on the context's device; a buffer has room for them and may be the
    /// target of copies.
    pub unsafe fn deliver(
        &self,
        cmd: vk::CommandBuffer,
        context: &Context,
        count: u32,
        target: ScoreTarget,
    ) {
        if let ScoreTarget::Buffer { buffer, offset } = target {
            let region = [vk::BufferCopy::default().dst_offset(offset).size(4 * u64::from(count))];
            // SAFETY: the caller's promises for `cmd` and the buffer.
            unsafe { context.recorder().cmd_copy_buffer(cmd, self.scores.raw(), buffer, &region) };
        }
    }

    /// Reads the scores of the generation that has run, of as many individuals as there are places.
    ///
    /// # Errors
    /// [`Error::Argument`] for more than there is room for in `held`, [`Error::Forgotten`].
    pub fn read_scores(held: Option<&Self>, scores: &mut [f32]) -> Result<()> {
        match held.filter(|g| g.scores.size() >= size_of_val(scores) as u64) {
            Some(generation) => generation.scores.read(scores),
            None => Err(Error::Argument(format!("no room was made for {} scores", scores.len()))),
        }
    }

    /// Terms and statistics of the first `count` individuals of the generation that has run.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_details(&self, context: &Arc<Context>, count: usize) -> Result<Vec<Detail>> {
        staging::read_buffer(context, &self.details, count)
    }
}

/// Bytes of the partial histograms, moments and gradients of one picture.
pub fn part_bytes(measure: &dyn Measure) -> [u64; 3] {
    let [histograms, others] = measure.entries().map(u64::from);
    [
        histograms * HISTOGRAM_BINS as u64 * u64::from(measure.bin_bits() / 8),
        others * size_of::<MomentPart>() as u64,
        others * size_of::<GradientPart>() as u64,
    ]
}

/// Pictures that can be measured at once: what the pipeline, the buffers of the partial results and
/// the work groups of `fitness` allow.
///
/// # Errors
/// [`Error::Argument`] when the device cannot hold as many as are measured together.
fn chunk(context: &Context, size: [u32; 2], measure: &dyn Measure) -> Result<u32> {
    let limits = context.limits();
    let parts = part_bytes(measure).into_iter().max().unwrap_or(0).max(1);
    let fits = [
        measure.largest_chunk()?.into(),
        limits.max_compute_work_group_count[0].into(),
        u64::from(limits.max_storage_buffer_range) / parts,
    ];
    let largest = fits.into_iter().min().unwrap_or(0) as u32;
    match largest - largest % measure.block() {
        0 => Err(Error::Argument(format!(
            "picture size {}x{} is more than the device's buffers can hold",
            size[0], size[1]
        ))),
        whole => Ok(whole),
    }
}
