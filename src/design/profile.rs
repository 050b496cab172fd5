//! Profiles: full sets of defaults that settings start from.

use super::coarse::CoarseSettings;
use crate::lighting::genome::{Boxes, Genome, RoleBox};
use crate::lighting::shading::{Brdf, Shading};
use crate::lighting::{LightKind, Role};
use crate::math::range::Range;
use crate::objective::{MeanTarget, Objective, Terms};
use crate::optimize::{Entry, GeneticSettings, Settings, genetic, shade};
use crate::{Error, Result};

/// A full set of defaults. Every part of it is a setting of its own, and what a user sets goes before it.
///
/// ```
/// use klieg::design::{Designer, profile::Profile};
///
/// let natural = Profile::named("natural")?;
/// let search = natural.optimizer.name;
/// let designer = Designer::new(natural.genome()?, search, &natural.endless(), None, 1)?;
/// assert_eq!(designer.genome().lights(), natural.roles.len());
/// # Ok::<(), klieg::Error>(())
/// ```
#[derive(Debug)]
pub struct Profile {
    /// Name in files, on the command line and in C.
    pub name: &'static str,
    /// What it is, for people.
    pub meaning: &'static str,
    /// What pictures are judged by.
    pub objective: fn() -> Objective,
    /// How surfaces reflect.
    pub shading: fn() -> Shading,
    /// Whether lights throw shadows.
    pub shadows: bool,
    /// The lights that are searched.
    pub roles: &'static [Role],
    /// Their kind.
    pub kind: LightKind,
    /// The values that they may have.
    pub boxes: fn() -> Boxes,
    /// How they are searched.
    pub optimizer: Entry,
    /// Individuals of a generation.
    pub population: usize,
    /// How a search begins on small pictures.
    pub coarse: CoarseSettings,
}

/// The profiles.
pub static PROFILES: &[&Profile] = &[&PAPER, &NATURAL];

/// What settings start from where nobody names a profile.
pub const DEFAULT: &Profile = &NATURAL;

/// The method of Ha and Olivier (2006), as `docs/METHOD.md` reconstructs it.
pub static PAPER: Profile = Profile {
    name: "paper",
    meaning: "The paper's five terms and its shading, without shadows",
    objective: Objective::default,
    shading: Shading::default,
    shadows: false,
    roles: &[Role::Key, Role::Fill],
    kind: LightKind::POINT,
    boxes: Boxes::default,
    optimizer: genetic::ENTRY,
    population: 30,
    coarse: CoarseSettings::NONE,
};

/// What people will see: the numbers are klieg's own, `docs/METHOD.md`.
pub static NATURAL: Profile = Profile {
    name: "natural",
    meaning: "The shading of glTF with shadows, as viewers show it, judged as people see it",
    objective: natural_objective,
    shading: natural_shading,
    shadows: true,
    roles: &[Role::Key, Role::Fill],
    kind: LightKind::POINT,
    boxes: natural_boxes,
    optimizer: shade::ENTRY,
    population: 20,
    coarse: CoarseSettings { side: 128, searches: 8, ..CoarseSettings::NONE },
};

impl Profile {
    /// The profile of that name.
    ///
    /// # Errors
    /// [`Error::Argument`] that lists them.
    pub fn named(name: &str) -> Result<&'static Self> {
        PROFILES.iter().copied().find(|profile| profile.name == name).ok_or_else(|| {
            let names: Vec<_> = PROFILES.iter().map(|profile| profile.name).collect();
            Error::Argument(format!(
                "there is no profile '{name}': the profiles are {}",
                names.join(", ")
            ))
        })
    }

    /// The codec of its lights.
    ///
    /// # Errors
    /// As [`Genome::new`].
    pub fn genome(&self) -> Result<Genome> {
        Genome::new(self.roles, self.kind, &(self.boxes)())
    }

    /// The settings of a search that runs as long as its caller wants.
    pub fn endless(&self) -> Settings {
        let genetic = GeneticSettings { population: self.population, ..GeneticSettings::endless() };
        Settings { genetic, ..Settings::endless() }
    }
}

