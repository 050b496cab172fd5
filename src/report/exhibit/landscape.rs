//! The landscape of one light: a heat map with its minima, a surface, each term's own map, and the
//! pictures at the best, the worst and every local minimum.

use super::{Exhibit, PLOT, Studio, plotted, table};
use crate::lighting::{Light, LightKind, Role};
use crate::objective::{Quality, Terms};
use crate::report::plot::{self, Field, Mark, Path, Symbol};
use crate::study::landscape::Landscape;
use anyhow::Result;
use serde::Serialize;

/// Depth of a valley that no rounding and no single pixel makes.
const DEEP: f32 = 0.01;

/// Size of the terms' own maps, pixels.
const TERM_PLOT: (u32, u32) = (400, 310);

/// Minima that are named in the heat map.
const NAMED: usize = 9;

/// A landscape in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// The light.
    pub light: FixedLight,
    /// Azimuths and elevations of the grid.
    pub grid: GridRecord,
    /// The lowest `F`.
    pub best: Place,
    /// The highest `F`.
    pub worst: Place,
    /// Number of strict local minima.
    pub local_minima: usize,
    /// Of these, minima deeper than `deep`.
    pub deep_minima: usize,
    /// The depth meant by `deep_minima`.
    pub deep: f32,
    /// The strict local minima, the lowest first.
    pub minima: Vec<MinimumRecord>,
}

/// What stays constant of the light.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct FixedLight {
    /// Its role.
    pub role: Role,
    /// Point or directional.
    pub kind: LightKind,
    /// Diffuse intensity.
    pub diffuse: f32,
    /// Specular intensity.
    pub specular: f32,
    /// Distance, scene radii; none for a directional light.
    pub distance: Option<f32>,
}

impl From<&Light> for FixedLight {
    fn from(light: &Light) -> Self {
        let &Light { role, kind, diffuse, specular, .. } = light;
        let distance = light.reach();
        Self { role, kind, diffuse, specular, distance }
    }
}

/// The grid, angles in degrees.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct GridRecord {
    /// Number of azimuths.
    pub columns: usize,
    /// Number of elevations.
    pub rows: usize,
    /// First and last azimuth.
    pub azimuth_deg: [f32; 2],
    /// First and last elevation.
    pub elevation_deg: [f32; 2],
}

/// The light at a place.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Place {
    /// Elevation, degrees.
    pub elevation_deg: f32,
    /// Azimuth, degrees.
    pub azimuth_deg: f32,
    /// `F`.
    pub score: f32,
    /// Its terms.
    pub terms: Terms,
}

/// A strict local minimum.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct MinimumRecord {
    /// Where it is.
    #[serde(flatten)]
    pub place: Place,
    /// How far `F` rises on the way to any lower place.
    pub depth: f32,
}

fn place(landscape: &Landscape, at: usize) -> Place {
    let (light, quality) = (&landscape.lights[at], &landscape.qualities[at]);
    let [azimuth_deg, elevation_deg] = position(light);
    Place { elevation_deg, azimuth_deg, score: quality.score, terms: quality.terms }
}

/// Azimuth and elevation, degrees.
pub(super) fn position(light: &Light) -> [f32; 2] {
    [light.azimuth.to_degrees(), light.elevation.to_degrees()]
}

fn grid(landscape: &Landscape) -> GridRecord {
    let crate::study::landscape::Grid { columns, rows } = landscape.grid;
    // A row at the pole has one azimuth alone.
    let row = if rows > 1 && landscape.lights[0] == landscape.lights[1] { rows - 1 } else { 0 };
    let corner = |row: usize, column: usize| position(&landscape.lights[row * columns + column]);
    GridRecord {
        columns,
        rows,
        azimuth_deg: [corner(row, 0)[0], corner(row, columns - 1)[0]],
        elevation_deg: [corner(0, 0)[1], corner(rows - 1, 0)[1]],
    }
}

