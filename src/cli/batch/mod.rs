//! `klieg batch`: many designs in one run. A thread loads the next scene while the present one is searched, and
//! another writes the files of the one before; the device stays open throughout.

mod ahead;
mod design;
mod isolate;
mod items;
mod record;
mod shard;
mod stamp;

use super::config::Settings;
use super::designer;
use super::options::{LookOptions, SearchOptions, TargetOptions, completed};
use super::picture::PictureOptions;
use super::progress::{self, Interrupt};
use super::session::milliseconds;
use super::views::ViewsOptions;
use super::{describe, print};
use crate::Error;
use crate::design::profile;
use crate::error::panic_words;
use crate::report::{Inputs, json};
use anyhow::Result;
use clap::Args;
use indicatif::ProgressBar;
use items::Item;
use record::{Files, Record};
use shard::Shard;
use stamp::Scores;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Find the best lights for many scenes
///
/// Designs each scene into a folder of its own, with the files that 'klieg design' writes, and goes on
/// where one fails. A second run into the same folder makes only what is missing or was made with
/// other settings or of another scene. Ctrl-C ends the batch after the running generation; finished
/// designs stay.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Folders, searched for .gltf, .glb, .ply, .stl and .obj files, such files, and lists: a .txt file, or '-' for
    /// standard input, with a path in each line, or a .toml file of [[item]] tables with 'scene' and, where it differs, 'name',
    /// 'camera', 'azimuth', 'elevation', 'fov', 'fill', 'size', 'lights', 'kind' and 'seed'
    #[arg(required = true, value_name = "FOLDER|LIST|SCENE")]
    inputs: Vec<PathBuf>,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    target: TargetOptions,
    #[command(flatten)]
    views: ViewsOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    picture: PictureOptions,
    /// Make all designs anew, finished ones too
    #[arg(long)]
    force: bool,
    /// Make each design in a process of its own, so that a scene that takes more memory than there is
    /// ends that one alone
    #[arg(long)]
    isolate: bool,
    /// Give up a design that takes longer; each is made in a process of its own then
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<Duration>,
    /// Make the third of every 16 designs alone, for 16 machines that share the work; array/16 for the jobs of an
    /// array. Its record is batch-3-of-16.json. Afterwards a run without it makes the record of all
    #[arg(long, value_name = "3/16")]
    shard: Option<Shard>,
    /// Print batch.json, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let settings = self.look.settings_of(profile::DEFAULT, &self.views)?;
        let settings = completed(settings, (&self.target, &self.search, &self.picture))?;
        settings.check()?;
        settings.genome()?;
        Ok(settings)
    }
}

/// A time that is more than none.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
    let limit = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    limit.ok_or_else(|| "not a number of seconds above 0".into())
}

/// What stands on the progress bar.
const TEMPLATE: &str = "{bar:32} {pos}/{len} designs, {msg}, {eta} left";

pub(super) use isolate::run as run_item;
pub(super) use items::gather;

pub(super) fn run(options: &Options) -> Result<()> {
    let settings = options.settings()?;
    let mut items = items::gather(&options.inputs, &options.out, &settings)?;
    if let Some(shard) = options.shard {
        items = shard.of(items);
    }
    let finished = |item: &Item| stamp::finished(item, &options.out.join(&item.name));
    let scores: Vec<_> =
        items.iter().map(|item| finished(item).filter(|_| !options.force)).collect();
    let record = Record::new(settings.profile.0, &items, &scores);
    let mut batch = Batch::new(&options.out, &items, record, options.json);
    let scenes = items.iter().map(|item| item.scene.as_path());
    let named = options.inputs.iter().map(PathBuf::as_path).chain(options.look.config());
    batch.inputs = Inputs::new(scenes.chain(named).chain(options.search.picture()));
    batch.files = options.shard.map_or_else(Files::default, |shard| Files::named(&shard.stem()));
    batch.inputs.spare(&options.out, batch.files.names())?;
    let todo: Vec<usize> = (0..items.len()).filter(|&index| scores[index].is_none()).collect();
    batch.bar.set_position((items.len() - todo.len()) as u64);
    batch.bar.reset_eta();
    match (todo.is_empty(), options.isolate || options.timeout.is_some()) {
        (true, _) => {}
        (false, false) => batch.design(&todo, &settings)?,
        (false, true) => batch.design_isolated(&todo, options.timeout)?,
    }
    batch.bar.finish_and_clear();
    let text = batch.note()?;
    print::out(if options.json { text } else { batch.record.show() })?;
    batch.record.verdict()
}

/// How much longer than writing `batch.json` takes the time between two writings of it is.
const PAUSE: u32 = 20;

