//! Animated PNG files (PNG, third edition, 11.3.6).

use image::RgbaImage;
use png::{BitDepth, BlendOp, ColorType, DisposeOp, Encoder, EncodingError};

/// Pictures that stand side by side, all of one size.
pub type Frame = [RgbaImage; 2];

/// Pixels between the two, which are transparent.
const GAP: u32 = 8;

/// The bytes of an animation of frames, of so many seconds each, that goes on for ever.
///
/// # Errors
/// When the pictures are too large for PNG.
pub fn beside(frames: &[Frame], seconds: f32) -> Result<Vec<u8>, EncodingError> {
    let (width, height) = frames.first().map_or((0, 0), |[first, _]| first.dimensions());
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, 2 * width + GAP, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay((1e3 * seconds).round() as u16, 1000)?;
    encoder.set_blend_op(BlendOp::Source)?;
    encoder.set_dispose_op(DisposeOp::None)?;
    let mut writer = encoder.write_header()?;
    for [left, right] in frames {
        let mut both = RgbaImage::new(2 * width + GAP, height);
        image::imageops::replace(&mut both, left, 0, 0);
        image::imageops::replace(&mut both, right, i64::from(width + GAP), 0);
        writer.write_image_data(&both)?;
    }
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::png::PngDecoder;
    use image::{AnimationDecoder, ImageDecoder, Rgba};
    use std::io::Cursor;

    #[test]
    fn frames_stand_side_by_side_one_after_another() {
        let plain = |red| RgbaImage::from_pixel(5, 3, Rgba([red, 7, 9, 255]));
        let frames = [[plain(0), plain(100)], [plain(50), plain(150)], [plain(60), plain(160)]];
        let bytes = beside(&frames, 0.25).unwrap();
        let decoder = PngDecoder::new(Cursor::new(&bytes)).unwrap();
        assert_eq!(decoder.dimensions(), (10 + GAP, 3));
        let read = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), 3);
        for (read, [left, right]) in read.iter().zip(&frames) {
            assert_eq!(read.delay().numer_denom_ms(), (250, 1));
            let read = read.buffer();
            assert_eq!(read.get_pixel(4, 2), left.get_pixel(4, 2));
            assert_eq!(read.get_pixel(5 + GAP, 0), right.get_pixel(0, 0));
            assert_eq!(read.get_pixel(6, 1).0[3], 0);
        }
    }
}
