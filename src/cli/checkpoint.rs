//! `--checkpoint` and `--resume`: a search that goes on where a killed one was.

use super::file_stamp::FileStamp;
use super::session::{Session, warn};
use crate::Error;
use crate::design::Journal;
use crate::report::Inputs;
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Name of a checkpoint in a folder.
const NAME: &str = "klieg.checkpoint";

/// Settings on which no score depends.
const FREE: [&str; 3] = ["device", "picture", "time_limit"];

/// Whether and where a search leaves its way.
#[derive(Debug, Args)]
pub(super) struct CheckpointOptions {
    /// Keep all scores so far in this file, or in klieg.checkpoint in this folder, so that --resume can go on
    /// where a killed run was; it is removed when the design is complete
    #[arg(long, value_name = "FILE|FOLDER")]
    checkpoint: Option<PathBuf>,
    /// Go on with the search of the checkpoint, to the same results; begin it where there is none
    #[arg(long, requires = "checkpoint")]
    resume: bool,
}

impl CheckpointOptions {
    /// The journal of a session's search, if any. The files `names` in the folder `out` are those that the run writes.
    ///
    /// # Errors
    /// [`Error::Input`] for a checkpoint that is of something else or in use, or there without `--resume`,
    /// [`Error::Argument`] for one in the place of an output, and [`Error::Output`].
    pub fn open(
        &self,
        session: &mut Session,
        (out, names): (&Path, &[&str]),
    ) -> Result<Option<Journal>> {
        let Some(path) = &self.checkpoint else { return Ok(None) };
        let path = if path.is_dir() { path.join(NAME) } else { path.clone() };
        let subject = subject(session)?;
        let journal = if self.resume {
            Journal::resume(&path, &subject)?
        } else {
            Journal::create(&path, &subject)?
        };
        if let Err(fault) = Inputs::new([&path]).spare(out, names.iter().map(OsStr::new)) {
            journal.remove()?;
            let text = format!("{}: the checkpoint must have another name", path.display());
            return Err(anyhow::Error::new(fault).context(Error::Argument(text)));
        }
        if !journal.is_new() {
            tracing::info!("going on with {}", path.display());
        }
        Ok(Some(journal))
    }
}

/// Removes the checkpoint of a search that is complete.
pub(super) fn done(journal: Journal) {
    if let Err(fault) = journal.remove() {
        warn(&[format!("the checkpoint is of no more use: {fault}")]);
    }
}

/// All that the scores of a session depend on.
fn subject(session: &mut Session) -> Result<Value> {
    let mut settings = serde_json::to_value(&session.settings)?;
    if let Some(settings) = settings.as_object_mut() {
        FREE.iter().for_each(|name| drop(settings.remove(*name)));
    }
    Ok(json!({
        "schema": "klieg.checkpoint/1",
        "klieg": env!("CARGO_PKG_VERSION"),
        "device": session.evaluator.device(),
        "scene": FileStamp::all(&session.scene)?,
        "settings": settings,
    }))
}
