//! The course of a search as a plot.

use crate::optimize::Progress;
use plotters::prelude::*;

/// Colours of the best, the mean and the worst score, and of text and rules.
const BEST: RGBColor = RGBColor(0x1f, 0x6f, 0xd6);
const MEAN: RGBColor = RGBColor(0xd9, 0x7a, 0x06);
const WORST: RGBColor = RGBColor(0xa3, 0x3b, 0x8f);
const INK: RGBColor = RGBColor(0x2b, 0x2d, 0x33);
const RULE: RGBColor = RGBColor(0xdd, 0xdf, 0xe4);

/// Best, mean and worst score of each generation, as an SVG of `size` (width, height).
///
/// # Errors
/// The plotting library's reason, in words.
pub fn convergence(history: &[Progress], size: (u32, u32)) -> Result<String, String> {
    let mut text = String::new();
    draw(history, SVGBackend::with_string(&mut text, size)).map_err(|e| e.to_string())?;
    Ok(text)
}

fn draw<B: DrawingBackend>(
    history: &[Progress],
    backend: B,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let root = backend.into_drawing_area();
    root.fill(&WHITE)?;
    let font = ("system-ui, sans-serif", 15).into_font().color(&INK);
    let last = history.len().max(2) as f32;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .margin_right(20)
        .x_label_area_size(42)
        .y_label_area_size(58)
        .build_cartesian_2d(1f32..last, span(history))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RULE)
        .axis_style(INK)
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.2}"))
        .label_style(font.clone())
        .x_desc("generation")
        .y_desc("F, lower is better")
        .draw()?;
    let lines: [Line; 3] = [
        ("worst", WORST, 1, |p| p.worst),
        ("mean", MEAN, 2, |p| p.mean),
        ("best", BEST, 3, |p| p.best),
    ];
    for (name, color, width, value) in lines {
        let style = ShapeStyle::from(color).stroke_width(width);
        let points = history.iter().map(|p| (p.generation as f32, value(p)));
        chart
            .draw_series(LineSeries::new(points, style))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .legend_area_size(28)
        .margin(8)
        .background_style(WHITE)
        .border_style(RULE)
        .label_font(font)
        .draw()?;
    root.present()
}

/// A line of the plot: name, colour, width in pixels, and its value in a generation.
type Line = (&'static str, RGBColor, u32, fn(&Progress) -> f32);

/// The plotted scores with a little room around them.
fn span(history: &[Progress]) -> std::ops::Range<f32> {
    let scores = history.iter().flat_map(|p| [p.best, p.mean, p.worst]).filter(|f| f.is_finite());
    let (low, high) =
        scores.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), f| (l.min(f), h.max(f)));
    if low > high {
        return 0.0..1.0;
    }
    let room = (0.05 * (high - low)).max(0.005);
    low - room..high + room
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
