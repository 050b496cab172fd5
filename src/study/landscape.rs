//! `F` over the positions of one light at constant intensity (Ha and Olivier 2006, figures 5 and 6):
//! how many valleys a search can be caught in.

use super::{Observe, Subject};
use crate::lighting::genome::Genome;
use crate::lighting::{Light, Population};
use crate::objective::Quality;
use crate::{Error, Result};
use serde::Serialize;

/// Most positions of a landscape.
pub const MAX_POSITIONS: usize = 1 << 20;

/// Positions that are evaluated together.
const TOGETHER: usize = 1 << 10;

/// Elevation from which on a row of positions is one: straight above, whatever the azimuth.
const POLE: f32 = std::f32::consts::FRAC_PI_2 - 1e-4;

/// Positions on a regular grid over a box: elevations in rows, the lowest first, azimuths in columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Azimuths, 2 or more.
    pub columns: usize,
    /// Elevations, 2 or more.
    pub rows: usize,
}

impl Default for Grid {
    /// Steps of 2° over the key's box.
    fn default() -> Self {
        Self { columns: 91, rows: 46 }
    }
}

/// A place that is lower than all its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Minimum {
    /// Its index in the landscape.
    pub at: usize,
    /// How far `F` must rise on the way to any lower place; for the lowest, to the highest.
    pub depth: f32,
}

/// `F` and the terms over the positions of one light.
#[derive(Debug, Clone, PartialEq)]
pub struct Landscape {
    /// The grid.
    pub grid: Grid,
    /// The light at every position, row after row.
    pub lights: Vec<Light>,
    /// Its quality there.
    pub qualities: Vec<Quality>,
    /// The strict local minima, the lowest first.
    pub minima: Vec<Minimum>,
}

impl Landscape {
    /// Index of the lowest `F`, the first of equals.
    pub fn best(&self) -> usize {
        self.scores().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(at, _)| at)
    }

    /// Index of the highest `F`, the first of equals.
    pub fn worst(&self) -> usize {
        self.scores().enumerate().min_by(|a, b| b.1.total_cmp(&a.1)).map_or(0, |(at, _)| at)
    }

    /// `F` at every position.
    pub fn scores(&self) -> impl Iterator<Item = f32> {
        self.qualities.iter().map(|quality| quality.score)
    }
}

/// Measures the light of a genome of one light at every position of its box, with every other value
/// in the middle of its range.
///
/// # Errors
/// [`Error::Argument`] for a grid out of range or a genome of several lights,
/// [`Error::Interrupted`], and what the evaluator reports.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    grid: Grid,
    observe: &mut Observe,
) -> Result<Landscape> {
    let lights = positions(genome, grid)?;
    let mut qualities = Vec::with_capacity(lights.len());
    for lights in lights.chunks(TOGETHER) {
        let population = Population::of(lights.iter().map(std::slice::from_ref))?;
        qualities.extend(subject.evaluator.qualities(&population)?);
        if observe(lights.len()).is_break() {
            return Err(Error::Interrupted);
        }
    }
    let scores: Vec<f32> = qualities.iter().map(|quality| quality.score).collect();
    let poles: Vec<bool> =
        lights.iter().step_by(grid.columns).map(|light| light.elevation >= POLE).collect();
    let minima = strict_minima(&scores, grid.columns, &poles);
    Ok(Landscape { grid, lights, qualities, minima })
}

fn positions(genome: &Genome, grid: Grid) -> Result<Vec<Light>> {
    let Grid { columns, rows } = grid;
    if genome.lights() != 1 {
        let fault = format!("a landscape is of one light, not of {}", genome.lights());
        return Err(Error::Argument(fault));
    }
    genome.check_angles()?;
    let total = columns.checked_mul(rows);
    if columns < 2 || rows < 2 || total.is_none_or(|total| total > MAX_POSITIONS) {
        return Err(Error::Argument(format!(
            "a grid of {columns}x{rows}: it needs 2 or more a side and at most {MAX_POSITIONS} in all"
        )));
    }
    let bounds = genome.bounds();
    let middle: Vec<f32> = bounds.iter().map(|range| range.middle()).collect();
    let light = |place: usize| {
        let share = |at: usize, count: usize| at as f32 / (count - 1) as f32;
        let mut chromosome = middle.clone();
        chromosome[0] = bounds[0].at(share(place / columns, rows));
        // At the pole every azimuth is the same light, and gets the same bits.
        let pole = chromosome[0] >= POLE;
        chromosome[1] =
            if pole { bounds[1].middle() } else { bounds[1].at(share(place % columns, columns)) };
        genome.decode(&chromosome).remove(0)
    };
    Ok((0..columns * rows).map(light).collect())
}

