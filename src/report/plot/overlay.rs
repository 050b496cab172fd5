//! SVG elements on top of what plotters draws, which its backend does not offer: pictures, outlines
//! and coordinates of less than a pixel.

use crate::report::picture;
use image::RgbImage;
use plotters::style::RGBColor;
use std::fmt::Write;

/// Outlines of marks, so that they stand out from every colour.
const HALO: &str = "#FFF";
/// Marks on maps. These colours are no palette colours, since a page must not change them.
pub const MARK: RGBColor = RGBColor(0x14, 0x16, 0x1a);

/// SVG text to be placed on a plot. Coordinates are its pixels.
#[derive(Default)]
pub struct Overlay(String);

impl Overlay {
    /// The plot with the elements on it.
    pub fn on(self, mut svg: String) -> String {
        let end = svg.rfind("</svg>").unwrap_or(svg.len());
        svg.insert_str(end, &self.0);
        svg
    }

    /// A picture that fills the rectangle between two corners.
    pub fn picture(
        &mut self,
        picture: &RgbImage,
        [left, top]: [f32; 2],
        [right, bottom]: [f32; 2],
    ) -> Result<(), String> {
        let data = picture::data_uri(picture).map_err(|error| error.to_string())?;
        self.push(format_args!(
            "<image x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" \
             preserveAspectRatio=\"none\" href=\"{data}\"/>\n",
            right - left,
            bottom - top
        ));
        Ok(())
    }

    /// A line with a halo.
    pub fn line(&mut self, points: &[[f32; 2]], color: RGBColor) {
        let mut list = String::new();
        for [x, y] in points {
            write!(list, "{x:.1},{y:.1} ").expect("writing to a string");
        }
        let list = list.trim_end();
        for (color, width) in [(HALO.to_string(), 5.0), (hex(color), 2.5)] {
            self.push(format_args!(
                "<polyline points=\"{list}\" fill=\"none\" stroke=\"{color}\" \
                 stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"/>\n"
            ));
        }
    }

    /// A filled disc with a halo.
    pub fn disc(&mut self, [x, y]: [f32; 2], radius: f32, color: RGBColor) {
        self.push(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\" stroke=\"{HALO}\" \
             stroke-width=\"3\" paint-order=\"stroke\"/>\n",
            hex(color)
        ));
    }

    /// A ring, white inside, with a halo.
    pub fn ring(&mut self, at: [f32; 2], radius: f32, color: RGBColor) {
        let [x, y] = at;
        self.disc(at, radius, color);
        self.push(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"{HALO}\"/>\n",
            0.55 * radius
        ));
    }

    /// A filled outline with a halo; its points are relative to a place.
    pub fn shape(&mut self, [x, y]: [f32; 2], outline: &[[f32; 2]], color: RGBColor) {
        let mut list = String::new();
        for [dx, dy] in outline {
            write!(list, "{:.1},{:.1} ", x + dx, y + dy).expect("writing to a string");
        }
        self.push(format_args!(
            "<polygon points=\"{}\" fill=\"{}\" stroke=\"{HALO}\" stroke-width=\"3\" \
             stroke-linejoin=\"round\" paint-order=\"stroke\"/>\n",
            list.trim_end(),
            hex(color)
        ));
    }

    /// White text in the middle of a mark.
    pub fn label(&mut self, [x, y]: [f32; 2], text: &str, size: f32) {
        self.push(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" dy=\"0.35em\" text-anchor=\"middle\" \
             font-family=\"system-ui, sans-serif\" font-weight=\"bold\" font-size=\"{size}\" \
             fill=\"{HALO}\">{}</text>\n",
            minijinja::HtmlEscape(text)
        ));
    }

    /// SVG text as it is.
    pub fn push(&mut self, element: std::fmt::Arguments) {
        self.0.write_fmt(element).expect("writing to a string");
    }
}

/// A colour as SVG has it.
pub fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
