//! How scores depend on settings: a small plot for each setting, side by side.

use super::summary::Summary;
use super::theme::{self, Area, Axes, BESIDE, Drawn, FIRST, MARGIN, SOFT, Scale};
use plotters::prelude::*;
use plotters::style::text_anchor::VPos;
use std::ops::Range;

/// A panel gets no narrower than this before it goes to a row of its own, pixels.
const NARROW: u32 = 180;
/// Room for a panel's title and its settings' labels, pixels.
const TITLE: u32 = 26;
const LABELS: u32 = 44;

/// What is varied, with its settings in order.
#[derive(Debug, Clone, Copy)]
pub struct Panel<'a> {
    /// Its title.
    pub name: &'a str,
    /// Its settings, from left to right.
    pub settings: &'a [Setting<'a>],
}

/// The scores under one setting.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// The setting's value in words.
    pub label: &'a str,
    /// The score of each run.
    pub values: &'a [f32],
    /// Whether it is the paper's value, which is emphasised.
    pub standard: bool,
}

/// For each setting the median as a dot, the interquartile range as a bar and the extremes as
/// whiskers, on one vertical axis for all panels.
///
/// # Errors
/// The plotting library's reason, in words.
pub fn sweep(panels: &[Panel], y_label: &str, size: (u32, u32)) -> Result<String, String> {
    theme::render(size, |root| draw(panels, y_label, root)).map(|(svg, ())| svg)
}

fn draw(panels: &[Panel], y_label: &str, root: &Area) -> Drawn {
    let settings = panels.iter().flat_map(|panel| panel.settings);
    let y = theme::span(settings.flat_map(|setting| setting.values).copied());
    let (w, h) = root.dim_in_pixel();
    let inner = w - BESIDE - 2 * MARGIN as u32;
    // As few rows as the width allows, filled evenly.
    let widest = (inner / NARROW).max(1) as usize;
    let rows = panels.len().div_ceil(widest).max(1);
    let columns = panels.len().div_ceil(rows).max(1);
    let (width, height) = (inner / columns as u32, h / rows as u32);
    for (index, panel) in panels.iter().enumerate() {
        let (row, column) = ((index / columns) as u32, (index % columns) as u32);
        let beside = if column == 0 { BESIDE } else { 0 };
        let left = MARGIN as u32 + BESIDE - beside + column * width;
        let area = root.clone().shrink((left, row * height), (width + beside, height));
        draw_panel(panel, &y, if column == 0 { y_label } else { "" }, beside, &area)?;
    }
    Ok(())
}

fn draw_panel(panel: &Panel, y: &Range<f32>, name: &str, beside: u32, area: &Area) -> Drawn {
    let count = panel.settings.len();
    let mut chart = ChartBuilder::on(area)
        .margin_right(MARGIN)
        .margin_top(TITLE)
        .x_label_area_size(LABELS)
        .y_label_area_size(beside)
        .build_cartesian_2d(
            Scale::bare(-0.6..count.max(1) as f32 - 0.4),
            Scale::plain(y.clone()),
        )?;
    theme::axes(&mut chart, &Axes { x: ("", 1), y: (name, 6), grid: true })?;
    let (x, bottom) = chart.plotting_area().get_pixel_range();
    let (left, top) = area.get_base_pixel();
    let middle = (x.start + x.end) / 2 - left;
    let title = theme::centred(&theme::bold(), VPos::Center);
    area.draw_text(panel.name, &title, (middle, TITLE as i32 / 2))?;

    // Labels that would touch stand in two rows.
    let widths: Vec<_> = panel.settings.iter().map(|s| theme::width(s.label)).collect();
    let slot = (x.end - x.start) / count.max(1) as i32;
    let tight = widths.windows(2).any(|pair| (pair[0] + pair[1]) / 2 + 8 > slot);
    for (index, setting) in panel.settings.iter().enumerate() {
        let at = index as f32;
        let color = if setting.standard { FIRST } else { SOFT };
        if let Some(Summary { least, lower, median, upper, most }) = Summary::new(setting.values) {
            let line = |from, to, width| {
                PathElement::new([(at, from), (at, to)], color.stroke_width(width))
            };
            chart.draw_series([line(least, most, 1)])?;
            chart.draw_series([line(lower, upper, 7)])?;
            let dot = |radius, color: RGBColor| Circle::new((at, median), radius, color.filled());
            chart.draw_series([dot(7, theme::CARD), dot(5, color)])?;
        }
        let style = if setting.standard { theme::bold() } else { theme::font(SOFT) };
        let (x, _) = chart.backend_coord(&(at, y.start));
        let lower = if tight && index % 2 == 1 { 18 } else { 0 };
        let place = (x - left, bottom.end - top + 8 + lower);
        area.draw_text(setting.label, &theme::centred(&style, VPos::Top), place)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setting<'a>(label: &'a str, values: &'a [f32]) -> Setting<'a> {
        Setting { label, values, standard: label == "30" }
    }

    #[test]
    fn each_setting_has_its_marks_and_the_standard_stands_out() {
        let (a, b) = ([0.21, 0.25, 0.22, 0.3], [0.24, 0.26, 0.28]);
        let sizes = [setting("15", &b), setting("30", &a), setting("60", &a)];
        let rates = [setting("10 %", &a), setting("30", &b)];
        let panels = [
            Panel { name: "population", settings: &sizes },
            Panel { name: "mutation & more", settings: &rates },
        ];
        let plot = sweep(&panels, "best F", (480, 300)).unwrap();
        for text in ["population", "mutation &amp; more", "10 %", "best F"] {
            assert!(plot.contains(text), "{text}");
        }
        assert_eq!(plot.matches("r=\"5\"").count(), 5);
        assert_eq!(plot.matches("stroke-width=\"7\"").count(), 5);
        assert_eq!(plot.matches("r=\"5\" opacity=\"1\" fill=\"#1F6FD6\"").count(), 2);
        // One shared axis: its name and numbers stand once where the panels are side by side.
        assert_eq!(plot.matches("best F").count(), 1);
        let narrow = sweep(&panels, "best F", (300, 500)).unwrap();
        assert_eq!(narrow.matches("best F").count(), 2);
    }

    #[test]
    fn poor_sweeps_are_drawn_too() {
        let nan = [f32::NAN; 3];
        let settings = [setting("", &[]), setting("a", &nan), setting("b", &[0.5])];
        let bare = Panel { name: "", settings: &[] };
        let panel = Panel { name: "x", settings: &settings };
        for panels in [&[][..], &[bare], &[panel], &[bare, panel, panel, panel, panel]] {
            let plot = sweep(panels, "F", (480, 400)).unwrap();
            assert!(plot.ends_with("</svg>\n") && !plot.contains("NaN"));
        }
    }
}
