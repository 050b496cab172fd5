//! An engine's own picture as klieg's.

use crate::math::color::{luminance, srgb_decode, srgb_encode};
use crate::objective::maps::{Maps, PixelType};
use crate::scene::engine::{PictureChannels, PictureEncoding, PictureFormat};
use glam::Vec3;

/// The picture `I` that is judged: sRGB-encoded luminance 0..=1, 0 in the background, one entry a
/// pixel, rows from the top. `texels` are as they come out of a texel fetch.
pub fn picture(maps: &Maps, texels: &[[f32; 4]], format: PictureFormat) -> Vec<f32> {
    let pixels = maps.types.iter().zip(texels);
    let brightness = |(&kind, texel): (&PixelType, &[f32; 4])| match kind {
        PixelType::Background => 0.0,
        _ => brightness(*texel, format),
    };
    pixels.map(brightness).collect()
}

/// `sRGB(clamp(Y, 0, 1))` with the luminance `Y` of a texel, of which what is negative or not a number
/// counts as 0.
fn brightness(texel: [f32; 4], format: PictureFormat) -> f32 {
    // `max` gives the other operand for what is not a number. Infinity makes white.
    let [r, g, b, _] = texel.map(|channel| channel.max(0.0));
    let linear = |channel: f32| match format.encoding {
        PictureEncoding::Linear => channel,
        PictureEncoding::Encoded => srgb_decode(channel.min(1.0)),
    };
    match (format.channels, format.encoding) {
        (PictureChannels::Red, PictureEncoding::Encoded) => r.min(1.0),
        (PictureChannels::Red, PictureEncoding::Linear) => srgb_encode(r),
        (PictureChannels::Rgb, _) => {
            srgb_encode(luminance(Vec3::new(linear(r), linear(g), linear(b))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENCODED: PictureEncoding = PictureEncoding::Encoded;
    const LINEAR: PictureEncoding = PictureEncoding::Linear;

    #[test]
    fn every_format_gives_the_encoded_luminance() {
        let of =
            |encoding, channels, texel| brightness(texel, PictureFormat { encoding, channels });
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} {b}");
        let (rgb, red) = (PictureChannels::Rgb, PictureChannels::Red);
        let color = [0.2, 0.5, 0.8, 0.3];
        close(of(ENCODED, red, color), 0.2);
        close(of(LINEAR, red, color), srgb_encode(0.2));
        close(of(ENCODED, rgb, [0.4, 0.4, 0.4, 1.0]), 0.4);
        let y = 0.2126 * 0.2 + 0.7152 * 0.5 + 0.0722 * 0.8;
        close(of(LINEAR, rgb, color), srgb_encode(y));
        let decoded = color.map(srgb_decode);
        close(of(ENCODED, rgb, color), of(LINEAR, rgb, decoded));
        // Only the luminance is clamped, not the colour.
        close(of(LINEAR, rgb, [2.0, 0.0, 0.0, 1.0]), srgb_encode(0.4252));
    }

    #[test]
    fn impossible_texels_stay_in_range() {
        for channels in [PictureChannels::Rgb, PictureChannels::Red] {
            for encoding in [ENCODED, LINEAR] {
                let of = |v| brightness([v; 4], PictureFormat { encoding, channels });
                assert_eq!([of(f32::NAN), of(-1.0), of(f32::NEG_INFINITY)], [0.0; 3]);
                for large in [of(f32::INFINITY), of(f32::MAX), of(1.5)] {
                    assert!((large - 1.0).abs() < 1e-6, "{large}");
                }
            }
        }
        let one = |v| brightness([v, 0.0, 0.0, 1.0], PictureFormat::default());
        assert!((one(f32::INFINITY) - 1.0).abs() < 1e-6);
    }
}
