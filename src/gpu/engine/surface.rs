//! An engine's own surface: its depth, normals and materials become klieg's G-buffer by the stage
//! `surface`, and the maps are made of that, in the engine's own commands.

use crate::Result;
use crate::constants::{
    BASE_COLOR_ENCODED, FLIPPED, HAS_BASE_COLOR, HAS_EMISSIVE, HAS_IDS, HAS_NORMAL,
    HAS_ROUGHNESS_METALLIC, NORMAL_OCTAHEDRAL, NORMAL_UNSIGNED,
};
use crate::gpu::Context;
use crate::gpu::evaluator::GpuEvaluator;
use crate::gpu::layout::{EngineSurface, Parameters};
use crate::gpu::shaders;
use crate::gpu::view::maps::MapStages;
use crate::gpu::view::memory::{PIXEL_GROUP, ViewMemory};
use crate::gpu::view::records::Records;
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::{
    COMPUTE_READ, COMPUTE_WRITE, COPY_READ, COPY_WRITE, Commands, StageTimer,
};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::{Binding, DescriptorSet, Pipeline, PipelineLayout, set_layout};
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::scene::engine::{EngineCamera, NormalCode, NormalSpace, SurfaceFormat};
use crate::scene::view::View;
use ash::vk;
use glam::{DMat3, DMat4};
use std::sync::Arc;

/// An image of an engine: a two-dimensional view of one aspect, and the layout that the image is in
/// whenever klieg reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineImage {
    /// The view; its image may be sampled.
    pub view: vk::ImageView,
    /// A layout that allows sampling, such as `SHADER_READ_ONLY_OPTIMAL` or `GENERAL`.
    pub layout: vk::ImageLayout,
}

/// The images of an engine's surface, all of the evaluator's size. klieg reads them by texel fetch, so
/// that any float, normalised or sRGB format will do.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceImages {
    /// Depth as the engine's projection gives it: the depth aspect, or a colour of one component.
    pub depth: EngineImage,
    /// Shading normals; without them normals are made of the depth.
    pub normal: Option<EngineImage>,
    /// Base colours.
    pub base_color: Option<EngineImage>,
    /// Roughness and metallic factor.
    pub roughness_metallic: Option<EngineImage>,
    /// Linear emitted radiance.
    pub emissive: Option<EngineImage>,
    /// Numbers of objects or polygons, unsigned integers: 0 is the background.
    pub ids: Option<EngineImage>,
}

/// Bindings of the stage's set: the engine's images, the G-buffer's, the block.
const ENGINE_IMAGES: u32 = 6;
const BLOCK: u32 = 11;

fn bindings() -> Vec<Binding> {
    let kind = |number| match number {
        0..ENGINE_IMAGES => vk::DescriptorType::SAMPLED_IMAGE,
        BLOCK => vk::DescriptorType::UNIFORM_BUFFER,
        _ => vk::DescriptorType::STORAGE_IMAGE,
    };
    (0..=BLOCK).map(|n| (n, kind(n), vk::ShaderStageFlags::COMPUTE)).collect()
}

/// An engine's images as an evaluator reads them. It stays usable as long as the images do.
pub struct ImportedSurface {
    set: DescriptorSet,
    format: SurfaceFormat,
    flags: u32,
}

/// The stages that make a view's maps of an engine's surface, in the engine's commands.
pub(in crate::gpu) struct SurfaceStages {
    stage: Pipeline,
    layout: PipelineLayout,
    block: Buffer,
    maps: MapStages,
    records: Records,
    objective: Objective,
    shading: Shading,
    context: Arc<Context>,
}

