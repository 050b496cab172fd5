//! What the device keeps of a view, and the seam between the stages that draw its maps and those of
//! a generation.
//!
//! [`ViewMemory`] owns all of it, with the one descriptor set that every stage binds as set 0
//! (`shaders/include/layout.glsl` declares it, [`layout::binding`] numbers it):
//!
//! - the G-buffer and the depth's maps ([`GBuffer`]), only where the device itself makes the maps.
//!   The visibility draw or, of what an engine has drawn, the stage `surface` writes the G-buffer's
//!   surface, `edges` the maps;
//! - the pixel types, R32_UINT, numbered as [`PixelType`](crate::objective::maps::PixelType);
//! - the surface's records, three RGBA32_SFLOAT images that `population` reads: position and
//!   shininess; normal and diffuse reflectance; specular reflectance (normalised), unlit luminance
//!   and pixel type (as a float) and 0. The three reflectances are luminances. `reflectance` makes
//!   them on the device from the G-buffer and the types, and for shading in colour `colors` three more,
//!   with shadows four;
//! - the shadow table and the occluders ([`ShadowMemory`]);
//! - [`ViewStatistics`]: pixel counts, `G_n` and the background's depth. `fitness` reads the
//!   counts and `G_n`.
//!
//! A generation needs types, records and statistics; [`ViewMemory::with_maps`] uploads them from
//! plain maps instead. Every image stays in layout `GENERAL`. What a recording writes, later
//! recordings see: each of klieg's begins with a barrier after all before it
//! ([`Commands::record`]; in an engine's commands [`Context::follow_earlier`]).

use super::g_buffer::GBuffer;
use super::records::{self, Coloring};
use super::shadows::{Casting, ShadowMemory};
use crate::gpu::Context;
use crate::gpu::layout::{self, Chunk, Detail, Parameters, ViewStatistics, binding};
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::{COPY_WRITE, Commands, NOTHING};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Access, Buffer, Image, ImageDesc};
use crate::gpu::vulkan::pipeline::{DescriptorSet, Pipeline, PipelineLayout};
use crate::gpu::vulkan::staging;
use crate::lighting::shading::{Brdf, Shading};
use crate::objective::maps::{self, Maps};
use crate::objective::{Needs, Objective, Quality};
use crate::scene::view::View;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Invocations of a work group of the stages that work pixel by pixel: columns and rows.
pub const PIXEL_GROUP: [u32; 2] = [32, 2];

/// Push constants of the view's stages: [`Chunk`].
pub const PUSH_BYTES: u32 = size_of::<Chunk>() as u32;
/// Who reads the push constants.
pub const PUSH_STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::COMPUTE.as_raw(),
);

/// The push constants of a view's stages.
pub fn push_constants(chunk: &Chunk) -> Option<(vk::ShaderStageFlags, &[u8])> {
    Some((PUSH_STAGES, bytemuck::bytes_of(chunk)))
}

/// Images of a view that some of its stages write: set 1 of these stages, and their layout.
pub struct Written {
    set: DescriptorSet,
    /// Of the view's set and this.
    pub layout: PipelineLayout,
}

/// All device memory of a view, its descriptor set and its stages' pipeline layout.
pub struct ViewMemory {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Set 0 of every stage.
    pub set: DescriptorSet,
    /// Layout of the stages that need the view's set alone.
    pub layout: PipelineLayout,
    /// Where the device makes the maps.
    pub g_buffer: Option<GBuffer>,
    /// Pixel types.
    pub types: Image,
    /// The surface as `population` reads it.
    pub records: [Image; 3],
    /// The same for shading in colour, in three layers, with shadows four; of a single pixel without.
    pub colors: Image,
    /// How pictures are shaded in colour: where the settings or the lights ask for it.
    pub color: Option<Coloring>,
    /// The shadow table, and what casts shadows.
    pub shadows: ShadowMemory,
    /// [`ViewStatistics`], device-local.
    pub statistics: Buffer,
    /// [`Parameters`], which an engine's commands may update.
    pub parameters: Buffer,
    /// What pictures are judged by.
    pub objective: Objective,
    context: Arc<Context>,
}

