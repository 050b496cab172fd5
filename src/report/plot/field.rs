//! A score over the directions of a light: what heat maps and surfaces show.

use super::theme;
use image::{Rgb, RgbImage};
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use std::ops::Range;

/// The colour of samples that are no numbers.
const MISSING: [u8; 3] = [0x9a, 0xa0, 0xaa];

/// A function of azimuth (x, degrees) and elevation (y, degrees), sampled on a regular grid: rows
/// from the lowest elevation, `columns` values a row.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// Azimuth of the first and the last column, degrees.
    pub azimuth: [f32; 2],
    /// Elevation of the first and the last row, degrees.
    pub elevation: [f32; 2],
    /// Samples in a row.
    pub columns: usize,
    /// The samples, row by row. Those that are no finite numbers are shown as missing.
    pub values: &'a [f32],
    /// What it shows, such as `F` or `F_edge`; lower is taken for better.
    pub name: &'a str,
}

impl Field<'_> {
    /// Whether it can be drawn.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn check(&self) -> Result<(), String> {
        let name = self.name;
        let (values, columns) = (self.values.len(), self.columns);
        if values == 0 || columns == 0 || !values.is_multiple_of(columns) {
            return Err(format!("{name}: {values} samples make no rows of {columns}"));
        }
        for [low, high] in [self.azimuth, self.elevation] {
            if !(low.abs() <= 1e4 && high.abs() <= 1e4 && low <= high) {
                return Err(format!("{name}: no grid from {low}° to {high}°"));
            }
        }
        Ok(())
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// The ranges of azimuth and elevation that the samples' cells cover, degrees.
    pub(super) fn cells(&self) -> [Range<f32>; 2] {
        let axis = |[low, high]: [f32; 2], count: usize| {
            let half = match (high - low) / (2 * count.max(2) - 2) as f32 {
                step if step > 1e-3 => step,
                _ => 0.5,
            };
            low - half..high + half
        };
        [axis(self.azimuth, self.columns), axis(self.elevation, self.rows())]
    }

    /// The range of the values; that of equal values has them in the middle.
    pub(super) fn range(&self) -> Range<f32> {
        match theme::extent(self.values.iter().copied()) {
            Some([low, high]) if high - low > 1e-6 * low.abs().max(high.abs()) => low..high,
            Some([low, _]) => theme::span([low]),
            None => 0.0..1.0,
        }
    }

    /// One pixel for each sample, the highest elevation on top.
    pub(super) fn picture(&self) -> RgbImage {
        let (range, rows) = (self.range(), self.rows());
        RgbImage::from_fn(self.columns as u32, rows as u32, |x, y| {
            let value = self.values[(rows - 1 - y as usize) * self.columns + x as usize];
            if !theme::drawable(value) {
                return Rgb(MISSING);
            }
            let RGBColor(r, g, b) = color(value, &range);
            Rgb([r, g, b])
        })
    }
}

/// Viridis, from yellow for the lowest (best) value to violet for the highest.
pub(super) fn color(value: f32, range: &Range<f32>) -> RGBColor {
    let place = (value - range.start) / (range.end - range.start);
    ViridisRGB.get_color(1.0 - place.clamp(0.0, 1.0))
}

/// The colours of a range as a picture one pixel wide, the highest value on top.
pub(super) fn scale() -> RgbImage {
    RgbImage::from_fn(1, 64, |_, y| {
        let RGBColor(r, g, b) = color(63.0 - y as f32, &(0.0..63.0));
        Rgb([r, g, b])
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A landscape with two valleys, 91 x 46 samples.
    pub fn landscape() -> Vec<f32> {
        let valley = |x: f32, y: f32, cx: f32, cy: f32, depth: f32, width: f32| {
            -depth * (-((x - cx).powi(2) + (y - cy).powi(2)) / (width * width)).exp()
        };
        let value = |i: usize| {
            let (x, y) = ((i % 91) as f32 * 2.0 - 90.0, (i / 91) as f32 * 2.0);
            let ripple = 0.012 * (x / 9.0).sin() * (y / 8.0).cos();
            0.52 + 0.1 * (x / 90.0).powi(2)
                + valley(x, y, -44.0, 32.0, 0.27, 26.0)
                + valley(x, y, 52.0, 58.0, 0.21, 20.0)
                + ripple
        };
        (0..91 * 46).map(value).collect()
    }

    pub fn field<'a>(values: &'a [f32], columns: usize) -> Field<'a> {
        Field { azimuth: [-90.0, 90.0], elevation: [0.0, 90.0], columns, values, name: "F" }
    }

    #[test]
    fn the_lowest_value_is_yellow_and_stands_where_it_belongs() {
        let values = [0.5, 0.1, 0.9, 0.4, 0.5, f32::NAN];
        let picture = field(&values, 3).picture();
        assert_eq!(picture.dimensions(), (3, 2));
        assert_eq!(picture.get_pixel(1, 1).0, [254, 232, 37]);
        assert_eq!(picture.get_pixel(2, 1).0, [68, 1, 84]);
        assert_eq!(picture.get_pixel(2, 0).0, MISSING);
        assert_eq!(picture.get_pixel(0, 1), picture.get_pixel(1, 0));
        let scale = scale();
        assert_eq!(scale.get_pixel(0, 0).0, [68, 1, 84]);
        assert_eq!(scale.get_pixel(0, 63).0, [254, 232, 37]);
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        let values = [0.5; 6];
        assert!(field(&values, 3).check().is_ok());
        assert!(field(&values, 4).check().is_err());
        assert!(field(&values, 0).check().is_err());
        assert!(field(&[], 3).check().is_err());
        for azimuth in [[90.0, -90.0], [f32::NAN, 90.0], [0.0, f32::INFINITY]] {
            assert!(Field { azimuth, ..field(&values, 3) }.check().is_err());
        }
    }
}
