//! The Vulkan evaluator.

use super::Context;
use super::measure::forward::ForwardDraw;
use super::measure::generation::{Fitness, GenerationMemory, Measure, ScoreTarget};
use super::measure::layered::Layered;
use super::measure::population::StoredDraw;
use super::measure::runs::Runs;
use super::measure::tiles::Tiles;
use super::scene::drawable::Drawable;
use super::view::drawn::{self, Drawn};
use super::view::memory::ViewMemory;
use super::view::shadows::untraceable;
use super::vulkan::choice::{ComputeShape, PipelineKind};
use super::vulkan::commands::Commands;
use super::vulkan::pipeline::RigKind;
use crate::cpu;
use crate::lighting::shading::Shading;
use crate::lighting::{LightRecord, Population, check_number};
use crate::objective::Objective;
use crate::objective::maps::Maps;
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

mod evaluate;
pub mod plan;

/// Measures populations on a Vulkan device: N chromosomes go up, N numbers come back.
///
/// The first generation makes the memory and the pipelines that it needs; a later one makes none,
/// unless it has more individuals or lights than any before, or another number of lights a rig. The
/// pipelines are the context's: an evaluator that follows on the same context finds them made.
///
/// ```
/// use klieg::evaluate::Evaluator;
/// use klieg::gpu::{Context, ContextOptions, GpuEvaluator};
/// use klieg::lighting::presets::Preset;
/// use klieg::lighting::shading::Shading;
/// use klieg::lighting::Population;
/// use klieg::objective::Objective;
/// use klieg::scene::build::{MeshData, SceneBuilder};
/// use klieg::scene::view::{Camera, Projection, View};
/// use klieg::glam::{DMat4, DVec3};
///
/// let positions = [[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]];
/// let indices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
/// let mut builder = SceneBuilder::default();
/// let mesh = MeshData { positions: &positions, indices: Some(&indices), ..MeshData::default() };
/// let mesh = builder.add_mesh(&mesh)?;
/// builder.add_instance("tetrahedron", mesh, DMat4::IDENTITY)?;
/// let scene = builder.finish("example")?;
/// let lens = Projection::Perspective { yfov: 0.7 };
/// let camera = Camera::look_at(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, DVec3::Y, lens)?;
/// let view = View::new(&scene, camera, 64, 64)?;
///
/// let context = Context::new(&ContextOptions::default())?;
/// let (objective, shading) = (Objective::default(), Shading::default());
/// let mut klieg = GpuEvaluator::new(&context, &scene, &view, objective, shading)?;
/// let rigs = [Preset::Headlight.rig()];
/// let mut scores = [0.0];
/// klieg.evaluate(&Population::of(rigs.iter().map(Vec::as_slice))?, &mut scores)?;
/// assert!((0.0..1.0).contains(&scores[0]));
/// # Ok::<(), klieg::Error>(())
/// ```
pub struct GpuEvaluator {
    /// Before the memory that they use: what is dropped waits for their end.
    commands: Vec<Commands>,
    recorded: Option<(u32, RigKind)>,
    generation: Option<GenerationMemory>,
    fitness: Fitness,
    measure: Box<dyn Measure + Send>,
    pipeline: PipelineKind,
    objects: u32,
    view: ViewMemory,
    drawn: Option<Drawn>,
    maps: Option<Maps>,
    /// What an evaluator of the same view in colour is made of; none where an engine's commands make views.
    source: Option<Source>,
    /// That evaluator, made for the first lights that ask for it.
    in_color: Option<Box<Self>>,
    context: Arc<Context>,
}

/// Whether there are shadows, and what casts them where that is known.
type Casting<'a> = (&'a ShadowSettings, Option<Arc<Occluders>>);

/// A view, how it is shaded, and the scene where that itself is drawn.
struct Source {
    view: View,
    shading: Shading,
    scene: Option<Arc<Drawable>>,
}

