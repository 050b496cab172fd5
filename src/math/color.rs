//! Colours: luminance and the sRGB encoding.

use crate::constants::{
    self, SRGB_ENCODED_END, SRGB_GAMMA, SRGB_LINEAR_END, SRGB_OFFSET, SRGB_SCALE, SRGB_SLOPE,
};
use glam::Vec3;

/// Rec. 709 luminance weights of linear RGB.
pub const LUMINANCE: Vec3 = Vec3::from_array(constants::LUMINANCE);

/// Rec. 709 luminance of linear RGB.
pub fn luminance(color: Vec3) -> f32 {
    color.dot(LUMINANCE)
}

/// The sRGB encoding (IEC 61966-2-1) of a linear value, clamped to 0..=1.
pub fn srgb_encode(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= SRGB_LINEAR_END {
        SRGB_SLOPE * x
    } else {
        SRGB_SCALE * x.powf(1.0 / SRGB_GAMMA) - SRGB_OFFSET
    }
}

/// The linear value of an sRGB encoding (IEC 61966-2-1).
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= SRGB_ENCODED_END {
        encoded / SRGB_SLOPE
    } else {
        ((encoded + SRGB_OFFSET) / SRGB_SCALE).powf(SRGB_GAMMA)
    }
}

/// Red, green and blue of the text `#rrggbb`, six hexadecimal digits; none of any other text.
pub fn of_hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let [_, rgb @ ..] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some(rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_srgb_curves_invert_each_other() {
        for i in 0..=1000 {
            let x = i as f32 / 1000.0;
            let back = srgb_decode(srgb_encode(x));
            assert!((back - x).abs() < 1e-5, "{x} {back}");
        }
        assert!((srgb_encode(f32::INFINITY) - 1.0).abs() < 1e-6);
        assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-6);
    }
}
