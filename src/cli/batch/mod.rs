//! `klieg batch`: many designs in one run. A thread loads the next scene while the present one is
//! designed; the device stays open throughout.

mod items;
mod record;
mod stamp;

use super::config::Settings;
use super::designer;
use super::device::{self, Opened};
use super::options::{LookOptions, SearchOptions, TargetOptions};
use super::picture::PictureOptions;
use super::progress::{self, Interrupt};
use super::session::{self, Loaded, Session, milliseconds};
use super::{describe, print};
use crate::Error;
use crate::design::{Progress, profile};
use crate::report::Staging;
use crate::scene::load::Reading;
use anyhow::{Context, Result};
use clap::Args;
use indicatif::ProgressBar;
use items::Item;
use record::Record;
use stamp::{FileStamp, Scores};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, SyncSender};
use std::time::{Duration, Instant};

/// Find the best lights for many scenes
///
/// Designs each scene into a folder of its own, with the files that 'klieg design' writes, and goes on
/// where one fails. A second run into the same folder makes only what is missing or was made with
/// other settings or of another scene. Ctrl-C ends the batch after the running generation; finished
/// designs stay.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Folders, searched for .gltf, .glb, .ply, .stl and .obj files, such files, and lists: a .txt file with a path in
    /// each line, or a .toml file of [[item]] tables with 'scene' and, where it differs, 'name',
    /// 'camera', 'azimuth', 'elevation', 'fov', 'fill', 'size', 'lights', 'kind' and 'seed'
    #[arg(required = true, value_name = "FOLDER|LIST|SCENE")]
    inputs: Vec<PathBuf>,
    /// Folder for the results, created where absent
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    target: TargetOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    picture: PictureOptions,
    /// Make all designs anew, finished ones too
    #[arg(long)]
    force: bool,
    /// Print batch.json, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let mut settings = self.look.settings(profile::DEFAULT)?;
        self.target.apply(&mut settings);
        self.search.apply(&mut settings)?;
        self.picture.apply(&mut settings);
        settings.check()?;
        settings.genome()?;
        Ok(settings)
    }
}

/// What stands on the progress bar.
const TEMPLATE: &str = "{bar:32} {pos}/{len} designs, {msg}, {eta} left";

pub(super) fn run(options: &Options) -> Result<()> {
    let begin = Instant::now();
    let settings = options.settings()?;
    let items = items::gather(&options.inputs, &options.out, &settings)?;
    let finished = |item: &Item| stamp::finished(item, &options.out.join(&item.name));
    let scores: Vec<_> =
        items.iter().map(|item| finished(item).filter(|_| !options.force)).collect();
    let mut batch = Batch {
        out: &options.out,
        record: Record::new(settings.profile.0, &items, &scores),
        items: &items,
        bar: progress::bar(Some(items.len() as u64), TEMPLATE, options.json),
        begin,
        noted: begin,
    };
    let todo: Vec<usize> = (0..items.len()).filter(|&index| scores[index].is_none()).collect();
    batch.bar.set_position((items.len() - todo.len()) as u64);
    batch.bar.reset_eta();
    if !todo.is_empty() {
        batch.design(&todo, &settings)?;
    }
    batch.bar.finish_and_clear();
    let text = batch.note()?;
    print::out(if options.json { text } else { batch.record.show() })?;
    batch.record.verdict()
}

/// Time between two writings of `batch.json`.
const PAUSE: Duration = Duration::from_secs(1);

/// A batch at work.
struct Batch<'a> {
    out: &'a Path,
    items: &'a [Item],
    record: Record,
    bar: ProgressBar,
    begin: Instant,
    /// When `batch.json` was last written.
    noted: Instant,
}

/// A scene that waits for its design.
#[derive(Clone)]
struct Ready {
    scene: Loaded,
    /// Its files as they were when it was loaded.
    files: Arc<[FileStamp]>,
}

impl Ready {
    fn read(path: &Path, reading: Reading) -> crate::Result<Self> {
        let scene = Loaded::read(path, reading)?;
        Ok(Self { files: FileStamp::all(&scene.scene)?.into(), scene })
    }
}