impl GpuEvaluator {
    /// An evaluator that draws the scene and makes the view's maps on the device, or on the CPU where the device
    /// cannot draw scenes or was not imported for that. Lights cast no shadows.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture larger than the device can draw and as [`View::check`],
    /// [`Objective::check`] and [`Shading::check`],
    /// [`Error::Unsupported`] when something of the scene is more than the device can take,
    /// [`Error::Input`] for a scene with more vertices than Vulkan can address and as
    /// [`Scene::check`], and [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        Self::with_shadows(context, scene, view, (objective, shading), &ShadowSettings::default())
    }

    /// The same with shadows as the settings have them.
    ///
    /// # Errors
    /// As [`GpuEvaluator::new`]; [`Error::Argument`] as [`ShadowSettings::check`], and [`Error::Input`] as
    /// [`Occluders::new`](crate::scene::occluders::Occluders::new).
    pub fn with_shadows(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        settings: (Objective, Shading),
        shadows: &ShadowSettings,
    ) -> Result<Self> {
        Self::of_scene(context, scene, view, settings, ((shadows, None), None))
    }

    /// The same with occluders that are there already, in the light frame of `view`.
    ///
    /// # Errors
    /// As [`GpuEvaluator::with_shadows`].
    pub fn with_occluders(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        settings: (Objective, Shading),
        shadows: (&ShadowSettings, Option<Arc<Occluders>>),
    ) -> Result<Self> {
        Self::of_scene(context, scene, view, settings, (shadows, None))
    }

    /// The same, with the number of object pixels where the context is dry and draws none.
    fn of_scene(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        (objective, shading): (Objective, Shading),
        (shadows, known): (Casting<'_>, Option<u32>),
    ) -> Result<Self> {
        context.check_present()?;
        if !context.needs().scene {
            let maps = cpu::draw(scene, view, &objective, shadows)?;
            return Self::of_maps(context, maps, view, (objective, shading));
        }
        let (lights, settings) = (context.lights(), (&objective, &shading));
        let (memory, drawn, drawable) =
            drawn::draw(context, scene, view, settings, lights, Some(shadows))?;
        let objects = known.map_or_else(|| drawn.objects(&memory), Ok)?;
        let drawable = Arc::new(drawable);
        let measure = measure(context, &memory, objects, Views::Scene(&drawable))?;
        let scene = (measure.0 == PipelineKind::Forward).then_some(drawable);
        let source = Source { view: view.clone(), shading, scene };
        let maps = (Some(drawn), None);
        Ok(Self { source: Some(source), ..Self::of(context, memory, objects, measure, maps)? })
    }

    /// An evaluator for a view whose maps are known. Lights cast shadows where the maps have a table of them.
    ///
    /// # Errors
    /// [`Error::Argument`] when maps and view differ in size or the picture is too large for the
    /// device, and as [`Maps::check`], [`View::check`], [`Objective::check`] and [`Shading::check`]; and
    /// [device errors](crate::Error::is_device).
    pub fn with_maps(
        context: &Arc<Context>,
        maps: &Maps,
        view: &View,
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        context.check_present()?;
        Self::of_maps(context, maps.clone(), view, (objective, shading))
    }

    fn of_maps(
        context: &Arc<Context>,
        maps: Maps,
        view: &View,
        (objective, shading): (Objective, Shading),
    ) -> Result<Self> {
        let lights = context.lights();
        let memory = ViewMemory::with_maps(context, &maps, view, &objective, &shading, lights)?;
        let objects = maps.counts.object();
        let measure = measure(context, &memory, objects, Views::Known)?;
        let source = Source { view: view.clone(), shading, scene: None };
        let maps = (None, Some(maps));
        Ok(Self { source: Some(source), ..Self::of(context, memory, objects, measure, maps)? })
    }

    /// An evaluator for views whose maps an engine's commands make, all of the same size.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub(in crate::gpu) fn of_any_view(context: &Arc<Context>, view: ViewMemory) -> Result<Self> {
        let pixels = view.size[0] * view.size[1];
        let measure = measure(context, &view, pixels, Views::Any)?;
        let drawn = Drawn::by_engine(context);
        Self::of(context, view, pixels, measure, (Some(drawn), None))
    }

    fn of(
        context: &Arc<Context>,
        view: ViewMemory,
        objects: u32,
        (pipeline, measure): (PipelineKind, Box<dyn Measure + Send>),
        (drawn, maps): (Option<Drawn>, Option<Maps>),
    ) -> Result<Self> {
        Ok(Self {
            commands: Vec::new(),
            recorded: None,
            generation: None,
            fitness: Fitness::new(context, &view, &*measure)?,
            measure,
            pipeline,
            objects,
            view,
            drawn,
            maps,
            source: None,
            in_color: None,
            context: Arc::clone(context),
        })
    }

    /// The view's memory.
    pub(in crate::gpu) fn view(&self) -> &ViewMemory {
        &self.view
    }

    /// Records what the pipeline has to know of a view whose maps the commands before have made.
    pub(in crate::gpu) fn record_view(&mut self, cmd: vk::CommandBuffer) {
        self.maps = None;
        self.measure.record_view(cmd, &self.view);
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

    /// Makes memory and pipelines for populations of up to `individuals` rigs of `lights` lights, so
    /// that [`GpuEvaluator::record`] finds all that it needs. No recording of this evaluator may be in
    /// use.
    ///
    /// # Errors
    /// [`Error::Argument`] when that is more than the device's buffers can hold, and
    /// [device errors](crate::Error::is_device).
    pub fn reserve(&mut self, individuals: u32, lights: usize) -> Result<()> {
        check_number(lights)?;
        if self.view.shadows.is_traceable() {
            self.prepare(individuals, RigKind { lights, near: true })?;
        }
        self.prepare(individuals, RigKind { lights, near: false })
    }

    /// Records the evaluation of a population into an engine's command buffer, outside render passes:
    /// never submits, waits or makes anything.
    ///
    /// All of it is work of one submission, while [`evaluate`](crate::evaluate::Evaluator::evaluate) divides what would
    /// take a slow GPU more than a second: record large populations in parts.
    ///
    /// The lights are copied into the commands, so that the population may change at once and a recording
    /// may be made while the last one runs. What was recorded before, on the same queue, is waited for
    /// by a barrier first. The scores are at `target` when the commands have run; for
    /// [`ScoreTarget::Buffer`] as a write of `TRANSFER`, which the engine makes visible to its readers.
    /// Pipeline, sets and push constants that were bound are not any more.
    ///
    /// # Errors
    /// [`Error::Argument`] for a population that [`GpuEvaluator::reserve`] has made no room for, for an
    /// objective with terms that are not klieg's own, and for
    /// coloured lights and spots where neither the objective nor the BRDF nor
    /// [`Tuning::any_lights`](crate::gpu::Tuning::any_lights) asked for pictures in colour.
    ///
    /// # Safety
    /// `cmd` is being recorded on this device, for the family of the context's queue; its submissions
    /// run one after the other, none beside a call of this evaluator's that evaluates, reads or reserves;
    /// the evaluator outlives them. A buffer holds 4 bytes for each individual, a multiple of 4 bytes
    /// from its front on, and may be the target of copies.
    pub unsafe fn record(
        &mut self,
        cmd: vk::CommandBuffer,
        population: &Population,
        target: ScoreTarget,
    ) -> Result<()> {
        self.context.check_present()?;
        if population.is_empty() {
            return Ok(());
        }
        if !population.is_plain() && self.view.color.is_none() {
            return Err(no_color());
        }
        if !self.view.objective.is_own() {
            let fault = "an evaluation that is recorded knows klieg's own terms alone";
            return Err(Error::Argument(fault.into()));
        }
        let (individuals, rigs) = (population.len(), self.rig_kind(population));
        let records = population.records();
        let held = |g: &&mut GenerationMemory| {
            u32::try_from(individuals).is_ok_and(|i| g.holds(i, records.len()))
        };
        let generation =
            self.generation.as_mut().filter(held).filter(|_| self.measure.prepared(rigs));
        let generation = generation.ok_or_else(|| {
            let lights = rigs.lights;
            Error::Argument(format!("no room was made for {individuals} rigs of {lights} lights"))
        })?;
        let context = &self.context;
        context.follow_earlier(cmd);
        context.update(cmd, &generation.lights, records);
        let stages = (&self.view, &*self.measure as &dyn Measure, &self.fitness);
        generation.record(cmd, context, stages, (individuals as u32, rigs));
        // SAFETY: the caller's promises for the buffer.
        unsafe { generation.deliver(cmd, context, individuals as u32, target) };
        Ok(())
    }

    /// Reads the scores of the last recording with [`ScoreTarget::Mapped`], whose commands have run.
    ///
    /// # Errors
    /// [`Error::Argument`] for more scores than there is room for, and [`Error::Forgotten`].
    pub fn read_scores(&self, scores: &mut [f32]) -> Result<()> {
        GenerationMemory::read_scores(self.generation.as_ref(), scores)
    }

    /// What the pipelines are specialised to for a population.
    fn rig_kind(&self, population: &Population) -> RigKind {
        let shadows = self.view.shadows.side > 0;
        let near = shadows && population.records().iter().any(LightRecord::is_near);
        RigKind { lights: population.lights(), near }
    }

    /// Makes memory and pipelines, unless they are there, once nothing is under way.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for lights within a scene that is more than the device can trace rays in, and
    /// what makes memory and pipelines reports.
    fn prepare(&mut self, individuals: u32, rigs: RigKind) -> Result<()> {
        self.context.check_present()?;
        // What was begun and never ended may still use the memory.
        self.commands.iter_mut().try_for_each(Commands::finish)?;
        if rigs.near && !self.view.shadows.is_traceable() {
            return Err(untraceable(&self.context));
        }
        let records = individuals as usize * rigs.lights;
        self.measure.prepare(&self.view, rigs)?;
        let stages: (_, &mut dyn Measure) = (&mut self.view, &mut *self.measure);
        let (generation, wanted) = (&mut self.generation, (individuals, records));
        if GenerationMemory::grow(generation, &self.context, stages, wanted)? {
            self.recorded = None;
        }
        Ok(())
    }
}

