//! Reading a view's images back.

use super::g_buffer::{BASE_COLOR_LAYER, EMISSIVE_LAYER, GBuffer};
use crate::Result;
use crate::gpu::Context;
use crate::gpu::vulkan::commands::{COPY_WRITE, Commands, HOST_READ};
use crate::gpu::vulkan::memory::{Access, Buffer, Image};
use crate::objective::maps::Surface;
use crate::scene::engine::octahedral;
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

/// Reads images of one size through one buffer.
pub struct Reader {
    buffer: Buffer,
    pixels: usize,
    context: Arc<Context>,
}

impl Reader {
    /// For images of this width and height.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, [width, height]: [u32; 2]) -> Result<Self> {
        let pixels = width as usize * height as usize;
        let size = (pixels * size_of::<[f32; 4]>()) as u64;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(context, "readback", size, usage, Access::Readback)?;
        Ok(Self { buffer, pixels, context: Arc::clone(context) })
    }

    /// One entry a pixel of an image in layout `GENERAL`.
    pub fn image<T: Pod>(&self, image: &Image) -> Result<Vec<T>> {
        self.layer(image, 0)
    }

    /// The same of a layer.
    pub fn layer<T: Pod>(&self, image: &Image, layer: u32) -> Result<Vec<T>> {
        Commands::once(&self.context, |cmd| {
            let from = (image, vk::ImageLayout::GENERAL, layer);
            self.context.download(cmd, from, &self.buffer);
            self.context.barrier(cmd, COPY_WRITE, HOST_READ);
            Ok(())
        })?;
        let mut out = vec![T::zeroed(); self.pixels];
        self.buffer.read(&mut out)?;
        Ok(out)
    }

    /// The first three components and the last of a layer.
    fn split(&self, image: &Image, layer: u32) -> Result<(Vec<[f32; 3]>, Vec<f32>)> {
        let texels: Vec<[f32; 4]> = self.layer(image, layer)?;
        Ok(texels.into_iter().map(|[x, y, z, w]| ([x, y, z], w)).unzip())
    }

    /// The surface, and the depth's Sobel length and Laplacian.
    pub fn surface(
        &self,
        g_buffer: &GBuffer,
        [width, height]: [u32; 2],
    ) -> Result<(Surface, Vec<f32>, Vec<f32>)> {
        let (position, roughness) = self.split(&g_buffer.position_roughness, 0)?;
        let (normal, metallic) = self.split(&g_buffer.normal_metallic, 0)?;
        let (base_color, face_x) = self.split(&g_buffer.material, BASE_COLOR_LAYER)?;
        let (emissive, face_y) = self.split(&g_buffer.material, EMISSIVE_LAYER)?;
        let code: Vec<u32> = self.image(&g_buffer.code)?;
        let face = |(&code, at): (&u32, usize)| match code {
            0 => [0.0; 3],
            _ => octahedral([face_x[at], face_y[at]]).to_array(),
        };
        let surface = Surface {
            width,
            height,
            face: code.iter().zip(0..).map(face).collect(),
            code,
            depth: self.image(&g_buffer.depth)?,
            position,
            normal,
            base_color,
            metallic,
            roughness,
            emissive,
        };
        Ok((surface, self.image(&g_buffer.sobel)?, self.image(&g_buffer.laplace)?))
    }
}
