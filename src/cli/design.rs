//! `klieg design`: the best lights for one scene.

use super::checkpoint::{self, CheckpointOptions};
use super::config::Settings;
use super::designer;
use super::device;
use super::options::{SceneOptions, SearchOptions, TargetOptions, completed};
use super::painter::{self, COLLAGE, Target};
use super::picture::PictureOptions;
use super::print;
use super::progress::{self, Interrupt};
use super::session::Session;
use super::session::gallery::{self, GENERATIONS, Gallery, SLACK, Wanted};
use super::views::ViewsOptions;
use crate::Error;
use crate::design::profile;
use crate::design::{Journal, Outcome, Progress};
use crate::lighting::genome::Genome;
use crate::report::json::{self, Design};
use crate::report::{Inputs, Staging};
use anyhow::Result;
use clap::Args;
use indicatif::ProgressBar;
use std::cell::RefCell;
use std::path::PathBuf;
use std::time::Instant;

/// Find the best lights for a scene
///
/// Writes best.png, headlight.png, report.html, lit.glb, result.json, convergence.csv and
/// convergence.svg; with --collage, collage.png; of several views, view-01.png and so on and turntable.png too. Ctrl-C ends the search after the running generation and writes the best so far.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    #[command(flatten)]
    views: ViewsOptions,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    search: SearchOptions,
    /// Make this picture, a PNG of the design's size and view, such as a painted-over best.png: intensities and colours
    /// of the lights are solved for, and their places searched. What is not opaque is free
    #[arg(long, value_name = "PICTURE", conflicts_with_all = ["checkpoint", "dim", "focus", "keeps", "like"])]
    target_picture: Option<PathBuf>,
    /// Make what a light collage shows, where each patch of the surface has a light of its own, with lights that shine on
    /// everything; collage.png has it
    #[arg(long, conflicts_with_all = ["alternatives", "checkpoint", "dim", "focus", "keeps", "like", "strokes", "target_picture"])]
    collage: bool,
    /// Draw where highlights and shadows are to lie: a PNG of the view's proportions, with bright strokes for highlights, dark
    /// ones for shadows, transparent elsewhere. Each highlight decides where a light stands
    #[arg(long, value_name = "PICTURE", conflicts_with_all = ["checkpoint", "dim", "focus", "target_picture"])]
    strokes: Option<PathBuf>,
    /// Look for so many other lights, good and different, 1 to 98: they stand in report.html and result.json [default: none]
    #[arg(long, value_name = "N", conflicts_with = "target_picture")]
    alternatives: Option<usize>,
    #[command(flatten)]
    checkpoint: CheckpointOptions,
    #[command(flatten)]
    picture: PictureOptions,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let settings = self.scene.settings_of(profile::DEFAULT, &self.views)?;
        let settings = completed(settings, (&self.target, &self.search, &self.picture))?;
        let painted = self.target_picture.is_some() || self.collage;
        let others = self.alternatives.is_some();
        if settings.has_views() && (others || painted || self.strokes.is_some()) {
            let fault = "--alternatives, --target-picture, --collage and --strokes look at one view: they do not go with \
                         several views";
            return Err(Error::Argument(fault.into()));
        }
        if others || painted {
            settings.check_together()?;
        }
        Ok(settings)
    }

    /// The design and its alternatives, where any are wanted.
    fn wanted(&self) -> Option<Wanted> {
        self.alternatives.map(|others| Wanted { count: others.saturating_add(1), slack: SLACK })
    }

    /// Makes the design and all its files.
    fn make(&self, settings: Settings) -> Result<(Design, Vec<PathBuf>)> {
        let settings = settings.steered()?;
        let genome = settings.genome()?;
        let mut session = Session::open(self.scene.path()?, settings)?;
        let drawn = self.target_picture.iter().chain(&self.strokes).map(PathBuf::as_path);
        let pictures = drawn.chain(self.search.picture());
        let mut inputs = session.inputs(self.scene.config());
        inputs.extend(Inputs::new(pictures));
        inputs.spare(&self.out, designer::FILES.into_iter().chain([COLLAGE]))?;
        if let Some(path) = &self.strokes {
            session.stroke(path)?;
        }
        let target = match &self.target_picture {
            Some(file) => Some(Target::read(file)?),
            None if self.collage => Some(Target::collage(&mut session)?),
            None => None,
        };
        let mut staging = Staging::new(&self.out)?.sparing(inputs);
        if let Some(target) = target.as_ref().filter(|_| self.collage) {
            staging.write(COLLAGE, target.png()?)?;
        }
        let files = (&*self.out, &designer::FILES[..]);
        let journal = self.checkpoint.open(&mut session, files)?.map(RefCell::new);
        let way = (target.as_ref(), self.wanted(), journal.as_ref());
        let (outcome, others) = search(&mut session, &genome, way, self.scene.json)?;
        let design = designer::write(&mut session, (&outcome, others.as_ref()), &mut staging)?;
        let files = staging.publish()?;
        if outcome.stopped {
            let generations = design.generations;
            let more = if journal.is_some() { "; --resume goes on" } else { "" };
            let text = "this is the best so far";
            tracing::info!("stopped after {generations} generations: {text}{more}");
        } else if let Some(journal) = journal {
            checkpoint::done(journal.into_inner());
        }
        Ok((design, files))
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    if options.alternatives.is_some_and(|others| !(1..gallery::MOST).contains(&others)) {
        let fault = format!("--alternatives must be 1 to {}", gallery::MOST - 1);
        return Err(Error::Argument(fault).into());
    }
    let (design, files) = device::or_cpu(options.settings()?, |settings| options.make(settings))?;
    if options.scene.json {
        print::out(json::text(&design)?)
    } else {
        print::out(print::design(&design, &files))
    }
}