/// Which views an evaluator will see.
enum Views<'a> {
    /// One of a scene, that is there.
    Scene(&'a Arc<Drawable>),
    /// One whose maps are there.
    Known,
    /// Any, made later.
    Any,
}

/// The pipeline for a view with at most `objects` object pixels.
fn measure(
    context: &Arc<Context>,
    view: &ViewMemory,
    objects: u32,
    views: Views<'_>,
) -> Result<(PipelineKind, Box<dyn Measure + Send>)> {
    let pipeline = context.pipeline().unwrap_or_else(|| best(context, objects));
    let layers = pipeline != PipelineKind::Compute;
    context.check_needs(!layers || context.needs().layers, "pictures drawn in layers")?;
    let measure: Box<dyn Measure + Send> = match (pipeline, views) {
        (PipelineKind::Layered, _) => {
            Box::new(Layered::new(context, view, StoredDraw::new(context, view)?)?)
        }
        (PipelineKind::Forward, Views::Scene(scene)) => Box::new(Layered::new(
            context,
            view,
            ForwardDraw::new(context, view, Arc::clone(scene))?,
        )?),
        (PipelineKind::Forward, _) => {
            return Err(Error::Argument("pipeline forward draws a scene, not maps".into()));
        }
        (PipelineKind::Compute, views) => match (context.shape(), views) {
            (ComputeShape::Runs, _) => Box::new(Runs::new(context, view, objects)?),
            (ComputeShape::Tiles, Views::Any) => Box::new(Tiles::of_any_view(context, view)?),
            (ComputeShape::Tiles, _) => Box::new(Tiles::new(context, view)?),
        },
    };
    Ok((pipeline, measure))
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

/// The error of an evaluator that cannot shade in colour.
fn no_color() -> Error {
    let fault = "this evaluator was made for white lights without cones";
    Error::Argument(format!("{fault}: make it on a context with Tuning::any_lights"))
}

#[cfg(test)]
mod tests;
