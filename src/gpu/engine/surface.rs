//! An engine's own surface: its depth, normals and materials become klieg's G-buffer by the stage
//! `surface`, and the maps are made of that, in the engine's own commands.

use crate::Result;
use crate::constants::{
    BASE_COLOR_ENCODED, FLIPPED, HAS_BASE_COLOR, HAS_EMISSIVE, HAS_IDS, HAS_NORMAL,
    HAS_ROUGHNESS_METALLIC, NORMAL_OCTAHEDRAL, NORMAL_UNSIGNED,
};
use crate::gpu::Context;
use crate::gpu::layout::{EngineSurface, Parameters};
use crate::gpu::shaders;
use crate::gpu::view::maps::MapStages;
use crate::gpu::view::memory::{PIXEL_GROUP, ViewMemory};
use crate::gpu::view::records::Records;
use crate::gpu::view::shadows::{self, Casting, ShadowStage};
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ, COPY_WRITE, Commands};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::{Binding, DescriptorSet, Pipeline, PipelineLayout, set_layout};
use crate::gpu::vulkan::timer::StageTimer;
use crate::lighting::shading::Shading;
use crate::math::frame::Frame;
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::engine::{EngineCamera, NormalCode, NormalSpace, SurfaceFormat};
use crate::scene::occluders::Occluders;
use crate::scene::view::{View, bounds};
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
const BLOCK: u32 = 10;

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

/// What casts the shadows of an engine's views. It stands in a frame of its own, as the light frame turns with
/// the camera.
struct Cast {
    occluders: Arc<Occluders>,
    frame: Frame,
    side: u32,
}

impl Cast {
    fn new(
        context: &Context,
        view: &View,
        scene: &Scene,
        settings: &ShadowSettings,
    ) -> Result<Self> {
        let side = shadows::side(context, [view.width, view.height], settings)?;
        let (center, radius) = bounds(scene)?;
        let (view, projection) = (DMat4::IDENTITY, DMat4::IDENTITY);
        let fixed = EngineCamera { view, projection, center, radius }.view(1, 1)?;
        let occluders = Arc::new(Occluders::new(scene, &fixed)?);
        Ok(Self { occluders, frame: fixed.frame, side })
    }

    fn casting(&self) -> Casting<'_> {
        Casting { occluders: &self.occluders, side: self.side }
    }
}

/// The stages that make a view's maps of an engine's surface, in the engine's commands.
pub(in crate::gpu) struct SurfaceStages {
    stage: Pipeline,
    layout: PipelineLayout,
    block: Buffer,
    maps: MapStages,
    /// With the frame of the occluders.
    shadows: Option<(ShadowStage, Frame)>,
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
        (objective, shading): (&Objective, &Shading),
        lights: Lights,
        shadows: Option<(&Scene, &ShadowSettings)>,
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
        let shadows = match shadows.filter(|(_, settings)| settings.on) {
            Some((scene, settings)) => Some(Cast::new(context, &view, scene, settings)?),
            None => None,
        };
        let casting = shadows.as_ref().map(Cast::casting);
        let settings = (objective, shading);
        let mut memory = ViewMemory::new(context, &view, settings, lights, casting)?;
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
            shadows: match shadows {
                Some(cast) => Some((ShadowStage::new(context, &memory)?, cast.frame)),
                None => None,
            },
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
            for image in g_buffer.images() {
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
        if let Some((stage, _)) = &self.shadows {
            let rows = 0..memory.size[1];
            timer.stage(cmd, "shadows", || stage.record(cmd, &self.context, memory, rows));
        }
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
            for (number, image) in (ENGINE_IMAGES..).zip(g_buffer.surface()) {
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
        if let Some((_, frame)) = &self.shadows {
            let occluders_from_frame = frame.from_world() * view.frame.from_world().inverse();
            let matrix = occluders_from_frame.as_mat4().to_cols_array();
            context.update(cmd, &memory.shadows.frame, &[matrix]);
        }
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
