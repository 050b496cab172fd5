//! The course of a search as a plot.

use super::theme::{self, Axes, FIRST, SECOND, Scale, THIRD};
use crate::design::Progress;
use plotters::prelude::*;
use std::ops::Range;

/// A line of the plot: name, colour, width in pixels, and its value in a generation.
type Line = (&'static str, RGBColor, u32, fn(&Progress) -> f32);

const LINES: [Line; 3] = [
    ("worst", THIRD, 1, |p| p.worst),
    ("mean", SECOND, 2, |p| p.mean),
    ("best", FIRST, 3, |p| p.best),
];

/// Best, mean and worst score of each generation, as an SVG of `size` (width, height). Where a search begins on small
/// pictures, whose scores are others, the lines are broken, and what either part looks at is written there.
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
    let span = theme::span(scores);
    let mut chart = theme::chart(&area)
        .build_cartesian_2d(Scale::plain(generations), Scale::plain(span.clone()))?;
    theme::axes(&mut chart, &Axes { x: ("generation", 6), y: (theme::SCORE, 6), grid: true })?;
    let parts = || history.chunk_by(|a, b| a.step == b.step);
    for ((_, color, width, value), symbol) in LINES.into_iter().zip(symbols) {
        let style = ShapeStyle::from(color).stroke_width(width);
        for part in parts() {
            let points = part.iter().map(|p| (p.generation as f32, value(p)));
            let points = points.filter(|&(_, score)| theme::drawable(score));
            chart.draw_series(LineSeries::new(points, style))?;
        }
        root.draw(&theme::key_line(symbol, style))?;
    }
    if history.iter().any(|p| p.step > 1) {
        for part in parts() {
            name_part(&mut chart, part, &span)?;
        }
    }
    Ok(())
}

/// A line where a part of the search begins, and above it what pictures it looks at.
fn name_part(chart: &mut theme::Chart, part: &[Progress], span: &Range<f32>) -> theme::Drawn {
    let Some(first) = part.first() else { return Ok(()) };
    let begin = first.generation as f32;
    if first.generation > 1 {
        let at = begin - 0.5;
        chart.draw_series(LineSeries::new([(at, span.start), (at, span.end)], theme::SOFT))?;
    }
    let name = match first.step {
        1 => "whole".to_owned(),
        step => format!("1/{step} size"),
    };
    let style = theme::font(theme::SOFT);
    chart.draw_series([Text::new(name, (begin, span.end), style)]).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(generation: usize, best: f32) -> Progress {
        let (mean, worst) = (best + 0.1, best + 0.4);
        Progress { generation, evaluations: generation, best, mean, worst, step: 1 }
    }

    #[test]
    fn the_plot_names_its_axes_and_lines() {
        let history: Vec<_> = (1..=50).map(|g| entry(g, 0.5 / g as f32)).collect();
        let plot = convergence(&history, (640, 400)).unwrap();
        for text in ["generation", "F, lower is better", "best", "mean", "worst"] {
            assert!(plot.contains(text), "{text}");
        }
        assert!(plot.matches("<polyline").count() >= 3 && !plot.contains("whole"));
    }

    #[test]
    fn where_pictures_become_larger_lines_are_broken_and_parts_named() {
        let lines = |small: [usize; 2]| {
            let step = |g: usize| {
                if g <= small[0] {
                    4
                } else if g <= small[1] {
                    2
                } else {
                    1
                }
            };
            let history = (1..=50).map(|g| Progress { step: step(g), ..entry(g, 0.3) });
            let plot = convergence(&history.collect::<Vec<_>>(), (640, 400)).unwrap();
            let named = ["1/4", "1/2", "whole"].map(|name| plot.contains(name));
            (plot.matches("<polyline").count(), named)
        };
        let (one, two, three) = (lines([0, 0]), lines([20, 20]), lines([20, 40]));
        assert_eq!((one.1, two.1, three.1), ([false; 3], [true, false, true], [true; 3]));
        // Three lines more, and that between the parts.
        assert_eq!((two.0, three.0), (one.0 + 4, one.0 + 8));
    }

    #[test]
    fn short_and_broken_courses_are_plotted_too() {
        for history in [vec![], vec![entry(1, 0.3)], vec![entry(1, f32::NAN), entry(2, 0.2)]] {
            assert!(convergence(&history, (640, 400)).unwrap().ends_with("</svg>\n"));
        }
    }
}
