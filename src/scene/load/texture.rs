//! Images and their mip chains.

use super::accessor::view_bytes;
use super::budget::{self, Budget};
use super::files::Buffer;
use super::resources::Resources;
use super::{Parsed, label, quoted};
use crate::scene::mips::{MAX_PIXELS, MAX_SIDE, mips};
use crate::scene::{Texture, TextureLevel, Wrap};
use gltf::json::Root;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Cursor;

/// Most bytes that decoding one image may take.
const MAX_DECODING: u64 = 1 << 30;

/// Most bytes that images may read of the file's buffers, for each that these have.
const READS_OF_BYTES: u64 = 16;

/// An image as a material uses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Index of the glTF image.
    pub image: usize,
    /// Whether RGB is sRGB-encoded.
    pub srgb: bool,
    /// Horizontal and vertical wrap.
    pub wrap: [Wrap; 2],
}

/// Decodes what `keys` name, each image once, and builds the mip chains.
pub fn load(
    root: &Root,
    buffers: &[Buffer],
    resources: &mut Resources,
    keys: &[Key],
    budget: &Budget,
) -> Parsed<Vec<Texture>> {
    let mut images: Vec<usize> = keys.iter().map(|key| key.image).collect();
    images.sort_unstable();
    images.dedup();
    let mut sources = Vec::with_capacity(images.len());
    let mut pixels = 0;
    let mut sum = [0; 2];
    let mut unread = READS_OF_BYTES * buffers.iter().map(Buffer::len).sum::<u64>();
    for &image in &images {
        let name = |fault| format!("{}: {fault}", image_label(root, image));
        let bytes = encoded(root, buffers, resources, image, &mut unread).map_err(name)?;
        let (width, height) = dimensions(&bytes).map_err(name)?;
        let uses = keys.iter().filter(|key| key.image == image).count() as u64;
        let texels = u64::from(width) * u64::from(height);
        budget::check_claim(&image_label(root, image), &bytes, [width, height])?;
        sum = [sum[0] + texels, sum[1] + bytes.len() as u64];
        budget.check_texels(sum[0], sum[1])?;
        // As decoded, as bytes of RGBA, and with the mip levels of each use.
        budget.take(4 * texels * (uses + 2))?;
        pixels += texels * (uses + 1);
        if pixels > MAX_PIXELS {
            return Err(format!("the images have more than {MAX_PIXELS} pixels together"));
        }
        sources.push(bytes);
    }
    let decode = |(&image, bytes): (&usize, Cow<[u8]>)| {
        decoded(&bytes).map_err(|fault| format!("{}: {fault}", image_label(root, image)))
    };
    let decoded: Vec<TextureLevel> =
        images.par_iter().zip(sources).map(decode).collect::<Parsed<_>>()?;
    let texture = |key: &Key| {
        let at = images.partition_point(|&image| image < key.image);
        Texture {
            name: label(root.images[key.image].name.as_deref()),
            srgb: key.srgb,
            wrap: key.wrap,
            levels: mips(decoded[at].clone(), key.srgb),
        }
    };
    Ok(keys.par_iter().map(texture).collect())
}

/// An image for messages.
fn image_label(root: &Root, image: usize) -> String {
    let json = &root.images[image];
    let name = json.name.as_deref().or(json.uri.as_deref().filter(|uri| !uri.starts_with("data:")));
    name.map_or(format!("image {image}"), |name| format!("image {image} {}", quoted(name)))
}

/// An image's PNG or JPEG; of the buffers, `unread` bytes may still be read.
fn encoded<'a>(
    root: &Root,
    buffers: &'a [Buffer],
    resources: &mut Resources,
    image: usize,
    unread: &mut u64,
) -> Parsed<Cow<'a, [u8]>> {
    let image = &root.images[image];
    match (&image.uri, image.buffer_view) {
        (_, Some(view)) => view_bytes(root, buffers, view, unread),
        (Some(uri), None) => resources.fetch(uri).map(Cow::Owned),
        (None, None) => Err("it has neither a URI nor a buffer view".into()),
    }
}

/// A reader for PNG or JPEG, told apart by content.
fn reader(bytes: &[u8]) -> Parsed<ImageReader<Cursor<&[u8]>>> {
    let format = image::guess_format(bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg))
        .ok_or("it is neither PNG nor JPEG")?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODING);
    reader.limits(limits);
    Ok(reader)
}

fn dimensions(bytes: &[u8]) -> Parsed<(u32, u32)> {
    let (width, height) = reader(bytes)?
        .into_dimensions()
        .map_err(|error| format!("it cannot be decoded: {error}"))?;
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("{width}x{height} pixels; klieg reads at most {MAX_SIDE} a side"));
    }
    Ok((width, height))
}

fn decoded(bytes: &[u8]) -> Parsed<TextureLevel> {
    let image = reader(bytes)?.decode().map_err(|error| format!("it cannot be decoded: {error}"));
    let rgba = image.map(DynamicImage::into_rgba8)?;
    let (width, height) = rgba.dimensions();
    let texels = bytemuck::allocation::try_cast_vec(rgba.into_raw())
        .unwrap_or_else(|(_, bytes)| bytemuck::pod_collect_to_vec(&bytes));
    Ok(TextureLevel { width, height, texels })
}
