//! The greedy search of Shacked and Lischinski (2001), section 5: steepest descent from one or more
//! starts, on alleles scaled to 0..1. All probes of a step, and those of all starts, are asked for
//! together.

use super::start::{StartSettings, population};
use super::{Best, Entry, Optimizer, Setup};
use crate::math::range::Range;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Its name in settings.
pub const NAME: &str = "greedy";

pub(super) const ENTRY: Entry = Entry {
    name: NAME,
    title: "greedy descents",
    description: "The steepest descent of Shacked and Lischinski, from one or more starts",
    new: |Setup { bounds, first, settings, mut rng }| {
        let uniform = StartSettings { scattered: 0.0, ..settings.start };
        let starts = population(bounds, first, settings.greedy.starts, &uniform, &mut rng);
        Ok(Box::new(Descent::new(bounds, &starts, settings.greedy.descent())?))
    },
    generations: |_| None,
    words: |settings| format!("greedy descents from {} starts", settings.greedy.starts),
};

/// Most starts, whose probes are evaluated together.
const MAX_STARTS: usize = 1 << 10;

/// The greedy search as settings name it: its starts, and its descents.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GreedySettings {
    /// Descents side by side, 1 to 1024: the first from the first individual, the others from uniform
    /// random ones.
    pub starts: usize,
    /// Distance of the probes of a central difference, as a share of each allele's range.
    pub probe: f32,
    /// Length of the first step, as such a share.
    pub step: f32,
    /// Length of a step below which a descent has ended.
    pub end: f32,
}

impl Default for GreedySettings {
    fn default() -> Self {
        let DescentSettings { probe, step, end } = DescentSettings::default();
        Self { starts: 1, probe, step, end }
    }
}

impl GreedySettings {
    /// The descents' own part.
    pub fn descent(&self) -> DescentSettings {
        DescentSettings { probe: self.probe, step: self.step, end: self.end }
    }

    /// # Errors
    /// [`Error::Argument`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        let starts = self.starts;
        if !(1..=MAX_STARTS).contains(&starts) {
            let fault = format!("greedy.starts is {starts}: it must be 1 to {MAX_STARTS}");
            return Err(Error::Argument(fault));
        }
        self.descent().check()
    }
}

/// Settings of a descent, in shares of each allele's range. The numbers are our reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DescentSettings {
    /// Distance of the probes of a central difference.
    pub probe: f32,
    /// Length of the first step; halved whenever the score does not fall.
    pub step: f32,
    /// Length of a step below which a descent has ended.
    pub end: f32,
}

impl Default for DescentSettings {
    fn default() -> Self {
        Self { probe: 0.005, step: 0.1, end: 1e-3 }
    }
}

impl DescentSettings {
    /// # Errors
    /// [`Error::Argument`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        for (name, share) in [("probe", self.probe), ("step", self.step), ("end", self.end)] {
            if !(share > 0.0 && share <= 1.0) {
                return Err(Error::Argument(format!(
                    "{name} {share} is not a share above 0, to 1"
                )));
            }
        }
        Ok(())
    }
}

/// The search's state: one walker for each start.
#[derive(Debug, Clone)]
pub struct Descent {
    settings: DescentSettings,
    bounds: Vec<Range>,
    walkers: Vec<Walker>,
    /// Chromosomes that wait for their scores, walker after walker.
    asked: Vec<Vec<f32>>,
    /// Current score of each walker.
    scores: Vec<f32>,
    /// Of all that was scored: a probe may lie below the place where its walker stands.
    best: Best,
}

/// One descent.
#[derive(Debug, Clone)]
struct Walker {
    /// Where it stands, scaled to 0..=1, and as a chromosome.
    at: Vec<f32>,
    chromosome: Vec<f32>,
    score: f32,
    step: f32,
    phase: Phase,
}

/// What a walker waits for.
#[derive(Debug, Clone)]
enum Phase {
    /// The score of its start.
    Start,
    /// The scores on both sides of each allele.
    Probes,
    /// The score of a step in this unit direction.
    Step(Vec<f32>),
    /// Nothing.
    Ended,
}

impl Descent {
    /// A search that descends from each of `starts`, all inside `bounds`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a setting out of its range, or no start.
    pub fn new(bounds: &[Range], starts: &[Vec<f32>], settings: DescentSettings) -> Result<Self> {
        settings.check()?;
        if starts.is_empty() {
            return Err(Error::Argument("a descent needs a start".into()));
        }
        Ok(Self::begin(bounds.to_vec(), starts.to_vec(), settings))
    }

    /// As [`Descent::new`], with settings that have passed their check.
    pub(super) fn begin(
        bounds: Vec<Range>,
        starts: Vec<Vec<f32>>,
        settings: DescentSettings,
    ) -> Self {
        let scaled = |chromosome: &Vec<f32>| {
            bounds.iter().zip(chromosome).map(|(range, &value)| range.share(value)).collect()
        };
        let walker = |chromosome: &Vec<f32>| Walker {
            at: scaled(chromosome),
            chromosome: chromosome.clone(),
            score: f32::INFINITY,
            step: settings.step,
            phase: Phase::Start,
        };
        let walkers: Vec<_> = starts.iter().map(walker).collect();
        let scores = vec![f32::INFINITY; walkers.len()];
        Self { settings, bounds, walkers, asked: starts, scores, best: Best::default() }
    }

