//! Greedy descents from several starts: their paths over the landscape, and the pictures at both ends.

use super::landscape::{heat_map, position};
use super::{Exhibit, Studio, table};
use crate::report::plot;
use crate::study::landscape::Landscape;
use crate::study::starts::Path;
use crate::study::statistics::Quartiles;
use anyhow::Result;
use serde::Serialize;

/// Difference of `F` from which on two ends count as different.
const APART: f32 = 0.01;

/// The descents in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Every descent.
    pub descents: Vec<DescentRecord>,
    /// The lowest end less the lowest place of the landscape.
    pub best_above_landscape: f32,
    /// The highest end less the lowest end.
    pub spread: f32,
    /// Descents that ended `apart` or more above the lowest place of the landscape or of all ends.
    pub caught: usize,
    /// The difference meant by `caught`.
    pub apart: f32,
}

/// One descent.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct DescentRecord {
    /// Steps that were taken.
    pub steps: usize,
    /// Where it began.
    pub start: End,
    /// Where it ended.
    pub end: End,
}

/// An end of a descent.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct End {
    /// Elevation, degrees.
    pub elevation_deg: f32,
    /// Azimuth, degrees.
    pub azimuth_deg: f32,
    /// `F`.
    pub score: f32,
}

fn end(path: &Path, step: usize) -> End {
    let [azimuth_deg, elevation_deg] = position(&path.lights[step]);
    End { elevation_deg, azimuth_deg, score: path.scores[step] }
}

/// The exhibit of descents over the landscape of the same light.
///
/// # Errors
/// The plotting library's reason, and what the studio reports.
pub fn exhibit(
    landscape: &Landscape,
    paths: &[Path],
    studio: &mut dyn Studio,
) -> Result<Exhibit<Figures>> {
    let descents: Vec<_> = paths
        .iter()
        .map(|path| {
            let steps = path.lights.len() - 1;
            DescentRecord { steps, start: end(path, 0), end: end(path, steps) }
        })
        .collect();
    let ends: Vec<f32> = descents.iter().map(|descent| descent.end.score).collect();
    let Quartiles { low, high, .. } = Quartiles::of(&ends);
    let lowest = landscape.qualities[landscape.best()].score;
    let data = Figures {
        best_above_landscape: low - lowest,
        spread: high - low,
        caught: ends.iter().filter(|end| **end >= low.min(lowest) + APART).count(),
        apart: APART,
        descents,
    };

    let labels: Vec<String> = (1..=paths.len()).map(|number| number.to_string()).collect();
    let points: Vec<Vec<[f32; 2]>> =
        paths.iter().map(|path| path.lights.iter().map(position).collect()).collect();
    let lines: Vec<_> =
        labels.iter().zip(&points).map(|(label, points)| plot::Path { label, points }).collect();
    let plots = vec![("starts".to_owned(), heat_map(landscape, &lines)?)];

    let mut pictures = Vec::new();
    for (label, path) in labels.iter().zip(paths) {
        let last = path.lights.len() - 1;
        pictures.push((format!("start-{label}"), studio.paint(&path.lights[..1])?));
        pictures.push((format!("end-{label}"), studio.paint(&path.lights[last..])?));
    }
    let rows = paths.iter().enumerate().flat_map(|(i, path)| {
        (0..path.lights.len()).map(move |step| (i + 1, step, end(path, step)))
    });
    let rows =
        rows.map(|(descent, step, at)| (descent, step, at.elevation_deg, at.azimuth_deg, at.score));
    let names = ["descent", "step", "elevation_deg", "azimuth_deg", "score"];
    Ok(Exhibit { data, tables: vec![("starts", table(&names, rows)?)], plots, pictures })
}
