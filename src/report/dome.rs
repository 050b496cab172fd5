//! How good every direction is for each light of a rig, as discs on the sheet of a design.

use super::picture;
use crate::design::dome::{self, Dome};
use crate::lighting::Light;
use image::{Rgba, RgbaImage};
use serde::Serialize;

/// Width of a disc's picture, pixels.
const PIXELS: u32 = 192;

/// Radius of a disc in its diagram.
const RADIUS: f32 = 100.0;

/// Lines of equal `F` between the lowest and the highest.
const LEVELS: f32 = 10.0;

/// A blue that is seen on light and on dark pages alike.
const COLOR: [u8; 3] = [63, 134, 224];

/// The disc of one light on the page.
#[derive(Debug, Serialize)]
pub(super) struct Disc {
    /// The light's number, from 1.
    number: usize,
    /// The map, a transparent picture, the more opaque the lower `F`.
    source: String,
    /// The place with the lowest `F`.
    best: [f32; 2],
    /// Where all lights of the rig stand.
    places: Vec<[f32; 2]>,
}

impl Disc {
    /// The disc of a rig's light of number `at`.
    ///
    /// # Errors
    /// What the PNG encoder reports.
    pub fn new(rig: &[Light], at: usize, dome: &Dome) -> image::ImageResult<Self> {
        let source = picture::uri(&picture::final_png(&draw(dome))?);
        let places = rig.iter().map(|light| spot(light.direction())).collect();
        Ok(Self { number: at + 1, source, best: spot(dome.best), places })
    }
}

/// The place of a direction in a diagram, y downwards.
fn spot(direction: glam::Vec3) -> [f32; 2] {
    let [x, y] = dome::place(direction);
    [RADIUS * x, -RADIUS * y]
}

/// The map with lines of equal `F`, the more opaque the better.
fn draw(dome: &Dome) -> RgbaImage {
    let heights = Heights::of(dome);
    let [r, g, b] = COLOR;
    RgbaImage::from_fn(PIXELS, PIXELS, |x, y| {
        let [u, v] = [x, y].map(|at| (at as f32 + 0.5) / PIXELS as f32);
        let rim = (2.0 * u - 1.0).hypot(2.0 * v - 1.0);
        let inside = (0.5 * PIXELS as f32 * (1.0 - rim) + 0.5).clamp(0.0, 1.0);
        let (height, slope) = heights.at(u, v);
        let level = height * LEVELS;
        let line = 1.0 - (level - level.round()).abs() / (0.9 * slope * LEVELS).max(1e-6);
        let good = height.powf(1.6);
        let opacity = inside * (good + 0.3 * (1.0 - good) * line.max(0.0));
        Rgba([r, g, b, (opacity * 255.0).round() as u8])
    })
}

/// How good each cell is, 0 for the worst to 1 for the best.
struct Heights {
    columns: usize,
    rows: usize,
    cells: Vec<f32>,
}

impl Heights {
    /// Those of a map; cells beyond its rim are like those beside them.
    fn of(dome: &Dome) -> Self {
        let known = || dome.values.iter().flatten();
        let low = known().copied().fold(f32::INFINITY, f32::min);
        let high = known().copied().fold(f32::NEG_INFINITY, f32::max);
        let range = (high - low).max(1e-6);
        let (columns, rows) = (dome.columns as usize, dome.rows as usize);
        let cells = dome.values.iter().map(|value| value.map(|value| (high - value) / range));
        let mut cells: Vec<Option<f32>> = cells.collect();
        for _ in 0..2 {
            cells = extended(&cells, columns);
        }
        let cells = cells.into_iter().map(Option::unwrap_or_default).collect();
        Self { columns, rows, cells }
    }

