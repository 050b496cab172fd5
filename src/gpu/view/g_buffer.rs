//! The G-buffer: the visible surface of a view, and the maps of its depth.

use super::memory::{image, map};
use crate::Result;
use crate::gpu::Context;
#[cfg(doc)]
use crate::gpu::layout::binding;
use crate::gpu::vulkan::memory::Image;
use ash::vk;
use std::sync::Arc;

/// Layer of a G-buffer's material: linear base colour; x of the polygon's normal, octahedral.
pub const BASE_COLOR_LAYER: u32 = 0;
/// Layer of a G-buffer's material: linear emitted radiance; y of the polygon's normal, octahedral.
pub const EMISSIVE_LAYER: u32 = 1;

/// What the visibility draw or `surface`, and `edges` write. All of the picture's size, in layout `GENERAL`.
pub struct GBuffer {
    /// Colour code, R32_UINT; 0 is the background.
    pub code: Image,
    /// RGBA32_SFLOAT: position in the light frame, scene radii; perceptual roughness.
    pub position_roughness: Image,
    /// RGBA32_SFLOAT: unit normal turned to the viewer; metallic factor.
    pub normal_metallic: Image,
    /// RGBA32_SFLOAT in layers: [`BASE_COLOR_LAYER`] and [`EMISSIVE_LAYER`].
    pub material: Image,
    /// R32_SFLOAT: distance along the view axis.
    pub depth: Image,
    /// R32_SFLOAT: length of the depth's Sobel pair.
    pub sobel: Image,
    /// R32_SFLOAT: the depth's Laplacian.
    pub laplace: Image,
}

impl GBuffer {
    /// Its images, whose surface is written as `written` says; their layouts are undefined.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(
        context: &Arc<Context>,
        size: [u32; 2],
        written: vk::ImageUsageFlags,
    ) -> Result<Self> {
        let usage = written
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let vec4 = vk::Format::R32G32B32A32_SFLOAT;
        let surface = |name, format, layers| image(context, size, (name, format, layers), usage);
        let depth_map = |name| map(context, size, name, vk::Format::R32_SFLOAT);
        Ok(Self {
            code: surface("code", vk::Format::R32_UINT, None)?,
            position_roughness: surface("position, roughness", vec4, None)?,
            normal_metallic: surface("normal, metallic", vec4, None)?,
            material: surface("material", vec4, Some(2))?,
            depth: depth_map("depth")?,
            sobel: depth_map("sobel")?,
            laplace: depth_map("laplace")?,
        })
    }

    /// What the visibility draw or `surface` writes, in the order of the bindings from [`binding::CODE`] on.
    pub fn surface(&self) -> [&Image; 4] {
        [&self.code, &self.position_roughness, &self.normal_metallic, &self.material]
    }

    /// What `edges` writes.
    pub fn depth_maps(&self) -> [&Image; 3] {
        [&self.depth, &self.sobel, &self.laplace]
    }

    /// Every image.
    pub fn images(&self) -> [&Image; 7] {
        let ([a, b, c, d], [e, f, g]) = (self.surface(), self.depth_maps());
        [a, b, c, d, e, f, g]
    }
}
