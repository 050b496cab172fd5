//! Images and their mip chains.

use super::budget::{self, Budget};
use super::extensions::Extensions;
use super::files::Buffer;
use super::glossiness::{Conversion, Part};
use super::picture::Picture;
use super::resources::Resources;
use super::views::view_bytes;
use super::{Parsed, label, quoted, warn};
use crate::scene::mips::{MAX_PIXELS, mips};
use crate::scene::{Material, Texture, TextureRef, Wrap};
use gltf::json::Root;
use rayon::prelude::*;
use std::borrow::Cow;

/// Most bytes that images may read of the file's buffers, for each that these have.
const READS_OF_BYTES: u64 = 16;

/// An image as a material uses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// What it shows.
    pub content: Content,
    /// Whether RGB is sRGB-encoded.
    pub srgb: bool,
    /// Horizontal and vertical wrap.
    pub wrap: [Wrap; 2],
}

/// What a texture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// The glTF image of that index.
    Image(usize),
    /// A part of what is made by the conversion of that index.
    Converted(usize, Part),
}

impl Content {
    /// Indices of its images.
    fn images(self, conversions: &[Conversion]) -> [Option<usize>; 2] {
        match self {
            Self::Image(image) => [Some(image), None],
            Self::Converted(index, _) => [conversions[index].diffuse, conversions[index].specular],
        }
    }
}

/// The file that images are read from.
pub struct Source<'a, 'r> {
    /// Its content.
    pub root: &'a Root,
    /// What its extensions say.
    pub extensions: &'a Extensions,
    /// Its buffers.
    pub buffers: &'a [Buffer],
    /// What its URIs name.
    pub resources: &'a mut Resources<'r>,
    /// What [`Content::Converted`] names.
    pub conversions: &'a [Conversion],
}

/// Decodes what `keys` name, each image once, and builds the mip chains. `None`, with a warning, stands for
/// what cannot be decoded, unless the file requires the extension that such an image needs.
pub fn load(
    source: Source,
    keys: &[Key],
    budget: &Budget,
    warnings: &mut Vec<String>,
) -> Parsed<Vec<Option<Texture>>> {
    let Source { root, extensions, buffers, resources, conversions } = source;
    let used = || keys.iter().flat_map(|key| key.content.images(conversions)).flatten();
    let mut images: Vec<usize> = used().collect();
    images.sort_unstable();
    images.dedup();
    let mut pictures = Vec::with_capacity(images.len());
    let mut pixels = 0;
    let mut sum = [0; 2];
    let mut unread = READS_OF_BYTES * buffers.iter().map(Buffer::len).sum::<u64>();
    for &image in &images {
        let name = |fault| format!("{}: {fault}", image_label(root, image));
        let bytes = encoded(root, buffers, resources, image, &mut unread).map_err(name)?;
        let picture = Picture::of(bytes).and_then(budget::check_claim);
        if let Ok(picture) = &picture {
            let [width, height] = picture.size().map_err(name)?;
            let uses = used().filter(|&other| other == image).count() as u64;
            let texels = u64::from(width) * u64::from(height);
            sum = [sum[0] + texels, sum[1] + picture.bytes().len() as u64];
            budget.check_texels(sum[0], sum[1])?;
            // As decoded, as bytes of RGBA, and with the mip levels of each use.
            budget.take(4 * texels * (uses + 2))?;
            pixels += texels * (uses + 1);
        }
        if pixels > MAX_PIXELS {
            return Err(format!("the images have more than {MAX_PIXELS} pixels together"));
        }
        pictures.push(picture);
    }
    let decode = |picture: Parsed<Picture>| {
        let picture = picture.map_err(|fault| (fault, None))?;
        picture.decode().map_err(|fault| (fault, picture.extension()))
    };
    let decoded: Vec<_> = pictures.into_par_iter().map(decode).collect();
    for (&image, result) in images.iter().zip(&decoded) {
        let Err((fault, extension)) = result else { continue };
        let label = image_label(root, image);
        match extension.filter(|&extension| extensions.required.contains(extension)) {
            Some(extension) => {
                return Err(format!("{label}: {fault}, and the file requires {extension}"));
            }
            None => warn(warnings, format!("{label} is left out: {fault}")),
        }
    }
    let level = |image: usize| {
        let at = images.partition_point(|&other| other < image);
        decoded[at].as_ref().ok()
    };
    let texture = |key: &Key| {
        let (name, full) = match key.content {
            Content::Image(image) => {
                (label(root.images[image].name.as_deref()), level(image)?.clone())
            }
            Content::Converted(index, part) => {
                let [diffuse, specular] =
                    key.content.images(conversions).map(|i| i.and_then(level));
                (String::new(), conversions[index].level(diffuse, specular, part))
            }
        };
        Some(Texture { name, srgb: key.srgb, wrap: key.wrap, levels: mips(full, key.srgb) })
    };
    Ok(keys.par_iter().map(texture).collect())
}

/// The textures that could be decoded; materials use them by their new numbers, and their factors instead of
/// the others.
pub fn give(textures: Vec<Option<Texture>>, materials: &mut [Material]) -> Vec<Texture> {
    let mut count = 0;
    let number = |texture: &Option<Texture>| {
        let number = texture.is_some().then_some(count);
        count += u32::from(texture.is_some());
        number
    };
    let numbers: Vec<Option<u32>> = textures.iter().map(number).collect();
    for material in materials {
        for texture in [
            &mut material.base_color_texture,
            &mut material.metallic_roughness_texture,
            &mut material.normal_texture,
            &mut material.emissive_texture,
        ] {
            *texture = texture.and_then(|used| {
                Some(TextureRef { texture: numbers[used.texture as usize]?, ..used })
            });
        }
    }
    textures.into_iter().flatten().collect()
}

/// An image for messages.
fn image_label(root: &Root, image: usize) -> String {
    let json = &root.images[image];
    let name = json.name.as_deref().or(json.uri.as_deref().filter(|uri| !uri.starts_with("data:")));
    name.map_or(format!("image {image}"), |name| format!("image {image} {}", quoted(name)))
}

/// An image as it is stored; of the buffers, `unread` bytes may still be read.
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
