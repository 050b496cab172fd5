//! Textures read back, and written as PNG files.

use crate::Result;
use crate::gpu::Gpu;
use std::path::Path;

/// The bytes of one layer of a texture, row after row from the top.
pub fn read(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Result<Vec<u8>> {
    let aspect = wgpu::TextureAspect::All;
    let texel = texture.format().block_copy_size(Some(aspect)).ok_or("a format without texels")?;
    let row = texture.width() * texel;
    let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(pitch) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let origin = wgpu::Origin3d { z: layer, ..wgpu::Origin3d::ZERO };
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(pitch),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
    );
    gpu.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    gpu.wait()?;
    let bytes = buffer.get_mapped_range(..)?;
    Ok(bytes.chunks_exact(pitch as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

/// Writes a layer of an `Rgba8UnormSrgb` texture, opaque.
pub fn save(gpu: &Gpu, texture: &wgpu::Texture, layer: u32, file: &Path) -> Result<()> {
    let bytes = read(gpu, texture, layer)?;
    let rgb: Vec<u8> = bytes.chunks_exact(4).flat_map(|texel| &texel[..3]).copied().collect();
    image::save_buffer(file, &rgb, texture.width(), texture.height(), image::ColorType::Rgb8)?;
    Ok(())
}