/// A design's scores, and the milliseconds that it took.
type Made = (Scores, f64);

/// A batch at work.
struct Batch<'a> {
    out: &'a Path,
    items: &'a [Item],
    /// What no output may replace, beside the files of its own scene.
    inputs: Inputs,
    record: Record,
    /// The record's.
    files: Files,
    /// Whether there is a record.
    recorded: bool,
    /// Whether to say what computes.
    announce: bool,
    bar: ProgressBar,
    begin: Instant,
    /// When `batch.json` was last written, and how long that took.
    noted: (Instant, Duration),
}

/// A fault of klieg's own.
#[derive(Debug, thiserror::Error)]
#[error("a fault of klieg's own, please report it: {0}")]
struct Panicked(String);

/// What `work` gives; its panic is an error.
fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    std::panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic_words(&*panic).unwrap_or("it panicked");
        Err(Panicked(text.to_owned()).into())
    })
}

impl<'a> Batch<'a> {
    fn new(out: &'a Path, items: &'a [Item], record: Record, quiet: bool) -> Self {
        let begin = Instant::now();
        Self {
            out,
            items,
            inputs: Inputs::default(),
            record,
            files: Files::default(),
            recorded: true,
            announce: true,
            bar: progress::bar(Some(items.len() as u64), TEMPLATE, quiet),
            begin,
            noted: (begin, Duration::ZERO),
        }
    }

    /// Designs the items of these numbers, each in a process of its own, which may take so long.
    fn design_isolated(&mut self, todo: &[usize], limit: Option<Duration>) -> Result<()> {
        self.note()?;
        let interrupt = Interrupt::listen()?;
        for &index in todo {
            if interrupt.check().is_break() {
                break;
            }
            let item = &self.items[index];
            self.bar.set_message(item.name.clone());
            let announce = self.record.device.is_none();
            let made = self.spare(item).and_then(|()| {
                let report = isolate::design(item, self.out, announce, limit)?;
                self.record.device = self.record.device.take().or(report.device.clone());
                report.made()
            });
            match made {
                Ok(Some((scores, time))) => {
                    self.record.done(index, scores, time);
                    self.told(index)?;
                }
                Ok(None) => break,
                Err(fault) => self.fault(index, &fault)?,
            }
        }
        Ok(())
    }

    /// Takes note of an item's fault.
    fn fault(&mut self, index: usize, fault: &anyhow::Error) -> Result<()> {
        if self.recorded {
            self.say(&format!("{}: {}", self.items[index].name, describe(fault)));
        }
        self.record.failed(index, fault);
        self.told(index)
    }

    /// Tells what became of an item.
    fn told(&mut self, index: usize) -> Result<()> {
        self.bar.inc(1);
        // Where no bar tells.
        if self.recorded && self.bar.is_hidden() {
            tracing::info!("{}", self.record.line(index));
        }
        let (noted, cost) = self.noted;
        if noted.elapsed() > PAUSE * cost {
            self.note()?;
        }
        Ok(())
    }

    /// An item's files must not replace any input.
    fn spare(&self, item: &Item) -> Result<()> {
        let names = designer::FILES.into_iter().chain([stamp::STAMP]);
        Ok(self.inputs.spare(&self.out.join(&item.name), names)?)
    }

    /// Says something beside the bar.
    fn say(&self, text: &str) {
        self.bar.suspend(|| tracing::warn!("{text}"));
    }

    /// Writes how the batch stands; gives the text of `batch.json`.
    fn note(&mut self) -> Result<String> {
        let begin = Instant::now();
        self.record.count(milliseconds(self.begin));
        let text = json::text(&self.record)?;
        if self.recorded {
            self.record.write(&text, &self.files, self.out)?;
        }
        self.noted = (Instant::now(), begin.elapsed());
        Ok(text)
    }
}

/// Whether the device may be of no more use after a fault.
fn may_be_lost(fault: &anyhow::Error) -> bool {
    fault.chain().any(|cause| {
        cause.is::<Panicked>() || matches!(cause.downcast_ref(), Some(Error::Vulkan { .. }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::exit_code;

    #[test]
    fn a_panic_is_a_fault_after_which_the_device_is_opened_anew() {
        let fault = guarded(|| -> Result<()> { panic!("{} is broken", "it") }).unwrap_err();
        assert!(
            fault.to_string().ends_with("please report it: it is broken") && may_be_lost(&fault)
        );
        assert_eq!(exit_code(&fault), 1);
        assert_eq!(guarded(|| Ok(3)).unwrap(), 3);
    }
}
