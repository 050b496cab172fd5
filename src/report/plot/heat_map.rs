//! A field in colours, with marked places and paths on it.

use super::field::{self, Field};
use super::overlay::{MARK, Overlay};
use super::theme::{self, Area, Axes, BELOW, BESIDE, Drawn, MARGIN, Scale};
use plotters::prelude::*;
use std::f32::consts::TAU;
use std::ops::Range;

/// Colours of paths in turn. They differ from Viridis and show on light and dark pages; they are no
/// palette colours, since a page must not change them.
const PATHS: [RGBColor; 6] = [
    RGBColor(0xe0, 0x2f, 0x2f),
    RGBColor(0x2a, 0x6b, 0xe8),
    RGBColor(0xf0, 0x7f, 0x13),
    RGBColor(0xc0, 0x2f, 0xb4),
    RGBColor(0x0c, 0x91, 0x6b),
    RGBColor(0x7a, 0x52, 0x30),
];

/// Radius of the star on a map, pixels: its tips stand out behind a minimum's disc.
const STAR: f32 = 17.0;
/// Room for the colour bar, its numbers and its name, pixels; its own width is [`BAR`].
const SCALE: u32 = 104;
const BAR: u32 = 16;

/// What stands at a marked place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// A star.
    Best,
    /// A cross.
    Worst,
    /// A disc with its label, or with its number among the minima where it has none.
    Minimum,
}

/// A marked place on a map.
#[derive(Debug, Clone, Copy)]
pub struct Mark<'a> {
    /// Its form.
    pub symbol: Symbol,
    /// Azimuth and elevation, degrees.
    pub at: [f32; 2],
    /// A minimum's few characters; what the legend calls the best and the worst. May be empty.
    pub label: &'a str,
}

/// A line on a map, from a ring to a dot.
#[derive(Debug, Clone, Copy)]
pub struct Path<'a> {
    /// What the legend calls it.
    pub label: &'a str,
    /// Azimuth and elevation of each point, degrees.
    pub points: &'a [[f32; 2]],
}

/// A field in Viridis, the lowest value brightest, with a colour bar; paths and marks are on it, and
/// explained in a legend. The field is one embedded picture with a pixel for each sample.
///
/// # Errors
/// When the field is no grid, or the plotting library's reason, in words.
pub fn heat_map(
    field: &Field,
    marks: &[Mark],
    paths: &[Path],
    size: (u32, u32),
) -> Result<String, String> {
    field.check()?;
    let (svg, places) = theme::render(size, |root| draw(field, marks, paths, root))?;
    let mut overlay = Overlay::default();
    let Frame { x, y, bar } = &places.frame;
    let corner = |x: i32, y: i32| [x as f32, y as f32];
    overlay.picture(&field.picture(), corner(x.start, y.start), corner(x.end, y.end))?;
    overlay.picture(&field::scale(), corner(bar.start, y.start), corner(bar.end, y.end))?;

    let [azimuth, elevation] = field.cells();
    let place = |[a, e]: [f32; 2]| {
        let part =
            |value: f32, range: &Range<f32>| (value - range.start) / (range.end - range.start);
        let (u, v) = (part(a, &azimuth).clamp(0.0, 1.0), part(e, &elevation).clamp(0.0, 1.0));
        [x.start as f32 + u * (x.end - x.start) as f32, y.end as f32 - v * (y.end - y.start) as f32]
    };
    let visible = |at: &[f32; 2]| at.iter().all(|&angle| theme::drawable(angle));
    for (index, path) in paths.iter().enumerate() {
        let points = path.points.iter().filter(|at| visible(at)).map(|&at| place(at));
        draw_path(&mut overlay, &points.collect::<Vec<_>>(), PATHS[index % PATHS.len()]);
    }
    // The best is often a minimum too: its star stands out behind the disc.
    for symbol in [Symbol::Worst, Symbol::Best, Symbol::Minimum] {
        let marks = marks.iter().filter(|mark| mark.symbol == symbol);
        let marks = marks.enumerate().filter(|(_, mark)| visible(&mark.at));
        // Where discs overlap, the first is on top.
        for (index, mark) in marks.collect::<Vec<_>>().into_iter().rev() {
            let number = (index + 1).to_string();
            let label = if mark.label.is_empty() { &number } else { mark.label };
            draw_mark(&mut overlay, symbol, place(mark.at), label, STAR);
        }
    }
    for (key, (x, y)) in places.keys {
        let at = corner(x, y);
        match key {
            Key::Mark(symbol) => draw_mark(&mut overlay, symbol, at, "n", 0.6 * STAR),
            Key::Path(index) => {
                let ends = [[at[0] - 11.0, at[1]], [at[0] + 11.0, at[1]]];
                draw_path(&mut overlay, &ends, PATHS[index % PATHS.len()]);
            }
        }
    }
    Ok(overlay.on(svg))
}

