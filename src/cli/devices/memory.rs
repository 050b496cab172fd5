//! `klieg devices --for`: the device memory that a search for a scene's lights takes.

use crate::cli::options::Shadows;
use crate::cli::print;
use crate::design::profile;
use crate::gpu::{
    ContextOptions, DeviceChoice, DeviceReport, GpuEvaluator, MemoryPlan, PipelineKind, Tuning,
};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::session::config::Settings;
use crate::session::input::SceneFile;
use crate::session::profile::ProfileName;
use crate::session::values::{Lights, Size};
use crate::session::{Loaded, view, warn};
use crate::{Error, Result};
use clap::Args;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// Whose memory is told.
#[derive(Debug, Args)]
pub(super) struct ForOptions {
    /// Tell the device memory that a search for the lights of this scene takes, by device and pipeline, before it is
    /// taken, and whether it fits
    #[arg(long = "for", value_name = "SCENE")]
    scene: Option<SceneFile>,
    /// Picture size in pixels [default: 512x512, or the size stored with a camera klieg wrote]
    #[arg(long, value_name = "WxH", requires = "scene")]
    size: Option<Size>,
    /// The lights: roles, or a number from 1 to 16 [default: the profile's, key,fill]
    #[arg(long, value_name = "ROLES|NUMBER", requires = "scene")]
    lights: Option<Lights>,
    /// Individuals of a generation, 2 or more [default: the profile's; natural: 20, paper: 30]
    #[arg(long, value_name = "N", requires = "scene")]
    population: Option<usize>,
    /// Whether lights cast shadows [default: the profile's; natural: on]
    #[arg(long, value_name = "on|off", requires = "scene")]
    shadows: Option<Shadows>,
    /// Defaults of the lights, the population, the shading and the shadows [default: natural]
    #[arg(long, value_name = "PROFILE", value_parser = ProfileName::parser(), requires = "scene")]
    profile: Option<ProfileName>,
}

/// The search whose memory is told.
#[derive(Serialize)]
pub(super) struct Search {
    scene: PathBuf,
    size: Size,
    lights: usize,
    population: usize,
    shadows: bool,
    #[serde(skip)]
    loaded: (Arc<Scene>, View, Settings),
}

/// What a pipeline takes, or why it cannot run there.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum Plan {
    Known(MemoryPlan),
    Impossible { pipeline: PipelineKind, fits: bool, fault: String },
}

impl ForOptions {
    /// The search that is asked for, with its scene loaded.
    ///
    /// # Errors
    /// Faults of the settings and the scene.
    pub fn search(&self) -> Result<Option<Search>> {
        let Some(file) = &self.scene else { return Ok(None) };
        let mut settings = Settings::of(self.profile.map_or(profile::DEFAULT, |name| name.0));
        settings.view.size = self.size;
        if let Some(lights) = &self.lights {
            settings.lights.roles = lights.clone();
        }
        settings.search.population = self.population.unwrap_or(settings.search.population);
        if let Some(shadows) = self.shadows {
            settings.shadows.on = shadows == Shadows::On;
        }
        settings.check()?;
        let Loaded { scene, .. } = Loaded::read(file.path()?, &settings.loading())?;
        warn(&scene.warnings);
        let view = view(&scene, &settings.view)?;
        Ok(Some(Search {
            scene: scene.path.clone(),
            size: Size([view.width, view.height]),
            lights: settings.lights.roles.0.len(),
            population: settings.search.population,
            shadows: settings.shadows.on,
            loaded: (scene, view, settings),
        }))
    }
}

impl Search {
    /// What each pipeline of a device that can run klieg takes.
    ///
    /// # Errors
    /// [`Error::Input`]: faults of the scene.
    pub fn plans(&self, report: &DeviceReport) -> Result<Vec<Plan>> {
        if !report.lacks.is_empty() {
            return Ok(Vec::new());
        }
        let (layers, scene) = (report.draws_layers, report.draws_scenes);
        [(PipelineKind::Compute, true), (PipelineKind::Layered, layers)]
            .into_iter()
            .chain([(PipelineKind::Forward, layers && scene)])
            .filter(|&(_, able)| able)
            .map(|(pipeline, _)| self.plan(report, pipeline))
            .collect()
    }

    fn plan(&self, report: &DeviceReport, pipeline: PipelineKind) -> Result<Plan> {
        let tuning = Tuning { pipeline: Some(pipeline), ..Tuning::default() };
        let device = DeviceChoice::Index(report.index);
        let options = ContextOptions { device, tuning, ..ContextOptions::default() };
        let (scene, view, settings) = &self.loaded;
        let both = (settings.objective, settings.shading);
        let individuals = u32::try_from(self.population)
            .map_err(|_| Error::Argument(format!("{} individuals", self.population)))?;
        let population = (individuals, self.lights);
        match GpuEvaluator::plan(&options, (scene, view), both, &settings.shadows, population) {
            Ok(plan) => Ok(Plan::Known(plan)),
            Err(fault @ Error::Input { .. }) => Err(fault),
            Err(fault) => Ok(Plan::Impossible { pipeline, fits: false, fault: fault.to_string() }),
        }
    }

    /// The table of all devices' plans, for people.
    pub fn table<'a>(&self, devices: impl Iterator<Item = (usize, &'a [Plan])>) -> String {
        let shadows = if self.shadows { "with shadows" } else { "without shadows" };
        let Self { size, population, lights, .. } = self;
        let mut table = columns();
        let mut faults = String::new();
        for (index, plans) in devices {
            for plan in plans {
                match plan {
                    Plan::Known(plan) => row(&mut table, index, plan),
                    Plan::Impossible { pipeline, fault, .. } => {
                        faults += &format!(" {index} {pipeline}: does not fit: {fault}\n");
                    }
                }
            }
        }
        format!(
            "Memory at {size}, {population} rigs of {lights} lights, {shadows}:\n{table}\n{faults}"
        )
    }
}

fn columns() -> Table {
    let mut table =
        print::columns(&["device", "view", "shadows", "population", "at most", "of"], &["fits"]);
    if let Some(last) = table.column_mut(6) {
        last.set_cell_alignment(CellAlignment::Left);
    }
    table
}

fn row(table: &mut Table, index: usize, plan: &MemoryPlan) {
    let bytes = [plan.view, plan.shadows, plan.population, plan.most.total(), plan.memory];
    let fits = if plan.fits { "yes" } else { "no" };
    table.add_row(
        [format!("{index} {}", plan.pipeline)]
            .into_iter()
            .chain(bytes.map(print::bytes_in_words))
            .chain([fits.to_owned()]),
    );
}
