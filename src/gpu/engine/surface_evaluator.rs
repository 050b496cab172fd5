//! Measures populations of lights against what an engine has drawn.

use super::surface::{ImportedSurface, SurfaceImages, SurfaceStages};
use crate::Result;
use crate::gpu::Context;
use crate::gpu::evaluator::GpuEvaluator;
use crate::gpu::vulkan::commands::Commands;
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::engine::{EngineCamera, SurfaceFormat};
use crate::scene::view::View;
use ash::vk;
use std::sync::Arc;

/// Measures populations against the views that an engine draws: its own surface stands for a scene.
///
/// The engine draws, [`SurfaceEvaluator::record_view`] makes the maps of what is seen, and
/// [`SurfaceEvaluator::evaluator`] measures populations of lights against them. Before the first view
/// the picture is empty. The memory is for pictures whose every pixel shows an object.
///
/// ```no_run
/// use ash::vk;
/// use klieg::gpu::{Context, EngineImage, ScoreTarget, SurfaceEvaluator, SurfaceImages};
/// use klieg::lighting::shading::Shading;
/// use klieg::objective::Objective;
/// use klieg::design::Designer;
/// use klieg::scene::engine::{EngineCamera, SurfaceFormat};
/// # use std::sync::Arc;
///
/// # unsafe fn frame(context: &Arc<Context>, [depth, normal]: [vk::ImageView; 2], camera: EngineCamera,
/// #     cmd: vk::CommandBuffer, buffer: vk::Buffer, designer: &mut Designer, scores: &[f32],
/// # ) -> klieg::Result<()> { unsafe {
/// let size = [1280, 720];
/// let mut klieg =
///     SurfaceEvaluator::new(context, size, Objective::default(), Shading::default())?;
/// klieg.evaluator().reserve(30, 2)?;
/// let image = |view| EngineImage { view, layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL };
/// let images = SurfaceImages {
///     depth: image(depth),
///     normal: Some(image(normal)),
///     base_color: None,
///     roughness_metallic: None,
///     emissive: None,
///     ids: None,
/// };
/// let surface = klieg.import(&images, &SurfaceFormat::default())?;
///
/// // Each frame, after the engine's G-buffer pass.
/// klieg.record_view(cmd, &surface, &camera)?;
/// let target = ScoreTarget::Buffer { buffer, offset: 0 };
/// klieg.evaluator().record(cmd, designer.ask(), target)?;
/// // After the frame's fence.
/// designer.tell(scores)?;
/// # Ok(()) } }
/// ```
pub struct SurfaceEvaluator {
    evaluator: GpuEvaluator,
    stages: SurfaceStages,
    view: Option<View>,
}

impl SurfaceEvaluator {
    /// For pictures of `size` (width and height, pixels). Lights cast no shadows.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for settings out of their range and a picture larger than the
    /// device can take, [`crate::Error::Unsupported`] for a pipeline that the device was not
    /// imported for, and [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        size: [u32; 2],
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        Self::of(context, size, (objective, shading), None)
    }

    /// The same with the shadows that a scene casts, whose triangles stand in the engine's world as the
    /// surface does; what moves in the engine's own scene does not move here. Of a light outside the ball of
    /// [`EngineCamera::radius`] the direction alone counts, so that it should hold all of the scene. The table
    /// is made on the device, in the commands of [`SurfaceEvaluator::record_view`].
    ///
    /// # Errors
    /// As [`SurfaceEvaluator::new`], [`ShadowSettings::check`] and
    /// [`Occluders::new`](crate::scene::occluders::Occluders::new), and
    /// [`crate::Error::Unsupported`] for a scene that is more than the device's buffers can hold.
    pub fn with_shadows(
        context: &Arc<Context>,
        size: [u32; 2],
        (objective, shading): (Objective, Shading),
        scene: &Scene,
        shadows: &ShadowSettings,
    ) -> Result<Self> {
        Self::of(context, size, (objective, shading), Some((scene, shadows)))
    }

    fn of(
        context: &Arc<Context>,
        size: [u32; 2],
        (objective, shading): (Objective, Shading),
        shadows: Option<(&Scene, &ShadowSettings)>,
    ) -> Result<Self> {
        let (lights, settings) = (context.lights(), (&objective, &shading));
        let (stages, memory) = SurfaceStages::new(context, size, settings, lights, shadows)?;
        let mut evaluator = GpuEvaluator::of_any_view(context, memory)?;
        Commands::once(context, |cmd| {
            evaluator.record_view(cmd);
            Ok(())
        })?;
        Ok(Self { evaluator, stages, view: None })
    }

    /// Takes an engine's images in: once for each set of images that the engine draws into.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a format out of its range, and
    /// [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// The views are of this device and of the evaluator's size, and alive as long as what is recorded
    /// with the result runs.
    pub unsafe fn import(
        &self,
        images: &SurfaceImages,
        format: &SurfaceFormat,
    ) -> Result<ImportedSurface> {
        // SAFETY: the caller's promise.
        unsafe { self.stages.import(self.evaluator.view(), images, format) }
    }

    /// Records the making of the maps of what the engine has drawn, outside render passes: never
    /// submits, waits or makes anything. What is recorded or evaluated later, until the next view,
    /// is measured against this view.
    ///
    /// # Errors
    /// As [`EngineCamera::view`].
    ///
    /// # Safety
    /// `cmd` is being recorded on this device, for the family of the context's queue; its submissions
    /// run one after the other, none beside [`evaluate`](crate::evaluate::Evaluator::evaluate); the
    /// evaluator and `surface`, which is one of its own, outlive them. The images are in their stated
    /// layouts and visible to `SHADER_READ` in `COMPUTE_SHADER`; they are left as they are, and may be
    /// written again after a barrier from `COMPUTE_SHADER`.
    pub unsafe fn record_view(
        &mut self,
        cmd: vk::CommandBuffer,
        surface: &ImportedSurface,
        camera: &EngineCamera,
    ) -> Result<()> {
        let view = self.stages.record(cmd, self.evaluator.view(), surface, camera)?;
        self.evaluator.record_view(cmd);
        self.view = Some(view);
        Ok(())
    }

    /// As [`SurfaceEvaluator::record_view`], submitted and waited for at once.
    ///
    /// # Errors
    /// As [`SurfaceEvaluator::record_view`], and [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// No recording of this evaluator runs; the images as for [`SurfaceEvaluator::record_view`].
    pub unsafe fn look(&mut self, surface: &ImportedSurface, camera: &EngineCamera) -> Result<()> {
        let context = Arc::clone(self.evaluator.context());
        // SAFETY: the caller's promise; the commands run and end here.
        Commands::once(&context, |cmd| unsafe { self.record_view(cmd, surface, camera) })
    }

    /// The view that was recorded last: the frame in which the lights stand.
    pub fn view(&self) -> Option<&View> {
        self.view.as_ref()
    }

    /// What measures populations against the view that was recorded last.
    pub fn evaluator(&mut self) -> &mut GpuEvaluator {
        &mut self.evaluator
    }
}
