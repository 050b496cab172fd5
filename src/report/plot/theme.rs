//! What all plots share: colours, type, axes, legends and the form of numbers.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf32;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// What the plots stand on.
pub const CARD: RGBColor = WHITE;
/// Text and marks that are emphasised.
pub const INK: RGBColor = RGBColor(0x1d, 0x1f, 0x24);
/// Other text and the axes.
pub const SOFT: RGBColor = RGBColor(0x5e, 0x63, 0x6e);
/// The grid.
pub const RULE: RGBColor = RGBColor(0xdd, 0xdf, 0xe4);
/// The best, or the first of several series.
pub const FIRST: RGBColor = RGBColor(0x1f, 0x6f, 0xd6);
/// The mean, or the second series.
pub const SECOND: RGBColor = RGBColor(0xb8, 0x65, 0x04);
/// The worst, or the third series.
pub const THIRD: RGBColor = RGBColor(0xa3, 0x3b, 0x8f);

/// Gives the plots inside an element of class `plot` a page's colours, by its custom properties
/// `--card`, `--ink`, `--soft`, `--rule`, `--after`, `--mean` and `--worst`. Colours of data (maps,
/// paths and marks on them) stay.
pub const THEME_CSS: &str = include_str!("theme.css");

/// What scores are called on an axis.
pub const SCORE: &str = "F, lower is better";

/// The height of text, pixels.
pub const TEXT: f32 = 15.0;
/// Room for an axis' numbers and name, pixels: below, and beside.
pub const BELOW: u32 = 48;
/// See [`BELOW`].
pub const BESIDE: u32 = 70;
/// Room around a plot, pixels.
pub const MARGIN: i32 = 12;

/// A part of a plot to draw on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing gives.
pub type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// An SVG of a size, and what `draw` gives.
///
/// # Errors
/// When the size leaves no room, or the plotting library's reason, in words.
pub fn render<T>(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Drawn<T>,
) -> Result<(String, T), String> {
    if size.0 < 240 || size.1 < 180 || size.0.max(size.1) > 1 << 15 {
        return Err(format!("no plot fits {} x {} pixels", size.0, size.1));
    }
    let mut text = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&CARD)
            .and_then(|()| draw(&root))
            .and_then(|drawn| root.present().map(|()| drawn))
            .map_err(|error| error.to_string())?
    };
    Ok((text, drawn))
}

/// The plots' type, in a colour.
pub fn font(color: RGBColor) -> TextStyle<'static> {
    // The SVG backend divides sizes by this factor.
    ("system-ui, sans-serif", f64::from(TEXT) * 1.24).into_font().color(&color)
}

/// The plots' type in bold ink.
pub fn bold() -> TextStyle<'static> {
    let size = f64::from(TEXT) * 1.24;
    ("system-ui, sans-serif", size, FontStyle::Bold).into_font().color(&INK)
}

