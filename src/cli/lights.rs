//! Options about lights that several subcommands share.

use crate::Result;
use crate::lighting::kinds::KINDS;
use crate::lighting::{Color, LightKind, Role};
use crate::session::config::Settings;
use crate::session::values::role;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use std::str::FromStr;

/// Colours, and what becomes of the scene's own lights.
#[derive(Debug, Args)]
pub(super) struct LightOptions {
    /// Colour of the lights: a temperature such as 5600K, or an sRGB colour such as '#ffddaa'; with a
    /// role, as in key=3200K, that of its lights alone. Several times for several roles [default: white]
    #[arg(long = "color", visible_alias = "warm", value_name = "[ROLE=]COLOR")]
    colors: Vec<ColorArg>,
    /// Keep the scene's own lights: they count in every score and stay in lit.glb [default: they count
    /// for nothing and are taken out]
    #[arg(long)]
    keep_lights: bool,
}

impl LightOptions {
    /// Puts these options in the place of `settings`.
    ///
    /// # Errors
    /// As [`LightSettings::set_color`].
    pub fn apply(&self, settings: &mut Settings) -> Result<()> {
        settings.lights.keep |= self.keep_lights;
        let lights = &mut settings.lights;
        self.colors.iter().try_for_each(|given| lights.set_color(given.role, given.color))
    }

    /// Whether any colour is given.
    pub fn colored(&self) -> bool {
        !self.colors.is_empty()
    }
}

/// A colour of all lights, or of those of a role.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ColorArg {
    role: Option<Role>,
    color: Color,
}

impl FromStr for ColorArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, color)) => Ok(Self { role: Some(role(name)?), color: color.parse()? }),
            None => Ok(Self { role: None, color: text.parse()? }),
        }
    }
}

/// The names of the kinds of lights.
pub(super) fn kinds() -> impl TypedValueParser<Value = LightKind> {
    let value = |kind: &LightKind| PossibleValue::new(kind.name).help(kind.meaning);
    PossibleValuesParser::new(KINDS.iter().map(value)).try_map(|name| LightKind::named(&name))
}

/// Intensities of each light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Intensities {
    /// One, as lamps have
    One,
    /// A diffuse and a specular one, free of each other
    Two,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::config::LightSettings;

    #[test]
    fn colours_by_role_and_for_all() {
        let mut lights = LightSettings::default();
        for text in ["3200K", "rim=#8080ff"] {
            let ColorArg { role, color } = text.parse().unwrap();
            lights.set_color(role, color).unwrap();
        }
        let boxes = lights.boxes;
        let texts = [boxes.key, boxes.fill, boxes.rim].map(|space| space.color.to_string());
        assert_eq!(texts, ["3200K", "3200K", "#8080ff"]);
        for text in ["", "red", "scene=5600K", "back=5600K", "key=", "key=5600"] {
            assert!(text.parse::<ColorArg>().is_err(), "{text}");
        }
    }
}
