//! The Vulkan evaluator.

use super::Context;
use super::choice::{ComputeShape, PipelineKind};
use super::commands::Commands;
use super::drawable::Drawable;
use super::drawn::{self, Drawn};
use super::forward::ForwardDraw;
use super::generation::{Fitness, GenerationMemory, Measure};
use super::layered::Layered;
use super::layout::Detail;
use super::population::StoredDraw;
use super::runs::Runs;
use super::staging;
use super::tiles::Tiles;
use super::view::ViewMemory;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::shading::Shading;
use crate::lighting::{Light, Population};
use crate::objective::maps::Maps;
use crate::objective::{Objective, Quality, Statistics};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use std::sync::Arc;

/// Measures populations on a Vulkan device: N chromosomes go up, N numbers come back.
///
/// The first generation makes the memory and the pipelines that it needs; a later one makes none,
/// unless it has more individuals or lights than any before, or another number of lights a rig.
pub struct GpuEvaluator {
    generation: Option<GenerationMemory>,
    recorded: Option<(u32, usize)>,
    commands: Commands,
    fitness: Fitness,
    measure: Box<dyn Measure + Send>,
    pipeline: PipelineKind,
    objects: u32,
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
        context.check_needs(context.needs().scene, "drawing scenes")?;
        let (view, drawn, drawable) = drawn::draw(context, scene, view, &objective, &shading)?;
        let objects = drawn.objects(&view)?;
        Self::of(context, view, objects, Some((drawn, drawable)), None)
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
        Self::of(context, view, maps.counts.object(), None, Some(maps.clone()))
    }

    fn of(
        context: &Arc<Context>,
        view: ViewMemory,
        objects: u32,
        scene: Option<(Drawn, Drawable)>,
        maps: Option<Maps>,
    ) -> Result<Self> {
        let (drawn, drawable) = scene.unzip();
        let pipeline = context.pipeline().unwrap_or_else(|| best(context, objects));
        let layers = pipeline != PipelineKind::Compute;
        context.check_needs(!layers || context.needs().layers, "pictures drawn in layers")?;
        let measure: Box<dyn Measure + Send> = match pipeline {
            PipelineKind::Layered => {
                let draw = Box::new(StoredDraw::new(context)?);
                Box::new(Layered::new(context, &view, draw)?)
            }
            PipelineKind::Forward => {
                let scene = drawable.ok_or_else(|| {
                    Error::Argument("pipeline forward draws a scene, not maps".into())
                })?;
                let draw = Box::new(ForwardDraw::new(context, scene)?);
                Box::new(Layered::new(context, &view, draw)?)
            }
            PipelineKind::Compute => match context.shape() {
                ComputeShape::Runs => Box::new(Runs::new(context, &view, objects)?),
                ComputeShape::Tiles => Box::new(Tiles::new(context, &view)?),
            },
        };
        Ok(Self {
            generation: None,
            recorded: None,
            commands: Commands::new(context)?,
            fitness: Fitness::new(context, &view, &*measure)?,
            measure,
            pipeline,
            objects,
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

    /// How the pictures are made.
    pub fn pipeline(&self) -> PipelineKind {
        self.pipeline
    }

    /// Object pixels of the view.
    pub fn objects(&self) -> u32 {
        self.objects
    }

    /// The device and what was made and read on it.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// GPU milliseconds of each stage in the last evaluation; empty before the first, and where the
    /// device has no timestamps.
    pub fn timings(&self) -> &[(&'static str, f64)] {
        self.generation.as_ref().map_or(&[], |generation| generation.timer.rows())
    }

    /// Makes memory and pipelines for the population, unless they are there.
    fn prepare(&mut self, population: &Population) -> Result<u32> {
        let records = population.records().len();
        let individuals = u32::try_from(population.len())
            .map_err(|_| Error::Argument(format!("{} individuals", population.len())))?;
        self.measure.prepare(&self.view, population.lights())?;
        if !self.generation.as_ref().is_some_and(|g| g.holds(individuals, records)) {
            let (held, held_records) =
                self.generation.as_ref().map_or((0, 0), GenerationMemory::capacity);
            let capacity = (individuals.max(held), records.max(held_records));
            // The old memory goes first, so that the two need not fit together.
            self.recorded = None;
            self.generation = None;
            let (view, measure) = (&mut self.view, &mut *self.measure);
            self.generation = Some(GenerationMemory::new(&self.context, view, measure, capacity)?);
        }
        Ok(individuals)
    }

    /// Terms and statistics of the first individuals of the last generation.
    fn read_details(&self, generation: &GenerationMemory, count: usize) -> Result<Vec<Detail>> {
        staging::read_buffer(&self.context, &generation.details, count)
    }
}

/// The fastest pipeline that can hold so many object pixels.
fn best(context: &Context, objects: u32) -> PipelineKind {
    match context.report().pipeline {
        PipelineKind::Compute
            if context.shape() == ComputeShape::Runs && !Runs::fits(context, objects) =>
        {
            PipelineKind::Layered
        }
        pipeline => pipeline,
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
                let stages = (&self.view, &*self.measure as &dyn Measure, &self.fitness);
                generation.record(cmd, &self.context, stages, plan);
                Ok(())
            })?;
            self.recorded = Some(plan);
        }
        generation.lights.write(population.records());
        self.commands.run()?;
        generation.scores.read(scores);
        generation.timer.read()
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
        let picture = self.measure.first_picture()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;

    #[test]
    fn a_view_with_too_many_object_pixels_is_drawn() {
        let context = testing::context();
        assert_eq!(best(&context, 1000), PipelineKind::Compute);
        assert!(!Runs::fits(&context, 1 << 31));
        let most = best(&context, 1 << 31);
        let runs = context.shape() == ComputeShape::Runs;
        assert_eq!(most == PipelineKind::Layered, runs);
        let (maps, view) = testing::maps(20, 10);
        let (objective, shading) = (Objective::default(), Shading::default());
        let view = ViewMemory::with_maps(&context, &maps, &view, &objective, &shading).unwrap();
        let error = Runs::new(&context, &view, 1 << 31).err();
        assert!(matches!(error, Some(Error::Unsupported { .. })));
        testing::assert_valid(&context);
    }
}
