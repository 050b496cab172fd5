//! Lines with a band around each.

use super::theme::{self, Axes, FIRST, INK, SECOND, Scale, THIRD};
use plotters::prelude::*;

/// Colours of series in turn.
const SERIES: [RGBColor; 4] = [FIRST, SECOND, THIRD, INK];

/// A line and the band around it. The slices are equally long; where a value is no finite number,
/// the point is left out.
#[derive(Debug, Clone, Copy)]
pub struct Band<'a> {
    /// What the legend calls it.
    pub name: &'a str,
    /// Where the points are, increasing.
    pub x: &'a [f32],
    /// The line.
    pub middle: &'a [f32],
    /// The band's lower end.
    pub low: &'a [f32],
    /// The band's upper end.
    pub high: &'a [f32],
}

impl Band<'_> {
    /// `x`, line, and the band's ends of each point.
    fn points(&self) -> impl DoubleEndedIterator<Item = [f32; 4]> + '_ {
        let count = self.x.len().min(self.middle.len()).min(self.low.len()).min(self.high.len());
        let point = |i| [self.x[i], self.middle[i], self.low[i], self.high[i]];
        (0..count).map(point).filter(|point| point.iter().all(|&value| theme::drawable(value)))
    }
}

/// Every series as a line with a translucent band, and a legend. The first is emphasised.
///
/// # Errors
/// The plotting library's reason, in words.
pub fn bands(
    series: &[Band],
    x_label: &str,
    y_label: &str,
    size: (u32, u32),
) -> Result<String, String> {
    let axes = Axes { x: (x_label, 6), y: (y_label, 6), grid: true };
    theme::render(size, |root| draw(series, &axes, root)).map(|(svg, ())| svg)
}

fn draw(series: &[Band], axes: &Axes, root: &theme::Area) -> theme::Drawn {
    let names: Vec<_> = series.iter().map(|band| band.name).collect();
    let (symbols, area) = theme::legend(root, &names)?;
    let points = || series.iter().flat_map(Band::points);
    let x = match theme::extent(points().map(|point| point[0])) {
        Some([first, last]) if last > first => first..last,
        Some([only, _]) => theme::span([only]),
        None => 0.0..1.0,
    };
    let y = theme::span(points().flat_map(|[_, values @ ..]| values));
    let mut chart = theme::chart(&area).build_cartesian_2d(Scale::plain(x), Scale::plain(y))?;
    theme::axes(&mut chart, axes)?;
    // The emphasised series comes last, on top.
    for (index, (band, symbol)) in series.iter().zip(symbols).enumerate().rev() {
        let color = SERIES[index % SERIES.len()];
        let low = band.points().map(|[x, _, low, _]| (x, low));
        let high = band.points().map(|[x, .., high]| (x, high));
        let area: Vec<_> = low.chain(high.rev()).collect();
        if !area.is_empty() {
            chart.draw_series([Polygon::new(area, color.mix(0.16))])?;
        }
        let (x, y) = symbol;
        root.draw(&Rectangle::new([(x - 11, y - 6), (x + 11, y + 6)], color.mix(0.16).filled()))?;
        let style = ShapeStyle::from(color).stroke_width(if index == 0 { 3 } else { 2 });
        root.draw(&theme::key_line(symbol, style))?;
        chart.draw_series(LineSeries::new(band.points().map(|[x, y, ..]| (x, y)), style))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (640, 400);

    #[test]
    fn each_series_has_a_line_a_band_and_a_name() {
        let x: Vec<f32> = (0..100).map(|i| 30.0 * i as f32).collect();
        let middle: Vec<f32> = x.iter().map(|x| 0.2 + 0.3 / (1.0 + x / 400.0)).collect();
        let low: Vec<f32> = middle.iter().map(|y| y - 0.02).collect();
        let high: Vec<f32> = middle.iter().map(|y| y + 0.03).collect();
        let band = |name| Band { name, x: &x, middle: &middle, low: &low, high: &high };
        let plot = bands(&[band("GA"), band("a < b")], "evaluations", "best F", SIZE).unwrap();
        for text in ["GA", "a &lt; b", "evaluations", "best F"] {
            assert!(plot.contains(text), "{text}");
        }
        assert_eq!(plot.matches("<polygon").count(), 2);
        let longest = plot.lines().filter(|line| line.starts_with("<polyline"));
        assert_eq!(longest.filter(|line| line.matches(',').count() == 100).count(), 2);
        let (first, second) = (plot.rfind("#1F6FD6").unwrap(), plot.rfind("#B86504").unwrap());
        assert!(first > second, "the first series is not on top");
    }

    #[test]
    fn poor_series_are_drawn_too() {
        let nan = [0.3, f32::NAN, f32::MAX];
        let band =
            |values| Band { name: "a", x: values, middle: values, low: values, high: values };
        let short = Band { low: &[], ..band(&nan) };
        for series in [&[][..], &[band(&[])], &[band(&[0.5])], &[band(&nan)], &[short]] {
            let plot = bands(series, "x", "y", SIZE).unwrap();
            assert!(plot.ends_with("</svg>\n") && !plot.contains("NaN"));
        }
    }
}