/// Text that is centred over or under a point.
pub fn centred(style: &TextStyle<'static>, v: VPos) -> TextStyle<'static> {
    style.pos(Pos::new(HPos::Center, v))
}

/// About how wide a text is, pixels.
pub fn width(text: &str) -> i32 {
    (0.56 * TEXT * text.chars().count() as f32).ceil() as i32
}

/// Whether a value can be drawn. Values near the end of `f32`'s range would make spans overflow.
pub fn drawable(value: f32) -> bool {
    value.abs() < 1e30
}

/// The smallest and the largest of the drawable values.
pub fn extent(values: impl IntoIterator<Item = f32>) -> Option<[f32; 2]> {
    let values = values.into_iter().filter(|&value| drawable(value));
    values.fold(None, |extent, value| match extent {
        None => Some([value; 2]),
        Some([low, high]) => Some([low.min(value), high.max(value)]),
    })
}

/// The range of an axis that shows all values with a little room around them.
pub fn span(values: impl IntoIterator<Item = f32>) -> Range<f32> {
    let Some([low, high]) = extent(values) else { return 0.0..1.0 };
    let room = (0.05 * (high - low)).max(0.005).max(1e-4 * low.abs().max(high.abs()));
    low - room..high + room
}

/// A number of an axis: as many digits as its ticks need.
pub fn number(value: f32, range: &Range<f32>) -> String {
    let step = match ticks(range, 6)[..] {
        [first, second, ..] => second - first,
        _ => range.end - range.start,
    };
    let digits = (-step.max(1e-6).log10() - 1e-3).ceil().clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|byte| matches!(byte, b'0' | b'.')) => zero.into(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// Round values inside a range, at most about `count`.
pub fn ticks(range: &Range<f32>, count: usize) -> Vec<f32> {
    RangedCoordf32::from(range.clone()).key_points(count)
}

/// Ticks of a logarithmic axis, whose range is in decades: 1, 2 and 5 times powers of ten, powers of ten
/// alone where these are many, and round values where they are few.
pub fn decade_ticks(range: &Range<f32>, count: usize) -> Vec<f32> {
    let steps = |steps: &[f32]| -> Vec<f32> {
        let decades = range.start.floor() as i32..=range.end.ceil() as i32;
        let ticks = decades.flat_map(|d| steps.iter().map(move |step| d as f32 + step.log10()));
        ticks.filter(|tick| range.contains(tick)).collect()
    };
    let (fine, coarse) = (steps(&[1.0, 2.0, 5.0]), steps(&[1.0]));
    if fine.len() < 3 && range.end < 30.0 {
        let linear = 10f32.powf(range.start)..10f32.powf(range.end);
        return ticks(&linear, count).into_iter().map(f32::log10).collect();
    }
    if fine.len() <= count + 2 { fine } else { coarse }
}

/// A number whose decimal logarithm is given: three digits and its thousands.
pub fn power(logarithm: f32) -> String {
    let value = 10f32.powf(logarithm);
    let (value, unit) = match value {
        v if v >= 0.9995e9 => (v * 1e-9, "G"),
        v if v >= 0.9995e6 => (v * 1e-6, "M"),
        v if v >= 9995.0 => (v * 1e-3, "k"),
        v => (v, ""),
    };
    let digits = (2.0 - value.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{unit}")
}

/// Values at which people expect the ticks of an angle, at most about `count`.
pub fn degree_ticks(range: &Range<f32>, count: usize) -> Vec<f32> {
    let steps = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0];
    let length = range.end - range.start;
    let Some(step) = steps.into_iter().find(|step| length / step <= count as f32) else {
        return ticks(range, count);
    };
    if length < 1.0 {
        return ticks(range, count);
    }
    // Half-cells beyond the ends would lose the outermost ticks to rounding.
    let (first, last) = ((range.start / step - 1e-3).ceil(), (range.end / step + 1e-3).floor());
    (0..=(last - first) as usize).map(|i| (first + i as f32) * step).collect()
}

/// An axis: its range and where its ticks are.
pub struct Scale {
    range: Range<f32>,
    ticks: fn(&Range<f32>, usize) -> Vec<f32>,
}

impl Scale {
    /// With ticks at round values.
    pub fn plain(range: Range<f32>) -> Self {
        Self { range, ticks }
    }

    /// With ticks where people expect those of an angle.
    pub fn degrees(range: Range<f32>) -> Self {
        Self { range, ticks: degree_ticks }
    }

    /// Logarithmic, the range in decades.
    pub fn logarithmic(range: Range<f32>) -> Self {
        Self { range, ticks: decade_ticks }
    }

    /// Without ticks.
    pub fn bare(range: Range<f32>) -> Self {
        Self { range, ticks: |_, _| Vec::new() }
    }
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f32;

    fn map(&self, value: &f32, limit: (i32, i32)) -> i32 {
        RangedCoordf32::from(self.range.clone()).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f32> {
        (self.ticks)(&self.range, hint.bold_points())
    }

    fn range(&self) -> Range<f32> {
        self.range.clone()
    }
}

/// A chart with such axes.
pub type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Scale, Scale>>;

/// The frame of a chart that fills an area.
pub fn chart<'a, 'b>(area: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut builder = ChartBuilder::on(area);
    builder
        .margin(MARGIN)
        .margin_right(MARGIN + 8)
        .x_label_area_size(BELOW)
        .y_label_area_size(BESIDE);
    builder
}

/// The legend's symbol for a line.
pub fn key_line((x, y): (i32, i32), style: ShapeStyle) -> PathElement<(i32, i32)> {
    PathElement::new([(x - 11, y), (x + 11, y)], style)
}

/// A chart's two axes: their names, and how many numbers about each has.
pub struct Axes<'a> {
    /// Name and numbers of the horizontal axis.
    pub x: (&'a str, usize),
    /// Name and numbers of the vertical axis.
    pub y: (&'a str, usize),
    /// Whether grid lines are drawn.
    pub grid: bool,
}

/// How the numbers of an axis are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// As they are.
    Plain,
    /// As that whose decimal logarithm they are.
    Power,
}

impl Form {
    fn text(self, value: f32, range: &Range<f32>) -> String {
        match self {
            Self::Plain => number(value, range),
            Self::Power => power(value),
        }
    }
}

/// Draws the grid, the axes, their numbers and names.
pub fn axes(chart: &mut Chart, style: &Axes) -> Drawn {
    axes_of_form(chart, style, [Form::Plain; 2])
}

/// The same, with the numbers of both axes in the given forms.
pub fn axes_of_form(chart: &mut Chart, style: &Axes, [form_x, form_y]: [Form; 2]) -> Drawn {
    let (x, y) = (chart.x_range(), chart.y_range());
    let rule = if style.grid { RULE.to_rgba() } else { TRANSPARENT };
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(rule)
        .axis_style(SOFT)
        .x_labels(style.x.1)
        .y_labels(style.y.1);
    let (text_x, text_y) =
        (|value: &f32| form_x.text(*value, &x), |value: &f32| form_y.text(*value, &y));
    mesh.x_label_formatter(&text_x)
        .y_label_formatter(&text_y)
        .label_style(font(SOFT))
        .x_desc(style.x.0)
        .y_desc(style.y.0)
        .draw()
}

/// Writes labels in rows at the top, each with room for a symbol on its left. Gives the middles of
/// these, absolute, and what is left of the area.
pub fn legend<'a>(area: &Area<'a>, labels: &[&str]) -> Drawn<(Vec<(i32, i32)>, Area<'a>)> {
    const SYMBOL: i32 = 34;
    const ROW: i32 = 22;
    let (w, h) = area.dim_in_pixel();
    let (left, right) = (MARGIN, w as i32 - MARGIN);
    let (mut x, mut y) = (left, MARGIN + ROW / 2);
    let mut symbols = Vec::new();
    for label in labels {
        let length = SYMBOL + width(label);
        if x > left && x + length > right {
            (x, y) = (left, y + ROW);
        }
        let style = font(SOFT).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw_text(label, &style, (x + SYMBOL, y))?;
        let (dx, dy) = area.get_base_pixel();
        symbols.push((x + SYMBOL / 2 - 2 + dx, y + dy));
        x += length + 16;
    }
    let used = if labels.is_empty() { 0 } else { y + ROW / 2 };
    // A legend that fills the area leaves a plot of no use, but no fault.
    let used = used.min(h as i32 - 100);
    Ok((symbols, area.split_vertically(used).1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::overlay::hex;

    #[test]
    fn a_page_themes_the_whole_palette_and_nothing_else() {
        let palette = [CARD, INK, SOFT, RULE, FIRST, SECOND, THIRD].map(|c| hex(c).to_uppercase());
        for color in &palette {
            assert!(THEME_CSS.contains(&format!("fill=\"{color}\"")), "{color}");
            assert!(*color == "#FFFFFF" || THEME_CSS.contains(&format!("stroke=\"{color}\"")));
        }
        let selectors = THEME_CSS.matches("=\"#").count();
        assert_eq!(selectors, 2 * palette.len() - 1);
        assert_eq!(THEME_CSS.matches(".plot [").count(), selectors);
    }

    #[test]
    fn numbers_have_the_digits_that_their_ticks_need() {
        assert_eq!(number(0.25, &(0.2..0.45)), "0.25");
        assert_eq!(number(-30.0, &(-90.0..90.0)), "−30");
        assert_eq!(number(-0.0004, &(-1.0..1.0)), "0.0");
        assert_eq!(number(0.2101, &(0.21..0.2103)), "0.21010");
        assert_eq!(number(1500.0, &(0.0..3000.0)), "1500");
    }

    #[test]
    fn logarithmic_axes_have_round_numbers() {
        let texts =
            |range, count| decade_ticks(&range, count).into_iter().map(power).collect::<Vec<_>>();
        assert_eq!(texts(-0.1..2.1, 6), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(texts(-2.1..4.1, 6), ["0.01", "0.1", "1", "10", "100", "1000", "10k"]);
        assert_eq!(texts(3.9..7.4, 4), ["10k", "100k", "1M", "10M"]);
        assert_eq!(texts(1.17..1.27, 6).first().unwrap(), "15");
        assert!(texts(0.29..0.31, 6).len() > 1);
        assert_eq!(power(1e6f32.log10()), "1M");
        assert_eq!(power(0.0234f32.log10()), "0.0234");
    }

    #[test]
    fn angles_have_the_ticks_that_people_expect() {
        let degrees = |range, count| degree_ticks(&range, count);
        assert_eq!(degrees(-91.0..91.0, 7), [-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0]);
        assert_eq!(degrees(0.0..90.0, 4), [0.0, 30.0, 60.0, 90.0]);
        assert_eq!(degrees(99.0..261.0, 5), [135.0, 180.0, 225.0]);
        assert!(degrees(0.0..0.5, 5).len() > 1);
        assert!(!degrees(-1e4..1e4, 5).is_empty());
    }

    #[test]
    fn a_legend_goes_on_in_the_next_row() {
        let rows = |labels: &[&str]| {
            let drawn = render((300, 300), |root| {
                let (places, rest) = legend(root, labels)?;
                Ok((places, rest.dim_in_pixel().1))
            });
            drawn.unwrap().1
        };
        let (places, rest) = rows(&["one", "two"]);
        assert!(places[0].1 == places[1].1 && places[0].0 < places[1].0);
        let (places, less) = rows(&["a rather long label", "another long one"]);
        assert!(places[0].1 < places[1].1 && less < rest);
        assert_eq!(rows(&[]), (vec![], 300));
        assert!(rows(&["a rather long label"; 50]).1 >= 100);
    }
}
