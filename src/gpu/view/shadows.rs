//! Shadows on the device: the view's shadow table, the occluders, and the stage `shadows`, which makes the
//! one of the other by rays. A table that the host has made is uploaded.

use super::memory::{PIXEL_GROUP, ViewMemory, Written};
use crate::gpu::Context;
use crate::gpu::layout::Chunk;
use crate::gpu::shaders;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE, COPY_WRITE, Commands, HOST_READ};
use crate::gpu::vulkan::memory::{Access, Buffer, Image, ImageDesc};
use crate::gpu::vulkan::pipeline::{DescriptorSet, Pipeline};
use crate::gpu::vulkan::staging::Uploader;
use crate::objective::shadows::{ShadowSettings, Shadows, words};
use crate::scene::occluders::Occluders;
use crate::{Error, Result};
use ash::vk;
use glam::Mat4;
use std::ops::Range;
use std::sync::Arc;

/// Most rays of one submission. Slow GPUs take about a second for them; drivers take a submission of several
/// for a hang, and reset the device.
const SUBMISSION_RAYS: u64 = 1 << 25;

const FORMAT: vk::Format = vk::Format::R32_UINT;
const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::STORAGE.as_raw()
        | vk::ImageUsageFlags::SAMPLED.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw()
        | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// What shadows a view has.
#[derive(Clone, Copy)]
pub struct Casting<'a> {
    /// What casts them.
    pub occluders: &'a Arc<Occluders>,
    /// Directions along a side of the octahedral map.
    pub side: u32,
}

/// The shadow table of a view and the occluders. Without shadows the table is of a single texel, and what is
/// bound is never read.
pub struct ShadowMemory {
    /// Directions along a side of the octahedral map; 0 without shadows.
    pub side: u32,
    /// The table: a layer of the picture's size for each word of a pixel, in layout `GENERAL`.
    pub table: Image,
    /// The occluders' frame from the light frame, which an engine's commands may update.
    pub frame: Buffer,
    /// Nodes, triangles and opacity; none where the device's buffers cannot hold them.
    occluders: Option<[Buffer; 3]>,
}

