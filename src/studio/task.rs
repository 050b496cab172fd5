//! Work beside that of a page's own thread.

use super::hall::Studio;
use crate::error::panic_words;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Work that goes on by itself; dropped, it is called off.
pub struct Task(Arc<AtomicBool>);

impl Task {
    /// Begins work after a while, on threads that no hand waits for. It gets what tells whether to go on; `failed` gets the
    /// words of a panic.
    pub fn spawn(
        (studio, delay): (&Arc<Studio>, Duration),
        work: impl FnOnce(&(dyn Fn() -> bool + Sync)) + Send + 'static,
        failed: impl FnOnce(String) + Send + 'static,
    ) -> Self {
        let wanted = Arc::new(AtomicBool::new(true));
        let (studio, flag) = (Arc::clone(studio), Arc::clone(&wanted));
        std::thread::spawn(move || {
            std::thread::sleep(delay);
            let go_on = || flag.load(Ordering::Relaxed);
            if !go_on() {
                return;
            }
            let work = || studio.background.install(|| work(&go_on));
            if let Err(panic) = catch_unwind(AssertUnwindSafe(work)) {
                failed(said(&*panic));
            }
        });
        Self(wanted)
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// The words of a panic.
pub fn said(panic: &(dyn std::any::Any + Send)) -> String {
    format!("a fault of klieg's own: {}", panic_words(panic).unwrap_or_default())
}