impl ViewMemory {
    /// Memory for a view; the records, the types, the shadow table and the statistics are yet to be written.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture larger than the device can draw and as [`View::check`],
    /// [`Objective::check`] and [`Shading::check`], [`Error::Unsupported`] as [`ShadowMemory::new`],
    /// and [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        view: &View,
        (objective, shading): (&Objective, &Shading),
        lights: Lights,
        casting: Option<Casting<'_>>,
    ) -> Result<Self> {
        view.check()?;
        objective.check()?;
        shading.check()?;
        let size = [view.width, view.height];
        let largest = context.report().max_size;
        if size.iter().any(|&side| side > largest) {
            return Err(Error::Argument(format!(
                "picture size {}x{} is more than the device's {largest}x{largest}",
                view.width, view.height
            )));
        }
        let mut set = DescriptorSet::new(context, "view", &layout::bindings())?;
        let layout = PipelineLayout::new(context, &[set.layout()], PUSH_STAGES, PUSH_BYTES)?;
        let parameters = Buffer::of(
            context,
            "parameters",
            &[Parameters::new(view, objective, shading)],
            vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST,
        )?;
        set.write_buffer(binding::PARAMETERS, &parameters);
        let types = map(context, size, "types", vk::Format::R32_UINT)?;
        let record = |name| map(context, size, name, vk::Format::R32G32B32A32_SFLOAT);
        let records = [record("record 0")?, record("record 1")?, record("record 2")?];
        let colored = lights == Lights::Any
            || casting.is_some()
            || shading.brdf != Brdf::BlinnPhong
            || objective.needs() != Needs::NONE;
        let layers = if casting.is_some() { 4 } else { 3 };
        let colors = colors(context, if colored { size } else { [1, 1] }, layers)?;
        let shadows = ShadowMemory::new(context, size, casting)?;
        shadows.write(&mut set, binding::SHADOW_TABLE);
        set.write_image(binding::COLOR_SURFACE, &colors, vk::ImageLayout::GENERAL);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let bytes = size_of::<ViewStatistics>() as u64;
        let statistics = Buffer::new(context, "view statistics", bytes, usage, Access::Device)?;
        set.write_buffer(binding::VIEW_STATISTICS, &statistics);
        set.write_image(binding::TYPES, &types, vk::ImageLayout::GENERAL);
        for (i, image) in records.iter().enumerate() {
            set.write_image(binding::SURFACE_0 + i as u32, image, vk::ImageLayout::GENERAL);
        }
        let memory = Self {
            size,
            set,
            layout,
            g_buffer: None,
            types,
            records,
            colors,
            color: colored.then_some(Coloring { brdf: shading.brdf, shadow_side: shadows.side }),
            shadows,
            statistics,
            parameters,
            objective: *objective,
            context: Arc::clone(context),
        };
        let [a, b, c] = &memory.records;
        to_general(context, &[&memory.types, a, b, c, &memory.colors, &memory.shadows.table])?;
        Ok(memory)
    }

    /// Adds the images that `edges` writes, and those that the visibility draw or, with `written` as
    /// storage images, the stage `surface` writes.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn add_g_buffer(&mut self, written: vk::ImageUsageFlags) -> Result<&GBuffer> {
        let g_buffer = GBuffer::new(&self.context, self.size, written)?;
        for (number, image) in (binding::CODE..).zip(g_buffer.surface()) {
            self.set.write_image(number, image, vk::ImageLayout::GENERAL);
        }
        to_general(&self.context, &g_buffer.images())?;
        Ok(self.g_buffer.insert(g_buffer))
    }

    /// Memory for the view that `maps` describes, ready for a generation.
    ///
    /// # Errors
    /// As [`ViewMemory::new`] and [`Maps::check`]; [`Error::Argument`] when the maps have another size than
    /// the view.
    pub fn with_maps(
        context: &Arc<Context>,
        maps: &Maps,
        view: &View,
        objective: &Objective,
        shading: &Shading,
        lights: Lights,
    ) -> Result<Self> {
        let surface = &maps.surface;
        if (surface.width, surface.height) != (view.width, view.height) {
            return Err(Error::Argument(format!(
                "maps of {}x{} for a view of {}x{}",
                surface.width, surface.height, view.width, view.height
            )));
        }
        maps.check()?;
        let shadows = maps.shadows.as_ref();
        let casting = shadows.map(|s| Casting { occluders: s.occluders(), side: s.side() });
        let memory = Self::new(context, view, (objective, shading), lights, casting)?;
        if let Some(shadows) = shadows {
            memory.shadows.upload(context, shadows)?;
        }
        let types: Vec<u32> = maps.types.iter().map(|&kind| kind as u32).collect();
        let records = records::records(maps, shading);
        let statistics = ViewStatistics::from(maps);
        let source = vk::BufferUsageFlags::TRANSFER_SRC;
        let types = Buffer::of(context, "types upload", &types, source)?;
        let [a, b, c] = &records;
        let upload = |record: &Vec<[f32; 4]>| Buffer::of(context, "record upload", record, source);
        let records = [upload(a)?, upload(b)?, upload(c)?];
        let colors = match memory.color {
            Some(_) => {
                records::colors(maps, view, shading).iter().map(upload).collect::<Result<_>>()?
            }
            None => Vec::new(),
        };
        let statistics = Buffer::of(context, "statistics upload", &[statistics], source)?;
        Commands::once(context, |cmd| {
            context.upload(cmd, &types, (&memory.types, 0));
            for (from, to) in records.iter().zip(&memory.records) {
                context.upload(cmd, from, (to, 0));
            }
            for (from, layer) in colors.iter().zip(0..) {
                context.upload(cmd, from, (&memory.colors, layer));
            }
            let region = [vk::BufferCopy::default().size(statistics.size())];
            // SAFETY: both buffers are alive and hold the statistics.
            unsafe {
                let (from, to) = (statistics.raw(), memory.statistics.raw());
                context.recorder().cmd_copy_buffer(cmd, from, to, &region);
            }
            Ok(())
        })?;
        Ok(memory)
    }

    /// The qualities of individuals with these scores and details. The scores are taken over, unless the
    /// objective has terms that no shader knows: these are judged here.
    ///
    /// # Errors
    /// What the device reports.
    pub fn qualities(&self, scores: &[f32], details: &[Detail]) -> Result<Vec<Quality>> {
        let view = maps::ViewStatistics::from(&self.read_statistics()?);
        let objective = &self.objective;
        let own = objective.is_own();
        let quality = |(&score, detail): (&f32, &Detail)| {
            let judged = objective.quality(&detail.statistics(), &view);
            if own { Quality { score, ..judged } } else { judged }
        };
        Ok(scores.iter().zip(details).map(quality).collect())
    }

    /// Reads the statistics back.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn read_statistics(&self) -> Result<ViewStatistics> {
        Ok(staging::read_buffer(&self.context, &self.statistics, 1)?[0])
    }

    /// Records a compute stage: its pipeline, the view's set, the push constants, the dispatch.
    pub fn dispatch(
        &self,
        cmd: vk::CommandBuffer,
        pipeline: &Pipeline,
        groups: [u32; 3],
        push: &Chunk,
    ) {
        let run = Dispatch {
            pipeline,
            layout: self.layout,
            sets: &[self.set.raw()],
            offsets: &[],
            push: push_constants(push),
            groups,
        };
        self.context.dispatch(cmd, &run);
    }

    /// The same of a stage with a set of its own behind the view's.
    pub fn dispatch_with(
        &self,
        cmd: vk::CommandBuffer,
        (pipeline, own): (&Pipeline, &Written),
        groups: [u32; 3],
        push: &Chunk,
    ) {
        let run = Dispatch {
            pipeline,
            layout: own.layout,
            sets: &[self.set.raw(), own.set.raw()],
            offsets: &[],
            push: push_constants(push),
            groups,
        };
        self.context.dispatch(cmd, &run);
    }

    /// Work groups of [`PIXEL_GROUP`] that cover the picture.
    pub fn pixel_groups(&self) -> [u32; 3] {
        let [x, y] = PIXEL_GROUP;
        [self.size[0].div_ceil(x), self.size[1].div_ceil(y), 1]
    }
}