impl ShadowMemory {
    /// # Errors
    /// [`Error::Unsupported`] for a table that is more than an image can be, and
    /// [device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        size: [u32; 2],
        casting: Option<Casting<'_>>,
    ) -> Result<Self> {
        let side = casting.map_or(0, |casting| casting.side);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST;
        let identity = [Mat4::IDENTITY.to_cols_array()];
        let traced = casting.filter(|casting| fit(context, casting.occluders));
        Ok(Self {
            side,
            table: table(context, size, side)?,
            frame: Buffer::of(context, "occluders' frame", &identity, usage)?,
            occluders: traced.map(|casting| upload(context, casting.occluders)).transpose()?,
        })
    }

    /// Whether shaders can trace rays.
    pub fn is_traceable(&self) -> bool {
        self.occluders.is_some()
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let occluders = self.occluders.iter().flatten().map(Buffer::bytes).sum::<u64>();
        self.table.bytes() + self.frame.bytes() + occluders
    }

    /// Puts all that shaders read at five bindings from `first` on: table, nodes, triangles, opacity, frame.
    /// The set must not be in use.
    pub fn write(&self, set: &mut DescriptorSet, first: u32) {
        set.write_image(first, &self.table, vk::ImageLayout::GENERAL);
        for (number, at) in (first + 1..).zip(0..3) {
            let buffer = self.occluders.as_ref().map_or(&self.frame, |occluders| &occluders[at]);
            set.write_buffer(number, buffer);
        }
        set.write_buffer(first + 4, &self.frame);
    }

    /// Uploads a table that the host has made.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn upload(&self, context: &Arc<Context>, shadows: &Shadows) -> Result<()> {
        let pixels = pixels(&self.table);
        let (bytes, usage) = (4 * pixels as u64, vk::BufferUsageFlags::TRANSFER_SRC);
        let mut staging = Buffer::new(context, "shadow upload", bytes, usage, Access::Upload)?;
        let mut layer = vec![0u32; pixels];
        for word in 0..words(self.side) {
            for (at, texel) in layer.iter_mut().enumerate() {
                *texel = shadows.number(at).map_or(0, |number| shadows.word(number, word));
            }
            staging.write(&layer)?;
            Commands::once(context, |cmd| {
                context.upload(cmd, &staging, (&self.table, word as u32));
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Reads the table back into `shadows`, which is of the same view and side.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn read(&self, context: &Arc<Context>, shadows: &mut Shadows) -> Result<()> {
        let pixels = pixels(&self.table);
        let (bytes, usage) = (4 * pixels as u64, vk::BufferUsageFlags::TRANSFER_DST);
        let staging = Buffer::new(context, "shadow readback", bytes, usage, Access::Readback)?;
        let mut layer = vec![0u32; pixels];
        for word in 0..words(self.side) {
            Commands::once(context, |cmd| {
                let from = (&self.table, vk::ImageLayout::GENERAL, word as u32);
                context.download(cmd, from, &staging);
                context.barrier(cmd, COPY_WRITE, HOST_READ);
                Ok(())
            })?;
            staging.read(&mut layer)?;
            for (at, &texel) in layer.iter().enumerate() {
                if let Some(number) = shadows.number(at) {
                    *shadows.word_mut(number, word) = texel;
                }
            }
        }
        Ok(())
    }
}

/// The side of the table of a view: what the settings' memory allows for all pixels of the picture, and what
/// the device's images can be.
///
/// # Errors
/// [Device errors](crate::Error::is_device), and as [`ShadowSettings::check`].
pub fn side(
    context: &Context,
    [width, height]: [u32; 2],
    settings: &ShadowSettings,
) -> Result<u32> {
    settings.check()?;
    let largest = context.image_limits(FORMAT, USAGE)?.max_resource_size >> 20;
    let memory = settings.memory.min(u32::try_from(largest).unwrap_or(u32::MAX)).max(1);
    let settings = ShadowSettings { memory, ..*settings };
    Ok(settings.fitting_side(u64::from(width) * u64::from(height)))
}

fn pixels(image: &Image) -> usize {
    let vk::Extent2D { width, height } = image.extent();
    width as usize * height as usize
}

/// Whether the device's buffers can hold the occluders.
pub fn fit(context: &Context, occluders: &Occluders) -> bool {
    let Occluders { nodes, triangles, opacity } = occluders;
    let bytes = [size_of_val(&nodes[..]), size_of_val(&triangles[..]), size_of_val(&opacity[..])];
    let largest = u64::from(context.limits().max_storage_buffer_range);
    bytes.iter().all(|&bytes| bytes as u64 <= largest)
}

/// The occluders in device memory.
fn upload(context: &Arc<Context>, occluders: &Occluders) -> Result<[Buffer; 3]> {
    let parts: [(&str, &[u8]); 3] = [
        ("occluder nodes", bytemuck::cast_slice(&occluders.nodes)),
        ("occluder triangles", bytemuck::cast_slice(&occluders.triangles)),
        ("occluder opacity", bytemuck::cast_slice(&occluders.opacity)),
    ];
    let [a, b, c] =
        parts.map(|(name, bytes)| Buffer::storage(context, name, bytes.len().max(4) as u64));
    let buffers = [a?, b?, c?];
    let mut uploader = Uploader::new(context)?;
    for (buffer, (_, bytes)) in buffers.iter().zip(parts) {
        uploader.buffer(buffer, 0, bytes)?;
    }
    uploader.finish()?;
    Ok(buffers)
}

/// The image of a table of `side`², or a stand-in of a texel for a side of 0; its layout is undefined.
fn table(context: &Arc<Context>, [width, height]: [u32; 2], side: u32) -> Result<Image> {
    let (width, height) = if side == 0 { (1, 1) } else { (width, height) };
    let layers = words(side).max(1) as u32;
    let limits = context.image_limits(FORMAT, USAGE)?;
    let bytes = 4 * u64::from(layers) * u64::from(width) * u64::from(height);
    if layers > limits.max_array_layers || bytes > limits.max_resource_size {
        let largest = limits.max_resource_size;
        return Err(context.unsupported(format!(
            "{bytes} bytes of the shadow table in {layers} layers (an image has {largest} at most): \
             give shadows a smaller side"
        )));
    }
    let (name, layers) = ("shadow table", Some(layers));
    Image::new(
        context,
        &ImageDesc { name, format: FORMAT, width, height, layers, mips: 1, usage: USAGE },
    )
}

/// The stage `shadows`, and the table as its set 1.
pub struct ShadowStage(Pipeline, Written);

impl ShadowStage {
    /// For a view with shadows, and views like it.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where the device's buffers cannot hold the occluders, and
    /// [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        if !view.shadows.is_traceable() {
            return Err(untraceable(context));
        }
        let ([x, y], spirv) = (PIXEL_GROUP, shaders::SHADOWS_COMP);
        let constants = [x, y, view.shadows.side];
        let table = Written::new(context, view, ("shadow words", &[&view.shadows.table]))?;
        let pipeline = Pipeline::compute(context, "shadows", spirv, &table.layout, &constants)?;
        Ok(Self(pipeline, table))
    }

    /// The rows of the picture that each submission is for; none without shadows.
    pub fn submissions(view: &ViewMemory) -> Vec<Range<u32>> {
        if view.shadows.side == 0 {
            return Vec::new();
        }
        let [width, height] = view.size;
        let rows = rows_of_submission(width, view.shadows.side);
        (0..height).step_by(rows as usize).map(|top| top..(top + rows).min(height)).collect()
    }

    /// Records the making of some rows' bits. The G-buffer must be visible to compute shaders; the table is
    /// then.
    pub fn record(
        &self,
        cmd: vk::CommandBuffer,
        context: &Context,
        view: &ViewMemory,
        rows: Range<u32>,
    ) {
        let [x, y] = PIXEL_GROUP;
        let groups =
            [view.size[0].div_ceil(x), (rows.end - rows.start).div_ceil(y), view.shadows.side];
        let rows = Chunk { first: rows.start, ..Chunk::default() };
        view.dispatch_with(cmd, (&self.0, &self.1), groups, &rows);
        context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
    }
}

