//! Items in processes of their own: what aborts one of them, or takes more memory than there is, is the
//! failure of that item alone.

use super::items::Item;
use super::record::{Record, Report};
use super::{Batch, Made};
use crate::Error;
use crate::cli::config::Settings;
use crate::cli::{messages, print};
use crate::report::json;
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use wait_timeout::ChildExt as _;

/// Name of the subcommand that such a process runs.
pub const COMMAND: &str = "batch-item";

/// Most bytes of a task.
const MAX_BYTES: u64 = 1 << 30;

/// What such a process has to do, on its standard input.
#[derive(Serialize, Deserialize)]
struct Task {
    name: String,
    scene: PathBuf,
    out: PathBuf,
    settings: Settings,
    /// Whether it says what computes.
    announce: bool,
}

/// Makes an item in a process of its own, within `limit`.
///
/// # Errors
/// What that process reports, and how it ended if it did not.
pub fn design(item: &Item, out: &Path, announce: bool, limit: Option<Duration>) -> Result<Report> {
    let Item { name, scene, settings } = item;
    let task = Task {
        name: name.clone(),
        scene: scene.clone(),
        out: out.into(),
        settings: settings.clone(),
        announce,
    };
    let task = serde_json::to_vec(&task).context("an item for a process of its own")?;
    let program = std::env::current_exe().context("looking for klieg's own program")?;
    let mut process = Command::new(program)
        .arg(COMMAND)
        .args(messages::like_this_process())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("starting a process for an item")?;
    if let Some(mut stdin) = process.stdin.take() {
        // One that has ended before it read all says so by its status.
        let _ = stdin.write_all(&task);
    }
    let waiting = "waiting for an item's process";
    let mut said = process.stdout.take().context(waiting)?;
    // Read meanwhile: a process that says more than a pipe holds would not end before.
    let reader = std::thread::spawn(move || {
        let mut stdout = Vec::new();
        said.read_to_end(&mut stdout).map(|_| stdout)
    });
    if let Some(limit) = limit
        && process.wait_timeout(limit).context(waiting)?.is_none()
    {
        process.kill().and_then(|()| process.wait()).context("ending an item's process")?;
        let seconds = limit.as_secs_f64();
        return Err(anyhow!("it took longer than {seconds} s (--timeout)"));
    }
    let status = process.wait().context(waiting)?;
    let stdout = reader.join().map_err(|_| anyhow!("{waiting}"))?.context(waiting)?;
    report(&Output { status, stdout, stderr: Vec::new() })
}

/// What a process has reported.
fn report(output: &Output) -> Result<Report> {
    serde_json::from_slice(&output.stdout).map_err(|_| {
        let killed = output.status.to_string().contains("SIGKILL");
        let why = if killed { ": perhaps there was not enough memory" } else { "" };
        anyhow!("its process ended without a result ({}){why}", output.status)
    })
}

impl Report {
    /// What the item's own process would have returned.
    ///
    /// # Errors
    /// Its fault.
    pub fn made(self) -> Result<Option<Made>> {
        match (self.scores, self.reason) {
            (Some(scores), _) => Ok(Some((scores, self.milliseconds.unwrap_or_default()))),
            (None, Some(reason)) if self.input => Err(Error::Argument(reason).into()),
            (None, Some(reason)) => Err(anyhow!(reason)),
            (None, None) => Ok(None),
        }
    }
}

/// Makes the item that standard input names, and reports on standard output.
///
/// # Errors
/// Input that is none of a batch's, and output that cannot be written.
pub fn run() -> Result<()> {
    be_expendable();
    let mut task = Vec::new();
    std::io::stdin().take(MAX_BYTES).read_to_end(&mut task).context("reading an item")?;
    let task: Task = serde_json::from_slice(&task)
        .map_err(|fault| Error::Argument(format!("{COMMAND} is for 'klieg batch': {fault}")))?;
    let Task { name, scene, out, settings, announce } = task;
    let items = [Item { name, scene, settings }];
    let settings = &items[0].settings;
    let mut batch = Batch {
        announce,
        recorded: false,
        ..Batch::new(&out, &items, Record::new(settings.profile.0, &items, &[None]), true)
    };
    if let Err(fault) = batch.design(&[0], settings) {
        batch.record.failed(0, &fault);
    }
    print::out(json::text(&batch.record.report(0))?)
}

/// Lets the system end this process rather than the one that waits for it, where memory runs out.
fn be_expendable() {
    // proc_pid_oom_score_adj(5): a process may always raise its own; elsewhere there is no such file.
    let _ = std::fs::write("/proc/self/oom_score_adj", "500");
}
