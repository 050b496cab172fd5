//! Results for people, on standard output.

use crate::objective::Terms;
use crate::report::json::{Design, LightRecord, Score};
use comfy_table::{CellAlignment, Table, presets};
use std::path::PathBuf;

/// What a design found, and where it stands.
pub(super) fn design(design: &Design, files: &[PathBuf]) {
    let mut qualities = columns(&["", "F"], &Terms::NAMES);
    for (name, quality) in [("headlight", &design.headlight), ("designed", &design.quality)] {
        qualities.add_row(quality_row(name, quality.score, &quality.terms));
    }
    println!("{qualities}\n\n{}\n", lights(&design.lights));
    let (generations, evaluations) = (design.generations, design.evaluations);
    let seconds = design.timing_ms.search / 1e3;
    println!("{generations} generations, {evaluations} evaluations in {seconds:.1} s");
    files.iter().for_each(|file| println!("  {}", file.display()));
}

/// A rig's quality.
pub(super) fn score(score: &Score) {
    let mut qualities = columns(&["", "F"], &Terms::NAMES);
    qualities.add_row(quality_row(score.rig, score.quality.score, &score.quality.terms));
    println!("{qualities}\n\n{}", lights(&score.lights));
}

fn quality_row(name: &str, score: f32, terms: &Terms) -> Vec<String> {
    let numbers = [score].into_iter().chain(terms.to_array());
    [name.into()].into_iter().chain(numbers.map(|x| format!("{x:.4}"))).collect()
}

fn lights(lights: &[LightRecord]) -> Table {
    let names = ["role", "kind", "elevation", "azimuth", "distance", "diffuse", "specular"];
    let mut table = columns(&names, &[]);
    for light in lights {
        table.add_row([
            format!("{:?}", light.role).to_lowercase(),
            format!("{:?}", light.kind).to_lowercase(),
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
