//! Results for people, and the way to standard output.

use crate::objective::Quality;
use crate::report::gallery::GalleryRecord;
use crate::report::json::{Design, LightRecord, Score, ViewsRecord};
use crate::report::text::visible;
use anstyle::Style;
use anyhow::{Context, Result};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

/// Most columns of a table.
const WIDTH: u16 = 80;

/// Writes to standard output, control characters escaped. A reader that has seen enough and gone away is no failure.
///
/// # Errors
/// When it cannot be written to.
pub(super) fn out(text: impl Display) -> Result<()> {
    bytes(visible(&text.to_string()).as_bytes())
}

/// Writes to standard output what is no text for people.
///
/// # Errors
/// As [`out`].
pub(super) fn bytes(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result.context("cannot write to standard output"),
    }
}

/// Writes a line to standard error. Where it cannot be written, nobody is there to read it.
pub(super) fn note(text: impl Display) {
    let _ = std::io::stderr().write_all(visible(&format!("{text}\n")).as_bytes());
}

/// The same with words before it, the second of which has a style.
pub(super) fn styled_note((first, name, style): (&str, &str, Style), text: &str) {
    let line = format!("{first}{style}{name}{style:#}{}\n", visible(text));
    let _ = anstream::stderr().write_all(line.as_bytes());
}

/// A name as a table has it: one line.
pub(super) fn name(name: &str) -> String {
    visible(&name.replace(['\n', '\t'], " ")).into_owned()
}

/// Bytes in words.
pub(super) fn bytes_in_words(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    let unit = units.into_iter().find(|&(power, _)| bytes >> power > 0);
    unit.map_or(format!("{bytes} bytes"), |(power, unit)| {
        format!("{:.1} {unit}", bytes as f64 / f64::from(1 << power))
    })
}

/// The files that a command wrote, a line each.
pub(super) fn written(files: &[PathBuf]) -> String {
    files.iter().map(|file| format!("  {}\n", file.display())).collect()
}

/// What a design found, and where it stands.
pub(super) fn design(design: &Design, files: &[PathBuf]) -> String {
    let qualities = qualities(&[("headlight", &design.headlight), ("designed", &design.quality)]);
    let (generations, evaluations) = (design.generations, design.evaluations);
    let seconds = design.timing_ms.search / 1e3;
    let own = design.scene_lights.in_words().map_or(String::new(), |words| format!("{words}\n\n"));
    let views = design.views.as_ref().map_or(String::new(), views);
    format!(
        "{qualities}\n\n{views}{}\n\n{own}{generations} generations, {evaluations} evaluations in {seconds:.1} s\n{}",
        lights(&design.lights),
        written(files)
    )
}

/// The lights of a gallery, and where it stands.
pub(super) fn gallery(gallery: &GalleryRecord, files: &[PathBuf]) -> String {
    let mut table = columns(&["number"], &["F", "nearest", "lights"]);
    for rig in &gallery.rigs {
        let light = |light: &LightRecord| {
            let LightRecord { role, elevation_deg, azimuth_deg, .. } = light;
            format!("{} {elevation_deg:.0}° {azimuth_deg:.0}°", role.name())
        };
        table.add_row([
            rig.number.to_string(),
            format!("{:.4}", rig.quality.score),
            rig.nearest.map_or("–".into(), |distance| format!("{distance:.1}")),
            rig.lights.iter().map(light).collect::<Vec<_>>().join(", "),
        ]);
    }
    let (evaluations, seconds) = (gallery.evaluations, gallery.timing_ms.search / 1e3);
    let pages: Vec<_> = files.iter().rev().take(2).rev().cloned().collect();
    format!("{table}\n\n{evaluations} evaluations in {seconds:.1} s\n{}", written(&pages))
}

/// A rig's quality.
pub(super) fn score(score: &Score) -> String {
    let qualities = qualities(&[(score.rig, &score.quality)]);
    let views = score.views.as_ref().map_or(String::new(), views);
    format!("{qualities}\n\n{views}{}\n", lights(&score.lights))
}

/// `F` in each of several views.
fn views(views: &ViewsRecord) -> String {
    let headlight = views.each.iter().all(|view| view.headlight.is_some());
    let names: &[&str] = if headlight { &["headlight", "F"] } else { &["F"] };
    let mut table = columns(&["view"], names);
    for view in &views.each {
        let headlight = view.headlight.map(|quality| quality.score);
        let scores = headlight.into_iter().chain([view.quality.score]);
        table.add_row(
            [name(&view.title)].into_iter().chain(scores.map(|score| format!("{score:.4}"))),
        );
    }
    format!("{table}\n\n")
}

/// `F` and its terms, a column for each rig; all have the same terms.
fn qualities(rigs: &[(&str, &Quality)]) -> Table {
    let names: Vec<_> = rigs.iter().map(|(name, _)| *name).collect();
    let mut table = columns(&[""], &names);
    let mut row = |name: &str, value: &dyn Fn(&Quality) -> f32| {
        let values = rigs.iter().map(|(_, quality)| format!("{:.4}", value(quality)));
        table.add_row([name.to_owned()].into_iter().chain(values));
    };
    row("F", &|quality| quality.score);
    for (at, name) in rigs.iter().take(1).flat_map(|(_, q)| q.terms.names()).enumerate() {
        row(name, &|quality| quality.terms.values().nth(at).unwrap_or(f32::NAN));
    }
    table
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

/// The table with long texts broken into lines, so that it fits.
pub(super) fn wrapped(mut table: Table) -> Table {
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    table
}

/// Leaves one blank between columns, where there are many.
pub(super) fn tighten(table: &mut Table) {
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
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
