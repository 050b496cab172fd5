//! The dome of all directions that light can come from, as a map, and `F` of one light in each of them.
//!
//! The map is Lambert's azimuthal equal-area projection about the viewer: a unit disc, x to the right and y upwards, in whose
//! middle light comes from the viewer, on the circle of radius `√½` from the side, and at the rim from behind.

use crate::Result;
use crate::evaluate::Evaluator;
use crate::lighting::{Light, Population, angles};
use glam::Vec3;

/// `F` of a rig with one of its lights in the direction of every cell of a grid over the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Dome {
    /// Cells of a row.
    pub columns: u32,
    /// Rows, the first at the top.
    pub rows: u32,
    /// `F` in the middle of each cell; none for cells outside the disc.
    pub values: Vec<Option<f32>>,
    /// The direction with the lowest `F`, in the light frame.
    pub best: Vec3,
}

impl Dome {
    /// Judges a rig with its light of number `at` in all directions, all else being as it is, in one batch.
    ///
    /// # Errors
    /// What the evaluator reports.
    ///
    /// # Panics
    /// If the rig has no such light.
    pub fn of(
        evaluator: &mut dyn Evaluator,
        rig: &[Light],
        at: usize,
        [columns, rows]: [u32; 2],
    ) -> Result<Self> {
        let directions: Vec<Option<Vec3>> = cells(columns, rows).map(direction).collect();
        let mut rig = rig.to_vec();
        let mut population = Population::new(rig.len())?;
        for direction in directions.iter().flatten() {
            let (elevation, azimuth) = angles(*direction);
            rig[at] = Light { elevation, azimuth, ..rig[at] };
            population.push(&rig)?;
        }
        let mut scores = vec![0.0; population.len()];
        if !population.is_empty() {
            evaluator.evaluate(&population, &mut scores)?;
        }
        let mut scores = scores.into_iter();
        let values =
            directions.iter().map(|direction| direction.and_then(|_| scores.next())).collect();
        let dome = Self { columns, rows, values, best: Vec3::Z };
        Ok(Self { best: dome.lowest(|_| true).unwrap_or(Vec3::Z), ..dome })
    }

    /// The direction with the lowest `F` of those that `may` be taken, in the light frame; none where no cell's may.
    pub fn lowest(&self, may: impl Fn(Vec3) -> bool) -> Option<Vec3> {
        let directions = cells(self.columns, self.rows).map(direction);
        let known = directions.zip(&self.values).filter_map(|(at, value)| at.zip(*value));
        let lowest = known.filter(|(at, _)| may(*at)).min_by(|a, b| a.1.total_cmp(&b.1));
        lowest.map(|(at, _)| at)
    }
}

/// The direction of a place on the map, a unit vector of the light frame; none outside the disc.
pub fn direction([x, y]: [f32; 2]) -> Option<Vec3> {
    let square = x * x + y * y;
    if square > 1.0 {
        return None;
    }
    let scale = 2.0 * (1.0 - square).sqrt();
    Some(Vec3::new(scale * x, scale * y, 1.0 - 2.0 * square))
}

/// The place of a direction on the map, a unit vector of the light frame; straight from behind it is on the right.
pub fn place(direction: Vec3) -> [f32; 2] {
    let across = direction.truncate().normalize_or(glam::Vec2::X);
    (across * (0.5 * (1.0 - direction.z)).max(0.0).sqrt()).to_array()
}

/// The place of the middle of each cell, row by row from the top.
fn cells(columns: u32, rows: u32) -> impl Iterator<Item = [f32; 2]> {
    let middle = |at: u32, count: u32| (2 * at + 1) as f32 / count as f32 - 1.0;
    (0..rows).flat_map(move |row| {
        (0..columns).map(move |column| [middle(column, columns), -middle(row, rows)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_shows_all_directions_with_equal_areas() {
        let near = |a: Option<Vec3>, b: Vec3| a.unwrap().abs_diff_eq(b, 1e-6);
        assert!(near(direction([0.0, 0.0]), Vec3::Z));
        assert!(near(direction([1.0, 0.0]), Vec3::NEG_Z) && direction([0.8, 0.7]).is_none());
        let half = 0.5f32.sqrt();
        assert!(near(direction([half, 0.0]), Vec3::X) && near(direction([0.0, half]), Vec3::Y));
        // Equal areas: half of the cells are before the scene, and a quarter of them is nearer to the viewer than 60°.
        let all: Vec<Vec3> = cells(101, 101).filter_map(direction).collect();
        let share =
            |least: f32| all.iter().filter(|d| d.z > least).count() as f32 / all.len() as f32;
        assert!((share(0.0) - 0.5).abs() < 0.01 && (share(0.5) - 0.25).abs() < 0.01);
        assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-5));
        // The first row is the upper one.
        let first = cells(5, 5).nth(2).unwrap();
        assert!(first[0].abs() < 1e-6 && first[1] > 0.7);
    }

    #[test]
    fn the_lowest_is_one_of_those_that_may_be_taken() {
        let values: Vec<_> = cells(9, 9).map(|at| direction(at).map(|to| to.y)).collect();
        let dome = Dome { columns: 9, rows: 9, values, best: Vec3::Z };
        assert!(dome.lowest(|_| true).unwrap().y < -0.9);
        let level = dome.lowest(|to| to.y >= 0.0).unwrap();
        assert!((0.0..0.3).contains(&level.y), "{level}");
        assert_eq!(dome.lowest(|_| false), None);
    }

    #[test]
    fn a_place_and_its_direction_tell_each_other() {
        for at in cells(21, 21) {
            let Some(direction) = direction(at) else { continue };
            let again = place(direction);
            assert!((again[0] - at[0]).abs() < 1e-5 && (again[1] - at[1]).abs() < 1e-5, "{at:?}");
        }
        assert_eq!((place(Vec3::Z), place(Vec3::NEG_Z)), ([0.0, 0.0], [1.0, 0.0]));
    }
}
