//! All designs of a batch: a table, and a page with their pictures.

use super::html::environment;
use super::text::visible;
use anyhow::{Context, Result};
use minijinja::context;
use minijinja::value::Serde;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Serialize;

/// What stands for itself in relative addresses.
const IN_ADDRESSES: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.');

/// A design and what became of it.
#[derive(Debug, Clone, Serialize)]
pub struct Entry<'a> {
    /// Its name, that of its folder.
    pub name: &'a str,
    /// The scene's file.
    pub scene: &'a str,
    /// `done`, `skipped` (an earlier run has made it), `failed` or `waiting`.
    pub state: &'a str,
    /// `F` of the headlight, where there is a design.
    pub headlight: Option<f32>,
    /// `F` of the design.
    pub score: Option<f32>,
    /// How long this run took for it.
    pub seconds: Option<f64>,
    /// Why it failed.
    pub reason: Option<&'a str>,
}

/// An entry's card.
#[derive(Serialize)]
struct Card<'a> {
    #[serde(flatten)]
    entry: &'a Entry<'a>,
    /// The folder's address from the page.
    folder: String,
}

impl<'a> Card<'a> {
    fn of(entry: &'a Entry<'a>) -> Self {
        Self { entry, folder: utf8_percent_encode(entry.name, IN_ADDRESSES).to_string() }
    }
}

/// `name,scene,state,headlight,score,seconds,reason`, one row a design.
///
/// # Errors
/// None in practice: the table is written to memory.
pub fn table(entries: &[Entry]) -> Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    entries.iter().try_for_each(|entry| table.serialize(entry))?;
    table.into_inner().map_err(|e| e.into_error().into())
}

/// The page, which shows `best.png` of each design and leads to its report.
///
/// # Errors
/// None in practice: the template is the program's own.
pub fn page(entries: &[Entry]) -> Result<String> {
    let mut environment = environment()?;
    environment.add_template("overview.html", include_str!("overview.html.j2"))?;
    let (made, others): (Vec<_>, Vec<_>) =
        entries.iter().map(Card::of).partition(|card| card.entry.score.is_some());
    let (failed, waiting): (Vec<_>, Vec<_>) =
        others.into_iter().partition(|card| card.entry.reason.is_some());
    let page = context! {
        made => Serde(&made), failed => Serde(&failed), waiting => waiting.len(), all => entries.len(),
    };
    let page = environment.get_template("overview.html")?.render(page);
    Ok(visible(&page.context("the overview's template")?).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MADE: Entry = Entry {
        name: "50% off #1",
        scene: "models/a.glb",
        state: "done",
        headlight: Some(0.5),
        score: Some(0.25),
        seconds: Some(1.5),
        reason: None,
    };
    const FAILED: Entry = Entry {
        name: "<b>",
        state: "failed",
        headlight: None,
        score: None,
        seconds: None,
        reason: Some("is empty, and \"odd\""),
        ..MADE
    };

    #[test]
    fn every_design_has_a_row() {
        let table = String::from_utf8(table(&[MADE, FAILED]).unwrap()).unwrap();
        let expected = "name,scene,state,headlight,score,seconds,reason\n\
            50% off #1,models/a.glb,done,0.5,0.25,1.5,\n\
            <b>,models/a.glb,failed,,,,\"is empty, and \"\"odd\"\"\"\n";
        assert_eq!(table, expected);
    }

    #[test]
    fn the_page_shows_designs_and_says_why_others_failed() {
        let page = page(&[MADE, FAILED]).unwrap();
        assert!(page.contains("src=\"50%25%20off%20%231/best.png\""));
        assert!(page.contains("href=\"50%25%20off%20%231/report.html\""));
        assert!(
            page.contains("&lt;b&gt;") && page.contains("is empty, and") && !page.contains("<b><")
        );
        assert!(page.contains("1 of 2") && page.contains("0.250"));
    }
}