impl PartialEq for Profile {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

fn natural_objective() -> Objective {
    let weights = Terms::named([
        ("edge", 0.10),
        ("mean", 0.20),
        ("hist", 0.05),
        ("detail", 0.25),
        ("range", 0.10),
        ("burnt", 0.25),
        ("unlit", 0.25),
        ("relief", 0.20),
        ("direction", 0.10),
        ("outline", 0.10),
    ]);
    Objective {
        weights: weights.unwrap_or_default(),
        mean_target: MeanTarget::Scene,
        ..Objective::default()
    }
}

fn natural_shading() -> Shading {
    Shading { brdf: Brdf::GltfScattering, ambient: 0.0, ..Shading::default() }
}

/// Fill and rim are told relative to the key, so that no search puts two lights in one place. Every light
/// has one intensity, as lamps have.
fn natural_boxes() -> Boxes {
    let paper = Boxes::default();
    let key = RoleBox { diffuse: Range::new(0.0, 6.0), specular: None, softness: 4.0, ..paper.key };
    let fill = RoleBox {
        elevation: Range::new(-10.0, 45.0),
        azimuth: Range::new(20.0, 110.0),
        azimuth_from_key: true,
        share_of_key: true,
        diffuse: Range::new(0.05, 0.6),
        ..key
    };
    let rim = RoleBox {
        elevation: Range::new(10.0, 80.0),
        azimuth: Range::new(110.0, 250.0),
        azimuth_from_key: false,
        diffuse: Range::new(0.1, 1.5),
        ..fill
    };
    Boxes { key, fill, rim }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_known_by_name_and_whole() {
        for &profile in PROFILES {
            assert_eq!(Profile::named(profile.name).unwrap(), profile);
            let objective = (profile.objective)();
            objective.check().unwrap();
            objective.check_without_target().unwrap();
            (profile.shading)().check().unwrap();
            assert_eq!(profile.genome().unwrap().roles(), profile.roles);
            let all = [Role::Key, Role::Fill, Role::Rim];
            Genome::new(&all, profile.kind, &(profile.boxes)()).unwrap();
        }
        let fault = Profile::named("film").unwrap_err().to_string();
        assert!(fault.contains("'film': the profiles are paper, natural"), "{fault}");
    }

    #[test]
    fn natural_weighs_ten_terms_and_light_of_one_intensity() {
        let Objective { weights, mean_target, .. } = (NATURAL.objective)();
        assert_eq!((weights.iter().count(), mean_target), (10, MeanTarget::Scene));
        let (all, counted) = (weights, (NATURAL.objective)().measured());
        for (weights, sum) in [(all, 1.6), (counted, 1.5)] {
            assert!((weights.values().sum::<f32>() - sum).abs() < 1e-6, "{weights:?}");
        }
        let genome = NATURAL.genome().unwrap();
        assert!((0..2).all(|light| genome.alleles(light).all(|allele| allele.name != "specular")));
        assert_eq!(PAPER.genome().unwrap().bounds().len(), genome.bounds().len() + 2);
    }

    /// Differences of azimuth, degrees, 0..=180.
    fn apart(a: f32, b: f32) -> f32 {
        let turn = (a - b).to_degrees().rem_euclid(360.0);
        turn.min(360.0 - turn)
    }

    #[test]
    fn natural_fills_stand_across_from_the_key_and_rims_behind() {
        let boxes = (NATURAL.boxes)();
        let genome =
            Genome::new(&[Role::Key, Role::Fill, Role::Rim], NATURAL.kind, &boxes).unwrap();
        for step in 0..1000 {
            let share =
                |allele: usize| ((step * (2 * allele + 7) + 31 * allele) % 101) as f32 / 100.0;
            let place = |(at, range): (usize, &Range)| range.at(share(at));
            let chromosome: Vec<f32> = genome.bounds().iter().enumerate().map(place).collect();
            let rig = genome.decode(&chromosome);
            let [key, fill, rim] = &rig[..] else { panic!("three lights") };
            assert!(apart(key.azimuth, fill.azimuth) > 19.99);
            let across = if key.azimuth > 0.0 { -1.0 } else { 1.0 };
            assert!((fill.azimuth - key.azimuth) * across > 0.0, "{key:?} {fill:?}");
            assert!(fill.diffuse <= 0.6 * key.diffuse && rim.diffuse <= 1.5 * key.diffuse);
            assert!(apart(rim.azimuth, std::f32::consts::PI) < 70.01 && rim.elevation > 0.0);
        }
    }
}