/// Rows of a picture whose rays are no more than those of a submission, or one.
fn rows_of_submission(width: u32, side: u32) -> u32 {
    let of_row = u64::from(width) * u64::from(side) * u64::from(side);
    (SUBMISSION_RAYS / of_row).max(1) as u32
}

/// The error of a device that cannot trace a scene's rays.
pub fn untraceable(context: &Context) -> Error {
    let largest = context.limits().max_storage_buffer_range;
    context
        .unsupported(format!("storage buffers for the scene's occluders (it has {largest} bytes)"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::lighting::shading::Shading;
    use crate::objective::Objective;
    use crate::scene::occluders::{Node, Triangle};

    /// A triangle above the sphere that tests draw.
    fn occluders() -> Arc<Occluders> {
        let triangle = Triangle {
            corner: [-1.0, 0.5, 1.5],
            opacity: u32::MAX,
            edge1: [2.0, 0.0, 0.0],
            padding1: 0,
            edge2: [0.0, 1.0, -1.5],
            padding2: 0,
        };
        let node = Node { low: [-1.0, 0.5, 0.0], skip: 1, high: [1.0, 1.5, 1.5], triangles: 0 };
        Arc::new(Occluders { nodes: vec![node], triangles: vec![triangle], opacity: Vec::new() })
    }

    #[test]
    fn a_table_in_parts_is_the_whole_table() {
        const SIDE: u32 = 7;
        let context = testing::context();
        let (maps, view) = testing::maps(37, 19);
        let occluders = occluders();
        let expected = cpu::shadows::reference(&maps.surface, Arc::clone(&occluders), SIDE);
        let casting = Some(Casting { occluders: &occluders, side: SIDE });
        let settings = (&Objective::default(), &Shading::default());
        let made = |parts: &[[u32; 2]]| {
            let mut memory =
                ViewMemory::new(&context, &view, settings, Lights::Plain, casting).unwrap();
            let g_buffer = memory.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT).unwrap();
            testing::upload_surface(&context, &maps.surface, g_buffer);
            let stage = ShadowStage::new(&context, &memory).unwrap();
            let object = maps.surface.code.iter().map(|&code| code != 0);
            let mut read = Shadows::new(SIDE, object, Arc::clone(&occluders));
            // Fresh memory may have the bits of another table.
            memory.shadows.upload(&context, &read).unwrap();
            for &[top, end] in parts {
                Commands::once(&context, |cmd| {
                    stage.record(cmd, &context, &memory, top..end);
                    Ok(())
                })
                .unwrap();
            }
            memory.shadows.read(&context, &mut read).unwrap();
            read
        };
        let [whole, parts] = [made(&[[0, 19]]), made(&[[0, 5], [5, 6], [6, 19]])];
        assert!(whole == parts);
        let differ = |(a, b): &(&u32, &u32)| a != b;
        let words = whole.blocks().len();
        assert!(whole.blocks().iter().zip(expected.blocks()).filter(differ).count() * 500 < words);
        assert!(made(&[[0, 5]]) != whole, "a part is missing");
        let darker = expected.openness().iter().filter(|&&open| open < 0.9).count();
        assert!(darker > 20, "{darker}");
        testing::assert_valid(&context);
    }

    #[test]
    fn occluders_that_do_not_fit_are_not_traced() {
        let context = testing::context();
        let (_, view) = testing::maps(8, 8);
        let (occluders, settings) = (occluders(), (&Objective::default(), &Shading::default()));
        let casting = Some(Casting { occluders: &occluders, side: 3 });
        let mut memory =
            ViewMemory::new(&context, &view, settings, Lights::Plain, casting).unwrap();
        assert!(memory.shadows.is_traceable() && ShadowStage::new(&context, &memory).is_ok());
        memory.shadows.occluders = None;
        let fault = ShadowStage::new(&context, &memory).err().map(|fault| fault.to_string());
        assert!(fault.is_some_and(|fault| fault.contains("occluders")));
        testing::assert_valid(&context);
    }

    #[test]
    fn submissions_are_bounded_in_whole_rows() {
        assert_eq!(rows_of_submission(512, 31), 68);
        assert_eq!(rows_of_submission(1920, 31), 18);
        assert_eq!(rows_of_submission(16384, 63), 1);
    }
}