/// The strict local minima of values in rows of `columns`, the lowest first: places that are lower
/// than each of their eight neighbours. The rows that `poles` marks are one place each.
pub fn strict_minima(values: &[f32], columns: usize, poles: &[bool]) -> Vec<Minimum> {
    let place = |row: usize, column: usize| row * columns + if poles[row] { 0 } else { column };
    let mut neighbours = Vec::new();
    for (row, column) in (0..poles.len()).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let mut join = |row: usize, other: usize, column_of_other: usize| {
            if other < poles.len() && column_of_other < columns {
                let pair = (place(row, column), place(other, column_of_other));
                neighbours.extend((pair.0 != pair.1).then_some(pair));
            }
        };
        join(row, row, column + 1);
        join(row, row + 1, column.wrapping_sub(1));
        join(row, row + 1, column);
        join(row, row + 1, column + 1);
    }
    let mut lowest: Vec<bool> =
        (0..values.len()).map(|at| place(at / columns, at % columns) == at).collect();
    for &(a, b) in &neighbours {
        // Written so that what is not a number is lower than nothing.
        lowest[a] &= values[a] < values[b];
        lowest[b] &= values[b] < values[a];
    }
    let depths = depths(values, neighbours);
    let minimum = |at: usize| Minimum { at, depth: depths[at] };
    let mut minima: Vec<_> = (0..values.len()).filter(|&at| lowest[at]).map(minimum).collect();
    minima.sort_by(|a, b| values[a.at].total_cmp(&values[b.at]));
    minima
}

