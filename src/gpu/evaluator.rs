//! The Vulkan evaluator.

use super::Context;
use super::commands::{COPY_READ, COPY_WRITE, Commands, HOST_READ};
use super::drawn::{self, Drawn};
use super::generation::{GenerationMemory, Stages};
use super::layout::Detail;
use super::memory::{Access, Buffer};
use super::view::ViewMemory;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::shading::Shading;
use crate::lighting::{Light, Population};
use crate::objective::maps::Maps;
use crate::objective::{Objective, Quality, Statistics};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use ash::vk;
use bytemuck::Zeroable;
use std::sync::Arc;

/// Measures populations on a Vulkan device: N chromosomes go up, N numbers come back.
///
/// The first generation makes the memory and the pipelines that it needs; a later one makes none,
/// unless it has more individuals or lights than any before, or another number of lights a rig.
pub struct GpuEvaluator {
    generation: Option<GenerationMemory>,
    recorded: Option<(u32, usize)>,
    timings: Vec<(&'static str, f64)>,
    commands: Commands,
    stages: Stages,
    view: ViewMemory,
    drawn: Option<Drawn>,
    maps: Option<Maps>,
    context: Arc<Context>,
}

impl GpuEvaluator {
    /// An evaluator that draws the scene and makes the view's maps on the device.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture larger than the device can draw, [`Error::Unsupported`]
    /// when something of the scene is more than it can take, [`Error::Input`] for a scene with more
    /// vertices than Vulkan can address, and what the device reports.
    pub fn new(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        let (view, drawn) = drawn::draw(context, scene, view, &objective, &shading)?;
        Self::of(context, view, Some(drawn), None)
    }

    /// An evaluator for a view whose maps are known.
    ///
    /// # Errors
    /// [`Error::Argument`] when maps and view differ in size or the picture is too large for the
    /// device, and what the device reports.
    pub fn with_maps(
        context: &Arc<Context>,
        maps: &Maps,
        view: &View,
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        let view = ViewMemory::with_maps(context, maps, view, &objective, &shading)?;
        Self::of(context, view, None, Some(maps.clone()))
    }

    fn of(
        context: &Arc<Context>,
        view: ViewMemory,
        drawn: Option<Drawn>,
        maps: Option<Maps>,
    ) -> Result<Self> {
        Ok(Self {
            generation: None,
            recorded: None,
            timings: Vec::new(),
            commands: Commands::new(context)?,
            stages: Stages::new(context, &view)?,
            view,
            drawn,
            maps,
            context: Arc::clone(context),
        })
    }

