//! One item after another on one open device: while the files of one are written, the next is searched.

use super::ahead::{Ready, load_ahead};
use super::items::Item;
use super::stamp::{self, Scores};
use super::{Batch, Made, Panicked, guarded, may_be_lost};
use crate::cli::config::Settings;
use crate::cli::device::{self, Opened};
use crate::cli::file_stamp::FileStamp;
use crate::cli::progress::Interrupt;
use crate::cli::session::{self, Session};
use crate::cli::values::Device;
use crate::cli::{describe, designer};
use crate::design::{Outcome, Progress};
use crate::report::{Inputs, Staging};
use anyhow::{Context, Result};
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::thread::ScopedJoinHandle;
use std::time::Instant;

/// A search that has ended, whose files are to be written.
struct Found<'a> {
    item: &'a Item,
    session: Session,
    outcome: Outcome,
    folder: PathBuf,
    /// What no file may replace.
    inputs: Inputs,
    /// The scene's files as they were when it was loaded.
    files: Arc<[FileStamp]>,
}

impl Found<'_> {
    /// Makes and publishes the files.
    fn write(mut self) -> Result<Made> {
        let mut staging = Staging::new(&self.folder)?.sparing(self.inputs);
        let design = designer::write(&mut self.session, (&self.outcome, None), &mut staging)?;
        let scores = Scores { headlight: design.headlight.score, score: design.quality.score };
        let stamp = stamp::text(&self.item.settings, &self.files, scores)?;
        staging.write(stamp::STAMP, stamp)?;
        stamp::remove(&self.folder)?;
        staging.publish()?;
        Ok((scores, design.timing_ms.total))
    }
}

/// An item whose files a thread writes.
struct Writing<'scope> {
    index: usize,
    /// Its scene, to do it again.
    ready: Ready,
    thread: ScopedJoinHandle<'scope, Result<Made>>,
}

impl<'a> Batch<'a> {
    /// Designs the items of these numbers, until the user has enough. While the files of one are written, the next is
    /// searched.
    pub(super) fn design(&mut self, todo: &[usize], settings: &Settings) -> Result<()> {
        let mut device = device::open(&settings.device, settings)?;
        self.note()?;
        let interrupt = Interrupt::listen()?;
        let (items, options) = (self.items, &settings.loading());
        if let Some(&first) = todo.first() {
            self.bar.set_message(format!("{}: reading", items[first].name));
        }
        std::thread::scope(|scope| {
            // Without a buffer, the thread waits with one scene at hand.
            let (sender, scenes) = mpsc::sync_channel(0);
            let paths = todo.iter().map(|&index| &*items[index].scene);
            scope.spawn(move || load_ahead(paths, options, &sender));
            let mut writing: Option<Writing> = None;
            for &index in todo {
                let scene = scenes.recv().context("the thread that loads scenes has ended")?;
                if interrupt.check().is_break() {
                    break;
                }
                let again = scene.as_ref().ok().cloned();
                let mut found = scene.and_then(|ready| {
                    guarded(|| self.search(&items[index], ready, &device, &interrupt))
                });
                if let Some(before) = writing.take() {
                    self.written(before, (settings, &mut device), &interrupt)?;
                }
                if let (Err(fault), Some(ready)) = (&found, &again)
                    && self.falls_back(index, fault, settings)
                {
                    device = device::open(&settings.device, settings)?;
                    let ready = ready.clone();
                    found = guarded(|| self.search(&items[index], ready, &Opened::Cpu, &interrupt));
                }
                match (found, again) {
                    (Ok(Some(found)), Some(ready)) => {
                        let thread = scope.spawn(|| guarded(|| found.write()));
                        writing = Some(Writing { index, ready, thread });
                    }
                    (Ok(_), _) => break, // the user ended the search
                    (Err(fault), _) => self.failed(index, fault, (settings, &mut device))?,
                }
            }
            writing.map_or(Ok(()), |last| self.written(last, (settings, &mut device), &interrupt))
        })
    }

    /// Waits for the files of an item.
    fn written(
        &mut self,
        Writing { index, ready, thread }: Writing<'_>,
        (settings, device): (&Settings, &mut Opened),
        interrupt: &Interrupt,
    ) -> Result<()> {
        let lost = || Err(Panicked("the thread that writes files has ended".into()).into());
        let mut made = thread.join().unwrap_or_else(|_| lost());
        if let Err(fault) = &made
            && self.falls_back(index, fault, settings)
        {
            *device = device::open(&settings.device, settings)?;
            let item = &self.items[index];
            let found = guarded(|| self.search(item, ready, &Opened::Cpu, interrupt));
            made = match found {
                Ok(Some(found)) => guarded(|| found.write()),
                Ok(None) => return Ok(()),
                Err(fault) => Err(fault),
            };
        }
        match made {
            Ok((scores, time)) => {
                self.record.done(index, scores, time);
                self.told(index)
            }
            Err(fault) => self.failed(index, fault, (settings, device)),
        }
    }

    /// Whether an item is done again on the CPU after a fault of a device that nobody has named.
    fn falls_back(&self, index: usize, fault: &anyhow::Error, settings: &Settings) -> bool {
        let falls_back = settings.device == Device::Auto && device::is_device(fault);
        if falls_back {
            let name = &self.items[index].name;
            self.say(&format!("{name}: {}: it is done again on the CPU", describe(fault)));
        }
        falls_back
    }

    /// Takes note of an item's fault, and opens the device anew where that may be lost.
    fn failed(
        &mut self,
        index: usize,
        fault: anyhow::Error,
        (settings, device): (&Settings, &mut Opened),
    ) -> Result<()> {
        if may_be_lost(&fault) {
            *device = device::open(&settings.device, settings)?;
        }
        self.fault(index, &fault)
    }

    /// Searches an item's lights; nothing where the user ended the search.
    fn search(
        &mut self,
        item: &'a Item,
        Ready { scene, files }: Ready,
        device: &Opened,
        interrupt: &Interrupt,
    ) -> Result<Option<Found<'a>>> {
        let begin = Instant::now();
        let folder = self.out.join(&item.name);
        self.spare(item)?;
        let inputs = session::inputs(&scene.scene, None);
        inputs.spare(&folder, designer::FILES.into_iter().chain([stamp::STAMP]))?;
        self.bar.set_message(item.name.clone());
        for warning in &scene.scene.warnings {
            self.say(&format!("{}: {warning}", item.name));
        }
        let settings = item.settings.steered()?;
        let genome = settings.genome()?;
        let mut session = Session::on(device, scene, settings, begin)?;
        if self.record.device.is_none() {
            if self.announce {
                self.bar.suspend(|| session::announce(&session.evaluator));
            }
            self.record.device = Some(serde_json::to_value(session.evaluator.device())?);
        }
        let mut observe = |progress: &Progress| {
            let Progress { generation, best, .. } = progress;
            self.bar.set_message(format!("{}: F {best:.4}, generation {generation}", item.name));
            interrupt.check()
        };
        let outcome = designer::search(&mut session, &genome, None, &mut observe)?;
        if outcome.stopped && interrupt.check().is_break() {
            return Ok(None);
        }
        Ok(Some(Found { item, session, outcome, folder, inputs, files }))
    }
}
