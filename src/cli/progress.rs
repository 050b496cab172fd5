//! How far a long run is, and the user's way out of it.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tracing::{Level, enabled};

/// Exit code of a run that a second Ctrl-C ends at once: 128 + SIGINT.
const KILLED: i32 = 130;

/// Set by the first Ctrl-C; the second ends the process.
#[derive(Debug, Clone)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens for Ctrl-C; who listens again gets the same.
    ///
    /// # Errors
    /// When the system does not let it.
    pub fn listen() -> Result<Self> {
        static LISTENING: Mutex<Option<Interrupt>> = Mutex::new(None);
        let mut listening = LISTENING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(interrupt) = &*listening {
            return Ok(interrupt.clone());
        }
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        let handler = move || {
            if flag.swap(true, Ordering::Relaxed) {
                crate::report::abandon();
                std::process::exit(KILLED);
            }
        };
        ctrlc::set_handler(handler).context("listening for Ctrl-C")?;
        Ok(listening.insert(Self(interrupted)).clone())
    }

    /// Whether to go on.
    pub fn check(&self) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// A progress bar on a terminal's standard error, nothing elsewhere; a spinner where the end is not
/// known.
pub(super) fn bar(total: Option<u64>, template: &str, quiet: bool) -> ProgressBar {
    if quiet || !enabled!(Level::INFO) || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = total.map_or_else(ProgressBar::no_length, ProgressBar::new);
    // The templates are well-formed; another style is no reason to end a run.
    bar.with_style(
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
    )
}

/// The course of a study.
#[derive(Debug)]
pub(super) struct Watch {
    bar: ProgressBar,
    interrupt: Interrupt,
}

impl Watch {
    /// Watches `total` evaluations, or a number that nobody knows yet.
    ///
    /// # Errors
    /// As [`Interrupt::listen`].
    pub fn new(total: Option<u64>, quiet: bool) -> Result<Self> {
        let template = match total {
            Some(_) => "{bar:32} {percent:>3} %, {msg}, {eta} left",
            None => "{spinner} {pos} evaluations, {msg}",
        };
        Ok(Self { bar: bar(total, template, quiet), interrupt: Interrupt::listen()? })
    }

    /// Names what is being done.
    pub fn stage(&self, name: impl Into<String>) {
        self.bar.set_message(name.into());
    }

    /// Takes note of evaluations.
    pub fn made(&self, evaluations: usize) -> ControlFlow<()> {
        self.bar.inc(evaluations as u64);
        self.check()
    }

    /// Whether to go on.
    pub fn check(&self) -> ControlFlow<()> {
        self.interrupt.check()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
