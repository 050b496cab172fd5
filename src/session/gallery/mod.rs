//! How a gallery is made: a design's search, a dispersion of what it has looked at, and of the good rigs those that are
//! least alike.

mod judge;
mod write;

use super::designer::{bound, first_rig, search_from, within_time};
use super::views::small_evaluator;
use super::{Session, milliseconds};
use crate::design::dispersion::{Candidate, Dispersion, near};
use crate::design::gallery::{Picture, farthest, polished, positions};
use crate::design::{CoarseSettings, Journal, Outcome, Progress, start};
use crate::error::within;
use crate::lighting::genome::Genome;
use crate::lighting::{Light, Population, Rig, Role};
use crate::math::range::Range;
use crate::objective::Quality;
use crate::optimize::Record;
use crate::report::json::{Alternative, LightRecord};
use crate::scene::view::View;
use anyhow::Result;
use judge::{Eye, Judge};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::time::Instant;
pub use write::{RECORD, names, picked, write};
pub(super) use write::{drawn, thumbnails};

/// Most rigs of a gallery: their numbers have two digits.
pub const MOST: usize = 99;

/// How much above the lowest score a rig's may be, where nobody says it.
pub const SLACK: f32 = 0.12;

/// Generations of the dispersion.
pub const GENERATIONS: usize = 60;

/// Longest side of the pictures in which the dispersion judges rigs, pixels.
const JUDGED: u32 = 96;

/// Most rigs that are taken over from a search.
const TAKEN: usize = 2048;

/// Rigs from anywhere with which a dispersion begins that no search was before.
const SCATTERED: usize = 512;

/// Share of a range in which rigs are near another.
const NEAR: f32 = 0.15;

/// Share of the least distance that may be given up for better scores.
const KEPT_DISTANCE: f32 = 0.8;

/// The stream of the seed's random numbers that disperses.
const STREAM: u64 = 1 << 32;

/// How a search stands that has not begun.
const NOTHING: Progress = Progress {
    generation: 0,
    evaluations: 0,
    best: f32::INFINITY,
    mean: f32::INFINITY,
    worst: f32::INFINITY,
    step: 1,
};

/// How many rigs are wanted, and how good ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Rigs at most, 2 to [`MOST`].
    pub count: usize,
    /// How much their scores may lie above the lowest, 0 to 1.
    pub slack: f32,
}

impl Wanted {
    /// # Errors
    /// [`crate::Error::Argument`] for a value out of its range.
    pub fn check(&self) -> crate::Result<()> {
        within("count", self.count as f32, 2.0, MOST as f32)?;
        within("slack", self.slack, 0.0, 1.0)
    }
}

/// Where a dispersion begins.
#[derive(Debug)]
pub struct Origin {
    genome: Genome,
    /// The ranges that it stays in.
    bounds: Vec<Range>,
    /// The rig that is shown in any case.
    first: Rig,
    /// Other chromosomes to begin with.
    others: Vec<Vec<f32>>,
    /// How the search stood that found them, and when it began.
    progress: Progress,
    begin: Instant,
}

/// A rig of a gallery.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The rig.
    pub rig: Rig,
    /// Its quality in the whole picture.
    pub quality: Quality,
    /// Whether the gallery was made around it: the design's best, or the one that was picked.
    pub first: bool,
    picture: Picture,
}

impl Shown {
    /// As `result.json` has it.
    pub(super) fn alternative(&self, view: &View) -> Alternative {
        Alternative { quality: self.quality, lights: LightRecord::rig(&self.rig, view) }
    }
}

/// Good and different rigs.
#[derive(Debug, Clone)]
pub struct Gallery {
    /// The rigs, best first.
    pub rigs: Vec<Shown>,
    /// Rigs that were evaluated, by the search before too.
    pub evaluations: usize,
    /// Whether the observer or the time ended it.
    pub stopped: bool,
}

impl Gallery {
    /// All but the one that it was made around.
    pub(super) fn others(&self) -> Vec<Shown> {
        self.rigs.iter().filter(|shown| !shown.first).cloned().collect()
    }

    /// The distance of each two pictures, in the order of the rigs: see [`Picture::distance`].
    pub fn distances(&self) -> Vec<Vec<f32>> {
        let row = |a: &Shown| self.rigs.iter().map(|b| a.picture.distance(&b.picture)).collect();
        self.rigs.iter().map(row).collect()
    }

    /// Their places on a map, on which what is alike is near: see [`positions`].
    pub fn positions(&self) -> Vec<[f32; 2]> {
        positions(&self.distances())
    }
}

