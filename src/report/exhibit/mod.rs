//! The results of the studies as records, tables, plots and pictures. A study's command writes an
//! exhibit's parts as files; the page of the paper shows them.

pub mod ablation;
pub mod contest;
pub mod gaps;
pub mod landscape;
pub mod starts;
pub mod sweep;

use super::{Staging, json, picture};
use crate::lighting::Light;
use crate::objective::Quality;
use crate::scene::view::View;
use anyhow::{Result, anyhow};
use image::RgbImage;
use serde::Serialize;

/// Size of the plots, pixels.
const PLOT: (u32, u32) = (520, 400);

/// What a study found.
#[derive(Debug, Clone)]
pub struct Exhibit<T> {
    /// The figures.
    pub data: T,
    /// Tables as CSV, with their files' stems.
    pub tables: Vec<(&'static str, Vec<u8>)>,
    /// Plots as SVG, with their files' stems.
    pub plots: Vec<(String, String)>,
    /// Pictures, with their files' stems.
    pub pictures: Vec<(String, RgbImage)>,
}

impl<T> Exhibit<T> {
    /// The plot of that stem.
    pub fn plot(&self, stem: &str) -> Option<&str> {
        self.plots.iter().find(|(name, _)| name == stem).map(|(_, svg)| svg.as_str())
    }

    /// The picture of that stem.
    pub fn picture(&self, stem: &str) -> Option<&RgbImage> {
        self.pictures.iter().find(|(name, _)| name == stem).map(|(_, picture)| picture)
    }

    /// Writes tables, plots and pictures.
    ///
    /// # Errors
    /// When a file cannot be written or a picture is too large for PNG.
    pub fn write(&self, staging: &mut Staging) -> Result<()> {
        for (stem, table) in &self.tables {
            staging.write(format!("{stem}.csv"), table)?;
        }
        for (stem, plot) in &self.plots {
            staging.write(format!("{stem}.svg"), plot)?;
        }
        for (stem, image) in &self.pictures {
            staging.write(format!("{stem}.png"), picture::png(image)?)?;
        }
        Ok(())
    }
}

/// Where rigs are looked at: the view that was studied.
pub trait Studio {
    /// The view.
    fn view(&self) -> &View;

    /// The colour picture under a rig.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn paint(&mut self, rig: &[Light]) -> Result<RgbImage>;

    /// The quality of a rig.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    fn judge(&mut self, rig: &[Light]) -> Result<Quality>;
}

/// `STUDY.json`: what every result begins with, the seed, and the study's figures.
#[derive(Debug, Clone, Serialize)]
pub struct StudyFile<'a, T> {
    /// Schema `klieg.study/1`.
    #[serde(flatten)]
    pub header: json::Header,
    /// Name of the study.
    pub study: &'static str,
    /// Seed.
    pub seed: u64,
    /// Settings of the quality function.
    pub objective: json::ObjectiveRecord,
    /// The study's figures.
    #[serde(flatten)]
    pub figures: &'a T,
}

impl<T> StudyFile<'_, T> {
    /// The schema's name.
    pub const SCHEMA: &'static str = "klieg.study/1";
}

/// A table with a header.
fn table<R: Serialize>(names: &[&str], rows: impl IntoIterator<Item = R>) -> Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(names)?;
    for row in rows {
        table.serialize(row)?;
    }
    Ok(table.into_inner().map_err(csv::IntoInnerError::into_error)?)
}

/// A plot, or the plotting library's reason against it.
fn plotted(plot: Result<String, String>) -> Result<String> {
    plot.map_err(|reason| anyhow!("plotting: {reason}"))
}
