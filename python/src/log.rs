//! klieg's messages, for Python's logger `klieg`.

use klieg::session::message;
use pyo3::prelude::*;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt as _};
use tracing_subscriber::util::SubscriberInitExt as _;

/// Hands events over.
struct Logger;

impl<S: Subscriber> Layer<S> for Logger {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let level = match *event.metadata().level() {
            Level::ERROR => 40,
            Level::WARN => 30,
            Level::INFO => 20,
            _ => 10,
        };
        // Where the interpreter is ending, nobody reads them any more; a logger that fails is no reason to end work.
        let _ = Python::try_attach(|py| -> PyResult<()> {
            let logger = py.import("logging")?.call_method1("getLogger", ("klieg",))?;
            logger.call_method1("log", (level, "%s", message(event)))?;
            Ok(())
        });
    }
}

/// Has messages appear in Python's log from here on.
pub fn listen() {
    // Where another module of this library listens already, it decides.
    let _ = tracing_subscriber::registry().with(Logger).try_init();
}