/// Where the picture and the colour bar go, pixels.
struct Frame {
    x: Range<i32>,
    y: Range<i32>,
    bar: Range<i32>,
}

/// What a line of the legend explains.
#[derive(Clone, Copy)]
enum Key {
    Mark(Symbol),
    Path(usize),
}

/// Where what plotters does not draw has to go.
struct Places {
    frame: Frame,
    keys: Vec<(Key, (i32, i32))>,
}

/// Legend, axes and the numbers of the colour bar.
fn draw(field: &Field, marks: &[Mark], paths: &[Path], root: &Area) -> Drawn<Places> {
    let (keys, labels): (Vec<_>, Vec<_>) = entries(marks, paths).into_iter().unzip();
    let labels: Vec<_> = labels.iter().map(String::as_str).collect();
    let (symbols, area) = theme::legend(root, &labels)?;
    let (map, scale) = area.split_horizontally(area.dim_in_pixel().0 - SCALE);

    let [azimuth, elevation] = field.cells();
    let mut chart = ChartBuilder::on(&map)
        .margin(MARGIN)
        .margin_right(0)
        .x_label_area_size(BELOW)
        .y_label_area_size(BESIDE)
        .build_cartesian_2d(Scale::degrees(azimuth), Scale::degrees(elevation))?;
    let style = Axes { x: ("azimuth (°)", 7), y: ("elevation (°)", 6), grid: false };
    theme::axes(&mut chart, &style)?;
    let (x, y) = chart.plotting_area().get_pixel_range();

    let mut bar = ChartBuilder::on(&scale)
        .margin(MARGIN)
        .x_label_area_size(BELOW)
        .right_y_label_area_size(SCALE - BAR - 2 * MARGIN as u32)
        .build_cartesian_2d(Scale::bare(0.0..1.0), Scale::plain(field.range()))?;
    let name = format!("{}, low is good", field.name);
    theme::axes(&mut bar, &Axes { x: ("", 1), y: (&name, 5), grid: false })?;
    let frame = Frame { x, y, bar: bar.plotting_area().get_pixel_range().0 };
    Ok(Places { frame, keys: keys.into_iter().zip(symbols).collect() })
}

/// The legend's lines: each kind of mark once, then the paths.
fn entries(marks: &[Mark], paths: &[Path]) -> Vec<(Key, String)> {
    let mut entries = Vec::new();
    for (symbol, name) in [(Symbol::Best, "best"), (Symbol::Worst, "worst")] {
        if let Some(mark) = marks.iter().find(|mark| mark.symbol == symbol) {
            let label = if mark.label.is_empty() { name } else { mark.label };
            entries.push((Key::Mark(symbol), label.into()));
        }
    }
    match marks.iter().filter(|mark| mark.symbol == Symbol::Minimum).count() {
        0 => {}
        1 => entries.push((Key::Mark(Symbol::Minimum), "local minimum".into())),
        count => entries.push((Key::Mark(Symbol::Minimum), format!("{count} local minima"))),
    }
    let paths = paths.iter().enumerate();
    entries.extend(paths.map(|(index, path)| (Key::Path(index), path.label.into())));
    entries
}

fn draw_mark(overlay: &mut Overlay, symbol: Symbol, at: [f32; 2], label: &str, star: f32) {
    match symbol {
        Symbol::Best => {
            let point = |i: usize| {
                let radius = if i.is_multiple_of(2) { star } else { 0.44 * star };
                let (sin, cos) = (TAU * i as f32 / 10.0).sin_cos();
                [radius * sin, -radius * cos]
            };
            overlay.shape(at, &std::array::from_fn::<_, 10, _>(point), MARK);
        }
        Symbol::Worst => {
            // A plus of arms 2·a wide and 2·r long, turned by an eighth.
            let (a, r) = (2.0, 9.0);
            let plus = [
                [-a, -r],
                [a, -r],
                [a, -a],
                [r, -a],
                [r, a],
                [a, a],
                [a, r],
                [-a, r],
                [-a, a],
                [-r, a],
                [-r, -a],
                [-a, -a],
            ];
            let turn = |[x, y]: [f32; 2]| [(x - y) * 0.707, (x + y) * 0.707];
            overlay.shape(at, &plus.map(turn), MARK);
        }
        Symbol::Minimum => {
            overlay.disc(at, 8.5, MARK);
            let size = if label.chars().count() > 1 { 10.0 } else { 12.0 };
            overlay.label(at, label, size);
        }
    }
}