impl Batch<'_> {
    /// Designs the items of these numbers, until the user has enough.
    fn design(&mut self, todo: &[usize], settings: &Settings) -> Result<()> {
        let mut device = device::open(&settings.device, settings)?;
        self.note()?;
        let interrupt = Interrupt::listen()?;
        let items = self.items;
        std::thread::scope(|scope| {
            // Without a buffer, the thread waits with one scene at hand.
            let (sender, scenes) = mpsc::sync_channel(0);
            let paths = todo.iter().map(|&index| &*items[index].scene);
            let reading = settings.reading();
            scope.spawn(move || load_ahead(paths, reading, &sender));
            for &index in todo {
                let scene = scenes.recv().context("the thread that loads scenes has ended")?;
                if interrupt.check().is_break() {
                    break;
                }
                let item = &items[index];
                let design = scene.map_err(anyhow::Error::from);
                match design.and_then(|ready| self.one(item, ready, &device, &interrupt)) {
                    Ok(None) => break,
                    Ok(Some((scores, time))) => self.record.done(index, scores, time),
                    Err(fault) => {
                        self.say(&format!("{}: {}", item.name, describe(&fault)));
                        self.record.failed(index, &fault);
                        if may_be_lost(&fault) {
                            device = device::open(&settings.device, settings)?;
                        }
                    }
                }
                self.bar.inc(1);
                if self.noted.elapsed() > PAUSE {
                    self.note()?;
                }
            }
            Ok(())
        })
    }

    /// Makes and publishes a design; gives its scores and its time in milliseconds, or nothing where
    /// the user ended the search.
    fn one(
        &mut self,
        item: &Item,
        Ready { scene, files }: Ready,
        device: &Opened,
        interrupt: &Interrupt,
    ) -> Result<Option<(Scores, f64)>> {
        let begin = Instant::now();
        let folder = self.out.join(&item.name);
        designer::spare(&item.scene, &folder.join(designer::LIT))?;
        self.bar.set_message(item.name.clone());
        for warning in &scene.scene.warnings {
            self.say(&format!("{}: {warning}", item.name));
        }
        let genome = item.settings.genome()?;
        let mut session = Session::on(device, scene, item.settings.clone(), begin)?;
        if self.record.device.is_none() {
            self.bar.suspend(|| session::announce(&session.evaluator));
            self.record.device = Some(session.evaluator.device().clone());
        }
        let mut observe = |progress: &Progress| {
            let Progress { generation, best, .. } = progress;
            self.bar.set_message(format!("{}: F {best:.4}, generation {generation}", item.name));
            interrupt.check()
        };
        let outcome = designer::search(&mut session, &genome, &mut observe)?;
        if outcome.stopped {
            return Ok(None);
        }
        let mut staging = Staging::new(&folder)?;
        let design = designer::write(&mut session, &outcome, &mut staging)?;
        let scores = Scores { headlight: design.headlight.score, score: design.quality.score };
        staging.write(stamp::STAMP, stamp::text(&item.settings, &files, scores)?)?;
        stamp::remove(&folder)?;
        staging.publish()?;
        Ok(Some((scores, design.timing_ms.total)))
    }

    /// Says something beside the bar.
    fn say(&self, text: &str) {
        self.bar.suspend(|| eprintln!("klieg: warning: {text}"));
    }

    /// Writes how the batch stands; gives the text of `batch.json`.
    fn note(&mut self) -> Result<String> {
        self.noted = Instant::now();
        self.record.count(milliseconds(self.begin));
        self.record.write(self.out)
    }
}

/// Whether the device may be of no more use after a fault.
fn may_be_lost(fault: &anyhow::Error) -> bool {
    fault.chain().any(|cause| matches!(cause.downcast_ref(), Some(Error::Vulkan { .. })))
}

/// Loads scenes in turn and hands each over. One that is asked for again at once is not loaded again.
/// Ends early when nobody takes them any more.
fn load_ahead<'a>(
    paths: impl Iterator<Item = &'a Path>,
    reading: Reading,
    taker: &SyncSender<crate::Result<Ready>>,
) {
    let mut last: Option<Ready> = None;
    for path in paths {
        // What is of no more use goes before the next scene is read.
        let mut again = last.take().filter(|ready| ready.scene.scene.path == path);
        if let Some(ready) = &mut again {
            ready.scene.load = 0.0;
        }
        let ready = again.map_or_else(|| Ready::read(path, reading), Ok);
        last = ready.as_ref().ok().cloned();
        if taker.send(ready).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_of_a_scene_share_it_and_a_fault_is_handed_over() {
        let scene = |name| Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
        let [pair, elephant, gone] = ["pair.glb", "elephant.glb", "gone.glb"].map(scene);
        let paths: [&Path; 5] = [&pair, &pair, &gone, &pair, &elephant];
        let (sender, scenes) = mpsc::sync_channel(0);
        let loaded: Vec<_> = std::thread::scope(|scope| {
            scope.spawn(move || load_ahead(paths.into_iter(), Reading::default(), &sender));
            scenes.iter().map(|ready| ready.map(|ready| ready.scene)).collect()
        });
        let [Ok(first), Ok(second), Err(fault), Ok(third), Ok(last)] = &loaded[..] else {
            panic!("{} scenes", loaded.len());
        };
        assert!(Arc::ptr_eq(&first.scene, &second.scene) && second.load == 0.0);
        assert!(fault.is_input() && fault.to_string().contains("gone.glb"));
        assert!(!Arc::ptr_eq(&first.scene, &third.scene) && third.load > 0.0);
        assert_eq!((&third.scene.path, &last.scene.path), (&pair, &elephant));
    }

    #[test]
    fn nobody_who_takes_scenes_ends_the_thread() {
        let (sender, scenes) = mpsc::sync_channel(0);
        drop(scenes);
        let paths = std::iter::repeat(Path::new("gone.glb"));
        load_ahead(paths, Reading::default(), &sender);
    }
}
