//! What the tests of searches measure with.

use crate::Result;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::lighting::genome::{Boxes, Genome};
use crate::lighting::{Light, LightKind, LightRecord, Population, Role};
use crate::objective::Quality;
use crate::objective::maps::Maps;
use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

/// Scores rigs by where their lights stand: a landscape of several valleys.
pub struct Hills {
    /// Populations so far.
    pub calls: usize,
    /// What is added to every score.
    pub base: f32,
    /// The rig of each population whose score is not a number.
    pub bottomless: Option<usize>,
    /// A clock that the calls turn on.
    pub clock: Rc<Cell<Duration>>,
    /// By how much the call of that number, from 0, does.
    pub cost: fn(usize) -> Duration,
}

impl Default for Hills {
    fn default() -> Self {
        Self {
            calls: 0,
            base: 0.0,
            bottomless: None,
            clock: Rc::default(),
            cost: |_| Duration::ZERO,
        }
    }
}

/// The score of a rig.
pub fn height(rig: &[LightRecord]) -> f32 {
    let hill = |l: &LightRecord| {
        let [x, y, z] = l.position;
        (1.7 * x).sin() * (1.3 * y).cos() + 0.05 * z + 0.1 * (l.diffuse - 0.4).powi(2)
    };
    rig.iter().map(hill).sum()
}

/// A rig of two point lights.
pub fn genome() -> Genome {
    Genome::new(&[Role::Key, Role::Fill], LightKind::POINT, &Boxes::default()).unwrap()
}

impl Evaluator for Hills {
    fn device(&self) -> &DeviceInfo {
        unreachable!("searches only evaluate")
    }
    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.clock.set(self.clock.get() + (self.cost)(self.calls));
        self.calls += 1;
        let rigs = population.rigs().zip(&mut *scores);
        rigs.for_each(|(rig, score)| *score = self.base + height(rig));
        if let Some(rig) = self.bottomless {
            scores[rig] = f32::NAN;
        }
        Ok(())
    }
    fn qualities(&mut self, _: &Population) -> Result<Vec<Quality>> {
        unreachable!("searches only evaluate")
    }
    fn inspect(&mut self, _: &[Light]) -> Result<Inspection> {
        unreachable!("searches only evaluate")
    }
    fn maps(&mut self) -> Result<&Maps> {
        unreachable!("searches only evaluate")
    }
}
