//! Results for people, and the way to standard output.

use crate::objective::Terms;
use crate::report::json::{Design, LightRecord, Score};
use crate::report::text::visible;
use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

/// Writes to standard output, control characters escaped. A reader that has seen enough and gone away is no failure.
///
/// # Errors
/// When it cannot be written to.
pub(super) fn out(text: impl Display) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(visible(&text.to_string()).as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result.context("cannot write to standard output"),
    }
}

/// Writes a line to standard error. Where it cannot be written, nobody is there to read it.
pub(super) fn note(text: impl Display) {
    let _ = std::io::stderr().write_all(visible(&format!("{text}\n")).as_bytes());
}

/// A name as a table has it: one line.
pub(super) fn name(name: &str) -> String {
    visible(&name.replace(['\n', '\t'], " ")).into_owned()
}

/// The files that a command wrote, a line each.
pub(super) fn written(files: &[PathBuf]) -> String {
    files.iter().map(|file| format!("  {}\n", file.display())).collect()
}

/// What a design found, and where it stands.
pub(super) fn design(design: &Design, files: &[PathBuf]) -> String {
    let mut qualities = columns(&["", "F"], &names(&design.quality.terms));
    for (name, quality) in [("headlight", &design.headlight), ("designed", &design.quality)] {
        qualities.add_row(quality_row(name, quality.score, &quality.terms));
    }
    let (generations, evaluations) = (design.generations, design.evaluations);
    let seconds = design.timing_ms.search / 1e3;
    let own = design.scene_lights.in_words().map_or(String::new(), |words| format!("{words}\n\n"));
    format!(
        "{qualities}\n\n{}\n\n{own}{generations} generations, {evaluations} evaluations in {seconds:.1} s\n{}",
        lights(&design.lights),
        written(files)
    )
}

/// A rig's quality.
pub(super) fn score(score: &Score) -> String {
    let mut qualities = columns(&["", "F"], &names(&score.quality.terms));
    qualities.add_row(quality_row(score.rig, score.quality.score, &score.quality.terms));
    format!("{qualities}\n\n{}\n", lights(&score.lights))
}

fn names(terms: &Terms) -> Vec<&'static str> {
    terms.names().collect()
}

fn quality_row(name: &str, score: f32, terms: &Terms) -> Vec<String> {
    let numbers = [score].into_iter().chain(terms.values());
    [name.into()].into_iter().chain(numbers.map(|x| format!("{x:.4}"))).collect()
}

fn lights(lights: &[LightRecord]) -> Table {
    let names =
        ["role", "kind", "colour", "elevation", "azimuth", "distance", "diffuse", "specular"];
    let mut table = columns(&names, &[]);
    for light in lights {
        table.add_row([
            light.role.name().into(),
            light.kind.to_string(),
            light.color.to_string(),
            format!("{:.1}°", light.elevation_deg),
            format!("{:.1}°", light.azimuth_deg),
            light.distance.map_or("–".into(), |distance| format!("{distance:.2}")),
            format!("{:.3}", light.diffuse),
            format!("{:.3}", light.specular),
        ]);
    }
    table
}

/// An empty table with a header, its columns but the first aligned to the right.
pub(super) fn columns(names: &[&str], more: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(names.iter().chain(more));
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
