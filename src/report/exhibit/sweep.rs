//! The genetic algorithm's settings, one changed at a time.

use super::{Exhibit, plotted, table};
use crate::report::plot::{self, Panel, Setting};
use crate::study::contest::{Comparison, Finding};
use crate::study::statistics::{LEVEL, Quartiles};
use crate::study::sweep::{Parameter, Sweep};
use anyhow::Result;
use serde::Serialize;

/// Size of the plot, pixels: four panels.
const PLOT: (u32, u32) = (560, 520);

/// A sweep in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Evaluations of every run.
    pub budget: usize,
    /// Runs of each trial.
    pub runs: usize,
    /// Trials that ended better than the standard settings, with a p-value below `level`.
    pub better: usize,
    /// Trials that ended worse, alike.
    pub worse: usize,
    /// The level meant by `better` and `worse`; not corrected for the number of trials.
    pub level: f64,
    /// The trials.
    pub trials: Vec<TrialRecord>,
}

/// A trial.
#[derive(Debug, Clone, Serialize)]
pub struct TrialRecord {
    /// What is changed.
    pub parameter: Parameter,
    /// To what.
    pub value: f32,
    /// Whether it is the standard value.
    pub standard: bool,
    /// The last scores.
    pub last: Quartiles,
    /// Against the standard settings, paired by seed: a negative difference is an improvement.
    pub against_standard: Comparison,
}

/// The exhibit.
///
/// # Errors
/// The plotting library's reason.
pub fn exhibit(sweep: &Sweep) -> Result<Exhibit<Figures>> {
    let trials: Vec<_> = sweep
        .trials
        .iter()
        .map(|trial| TrialRecord {
            parameter: trial.parameter,
            value: trial.value,
            standard: trial.standard,
            last: Quartiles::of(&trial.scores),
            against_standard: trial.against_standard,
        })
        .collect();
    let count =
        |verdict| trials.iter().filter(|trial| trial.against_standard.verdict == verdict).count();
    let data = Figures {
        budget: sweep.budget,
        runs: sweep.trials.first().map_or(0, |trial| trial.scores.len()),
        better: count(Finding::Lower),
        worse: count(Finding::Higher),
        level: LEVEL,
        trials: trials.clone(),
    };
    let names = [
        "parameter",
        "value",
        "standard",
        "low",
        "first_quartile",
        "median",
        "third_quartile",
        "high",
        "won",
        "median_difference",
        "p_value",
    ];
    let rows = trials.iter().map(|t| {
        let (Quartiles { low, first, median, third, high }, c) = (t.last, t.against_standard);
        let last = (low, first, median, third, high);
        let against = (c.won, c.median_difference, c.p_value);
        (t.parameter, t.value, u8::from(t.standard), last, against)
    });
    Ok(Exhibit {
        tables: vec![("sweep", table(&names, rows)?)],
        plots: vec![("sweep".into(), plot(sweep)?)],
        pictures: Vec::new(),
        data,
    })
}

fn plot(sweep: &Sweep) -> Result<String> {
    let labels: Vec<String> =
        sweep.trials.iter().map(|trial| trial.parameter.label(trial.value)).collect();
    let settings: Vec<Vec<Setting>> = Parameter::ALL
        .iter()
        .map(|parameter| {
            let own = sweep.trials.iter().zip(&labels).filter(|(t, _)| t.parameter == *parameter);
            own.map(|(trial, label)| Setting {
                label,
                values: &trial.scores,
                standard: trial.standard,
            })
            .collect()
        })
        .collect();
    let names = ["population", "elitism, %", "crossover, %", "mutation, %"];
    let panels: Vec<_> =
        names.iter().zip(&settings).map(|(name, settings)| Panel { name, settings }).collect();
    plotted(plot::sweep(&panels, "last F, lower is better", PLOT))
}
