//! A generation on the device: `population`, the reductions `histogram`, `moments` and `gradient`,
//! and `fitness`. A population larger than what one draw can hold goes in chunks.

use super::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ, HOST_READ, StageTimer};
use super::layout::{Detail, GradientPart, MomentPart, binding};
use super::memory::{Access, Buffer};
use super::pipeline::Pipeline;
use super::population::{self, Draw, Pictures};
use super::view::ViewMemory;
use super::{Context, shaders};
use crate::lighting::LightRecord;
use crate::objective::HISTOGRAM_BINS;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of the reductions, along a row.
const COLUMNS: u32 = 64;
/// Rows of a strip of `histogram`; at most 255, as it counts in bytes.
const HISTOGRAM_ROWS: u32 = 128;
/// Rows of a strip of `moments` and `gradient`.
const ROWS: u32 = 32;
/// Invocations of a work group of `fitness`.
const FITNESS_GROUP: u32 = 128;
/// Stages of a chunk.
const STAGES: u32 = 5;

/// The pipelines of a generation.
pub struct Stages {
    draw: Draw,
    histogram: Pipeline,
    moments: Pipeline,
    gradient: Pipeline,
    fitness: Pipeline,
}

impl Stages {
    /// # Errors
    /// What the device reports.
    pub fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        let bins = HISTOGRAM_BINS as u32;
        let compute = |stem, spirv, constants: &[u32]| {
            Pipeline::compute(context, stem, spirv, &view.layout, constants)
        };
        let fitness = [FITNESS_GROUP, HISTOGRAM_ROWS, ROWS, bins];
        Ok(Self {
            draw: Draw::new(context)?,
            histogram: compute(
                "histogram",
                shaders::HISTOGRAM_COMP,
                &[COLUMNS, HISTOGRAM_ROWS, bins],
            )?,
            moments: compute("moments", shaders::MOMENTS_COMP, &[COLUMNS, ROWS])?,
            gradient: compute("gradient", shaders::GRADIENT_COMP, &[COLUMNS, ROWS])?,
            fitness: compute("fitness", shaders::FITNESS_COMP, &fitness)?,
        })
    }

    /// Makes what rigs of `lights` lights need, unless it is there.
    ///
    /// # Errors
    /// What the device reports.
    pub fn prepare(&mut self, view: &ViewMemory, lights: usize) -> Result<()> {
        self.draw.prepare(view, lights)
    }
}

