//! Options about lights that several subcommands share.

use super::config::{LightSettings, Settings};
use crate::Result;
use crate::lighting::genome::Boxes;
use crate::lighting::kinds::KINDS;
use crate::lighting::{Color, LightKind, Role};
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
    /// As [`Boxes::of_mut`].
    pub fn apply(&self, settings: &mut Settings) -> Result<()> {
        settings.lights.keep |= self.keep_lights;
        self.colors.iter().try_for_each(|color| color.apply(&mut settings.lights.boxes))
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

impl ColorArg {
    fn apply(&self, boxes: &mut Boxes) -> Result<()> {
        match self.role {
            Some(role) => boxes.of_mut(role)?.color = self.color,
            None => boxes.all_mut().into_iter().for_each(|space| space.color = self.color),
        }
        Ok(())
    }
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

/// A role that is searched, by its name.
pub(super) fn role(name: &str) -> Result<Role, String> {
    let searched = Role::ALL.into_iter().filter(|role| *role != Role::Scene);
    searched.clone().find(|role| role.name() == name.trim()).ok_or_else(|| {
        let names: Vec<_> = searched.map(Role::name).collect();
        format!("'{name}' is none of {}", names.join(", "))
    })
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

impl Intensities {
    /// Gives every box that many; a specular range that is missing is that of the diffuse intensity.
    pub fn apply(self, lights: &mut LightSettings) {
        for space in lights.boxes.all_mut() {
            space.specular = match self {
                Self::One => None,
                Self::Two => space.specular.or(Some(space.diffuse)),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_role_and_for_all() {
        let mut boxes = Boxes::default();
        for text in ["3200K", "rim=#8080ff"] {
            text.parse::<ColorArg>().unwrap().apply(&mut boxes).unwrap();
        }
        let texts = [boxes.key, boxes.fill, boxes.rim].map(|space| space.color.to_string());
        assert_eq!(texts, ["3200K", "3200K", "#8080ff"]);
        for text in ["", "red", "scene=5600K", "back=5600K", "key=", "key=5600"] {
            assert!(text.parse::<ColorArg>().is_err(), "{text}");
        }
    }

    #[test]
    fn intensities_are_one_or_two() {
        let mut lights = LightSettings::default();
        let two = lights.boxes.fill.specular;
        Intensities::One.apply(&mut lights);
        assert_eq!(lights.boxes.fill.specular, None);
        Intensities::Two.apply(&mut lights);
        assert_eq!(lights.boxes.fill.specular, two);
    }
}
