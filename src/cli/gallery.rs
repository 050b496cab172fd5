//! `klieg gallery`: many good and different lights for one scene.

use super::config::Settings;
use super::design::{generations, progress_bar};
use super::device;
use super::options::{SceneOptions, SearchOptions, TargetOptions, completed};
use super::picture::PictureOptions;
use super::print;
use super::progress::Interrupt;
use super::session::gallery::{self, GENERATIONS, Gallery, Origin, RECORD, SLACK, Wanted};
use super::session::{Session, warn};
use crate::design::{Progress, profile};
use crate::lighting::genome::Genome;
use crate::report::gallery::{GalleryRecord, Picked, RigFiles};
use crate::report::{Inputs, Staging, json};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

/// Find many good and different lights for a scene
///
/// Writes index.html, where all of them stand side by side, best first and on a map of what is alike, gallery.json, and
/// for each a picture, its lights and the lit scene: 01.png, 01.rig.json, 01.glb. With --from and --pick the lights are near
/// one of an earlier gallery. Ctrl-C ends the search after the running generation and shows what there is.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Lights to find, 2 to 99; where fewer are good and different, there are fewer
    #[arg(long, value_name = "N", default_value_t = 12)]
    count: usize,
    /// How much worse than the best a light may be: how far its F may lie above the lowest, 0 to 1. More of it finds what is
    /// less alike
    #[arg(long, value_name = "F", default_value_t = SLACK, allow_negative_numbers = true)]
    slack: f32,
    /// Folder of an earlier gallery, of the same scene and options
    #[arg(long, value_name = "DIR", requires = "pick")]
    from: Option<PathBuf>,
    /// Number of its light to go on from
    #[arg(long, value_name = "NUMBER", requires = "from")]
    pick: Option<usize>,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    picture: PictureOptions,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let settings = self.scene.settings(profile::DEFAULT)?;
        let settings = completed(settings, (&self.target, &self.search, &self.picture))?;
        settings.check_together()?;
        Ok(settings)
    }

    fn wanted(&self) -> Wanted {
        Wanted { count: self.count, slack: self.slack }
    }

    fn picked(&self) -> Option<Picked> {
        let (folder, number) = self.from.clone().zip(self.pick)?;
        Some(Picked { folder, number })
    }

    /// Makes the gallery and all its files.
    fn make(&self, settings: Settings) -> Result<(GalleryRecord, Vec<PathBuf>)> {
        let settings = settings.steered()?;
        let genome = settings.genome()?;
        let mut session = Session::open(self.scene.path()?, settings)?;
        let mut inputs = session.inputs(self.scene.config());
        inputs.extend(Inputs::new(self.search.picture()));
        let mut around = None;
        if let Some(Picked { folder, number }) = self.picked() {
            inputs.extend(Inputs::new([RECORD, &RigFiles::of(number).rig].map(|n| folder.join(n))));
            let rig = gallery::picked(&folder, number, &session.view)?;
            around = Some(gallery::around(&mut session, &genome, &rig)?);
        }
        inputs.spare(&self.out, gallery::names(self.count))?;
        let mut staging = Staging::new(&self.out)?.sparing(inputs);
        let found = self.find(&mut session, &genome, around)?;
        if found.stopped {
            tracing::info!("stopped: these are the best and least alike so far");
        }
        if found.rigs.len() < self.count {
            warn(&[format!(
                "there are {} lights in place of {}: no others are within {} of the best and different; \
                 more --slack finds more",
                found.rigs.len(),
                self.count,
                self.slack
            )]);
        }
        let shown = (self.slack, self.picked());
        let record = gallery::write(&mut session, &found, shown, &mut staging)?;
        Ok((record, staging.publish()?))
    }

    /// Searches under the user's eyes, `around` a rig where one is picked.
    fn find(
        &self,
        session: &mut Session,
        genome: &Genome,
        around: Option<Origin>,
    ) -> Result<Gallery> {
        let interrupt = Interrupt::listen()?;
        let before = if around.is_some() { Some(0) } else { generations(&session.settings) };
        let bar = progress_bar(before.map(|before| before + GENERATIONS), self.scene.json);
        let mut observe = |progress: &Progress| {
            bar.set_message(format!("F {:.4}", progress.best));
            bar.set_position(progress.generation as u64);
            interrupt.check()
        };
        let origin = match around {
            Some(origin) => origin,
            None => gallery::search(session, genome, None, &mut observe)?.1,
        };
        let found = gallery::disperse(session, &origin, self.wanted(), &mut observe)?;
        bar.finish_and_clear();
        Ok(found)
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    options.wanted().check()?;
    let (record, files) = device::or_cpu(options.settings()?, |settings| options.make(settings))?;
    if options.scene.json {
        print::out(json::text(&record)?)
    } else {
        print::out(print::gallery(&record, &files))
    }
}
