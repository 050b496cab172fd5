//! A field as a surface in space.

use super::field::{self, Field};
use super::overlay::{Overlay, hex};
use super::theme::{self, Area, Drawn, RULE, SOFT};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// From where the surface is seen: turned about the vertical so that the nearest corner is that of
/// the largest azimuth and the lowest elevation, and from above; degrees.
const YAW: f32 = 38.0;
const PITCH: f32 = 40.0;
/// Half the lengths of the box: azimuth, elevation, value.
const BOX: [f32; 3] = [1.0, 0.8, 0.45];
/// Room for numbers and names: left, right, above and below, pixels.
const ROOM: [f32; 4] = [80.0, 34.0, 14.0, 44.0];
/// A mesh line runs along every fifth row and column of the quadrilaterals.
const LINE: usize = 5;
const MESH: &str = "#0006";
/// More quadrilaterals than this are thinned out.
const MOST: usize = 4200;

/// A field over azimuth and elevation as a surface of quadrilaterals in Viridis, the lowest value
/// brightest, in a box with axes; where its lower side shows, that is darker. A field of more than 4200 cells is drawn at every second (third, …)
/// sample; quadrilaterals with a missing corner are left out.
///
/// # Errors
/// When the field is no grid, or the plotting library's reason, in words.
pub fn surface(field: &Field, size: (u32, u32)) -> Result<String, String> {
    field.check()?;
    let view = View::new(size);
    let frame = Frame::new(field, &view);
    let (svg, ()) = theme::render(size, |root| {
        frame.draw_lines(root)?;
        frame.draw_text(field.name, root)
    })?;
    let mut overlay = Overlay::default();
    // Lengths in tenths of a pixel are short whole numbers. Outlines cover the seams between pieces.
    overlay.push(format_args!(
        "<g transform=\"scale(.1)\" fill=\"currentColor\" stroke=\"currentColor\" \
         stroke-width=\"5\" stroke-linejoin=\"round\">\n"
    ));
    for Quad { corners, color, mesh, .. } in quads(field, &view) {
        let [a, b, c, d] =
            corners.map(|corner| corner.map(|length| (10.0 * length).round() as i32));
        let color = hex(color);
        overlay.push(format_args!("<path color=\"{color}\" d=\"{}z\"/>\n", outline(&[a, b, c, d])));
        let edges = match mesh {
            [false, false] => continue,
            [true, false] => outline(&[d, a]),
            [false, true] => outline(&[c, d]),
            [true, true] => outline(&[c, d, a]),
        };
        overlay.push(format_args!("<path color=\"{MESH}\" fill=\"none\" d=\"{edges}\"/>\n"));
    }
    overlay.push(format_args!("</g>\n"));
    Ok(overlay.on(svg))
}

/// A line through points as SVG has it, relative to each other.
fn outline(points: &[[i32; 2]]) -> String {
    let mut text = String::from("m");
    let mut last = [0, 0];
    for &[x, y] in points {
        text += &format!("{} {} ", x - last[0], y - last[1]);
        last = [x, y];
    }
    text.truncate(text.trim_end().len());
    text
}

/// A parallel projection of the box (−1..1 in azimuth, elevation and value) onto the plot.
struct View {
    scale: [f32; 2],
    offset: [f32; 2],
}

impl View {
    fn new((width, height): (u32, u32)) -> Self {
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 }));
        let corners: Vec<_> = corners.map(|corner| Self::turned(corner).0).collect();
        let [left, right, top, bottom] = ROOM;
        let axis = |k: usize, from: f32, to: f32| {
            let values = corners.iter().map(|corner| corner[k]);
            let (low, high) =
                values.fold((f32::MAX, f32::MIN), |(l, h), value| (l.min(value), h.max(value)));
            let scale = (to - from) / (high - low);
            (scale, from - low * scale)
        };
        let x = axis(0, left, width as f32 - right);
        let y = axis(1, top, height as f32 - bottom);
        Self { scale: [x.0, y.0], offset: [x.1, y.1] }
    }

    /// Right and down as the viewer sees it, and the distance from the viewer.
    fn turned(at: [f32; 3]) -> ([f32; 2], f32) {
        let [x, y, z] = [0, 1, 2].map(|k| at[k] * BOX[k]);
        let ((yaw_sin, yaw_cos), (sin, cos)) =
            (YAW.to_radians().sin_cos(), PITCH.to_radians().sin_cos());
        let (across, away) = (x * yaw_cos + y * yaw_sin, y * yaw_cos - x * yaw_sin);
        ([across, -(z * cos + away * sin)], away * cos - z * sin)
    }

    fn pixel(&self, at: [f32; 3]) -> [f32; 2] {
        let (place, _) = Self::turned(at);
        [0, 1].map(|k| place[k] * self.scale[k] + self.offset[k])
    }
}