impl SurfaceStages {
    /// With the memory of a view of `size`; its maps are those of an empty picture.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for settings out of their range and a picture larger than the
    /// device can take, and [device errors](crate::Error::is_device).
    pub(in crate::gpu) fn new(
        context: &Arc<Context>,
        [width, height]: [u32; 2],
        objective: &Objective,
        shading: &Shading,
        lights: Lights,
    ) -> Result<(Self, ViewMemory)> {
        context.check_present()?;
        objective.check()?;
        shading.check()?;
        // Any camera will do before the first view.
        let camera = EngineCamera {
            view: DMat4::IDENTITY,
            projection: DMat4::IDENTITY,
            center: Default::default(),
            radius: 1.0,
        };
        let view = camera.view(width, height)?;
        let mut memory = ViewMemory::new(context, &view, objective, shading, lights)?;
        memory.add_g_buffer(vk::ImageUsageFlags::STORAGE)?;
        let layout = set_layout(context, &bindings())?;
        let layout = PipelineLayout::new(context, &[layout], vk::ShaderStageFlags::empty(), 0)?;
        let (spirv, size) = (shaders::SURFACE_COMP, size_of::<EngineSurface>() as u64);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let stages = Self {
            stage: Pipeline::compute(context, "surface", spirv, &layout, &PIXEL_GROUP)?,
            layout,
            block: Buffer::new(context, "engine surface", size, usage, Access::Device)?,
            maps: MapStages::new(context, &memory, None)?,
            records: Records::new(context, &memory)?,
            objective: *objective,
            shading: *shading,
            context: Arc::clone(context),
        };
        stages.clear(&memory)?;
        Ok((stages, memory))
    }

    /// Makes the maps of an empty picture.
    fn clear(&self, memory: &ViewMemory) -> Result<()> {
        let Some(g_buffer) = &memory.g_buffer else { return Ok(()) };
        let context = &self.context;
        Commands::once(context, |cmd| {
            let (color, layout) = (vk::ClearColorValue::default(), vk::ImageLayout::GENERAL);
            for (_, image) in g_buffer.images() {
                // SAFETY: `cmd` is being recorded; the images are alive, in this layout, and may be
                // cleared.
                unsafe {
                    let range = [image.range()];
                    context.recorder().cmd_clear_color_image(
                        cmd,
                        image.raw(),
                        layout,
                        &color,
                        &range,
                    );
                }
            }
            context.barrier(cmd, COPY_WRITE, (COMPUTE_READ.0, COMPUTE_READ.1 | COMPUTE_WRITE.1));
            self.record_maps(cmd, memory)
        })
    }

    fn record_maps(&self, cmd: vk::CommandBuffer, memory: &ViewMemory) -> Result<()> {
        let mut timer = StageTimer::new(&self.context, 0)?;
        self.maps.record(cmd, memory, &mut timer);
        timer.stage(cmd, "reflectance", || self.records.record(cmd, &self.context, memory));
        let readers = (COMPUTE_READ.0 | COPY_READ.0, COMPUTE_READ.1 | COPY_READ.1);
        self.context.barrier(cmd, COMPUTE_WRITE, readers);
        Ok(())
    }

    /// Takes an engine's images in.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a format out of its range, and
    /// [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// The views are of this device, and alive as long as what is recorded with the result runs.
    pub(in crate::gpu) unsafe fn import(
        &self,
        memory: &ViewMemory,
        images: &SurfaceImages,
        format: &SurfaceFormat,
    ) -> Result<ImportedSurface> {
        self.context.check_present()?;
        format.check()?;
        let mut set = DescriptorSet::new(&self.context, "engine surface", &bindings())?;
        let general = vk::ImageLayout::GENERAL;
        // Where there is no image, any other stands for it, unread.
        let blank = |image: &crate::gpu::vulkan::memory::Image| EngineImage {
            view: image.view(),
            layout: general,
        };
        let float = blank(&memory.records[0]);
        let SurfaceImages { depth, normal, base_color, roughness_metallic, emissive, ids } =
            *images;
        let mut flags = 0;
        for (number, (image, other, flag)) in [
            (Some(depth), float, 0),
            (normal, float, HAS_NORMAL),
            (base_color, float, HAS_BASE_COLOR),
            (roughness_metallic, float, HAS_ROUGHNESS_METALLIC),
            (emissive, float, HAS_EMISSIVE),
            (ids, blank(&memory.types), HAS_IDS),
        ]
        .into_iter()
        .enumerate()
        {
            flags |= image.map_or(0, |_| flag);
            let EngineImage { view, layout } = image.unwrap_or(other);
            set.write_view(number as u32, view, layout);
        }
        if let Some(g_buffer) = &memory.g_buffer {
            let written = g_buffer.images().into_iter().take((BLOCK - ENGINE_IMAGES) as usize);
            for (number, (_, image)) in (ENGINE_IMAGES..).zip(written) {
                set.write_image(number, image, general);
            }
        }
        set.write_buffer(BLOCK, &self.block);
        Ok(ImportedSurface { set, format: *format, flags: flags | code_flags(format) })
    }

