//! Settings of a run, made of the tables of a configuration file.

use crate::error::{OrRaise as _, refused};
use klieg::design::profile::{DEFAULT, PROFILES, Profile};
use klieg::lighting::Color;
use klieg::objective::{Term, terms::TERMS};
use klieg::optimize::OPTIMIZERS;
use klieg::session::config;
use klieg::session::values::role;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Settings that have passed their check.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct Settings(pub config::Settings);

#[pymethods]
impl Settings {
    /// Of `tables` as JSON, in the place of what the `file` says, in the place of the defaults of the `profile`.
    #[new]
    #[pyo3(signature = (tables, file, profile, seed, weights, one_intensity, colors))]
    fn new(
        tables: &str,
        file: Option<PathBuf>,
        profile: Option<&str>,
        seed: Option<u64>,
        weights: Vec<(String, f32)>,
        one_intensity: Option<bool>,
        colors: Vec<(Option<String>, String)>,
    ) -> PyResult<Self> {
        let asked = profile.map(Profile::named).transpose().or_raise()?;
        let fault = |fault: &dyn std::fmt::Display| refused(format!("settings: {fault}"));
        let tables: toml::Table = serde_json::from_str(tables).map_err(|e| fault(&e))?;
        let mut settings = match file {
            Some(path) => config::Settings::read_over(&path, tables, asked, DEFAULT).or_raise()?,
            None => config::Settings::of_table(tables, asked.unwrap_or(DEFAULT))
                .map_err(|e| fault(&e.message()))?,
        };
        settings.seed = seed.unwrap_or(settings.seed);
        for (name, weight) in weights {
            let term = Term::named(&name).or_raise()?;
            settings.objective.weights.set(term, weight).or_raise()?;
        }
        if let Some(one) = one_intensity {
            settings.lights.set_intensities(one);
        }
        for (name, color) in colors {
            let role = name.map(|name| role(&name)).transpose().map_err(refused)?;
            let color: Color = color.parse().map_err(|text: String| refused(text))?;
            settings.lights.set_color(role, color).or_raise()?;
        }
        settings.check().or_raise()?;
        settings.one_view().or_raise()?;
        settings.genome().or_raise()?;
        Ok(Self(settings))
    }

    /// All of them as JSON.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).or_raise()
    }
}

/// Name and meaning of each profile.
#[pyfunction]
pub fn profiles() -> Vec<(&'static str, &'static str)> {
    PROFILES.iter().map(|profile| (profile.name, profile.meaning)).collect()
}

/// Name and meaning of each term.
#[pyfunction]
pub fn terms() -> Vec<(&'static str, &'static str)> {
    TERMS.iter().map(|term| (term.name, term.meaning)).collect()
}

/// Name and description of each optimiser.
#[pyfunction]
pub fn optimizers() -> Vec<(&'static str, &'static str)> {
    OPTIMIZERS.iter().map(|entry| (entry.name, entry.description)).collect()
}