fn draw_path(overlay: &mut Overlay, points: &[[f32; 2]], color: RGBColor) {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return };
    overlay.line(points, color);
    overlay.ring(first, 6.5, color);
    overlay.disc(last, 4.0, color);
}

#[cfg(test)]
mod tests {
    use super::super::field::tests::{field, landscape};
    use super::*;

    const SIZE: (u32, u32) = (640, 400);

    #[test]
    fn a_map_shows_its_field_marks_and_paths() {
        let values = landscape();
        let field = field(&values, 91);
        let bare = heat_map(&field, &[], &[], SIZE).unwrap();
        assert_eq!(bare.matches("<image ").count(), 2);
        assert!(bare.len() < 24_000, "{} bytes", bare.len());
        for text in ["azimuth (°)", "elevation (°)", "F, low is good", "−90", "45"] {
            assert!(bare.contains(text), "{text}");
        }
        assert!(!bare.contains("<circle") && !bare.contains("<polygon"));

        let minimum = |x| Mark { symbol: Symbol::Minimum, at: [x, 30.0], label: "" };
        let marks = [
            Mark { symbol: Symbol::Best, at: [-44.0, 32.0], label: "best <0.21>" },
            Mark { symbol: Symbol::Worst, at: [90.0, 0.0], label: "" },
            minimum(-44.0),
            minimum(52.0),
            Mark { label: "<b>", ..minimum(0.0) },
        ];
        let paths = [
            Path { label: "from the left", points: &[[-80.0, 5.0], [-60.0, 20.0], [-44.0, 32.0]] },
            Path { label: "from above", points: &[[0.0, 80.0]] },
        ];
        let map = heat_map(&field, &marks, &paths, SIZE).unwrap();
        let count = |text: &str| map.matches(text).count() - bare.matches(text).count();
        // Each mark and path once, and once more in the legend, where minima share a line.
        assert_eq!(count("<polygon"), 4);
        assert_eq!(count("r=\"8.5\""), 4);
        assert_eq!(count("<polyline"), 8);
        for text in [
            ">1</text>",
            ">2</text>",
            "&lt;b&gt;",
            "best &lt;0.21&gt;",
            "worst",
            "3 local minima",
            "from the left",
            "from above",
        ] {
            assert_eq!(count(text), 1, "{text}");
        }
    }

    #[test]
    fn marks_stand_at_their_samples() {
        let values = [0.2; 6];
        let field = field(&values, 3);
        let at = |at| {
            let mark = Mark { symbol: Symbol::Minimum, at, label: "" };
            let map = heat_map(&field, &[mark], &[], SIZE).unwrap();
            let number = |name: &str, text: &str| {
                let start = text.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
                text[start..].split('"').next().unwrap().parse::<f32>().unwrap()
            };
            let image = &map[map.find("<image").unwrap()..];
            let disc = &map[map.find("<circle").unwrap()..];
            [
                (number("cx", disc) - number("x", image)) / number("width", image),
                (number("cy", disc) - number("y", image)) / number("height", image),
            ]
        };
        // The middles of a corner's cell and of the middle column's upper cell.
        for (angles, expected) in [([-90.0, 0.0], [1.0 / 6.0, 0.75]), ([0.0, 90.0], [0.5, 0.25])] {
            let found = at(angles);
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-3), "{found:?}");
        }
    }

    #[test]
    fn poor_fields_are_drawn_too() {
        let nan = [f32::NAN; 6];
        for (values, columns) in [
            (&[0.3; 6][..], 3),
            (&[0.3; 6], 1),
            (&[0.1, 0.2, 0.3], 3),
            (&[0.5], 1),
            (&nan, 2),
            (&[f32::MAX, f32::MIN, f32::INFINITY, 0.5], 2),
        ] {
            let broken = Mark { symbol: Symbol::Best, at: [f32::NAN, 0.0], label: "" };
            let empty = Path { label: "", points: &[] };
            let map = heat_map(&field(values, columns), &[broken], &[empty], SIZE).unwrap();
            assert!(map.ends_with("</svg>\n") && !map.contains("NaN"), "{values:?}");
        }
        let point = Field { azimuth: [5.0; 2], elevation: [7.0; 2], ..field(&[0.5], 1) };
        assert!(heat_map(&point, &[], &[], SIZE).is_ok());
        assert!(heat_map(&field(&[0.5; 5], 2), &[], &[], SIZE).is_err());
        assert!(heat_map(&field(&[0.5; 4], 2), &[], &[], (20, 20)).is_err());
    }
}