/// The heat map of `F` with its best, worst and lowest minima, and paths over it.
pub(super) fn heat_map(landscape: &Landscape, paths: &[Path]) -> Result<String> {
    let scores: Vec<f32> = landscape.scores().collect();
    let others: Vec<_> =
        landscape.minima.iter().map(|m| m.at).filter(|&at| at != landscape.best()).collect();
    let labels: Vec<String> = (2..others.len() + 2).map(|number| number.to_string()).collect();
    let mark =
        |symbol, at: usize, label| Mark { symbol, at: position(&landscape.lights[at]), label };
    let minima = others.iter().zip(&labels).enumerate();
    let mut marks: Vec<Mark> = minima
        .map(|(i, (&at, label))| mark(Symbol::Minimum, at, if i + 1 < NAMED { label } else { "" }))
        .collect();
    marks.push(mark(Symbol::Worst, landscape.worst(), ""));
    marks.push(mark(Symbol::Best, landscape.best(), ""));
    plotted(plot::heat_map(&field(landscape, &scores, "F"), &marks, paths, PLOT))
}

fn field<'a>(landscape: &Landscape, values: &'a [f32], name: &'a str) -> Field<'a> {
    let GridRecord { columns, azimuth_deg, elevation_deg, .. } = grid(landscape);
    Field { azimuth: azimuth_deg, elevation: elevation_deg, columns, values, name }
}

/// The exhibit.
///
/// # Errors
/// The plotting library's reason, and what the studio reports.
pub fn exhibit(landscape: &Landscape, studio: &mut dyn Studio) -> Result<Exhibit<Figures>> {
    let minima: Vec<_> = landscape
        .minima
        .iter()
        .map(|m| MinimumRecord { place: place(landscape, m.at), depth: m.depth })
        .collect();
    let data = Figures {
        light: FixedLight::from(&landscape.lights[0]),
        grid: grid(landscape),
        best: place(landscape, landscape.best()),
        worst: place(landscape, landscape.worst()),
        local_minima: minima.len(),
        deep_minima: minima.iter().filter(|m| m.depth >= DEEP).count(),
        deep: DEEP,
        minima,
    };
    let mut plots = vec![("landscape".to_owned(), heat_map(landscape, &[])?)];
    let scores: Vec<f32> = landscape.scores().collect();
    plots.push(("surface".into(), plotted(plot::surface(&field(landscape, &scores, "F"), PLOT))?));
    let names = landscape.qualities.first().map(|quality| quality.terms.names());
    for (i, name) in names.into_iter().flatten().enumerate() {
        let value = |quality: &Quality| quality.terms.values().nth(i).unwrap_or(f32::NAN);
        let values: Vec<f32> = landscape.qualities.iter().map(value).collect();
        let title = format!("F_{name}");
        let map = plot::heat_map(&field(landscape, &values, &title), &[], &[], TERM_PLOT);
        plots.push((format!("term-{name}"), plotted(map)?));
    }
    let mut pictures = Vec::new();
    let mut picture = |name: String, at: usize| -> Result<()> {
        pictures.push((name, studio.paint(&landscape.lights[at..=at])?));
        Ok(())
    };
    picture("best".into(), landscape.best())?;
    picture("worst".into(), landscape.worst())?;
    for (i, minimum) in landscape.minima.iter().enumerate() {
        picture(format!("minimum-{:02}", i + 1), minimum.at)?;
    }
    Ok(Exhibit { data, tables: vec![("landscape", rows(landscape)?)], plots, pictures })
}

/// A row for each position.
fn rows(landscape: &Landscape) -> Result<Vec<u8>> {
    let terms = landscape.qualities.first().map(|quality| quality.terms.names());
    let names: Vec<_> = ["elevation_deg", "azimuth_deg", "score"]
        .into_iter()
        .chain(terms.into_iter().flatten())
        .chain(["minimum"])
        .collect();
    let mut is_minimum = vec![false; landscape.lights.len()];
    landscape.minima.iter().for_each(|minimum| is_minimum[minimum.at] = true);
    let row = |at: usize| {
        let place = place(landscape, at);
        let terms: Vec<_> = place.terms.values().collect();
        (place.elevation_deg, place.azimuth_deg, place.score, terms, u8::from(is_minimum[at]))
    };
    table(&names, (0..landscape.lights.len()).map(row))
}