    /// GPU milliseconds of each stage that drew the view; empty for a view whose maps were known,
    /// and where the device has no timestamps.
    pub fn view_timings(&self) -> &[(&'static str, f64)] {
        self.drawn.as_ref().map_or(&[], |drawn| &drawn.timings)
    }

    /// The device and what was made and read on it.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// GPU milliseconds of each stage in the last evaluation; empty before the first, and where the
    /// device has no timestamps.
    pub fn timings(&self) -> &[(&'static str, f64)] {
        &self.timings
    }

    /// Makes memory and pipelines for the population, unless they are there.
    fn prepare(&mut self, population: &Population) -> Result<u32> {
        let records = population.records().len();
        let individuals = u32::try_from(population.len())
            .map_err(|_| Error::Argument(format!("{} individuals", population.len())))?;
        self.stages.prepare(&self.view, population.lights())?;
        if !self.generation.as_ref().is_some_and(|g| g.holds(individuals, records)) {
            let (held, held_records) =
                self.generation.as_ref().map_or((0, 0), GenerationMemory::capacity);
            let capacity = (individuals.max(held), records.max(held_records));
            // The old memory goes first, so that the two need not fit together.
            self.recorded = None;
            self.generation = None;
            self.generation =
                Some(GenerationMemory::new(&self.context, &mut self.view, &self.stages, capacity)?);
        }
        Ok(individuals)
    }

    /// Terms and statistics of the first individuals of the last generation.
    fn read_details(&self, generation: &GenerationMemory, count: usize) -> Result<Vec<Detail>> {
        let out = self.readback("details", count * size_of::<Detail>())?;
        Commands::once(&self.context, |cmd| {
            let region = [vk::BufferCopy::default().size(out.size())];
            // SAFETY: both buffers are alive and hold `count` details.
            unsafe {
                let (from, to) = (generation.details.raw(), out.raw());
                self.context.device().cmd_copy_buffer(cmd, from, to, &region);
            }
            self.context.barrier(cmd, COPY_WRITE, HOST_READ);
            Ok(())
        })?;
        let mut details = vec![Detail::zeroed(); count];
        out.read(&mut details);
        Ok(details)
    }

    /// The picture of individual 0 of the last generation.
    fn read_picture(&self, generation: &GenerationMemory) -> Result<Vec<f32>> {
        let [width, height] = self.view.size;
        let pixels = width as usize * height as usize;
        let out = self.readback("picture", 4 * pixels)?;
        Commands::once(&self.context, |cmd| {
            let image = &generation.pictures.image;
            // The draw leaves the pictures to shaders.
            let shader = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
            let copy = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            self.context.transition(cmd, image, (shader, copy), COPY_READ, COPY_READ);
            self.context.download(cmd, (image, copy, 0), &out);
            self.context.transition(cmd, image, (copy, shader), COPY_READ, COPY_READ);
            self.context.barrier(cmd, COPY_WRITE, HOST_READ);
            Ok(())
        })?;
        let mut picture = vec![0.0; pixels];
        out.read(&mut picture);
        // The device marks the background by a negative value.
        picture.iter_mut().for_each(|value: &mut f32| *value = value.max(0.0));
        Ok(picture)
    }

    fn readback(&self, name: &str, bytes: usize) -> Result<Buffer> {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        Buffer::new(&self.context, name, bytes as u64, usage, Access::Readback)
    }
}

impl Evaluator for GpuEvaluator {
    fn device(&self) -> &DeviceInfo {
        &self.context.report().info
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        if scores.len() != population.len() {
            return Err(Error::Argument(format!(
                "{} places for the scores of {} rigs",
                scores.len(),
                population.len()
            )));
        }
        if population.is_empty() {
            return Ok(());
        }
        let individuals = self.prepare(population)?;
        let generation = self.generation.as_mut().expect("made by `prepare`");
        let plan = (individuals, population.lights());
        if self.recorded != Some(plan) {
            self.recorded = None;
            self.commands.record(|cmd| {
                generation.record(cmd, &self.context, (&self.view, &self.stages), plan);
                Ok(())
            })?;
            self.recorded = Some(plan);
        }
        generation.lights.write(population.records());
        self.commands.run()?;
        generation.scores.read(scores);
        self.timings = generation.timer.read()?;
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        if population.is_empty() {
            return Ok(Vec::new());
        }
        let mut scores = vec![0.0; population.len()];
        self.evaluate(population, &mut scores)?;
        let generation = self.generation.as_ref().expect("made by `evaluate`");
        let details = self.read_details(generation, scores.len())?;
        let quality = |(score, detail): (f32, Detail)| Quality { score, terms: detail.terms() };
        Ok(scores.into_iter().zip(details).map(quality).collect())
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let mut score = [0.0];
        self.evaluate(&Population::of([rig])?, &mut score)?;
        let generation = self.generation.as_ref().expect("made by `evaluate`");
        let detail = self.read_details(generation, 1)?[0];
        let picture = self.read_picture(generation)?;
        Ok(Inspection {
            score: score[0],
            terms: detail.terms(),
            statistics: Statistics {
                edge_contrast: detail.picture_edge_contrast,
                mean: detail.picture_mean,
                variance: detail.picture_variance,
                gradient: detail.picture_gradient,
                histogram: detail.histogram,
            },
            picture,
        })
    }

    fn maps(&mut self) -> Result<&Maps> {
        if self.maps.is_none()
            && let Some(drawn) = &self.drawn
        {
            self.maps = Some(drawn.read(&self.view)?);
        }
        Ok(self.maps.as_ref().expect("maps are known or drawn"))
    }
}
