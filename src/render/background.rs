//! What stands behind the objects.

use crate::math::color::{luminance, of_hex, srgb_decode, srgb_encode};
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display};
use std::str::FromStr;

/// Colour behind the objects in pictures of the lit scene: dark enough for bright outlines, bright enough for
/// dark ones.
pub const BACKGROUND: [u8; 3] = [58, 60, 66];

/// A background; as text it is an sRGB colour, `#3a3c42`, or `transparent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Background {
    /// An sRGB colour.
    Color([u8; 3]),
    /// Nothing: alpha is the share of a pixel that the object covers.
    Transparent,
}

impl Background {
    /// Linear colour and alpha of a pixel of which an object of that linear colour covers the share
    /// `coverage`. Alpha is straight.
    pub(super) fn behind(self, object: Vec3, coverage: f32) -> Vec4 {
        match self {
            Self::Transparent => object.extend(coverage),
            Self::Color(color) => linear(color).lerp(object, coverage).extend(1.0),
        }
    }

    /// sRGB-encoded luminance of a colour, as [`Objective::background`](crate::objective::Objective::background)
    /// takes it; none where the background is transparent.
    pub fn luminance(self) -> Option<f32> {
        match self {
            Self::Transparent => None,
            Self::Color(color) => Some(srgb_encode(luminance(linear(color)).min(1.0))),
        }
    }
}

fn linear(color: [u8; 3]) -> Vec3 {
    color.map(|byte| srgb_decode(f32::from(byte) / 255.0)).into()
}

impl Default for Background {
    fn default() -> Self {
        Self::Color(BACKGROUND)
    }
}

impl Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color([r, g, b]) => write!(f, "#{r:02x}{g:02x}{b:02x}"),
            Self::Transparent => f.write_str("transparent"),
        }
    }
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == "transparent" {
            return Ok(Self::Transparent);
        }
        let fault = || format!("'{text}' is neither an sRGB colour (#3a3c42) nor transparent");
        of_hex(text).map(Self::Color).ok_or_else(fault)
    }
}

text_form!(Background);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_colours_or_transparent() {
        for text in ["#3a3c42", "#000000", "#ffffff", "transparent"] {
            assert_eq!(text.parse::<Background>().map(String::from), Ok(text.into()));
        }
        assert_eq!(Background::default().to_string(), "#3a3c42");
        for text in ["", "#fff", "white", "#gg0000", "#+12345", "3a3c42", "Transparent"] {
            assert!(text.parse::<Background>().is_err(), "{text}");
        }
    }

    #[test]
    fn colours_have_a_luminance() {
        let luminance = |text: &str| text.parse::<Background>().unwrap().luminance();
        assert_eq!((luminance("transparent"), luminance("#000000")), (None, Some(0.0)));
        for (text, expected) in [("#ffffff", 1.0), ("#808080", 128.0 / 255.0), ("#00ff00", 0.8622)]
        {
            let found = luminance(text).unwrap();
            assert!((found - expected).abs() < 1e-3 && found <= 1.0, "{text}: {found}");
        }
    }

    #[test]
    fn coverage_mixes_in_linear_light_or_is_the_alpha() {
        let red = Vec3::X;
        assert_eq!(Background::Transparent.behind(red, 0.25), Vec4::new(1.0, 0.0, 0.0, 0.25));
        let white = Background::Color([255; 3]);
        assert!(white.behind(red, 0.25).abs_diff_eq(Vec4::new(1.0, 0.75, 0.75, 1.0), 1e-6));
        assert_eq!(white.behind(red, 1.0), Vec4::new(1.0, 0.0, 0.0, 1.0));
    }
}