/// A piece of the surface: its corners in pixels (counter-clockwise seen from above, from the lowest
/// azimuth and elevation), whether mesh lines run along its far edges (at its lowest azimuth and its
/// highest elevation), and how far it is.
struct Quad {
    corners: [[f32; 2]; 4],
    color: RGBColor,
    mesh: [bool; 2],
    away: f32,
}

/// The pieces from the farthest to the nearest.
fn quads(field: &Field, view: &View) -> Vec<Quad> {
    let (rows, columns) = (field.rows(), field.columns);
    let range = field.range();
    let cells = |count: usize| (count - 1).max(1);
    let mut step = 1;
    while cells(rows).div_ceil(step) * cells(columns).div_ceil(step) > MOST {
        step += 1;
    }
    // Places along an axis, -1..1, each with its sample: a single sample fills the axis.
    let places = |count: usize| {
        let last = cells(count);
        let samples = (0..last).step_by(step).chain([last]);
        let place = |i: usize| (2.0 * i as f32 / last as f32 - 1.0, i.min(count - 1));
        samples.map(place).collect::<Vec<_>>()
    };
    let (across, up) = (places(columns), places(rows));
    let value = |(_, column): (f32, usize), (_, row): (f32, usize)| {
        Some(field.values[row * columns + column]).filter(|&value| theme::drawable(value))
    };
    let height = |value: f32| 2.0 * (value - range.start) / (range.end - range.start) - 1.0;
    let mut quads = Vec::new();
    for (row, y) in up.windows(2).enumerate() {
        for (column, x) in across.windows(2).enumerate() {
            let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
            let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|(x, y)| value(x, y)) else {
                continue;
            };
            let heights = [a, b, c, d].map(height);
            let place = |k: usize| view.pixel([corners[k].0.0, corners[k].1.0, heights[k]]);
            let middle = [0.5 * (x[0].0 + x[1].0), 0.5 * (y[0].0 + y[1].0), 0.0];
            let corners = [0, 1, 2, 3].map(place);
            let color = field::color(0.25 * (a + b + c + d), &range);
            quads.push(Quad {
                color: if from_above(&corners) { color } else { shaded(color) },
                corners,
                mesh: [column.is_multiple_of(LINE), (row + 1).is_multiple_of(LINE)],
                away: View::turned(middle).1,
            });
        }
    }
    quads.sort_by(|a, b| b.away.total_cmp(&a.away));
    quads
}

/// Whether a piece shows its upper side.
fn from_above([a, b, c, d]: &[[f32; 2]; 4]) -> bool {
    let (across, up) = ([c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]);
    // Pixels count downwards, which turns the sense of rotation round.
    across[0] * up[1] - across[1] * up[0] < 0.0
}

/// The colour of a lower side.
fn shaded(RGBColor(r, g, b): RGBColor) -> RGBColor {
    let [r, g, b] = [r, g, b].map(|channel| channel / 5 * 3);
    RGBColor(r, g, b)
}

/// The box around a surface: the ranges of azimuth, elevation and value, and their ticks.
struct Frame<'a> {
    view: &'a View,
    ranges: [Range<f32>; 3],
    ticks: [Vec<f32>; 3],
}

impl<'a> Frame<'a> {
    fn new(field: &Field, view: &'a View) -> Self {
        let degrees =
            |[low, high]: [f32; 2]| if high > low { low..high } else { low - 0.5..high + 0.5 };
        let ranges = [degrees(field.azimuth), degrees(field.elevation), field.range()];
        let ticks = [
            theme::degree_ticks(&ranges[0], 5),
            theme::degree_ticks(&ranges[1], 4),
            theme::ticks(&ranges[2], 5),
        ];
        Self { view, ranges, ticks }
    }

    /// The pixel of a place in the box, −1..1.
    fn pixel(&self, at: [f32; 3]) -> (i32, i32) {
        let [x, y] = self.view.pixel(at);
        (x.round() as i32, y.round() as i32)
    }