/// Runs the search under the user's eyes.
fn search(
    session: &mut Session,
    genome: &Genome,
    (target, wanted, journal): (Option<&Target>, Option<Wanted>, Option<&RefCell<Journal>>),
    quiet: bool,
) -> Result<(Outcome, Option<Gallery>)> {
    let interrupt = Interrupt::listen()?;
    let more = if wanted.is_some() { GENERATIONS } else { 0 };
    let bar = progress_bar(generations(&session.settings).map(|before| before + more), quiet);
    let begin = Instant::now();
    let mut observe = |progress: &Progress| {
        let rate = progress.evaluations as f64 / begin.elapsed().as_secs_f64();
        let name = if target.is_some() { "distance" } else { "F" };
        bar.set_message(format!("{name} {:.4}, {rate:.0} evaluations/s", progress.best));
        bar.set_position(progress.generation as u64);
        interrupt.check()
    };
    let found = match (target, wanted) {
        (Some(target), _) => (painter::search(session, genome, target, &mut observe)?, None),
        (None, None) => (designer::search(session, genome, journal, &mut observe)?, None),
        (None, Some(wanted)) => {
            let (outcome, origin) = gallery::search(session, genome, journal, &mut observe)?;
            let others = gallery::disperse(session, &origin, wanted, &mut observe)?;
            (outcome, Some(others))
        }
    };
    bar.finish_and_clear();
    Ok(found)
}

/// Generations of a search of these settings; none where nobody knows them before.
pub(super) fn generations(settings: &Settings) -> Option<usize> {
    let searches = if settings.lights.one_by_one { settings.lights.roles.0.len() } else { 1 };
    let generations = (settings.optimizer.0.generations)(&settings.optimizers())?;
    Some(searches * generations)
}

pub(super) fn progress_bar(generations: Option<usize>, quiet: bool) -> ProgressBar {
    match generations {
        Some(generations) => {
            let template = "{bar:32} {pos}/{len} generations, {msg}, {eta} left";
            progress::bar(Some(generations as u64), template, quiet)
        }
        None => progress::bar(None, "{spinner} {pos} generations, {msg}", quiet),
    }
}
