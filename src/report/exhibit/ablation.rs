//! What each number of the quality function does to the lights and pictures that are found.

use super::{Exhibit, Studio, table};
use crate::evaluate::Inspection;
use crate::lighting::{Light, Rig, Role};
use crate::objective::{HISTOGRAM_BINS, Terms};
use crate::report::json::ObjectiveRecord;
use crate::study::ablation::Effect;
use crate::study::statistics::Quartiles;
use anyhow::Result;
use serde::Serialize;

/// An ablation in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Runs of each variant.
    pub runs: usize,
    /// The variants, the unchanged function first.
    pub variants: Vec<VariantRecord>,
}

/// A variant and its effect: medians over the runs, measured by the unchanged function.
#[derive(Debug, Clone, Serialize)]
pub struct VariantRecord {
    /// What is changed, and to what.
    pub name: String,
    /// The changed function.
    pub changed: ObjectiveRecord,
    /// `F`.
    pub score: f32,
    /// Its terms.
    pub terms: Terms,
    /// Mean of `I` over the object.
    pub mean: f32,
    /// Its standard deviation.
    pub deviation: f32,
    /// Share of the object in the darkest bin of the histogram.
    pub dark: f32,
    /// Share of the object in the brightest bin.
    pub white: f32,
    /// Elevation of the key light, degrees.
    pub key_elevation_deg: f32,
    /// Angle between the key light and the viewer, degrees.
    pub key_from_viewer_deg: f32,
    /// Mean absolute difference of `I` from the unchanged function's picture of the same seed.
    pub change: f32,
}

fn key(rig: &Rig) -> &Light {
    rig.iter().find(|light| light.role == Role::Key).unwrap_or(&rig[0])
}

fn share(inspection: &Inspection, bin: usize) -> f32 {
    let histogram = &inspection.statistics.histogram;
    histogram[bin] as f32 / histogram.iter().sum::<u32>().max(1) as f32
}

fn record(effect: &Effect) -> VariantRecord {
    let median = |sample: Vec<f32>| Quartiles::of(&sample).median;
    let seen = |f: &dyn Fn(&Inspection) -> f32| median(effect.inspections.iter().map(f).collect());
    let of_key = |f: fn(&Light) -> f32| median(effect.rigs.iter().map(|rig| f(key(rig))).collect());
    VariantRecord {
        name: effect.variant.name.clone(),
        changed: (&effect.variant.objective).into(),
        score: seen(&|i| i.score),
        terms: effect
            .variant
            .objective
            .measured()
            .map(|term, _| seen(&|inspection| inspection.terms.get(term.name).unwrap_or(f32::NAN))),
        mean: seen(&|i| i.statistics.mean),
        deviation: seen(&|i| i.statistics.variance.max(0.0).sqrt()),
        dark: seen(&|i| share(i, 0)),
        white: seen(&|i| share(i, HISTOGRAM_BINS - 1)),
        key_elevation_deg: of_key(|light| light.elevation.to_degrees()),
        key_from_viewer_deg: of_key(|light| {
            light.direction().z.clamp(-1.0, 1.0).acos().to_degrees()
        }),
        change: median(effect.changes.clone()),
    }
}

/// The exhibit: the picture of every variant is that of its median run.
///
/// # Errors
/// What the studio reports.
pub fn exhibit(effects: &[Effect], studio: &mut dyn Studio) -> Result<Exhibit<Figures>> {
    let variants: Vec<_> = effects.iter().map(record).collect();
    let mut pictures = Vec::new();
    for (i, effect) in effects.iter().enumerate() {
        let name = effect.variant.name.replace([' ', '.'], "-").to_lowercase();
        pictures.push((format!("{i:02}-{name}"), studio.paint(&effect.rigs[effect.median_run()])?));
    }
    let terms: Vec<_> = variants.first().map_or(Vec::new(), |v| v.terms.names().collect());
    let others = [
        "mean_i",
        "deviation",
        "dark",
        "white",
        "key_elevation_deg",
        "key_from_viewer_deg",
        "change",
    ];
    let names: Vec<&str> =
        ["variant", "score"].into_iter().chain(terms.clone()).chain(others).collect();
    let rows = variants.iter().map(|v| {
        let picture = (v.mean, v.deviation, v.dark, v.white);
        let key = (v.key_elevation_deg, v.key_from_viewer_deg);
        let values: Vec<_> = terms.iter().map(|name| v.terms.get(name)).collect();
        (&v.name, v.score, values, picture, key, v.change)
    });
    let tables = vec![("ablation", table(&names, rows)?)];
    let runs = effects.first().map_or(0, |effect| effect.rigs.len());
    Ok(Exhibit { data: Figures { runs, variants }, tables, plots: Vec::new(), pictures })
}
