//! What klieg says beside its results, on standard error: errors, warnings, notes and, where they are asked for,
//! details. They are `tracing` events; colours appear on terminals, unless NO_COLOR is set.

use super::print;
use crate::session::message;
use anstyle::{AnsiColor, Style};
use clap::{ArgAction, Args};
use tracing::level_filters::LevelFilter;
use tracing::{Event, Level, Subscriber, enabled};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt as _};
use tracing_subscriber::util::SubscriberInitExt as _;

/// Behind the options of a command in its help.
const LAST: usize = 900;

/// How much klieg says.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Verbosity {
    /// Say more: what is read, chosen and written, and how long it takes
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet",
        display_order = LAST)]
    verbose: u8,
    /// Say less: no notes, warnings and progress, only results and errors
    #[arg(short, long, global = true, display_order = LAST)]
    quiet: bool,
}

impl Verbosity {
    /// Has messages appear from here on.
    pub fn listen(self) {
        let most = match (self.quiet, self.verbose) {
            (true, _) => LevelFilter::ERROR,
            (false, 0) => LevelFilter::INFO,
            (false, _) => LevelFilter::DEBUG,
        };
        let messages = Messages.with_filter(most);
        // Where a program that embeds the command line listens already, it decides.
        let _ = tracing_subscriber::registry().with(messages).try_init();
    }
}

/// The options by which a further process says as much as this one.
pub(super) fn like_this_process() -> Option<&'static str> {
    match (enabled!(Level::DEBUG), enabled!(Level::INFO)) {
        (true, _) => Some("--verbose"),
        (false, true) => None,
        (false, false) => Some("--quiet"),
    }
}

/// Writes events as lines.
struct Messages;

impl<S: Subscriber> Layer<S> for Messages {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let message = message(event);
        let bold = Style::new().bold();
        let (name, style) = match *event.metadata().level() {
            Level::ERROR => ("error: ", bold.fg_color(Some(AnsiColor::Red.into()))),
            Level::WARN => ("warning: ", bold.fg_color(Some(AnsiColor::Yellow.into()))),
            Level::INFO => return print::note(&message),
            _ => ("", Style::new()),
        };
        print::styled_note(("klieg: ", name, style), &message);
    }
}