    /// The height at shares of the map's width and height, and by how much it changes from pixel to pixel.
    fn at(&self, u: f32, v: f32) -> (f32, f32) {
        let along = |share: f32, count: usize| {
            let at = (share * count as f32 - 0.5).clamp(0.0, count as f32 - 1.0);
            let first = (at as usize).min(count.saturating_sub(2));
            (first, (first + 1).min(count - 1), at - first as f32)
        };
        let (left, right, s) = along(u, self.columns);
        let (top, bottom, t) = along(v, self.rows);
        let cell = |row: usize, column: usize| self.cells[row * self.columns + column];
        let upper = [cell(top, left), cell(top, right)];
        let lower = [cell(bottom, left), cell(bottom, right)];
        let mix = |[a, b]: [f32; 2], share: f32| a + (b - a) * share;
        let (above, below) = (mix(upper, s), mix(lower, s));
        let change = [mix([upper[1] - upper[0], lower[1] - lower[0]], t), below - above];
        let scale = [self.columns, self.rows].map(|count| count as f32 / PIXELS as f32);
        (mix([above, below], t), (change[0] * scale[0]).hypot(change[1] * scale[1]))
    }
}

/// The cells, those without a value having the mean of their neighbours with one.
fn extended(cells: &[Option<f32>], columns: usize) -> Vec<Option<f32>> {
    let rows = cells.len() / columns;
    let value = |at: usize| {
        let (row, column) = (at / columns, at % columns);
        let beside = (row.saturating_sub(1)..=(row + 1).min(rows - 1)).flat_map(|row| {
            let columns_beside = column.saturating_sub(1)..=(column + 1).min(columns - 1);
            columns_beside.filter_map(move |column| cells[row * columns + column])
        });
        let (total, count) = beside.fold((0.0, 0), |(sum, n), value| (sum + value, n + 1));
        cells[at].or((count > 0).then(|| total / count as f32))
    };
    (0..cells.len()).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// The lowest `F` lies to the upper right.
    fn sloping() -> Dome {
        let side = 33;
        let cell = |at: u32| {
            let [x, y] = [at % side, at / side].map(|at| (2 * at + 1) as f32 / side as f32 - 1.0);
            (x.hypot(y) <= 1.0).then_some(0.5 - 0.1 * x + 0.1 * y)
        };
        let values = (0..side * side).map(cell).collect();
        Dome { columns: side, rows: side, values, best: Vec3::new(0.5, 0.5, 0.5f32.sqrt()) }
    }

    #[test]
    fn the_better_a_direction_the_more_opaque_it_is_and_nothing_is_beyond_the_rim() {
        let picture = draw(&sloping());
        let mean = |x: u32, y: u32| -> f32 {
            let around = (x - 8..x + 8).flat_map(|x| (y - 8..y + 8).map(move |y| (x, y)));
            around.map(|(x, y)| f32::from(picture.get_pixel(x, y).0[3])).sum::<f32>() / 256.0
        };
        let [worst, middle, best] = [mean(40, 152), mean(96, 96), mean(152, 40)];
        assert!(
            worst < 30.0 && middle > worst + 40.0 && best > middle + 60.0,
            "{worst} {middle} {best}"
        );
        assert_eq!(picture.get_pixel(4, 4).0[3], 0);
    }

    #[test]
    fn a_map_without_any_slope_is_even() {
        let mut dome = sloping();
        dome.values.iter_mut().flatten().for_each(|value| *value = 0.5);
        let picture = draw(&dome);
        let inside = picture.get_pixel(96, 96).0[3];
        assert!(picture.pixels().all(|pixel| pixel.0[3] <= inside));
    }

    #[test]
    fn marks_stand_where_lights_do() {
        let rig = crate::lighting::presets::Preset::Headlight.rig();
        let disc = Disc::new(&rig, 0, &sloping()).unwrap();
        assert_eq!((disc.number, disc.places.len()), (1, rig.len()));
        assert!(disc.best[0] > 0.0 && disc.best[1] < 0.0, "{:?}", disc.best);
        assert!(disc.places[0].map(f32::abs).iter().all(|&at| at < 1.0));
    }
}
