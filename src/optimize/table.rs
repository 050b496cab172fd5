//! The optimisers by name.

use super::{GeneticSettings, GreedySettings, Optimizer, ShadeSettings, StartSettings};
use super::{bipop, descent, genetic, random, restarts, shade};
use crate::math::range::Range;
use crate::{Error, Result};
use rand_chacha::ChaCha8Rng;

/// Every optimiser.
pub const OPTIMIZERS: &[Entry] =
    &[genetic::ENTRY, shade::ENTRY, bipop::ENTRY, descent::ENTRY, restarts::ENTRY, random::ENTRY];

/// An optimiser by its name.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The name in settings: lower-case letters, digits and `-`.
    pub name: &'static str,
    /// What plots and tables call it.
    pub title: &'static str,
    /// What it does, in one line.
    pub description: &'static str,
    /// Makes a search; the settings and the first individual have passed their checks.
    pub new: fn(Setup) -> Result<Box<dyn Optimizer>>,
    /// Generations of a whole search; `None` where nobody knows them beforehand.
    pub generations: fn(&Settings) -> Option<usize>,
    /// Its own settings in a few words.
    pub words: fn(&Settings) -> String,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Entry {}

/// What a search is made from.
#[derive(Debug, Clone)]
pub struct Setup<'a> {
    /// The range of each allele.
    pub bounds: &'a [Range],
    /// Where it begins: a value for each allele, inside its range.
    pub first: Vec<f32>,
    /// Settings of all optimisers; each reads its own.
    pub settings: &'a Settings,
    /// What all its random numbers come from.
    pub rng: ChaCha8Rng,
}

/// Settings of all optimisers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// The first population.
    pub start: StartSettings,
    /// The genetic algorithm. Its population and generations hold for SHADE and random search too, its
    /// patience for SHADE, and its evaluations are what descents with restarts may use.
    pub genetic: GeneticSettings,
    /// SHADE.
    pub shade: ShadeSettings,
    /// The greedy descents.
    pub greedy: GreedySettings,
}

impl Settings {
    /// The defaults without an end, for a search that runs as long as its caller wants: a greedy
    /// descent goes on until the ground is level, all others for ever.
    pub fn endless() -> Self {
        let (genetic, shade) = (GeneticSettings::endless(), ShadeSettings::endless());
        Self { genetic, shade, ..Self::default() }
    }

    /// # Errors
    /// [`Error::Argument`] that names the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        self.start.check()?;
        self.shade.check()?;
        self.greedy.check()?;
        self.genetic.check()
    }
}

/// The optimiser of a name.
///
/// # Errors
/// [`Error::Argument`], with all names, for an unknown one.
pub fn find(name: &str) -> Result<&'static Entry> {
    OPTIMIZERS.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let names: Vec<_> = OPTIMIZERS.iter().map(|entry| entry.name).collect();
        Error::Argument(format!("no optimizer is called '{name}': there are {}", names.join(", ")))
    })
}

/// Makes the search of a name.
///
/// # Errors
/// [`Error::Argument`] for an unknown name, a setting out of its range, and a first individual of another
/// number of alleles or outside its ranges.
pub fn create(name: &str, setup: Setup) -> Result<Box<dyn Optimizer>> {
    let entry = find(name)?;
    setup.settings.check()?;
    check(setup.bounds, &setup.first)?;
    (entry.new)(setup)
}

/// # Errors
/// [`Error::Argument`] unless `first` has one allele for each of `bounds`, inside it.
fn check(bounds: &[Range], first: &[f32]) -> Result<()> {
    let (given, wanted) = (first.len(), bounds.len());
    if given != wanted {
        let fault = format!("a first individual of {given} alleles: the search has {wanted}");
        return Err(Error::Argument(fault));
    }
    for (at, (range, &value)) in std::iter::zip(bounds, first).enumerate() {
        if !range.contains(value) {
            let Range { low, high } = range;
            let fault =
                format!("allele {at} of the first individual is {value}: it is {low} to {high}");
            return Err(Error::Argument(fault));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_the_same_where_their_names_are() {
        for (number, entry) in OPTIMIZERS.iter().enumerate() {
            assert_eq!(find(entry.name).unwrap(), entry);
            assert!(OPTIMIZERS[..number].iter().all(|other| other != entry), "{}", entry.name);
        }
        let fault = find("nothing").unwrap_err().to_string();
        assert!(OPTIMIZERS.iter().all(|entry| fault.contains(entry.name)), "{fault}");
    }
}
