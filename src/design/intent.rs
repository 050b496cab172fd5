//! What light is wanted, in words: brightness, contrast, mood, and whether it may come from below. An intent is no
//! setting of its own: it changes the settings of objective and boxes that a search begins with.

use crate::Result;
use crate::error::within;
use crate::lighting::genome::{Boxes, Genome, RoleBox};
use crate::math::range::Range;
use crate::objective::{Objective, Term};
use crate::scene::view::View;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Stops of a step of brightness.
const STEP_STOPS: f32 = 0.6;
/// Standard deviation of the brightness of a step of contrast.
const STEP_SPREAD: f32 = 0.06;
/// Factor of the fill's share of the key of a step of contrast.
const STEP_FILL: f32 = 0.6;
/// Factor of the weight of unlit pixels of a step of more contrast: deep shadows are then wanted.
const STEP_UNLIT: f32 = 0.4;
/// Weight of the mean brightness where one is asked for, at least: no other term is to outvote it.
const MEAN_WEIGHT: f32 = 0.8;
/// Weight of the spread of brightness where one is asked for.
const SPREAD_WEIGHT: f32 = 0.6;
/// The share of its key that a fill may have at most, so that the key stays the key.
const FILL_MOST: f32 = 0.95;

/// The character of a light.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "lowercase")]
pub enum Mood {
    /// Large lights, a strong fill, little contrast.
    Soft,
    /// As the profile has it.
    #[default]
    Natural,
    /// A small key from anywhere in front, hardly any fill, shadows that may be black.
    Dramatic,
}

impl Mood {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Soft, Self::Natural, Self::Dramatic];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Natural => "natural",
            Self::Dramatic => "dramatic",
        }
    }
}

impl FromStr for Mood {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|mood| mood.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("'{text}' is no mood: there are {names}")
        })
    }
}

/// What light is wanted. The default wants nothing and leaves all settings as they are, to the bit.
///
/// ```
/// use klieg::design::{Intent, Mood, profile};
///
/// let natural = profile::DEFAULT;
/// let (mut objective, mut boxes) = ((natural.objective)(), (natural.boxes)());
/// let intent = Intent { brightness: 1.0, mood: Mood::Dramatic, ..Intent::default() };
/// intent.steer(&mut objective, &mut boxes)?;
/// assert!(boxes.fill.diffuse.high < (natural.boxes)().fill.diffuse.high);
/// # Ok::<(), klieg::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(default, deny_unknown_fields)]
pub struct Intent {
    /// Steps of brightness, −2..=2: each moves the mean brightness aimed at by 0.6 stops.
    pub brightness: f32,
    /// Steps of contrast, −2..=2: each moves the standard deviation of the brightness aimed at by 0.06 from 0.2, and
    /// leaves the fill 0.6 of its share of the key.
    pub contrast: f32,
    /// The character.
    pub mood: Mood,
    /// Whether lights may stand below the horizon of the scene's centre.
    pub below: bool,
}

impl Default for Intent {
    fn default() -> Self {
        Self { brightness: 0.0, contrast: 0.0, mood: Mood::Natural, below: true }
    }
}

impl Intent {
    /// What is wanted in words, each part with a comma behind it; empty for nothing.
    pub fn words(&self) -> String {
        let step = |name, steps: f32| match steps {
            0.0 => String::new(),
            _ => format!("{name} {steps:+}, "),
        };
        let mood = match self.mood {
            Mood::Natural => String::new(),
            mood => format!("{} mood, ", mood.name()),
        };
        let below = if self.below { "" } else { "no light from below, " };
        let (brightness, contrast) =
            (step("brightness", self.brightness), step("contrast", self.contrast));
        format!("{brightness}{contrast}{mood}{below}")
    }

    /// # Errors
    /// [`crate::Error::Argument`] for a step out of its range.
    pub fn check(&self) -> Result<()> {
        within("brightness", self.brightness, -2.0, 2.0)?;
        within("contrast", self.contrast, -2.0, 2.0)
    }

    /// Changes the settings of a search into those that make such light: targets and weights of the objective, and
    /// boxes. What is not wanted stays as it is. The horizon is the genome's
    /// ([`above_horizon`](crate::lighting::genome::Genome::above_horizon)), which [`up`] helps with.
    ///
    /// # Errors
    /// As [`Intent::check`], and for an objective without room for the terms `mean` and `spread`.
    pub fn steer(&self, objective: &mut Objective, boxes: &mut Boxes) -> Result<()> {
        self.check()?;
        match self.mood {
            Mood::Soft => soft(objective, boxes)?,
            Mood::Natural => (),
            Mood::Dramatic => dramatic(objective, boxes)?,
        }
        if self.brightness != 0.0 {
            brighten(objective, STEP_STOPS * self.brightness)?;
        }
        if self.contrast != 0.0 {
            let spread = objective.spread_target + STEP_SPREAD * self.contrast;
            spread_to(objective, spread)?;
            let factor = STEP_FILL.powf(self.contrast);
            let Range { low, high } = boxes.fill.diffuse;
            fill_shares(&mut boxes.fill, Range::new(factor * low, factor * high));
            weigh(objective, "unlit", STEP_UNLIT.powf(self.contrast.max(0.0)))?;
        }
        Ok(())
    }

    /// The genome with the horizon of `view`, where lights may not stand below it.
    ///
    /// # Errors
    /// As [`Genome::above_horizon`].
    pub fn bound(&self, genome: Genome, view: &View) -> Result<Genome> {
        if self.below { Ok(genome) } else { genome.above_horizon(up(view)) }
    }
}

