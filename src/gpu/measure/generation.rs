//! A generation on the device: a pipeline measures the pictures of a chunk of the population, `fitness`
//! makes the scores. A population larger than what the pipeline can hold at once goes in chunks.

use super::runs::LIGHT_MARGIN;
use crate::constants::{FITNESS_GROUP, HISTOGRAM_BINS};
use crate::gpu::Context;
use crate::gpu::layout::{AppearancePart, Chunk, Detail, GradientPart, MomentPart, binding};
use crate::gpu::shaders;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ, Commands, HOST_READ};
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::{Pipeline, RigKind};
use crate::gpu::vulkan::staging;
use crate::gpu::vulkan::timer::StageTimer;
use crate::lighting::{LightRecord, MAX_LIGHTS};
use crate::objective::Needs;
use crate::{Error, Result};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

/// Stages of a chunk, at most.
const STAGES: u32 = 6;
/// Most work of one submission: pixels of all pictures, times the lights of a rig. Slow GPUs take about a
/// second for it; drivers take a submission of several for a hang, and reset the device.
const SUBMISSION_WORK: u64 = 1 << 30;

/// Bits of a bin of a partial histogram by curvature.
const CURVATURE_BITS: u32 = 16;

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
    /// [Device errors](crate::Error::is_device).
    fn largest_chunk(&self, view: &ViewMemory) -> Result<u32>;

    /// Makes what such rigs need, unless it is there.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn prepare(&mut self, view: &ViewMemory, rigs: RigKind) -> Result<()>;

    /// Whether that is there.
    fn prepared(&self, rigs: RigKind) -> bool;

    /// Makes room for `chunk` pictures; the lights will be in `lights`.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn allocate(&mut self, view: &mut ViewMemory, chunk: u32, lights: &Buffer) -> Result<()>;

    /// Records what has to be known of a view whose maps the commands before have made, visible to
    /// compute shaders; what it leaves is too.
    fn record_view(&self, cmd: vk::CommandBuffer, view: &ViewMemory);

    /// Records the stages that leave the partial results of a chunk of `count` rigs.
    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        timer: &mut StageTimer,
        chunk: (&Chunk, u32),
        rigs: RigKind,
    );

    /// The first picture of the last chunk: `I`, 0 in the background, rows from the top.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn first_picture(&self, view: &ViewMemory) -> Result<Vec<f32>>;
}

/// The stage `fitness`.
pub struct Fitness(Pipeline);

impl Fitness {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory, measure: &dyn Measure) -> Result<Self> {
        let needs = view.objective.needs();
        let parts = [needs.sums(), needs.curvature].map(u32::from);
        let constants = [FITNESS_GROUP, HISTOGRAM_BINS, measure.bin_bits(), parts[0], parts[1]];
        let spirv = shaders::FITNESS_COMP;
        Pipeline::compute(context, "fitness", spirv, &view.layout, &constants).map(Self)
    }
}

/// What a generation's stages are recorded from.
pub type Stages<'a> = (&'a ViewMemory, &'a dyn Measure, &'a Fitness);

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
    /// Pixels of a picture.
    pixels: u64,
    /// Individuals that are measured together.
    block: u32,
    /// Most work of one submission: [`SUBMISSION_WORK`], or less in tests.
    pub submission_work: u64,
    _parts: [Buffer; 4],
}