    /// The ticks of an axis: places in the box, −1..1, and numbers.
    fn numbers(&self, axis: usize) -> impl Iterator<Item = (f32, String)> + '_ {
        let range = &self.ranges[axis];
        let place = |value: f32| 2.0 * (value - range.start) / (range.end - range.start) - 1.0;
        self.ticks[axis].iter().map(move |&value| (place(value), theme::number(value, range)))
    }

    /// The floor and the two walls behind the surface with their grid, and the axes in front.
    fn draw_lines(&self, root: &Area) -> Drawn {
        let line = |points: &[[f32; 3]], color: RGBColor| {
            let points: Vec<_> = points.iter().map(|&at| self.pixel(at)).collect();
            root.draw(&PathElement::new(points, color))
        };
        for axis in 0..3 {
            for (u, _) in self.numbers(axis) {
                // Across the floor and up a wall, or along both walls.
                let points = match axis {
                    0 => [[u, -1.0, -1.0], [u, 1.0, -1.0], [u, 1.0, 1.0]],
                    1 => [[1.0, u, -1.0], [-1.0, u, -1.0], [-1.0, u, 1.0]],
                    _ => [[-1.0, -1.0, u], [-1.0, 1.0, u], [1.0, 1.0, u]],
                };
                line(&points, RULE)?;
            }
        }
        line(&[[-1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, 1.0, -1.0]], RULE)?;
        line(&[[-1.0, 1.0, -1.0], [-1.0, -1.0, -1.0]], RULE)?;
        let front = [[-1.0, -1.0, 1.0], [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0]];
        line(&front, SOFT)
    }

    /// The numbers and names of the axes.
    fn draw_text(&self, name: &str, root: &Area) -> Drawn {
        let text = |text: &str, at: [f32; 3], (dx, dy): (i32, i32), h: HPos| {
            let (x, y) = self.pixel(at);
            let style = theme::font(SOFT).pos(Pos::new(h, VPos::Center));
            root.draw_text(text, &style, (x + dx, y + dy))
        };
        for (u, number) in self.numbers(0) {
            text(&number, [u, -1.0, -1.0], (-8, 14), HPos::Center)?;
        }
        for (u, number) in self.numbers(1) {
            text(&number, [1.0, u, -1.0], (8, 10), HPos::Left)?;
        }
        for (u, number) in self.numbers(2) {
            text(&number, [-1.0, -1.0, u], (-8, 0), HPos::Right)?;
        }
        text("azimuth (°)", [-0.1, -1.0, -1.0], (-30, 40), HPos::Right)?;
        // As far to the right as the plot's border allows.
        let elevation = "elevation (°)";
        let (x, _) = self.pixel([1.0, 0.0, -1.0]);
        let beyond = x + 16 + theme::width(elevation) - root.dim_in_pixel().0 as i32;
        text(elevation, [1.0, 0.0, -1.0], (16 - beyond.max(0), 52), HPos::Left)?;
        let (x, y) = self.pixel([-1.0, -1.0, 0.0]);
        let upright = theme::centred(&theme::font(SOFT), VPos::Bottom);
        let upright = upright.transform(FontTransform::Rotate270);
        root.draw_text(&format!("{name}, low is good"), &upright, (x - 54, y))
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::tests::{field, landscape};
    use super::*;

    const SIZE: (u32, u32) = (640, 460);

    #[test]
    fn a_surface_has_all_its_cells_and_axes() {
        let values = landscape();
        let plot = surface(&field(&values, 91), SIZE).unwrap();
        assert_eq!(plot.matches("z\"/>").count(), 90 * 45);
        assert!(plot.len() < 400_000, "{} bytes", plot.len());
        for text in ["azimuth (°)", "elevation (°)", "F, low is good", "−90", "45"] {
            assert!(plot.contains(text), "{text}");
        }
        let dense = vec![0.5; 300 * 200];
        assert_eq!(plot.matches("fill=\"none\" d=").count(), 18 * 45 + 9 * 90 - 18 * 9);
        let count = surface(&field(&dense, 300), SIZE).unwrap().matches("z\"/>").count();
        assert!((1000..=MOST).contains(&count), "{count}");
    }

    #[test]
    fn near_pieces_come_last_and_low_ones_are_yellow() {
        let values = [0.1, 0.5, 0.9, 0.1, 0.5, 0.9, 0.1, 0.5, 0.9];
        let quads = quads(&field(&values, 3), &View::new(SIZE));
        assert_eq!(quads.len(), 4);
        let lowest = |quad: &Quad| quad.corners.iter().map(|c| c[1]).fold(f32::MIN, f32::max);
        assert!(lowest(&quads[3]) > lowest(&quads[0]));
        let yellow = field::color(0.1, &(0.1..0.9));
        assert_eq!((yellow.0, yellow.1), (254, 232));
        let green = |quad: &Quad| quad.color.1;
        assert!(quads.iter().map(green).max() > quads.iter().map(green).min());
        assert!(quads.iter().all(|quad| from_above(&quad.corners)));
        let [a, b, c, d] = quads[0].corners;
        assert!(!from_above(&[a, d, c, b]));
    }

    #[test]
    fn poor_fields_are_drawn_too() {
        let nan = f32::NAN;
        let cases: [(&[f32], usize, usize); 6] = [
            (&[0.3; 6], 3, 2),
            (&[0.1, 0.2, 0.3], 3, 2),
            (&[0.1, 0.2, 0.3], 1, 2),
            (&[0.5], 1, 1),
            (&[nan; 4], 2, 0),
            (&[nan, 0.1, 0.2, 0.3, 0.4, 0.5], 3, 1),
        ];
        for (values, columns, expected) in cases {
            let plot = surface(&field(values, columns), SIZE).unwrap();
            assert_eq!(plot.matches("z\"/>").count(), expected, "{values:?}");
            assert!(plot.ends_with("</svg>\n") && !plot.contains("NaN"));
        }
        let point = Field { azimuth: [5.0; 2], elevation: [7.0; 2], ..field(&[0.5], 1) };
        assert!(surface(&point, SIZE).is_ok());
        assert!(surface(&field(&[0.5; 5], 2), SIZE).is_err());
    }
}