/// Unit vector upwards, the world's +y, in the light frame of a view.
pub fn up(view: &View) -> Vec3 {
    let frame = &view.frame;
    Vec3::new(frame.right.y as f32, frame.up.y as f32, frame.back.y as f32).normalize_or(Vec3::Y)
}

/// Moves the mean brightness aimed at, and lets it weigh more.
fn brighten(objective: &mut Objective, stops: f32) -> Result<()> {
    objective.mean_stops = (objective.mean_stops + stops).clamp(-4.0, 4.0);
    insist_on_mean(objective)
}

/// Has the mean brightness weigh so much that no other term outvotes it.
///
/// # Errors
/// [`crate::Error::Argument`] for an objective without room for the term `mean`.
pub fn insist_on_mean(objective: &mut Objective) -> Result<()> {
    let weight = objective.weights.get("mean").unwrap_or(0.0).max(MEAN_WEIGHT);
    objective.weights.set(Term::named("mean")?, weight)
}

/// Aims at a spread of brightness in place of a wide one.
fn spread_to(objective: &mut Objective, spread: f32) -> Result<()> {
    objective.spread_target = spread.clamp(0.0, 0.5);
    for one_sided in ["range", "var", "hist"] {
        if objective.weights.get(one_sided).is_some() {
            objective.weights.set(Term::named(one_sided)?, 0.0)?;
        }
    }
    objective.weights.set(Term::named("spread")?, SPREAD_WEIGHT)
}

/// Multiplies the weight of a term, where it has one.
fn weigh(objective: &mut Objective, name: &str, factor: f32) -> Result<()> {
    match objective.weights.get(name) {
        Some(weight) => objective.weights.set(Term::named(name)?, factor * weight),
        None => Ok(()),
    }
}

/// Sets the shares of the key that a fill may have; one that is told by itself stays as it is.
fn fill_shares(fill: &mut RoleBox, shares: Range) {
    if fill.share_of_key {
        let high = shares.high.min(FILL_MOST);
        fill.diffuse = Range::new(shares.low.min(high), high);
        fill.specular = fill.specular.map(|_| fill.diffuse);
    }
}

fn soft(objective: &mut Objective, boxes: &mut Boxes) -> Result<()> {
    spread_to(objective, 0.14)?;
    weigh(objective, "relief", 0.5)?;
    fill_shares(&mut boxes.fill, Range::new(0.45, 0.9));
    boxes.all_mut().into_iter().for_each(|space| space.softness = 40.0);
    Ok(())
}

fn dramatic(objective: &mut Objective, boxes: &mut Boxes) -> Result<()> {
    spread_to(objective, 0.27)?;
    brighten(objective, -0.9)?;
    for (name, factor) in [("unlit", 0.0), ("direction", 0.0), ("detail", 0.4), ("edge", 0.0)] {
        weigh(objective, name, factor)?;
    }
    fill_shares(&mut boxes.fill, Range::new(0.0, 0.06));
    boxes.all_mut().into_iter().for_each(|space| space.softness = 1.0);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::profile::PROFILES;

    fn steered(intent: Intent) -> (Objective, Boxes) {
        let natural = PROFILES[1];
        let (mut objective, mut boxes) = ((natural.objective)(), (natural.boxes)());
        intent.steer(&mut objective, &mut boxes).unwrap();
        (objective, boxes)
    }

    #[test]
    fn wanting_nothing_changes_nothing_and_wishes_make_valid_settings() {
        for profile in PROFILES {
            let usual = ((profile.objective)(), (profile.boxes)());
            let (mut objective, mut boxes) = usual;
            Intent::default().steer(&mut objective, &mut boxes).unwrap();
            assert_eq!((objective, boxes), usual);
            for mood in Mood::ALL {
                for step in [-2.0, -0.5, 2.0] {
                    let (mut objective, mut boxes) = usual;
                    let intent = Intent { brightness: step, contrast: step, mood, below: false };
                    intent.steer(&mut objective, &mut boxes).unwrap();
                    objective.check().unwrap();
                    crate::lighting::genome::Genome::new(profile.roles, profile.kind, &boxes)
                        .unwrap();
                }
            }
        }
    }

    #[test]
    fn wishes_add_up() {
        let both = Intent { brightness: 1.0, mood: Mood::Dramatic, ..Intent::default() };
        let dramatic = Intent { brightness: 0.0, ..both };
        let [with, without] = [both, dramatic].map(|intent| steered(intent).0.mean_stops);
        assert!((with - without - STEP_STOPS).abs() < 1e-6, "{with} {without}");
        let fill = |contrast| {
            let (_, boxes) = steered(Intent { contrast, ..Intent::default() });
            boxes.fill.diffuse
        };
        assert!(fill(1.0).high < fill(0.0).high && fill(0.0).high < fill(-1.0).high);
        assert!(fill(-2.0).high <= FILL_MOST);
    }

    #[test]
    fn steps_out_of_range_are_refused() {
        for (brightness, contrast, name) in
            [(2.1, 0.0, "brightness"), (0.0, -3.0, "contrast"), (f32::NAN, 0.0, "brightness")]
        {
            let fault = Intent { brightness, contrast, ..Intent::default() }.check().unwrap_err();
            assert!(fault.is_input() && fault.to_string().contains(name), "{fault}");
        }
        assert!("moody".parse::<Mood>().unwrap_err().contains("soft, natural, dramatic"));
    }
}
