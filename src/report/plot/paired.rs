//! Two samples of which the values belong together in pairs.

use super::summary::Summary;
use super::theme::{self, Axes, Chart, FIRST, SECOND, SOFT, Scale};
use plotters::prelude::*;
use plotters::style::text_anchor::VPos;

/// The scores of one side, one for each pair.
#[derive(Debug, Clone, Copy)]
pub struct Group<'a> {
    /// What the axis calls it.
    pub name: &'a str,
    /// The scores; lower is better.
    pub values: &'a [f32],
}

/// One of the two groups: its values, colour, where its dots stand, and how far from them its box.
struct Side<'a> {
    group: &'a Group<'a>,
    color: RGBColor,
    at: f32,
    aside: f32,
}

/// Half the width of a box.
const HALF: f32 = 0.11;

/// The scores of both groups as box plots (whiskers reach the extremes) and dots. A thin line joins
/// each pair, in the colour of the lower (better) one; below, how often each is the lower.
///
/// # Errors
/// When the groups differ in length, or the plotting library's reason, in words.
pub fn paired(a: &Group, b: &Group, size: (u32, u32)) -> Result<String, String> {
    if a.values.len() != b.values.len() {
        let (m, n) = (a.values.len(), b.values.len());
        return Err(format!("{} and {}: {m} and {n} values make no pairs", a.name, b.name));
    }
    let sides = [
        Side { group: a, color: FIRST, at: 0.0, aside: -0.24 },
        Side { group: b, color: SECOND, at: 1.0, aside: 0.24 },
    ];
    theme::render(size, |root| draw(&sides, root)).map(|(svg, ())| svg)
}

fn draw(sides: &[Side; 2], root: &theme::Area) -> theme::Drawn {
    let y = theme::span(sides.iter().flat_map(|side| side.group.values.iter().copied()));
    let mut chart =
        theme::chart(root).build_cartesian_2d(Scale::bare(-0.5..1.5), Scale::plain(y))?;
    theme::axes(&mut chart, &Axes { x: ("", 1), y: (theme::SCORE, 6), grid: true })?;

    let [a, b] = sides.each_ref().map(|side| side.group.values);
    let pairs = a.iter().copied().zip(b.iter().copied());
    let pairs = pairs.filter(|&(a, b)| theme::drawable(a) && theme::drawable(b));
    let pairs: Vec<(f32, f32)> = pairs.collect();
    for &(a, b) in &pairs {
        let color = match a.total_cmp(&b) {
            std::cmp::Ordering::Less => sides[0].color,
            std::cmp::Ordering::Equal => SOFT,
            std::cmp::Ordering::Greater => sides[1].color,
        };
        let ends = [(sides[0].at, a), (sides[1].at, b)];
        chart.draw_series([PathElement::new(ends, color.mix(0.6))])?;
    }
    let lower =
        [pairs.iter().filter(|(a, b)| a < b).count(), pairs.iter().filter(|(a, b)| b < a).count()];
    let (_, bottom) = chart.plotting_area().get_pixel_range();
    for (side, wins) in sides.iter().zip(lower) {
        if let Some(summary) = Summary::new(side.group.values) {
            draw_box(&mut chart, side, &summary)?;
        }
        let values = side.group.values.iter().filter(|&&value| theme::drawable(value));
        chart.draw_series(values.map(|&y| Circle::new((side.at, y), 4, side.color.filled())))?;
        let (x, _) = chart.backend_coord(&(side.at + 0.5 * side.aside, 0.0));
        let count = format!("lower in {wins} of {}", pairs.len());
        let name = theme::centred(&theme::bold(), VPos::Top);
        root.draw_text(side.group.name, &name, (x, bottom.end + 8))?;
        let plain = theme::centred(&theme::font(SOFT), VPos::Top);
        root.draw_text(&count, &plain, (x, bottom.end + 28))?;
    }
    Ok(())
}

fn draw_box(chart: &mut Chart, side: &Side, summary: &Summary) -> theme::Drawn {
    let (middle, color) = (side.at + side.aside, side.color);
    let (left, right) = (middle - HALF, middle + HALF);
    let Summary { least, lower, median, upper, most } = *summary;
    let body = [(left, lower), (right, upper)];
    chart.draw_series([Rectangle::new(body, color.mix(0.16).filled())])?;
    chart.draw_series([Rectangle::new(body, color)])?;
    let whiskers = [[(middle, least), (middle, lower)], [(middle, upper), (middle, most)]];
    chart.draw_series(whiskers.map(|line| PathElement::new(line, color)))?;
    let bold = color.stroke_width(3);
    chart.draw_series([PathElement::new([(left, median), (right, median)], bold)])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (480, 400);

    fn plot(a: &[f32], b: &[f32]) -> Result<String, String> {
        paired(&Group { name: "GA", values: a }, &Group { name: "greedy & co", values: b }, SIZE)
    }

    #[test]
    fn each_pair_has_its_line_in_the_colour_of_the_lower() {
        let plot = plot(&[0.21, 0.22, 0.26, 0.2], &[0.25, 0.24, 0.23, 0.2]).unwrap();
        for text in ["GA", "greedy &amp; co", "lower in 2 of 4", "lower in 1 of 4", theme::SCORE] {
            assert!(plot.contains(text), "{text}");
        }
        assert_eq!(plot.matches("<circle").count(), 8);
        let lines = |color: &str| {
            let pair = format!("opacity=\"0.6\" stroke=\"{color}\"");
            plot.matches(&pair).count()
        };
        assert_eq!((lines("#1F6FD6"), lines("#B86504"), lines("#5E636E")), (2, 1, 1));
        assert_eq!(plot.matches("stroke-width=\"3\"").count(), 2);
    }

    #[test]
    fn poor_groups_are_drawn_too() {
        let nan = f32::NAN;
        for (a, b) in [
            (&[][..], &[][..]),
            (&[0.3], &[0.2]),
            (&[0.3; 4], &[0.3; 4]),
            (&[nan, 0.2], &[0.1, nan]),
            (&[nan], &[nan]),
        ] {
            let plot = plot(a, b).unwrap();
            assert!(plot.ends_with("</svg>\n") && !plot.contains("NaN"));
        }
        assert!(plot(&[0.1], &[]).is_err());
    }
}
