//! Five numbers of a sample.

use super::theme;
use plotters::data::Quartiles;

/// Extremes, quartiles and the median of a sample's finite values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    pub least: f32,
    pub lower: f32,
    pub median: f32,
    pub upper: f32,
    pub most: f32,
}

impl Summary {
    /// `None` without finite values. Quartiles are interpolated between the two nearest values.
    pub fn new(values: &[f32]) -> Option<Self> {
        let values: Vec<f32> =
            values.iter().copied().filter(|&value| theme::drawable(value)).collect();
        let [least, most] = theme::extent(values.iter().copied())?;
        let [_, lower, median, upper, _] = Quartiles::new(&values).values();
        Some(Self { least, lower, median, upper, most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated_and_broken_values_left_out() {
        let summary = Summary::new(&[4.0, f32::NAN, 1.0, 3.0, 2.0, f32::INFINITY]).unwrap();
        let expected = Summary { least: 1.0, lower: 1.75, median: 2.5, upper: 3.25, most: 4.0 };
        assert_eq!(summary, expected);
        assert_eq!(Summary::new(&[0.5]).unwrap().upper, 0.5);
        assert_eq!(Summary::new(&[f32::NAN]), None);
    }
}
