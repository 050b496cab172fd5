//! From linear radiance to what a display can show.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// How radiance becomes a displayable colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum ToneMapping {
    /// Every channel is clamped to 0..1, as the search judges pictures.
    #[default]
    None,
    /// Khronos PBR Neutral: base colours stay as they are, highlights are compressed.
    Neutral,
}

impl ToneMapping {
    /// The displayable colour of a non-negative radiance, linear RGB of 0..1.
    pub fn apply(self, radiance: Vec3) -> Vec3 {
        match self {
            Self::None => radiance,
            Self::Neutral => neutral(radiance),
        }
        .clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Radiance that no display tells from a greater one; it keeps what follows finite.
const MOST: f32 = 1e6;

/// The Khronos PBR Neutral tone mapper (specification of 2024, `KhronosGroup/ToneMapping`), whose letters
/// these are.
fn neutral(radiance: Vec3) -> Vec3 {
    const F90: f32 = 0.04;
    const K_S: f32 = 0.8 - F90;
    const K_D: f32 = 0.15;
    let color = radiance.clamp(Vec3::ZERO, Vec3::splat(MOST));
    let x = color.min_element();
    let f = if x <= 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let color = color - f;
    let p = color.max_element();
    if p <= K_S {
        return color;
    }
    let p_n = 1.0 - (1.0 - K_S).powi(2) / (p + 1.0 - 2.0 * K_S);
    let g = 1.0 / (K_D * (p - p_n) + 1.0);
    color * (p_n / p * g) + Vec3::splat(p_n * (1.0 - g))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_has_the_values_of_the_specification() {
        // Computed from the specification's formulas in double precision, apart from this program.
        for (color, expected) in REFERENCE {
            let found = ToneMapping::Neutral.apply(color.into());
            assert!(found.abs_diff_eq(expected.into(), 2e-6), "{color:?}: {found}");
        }
    }

    #[test]
    fn no_mapping_clamps_and_whatever_is_given_stays_displayable() {
        let none = ToneMapping::None;
        assert_eq!(none.apply(Vec3::new(0.2, 1.0, 7.0)), Vec3::new(0.2, 1.0, 1.0));
        for mapping in [none, ToneMapping::Neutral] {
            for value in [0.0, 1e-30, 3e5, f32::MAX, f32::INFINITY] {
                let found = mapping.apply(Vec3::new(value, 0.0, 0.5 * value));
                assert!(found.is_finite() && found.min_element() >= 0.0, "{value} {found}");
                assert!(found.max_element() <= 1.0, "{value} {found}");
            }
        }
    }

    /// Colours and what they become.
    const REFERENCE: [([f32; 3], [f32; 3]); 9] = [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([0.05, 0.05, 0.05], [0.015625, 0.015625, 0.015625]),
        ([0.5, 0.5, 0.5], [0.46, 0.46, 0.46]),
        ([0.8, 0.3, 0.1], [0.76, 0.26, 0.06]),
        ([0.9, 0.02, 0.0], [0.848421, 0.025223, 0.006514]),
        ([1.0, 1.0, 1.0], [0.869091, 0.869091, 0.869091]),
        ([2.0, 1.0, 0.5], [0.96, 0.534091, 0.321136]),
        ([10.0, 10.0, 10.0], [0.993898, 0.993898, 0.993898]),
        ([40.0, 2.0, 0.03], [0.998540, 0.859903, 0.852715]),
    ];
}