/// For the lowest place of every valley, how far the ground rises before it falls lower than there:
/// valleys are flooded and joined from the lowest pass to the highest (the persistence of Edelsbrunner,
/// Letscher and Zomorodian 2002).
fn depths(values: &[f32], mut passes: Vec<(usize, usize)>) -> Vec<f32> {
    let height = |&(a, b): &(usize, usize)| values[a].max(values[b]);
    passes.sort_by(|a, b| height(a).total_cmp(&height(b)));
    let mut depths = vec![0.0; values.len()];
    // Every place points towards the lowest of its valley, which points to itself.
    let mut below: Vec<usize> = (0..values.len()).collect();
    let bottom = |below: &mut [usize], mut at: usize| {
        while below[at] != at {
            below[at] = below[below[at]];
            at = below[at];
        }
        at
    };
    let mut highest = f32::NEG_INFINITY;
    for pass in passes {
        highest = highest.max(height(&pass));
        let (a, b) = (bottom(&mut below, pass.0), bottom(&mut below, pass.1));
        if a != b {
            let (low, high) = if values[a] <= values[b] { (a, b) } else { (b, a) };
            depths[high] = height(&pass) - values[high];
            below[high] = low;
        }
    }
    for at in 0..values.len() {
        if below[at] == at {
            depths[at] = highest - values[at];
        }
    }
    depths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::genome::Boxes;
    use crate::lighting::{LightKind, Role};
    use proptest::prelude::*;

    /// Values of a function on a grid over 0..1 × 0..1.
    fn sample(columns: usize, rows: usize, f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        let share = |at: usize, count: usize| at as f32 / (count - 1) as f32;
        let value = |at: usize| f(share(at % columns, columns), share(at / columns, rows));
        (0..columns * rows).map(value).collect()
    }

    #[test]
    fn minima_of_a_known_function_are_counted_and_measured() {
        // Three by two valleys: cos(6πx)·… has its minima inside, at x = 1/6, 3/6, 5/6.
        let waves = |x: f32, y: f32| {
            let tau = std::f32::consts::TAU;
            (3.0 * tau * x).cos() + (2.0 * tau * y).cos() + 0.1 * x + 0.01 * y
        };
        let values = sample(91, 46, waves);
        let minima = strict_minima(&values, 91, &[false; 46]);
        assert_eq!(minima.len(), 6);
        let column = |minimum: &Minimum| (minimum.at % 91) as f32 / 90.0;
        assert!((column(&minima[0]) - 1.0 / 6.0).abs() < 0.02);
        assert!((column(&minima[5]) - 5.0 / 6.0).abs() < 0.02);
        // From the bottom at −2 to a saddle at 0, and for the lowest to the top.
        assert!((minima[5].depth - 2.0).abs() < 0.05, "{:?}", minima[5]);
        assert!((minima[0].depth - 4.0).abs() < 0.2, "{:?}", minima[0]);
        let mut planted = values;
        planted[20 * 91 + 45] = -9.0;
        let minima = strict_minima(&planted, 91, &[false; 46]);
        assert!(minima.len() == 7 && minima[0].at == 20 * 91 + 45);
    }

    #[test]
    fn level_ground_has_no_strict_minimum() {
        assert!(strict_minima(&[0.5; 12], 4, &[false; 3]).is_empty());
        assert!(strict_minima(&[f32::NAN; 12], 4, &[false; 3]).is_empty());
        // Two equal places side by side are no strict minimum either.
        let values = [3.0, 3.0, 3.0, 3.0, 1.0, 1.0, 3.0, 3.0];
        assert!(strict_minima(&values, 4, &[false; 2]).is_empty());
    }

    #[test]
    fn corners_and_sides_can_be_minima() {
        let bowl = sample(5, 5, |x, y| x + y);
        let minima = strict_minima(&bowl, 5, &[false; 5]);
        assert_eq!(minima, [Minimum { at: 0, depth: 2.0 }]);
    }

    #[test]
    fn the_pole_is_one_place() {
        let down_to_the_pole = sample(6, 4, |_, y| -y);
        let poles = [false, false, false, true];
        let minima = strict_minima(&down_to_the_pole, 6, &poles);
        assert_eq!(minima, [Minimum { at: 18, depth: 1.0 }]);
        assert!(strict_minima(&down_to_the_pole, 6, &[false; 4]).is_empty());
    }

    #[test]
    fn positions_cover_the_box_and_meet_at_the_pole() {
        let genome = Genome::new(&[Role::Key], LightKind::POINT, &Boxes::default()).unwrap();
        let lights = positions(&genome, Grid { columns: 3, rows: 4 }).unwrap();
        let degrees = |light: &Light| {
            [light.elevation, light.azimuth].map(|angle| angle.to_degrees().round())
        };
        assert_eq!(degrees(&lights[0]), [0.0, -90.0]);
        assert_eq!(degrees(&lights[5]), [30.0, 90.0]);
        assert!(lights[9..].iter().all(|light| *light == lights[9]));
        assert_eq!((lights[7].diffuse, lights[7].distance), (1.0, 3.25));
        for grid in [Grid { columns: 1, rows: 9 }, Grid { columns: 1 << 11, rows: 1 << 10 }] {
            assert!(positions(&genome, grid).is_err());
        }
    }

    proptest! {
        #[test]
        fn minima_are_those_that_the_definition_gives(
            values in prop::collection::vec(0u8..9, 30),
        ) {
            let values: Vec<f32> = values.into_iter().map(f32::from).collect();
            let expected = (0..30).filter(|&at| {
                let (x, y) = (at as i32 % 6, at as i32 / 6);
                (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy))).all(|(nx, ny)| {
                    let outside = !(0..6).contains(&nx) || !(0..5).contains(&ny);
                    outside || (nx, ny) == (x, y) || values[(6 * ny + nx) as usize] > values[at]
                })
            });
            let mut found: Vec<_> = strict_minima(&values, 6, &[false; 5]).iter().map(|m| m.at).collect();
            found.sort_unstable();
            prop_assert_eq!(found, expected.collect::<Vec<_>>());
        }
    }
}
