//! How a design is made, one or many: the search, and all files that it leaves behind.

use super::config::{First, Settings};
use super::device::Opened;
use super::gallery::{self, Gallery};
use super::views::{self, small_evaluator};
use super::{Engine, Session, intent, milliseconds, warn};
use crate::design::coarse::{Small, run_coarse_first};
use crate::design::{self, Dome, Journal, Outcome, Progress, Remembered, start};
use crate::lighting::genome::Genome;
use crate::lighting::presets::Preset;
use crate::lighting::{Light, MAX_LIGHTS, Rig, Role, Stand};
use crate::optimize::{self, Optimizer, Record, Recorded, Setup};
use crate::render::Picture;
use crate::report::gallery::Thumbnail;
use crate::report::html::{Sheet, Shown, light_ratio};
use crate::report::json::{self, Design};
use crate::report::{Staging, csv, picture, plot};
use crate::scene;
use crate::scene::view::View;
use anyhow::{Result, anyhow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::time::Instant;

/// The lit scene.
pub const LIT: &str = "lit.glb";

/// The result.
pub const RESULT: &str = "result.json";

/// All files of a design.
pub const FILES: [&str; 7] =
    ["best.png", "headlight.png", "report.html", LIT, "convergence.csv", "convergence.svg", RESULT];

/// Size of `convergence.svg`.
const PLOT: (u32, u32) = (800, 480);

/// The individual that the search of the settings begins with.
///
/// # Errors
/// What the device reports, and a rig with another number of lights than the genome's.
pub fn beginning(session: &mut Session, genome: &Genome) -> Result<Vec<f32>> {
    let rig = first_rig(session)?;
    first(session, genome, rig.as_deref(), &mut ChaCha8Rng::seed_from_u64(session.settings.seed))
}

/// The individual that the search begins with; `rig` is the one that the settings name.
fn first(
    session: &mut Session,
    genome: &Genome,
    rig: Option<&[Light]>,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<f32>> {
    match rig {
        Some(rig) => Ok(start::from_rig(genome, rig)?),
        None if session.settings.first == First::Random => {
            Ok(genome.bounds().iter().map(|range| range.uniform(rng)).collect())
        }
        None => {
            let maps = session.evaluator.maps()?;
            Ok(start::first(&session.scene, &session.view, maps, genome, rng))
        }
    }
}

/// The rig that the settings name to begin with.
pub(super) fn first_rig(session: &Session) -> Result<Option<Rig>> {
    Ok(match session.settings.first {
        First::KMeans | First::Random => None,
        First::Scene => {
            let (mut rig, warnings) = scene::lights::rig(&session.scene, &session.view)?;
            warn(&warnings);
            rig.retain(|light| light.role != Role::Scene);
            Some(rig)
        }
        First::Headlight => Some(Preset::Headlight.rig()),
        First::LightKit => Some(Preset::LightKit.rig()),
        First::ThreePoint => Some(Preset::ThreePoint.rig()),
    })
}

/// The search that the settings ask for, `count` of them side by side.
pub(super) fn optimizer(
    session: &mut Session,
    (genome, rig): (&Genome, Option<&[Light]>),
    count: u32,
) -> Result<Box<dyn Optimizer>> {
    let mut rng = ChaCha8Rng::seed_from_u64(session.settings.seed);
    let first = first(session, genome, rig, &mut rng)?;
    let (name, settings) = (session.settings.optimizer.0.name, &session.settings.optimizers());
    let setup = Setup { bounds: genome.bounds(), first, settings, rng };
    Ok(optimize::side_by_side(name, &setup, count, session.settings.coarse.settled)?)
}

/// What measures the small pictures that a search begins with, and how many generations there are in all; none where the
/// settings do without, the optimizer does not count generations, or nothing of the scene is seen in one of them.
fn coarse_generations(session: &mut Session) -> Result<Option<(Vec<Small<Engine>>, usize)>> {
    let steps = session.settings.coarse.steps([session.view.width, session.view.height]);
    let generations = (session.settings.optimizer.0.generations)(&session.settings.optimizers());
    let Some(generations) = generations.filter(|_| !steps.is_empty()) else { return Ok(None) };
    let device = session.device.clone();
    let small = |step| {
        let small = small_evaluator(session, &device, step)?;
        Ok(small.map(|evaluator| Small { step, evaluator }))
    };
    let all: Result<Option<Vec<_>>> = steps.into_iter().map(small).collect();
    Ok(all?.map(|all| (all, generations)))
}

/// `observe`, and the end when the time that the settings give a search is over, which began at `start`.
pub(super) fn within_time<'a>(
    session: &Session,
    start: Instant,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> impl FnMut(&Progress) -> ControlFlow<()> + use<'a> {
    let limit = session.settings.time_limit;
    move |progress| match observe(progress) {
        _ if limit.is_some_and(|limit| start.elapsed().as_secs_f64() >= limit) => {
            ControlFlow::Break(())
        }
        flow => flow,
    }
}

/// Searches the lights, `observe` being called after every generation, until the settings' time is over. What the
/// `journal` remembers is not measured again.
///
/// # Errors
/// Faults of the settings, and what the device reports.
pub fn search(
    session: &mut Session,
    genome: &Genome,
    journal: Option<&RefCell<Journal>>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let rig = first_rig(session)?;
    let genome = bound(session, genome, rig.clone())?;
    if session.settings.lights.one_by_one {
        return one_after_another(session, (&genome, rig), journal, observe);
    }
    search_from(session, (&genome, rig.as_deref()), (journal, None), observe)
}

/// Searches the lights one after another; each has the same part of the time.
fn one_after_another(
    session: &mut Session,
    (genome, rig): (&Genome, Option<Rig>),
    journal: Option<&RefCell<Journal>>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let begin = Instant::now();
    let limit = session.settings.time_limit;
    session.settings.time_limit = limit.map(|limit| limit / genome.lights() as f64);
    let rig = rig.map(|rig| start::matched(genome, &rig)).transpose()?;
    let found = design::one_by_one(genome, observe, &mut |genome, observe| {
        let rig = rig.as_ref().map(|rig| &rig[..genome.lights()]);
        search_from(session, (genome, rig), (journal, None), observe)
    });
    session.settings.time_limit = limit;
    session.timing.search = milliseconds(begin);
    found
}

/// The genome of a session's search: with the lights that are kept, of the rig `first` too, and its horizon.
///
/// # Errors
/// Faults of the settings.
pub(super) fn bound(session: &mut Session, genome: &Genome, first: Option<Rig>) -> Result<Genome> {
    let genome = intent::bound(session, session.complete(genome)?, first)?;
    session.with_highlights(genome)
}

/// As [`search`], of a genome of [`bound`]. What is looked at goes into the `record`.
pub(super) fn search_from(
    session: &mut Session,
    (genome, rig): (&Genome, Option<&[Light]>),
    (journal, record): (Option<&RefCell<Journal>>, Option<Record>),
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let start = Instant::now();
    let coarse = coarse_generations(session)?;
    let count = coarse.as_ref().map_or(1, |_| session.settings.coarse.searches);
    let mut search = optimizer(session, (genome, rig), count)?;
    if let Some(record) = record {
        search = Box::new(Recorded::new(search, record));
    }
    let settings = session.settings.coarse;
    let mut watch = within_time(session, start, observe);
    let evaluator = &mut Remembered::new(&mut *session.evaluator, journal, 1);
    let outcome = match coarse {
        Some((mut small, generations)) => {
            let small = small.iter_mut().map(|Small { step, evaluator }| Small {
                step: *step,
                evaluator: Remembered::new(&mut **evaluator, journal, *step),
            });
            let mut small: Vec<_> = small.collect();
            run_coarse_first(
                &mut *search,
                genome,
                (&mut small, evaluator),
                (&settings, generations),
                &mut watch,
            )?
        }
        None => design::run(&mut *search, genome, evaluator, &mut watch)?,
    };
    session.timing.search = milliseconds(start);
    Ok(outcome)
}

/// The search's settings in words.
pub(super) fn in_words(settings: &Settings) -> String {
    let words = (settings.optimizer.0.words)(&settings.optimizers());
    let intent = settings.intent.words();
    format!("profile {}, seed {}, {intent}{words}", settings.profile.0.name, settings.seed)
}

/// Most pixels of a side of the pictures under usual rigs that the report alone shows,
const COMPARED: u32 = 384;
/// and most samples of a pixel of theirs.
const COMPARED_SAMPLES: u32 = 4;

/// The final pictures under a headlight, under the designed rig, and under the other usual rigs.
///
/// # Errors
/// What the device reports, and as [`Session::render`].
fn pictures(session: &mut Session, rig: &[Light]) -> Result<Vec<Shown>> {
    let whole = session.view.clone();
    let small = whole.shrunk(&session.scene, COMPARED)?;
    let preset = |preset: Preset| (preset.title(), session.with_kept(preset.rig()));
    let headlight = preset(Preset::Headlight);
    let mut others = [Preset::LightKit, Preset::ThreePoint].map(preset).to_vec();
    // With many lights that are kept there may be no room for it.
    others.retain(|(_, rig)| rig.len() <= MAX_LIGHTS);

    let stand = session.settings.views.rig;
    let rigs = vec![(headlight, Stand::Camera), (("Designed", rig.to_vec()), stand)];
    let mut pictures = shown(session, &whole, rigs)?;
    pictures[1].designed = true;
    let samples = session.settings.picture.samples;
    session.settings.picture.samples = samples.min(COMPARED_SAMPLES);
    let others = others.into_iter().map(|other| (other, Stand::Camera)).collect();
    pictures.extend(shown(session, &small, others)?);
    session.settings.picture.samples = samples;
    Ok(pictures)
}

/// A rig with its name, and what it stands in where there are several views.
type Named = ((&'static str, Rig), Stand);

/// The final pictures of rigs.
fn shown(session: &mut Session, view: &View, rigs: Vec<Named>) -> Result<Vec<Shown>> {
    let lights: Vec<_> = rigs.iter().map(|((_, rig), _)| rig.as_slice()).collect();
    let pictures = session.render(view, &lights)?;
    let shown = |(((title, rig), stand), picture): (Named, Picture)| {
        Ok(Shown {
            title: title.to_owned(),
            designed: false,
            png: picture::final_png(&picture.image)?,
            quality: session.evaluator.judge(&rig, stand)?.0,
            ratio: light_ratio(&rig),
            burnt: picture.burnt,
            unlit: picture.unlit,
        })
    };
    rigs.into_iter().zip(pictures).map(shown).collect()
}

/// Longest side of the pictures that tell how good every direction is for a light, pixels,
const MAPPED: u32 = 64;
/// and directions that are tried in a row of the map.
const CELLS: u32 = 33;

/// How good every direction is for each light of a rig that is not the scene's own, judged natively whatever the device;
/// none where nothing of the scene is seen in pictures so small.
///
/// # Errors
/// What the evaluator reports.
fn domes(session: &mut Session, rig: &[Light]) -> Result<Vec<Dome>> {
    let step = session.view.width.max(session.view.height).div_ceil(MAPPED);
    let Some(mut small) = small_evaluator(session, &Opened::Cpu, step)? else {
        return Ok(Vec::new());
    };
    let own = rig.iter().take_while(|light| light.role != Role::Scene).count();
    Ok((0..own).map(|at| Dome::of(&mut *small, rig, at, [CELLS; 2])).collect::<Result<_, _>>()?)
}

/// Small pictures of the alternatives.
///
/// # Errors
/// As [`Session::render`].
fn alternatives<'a>(
    session: &mut Session,
    others: &'a [gallery::Shown],
) -> Result<Vec<Thumbnail<'a>>> {
    if others.is_empty() {
        return Ok(Vec::new());
    }
    let rigs: Vec<&[Light]> = others.iter().map(|other| &*other.rig).collect();
    let pictures = gallery::drawn(session, &rigs)?;
    gallery::thumbnails(others, &pictures)
}

/// The content of `result.json`, its times as they are so far.
///
/// # Errors
/// What the device reports.
pub fn result(session: &mut Session, outcome: &Outcome) -> Result<Design> {
    let headlight = session.with_kept(Preset::Headlight.rig());
    let (headlight, before) = session.evaluator.judge(&headlight, Stand::Camera)?;
    let (best, after) = session.evaluator.judge(&outcome.rig, session.settings.views.rig)?;
    let views = session.views_record(&after, &before);
    let header = session.header(Design::SCHEMA);
    let Settings { seed, objective, .. } = &session.settings;
    let mut design =
        Design::new(header, (*seed, objective), (best, headlight), outcome, &session.view);
    design.views = views;
    design.scene_lights = session.scene_lights();
    design.timing_ms = session.finish();
    design.intent = session.settings.intent;
    design.focus.clone_from(&session.settings.focus);
    design.dim.clone_from(&session.settings.dim);
    design.strokes = session.strokes.is_some();
    Ok(design)
}

/// Writes all files of a design; gives the content of `result.json`, the last of them. Rigs of `others` but the design's
/// own are its alternatives.
///
/// # Errors
/// What the device reports, and files that cannot be written.
pub fn write(
    session: &mut Session,
    (outcome, others): (&Outcome, Option<&Gallery>),
    staging: &mut Staging,
) -> Result<Design> {
    let mut design = result(session, outcome)?;
    let others = others.map_or_else(Vec::new, Gallery::others);
    design.alternatives = others.iter().map(|other| other.alternative(&session.view)).collect();
    let settings = in_words(&session.settings);

    let pictures = pictures(session, &outcome.rig)?;
    for (name, shown) in ["headlight.png", "best.png"].into_iter().zip(&pictures) {
        staging.write(name, &shown.png)?;
    }
    let sights = match session.views.len() {
        1 => Vec::new(),
        _ => views::write_pictures(session, (&outcome.rig, &pictures[1].png), staging)?,
    };
    let alternatives = alternatives(session, &others)?;
    let domes = domes(session, &outcome.rig)?;
    let sheet = Sheet {
        design: &design,
        sights: &sights,
        domes: &domes,
        alternatives: &alternatives,
        rig: &outcome.rig,
        pictures: &pictures,
        history: &outcome.history,
        settings,
        coarse: outcome.history.iter().any(|progress| progress.step > 1),
    };
    staging.write("report.html", sheet.render()?)?;
    let lit = staging.path(LIT);
    let (source, options) = (&session.scene.path, session.settings.loading());
    let standing = (&session.view, &*outcome.rig, session.settings.views.rig);
    scene::lit::write_standing(source, options, standing, &lit)?;
    staging.write("convergence.csv", csv::convergence(&outcome.history)?)?;
    let plot = plot::convergence(&outcome.history, PLOT).map_err(|e| anyhow!("plotting: {e}"))?;
    staging.write("convergence.svg", plot)?;
    design.timing_ms = session.finish();
    staging.write(RESULT, json::text(&design)?)?;
    Ok(design)
}
