//! Pictures in the formats that glTF knows: PNG, JPEG, WebP (`EXT_texture_webp`) and KTX2 with Basis
//! Universal (`KHR_texture_basisu`), told apart by content.

use super::Parsed;
use super::files;
use super::guard::guarded;
use crate::scene::TextureLevel;
use crate::scene::mips::MAX_SIDE;
use crate::{Error, Result};
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

/// Most bytes that decoding one picture may take.
const MAX_DECODING: u64 = 1 << 30;

/// What a KTX2 file begins with.
pub const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// A picture as it is stored.
pub struct Picture<'a> {
    bytes: Cow<'a, [u8]>,
    format: Format,
    size: [u32; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Format {
    Plain(ImageFormat),
    Ktx2,
}

/// The picture in the file at `path`: PNG, JPEG, WebP or KTX2.
///
/// # Errors
/// [`Error::Input`] for a file that cannot be read, is no such picture, or a broken or too large one.
pub fn read(path: &Path) -> Result<TextureLevel> {
    let fault = |fault: String| Error::input(path, fault);
    let bytes = files::read(path, MAX_DECODING).map_err(fault)?;
    let picture = Picture::of(Cow::Owned(bytes)).map_err(fault)?;
    picture.size().map_err(fault)?;
    picture.decode().map_err(fault)
}

impl<'a> Picture<'a> {
    /// The encoded picture.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Looks at a picture's header.
    pub fn of(bytes: Cow<'a, [u8]>) -> Parsed<Self> {
        let format = format(&bytes)?;
        let size = match format {
            Format::Plain(format) => ImageReader::with_format(Cursor::new(&bytes), format)
                .into_dimensions()
                .map(|(width, height)| [width, height])
                .map_err(|error| format!("it cannot be decoded: {error}"))?,
            Format::Ktx2 => ktx2_size(&bytes)?,
        };
        Ok(Self { bytes, format, size })
    }

    /// Pixels in a row, and rows: at most [`MAX_SIDE`] each.
    pub fn size(&self) -> Parsed<[u32; 2]> {
        let [width, height] = self.size;
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("{width}x{height} pixels; klieg reads at most {MAX_SIDE} a side"));
        }
        Ok(self.size)
    }

    /// The extension that lets glTF have such a picture; `None` where it needs none.
    pub fn extension(&self) -> Option<&'static str> {
        match self.format {
            Format::Plain(ImageFormat::WebP) => Some("EXT_texture_webp"),
            Format::Plain(_) => None,
            Format::Ktx2 => Some("KHR_texture_basisu"),
        }
    }

    /// The picture as RGBA.
    pub fn decode(&self) -> Parsed<TextureLevel> {
        if self.format == Format::Plain(ImageFormat::Jpeg) && !jpeg_is_whole(&self.bytes) {
            return Err("it cannot be decoded: the JPEG is truncated".into());
        }
        guarded(|| match self.format {
            Format::Plain(format) => plain(&self.bytes, format),
            Format::Ktx2 => self.transcoded(),
        })
        .map_err(|fault| format!("it cannot be decoded: {fault}"))
    }

    fn transcoded(&self) -> Parsed<TextureLevel> {
        let fault = |error: basisu::Error| match error {
            basisu::Error::Truncated => "the KTX2 is truncated".to_owned(),
            error => format!("the KTX2 is not Basis Universal or broken ({error:?})"),
        };
        let transcoder = Transcoder::new(&self.bytes).map_err(fault)?;
        let (width, height) = transcoder.base_dimensions();
        if [width, height] != self.size {
            return Err("the KTX2 is inconsistent".into());
        }
        let bytes = transcoder.transcode_image(0, 0, 0, TargetFormat::Rgba32, DecodeFlags::NONE);
        let texels = texels(bytes.map_err(fault)?);
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err("the KTX2 lacks pixels".into());
        }
        Ok(TextureLevel { width, height, texels })
    }
}

fn format(bytes: &[u8]) -> Parsed<Format> {
    if bytes.starts_with(KTX2) {
        return Ok(Format::Ktx2);
    }
    match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => {
            Ok(Format::Plain(format))
        }
        Ok(other) => {
            Err(format!("it is {}, and klieg reads PNG, JPEG, WebP and KTX2", other.to_mime_type()))
        }
        Err(_) => Err("it is neither PNG nor JPEG, WebP or KTX2".into()),
    }
}

fn reader(bytes: &[u8], format: ImageFormat) -> ImageReader<Cursor<&[u8]>> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODING);
    reader.limits(limits);
    reader
}

fn plain(bytes: &[u8], format: ImageFormat) -> Parsed<TextureLevel> {
    let image = reader(bytes, format).decode().map_err(|error| error.to_string());
    let rgba = image.map(DynamicImage::into_rgba8)?;
    let (width, height) = rgba.dimensions();
    Ok(TextureLevel { width, height, texels: texels(rgba.into_raw()) })
}

