//! The texts of klieg's messages, which are `tracing` events.

use std::fmt::{Debug, Write as _};
use tracing::Event;
use tracing::field::{Field, Visit};

/// An event's text.
pub fn message(event: &Event<'_>) -> String {
    let mut message = Message::default();
    event.record(&mut message);
    message.0
}

#[derive(Default)]
struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            // Writing to a string does not fail.
            let _ = write!(self.0, "{value:?}");
        }
    }
}
