//! Values of options, in the forms that the command line has for them.

use crate::error::within;
use crate::lighting::genome::Genome;
use crate::lighting::{Light, LightKind, Role};
use crate::math::range::Range;
use crate::objective::{Term, Terms};
use crate::study::landscape::Grid;
use std::str::FromStr;

pub use crate::session::values::{Device, Lights, Size, Times};

/// Weights of terms, each `name=value`: they are set, and all other terms stay as they are. Without names
/// they are those of the paper's five terms in order, which alone then count.
#[derive(Debug, Clone, PartialEq)]
pub enum Weights {
    /// By name.
    Named(Vec<(String, f32)>),
    /// Of the paper's terms.
    Paper([f32; 5]),
}

/// The terms of the paper, in its order.
const PAPER: [&str; 5] = ["edge", "mean", "grad", "var", "hist"];

impl Weights {
    /// Sets what is given.
    ///
    /// # Errors
    /// As [`Terms::set`].
    pub fn apply(&self, weights: &mut Terms) -> crate::Result<()> {
        match self {
            Self::Named(pairs) => {
                for (name, weight) in pairs {
                    weights.set(Term::named(name)?, *weight)?;
                }
            }
            Self::Paper(all) => *weights = Terms::named(PAPER.into_iter().zip(*all))?,
        }
        Ok(())
    }
}

impl FromStr for Weights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        if !text.contains('=') {
            let numbers: Vec<f32> =
                parts.iter().map(|part| weight_value(part)).collect::<Result<_, _>>()?;
            let wrong =
                |all: Vec<f32>| format!("{} numbers instead of 5 ({})", all.len(), PAPER.join(","));
            return numbers.try_into().map(Self::Paper).map_err(wrong);
        }
        let pair = |part: &&str| {
            let (name, value) =
                part.split_once('=').ok_or_else(|| format!("'{part}' is not a pair name=value"))?;
            let term = Term::named(name.trim()).map_err(|error| error.to_string())?;
            Ok((term.name.to_owned(), weight_value(value)?))
        };
        parts.iter().map(pair).collect::<Result<_, String>>().map(Self::Named)
    }
}

fn weight_value(text: &str) -> Result<f32, String> {
    let value = number(text)?;
    if value < 0.0 { Err(format!("weight is {value}: it must be 0 or more")) } else { Ok(value) }
}

/// Columns and rows of a landscape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GridSize(pub Grid);

impl FromStr for GridSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("'{text}' is not a grid COLUMNSxROWS");
        let (columns, rows) = text.split_once(['x', 'X', '×']).ok_or_else(fault)?;
        let number = |text: &str| text.trim().parse().map_err(|_| fault());
        Ok(Self(Grid { columns: number(columns)?, rows: number(rows)? }))
    }
}

/// Where a light stands: elevation and azimuth, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position([f32; 2]);

impl Position {
    /// The chromosome of a light there, every other value in the middle of its range.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a position outside the box.
    pub fn chromosome(self, genome: &Genome) -> crate::Result<Vec<f32>> {
        let mut chromosome: Vec<f32> = genome.bounds().iter().map(Range::middle).collect();
        for (i, (angle, name)) in self.0.into_iter().zip(["elevation", "azimuth"]).enumerate() {
            let range = genome.bounds()[i];
            let (low, high) = (range.low.to_degrees(), range.high.to_degrees());
            within(name, angle, low.round(), high.round())?;
            chromosome[i] = range.nearest(angle.to_radians());
        }
        Ok(chromosome)
    }
}

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
        let count = |v: Vec<_>| format!("{} numbers instead of 2 (el,az)", v.len());
        Ok(Self(values.try_into().map_err(count)?))
    }
}

/// A light as `el,az,R,Id,Is`: degrees, scene radii and intensities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightArg([f32; 5]);

impl LightArg {
    /// The light. Roles do not touch the score; the first light of a rig counts as its key.
    pub fn light(self, kind: LightKind, role: Role) -> Light {
        let [elevation, azimuth, distance, diffuse, specular] = self.0;
        let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
        Light { role, kind, elevation, azimuth, distance, diffuse, specular, ..Light::default() }
    }
}

impl FromStr for LightArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
        let values: [f32; 5] = values
            .try_into()
            .map_err(|v: Vec<_>| format!("{} numbers instead of 5 (el,az,R,Id,Is)", v.len()))?;
        let [elevation, azimuth, distance, diffuse, specular] = values;
        if !(-90.0..=90.0).contains(&elevation) || !(-360.0..=360.0).contains(&azimuth) {
            return Err("elevation must be -90 to 90, azimuth -360 to 360 degrees".into());
        }
        if distance <= 0.0 {
            return Err(format!("distance is {distance}: it must be more than 0 scene radii"));
        }
        if diffuse < 0.0 || specular < 0.0 {
            return Err("intensities must be 0 or more".into());
        }
        Ok(Self(values))
    }
}

/// A finite number.
fn number(text: &str) -> Result<f32, String> {
    let value: f32 = text.trim().parse().map_err(|_| format!("'{text}' is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("'{text}' is not finite")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::Objective;

    fn refused<T: FromStr>(texts: &[&str]) {
        texts.iter().for_each(|text| assert!(text.parse::<T>().is_err(), "{text}"));
    }

    #[test]
    fn weights_in_order_and_by_name() {
        let mut weights = Objective::default().weights;
        let mut given = |text: &str| {
            text.parse::<Weights>().unwrap().apply(&mut weights).unwrap();
            weights.iter().map(|(term, weight)| (term.name, weight)).collect::<Vec<_>>()
        };
        let named = given("var=0,edge=1.5,relief=0.5");
        let expected = [("edge", 1.5), ("mean", 0.2), ("grad", 0.2), ("var", 0.0), ("hist", 0.2)];
        assert_eq!(named, [&expected[..], &[("relief", 0.5)]].concat());
        let paper = given("1,2,3,4,5");
        let expected = [("edge", 1.0), ("mean", 2.0), ("grad", 3.0), ("var", 4.0), ("hist", 5.0)];
        assert_eq!(paper, expected);
        refused::<Weights>(&[
            "1,2,3",
            "1,2,3,4,nan",
            "-1,0,0,0,0",
            "size=1",
            "edge=1,3",
            "edge=inf",
        ]);
    }

    #[test]
    fn lights_in_numbers() {
        let light = "30,-45,2.5,1,0.5".parse::<LightArg>().unwrap();
        let light = light.light(LightKind::POINT, Role::Key);
        assert_eq!((light.distance, light.diffuse, light.specular), (2.5, 1.0, 0.5));
        assert_eq!(light.azimuth, (-45f32).to_radians());
        refused::<LightArg>(&[
            "",
            "1,2,3,4",
            "91,0,2,1,1",
            "0,0,0,1,1",
            "0,0,2,-1,1",
            "0,0,2,inf,1",
        ]);
    }
}