    /// Where each descent stands and its score, in the order of the starts.
    pub fn positions(&self) -> impl Iterator<Item = (&[f32], f32)> {
        self.walkers.iter().map(|walker| (walker.chromosome.as_slice(), walker.score))
    }

    fn chromosome(&self, scaled: &[f32]) -> Vec<f32> {
        self.bounds.iter().zip(scaled).map(|(range, &share)| range.at(share)).collect()
    }

    /// What a walker asks for.
    fn questions(&self, walker: &Walker) -> Vec<Vec<f32>> {
        match &walker.phase {
            Phase::Start => vec![walker.chromosome.clone()],
            Phase::Probes => {
                let probes = |i: usize| walker.probes(i, self.settings.probe);
                let places = (0..walker.at.len()).flat_map(probes);
                places.map(|place| self.chromosome(&place)).collect()
            }
            Phase::Step(direction) => vec![self.chromosome(&walker.stepped(direction))],
            Phase::Ended => Vec::new(),
        }
    }
}

impl Walker {
    /// Both sides of allele `i`, as far as the box reaches.
    fn probes(&self, i: usize, distance: f32) -> [Vec<f32>; 2] {
        [-distance, distance].map(|offset| {
            let mut place = self.at.clone();
            place[i] = (place[i] + offset).clamp(0.0, 1.0);
            place
        })
    }

    /// A step in `direction`, stopped by the box's sides.
    fn stepped(&self, direction: &[f32]) -> Vec<f32> {
        let step = |(&at, &d): (&f32, &f32)| (at + self.step * d).clamp(0.0, 1.0);
        self.at.iter().zip(direction).map(step).collect()
    }

    /// The unit direction of steepest descent that does not lead out of the box, from the scores of
    /// the probes; `None` on level ground.
    fn downhill(&self, scores: &[f32], distance: f32) -> Option<Vec<f32>> {
        let slope = |(i, pair): (usize, &[f32])| {
            let [low, high] = self.probes(i, distance).map(|place| place[i]);
            let down = -(pair[1] - pair[0]) / (high - low);
            let blocked = (self.at[i] <= 0.0 && down < 0.0) || (self.at[i] >= 1.0 && down > 0.0);
            if blocked { 0.0 } else { down }
        };
        let slopes: Vec<f32> = scores.chunks_exact(2).enumerate().map(slope).collect();
        let length = slopes.iter().map(|s| s * s).sum::<f32>().sqrt();
        (length > 0.0 && length.is_finite()).then(|| slopes.iter().map(|s| s / length).collect())
    }

    /// Takes the answers to its questions.
    fn advance(&mut self, scores: &[f32], asked: &[Vec<f32>], settings: &DescentSettings) {
        match std::mem::replace(&mut self.phase, Phase::Ended) {
            Phase::Start => {
                self.score = scores[0];
                self.phase = Phase::Probes;
            }
            Phase::Probes => {
                if let Some(direction) = self.downhill(scores, settings.probe) {
                    self.phase = Phase::Step(direction);
                }
            }
            Phase::Step(direction) if scores[0] < self.score => {
                self.at = self.stepped(&direction);
                self.chromosome.clone_from(&asked[0]);
                self.score = scores[0];
                self.phase = Phase::Probes;
            }
            Phase::Step(direction) => {
                self.step /= 2.0;
                if self.step >= settings.end {
                    self.phase = Phase::Step(direction);
                }
            }
            Phase::Ended => {}
        }
    }
}

