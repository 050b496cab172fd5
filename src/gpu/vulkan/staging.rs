//! Uploads through one staging buffer of bounded size, and reading buffers back.

use super::commands::{COPY_WRITE, Commands, HOST_READ};
use super::memory::{Access, Buffer, Image};
use crate::Result;
use crate::gpu::Context;
use crate::scene::TextureLevel;
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

/// Bytes of the staging buffer: many rows of the widest texture that a device may have.
const CAPACITY: usize = 32 << 20;

/// Gathers copies to the device and runs them whenever the staging buffer is full.
pub struct Uploader<'a> {
    context: Arc<Context>,
    staging: Buffer,
    bytes: Vec<u8>,
    copies: Vec<Copy<'a>>,
}

/// A copy out of the staging buffer.
enum Copy<'a> {
    Buffer(&'a Buffer, vk::BufferCopy),
    Image(&'a Image, vk::BufferImageCopy),
}

impl<'a> Uploader<'a> {
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>) -> Result<Self> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let staging = Buffer::new(context, "staging", CAPACITY as u64, usage, Access::Upload)?;
        let bytes = Vec::with_capacity(CAPACITY);
        Ok(Self { context: Arc::clone(context), staging, bytes, copies: Vec::new() })
    }

    /// Puts `data` into `to`, `offset` bytes from its front.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn buffer(&mut self, to: &'a Buffer, mut offset: u64, data: &[u8]) -> Result<()> {
        let mut rest = data;
        while !rest.is_empty() {
            let room = self.room(1)?;
            let (now, later) = rest.split_at(rest.len().min(room));
            let region = vk::BufferCopy::default()
                .src_offset(self.bytes.len() as u64)
                .dst_offset(offset)
                .size(now.len() as u64);
            self.copies.push(Copy::Buffer(to, region));
            self.bytes.extend_from_slice(now);
            offset += now.len() as u64;
            rest = later;
        }
        Ok(())
    }

    /// Puts a picture into a mip level of `to`, which is in layout `GENERAL`.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn level(&mut self, to: &'a Image, mip_level: u32, level: &TextureLevel) -> Result<()> {
        let width = level.width as usize;
        let mut y = 0;
        while y < level.height {
            // Copies to an image start at whole texels.
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            let rows = (self.room(4 * width)? / (4 * width)).min((level.height - y) as usize);
            let region = vk::BufferImageCopy::default()
                .buffer_offset(self.bytes.len() as u64)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    mip_level,
                    base_array_layer: 0,
                    layer_count: 1,
                })
                .image_offset(vk::Offset3D { x: 0, y: y as i32, z: 0 })
                .image_extent(vk::Extent3D { width: level.width, height: rows as u32, depth: 1 });
            self.copies.push(Copy::Image(to, region));
            let texels = &level.texels[y as usize * width..][..rows * width];
            self.bytes.extend_from_slice(bytemuck::cast_slice(texels));
            y += rows as u32;
        }
        Ok(())
    }

    /// Runs the copies that are left.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn finish(mut self) -> Result<()> {
        self.flush()
    }

    /// Bytes that the staging buffer has left, at least `needed`.
    fn room(&mut self, needed: usize) -> Result<usize> {
        if self.bytes.len() + needed > CAPACITY {
            self.flush()?;
        }
        Ok(CAPACITY - self.bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.staging.write(&self.bytes)?;
        let (context, from) = (&self.context, self.staging.raw());
        Commands::once(context, |cmd| {
            for copy in &self.copies {
                // SAFETY: `cmd` is being recorded; the staging buffer holds every region, and the
                // targets, which outlive `self`, were made for them.
                unsafe {
                    match *copy {
                        Copy::Buffer(to, region) => {
                            context.recorder().cmd_copy_buffer(cmd, from, to.raw(), &[region]);
                        }
                        Copy::Image(to, region) => context.recorder().cmd_copy_buffer_to_image(
                            cmd,
                            from,
                            to.raw(),
                            vk::ImageLayout::GENERAL,
                            &[region],
                        ),
                    }
                }
            }
            let readers = (
                vk::PipelineStageFlags::ALL_GRAPHICS,
                vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE,
            );
            context.barrier(cmd, COPY_WRITE, readers);
            Ok(())
        })?;
        self.bytes.clear();
        self.copies.clear();
        Ok(())
    }
}

/// Reads the first `count` elements of a buffer that compute shaders wrote and copies may read.
///
/// # Errors
/// [Device errors](crate::Error::is_device).
pub fn read_buffer<T: Pod>(context: &Arc<Context>, from: &Buffer, count: usize) -> Result<Vec<T>> {
    let mut out = vec![T::zeroed(); count];
    let (size, usage) = (size_of_val(&out[..]) as u64, vk::BufferUsageFlags::TRANSFER_DST);
    context.check_present()?;
    if size == 0 {
        return Ok(out);
    }
    let to = Buffer::new(context, "readback", size, usage, Access::Readback)?;
    Commands::once(context, |cmd| {
        let region = [vk::BufferCopy::default().size(size)];
        // SAFETY: both buffers are alive and hold so many bytes.
        unsafe { context.recorder().cmd_copy_buffer(cmd, from.raw(), to.raw(), &region) };
        context.barrier(cmd, COPY_WRITE, HOST_READ);
        Ok(())
    })?;
    to.read(&mut out)?;
    Ok(out)
}
