//! What a term is, and numbers that belong to terms.

use super::maps::ViewStatistics;
use super::terms::TERMS;
use super::{Objective, Statistics};
use crate::{Error, Result};
use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Most terms of an objective.
pub const MAX_TERMS: usize = 16;

/// What a picture has to be measured for besides its brightness and gradients, which always are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Needs {
    /// [`Statistics::detail`].
    pub detail: bool,
    /// [`Statistics::burnt`].
    pub channels: bool,
    /// [`Statistics::irradiance`] and [`Statistics::unlit`].
    pub irradiance: bool,
    /// [`Statistics::residual`].
    pub target: bool,
}

impl Needs {
    /// Nothing more.
    pub const NONE: Self =
        Self { detail: false, channels: false, irradiance: false, target: false };
    /// Visible detail.
    pub const DETAIL: Self = Self { detail: true, ..Self::NONE };
    /// The channels of the colour.
    pub const CHANNELS: Self = Self { channels: true, ..Self::NONE };
    /// The irradiance of the lights.
    pub const IRRADIANCE: Self = Self { irradiance: true, ..Self::NONE };
    /// The distance from a target picture.
    pub const TARGET: Self = Self { target: true, ..Self::NONE };

    /// Whether what the lights do has to be known, and not the brightness alone.
    pub fn lights(self) -> bool {
        self.channels || self.irradiance
    }

    /// What either of two needs.
    pub fn and(self, other: Self) -> Self {
        Self {
            detail: self.detail || other.detail,
            channels: self.channels || other.channels,
            irradiance: self.irradiance || other.irradiance,
            target: self.target || other.target,
        }
    }
}

/// One term of an objective: a number 0..=1 that a picture's statistics make, lower is better.
///
/// Terms of klieg's own stand in [`TERMS`]; any other `static` may join them in an [`Objective`].
pub struct Term {
    /// Its name in JSON, in TOML, on the command line and in C.
    pub name: &'static str,
    /// What it is called in a report.
    pub title: &'static str,
    /// What it says of a picture, for people: a sentence without its subject.
    pub meaning: &'static str,
    /// What it is made of.
    pub needs: Needs,
    /// Its value for a picture of a view.
    pub formula: fn(&Statistics, &ViewStatistics, &Objective) -> f32,
}

impl Term {
    /// klieg's own term of that name.
    ///
    /// # Errors
    /// [`Error::Argument`] that lists the known ones.
    pub fn named(name: &str) -> Result<&'static Self> {
        TERMS.iter().find(|term| term.name == name).copied().ok_or_else(|| {
            let known: Vec<_> = TERMS.iter().map(|term| term.name).collect();
            Error::Argument(format!("'{name}' is not a term: they are {}", known.join(", ")))
        })
    }
}

impl PartialEq for Term {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Term {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// One number for each of some terms: the weights of an objective, or the values of a picture.
#[derive(Clone, Copy, PartialEq, Default)]
pub struct Terms {
    entries: [Option<(&'static Term, f32)>; MAX_TERMS],
}

impl Terms {
    /// The numbers of klieg's own terms, by name, in that order.
    ///
    /// # Errors
    /// [`Error::Argument`] for a name that is none of a term.
    pub fn named<'n>(numbers: impl IntoIterator<Item = (&'n str, f32)>) -> Result<Self> {
        let mut terms = Self::default();
        for (name, number) in numbers {
            terms.set(Term::named(name)?, number)?;
        }
        Ok(terms)
    }

    /// Gives a term its number; a term that is not there comes last.
    ///
    /// # Errors
    /// [`Error::Argument`] beyond [`MAX_TERMS`] terms.
    pub fn set(&mut self, term: &'static Term, number: f32) -> Result<()> {
        let entries = &mut self.entries;
        let place = entries.iter_mut().find(|entry| entry.is_none_or(|(known, _)| known == term));
        match place {
            Some(entry) => *entry = Some((term, number)),
            None => return Err(Error::Argument(format!("more than {MAX_TERMS} terms"))),
        }
        Ok(())
    }

    /// The terms and their numbers, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Term, f32)> + Clone + use<> {
        self.entries.into_iter().map_while(|entry| entry)
    }

    /// The numbers alone, in order.
    pub fn values(&self) -> impl Iterator<Item = f32> + Clone + use<> {
        self.iter().map(|(_, number)| number)
    }

    /// The names, in order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.iter().map(|(term, _)| term.name)
    }

    /// The number of the term of that name.
    pub fn get(&self, name: &str) -> Option<f32> {
        self.iter().find(|(term, _)| term.name == name).map(|(_, number)| number)
    }

    /// Those of the terms that pass.
    pub fn filter(&self, pass: impl Fn(&Term) -> bool) -> Self {
        let mut passed = self.iter().filter(|(term, _)| pass(term));
        Self { entries: std::array::from_fn(|_| passed.next()) }
    }

    /// The same terms with other numbers.
    pub fn map(&self, number: impl Fn(&'static Term, f32) -> f32) -> Self {
        let entries = self.entries.map(|entry| entry.map(|(term, old)| (term, number(term, old))));
        Self { entries }
    }
}

impl fmt::Debug for Terms {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_map().entries(self.iter()).finish()
    }
}

impl Serialize for Terms {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.iter().count()))?;
        for (term, number) in self.iter() {
            map.serialize_entry(term.name, &number)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Terms {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ByName;
        impl<'de> Visitor<'de> for ByName {
            type Value = Terms;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number for each term")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Terms, A::Error> {
                use serde::de::Error;
                let mut terms = Terms::default();
                while let Some((name, number)) = map.next_entry::<String, f32>()? {
                    let term = Term::named(&name).map_err(A::Error::custom)?;
                    terms.set(term, number).map_err(A::Error::custom)?;
                }
                Ok(terms)
            }
        }
        deserializer.deserialize_map(ByName)
    }
}
