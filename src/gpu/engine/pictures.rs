//! The stage `pictures`: pictures that an engine has rendered, a layer for each individual, become
//! klieg's own.

use super::surface::EngineImage;
use crate::gpu::Context;
use crate::gpu::layout::Chunk;
use crate::gpu::measure::population::{self, PictureStage};
use crate::gpu::shaders;
use crate::gpu::view::memory::{PIXEL_GROUP, PUSH_BYTES, PUSH_STAGES, ViewMemory, push_constants};
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_READ};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Buffer, Image};
use crate::gpu::vulkan::pipeline::RigKind;
use crate::gpu::vulkan::pipeline::{Binding, DescriptorSet, Pipeline, PipelineLayout, set_layout};
use crate::scene::engine::{PictureChannels, PictureEncoding, PictureFormat};
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// The stage's second and third set: the engine's pictures, and klieg's.
const RENDERED: [Binding; 1] =
    [(0, vk::DescriptorType::SAMPLED_IMAGE, vk::ShaderStageFlags::COMPUTE)];
const MADE: [Binding; 1] = [(0, vk::DescriptorType::STORAGE_IMAGE, vk::ShaderStageFlags::COMPUTE)];

/// An engine's pictures as an evaluator reads them. It stays usable as long as their image does.
pub struct ImportedPictures {
    set: DescriptorSet,
    pipeline: Pipeline,
    layers: u32,
    size: [u32; 2],
    context: Arc<Context>,
}

impl ImportedPictures {
    /// How many pictures there are.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// # Errors
    /// [`Error::Argument`] unless these are layers of pictures of `size` on `context`.
    pub(in crate::gpu) fn check(
        &self,
        (context, size): (&Arc<Context>, [u32; 2]),
        (first, count): (u32, u32),
    ) -> Result<()> {
        if !Arc::ptr_eq(&self.context, context) {
            return Err(Error::Argument("the pictures are of another context".into()));
        }
        if self.size != size {
            let ([width, height], [x, y]) = (self.size, size);
            let fault = format!("pictures of {width}x{height} for an evaluator of {x}x{y}");
            return Err(Error::Argument(fault));
        }
        match first.checked_add(count) {
            Some(end) if end <= self.layers => Ok(()),
            _ => Err(Error::Argument(format!(
                "{count} pictures from layer {first} on, of an image with {} layers",
                self.layers
            ))),
        }
    }
}

/// What the next recording reads.
struct Source {
    set: vk::DescriptorSet,
    pipeline: Pipeline,
    first_layer: u32,
}

/// The stage, with the pictures that it makes.
pub(in crate::gpu) struct Pictures {
    source: Option<Source>,
    made: DescriptorSet,
    image: Option<Image>,
    size: [u32; 2],
    layout: PipelineLayout,
    /// Whether pixels with a channel that is burnt out are told apart.
    channels: bool,
    context: Arc<Context>,
}

impl Pictures {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub(in crate::gpu) fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        let made = DescriptorSet::new(context, "made pictures", &MADE)?;
        let sets = [view.set.layout(), set_layout(context, &RENDERED)?, made.layout()];
        let layout = PipelineLayout::new(context, &sets, PUSH_STAGES, PUSH_BYTES)?;
        let channels = view.objective.needs().channels;
        let (size, context) = (view.size, Arc::clone(context));
        Ok(Self { source: None, made, image: None, size, layout, channels, context })
    }

    /// Takes an engine's pictures in.
    ///
    /// # Errors
    /// [`Error::Argument`] for pictures without layers, and
    /// [device errors](crate::Error::is_device).
    ///
    /// # Safety
    /// The view is an array of this device, of so many layers at least as large as the picture, and
    /// alive as long as what is recorded with the result runs.
    pub(in crate::gpu) unsafe fn import(
        &self,
        pictures: EngineImage,
        layers: u32,
        format: PictureFormat,
    ) -> Result<ImportedPictures> {
        self.context.check_present()?;
        if layers == 0 {
            return Err(Error::Argument("pictures without layers".into()));
        }
        let mut set = DescriptorSet::new(&self.context, "engine's pictures", &RENDERED)?;
        set.write_view(0, pictures.view, pictures.layout);
        let [x, y] = PIXEL_GROUP;
        let encoded = format.encoding == PictureEncoding::Encoded;
        let red = format.channels == PictureChannels::Red;
        let constants = [x, y, encoded.into(), red.into()];
        let context = Arc::clone(&self.context);
        let (stem, spirv) = match self.channels {
            true => ("pictures_channels", shaders::PICTURES_CHANNELS_COMP),
            false => ("pictures", shaders::PICTURES_COMP),
        };
        let pipeline = Pipeline::compute(&context, stem, spirv, &self.layout, &constants)?;
        Ok(ImportedPictures { set, pipeline, layers, size: self.size, context })
    }

    /// Lets the next recording read these pictures, the first of a population at `first_layer`.
    pub(in crate::gpu) fn read(&mut self, pictures: &ImportedPictures, first_layer: u32) {
        let (set, pipeline) = (pictures.set.raw(), pictures.pipeline);
        self.source = Some(Source { set, pipeline, first_layer });
    }
}

impl PictureStage for Pictures {
    fn stem(&self) -> &'static str {
        "pictures"
    }

    fn format(&self) -> vk::Format {
        match self.channels {
            true => vk::Format::R32G32B32A32_SFLOAT,
            false => vk::Format::R32_SFLOAT,
        }
    }

    fn pixel_bytes(&self) -> u64 {
        4 * population::channels(self.format()) as u64
    }

    fn written(&self) -> vk::ImageUsageFlags {
        vk::ImageUsageFlags::STORAGE
    }

    fn most_pictures(&self) -> u32 {
        u32::MAX
    }

    fn prepare(&mut self, _view: &ViewMemory, _rigs: RigKind) -> Result<()> {
        Ok(())
    }

    fn prepared(&self, _rigs: RigKind) -> bool {
        true
    }

    fn allocate(&mut self, size: [u32; 2], count: u32, _lights: &Buffer) -> Result<()> {
        // The old pictures go first, so that the two need not fit together.
        self.image = None;
        let image =
            population::pictures(&self.context, (self.format(), size), count, self.written())?;
        self.made.write_image(0, &image, vk::ImageLayout::GENERAL);
        self.image = Some(image);
        Ok(())
    }

    fn pictures(&self) -> &Image {
        self.image.as_ref().expect("allocated before use")
    }

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        (chunk, count): (&Chunk, u32),
        _rigs: RigKind,
    ) {
        let Source { set, pipeline, first_layer } = self.source.as_ref().expect("what to read");
        let readers = (COMPUTE_READ.0 | COPY_READ.0, COMPUTE_READ.1 | COPY_READ.1);
        let (old, general) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        // The chunk before has been read.
        self.context.transition(cmd, self.pictures(), (old, general), readers, COMPUTE_WRITE);
        let chunk = Chunk { first: first_layer + chunk.first, ..*chunk };
        let [x, y, _] = view.pixel_groups();
        let run = Dispatch {
            pipeline,
            layout: self.layout,
            sets: &[view.set.raw(), *set, self.made.raw()],
            offsets: &[],
            push: push_constants(&chunk),
            groups: [x, y, count],
        };
        self.context.dispatch(cmd, &run);
        let shader = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        self.context.transition(cmd, self.pictures(), (general, shader), COMPUTE_WRITE, readers);
    }
}