impl GenerationMemory {
    /// Memory for `individuals` and `records` lights in all, put into the view's set.
    ///
    /// # Errors
    /// [`Error::Argument`] when these or the picture are more than the device's buffers can hold,
    /// and [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        view: &mut ViewMemory,
        measure: &mut dyn Measure,
        (individuals, records): (u32, usize),
    ) -> Result<Self> {
        let entries = measure.entries();
        let [lights, details] = light_and_detail_bytes(context, individuals, records)?;
        let (largest, block) = (chunk(context, view, measure)?, measure.block());
        let chunk = individuals.checked_next_multiple_of(block).map_or(largest, |n| n.min(largest));
        let pixels = view.size.map(u64::from).iter().product();
        let least = submission_size(SUBMISSION_WORK, pixels, MAX_LIGHTS, block);
        let most_chunks = individuals.div_ceil(chunk) + individuals.div_ceil(least);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let device = |name, bytes| Buffer::new(context, name, bytes, storage, Access::Device);
        let bytes = part_bytes(view, measure).map(|b| b * u64::from(chunk));
        let [histogram, moments, gradient, appearance] = bytes;
        let parts = [
            device("histogram parts", histogram)?,
            device("moment parts", moments)?,
            device("gradient parts", gradient)?,
            device("appearance parts", appearance.max(size_of::<AppearancePart>() as u64))?,
        ];
        let lights_usage =
            storage | vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let details_usage = storage | vk::BufferUsageFlags::TRANSFER_SRC;
        let scores = u64::from(individuals) * 4;
        let memory = Self {
            lights: Buffer::new(context, "lights", lights, lights_usage, Access::Upload)?,
            scores: Buffer::new(context, "scores", scores, details_usage, Access::Readback)?,
            details: Buffer::new(context, "details", details, details_usage, Access::Device)?,
            timer: StageTimer::new(context, STAGES * most_chunks)?,
            untimed: StageTimer::new(context, 0)?,
            chunk,
            individuals,
            records,
            entries,
            pixels,
            block,
            submission_work: SUBMISSION_WORK,
            _parts: parts,
        };
        measure.allocate(view, chunk, &memory.lights)?;
        let [histogram, moments, gradient, appearance] = &memory._parts;
        for (number, buffer) in [
            (binding::LIGHTS, &memory.lights),
            (binding::HISTOGRAM, histogram),
            (binding::MOMENTS, moments),
            (binding::GRADIENT, gradient),
            (binding::APPEARANCE, appearance),
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

    /// Individuals that are measured at once.
    pub fn at_once(&self) -> u32 {
        self.chunk.min(self.individuals)
    }

    /// Whether it holds so many individuals and lights.
    pub fn holds(&self, individuals: u32, records: usize) -> bool {
        individuals <= self.individuals && records <= self.records
    }

    /// Records a generation of `individuals` rigs into an engine's commands.
    pub fn record(
        &mut self,
        cmd: vk::CommandBuffer,
        context: &Context,
        stages: Stages<'_>,
        (individuals, rigs): (u32, RigKind),
    ) {
        self.record_part(cmd, context, stages, (0..individuals, rigs), false);
    }

    /// Records a generation of `individuals` rigs into klieg's own commands, with its
    /// times: into one for each submission, which are then to be run in order.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn record_submissions(
        &mut self,
        commands: &mut Vec<Commands>,
        context: &Arc<Context>,
        stages: Stages<'_>,
        (individuals, rigs): (u32, RigKind),
    ) -> Result<()> {
        let parts = self.submissions(individuals, rigs.lights);
        commands.truncate(parts.len());
        for (i, part) in parts.into_iter().enumerate() {
            if commands.len() == i {
                commands.push(Commands::new(context)?);
            }
            commands[i].record(|cmd| {
                if part.start == 0 {
                    self.timer.reset(cmd);
                }
                self.record_part(cmd, context, stages, (part, rigs), true);
                Ok(())
            })?;
        }
        Ok(())
    }

    /// The individuals of each submission.
    fn submissions(&self, individuals: u32, lights: usize) -> Vec<Range<u32>> {
        let step = submission_size(self.submission_work, self.pixels, lights, self.block);
        let part = |first: u32| first..first.saturating_add(step).min(individuals);
        (0..individuals).step_by(step as usize).map(part).collect()
    }

    /// Records some individuals, chunk by chunk.
    fn record_part(
        &mut self,
        cmd: vk::CommandBuffer,
        context: &Context,
        (view, measure, fitness): Stages<'_>,
        (part, rigs): (Range<u32>, RigKind),
        timed: bool,
    ) {
        let timer = if timed { &mut self.timer } else { &mut self.untimed };
        let [histogram_entries, entries] = self.entries;
        for first in part.clone().step_by(self.chunk as usize) {
            if first > part.start {
                // The last chunk's `fitness` has read what this one's stages write.
                context.barrier(cmd, COMPUTE_READ, COMPUTE_WRITE);
            }
            let count = self.chunk.min(part.end - first);
            let chunk = Chunk {
                first,
                histogram_entries,
                entries,
                lights: rigs.lights as u32,
                ..Chunk::default()
            };
            measure.record(cmd, view, timer, (&chunk, count), rigs);
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
    /// [Device errors](crate::Error::is_device).
    pub fn read_details(&self, context: &Arc<Context>, count: usize) -> Result<Vec<Detail>> {
        staging::read_buffer(context, &self.details, count)
    }
}

/// Individuals of a submission: whole blocks that make no more than `most_work`, or one.
fn submission_size(most_work: u64, pixels: u64, lights: usize, block: u32) -> u32 {
    let each = pixels * lights.max(1) as u64;
    let most = u32::try_from(most_work / each).unwrap_or(u32::MAX);
    (most - most % block).max(block)
}

/// Bytes of all lights and of all details.
///
/// # Errors
/// [`Error::Argument`] when that is more than the device's buffers can hold.
fn light_and_detail_bytes(context: &Context, individuals: u32, records: usize) -> Result<[u64; 2]> {
    let lights = (records * size_of::<LightRecord>()) as u64 + LIGHT_MARGIN;
    let details = u64::from(individuals) * size_of::<Detail>() as u64;
    if lights.max(details) > context.limits().max_storage_buffer_range.into() {
        let fault = "individuals are more than the device's buffers can hold";
        return Err(Error::Argument(format!("{individuals} {fault}")));
    }
    Ok([lights, details])
}

/// The specialisation constants that tell shaders what is measured besides the brightness and its
/// gradients: what the lights do, detail, a target, the outline before a background, and the histogram by curvature.
pub fn measured(needs: Needs) -> [u32; 5] {
    [needs.lights(), needs.detail, needs.target, needs.background, needs.curvature].map(u32::from)
}

/// Bytes of the partial histograms, moments, gradients and, where the objective needs any, appearances of
/// one picture.
pub fn part_bytes(view: &ViewMemory, measure: &dyn Measure) -> [u64; 4] {
    let [histograms, others] = measure.entries().map(u64::from);
    let needs = view.objective.needs();
    let bin_bits = measure.bin_bits() + if needs.curvature { CURVATURE_BITS } else { 0 };
    [
        histograms * HISTOGRAM_BINS as u64 * u64::from(bin_bits / 8),
        others * size_of::<MomentPart>() as u64,
        others * size_of::<GradientPart>() as u64,
        if needs.sums() { others * size_of::<AppearancePart>() as u64 } else { 0 },
    ]
}

/// Pictures that can be measured at once: what the pipeline, the buffers of the partial results and
/// the work groups of `fitness` allow.
///
/// # Errors
/// [`Error::Argument`] when the device cannot hold as many as are measured together.
fn chunk(context: &Context, view: &ViewMemory, measure: &dyn Measure) -> Result<u32> {
    let limits = context.limits();
    let parts = part_bytes(view, measure).into_iter().max().unwrap_or(0).max(1);
    let fits = [
        measure.largest_chunk(view)?.into(),
        limits.max_compute_work_group_count[0].into(),
        u64::from(limits.max_storage_buffer_range) / parts,
    ];
    let largest = fits.into_iter().min().unwrap_or(0) as u32;
    match largest - largest % measure.block() {
        0 => Err(Error::Argument(format!(
            "picture size {}x{} is more than the device's buffers can hold",
            view.size[0], view.size[1]
        ))),
        whole => Ok(whole),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submissions_are_bounded_in_whole_blocks() {
        let size = |pixels, lights, block| submission_size(SUBMISSION_WORK, pixels, lights, block);
        // 30 rigs of 16 lights at 1920x1080, and of 2 at 3840x2160, go at once.
        assert!(size(1920 * 1080, 16, 4) >= 30);
        assert!(size(3840 * 2160, 2, 4) >= 30);
        assert_eq!(size(1 << 20, 2, 4), 512);
        assert_eq!(size((1 << 20) + 1, 2, 4), 508);
        assert_eq!(size(1 << 20, 0, 1), 1024, "pictures that come without lights");
        assert_eq!(size(1 << 26, 16, 4), 4, "a block is never divided");
        assert_eq!(size(1, 1, 4), 1 << 30);
        assert_eq!(submission_size(u64::MAX, 1, 1, 4), u32::MAX - 3);
    }
}
