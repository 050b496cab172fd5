//! What light is wanted, as the settings say it, and what a search makes of it.

use super::Session;
use super::config::{First, Settings, ViewsSettings};
use super::values::role;
use crate::design::start;
use crate::lighting::genome::Genome;
use crate::lighting::{Rig, Role, Stand};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display};
use std::str::FromStr;

/// A light, or one of its values, that a search leaves as it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Keep {
    light: Which,
    /// Name of one value; the whole light where absent.
    value: Option<String>,
}

/// Which light.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Which {
    /// All of that role.
    Role(Role),
    /// By its place.
    Index(usize),
}

impl FromStr for Keep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (light, value) = match text.split_once('.') {
            Some((light, value)) => (light, Some(value.trim().to_owned())),
            None => (text, None),
        };
        let light = match light.trim().parse() {
            Ok(index) => Which::Index(index),
            Err(_) => Which::Role(role(light)?),
        };
        Ok(Self { light, value })
    }
}

impl Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.light {
            Which::Role(role) => f.write_str(role.name())?,
            Which::Index(index) => write!(f, "{index}")?,
        }
        self.value.as_ref().map_or(Ok(()), |value| write!(f, ".{value}"))
    }
}

text_form!(Keep);

impl Settings {
    /// The settings with what the intent makes of the objective and the boxes. A rig that stands in the world, for several
    /// cameras, may have its lights on all sides.
    ///
    /// # Errors
    /// As [`Intent::steer`](crate::design::Intent::steer).
    pub fn steered(&self) -> Result<Self> {
        let mut settings = self.clone();
        let ViewsSettings { cameras, rig, .. } = &self.views;
        if cameras.is_some() && *rig == Stand::World {
            settings.lights.boxes.go_round(&(self.profile.0.boxes)());
        }
        self.intent.steer(&mut settings.objective, &mut settings.lights.boxes)?;
        Ok(settings)
    }

    /// # Errors
    /// [`Error::Argument`] for lights that are kept of a search that begins with none, or adds them one by one.
    pub fn check_intent(&self) -> Result<()> {
        if !self.lights.hold.is_empty() && matches!(self.first, First::KMeans | First::Random) {
            let fault = "there is no rig of which a light could be kept: --first names one, such as scene for the \
                         lights of a lit scene, or three-point";
            return Err(Error::Argument(fault.into()));
        }
        if self.lights.one_by_one && !self.lights.hold.is_empty() {
            let fault = "lights that are added one by one are held where they were found: \
                         --one-by-one does not go with --keep";
            return Err(Error::Argument(fault.into()));
        }
        self.steered().map(drop)
    }

    /// # Errors
    /// [`Error::Argument`] for lights that are added one by one, of a search that has to know all of them.
    pub fn check_together(&self) -> Result<()> {
        if self.lights.one_by_one {
            let fault = "--one-by-one goes with 'design', 'batch' and 'thumbnail' alone, and not with \
                         --alternatives, --target-picture or --collage";
            return Err(Error::Argument(fault.into()));
        }
        Ok(())
    }
}

/// The genome of a session's search with its horizon and with the lights of the rig `first` that are kept.
///
/// # Errors
/// As [`Genome::hold`], and [`Error::Argument`] for a role that is not searched.
pub fn bound(session: &Session, mut genome: Genome, first: Option<Rig>) -> Result<Genome> {
    let settings = &session.settings;
    genome = settings.intent.bound(genome, &session.view)?;
    let Some(first) = first.filter(|_| !settings.lights.hold.is_empty()) else {
        return Ok(genome);
    };
    let first = start::matched(&genome, &first)?;
    for Keep { light, value } in &settings.lights.hold {
        let wanted: Vec<usize> = match *light {
            Which::Index(index) => vec![index],
            Which::Role(role) => {
                (0..genome.lights()).filter(|&at| genome.roles()[at] == role).collect()
            }
        };
        if let (Which::Role(role), []) = (light, &wanted[..]) {
            let fault = format!("there is no {} light to keep", role.name());
            return Err(Error::Argument(fault));
        }
        for at in wanted {
            let held = first.get(at).copied().unwrap_or_default();
            genome = genome.hold(at, &held, value.as_deref())?;
        }
    }
    Ok(genome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_kept_by_role_or_number_as_a_whole_or_in_part() {
        for text in ["key", "1", "fill.azimuth", "0.elevation"] {
            let keep: Keep = text.parse().unwrap();
            assert_eq!(keep.to_string(), text);
        }
        for text in ["", "back", "scene", "-1", ".azimuth"] {
            assert!(text.parse::<Keep>().is_err(), "{text}");
        }
    }
}