/// The device memory of a generation; it only ever grows.
pub struct GenerationMemory {
    /// Pictures of the last chunk.
    pub pictures: Pictures,
    /// The lights of all individuals; the host writes.
    pub lights: Buffer,
    /// `F` of all individuals; the host reads.
    pub scores: Buffer,
    /// [`Detail`] of all individuals.
    pub details: Buffer,
    /// Times of the last run.
    pub timer: StageTimer,
    /// Individuals that fit in a draw.
    chunk: u32,
    individuals: u32,
    records: usize,
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
        stages: &Stages,
        (individuals, records): (u32, usize),
    ) -> Result<Self> {
        let size = view.size;
        let chunk = individuals.min(largest_chunk(context, size)?);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let device = |name, bytes| Buffer::new(context, name, bytes, storage, Access::Device);
        let [histogram, moments, gradient] = part_bytes(size).map(|b| b * u64::from(chunk));
        let parts = [
            device("histogram parts", histogram)?,
            device("moment parts", moments)?,
            device("gradient parts", gradient)?,
        ];
        let lights = (records * size_of::<LightRecord>()) as u64;
        let details = u64::from(individuals) * size_of::<Detail>() as u64;
        let largest = u64::from(context.limits().max_storage_buffer_range);
        if lights.max(details) > largest {
            return Err(Error::Argument(format!(
                "{individuals} individuals are more than the device's buffers can hold"
            )));
        }
        let details_usage = storage | vk::BufferUsageFlags::TRANSFER_SRC;
        let scores = u64::from(individuals) * 4;
        let memory = Self {
            pictures: stages.draw.pictures(size, chunk)?,
            lights: Buffer::new(context, "lights", lights, storage, Access::Upload)?,
            scores: Buffer::new(context, "scores", scores, storage, Access::Readback)?,
            details: Buffer::new(context, "details", details, details_usage, Access::Device)?,
            timer: StageTimer::new(context, STAGES * individuals.div_ceil(chunk))?,
            chunk,
            individuals,
            records,
            _parts: parts,
        };
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        view.set.write_image(binding::PICTURES, &memory.pictures.image, layout);
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

    /// Whether it holds so many individuals and lights.
    pub fn holds(&self, individuals: u32, records: usize) -> bool {
        individuals <= self.individuals && records <= self.records
    }

    /// What a larger memory should hold so that it need not grow back and forth.
    pub fn capacity(&self) -> (u32, usize) {
        (self.individuals, self.records)
    }

    /// Records a generation of `individuals` rigs of `lights` lights.
    pub fn record(
        &mut self,
        cmd: vk::CommandBuffer,
        context: &Context,
        (view, stages): (&ViewMemory, &Stages),
        (individuals, lights): (u32, usize),
    ) {
        self.timer.reset(cmd);
        for first in (0..individuals).step_by(self.chunk as usize) {
            let count = self.chunk.min(individuals - first);
            let pictures = &self.pictures;
            self.timer.stage(cmd, "population", || {
                stages.draw.record(cmd, (view, pictures), lights, (first, count));
            });
            let groups =
                |rows| [view.size[0].div_ceil(COLUMNS), view.size[1].div_ceil(rows), count];
            for (stem, pipeline, groups) in [
                ("histogram", &stages.histogram, groups(HISTOGRAM_ROWS)),
                ("moments", &stages.moments, groups(ROWS)),
                ("gradient", &stages.gradient, groups(ROWS)),
            ] {
                self.timer.stage(cmd, stem, || view.dispatch(cmd, pipeline, groups, first));
            }
            context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
            self.timer.stage(cmd, "fitness", || {
                view.dispatch(cmd, &stages.fitness, [count, 1, 1], first);
            });
            // The next chunk's reductions write where `fitness` has read.
            context.barrier(cmd, COMPUTE_READ, COMPUTE_WRITE);
        }
        context.barrier(cmd, COMPUTE_WRITE, (HOST_READ.0 | COPY_READ.0, HOST_READ.1 | COPY_READ.1));
    }
}

/// Bytes of the partial histograms, moments and gradients of one picture.
fn part_bytes([width, height]: [u32; 2]) -> [u64; 3] {
    let entries = |rows| u64::from(width) * u64::from(height.div_ceil(rows));
    [
        entries(HISTOGRAM_ROWS) * HISTOGRAM_BINS as u64,
        entries(ROWS) * size_of::<MomentPart>() as u64,
        entries(ROWS) * size_of::<GradientPart>() as u64,
    ]
}

/// Pictures that one draw can make: what layers, image size, buffer sizes and memory allow.
///
/// # Errors
/// [`Error::Argument`] when a single picture is more than the device can hold.
fn largest_chunk(context: &Context, size: [u32; 2]) -> Result<u32> {
    let image = context.image_limits(population::FORMAT, population::USAGE)?;
    let limits = context.limits();
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    let memory = context.picture_memory().min(image.max_resource_size);
    let parts = part_bytes(size).into_iter().max().unwrap_or(1);
    let fits = [
        u64::from(context.report().max_layers),
        image.max_array_layers.into(),
        limits.max_compute_work_group_count[2].into(),
        limits.max_compute_work_group_count[0].into(),
        u64::from(limits.max_storage_buffer_range) / parts,
        (memory / (4 * pixels)).max(1),
    ];
    let largest = fits.into_iter().min().unwrap_or(0) as u32;
    if largest == 0 {
        return Err(Error::Argument(format!(
            "picture size {}x{} is more than the device's buffers can hold",
            size[0], size[1]
        )));
    }
    Ok(largest)
}
