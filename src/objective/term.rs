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
    /// [`Statistics::outline`].
    pub background: bool,
    /// Nothing more of pictures, but [`Objective::example`].
    pub example: bool,
    /// [`Statistics::entropy`].
    pub curvature: bool,
}

impl Needs {
    /// Nothing more.
    pub const NONE: Self = Self {
        detail: false,
        channels: false,
        irradiance: false,
        target: false,
        background: false,
        example: false,
        curvature: false,
    };
    /// Visible detail.
    pub const DETAIL: Self = Self { detail: true, ..Self::NONE };
    /// The channels of the colour.
    pub const CHANNELS: Self = Self { channels: true, ..Self::NONE };
    /// The irradiance of the lights.
    pub const IRRADIANCE: Self = Self { irradiance: true, ..Self::NONE };
    /// The distance from a target picture.
    pub const TARGET: Self = Self { target: true, ..Self::NONE };
    /// The contrast of the outline with a given background.
    pub const BACKGROUND: Self = Self { background: true, ..Self::NONE };
    /// A given example.
    pub const EXAMPLE: Self = Self { example: true, ..Self::NONE };
    /// How the brightnesses are spread where the surface curves.
    pub const CURVATURE: Self = Self { curvature: true, ..Self::NONE };

    /// Whether what the lights do has to be known, and not the brightness alone.
    pub fn lights(self) -> bool {
        self.channels || self.irradiance
    }

    /// Whether sums over pixels have to be known besides those of brightness and gradients.
    pub fn sums(self) -> bool {
        self.lights() || self.detail || self.target || self.background
    }

    /// What either of two needs.
    pub fn and(self, other: Self) -> Self {
        Self {
            detail: self.detail || other.detail,
            channels: self.channels || other.channels,
            irradiance: self.irradiance || other.irradiance,
            target: self.target || other.target,
            background: self.background || other.background,
            example: self.example || other.example,
            curvature: self.curvature || other.curvature,
        }
    }

    /// What is needed, a word each.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let all = [
            ("detail", self.detail),
            ("channels", self.channels),
            ("irradiance", self.irradiance),
            ("target", self.target),
            ("background", self.background),
            ("example", self.example),
            ("curvature", self.curvature),
        ];
        all.into_iter().filter(|(_, needed)| *needed).map(|(name, _)| name)
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
            Error::Argument(format!(
                "there is no term '{name}': the terms are {}",
                known.join(", ")
            ))
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
    /// The numbers of klieg's own terms, by name.
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

    /// Gives a term its number. Whatever the order in which they come, klieg's own terms stand in the order
    /// of [`TERMS`], so that sums over them have the same bits; others follow.
    ///
    /// # Errors
    /// [`Error::Argument`] beyond [`MAX_TERMS`] terms.
    pub fn set(&mut self, term: &'static Term, number: f32) -> Result<()> {
        let same = |entry: &&mut Option<_>| entry.is_some_and(|(known, _)| known == term);
        if let Some(entry) = self.entries.iter_mut().find(same) {
            *entry = Some((term, number));
            return Ok(());
        }
        let count = self.iter().count();
        if count == MAX_TERMS {
            return Err(Error::Argument(format!("more than {MAX_TERMS} terms")));
        }
        let rank = |term| TERMS.iter().position(|&own| own == term).unwrap_or(TERMS.len());
        let place = self.iter().filter(|&(known, _)| rank(known) <= rank(term)).count();
        self.entries[place..=count].rotate_right(1);
        self.entries[place] = Some((term, number));
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

#[cfg(test)]
mod tests {
    use super::*;

    static DARK: Term = Term {
        name: "dark",
        title: "Dark",
        meaning: "how dark the picture is",
        needs: Needs::NONE,
        formula: |picture, _, _| 1.0 - picture.mean,
    };

    fn named(pairs: &[(&str, f32)]) -> Terms {
        Terms::named(pairs.iter().copied()).unwrap()
    }

    #[test]
    fn terms_stand_in_the_order_of_the_table_however_they_come() {
        let mut terms = Terms::default();
        terms.set(&DARK, 7.0).unwrap();
        for (name, number) in [("relief", 1.0), ("edge", 2.0), ("hist", 3.0), ("relief", 4.0)] {
            terms.set(Term::named(name).unwrap(), number).unwrap();
        }
        let all: Vec<_> = terms.iter().map(|(term, number)| (term.name, number)).collect();
        assert_eq!(all, [("edge", 2.0), ("hist", 3.0), ("relief", 4.0), ("dark", 7.0)]);
        assert_eq!((terms.get("hist"), terms.get("mean")), (Some(3.0), None));
        let [ab, ba] = [[("edge", 1.0), ("mean", 2.0)], [("mean", 2.0), ("edge", 1.0)]];
        assert_eq!(named(&ab), named(&ba));
        assert_ne!(named(&ab), named(&[("edge", 1.0)]));
    }

    #[test]
    fn there_is_room_for_sixteen_terms() {
        let term = |name| Box::leak(Box::new(Term { name, ..DARK }));
        let names =
            ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p"];
        let mut terms = Terms::default();
        names.iter().for_each(|name| terms.set(term(name), 1.0).unwrap());
        assert!(terms.names().eq(names));
        assert!(terms.set(&DARK, 1.0).is_err() && terms.set(term("p"), 2.0).is_ok());
    }

    #[test]
    fn numbers_go_to_json_and_back_by_name() {
        let terms = named(&[("edge", 0.5), ("burnt", 0.25)]);
        let text = serde_json::to_string(&terms).unwrap();
        assert_eq!(text, r#"{"edge":0.5,"burnt":0.25}"#);
        assert_eq!(serde_json::from_str::<Terms>(&text).unwrap(), terms);
        let fault = serde_json::from_str::<Terms>(r#"{"bornt":1}"#).unwrap_err().to_string();
        assert!(fault.contains("no term 'bornt': the terms are edge, mean"), "{fault}");
    }

    #[test]
    fn needs_are_named() {
        let two = Needs::DETAIL.and(Needs::TARGET);
        assert!(two.names().eq(["detail", "target"]) && Needs::NONE.names().next().is_none());
        assert!(Needs::CHANNELS.and(Needs::IRRADIANCE).names().eq(["channels", "irradiance"]));
        assert!(Needs::BACKGROUND.and(Needs::TARGET).names().eq(["target", "background"]));
    }
}
