//! Measures pictures that an engine renders itself, with lights and shadows of its own.

use super::pictures::{ImportedPictures, Pictures};
use super::surface::{EngineImage, ImportedSurface, SurfaceImages, SurfaceStages};
use crate::evaluate::Inspection;
use crate::gpu::Context;
use crate::gpu::layout::Detail;
use crate::gpu::measure::generation::{Fitness, GenerationMemory, Measure, ScoreTarget};
use crate::gpu::measure::layered::Layered;
use crate::gpu::view::drawn::Drawn;
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::Commands;
use crate::gpu::vulkan::pipeline::RigKind;
use crate::lighting::shading::Shading;
use crate::objective::maps::Maps;
use crate::objective::{Objective, Quality};
use crate::scene::engine::{EngineCamera, PictureFormat, SurfaceFormat};
use crate::scene::view::View;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Pictures come without their lights.
const WITHOUT_LIGHTS: RigKind = RigKind { lights: 0, near: false };

/// Measures pictures that an engine renders itself: a layered image goes in, a score for each layer
/// comes out.
///
/// The engine draws its surface once for a view, [`PictureEvaluator::record_view`] makes the maps of
/// it; then it renders the same view under lights of its choice, a layer for each choice, and
/// [`PictureEvaluator::record`] measures the layers. Before the first view the picture is empty.
///
/// ```no_run
/// use ash::vk;
/// use klieg::gpu::{
///     Context, EngineImage, ImportedSurface, PictureEvaluator, ScoreTarget, SurfaceImages,
/// };
/// use klieg::objective::Objective;
/// use klieg::scene::engine::{EngineCamera, PictureFormat, SurfaceFormat};
/// # use std::sync::Arc;
///
/// # unsafe fn frame(context: &Arc<Context>, images: SurfaceImages, array: vk::ImageView,
/// #     camera: EngineCamera, cmd: vk::CommandBuffer, buffer: vk::Buffer,
/// # ) -> klieg::Result<()> { unsafe {
/// let mut klieg = PictureEvaluator::new(context, [640, 360], Objective::default())?;
/// klieg.reserve(30)?;
/// let surface: ImportedSurface = klieg.import_surface(&images, &SurfaceFormat::default())?;
/// let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
/// let array = EngineImage { view: array, layout };
/// let pictures = klieg.import_pictures(array, 30, PictureFormat::default())?;
///
/// // Each frame: the view, the engine's 30 layers, and their scores.
/// klieg.record_view(cmd, &surface, &camera)?;
/// // … the engine renders …
/// klieg.record(cmd, &pictures, 0, 30, ScoreTarget::Buffer { buffer, offset: 0 })?;
/// # Ok(()) } }
/// ```
pub struct PictureEvaluator {
    generation: Option<GenerationMemory>,
    commands: Vec<Commands>,
    fitness: Fitness,
    measure: Layered<Pictures>,
    stages: SurfaceStages,
    memory: ViewMemory,
    view: Option<View>,
    maps: Option<Maps>,
    context: Arc<Context>,
}

