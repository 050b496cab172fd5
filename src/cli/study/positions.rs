//! Studies of one light's position: the landscape of `F`, and descents over it.

use super::Common;
use crate::cli::progress::Watch;
use crate::cli::session::Session;
use crate::cli::values::{GridSize, Position};
use crate::lighting::Role;
use crate::report::exhibit::{self, Exhibit};
use crate::study::landscape::{self, Landscape};
use crate::study::starts;
use anyhow::Result;
use clap::{Args, ValueEnum};

/// F over the positions of one light
///
/// A heat map with the strict local minima, a surface, each term's own map, and the pictures at the
/// best, the worst and every local minimum (figures 5 and 6 of the paper). Every value of the light
/// but its position has the middle of its range.
#[derive(Debug, Args)]
pub(super) struct LandscapeOptions {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    light: LightOptions,
}

/// Greedy descents from several starts
///
/// Four descents, from a random position in each quarter of the light's box, or from given ones: the
/// paths over the landscape, and the pictures at both ends (figures 1 to 4 of the paper).
#[derive(Debug, Args)]
pub(super) struct StartsOptions {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    light: LightOptions,
    /// A start: elevation and azimuth in degrees; several times for several
    #[arg(long = "from", value_name = "EL,AZ", allow_hyphen_values = true)]
    starts: Vec<Position>,
}

/// The light that moves.
#[derive(Debug, Args)]
struct LightOptions {
    /// Role of the light, which decides its box
    #[arg(long, default_value = "key")]
    role: RoleName,
    /// Azimuths x elevations of the landscape
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "91x46")]
    grid: GridSize,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RoleName {
    Key,
    Fill,
    Rim,
}

impl From<RoleName> for Role {
    fn from(name: RoleName) -> Self {
        match name {
            RoleName::Key => Self::Key,
            RoleName::Fill => Self::Fill,
            RoleName::Rim => Self::Rim,
        }
    }
}

pub(super) fn landscape(options: &LandscapeOptions) -> Result<()> {
    let common = &options.common;
    let (mut session, staging) = common.open(common.settings()?)?;
    let watch = Watch::new(Some(options.light.positions()), common.scene.json)?;
    let landscape = options.light.landscape(&mut session, &watch)?;
    let exhibit = exhibit::landscape::exhibit(&landscape, &mut session)?;
    drop(watch);
    common.finish((session, staging), "landscape", &exhibit, &describe(&exhibit))
}

pub(super) fn starts(options: &StartsOptions) -> Result<()> {
    let common = &options.common;
    let (mut session, staging) = common.open(common.settings()?)?;
    let settings = &session.settings;
    let (role, kind) = (options.light.role.into(), settings.lights.kind);
    let genome = starts::position_genome(role, kind, &settings.lights.boxes)?;
    let starts = if options.starts.is_empty() {
        starts::quarters(&genome, settings.seed)
    } else {
        let given = options.starts.iter().map(|start| start.chromosome(&genome));
        given.collect::<crate::Result<_>>()?
    };
    let descent = settings.greedy.descent();
    let watch = Watch::new(None, common.scene.json)?;
    let landscape = options.light.landscape(&mut session, &watch)?;
    watch.stage("descents");
    let made = &mut |evaluations| watch.made(evaluations);
    let paths = starts::run(&mut session.subject(), &genome, &starts, descent, made)?;
    let exhibit = exhibit::starts::exhibit(&landscape, &paths, &mut session)?;
    drop(watch);

    let data = &exhibit.data;
    let summary: String = data
        .descents
        .iter()
        .enumerate()
        .map(|(i, d)| {
            let (start, end) = (d.start, d.end);
            format!(
                "descent {}: F {:.4} at {:.1}°, {:.1}° to F {:.4} at {:.1}°, {:.1}° in {} steps\n",
                i + 1,
                start.score,
                start.elevation_deg,
                start.azimuth_deg,
                end.score,
                end.elevation_deg,
                end.azimuth_deg,
                d.steps
            )
        })
        .collect();
    common.finish((session, staging), "starts", &exhibit, &summary)
}

impl LightOptions {
    fn positions(&self) -> u64 {
        let GridSize(grid) = self.grid;
        grid.columns as u64 * grid.rows as u64
    }

    fn landscape(&self, session: &mut Session, watch: &Watch) -> Result<Landscape> {
        let lights = &session.settings.lights;
        let genome = starts::position_genome(self.role.into(), lights.kind, &lights.boxes)?;
        watch.stage("landscape");
        let made = &mut |evaluations| watch.made(evaluations);
        Ok(landscape::run(&mut session.subject(), &genome, self.grid.0, made)?)
    }
}

fn describe(exhibit: &Exhibit<exhibit::landscape::Figures>) -> String {
    let data = &exhibit.data;
    let place = |name: &str, place: &exhibit::landscape::Place| {
        format!(
            "{name}: F {:.4} at elevation {:.1}°, azimuth {:.1}°\n",
            place.score, place.elevation_deg, place.azimuth_deg
        )
    };
    format!(
        "{}{}{} strict local minima, {} of them deeper than {}\n",
        place("best", &data.best),
        place("worst", &data.worst),
        data.local_minima,
        data.deep_minima,
        data.deep
    )
}