impl Written {
    /// For stages that write these images, which are in layout `GENERAL`, at bindings from 0 on.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        view: &ViewMemory,
        (name, images): (&str, &[&Image]),
    ) -> Result<Self> {
        let bindings: Vec<_> = layout::written_images(0, images.len() as u32).collect();
        let mut set = DescriptorSet::new(context, name, &bindings)?;
        for (number, image) in (0..).zip(images) {
            set.write_image(number, image, vk::ImageLayout::GENERAL);
        }
        let sets = [view.set.layout(), set.layout()];
        let layout = PipelineLayout::new(context, &sets, PUSH_STAGES, PUSH_BYTES)?;
        Ok(Self { set, layout })
    }
}

/// The records for shading in colour.
fn colors(context: &Arc<Context>, [width, height]: [u32; 2], layers: u32) -> Result<Image> {
    let usage = vk::ImageUsageFlags::STORAGE
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC
        | vk::ImageUsageFlags::TRANSFER_DST;
    let image_of = ("colors", vk::Format::R32G32B32A32_SFLOAT, Some(layers));
    image(context, [width, height], image_of, usage)
}

/// An image that compute stages write and read.
pub(super) fn map(
    context: &Arc<Context>,
    size: [u32; 2],
    name: &str,
    format: vk::Format,
) -> Result<Image> {
    let usage = vk::ImageUsageFlags::STORAGE
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC
        | vk::ImageUsageFlags::TRANSFER_DST;
    image(context, size, (name, format, None), usage)
}

/// An image of one mip level.
pub(super) fn image(
    context: &Arc<Context>,
    [width, height]: [u32; 2],
    (name, format, layers): (&str, vk::Format, Option<u32>),
    usage: vk::ImageUsageFlags,
) -> Result<Image> {
    Image::new(context, &ImageDesc { name, format, width, height, layers, mips: 1, usage })
}

/// Moves fresh images to layout `GENERAL`.
fn to_general(context: &Arc<Context>, images: &[&Image]) -> Result<()> {
    Commands::once(context, |cmd| {
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in images {
            context.transition(cmd, image, layouts, NOTHING, COPY_WRITE);
        }
        Ok(())
    })
}
