//! Final pictures, as settings ask for them.

use super::config::Settings;
use crate::Result;
use crate::lighting::{Light, LightRecord, Population};
use crate::render::{self, Picture, Stage};
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;

/// What casts shadows in final pictures; nothing where the settings have none.
///
/// # Errors
/// As [`Occluders::new`].
pub fn occluders(scene: &Scene, view: &View, settings: &Settings) -> Result<Option<Occluders>> {
    settings.shadows.on.then(|| Occluders::new(scene, view)).transpose()
}

/// The final picture of each rig.
///
/// # Errors
/// As [`render::draw`].
pub fn draw(
    (scene, view): (&Scene, &View),
    occluders: Option<&Occluders>,
    settings: &Settings,
    rigs: &[&[Light]],
) -> Result<Vec<Picture>> {
    let rigs = rigs.iter().map(|rig| Population::of([*rig])).collect::<Result<Vec<_>>>()?;
    let records: Vec<_> = rigs.iter().map(Population::records).collect();
    draw_records((scene, view), occluders, settings, &records)
}

/// The same of rigs as evaluators read them.
///
/// # Errors
/// As [`render::draw`].
pub fn draw_records(
    (scene, view): (&Scene, &View),
    occluders: Option<&Occluders>,
    settings: &Settings,
    records: &[&[LightRecord]],
) -> Result<Vec<Picture>> {
    let stage = Stage { scene, view, shading: &settings.shading, occluders };
    render::draw_each(&stage, records, &settings.picture)
}