    /// Records the making of the maps of what the engine has drawn.
    ///
    /// # Errors
    /// As [`EngineCamera::view`].
    pub(in crate::gpu) fn record(
        &self,
        cmd: vk::CommandBuffer,
        memory: &ViewMemory,
        surface: &ImportedSurface,
        camera: &EngineCamera,
    ) -> Result<View> {
        self.context.check_present()?;
        let view = camera.view(memory.size[0], memory.size[1])?;
        let context = &self.context;
        context.follow_earlier(cmd);
        let parameters = Parameters::new(&view, &self.objective, &self.shading);
        context.update(cmd, &memory.parameters, &[parameters]);
        context.update(cmd, &self.block, &[block(surface, camera, &view)]);
        let run = Dispatch {
            pipeline: &self.stage,
            layout: self.layout,
            sets: &[surface.set.raw()],
            offsets: &[],
            push: None,
            groups: memory.pixel_groups(),
        };
        context.labelled(cmd, "surface", || context.dispatch(cmd, &run));
        context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
        self.record_maps(cmd, memory)?;
        Ok(view)
    }
}

/// How the images are coded, as bits.
fn code_flags(format: &SurfaceFormat) -> u32 {
    let code = match format.normal_code {
        NormalCode::Signed => 0,
        NormalCode::Unsigned => NORMAL_UNSIGNED,
        NormalCode::Octahedral => NORMAL_OCTAHEDRAL,
        NormalCode::OctahedralUnsigned => NORMAL_OCTAHEDRAL | NORMAL_UNSIGNED,
    };
    let flag = |set, flag| if set { flag } else { 0 };
    code | flag(format.flipped, FLIPPED) | flag(format.base_color_encoded, BASE_COLOR_ENCODED)
}

fn block(surface: &ImportedSurface, camera: &EngineCamera, view: &View) -> EngineSurface {
    let (format, frame) = (&surface.format, &view.frame);
    let rotation = match format.normal_space {
        NormalSpace::World => DMat3::from_cols(frame.right, frame.up, frame.back).transpose(),
        NormalSpace::Eye => DMat3::IDENTITY,
    };
    let ([x, y, z], [r, g, b]) = (view.eye.to_array(), format.base_color);
    EngineSurface {
        frame_from_clip: camera.frame_from_clip(frame).as_mat4().to_cols_array_2d(),
        frame_from_normals: DMat4::from_mat3(rotation).as_mat4().to_cols_array_2d(),
        eye: [x, y, z, f32::from(u8::from(view.is_orthographic()))],
        base_color_roughness: [r, g, b, format.roughness],
        metallic: format.metallic,
        cleared_depth: format.cleared_depth,
        flags: surface.flags,
        channels: format.roughness_channel | format.metallic_channel << 2,
        size: [view.width, view.height],
        padding: [0; 2],
    }
}

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
    /// For pictures of `size` (width and height, pixels).
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
        let lights = context.lights();
        let (stages, memory) = SurfaceStages::new(context, size, &objective, &shading, lights)?;
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
