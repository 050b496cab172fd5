//! Kinds of lights. A kind is data: how its light reaches the scene, and what of it a search may change.
//! `docs/EXTENDING.md` shows how another crate adds one.

pub mod alleles;
mod directional;
mod point;
mod spot;

use super::Light;
use super::genome::RoleBox;
use crate::math::range::Range;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Debug, Display};
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::str::FromStr;

/// A kind of light.
#[derive(Debug)]
pub struct Kind {
    /// Name in files and on the command line; two kinds of one name count as the same.
    pub name: &'static str,
    /// What it is, for people.
    pub meaning: &'static str,
    /// Whether its light is parallel and has no falloff, rather than coming from a point at the distance
    /// `R` with the falloff `(R/d)²`.
    pub parallel: bool,
    /// Whether it shines within [`Light::cone`] alone.
    pub cone: bool,
    /// What a search may change, in the order of the chromosome; each is set in that order.
    pub alleles: &'static [Allele],
}

/// One value of a light that a search may change.
#[derive(Debug, Clone, Copy)]
pub struct Allele {
    /// Name, for people.
    pub name: &'static str,
    /// The values that it may have, in the light's own units; `None` where the box leaves it out.
    pub range: fn(&RoleBox) -> Option<Range>,
    /// Reads it.
    pub get: fn(&Light) -> f32,
    /// Writes it.
    pub set: fn(&mut Light, f32),
    /// Whether it is an angle, radians, that full turns leave as it is.
    pub turns: bool,
    /// What the box makes its values relative to; `None` for values that stand for themselves.
    pub relation: fn(&RoleBox) -> Option<Relation>,
}

/// How a value of a light is told relative to that of the key light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// An azimuth, radians, from the key's across the viewer's direction: to the left of a key on the
    /// right, and to the right of any other.
    Azimuth,
    /// A share of the key's value, which is 0 or more.
    Share,
}

impl Relation {
    /// The value of a light that is told as `relative` to the key's.
    pub fn absolute(self, relative: f32, key: f32) -> f32 {
        match self {
            Self::Azimuth => key + across(key) * relative,
            Self::Share => key * relative,
        }
    }

    /// How `absolute` is told relative to the key's value. Of nothing everything is the share 0.
    pub fn relative(self, absolute: f32, key: f32) -> f32 {
        match self {
            Self::Azimuth => across(key) * (absolute - key),
            Self::Share if key > 0.0 => absolute / key,
            Self::Share => 0.0,
        }
    }
}

/// The sign of azimuths on the other side of a key.
fn across(key: f32) -> f32 {
    if key.sin() > 0.0 { -1.0 } else { 1.0 }
}

/// The kinds that klieg has, by which files and the command line name them.
pub static KINDS: [LightKind; 3] = [LightKind::POINT, LightKind::DIRECTIONAL, LightKind::SPOT];

/// A kind of light, as lights hold it. As text it is the kind's name.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct LightKind(&'static Kind);

impl LightKind {
    /// From a point at distance `R`, with falloff `(R/d)²`.
    pub const POINT: Self = Self(&point::POINT);
    /// Parallel, without falloff.
    pub const DIRECTIONAL: Self = Self(&directional::DIRECTIONAL);
    /// As a point light, within a cone.
    pub const SPOT: Self = Self(&spot::SPOT);

    /// A kind of one's own.
    pub const fn new(kind: &'static Kind) -> Self {
        Self(kind)
    }

    /// What a search may change, as [`Kind::alleles`].
    pub const fn alleles(self) -> &'static [Allele] {
        self.0.alleles
    }

    /// The kind of that name among [`KINDS`].
    ///
    /// # Errors
    /// [`Error::Argument`] that lists them.
    pub fn named(name: &str) -> Result<Self> {
        KINDS.into_iter().find(|kind| kind.name == name).ok_or_else(|| {
            let names = KINDS.map(|kind| kind.name).join(", ");
            Error::Argument(format!("'{name}' is no kind of light: there are {names}"))
        })
    }
}

impl Deref for LightKind {
    type Target = Kind;

    fn deref(&self) -> &Kind {
        self.0
    }
}

impl Default for LightKind {
    fn default() -> Self {
        Self::POINT
    }
}

impl PartialEq for LightKind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for LightKind {}

impl Hash for LightKind {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl Debug for LightKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Display for LightKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl FromStr for LightKind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::named(name)
    }
}

impl TryFrom<String> for LightKind {
    type Error = Error;

    fn try_from(name: String) -> Result<Self> {
        Self::named(&name)
    }
}

impl From<LightKind> for String {
    fn from(kind: LightKind) -> Self {
        kind.name.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_known_by_their_names() {
        for kind in KINDS {
            assert_eq!(LightKind::named(kind.name).unwrap(), kind);
            let text = serde_json::to_string(&kind).unwrap();
            assert_eq!(text, format!("\"{}\"", kind.name));
            assert_eq!(serde_json::from_str::<LightKind>(&text).unwrap(), kind);
        }
        let fault = LightKind::named("lamp").unwrap_err().to_string();
        assert!(fault.contains("'lamp'") && fault.contains("spot"), "{fault}");
        assert_ne!(LightKind::POINT, LightKind::SPOT);
    }

    #[test]
    fn alleles_read_what_they_wrote() {
        for kind in KINDS {
            for allele in kind.alleles {
                let mut light = Light { kind, ..Light::default() };
                (allele.set)(&mut light, 0.625);
                assert_eq!((allele.get)(&light), 0.625, "{} of {kind}", allele.name);
                assert_ne!(light, Light { kind, ..Light::default() }, "{} of {kind}", allele.name);
            }
        }
    }
}