impl PictureEvaluator {
    /// For pictures of `size` (width and height, pixels).
    ///
    /// # Errors
    /// [`Error::Argument`] for settings out of their range and a picture larger than the device can
    /// take, and [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, size: [u32; 2], objective: Objective) -> Result<Self> {
        if objective.needs().irradiance {
            let fault = "an engine's pictures do not tell the irradiance: the terms unlit and relief cannot be";
            return Err(Error::Argument(format!("{fault} measured in them")));
        }
        // The engine's shading is its own.
        let shading = Shading::default();
        let (stages, memory) =
            SurfaceStages::new(context, size, (&objective, &shading), Lights::Plain, None)?;
        let measure = Layered::new(context, &memory, Pictures::new(context, &memory)?)?;
        Ok(Self {
            generation: None,
            commands: Vec::new(),
            fitness: Fitness::new(context, &memory, &measure)?,
            measure,
            stages,
            memory,
            view: None,
            maps: None,
            context: Arc::clone(context),
        })
    }

    /// Takes the images of an engine's surface in: once for each set of images that the engine draws
    /// into. Only depth, normals and ids count, as the engine shades the surface itself.
    ///
    /// # Errors
    /// [`Error::Argument`] for a format out of its range, and
    /// [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// The views are of this device and of the evaluator's size, and alive as long as what is recorded
    /// with the result runs.
    pub unsafe fn import_surface(
        &self,
        images: &SurfaceImages,
        format: &SurfaceFormat,
    ) -> Result<ImportedSurface> {
        // SAFETY: the caller's promise.
        unsafe { self.stages.import(&self.memory, images, format) }
    }

    /// Takes an engine's pictures in: once for each layered image that the engine renders into. klieg
    /// reads them by texel fetch, so that any float, normalised or sRGB format will do.
    ///
    /// # Errors
    /// [`Error::Argument`] for pictures without layers, and
    /// [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// The view is a two-dimensional array of `layers` layers of the evaluator's size, on this device, and
    /// alive as long as the result is used. Whenever commands of this evaluator read the layers, they
    /// are in the stated layout and visible to `SHADER_READ` in `COMPUTE_SHADER`. They are left as
    /// they are, and may be written again after a barrier from `COMPUTE_SHADER`; nothing else of
    /// klieg's touches them.
    pub unsafe fn import_pictures(
        &self,
        pictures: EngineImage,
        layers: u32,
        format: PictureFormat,
    ) -> Result<ImportedPictures> {
        // SAFETY: the caller's promise.
        unsafe { self.measure.stage.import(pictures, layers, format) }
    }

    /// Makes memory for up to `individuals` pictures, so that [`PictureEvaluator::record`] finds all that
    /// it needs. No recording of this evaluator may be in use.
    ///
    /// # Errors
    /// [`Error::Argument`] when that is more than the device's buffers can hold, and
    /// [device errors](crate::Error::is_device).
    pub fn reserve(&mut self, individuals: u32) -> Result<()> {
        self.context.check_present()?;
        let stages: (_, &mut dyn Measure) = (&mut self.memory, &mut self.measure);
        let wanted = (individuals, 0);
        GenerationMemory::grow(&mut self.generation, &self.context, stages, wanted).map(drop)
    }

    /// Records the making of the maps of what the engine has drawn, as
    /// [`SurfaceEvaluator::record_view`](crate::gpu::SurfaceEvaluator::record_view). Pictures that are
    /// recorded or evaluated later, until the next view, are of this view.
    ///
    /// # Errors
    /// As [`EngineCamera::view`].
    ///
    /// # Safety
    /// As [`SurfaceEvaluator::record_view`](crate::gpu::SurfaceEvaluator::record_view).
    pub unsafe fn record_view(
        &mut self,
        cmd: vk::CommandBuffer,
        surface: &ImportedSurface,
        camera: &EngineCamera,
    ) -> Result<()> {
        self.view = Some(self.stages.record(cmd, &self.memory, surface, camera)?);
        self.maps = None;
        Ok(())
    }

    /// As [`PictureEvaluator::record_view`], submitted and waited for at once.
    ///
    /// # Errors
    /// As [`PictureEvaluator::record_view`], and [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// No recording of this evaluator runs; the images as for [`PictureEvaluator::record_view`].
    pub unsafe fn look(&mut self, surface: &ImportedSurface, camera: &EngineCamera) -> Result<()> {
        let context = Arc::clone(&self.context);
        // SAFETY: the caller's promise; the commands run and end here.
        Commands::once(&context, |cmd| unsafe { self.record_view(cmd, surface, camera) })
    }

    /// Records the evaluation of `count` layers from `first_layer` on into an engine's command buffer,
    /// outside render passes: never submits, waits or makes anything.
    ///
    /// What was recorded before, on the same queue, is waited for by a barrier first. The scores are at
    /// `target` when the commands have run; for [`ScoreTarget::Buffer`] as a write of `TRANSFER`,
    /// which the engine makes visible to its readers. Pipeline, sets and push constants that were
    /// bound are not any more.
    ///
    /// # Errors
    /// [`Error::Argument`] for layers that the pictures do not have, and for more than
    /// [`PictureEvaluator::reserve`] has made room for.
    ///
    /// # Safety
    /// `cmd` is being recorded on this device, for the family of the context's queue; its submissions
    /// run one after the other, none beside a call of this evaluator's that evaluates, reads or reserves;
    /// the evaluator and the pictures outlive them. A buffer holds 4 bytes for each layer, a multiple of
    /// 4 bytes from its front on, and may be the target of copies.
    pub unsafe fn record(
        &mut self,
        cmd: vk::CommandBuffer,
        pictures: &ImportedPictures,
        first_layer: u32,
        count: u32,
        target: ScoreTarget,
    ) -> Result<()> {
        let context = &self.context;
        context.check_present()?;
        pictures.check((context, self.memory.size), (first_layer, count))?;
        if count == 0 {
            return Ok(());
        }
        let generation = self.generation.as_mut().filter(|g| g.holds(count, 0));
        let generation = generation
            .ok_or_else(|| Error::Argument(format!("no room was made for {count} pictures")))?;
        self.measure.stage.read(pictures, first_layer);
        context.follow_earlier(cmd);
        let stages = (&self.memory, &self.measure as &dyn Measure, &self.fitness);
        generation.record(cmd, context, stages, (count, WITHOUT_LIGHTS));
        // SAFETY: the caller's promises for the buffer.
        unsafe { generation.deliver(cmd, context, count, target) };
        Ok(())
    }

    /// Reads the scores of the last recording with [`ScoreTarget::Mapped`], whose commands have run.
    ///
    /// # Errors
    /// [`Error::Argument`] for more scores than there is room for, and [`Error::Forgotten`].
    pub fn read_scores(&self, scores: &mut [f32]) -> Result<()> {
        GenerationMemory::read_scores(self.generation.as_ref(), scores)
    }

    /// `F` of the first `count` layers, submitted and waited for at once: `scores[i]` belongs to layer
    /// `i`.
    ///
    /// # Errors
    /// [`Error::Argument`] unless there are so many layers and `scores` has a place for each, and
    /// [device errors](crate::Error::is_device).
    pub fn evaluate(
        &mut self,
        pictures: &ImportedPictures,
        count: u32,
        scores: &mut [f32],
    ) -> Result<()> {
        if scores.len() != count as usize {
            let fault = format!("{} places for the scores of {count} pictures", scores.len());
            return Err(Error::Argument(fault));
        }
        self.run(pictures, 0, count)?;
        self.read_scores(scores)
    }

    /// `F` and the terms of the first `count` layers, in order. `F` has the bits that
    /// [`PictureEvaluator::evaluate`] gives.
    ///
    /// # Errors
    /// As [`PictureEvaluator::evaluate`].
    pub fn qualities(&mut self, pictures: &ImportedPictures, count: u32) -> Result<Vec<Quality>> {
        let (scores, details) = self.measured(pictures, 0, count)?;
        self.memory.qualities(&scores, &details)
    }

    /// One layer: its terms, and the picture that klieg has made of it.
    ///
    /// # Errors
    /// [`Error::Argument`] unless there is such a layer, and
    /// [device errors](crate::Error::is_device).
    pub fn inspect(&mut self, pictures: &ImportedPictures, layer: u32) -> Result<Inspection> {
        let (scores, details) = self.measured(pictures, layer, 1)?;
        let picture = self.measure.first_picture(&self.memory)?;
        let Quality { score, terms } = self.memory.qualities(&scores, &details)?[0];
        Ok(Inspection { score, terms, statistics: details[0].statistics(), picture })
    }

    /// The maps of the view that was recorded last and has run; read back from the device at the first
    /// call.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn maps(&mut self) -> Result<&Maps> {
        let maps = match self.maps.take() {
            Some(maps) => maps,
            None => Drawn::by_engine(&self.context).read(&self.memory)?,
        };
        Ok(self.maps.insert(maps))
    }

    /// The view that was recorded last: the frame in which lights stand.
    pub fn view(&self) -> Option<&View> {
        self.view.as_ref()
    }

    /// The device and what was made and read on it.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Scores, terms and statistics of some layers.
    fn measured(
        &mut self,
        pictures: &ImportedPictures,
        first_layer: u32,
        count: u32,
    ) -> Result<(Vec<f32>, Vec<Detail>)> {
        self.run(pictures, first_layer, count)?;
        let mut scores = vec![0.0; count as usize];
        self.read_scores(&mut scores)?;
        let details = match &self.generation {
            Some(generation) => generation.read_details(&self.context, scores.len())?,
            None => Vec::new(),
        };
        Ok((scores, details))
    }

    /// Evaluates some layers and waits for the end.
    fn run(&mut self, pictures: &ImportedPictures, first_layer: u32, count: u32) -> Result<()> {
        pictures.check((&self.context, self.memory.size), (first_layer, count))?;
        self.reserve(count)?;
        if count == 0 {
            return Ok(());
        }
        self.measure.stage.read(pictures, first_layer);
        let generation = self.generation.as_mut().expect("made by `reserve`");
        let stages = (&self.memory, &self.measure as &dyn Measure, &self.fitness);
        generation.record_submissions(
            &mut self.commands,
            &self.context,
            stages,
            (count, WITHOUT_LIGHTS),
        )?;
        self.commands.iter_mut().try_for_each(Commands::run)
    }
}
