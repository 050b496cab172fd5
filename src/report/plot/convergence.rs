//! The course of a search as a plot.

use super::theme::{self, Axes, FIRST, SECOND, Scale, THIRD};
use crate::design::Progress;
use plotters::prelude::*;

/// A line of the plot: name, colour, width in pixels, and its value in a generation.
type Line = (&'static str, RGBColor, u32, fn(&Progress) -> f32);

const LINES: [Line; 3] = [
    ("worst", THIRD, 1, |p| p.worst),
    ("mean", SECOND, 2, |p| p.mean),
    ("best", FIRST, 3, |p| p.best),
];

/// Best, mean and worst score of each generation, as an SVG of `size` (width, height).
///
/// # Errors
/// The plotting library's reason, in words.
pub fn convergence(history: &[Progress], size: (u32, u32)) -> Result<String, String> {
    theme::render(size, |root| draw(history, root)).map(|(svg, ())| svg)
}

fn draw(history: &[Progress], root: &theme::Area) -> theme::Drawn {
    let (symbols, area) = theme::legend(root, &LINES.map(|(name, ..)| name))?;
    let scores = history.iter().flat_map(|p| [p.best, p.mean, p.worst]);
    let generations = 1.0..history.len().max(2) as f32;
    let mut chart = theme::chart(&area)
        .build_cartesian_2d(Scale::plain(generations), Scale::plain(theme::span(scores)))?;
    theme::axes(&mut chart, &Axes { x: ("generation", 6), y: (theme::SCORE, 6), grid: true })?;
    for ((_, color, width, value), symbol) in LINES.into_iter().zip(symbols) {
        let style = ShapeStyle::from(color).stroke_width(width);
        let points = history.iter().map(|p| (p.generation as f32, value(p)));
        let points = points.filter(|&(_, score)| theme::drawable(score));
        chart.draw_series(LineSeries::new(points, style))?;
        root.draw(&theme::key_line(symbol, style))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(generation: usize, best: f32) -> Progress {
        Progress { generation, evaluations: generation, best, mean: best + 0.1, worst: best + 0.4 }
    }

    #[test]
    fn the_plot_names_its_axes_and_lines() {
        let history: Vec<_> = (1..=50).map(|g| entry(g, 0.5 / g as f32)).collect();
        let plot = convergence(&history, (640, 400)).unwrap();
        for text in ["generation", "F, lower is better", "best", "mean", "worst"] {
            assert!(plot.contains(text), "{text}");
        }
        assert!(plot.matches("<polyline").count() >= 3);
    }

    #[test]
    fn short_and_broken_courses_are_plotted_too() {
        for history in [vec![], vec![entry(1, 0.3)], vec![entry(1, f32::NAN), entry(2, 0.2)]] {
            assert!(convergence(&history, (640, 400)).unwrap().ends_with("</svg>\n"));
        }
    }
}
