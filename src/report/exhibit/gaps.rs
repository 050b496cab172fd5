//! How far above the lowest `F` that is known searches end.

use super::{Exhibit, PLOT, plotted, table};
use crate::report::plot::{self, Band};
use crate::study::gaps::{Case, Standing, TARGETS, by_lights, optimizers, reached, standings};
use crate::study::statistics::Quartiles;
use anyhow::Result;
use serde::Serialize;

/// Points of a run-length distribution.
const POINTS: usize = 60;

/// The gaps in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Evaluations of every run, at most.
    pub budget: usize,
    /// Runs of each optimiser in each case.
    pub runs: usize,
    /// The first seed; each further run has the next.
    pub first_seed: u64,
    /// Gaps, percent, that count as targets.
    pub targets: [f32; TARGETS.len()],
    /// What came of it, by number of lights and optimiser.
    pub standings: Vec<StandingRecord>,
    /// The cases.
    pub cases: Vec<CaseRecord>,
}

/// How an optimiser does with a number of lights.
#[derive(Debug, Clone, Serialize)]
pub struct StandingRecord {
    /// Number of lights.
    pub lights: usize,
    /// Name of the optimiser.
    pub method: &'static str,
    /// What tables call it.
    #[serde(skip)]
    pub title: &'static str,
    /// Gaps of the last scores, percent.
    pub gaps: Quartiles,
    /// Share of the runs that end within each target.
    pub within: [f32; TARGETS.len()],
    /// Evaluations of a run, the median.
    pub evaluations: f32,
}

/// A scene with a number of lights.
#[derive(Debug, Clone, Serialize)]
pub struct CaseRecord {
    /// The scene's file, as it was given.
    pub scene: String,
    /// Number of lights.
    pub lights: usize,
    /// The lowest `F` of all runs.
    pub lowest: f32,
}

/// The exhibit.
///
/// # Errors
/// The plotting library's reason.
pub fn exhibit(cases: &[Case]) -> Result<Exhibit<Figures>> {
    let first = cases.first().map(|case| &case.contest);
    let runs = first.and_then(|contest| contest.contestants.first());
    let data = Figures {
        budget: first.map_or(0, |contest| contest.budget),
        runs: runs.map_or(0, |one| one.courses.len()),
        first_seed: first.map_or(0, |contest| contest.seed),
        targets: TARGETS,
        standings: standings(cases).into_iter().map(record).collect(),
        cases: cases.iter().map(case).collect(),
    };
    let mut plots = Vec::new();
    for (lights, _) in by_lights(cases) {
        let plot = run_lengths(cases, lights, data.budget);
        plots.push((format!("run-lengths-{lights}"), plotted(plot)?));
    }
    let names = ["scene", "lights", "method", "seed", "evaluations", "score", "gap_percent"];
    let rows = cases.iter().flat_map(rows);
    Ok(Exhibit {
        tables: vec![("optimizers", table(&names, rows)?)],
        plots,
        data,
        pictures: Vec::new(),
    })
}

fn record(standing: Standing) -> StandingRecord {
    let Standing { optimizer, lights, gaps, within, evaluations } = standing;
    let (method, title) = (optimizer.name, optimizer.title);
    StandingRecord { lights, method, title, gaps, within, evaluations }
}

fn case(case: &Case) -> CaseRecord {
    CaseRecord { scene: case.scene.clone(), lights: case.lights, lowest: case.lowest }
}

/// A row of the table.
type Row<'a> = (&'a str, usize, &'static str, u64, usize, f32, f32);

fn rows(case: &Case) -> impl Iterator<Item = Row<'_>> {
    case.contest.contestants.iter().flat_map(move |one| {
        one.courses.iter().enumerate().map(move |(run, course)| {
            let seed = case.contest.seed.wrapping_add(run as u64);
            let (score, name) = (course.score(), one.optimizer.name);
            (&*case.scene, case.lights, name, seed, course.evaluations, score, case.gap(score))
        })
    })
}

/// The share of runs and targets that each optimiser has reached, over the evaluations.
fn run_lengths(cases: &[Case], lights: usize, budget: usize) -> Result<String, String> {
    let own: Vec<&Case> = cases.iter().filter(|case| case.lights == lights).collect();
    let at = |point: usize| (budget * point).div_ceil(POINTS);
    let x: Vec<f32> = (1..=POINTS).map(|point| at(point) as f32).collect();
    let curves: Vec<_> = optimizers(&own)
        .into_iter()
        .map(|entry| {
            let share = |point| 100.0 * reached(cases, lights, entry, at(point));
            (entry.title, (1..=POINTS).map(share).collect::<Vec<f32>>())
        })
        .collect();
    let bands: Vec<_> =
        curves.iter().map(|(name, y)| Band { name, x: &x, middle: y, low: y, high: y }).collect();
    plot::bands(&bands, "evaluations", "runs and targets reached, %", PLOT)
}