fn texels(bytes: Vec<u8>) -> Vec<[u8; 4]> {
    bytemuck::allocation::try_cast_vec(bytes)
        .unwrap_or_else(|(_, bytes)| bytes.as_chunks().0.to_vec())
}

/// Width and height in a KTX2's header (KTX 2.0, 3), which must be that of one flat picture of 8 bits a texel
/// at most: the decoder takes it at its word.
fn ktx2_size(bytes: &[u8]) -> Parsed<[u32; 2]> {
    let number = |at: usize, size: usize| {
        let mut number = [0; 8];
        let bytes =
            bytes.get(at..at + size).ok_or("it cannot be decoded: the KTX2 is truncated")?;
        number[..size].copy_from_slice(bytes);
        Parsed::Ok(u64::from_le_bytes(number))
    };
    let word = |at| number(at, 4);
    let (width, height) = (word(20)?, word(24)?);
    let (depth, layers, faces, levels, scheme) =
        (word(28)?, word(32)?, word(36)?, word(40)?, word(44)?);
    let flat = width > 0 && height > 0 && depth == 0 && layers <= 1 && faces == 1;
    if !(flat && levels <= 32 && scheme <= 2) {
        return Err("it cannot be decoded: the KTX2 is no flat picture of Basis Universal".into());
    }
    let most = width.div_ceil(4) * height.div_ceil(4) * 16;
    for level in 0..levels.max(1) {
        // Offset and length in the file, and the length without Zstandard.
        if number(80 + 24 * level as usize + 16, 8)? > most {
            return Err("it cannot be decoded: the KTX2 has more data than pixels".into());
        }
    }
    Ok([width as u32, height as u32])
}

/// Whether a JPEG reaches its end marker: what the decoder lacks, it would make up (ITU T.81, B.1.1).
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(skipped) = bytes.get(at..).and_then(|rest| rest.iter().position(|&b| b == 0xff))
    {
        at += skipped + 1;
        match bytes.get(at) {
            // End of image.
            Some(0xd9) => return true,
            // A stuffed byte, a fill byte, a restart marker, one of an older standard: no segment follows.
            Some(0x00 | 0xff | 0xd0..=0xd8 | 0x01) => {}
            // A segment tells its length; a scan's data follow on it, as far as the next marker.
            Some(_) => match bytes.get(at + 1..at + 3) {
                Some(&[high, low]) => at += 1 + usize::from(u16::from_be_bytes([high, low])),
                _ => return false,
            },
            None => return false,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jpeg() -> Vec<u8> {
        let pixel = |x, y| image::Rgb([(x * 7) as u8, (y * 5) as u8, (x * y) as u8]);
        let image = image::RgbImage::from_fn(40, 30, pixel);
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Jpeg).expect("a JPEG");
        bytes.into_inner()
    }

    #[test]
    fn truncated_jpegs_are_told_from_whole_ones() {
        let whole = jpeg();
        assert!(jpeg_is_whole(&whole));
        let padded = [&whole[..], &[0; 9]].concat();
        assert!(jpeg_is_whole(&padded));
        for end in 0..whole.len() {
            assert!(!jpeg_is_whole(&whole[..end]), "{end}");
        }
        // A thumbnail in a segment has an end of its own.
        let mut with_thumbnail = whole[..2].to_vec();
        with_thumbnail.extend_from_slice(&[0xff, 0xe1, 0, 6, 0xff, 0xd9, 0, 0]);
        with_thumbnail.extend_from_slice(&whole[2..]);
        assert!(jpeg_is_whole(&with_thumbnail));
        assert!(!jpeg_is_whole(&with_thumbnail[..with_thumbnail.len() - 2]));
    }

    #[test]
    fn headers_of_ktx2_are_bounded() {
        let mut bytes = [KTX2, &[0; 92]].concat();
        let mut set =
            |at: usize, value: u32| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        set(20, u32::MAX);
        set(24, 1);
        set(36, 1);
        for length in 0..bytes.len() {
            assert!(Picture::of(bytes[..length].into()).is_err(), "{length}");
        }
        for (at, value) in [(20, 0), (28, 1), (32, 2), (36, 6), (40, 1 << 30), (44, 9), (103, 1)] {
            let mut bytes = bytes.clone();
            for (byte, value) in bytes[at..].iter_mut().zip(u32::to_le_bytes(value)) {
                *byte = value;
            }
            assert!(Picture::of(bytes.into()).is_err(), "{at}");
        }
        let picture = Picture::of(bytes.into()).expect("a header");
        assert!(picture.size().is_err_and(|fault| fault.contains("4294967295x1")));
        assert!(picture.decode().is_err());
    }
}
