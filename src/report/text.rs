//! Text that others chose the parts of, such as names in scenes: safe to show.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character commands what shows it instead of standing for itself: control characters, and
/// those that turn the direction of the text round them (Unicode 16, UAX #9, 2). Line breaks and tabs
/// are ordinary.
pub fn is_command(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

/// The text with its commands as `\u{1b}`, for people.
pub fn visible(text: &str) -> Cow<'_, str> {
    spelled(text, |c, out| out.extend(c.escape_unicode()))
}

/// The text with its commands as `\u001b`, which JSON reads as the same characters within strings.
pub fn visible_json(text: &str) -> Cow<'_, str> {
    spelled(text, |c, out| {
        let mut units = [0; 2];
        for unit in c.encode_utf16(&mut units) {
            // Writing to a string does not fail.
            let _ = write!(out, "\\u{unit:04x}");
        }
    })
}

fn spelled(text: &str, spell: impl Fn(char, &mut String)) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_command(c) { spell(c, &mut out) } else { out.push(c) }
    }
    out.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_spelled_out_and_nothing_else() {
        assert_eq!(visible("a\tb\nüber 光 \u{5d0}"), "a\tb\nüber 光 \u{5d0}");
        assert_eq!(
            visible("\u{1b}[31mred\u{202e}\u{7}\u{85}"),
            "\\u{1b}[31mred\\u{202e}\\u{7}\\u{85}"
        );
        let json = serde_json::to_string("\u{1b}\u{202e}\u{85}\u{2069}x").unwrap();
        let safe = visible_json(&json);
        assert!(!safe.contains(is_command));
        assert_eq!(serde_json::from_str::<String>(&safe).unwrap(), "\u{1b}\u{202e}\u{85}\u{2069}x");
    }
}
