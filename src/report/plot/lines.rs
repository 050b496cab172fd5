//! Lines on logarithmic axes.

use super::theme::{self, FIRST, Form, INK, SECOND, SOFT, Scale, THIRD};
use plotters::prelude::*;

/// Colours of series in turn; those of a second turn have hollow dots.
const SERIES: [RGBColor; 5] = [FIRST, SECOND, THIRD, INK, SOFT];

/// A line with a dot at each point.
#[derive(Debug, Clone)]
pub struct Line {
    /// What the legend calls it.
    pub name: String,
    /// `x` and `y`, both more than 0; other points are left out.
    pub points: Vec<[f32; 2]>,
}

impl Line {
    /// Decimal logarithms of the points.
    fn logarithms(&self) -> impl Iterator<Item = (f32, f32)> {
        let inside = |value: &f32| *value > 0.0 && theme::drawable(*value);
        let points = self.points.iter().filter(move |point| point.iter().all(inside));
        points.map(|[x, y]| (x.log10(), y.log10()))
    }
}

/// Every series as a line with dots, on two logarithmic axes, and a legend.
///
/// # Errors
/// The plotting library's reason, in words.
pub fn lines(
    series: &[Line],
    x_label: &str,
    y_label: &str,
    size: (u32, u32),
) -> Result<String, String> {
    theme::render(size, |root| draw(series, [x_label, y_label], root)).map(|(svg, ())| svg)
}

fn draw(series: &[Line], [x_label, y_label]: [&str; 2], root: &theme::Area) -> theme::Drawn {
    let names: Vec<_> = series.iter().map(|line| line.name.as_str()).collect();
    let (symbols, area) = theme::legend(root, &names)?;
    let points = || series.iter().flat_map(Line::logarithms);
    let (x, y) = (theme::span(points().map(|p| p.0)), theme::span(points().map(|p| p.1)));
    let mut chart =
        theme::chart(&area).build_cartesian_2d(Scale::logarithmic(x), Scale::logarithmic(y))?;
    let axes = theme::Axes { x: (x_label, 6), y: (y_label, 6), grid: true };
    theme::axes_of_form(&mut chart, &axes, [Form::Power, Form::Power])?;
    for (index, (line, symbol)) in series.iter().zip(symbols).enumerate() {
        let color = SERIES[index % SERIES.len()];
        let inner = if index < SERIES.len() { color } else { theme::CARD };
        let style = ShapeStyle::from(color).stroke_width(2);
        root.draw(&theme::key_line(symbol, style))?;
        chart.draw_series(LineSeries::new(line.logarithms(), style))?;
        chart.draw_series(line.logarithms().map(|at| Circle::new(at, 4, color.filled())))?;
        chart.draw_series(line.logarithms().map(|at| Circle::new(at, 2, inner.filled())))?;
        root.draw(&Circle::new(symbol, 4, color.filled()))?;
        root.draw(&Circle::new(symbol, 2, inner.filled()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (640, 400);

    fn line(name: &str, points: &[[f32; 2]]) -> Line {
        Line { name: name.into(), points: points.to_vec() }
    }

    #[test]
    fn powers_are_straight_lines_with_round_numbers() {
        let square = [[10.0, 1.0], [100.0, 100.0], [1000.0, 10_000.0]];
        let flat = [[10.0, 3.0], [100.0, 3.0], [1000.0, 3.0]];
        let series = [line("square", &square), line("flat & low", &flat)];
        let plot = lines(&series, "triangles", "milliseconds", SIZE).unwrap();
        for text in ["square", "flat &amp; low", "triangles", "milliseconds", "10", "100", "10k"] {
            assert!(plot.contains(text), "{text}");
        }
        assert_eq!(plot.matches("r=\"4\"").count(), 8);
        let course = plot.lines().find(|line| {
            line.starts_with("<polyline")
                && line.contains("#1F6FD6")
                && line.matches(',').count() == 3
        });
        let numbers: Vec<f32> = course
            .unwrap()
            .split('"')
            .find(|part| part.matches(',').count() == 3)
            .unwrap()
            .split([',', ' '])
            .filter_map(|number| number.parse().ok())
            .collect();
        let [a, b, c, d, e, f] = numbers[..] else { panic!("{numbers:?}") };
        assert!((a - 2.0 * c + e).abs() <= 2.0 && (b - 2.0 * d + f).abs() <= 2.0, "{numbers:?}");
    }

    #[test]
    fn poor_series_are_drawn_too() {
        let bad = [[0.0, 1.0], [f32::NAN, 1.0], [1.0, f32::INFINITY], [-1.0, -1.0]];
        for series in [&[][..], &[line("", &[])], &[line("a", &bad)], &[line("a", &[[5.0, 5.0]])]] {
            let plot = lines(series, "x", "y", SIZE).unwrap();
            assert!(plot.ends_with("</svg>\n") && !plot.contains("NaN"));
        }
    }
}
