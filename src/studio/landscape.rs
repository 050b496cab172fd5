//! `F` of one light in all directions, in one batch.

use super::answers::{Answer, Mapped};
use super::convert::{chosen, rig};
use super::hall::Hall;
use super::messages::Map;
use super::stage::Sight;
use super::worker::Worker;
use crate::Result;
use crate::cpu::{self, CpuEvaluator};
use crate::design::coarse;
use crate::error::within;
use crate::evaluate::Evaluator;
use crate::lighting::{Light, Population, angles};
use crate::objective::Objective;
use crate::objective::maps::Maps;
use crate::objective::shadows::ShadowSettings;
use crate::scene::view::View;
use glam::Vec3;

/// Longest side of the pictures that are judged, pixels.
const JUDGED: u32 = 64;

/// Directions along a side of their shadow table.
const SIDE: u32 = 15;

/// Most cells of a side.
const MOST_CELLS: f32 = 129.0;

/// What judges small pictures of a sight.
pub struct Landscape {
    sight: Sight,
    whole: View,
    view: View,
    maps: Maps,
    /// The last objective, and what measures for it.
    evaluator: Option<(Objective, CpuEvaluator)>,
}

impl Landscape {
    fn new(hall: &Hall, sight: Sight) -> Result<Self> {
        let whole = sight.view(&hall.held)?;
        let view = whole.shrunk(&hall.held.scene, JUDGED)?;
        let settings = hall.settings();
        let objective = coarse::objective(&settings.objective, &whole, &view);
        let shadows = ShadowSettings { side: SIDE, ..settings.shadows };
        let occluders = hall.occluders(&sight.camera, &view)?;
        let maps = cpu::draw(&hall.held.scene, &view, &objective, (&shadows, occluders))?;
        Ok(Self { sight, whole, view, maps, evaluator: None })
    }

    fn scores(
        &mut self,
        hall: &Hall,
        objective: &Objective,
        population: &Population,
    ) -> Result<Vec<f32>> {
        let (whole, view) = (&self.whole, &self.view);
        if self.evaluator.as_ref().is_none_or(|(known, _)| known != objective) {
            let small = coarse::objective(objective, whole, view);
            let maps = self.maps.clone();
            let evaluator = CpuEvaluator::new(maps, view, small, hall.settings().shading)?;
            self.evaluator = Some((*objective, evaluator));
        }
        let mut scores = vec![0.0; population.len()];
        if let Some((_, evaluator)) = &mut self.evaluator {
            evaluator.evaluate(population, &mut scores)?;
        }
        Ok(scores)
    }
}

/// The direction of a place in the unit disc, x to the right and y upwards: Lambert's azimuthal equal-area projection about
/// the viewer; `None` outside.
pub fn direction([x, y]: [f32; 2]) -> Option<Vec3> {
    let square = x * x + y * y;
    if square > 1.0 {
        return None;
    }
    let scale = 2.0 * (1.0 - square).sqrt();
    Some(Vec3::new(scale * x, scale * y, 1.0 - 2.0 * square))
}

/// The place of the middle of each cell, row by row from the top.
fn cells(columns: u32, rows: u32) -> impl Iterator<Item = [f32; 2]> {
    let middle = |at: u32, count: u32| (2 * at + 1) as f32 / count as f32 - 1.0;
    (0..rows).flat_map(move |row| {
        (0..columns).map(move |column| [middle(column, columns), -middle(row, rows)])
    })
}

impl Worker {
    /// Judges one light in all directions.
    pub(super) fn map(&mut self, map: &Map) -> Result<()> {
        let hall = self.hall()?;
        let Map { id, light, columns, rows, .. } = *map;
        within("columns", columns as f32, 1.0, MOST_CELLS)?;
        within("rows", rows as f32, 1.0, MOST_CELLS)?;
        let mut lights = rig(&map.look.lights)?;
        let objective = map.look.objective(&hall.settings().objective)?;
        let moved = chosen(&lights, light)?;
        let directions: Vec<Option<Vec3>> = cells(columns, rows).map(direction).collect();
        let mut population = Population::new(lights.len())?;
        for direction in directions.iter().flatten() {
            let (elevation, azimuth) = angles(*direction);
            lights[light as usize] = Light { elevation, azimuth, ..moved };
            population.push(&lights)?;
        }
        let sight = Sight { camera: map.look.camera.clone(), size: map.size };
        let mut landscape = match self.landscape.take() {
            Some(known) if known.sight == sight => known,
            _ => Landscape::new(&hall, sight)?,
        };
        let scores = landscape.scores(&hall, &objective, &population)?;
        self.landscape = Some(landscape);
        let mut scores = scores.into_iter();
        let values: Vec<Option<f32>> =
            directions.iter().map(|direction| direction.and_then(|_| scores.next())).collect();
        let judged = directions.iter().zip(&values).filter_map(|(d, value)| Some((*d, (*value)?)));
        let best = judged.min_by(|a, b| a.1.total_cmp(&b.1)).and_then(|(direction, _)| direction);
        let best = best.unwrap_or(Vec3::Z).to_array();
        self.send(Answer::Mapped(Mapped { id, light, columns, rows, values, best }))
    }
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
}
