//! The mean brightness that an objective aims at.

use super::maps::ViewStatistics;
use crate::Result;
use crate::constants::{SCENE_MEAN_LEAST, SCENE_MEAN_MOST, SCENE_MEAN_SHARE};
use crate::error::within;
use crate::math::color::srgb_encode;
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Mean brightness aimed at, sRGB-encoded. As text it is a number or the word `scene`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeanTarget {
    /// A given one, 0..=1.
    Value(f32),
    /// Of the scene: see [`MeanTarget::of`].
    Scene,
}

impl MeanTarget {
    /// The brightness aimed at in a view. That of [`MeanTarget::Scene`] is `sRGB(0.5·b)`, kept in
    /// 0.25..=0.72, `b` the mean luminance of the object's base colour: pale things stay pale, and dark
    /// things dark.
    pub fn of(self, view: &ViewStatistics) -> f32 {
        match self {
            Self::Value(value) => value,
            Self::Scene => srgb_encode(SCENE_MEAN_SHARE * view.shape.base_luminance)
                .clamp(SCENE_MEAN_LEAST, SCENE_MEAN_MOST),
        }
    }

    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) for a number outside 0..=1.
    pub fn check(self) -> Result<()> {
        match self {
            Self::Value(value) => within("objective.mean_target", value, 0.0, 1.0),
            Self::Scene => Ok(()),
        }
    }
}

/// How files write [`MeanTarget::Scene`].
const SCENE: &str = "scene";

impl Serialize for MeanTarget {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => serializer.serialize_f32(*value),
            Self::Scene => serializer.serialize_str(SCENE),
        }
    }
}

impl<'de> Deserialize<'de> for MeanTarget {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Word;
        impl Visitor<'_> for Word {
            type Value = MeanTarget;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "a number or \"{SCENE}\"")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<MeanTarget, E> {
                Ok(MeanTarget::Value(value as f32))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<MeanTarget, E> {
                Ok(MeanTarget::Value(value as f32))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<MeanTarget, E> {
                Ok(MeanTarget::Value(value as f32))
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<MeanTarget, E> {
                let fault = || E::invalid_value(de::Unexpected::Str(word), &self);
                (word == SCENE).then_some(MeanTarget::Scene).ok_or_else(fault)
            }
        }
        deserializer.deserialize_any(Word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::maps::Shape;

    #[test]
    fn a_scene_s_target_follows_its_base_colour_within_bounds() {
        let target = |base_luminance| {
            let shape = Shape { base_luminance, ..Shape::default() };
            MeanTarget::Scene.of(&ViewStatistics { shape, ..ViewStatistics::default() })
        };
        // Half of 0.428 is 0.214, which is encoded as 0.5.
        assert!((target(0.428_082) - 0.5).abs() < 1e-5);
        assert_eq!((target(0.0), target(0.05)), (0.25, 0.25));
        assert_eq!((target(0.97), target(1.0)), (0.72, 0.72));
        assert_eq!(MeanTarget::Value(0.9).of(&ViewStatistics::default()), 0.9);
    }

    #[test]
    fn files_say_a_number_or_scene() {
        let read = |text: &str| serde_json::from_str::<MeanTarget>(text);
        assert_eq!(read("0.25").unwrap(), MeanTarget::Value(0.25));
        assert_eq!(read("1").unwrap(), MeanTarget::Value(1.0));
        assert_eq!(read("\"scene\"").unwrap(), MeanTarget::Scene);
        let fault = read("\"object\"").unwrap_err().to_string();
        assert!(fault.contains("a number or \"scene\""), "{fault}");
        for target in [MeanTarget::Value(0.5), MeanTarget::Scene] {
            let text = serde_json::to_string(&target).unwrap();
            assert_eq!(read(&text).unwrap(), target);
        }
        assert!(MeanTarget::Value(-1.0).check().is_err() && MeanTarget::Scene.check().is_ok());
    }
}