/// Searches the lights as [`super::designer::search`] does, to the same bits, and keeps what a dispersion goes on from.
///
/// # Errors
/// The same.
pub fn search(
    session: &mut Session,
    genome: &Genome,
    journal: Option<&RefCell<Journal>>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(Outcome, Origin)> {
    let begin = Instant::now();
    let rig = first_rig(session)?;
    let genome = bound(session, genome, rig.clone())?;
    let record = Record::new(genome.bounds());
    let recorded = (journal, Some(record.clone()));
    let outcome = search_from(session, (&genome, rig.as_deref()), recorded, observe)?;
    let origin = Origin {
        bounds: genome.bounds().to_vec(),
        genome,
        first: outcome.rig.clone(),
        others: record.best(TAKEN),
        progress: outcome.history.last().map_or(NOTHING, |last| *last),
        begin,
    };
    Ok((outcome, origin))
}

/// What is near a rig, whose lights of the scene's own do not count.
///
/// # Errors
/// Faults of the settings, and [`crate::Error::Argument`] for a rig of another number of lights than is searched.
pub fn around(session: &mut Session, genome: &Genome, rig: &[Light]) -> Result<Origin> {
    let begin = Instant::now();
    let rig: Rig = rig.iter().filter(|light| light.role != Role::Scene).copied().collect();
    let first = first_rig(session)?;
    let genome = bound(session, genome, first)?;
    let chromosome = start::from_rig(&genome, &rig)?;
    Ok(Origin {
        bounds: near(genome.bounds(), &chromosome, NEAR),
        first: genome.decode(&chromosome),
        genome,
        others: Vec::new(),
        progress: NOTHING,
        begin,
    })
}

/// All that a genome has, with a rig of it that is shown in any case, and no search before.
pub fn from_anywhere(session: &Session, genome: &Genome, rig: &[Light]) -> Origin {
    let mut rng = ChaCha8Rng::seed_from_u64(session.settings.seed);
    let mut any = || genome.bounds().iter().map(|range| range.uniform(&mut rng)).collect();
    Origin {
        bounds: genome.bounds().to_vec(),
        genome: genome.clone(),
        first: rig.to_vec(),
        others: (0..SCATTERED).map(|_| any()).collect(),
        progress: NOTHING,
        begin: Instant::now(),
    }
}

/// Disperses what is good, `observe` being called after every generation, until the settings' time is over; then chooses
/// the rigs that are shown, judged in whole pictures. There may be fewer than are wanted.
///
/// # Errors
/// What the device reports.
pub fn disperse(
    session: &mut Session,
    origin: &Origin,
    wanted: Wanted,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Gallery> {
    let mut watch = within_time(session, origin.begin, observe);
    let eye = Eye::new(session)?;
    let whole = [session.view.width, session.view.height];
    let sizes = CoarseSettings { side: JUDGED, ..CoarseSettings::NONE }.steps(whole);
    let device = session.device.clone();
    let small = sizes.first().map(|&step| small_evaluator(session, &device, step));
    let mut small = small.transpose()?.flatten();
    let step = small.as_ref().map_or(1, |_| sizes[0]);
    let mut rng = ChaCha8Rng::seed_from_u64(session.settings.seed);
    rng.set_stream(STREAM);
    let evaluator = small.as_mut().unwrap_or(&mut session.evaluator);
    let mut judge = Judge { genome: &origin.genome, eye: &eye, evaluator };
    let mut dispersion = Dispersion::new(
        &origin.bounds,
        judge.one(origin.genome.encode(&origin.first))?,
        (wanted.count, wanted.slack),
        rng,
    );
    judge.offer(&mut dispersion, origin.others.clone())?;
    let mut progress = Progress { step, ..origin.progress };
    let before = progress.generation;
    progress.evaluations += 1 + origin.others.len();
    while progress.generation < before + GENERATIONS && watch(&progress).is_continue() {
        let asked = dispersion.ask();
        progress.evaluations += asked.len();
        progress.generation += 1;
        judge.offer(&mut dispersion, asked)?;
        progress.best = dispersion.limit() - wanted.slack;
    }
    let stopped = progress.generation < before + GENERATIONS;
    let evaluations = progress.evaluations + dispersion.candidates().len();
    let rigs = choose(session, origin, dispersion.candidates(), wanted)?;
    session.timing.search = milliseconds(origin.begin);
    Ok(Gallery { rigs, evaluations, stopped })
}

/// The candidates that are shown, best first: judged in whole pictures, of which the small ones tell the scores nearly.
fn choose(
    session: &mut Session,
    origin: &Origin,
    candidates: &[Candidate],
    wanted: Wanted,
) -> Result<Vec<Shown>> {
    let rig = |one: &Candidate| origin.genome.decode(&one.chromosome);
    let mut rigs: Vec<Rig> = candidates.iter().map(rig).collect();
    if let Some(first) = rigs.first_mut() {
        first.clone_from(&origin.first);
    }
    let population = Population::of(rigs.iter().map(Vec::as_slice))?;
    let qualities = session.evaluator.qualities(&population)?;
    let lowest = qualities.iter().map(|quality| quality.score).fold(f32::INFINITY, f32::min);
    let good: Vec<usize> = (0..rigs.len())
        .filter(|&at| at == 0 || qualities[at].score <= lowest + wanted.slack)
        .collect();
    let apart =
        |a: usize, b: usize| candidates[good[a]].picture.distance(&candidates[good[b]].picture);
    let scores: Vec<f32> = good.iter().map(|&at| qualities[at].score).collect();
    let chosen = farthest(good.len(), 0, wanted.count, apart);
    let chosen = polished(&chosen, &scores, KEPT_DISTANCE, apart);
    let shown = |at: usize| Shown {
        rig: rigs[good[at]].clone(),
        quality: qualities[good[at]],
        first: good[at] == 0,
        picture: candidates[good[at]].picture.clone(),
    };
    let mut shown: Vec<Shown> = chosen.into_iter().map(shown).collect();
    shown.sort_by(|a, b| a.quality.score.total_cmp(&b.quality.score));
    Ok(shown)
}

#[cfg(test)]
mod tests;
