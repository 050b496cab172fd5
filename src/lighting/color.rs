//! Colours of lights.

use crate::math::color::{luminance, of_hex, srgb_decode, srgb_encode};
use glam::{DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Colour temperatures that a light can have, kelvin.
pub const KELVIN: RangeInclusive<f32> = 1000.0..=40_000.0;

/// The colour of a light without its strength: linear RGB (Rec. 709 primaries) of luminance 1, so that an
/// intensity says the same of every colour.
///
/// As text it is a temperature, `5600K`, or an sRGB colour, `#ffddaa`, whose brightness does not count. Any
/// other colour is written as the sRGB one nearest to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Color {
    linear: [f32; 3],
    /// The temperature that it was made of.
    kelvin: Option<f32>,
}

impl Color {
    /// White: that of sRGB, D65.
    pub const WHITE: Self = Self { linear: [1.0; 3], kelvin: None };

    /// The colour of linear RGB, whatever its luminance; `None` for black and for what is negative or not
    /// finite.
    pub fn of_linear(rgb: [f32; 3]) -> Option<Self> {
        let [r, g, b] = rgb;
        let valid = rgb.iter().all(|channel| channel.is_finite() && *channel >= 0.0);
        let strength = luminance(Vec3::from(rgb));
        if !valid || !strength.is_normal() {
            return None;
        }
        if r == g && g == b {
            return Some(Self::WHITE); // a quotient might miss 1 by the last bit
        }
        Some(Self { linear: (Vec3::from(rgb) / strength).to_array(), kelvin: None })
    }

    /// The colour of a black body; `None` for a temperature outside [`KELVIN`].
    ///
    /// Planck's law is summed over the CIE 1931 observer in the form of Wyman, Sloan and Shirley, *Simple
    /// Analytic Approximations to the CIE XYZ Color Matching Functions* (2013); the chromaticity is within
    /// 0.0015 of the tables from 2500 K on, and within 0.011 at 1000 K. What lies outside the gamut of sRGB
    /// (blue below 1900 K) is clipped. White is near 6500 K.
    pub fn of_kelvin(kelvin: f32) -> Option<Self> {
        if !KELVIN.contains(&kelvin) {
            return None;
        }
        let rgb = rgb_from_xyz() * black_body(f64::from(kelvin));
        let color = Self::of_linear(rgb.max(DVec3::ZERO).as_vec3().to_array())?;
        Some(Self { kelvin: Some(kelvin), ..color })
    }

    /// Linear RGB of luminance 1.
    pub fn linear(&self) -> [f32; 3] {
        self.linear
    }

    /// Linear RGB whose largest channel is 1, and what it has to be multiplied with to be
    /// [`Color::linear`].
    pub fn scaled(&self) -> ([f32; 3], f32) {
        let largest = Vec3::from(self.linear).max_element();
        ((Vec3::from(self.linear) / largest).to_array(), largest)
    }

    /// The brightest sRGB colour of this hue, `#rrggbb`.
    pub fn hex(&self) -> String {
        let (rgb, _) = self.scaled();
        let [r, g, b] = rgb.map(|channel| (255.0 * srgb_encode(channel)).round() as u8);
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

impl Default for Color {
    fn default() -> Self {
        Self::WHITE
    }
}

impl Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kelvin {
            Some(kelvin) => write!(f, "{kelvin}K"),
            None => f.write_str(&self.hex()),
        }
    }
}

impl FromStr for Color {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if let Some(number) = text.strip_suffix(['K', 'k']) {
            let (least, most) = (KELVIN.start(), KELVIN.end());
            let kelvin = number.trim().parse().ok().and_then(Self::of_kelvin);
            return kelvin
                .ok_or_else(|| format!("'{text}' is not a temperature of {least} to {most} K"));
        }
        let fault = || format!("'{text}' is neither a temperature (5600K) nor a colour (#ffddaa)");
        let channels = of_hex(text).ok_or_else(fault)?;
        Self::of_linear(channels.map(|channel| srgb_decode(f32::from(channel) / 255.0)))
            .ok_or_else(|| format!("'{text}' is black: a light needs a colour"))
    }
}

text_form!(Color);