impl Optimizer for Descent {
    fn name(&self) -> &'static str {
        NAME
    }

    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        let asked = std::mem::take(&mut self.asked);
        self.best.offer_all(&asked, scores);
        let alleles = self.bounds.len();
        let mut from = 0;
        for walker in &mut self.walkers {
            let questions = match walker.phase {
                Phase::Start | Phase::Step(_) => 1,
                Phase::Probes => 2 * alleles,
                Phase::Ended => 0,
            };
            let answers = from..from + questions;
            walker.advance(&scores[answers.clone()], &asked[answers.clone()], &self.settings);
            from = answers.end;
        }
        self.scores = self.walkers.iter().map(|walker| walker.score).collect();
        self.asked = self.walkers.iter().flat_map(|walker| self.questions(walker)).collect();
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    /// Every descent begins anew where it stands.
    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        let walkers = std::mem::take(&mut self.walkers);
        let starts = walkers.iter().map(|walker| change(&walker.chromosome)).collect();
        *self = Self::begin(std::mem::take(&mut self.bounds), starts, self.settings);
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A tilted, rippled bowl with its lowest point outside or inside the box, as `middle` says.
    fn bowl(x: &[f32], middle: f32) -> f32 {
        let term = |(i, x): (usize, &f32)| {
            (1.0 + i as f32) * (x - middle).powi(2) + 0.05 * (9.0 * x).sin()
        };
        x.iter().enumerate().map(term).sum()
    }

    proptest! {
        #[test]
        fn every_accepted_step_descends_inside_the_box(
            starts in prop::collection::vec(prop::collection::vec(0f32..=1.0, 4), 1..5),
            middle in -1f32..2.0,
        ) {
            let bounds = [(-1.0, 1.0), (0.0, 2.0), (0.5, 0.5), (3.0, 3.5)].map(|(low, high)| Range::new(low, high));
            let place = |start: &Vec<f32>| std::iter::zip(&bounds, start).map(|(r, &t)| r.at(t)).collect();
            let starts: Vec<Vec<f32>> = starts.iter().map(place).collect();
            let mut search = Descent::new(&bounds, &starts, DescentSettings::default()).unwrap();
            let mut rounds = 0;
            while !search.ask().is_empty() {
                for chromosome in search.ask() {
                    prop_assert!(bounds.iter().zip(chromosome).all(|(r, &x)| r.contains(x)));
                }
                let before: Vec<_> = search.positions().map(|(x, f)| (x.to_vec(), f)).collect();
                let scores: Vec<f32> = search.ask().iter().map(|x| bowl(x, middle)).collect();
                search.tell(&scores);
                for ((x, score), (old, old_score)) in search.positions().zip(&before) {
                    prop_assert!(score < *old_score || (x == old && score == *old_score));
                    prop_assert_eq!(score, bowl(x, middle));
                }
                rounds += 1;
                prop_assert!(rounds < 10_000);
            }
        }
    }

    #[test]
    fn slopes_are_right_where_the_box_cuts_a_probe_off() {
        let at = vec![0.0, 0.98, 0.5, 1.0];
        let (chromosome, phase) = (at.clone(), Phase::Probes);
        let walker = Walker { at, chromosome, score: 0.0, step: 0.1, phase };
        let plane = |x: &[f32]| -2.0 * x[0] + x[1] + 2.0 * x[2] - 3.0 * x[3];
        let scores: Vec<f32> =
            (0..4).flat_map(|i| walker.probes(i, 0.05)).map(|x| plane(&x)).collect();
        // The last would lead out of the box.
        let down = walker.downhill(&scores, 0.05).unwrap();
        let near = |(a, b): (&f32, f32)| (a - b).abs() < 1e-4;
        let expected = [2.0 / 3.0, -1.0 / 3.0, -2.0 / 3.0, 0.0];
        assert!(down.iter().zip(expected).all(near), "{down:?}");
        assert_eq!(walker.downhill(&[0.3; 8], 0.05), None);
    }

    #[test]
    fn it_ends_at_the_bottom_of_the_start_s_own_valley() {
        let bounds = [Range::new(-2.0, 2.0)];
        let two_valleys = |x: f32| (x * x - 1.0).powi(2) + 0.1 * x;
        let starts = [vec![-1.6], vec![0.4]];
        let mut search = Descent::new(&bounds, &starts, DescentSettings::default()).unwrap();
        while !search.ask().is_empty() {
            let scores: Vec<f32> = search.ask().iter().map(|x| two_valleys(x[0])).collect();
            search.tell(&scores);
        }
        let ends: Vec<f32> = search.positions().map(|(x, _)| x[0]).collect();
        assert!((ends[0] + 1.01).abs() < 0.01 && (ends[1] - 0.987).abs() < 0.01, "{ends:?}");
        let best = search.best().unwrap().0[0];
        assert!((best - ends[0]).abs() <= 0.005 * 4.0, "{best}");
    }

    #[test]
    fn all_probes_of_all_starts_are_asked_for_together() {
        let bounds = [Range::new(0.0, 1.0); 5];
        let starts = vec![vec![0.5; 5]; 3];
        let mut search = Descent::new(&bounds, &starts, DescentSettings::default()).unwrap();
        assert_eq!(search.ask().len(), 3);
        search.tell(&[0.3; 3]);
        assert_eq!(search.ask().len(), 3 * 2 * 5);
    }

    #[test]
    fn a_batch_gives_each_start_what_it_gets_alone() {
        let bounds = [Range::new(0.0, 1.0); 3];
        let starts = [vec![0.9, 0.1, 0.4], vec![0.2, 0.2, 0.2], vec![0.5, 1.0, 0.0]];
        let run = |starts: &[Vec<f32>]| {
            let mut search = Descent::new(&bounds, starts, DescentSettings::default()).unwrap();
            while !search.ask().is_empty() {
                let scores: Vec<f32> = search.ask().iter().map(|x| bowl(x, 0.3)).collect();
                search.tell(&scores);
            }
            search.positions().map(|(x, f)| (x.to_vec(), f)).collect::<Vec<_>>()
        };
        let alone: Vec<_> = starts.iter().flat_map(|s| run(std::slice::from_ref(s))).collect();
        assert_eq!(run(&starts), alone);
    }
}