/// Linear Rec. 709 RGB of CIE 1931 XYZ (IEC 61966-2-1), white at D65.
fn rgb_from_xyz() -> DMat3 {
    DMat3::from_cols_array_2d(&[
        [3.240_454_2, -0.969_266_0, 0.055_643_4],
        [-1.537_138_5, 1.876_010_8, -0.204_025_9],
        [-0.498_531_4, 0.041_556_0, 1.057_225_2],
    ])
}

/// CIE 1931 XYZ of a black body of that temperature, with a sum of 1.
fn black_body(kelvin: f64) -> DVec3 {
    /// Second radiation constant, nm·K.
    const C2: f64 = 1.438_776_877e7;
    const STEP: usize = 5;
    let xyz: DVec3 = (360..=830)
        .step_by(STEP)
        .map(|nanometres| {
            let length = f64::from(nanometres);
            observer(length) / (length.powi(5) * (C2 / (length * kelvin)).exp_m1())
        })
        .sum();
    xyz / xyz.element_sum()
}

/// The CIE 1931 colour matching functions at a wavelength in nanometres.
fn observer(length: f64) -> DVec3 {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let width = if length < middle { below } else { above };
        height * (-0.5 * ((length - middle) / width).powi(2)).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0)
            + lobe(0.362, 442.0, 16.0, 26.7)
            + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn temperatures_lie_on_the_planckian_locus() {
        // Wyszecki and Stiles, Color Science (1982), table 1(3.11); 2856 K is CIE illuminant A.
        for (kelvin, x, y, error) in [
            (1000.0, 0.6528, 0.3444, 0.011),
            (2000.0, 0.5267, 0.4133, 0.003),
            (2856.0, 0.4476, 0.4074, 0.0015),
            (4000.0, 0.3805, 0.3768, 0.0015),
            (5000.0, 0.3451, 0.3516, 0.0015),
            (6500.0, 0.3135, 0.3237, 0.0015),
            (10_000.0, 0.2807, 0.2884, 0.0015),
            (20_000.0, 0.2565, 0.2577, 0.0015),
        ] {
            let found = black_body(kelvin);
            let off = DVec3::new(x, y, 1.0 - x - y) - found;
            assert!(off.x.abs() < error && off.y.abs() < error, "{kelvin} K: {found}");
        }
        let color = Color::of_kelvin(6500.0).unwrap().linear();
        assert!(color.iter().all(|channel| (channel - 1.0).abs() < 0.05), "{color:?}");
    }

    #[test]
    fn texts_are_temperatures_and_srgb_colours() {
        let parse = |text: &str| text.parse::<Color>();
        assert_eq!(parse("#ffffff"), Ok(Color::WHITE));
        assert_eq!(parse("#808080"), Ok(Color::WHITE));
        let warm = parse("#ffddaa").unwrap();
        let (rgb, factor) = warm.scaled();
        let expected = [1.0, 0.723_055, 0.401_978];
        assert!(rgb.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{rgb:?}");
        assert!((factor * rgb[1] - warm.linear()[1]).abs() < 1e-6);
        assert_eq!(warm.to_string(), "#ffddaa");
        assert_eq!(parse(" 5600k ").unwrap().to_string(), "5600K");
        assert_eq!(parse("2856.5K").unwrap().to_string(), "2856.5K");
        for text in [
            "", "K", "999K", "40001K", "nanK", "#fff", "#gggggg", "#+fffff", "#000000", "red",
            "5600",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn every_colour_has_luminance_one_and_comes_back_from_text(rgb: [u8; 3]) {
            prop_assume!(rgb != [0; 3]);
            let [r, g, b] = rgb;
            let color: Color = format!("#{r:02x}{g:02x}{b:02x}").parse().unwrap();
            prop_assert!((luminance(Vec3::from(color.linear())) - 1.0).abs() < 1e-5);
            let again: Color = color.to_string().parse().unwrap();
            prop_assert_eq!(again.to_string(), color.to_string());
            let dark = Color::of_linear(color.linear().map(|channel| channel * 1e-3)).unwrap();
            let off = (Vec3::from(dark.linear()) - Vec3::from(color.linear())).abs().max_element();
            prop_assert!(off < 1e-5 * Vec3::from(color.linear()).max_element());
        }
    }
}
