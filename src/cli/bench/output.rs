//! A benchmark as a table, as CSV and as plots.

use super::super::print;
use super::super::values::Size;
use super::record::{Bench, Row};
use crate::report::plot::{self, Line, Panel, Setting};
use crate::report::{Staging, json};
use anyhow::anyhow;
use std::path::PathBuf;

/// Size of the plots, pixels.
const PLOT: (u32, u32) = (760, 480);

/// A quantity that a benchmark varies.
struct Sweep {
    file: &'static str,
    label: &'static str,
    value: fn(&Row) -> u64,
}

const SWEEPS: [Sweep; 4] = [
    Sweep {
        file: "size.svg",
        label: "pixels",
        value: |row| row.setup.size.map(u64::from).iter().product(),
    },
    Sweep { file: "population.svg", label: "individuals", value: |row| row.work.population as u64 },
    Sweep { file: "lights.svg", label: "lights", value: |row| row.work.lights as u64 },
    Sweep { file: "triangles.svg", label: "triangles", value: |row| row.setup.triangles.into() },
];

/// Writes `bench.json`, `bench.csv` and a plot for each quantity of several values.
///
/// # Errors
/// [`crate::Error::Output`], and the plotting library's reason.
pub fn write(bench: &Bench, mut staging: Staging) -> anyhow::Result<Vec<PathBuf>> {
    staging.write("bench.json", json::text(bench)?)?;
    staging.write("bench.csv", csv(&bench.rows)?)?;
    for (at, sweep) in SWEEPS.iter().enumerate() {
        if let Some(plot) = plot_sweep(&bench.rows, at) {
            staging.write(sweep.file, plot.map_err(|fault| anyhow!(fault))?)?;
        }
    }
    if let Some(plot) = plot_methods(&bench.rows) {
        staging.write("pipelines.svg", plot.map_err(|fault| anyhow!(fault))?)?;
    }
    Ok(staging.publish()?)
}

/// One row a line; what is not known is empty.
fn csv(rows: &[Row]) -> csv::Result<Vec<u8>> {
    let mut stages: Vec<&str> = Vec::new();
    for stage in rows.iter().flat_map(|row| row.stages_ms.keys()) {
        if !stages.contains(&stage.as_str()) {
            stages.push(stage);
        }
    }
    let names = [
        "device",
        "pipeline",
        "threads",
        "triangles",
        "width",
        "height",
        "object_pixels",
        "lights",
        "population",
        "rigs",
        "maps_ms",
        "shadows_ms",
        "plain_ceiling",
        "special_ceiling",
        "first_ms",
        "runs",
        "median_ms",
        "median_low_ms",
        "median_high_ms",
        "p95_ms",
        "gpu_ms",
        "evaluations_per_second",
        "light_pixels_per_second",
        "gflops",
        "floor_share",
        "host_bytes",
        "device_bytes",
    ];
    let mut table = csv::Writer::from_writer(Vec::new());
    let stage_names = stages.iter().map(|stage| format!("{stage}_ms"));
    table.write_record(names.into_iter().map(String::from).chain(stage_names))?;
    for row in rows {
        let (setup, work) = (&row.setup, &row.work);
        let [low, high] = [0, 1].map(|end| text(row.median_interval_ms.map(|ends| ends[end])));
        let known = [
            setup.device.name.clone(),
            setup.pipeline.clone(),
            text(setup.threads),
            setup.triangles.to_string(),
            setup.size[0].to_string(),
            setup.size[1].to_string(),
            setup.object_pixels.to_string(),
            work.lights.to_string(),
            work.population.to_string(),
            work.rigs.to_string(),
            setup.maps_ms.to_string(),
            text(setup.shadows_ms),
            text(setup.ceiling.map(|ceiling| ceiling.plain)),
            text(setup.ceiling.and_then(|ceiling| ceiling.special)),
            row.first_ms.to_string(),
            row.runs.to_string(),
            row.median_ms.to_string(),
            low,
            high,
            row.p95_ms.to_string(),
            text(row.gpu_ms),
            row.evaluations_per_second.to_string(),
            row.light_pixels_per_second.to_string(),
            text(row.gflops),
            text(row.floor_share),
            text(row.host_bytes),
            text(row.device_bytes),
        ];
        let times = stages.iter().map(|stage| text(row.stages_ms.get(*stage)));
        table.write_record(known.into_iter().chain(times))?;
    }
    table.into_inner().map_err(|e| e.into_error().into())
}

fn text(value: Option<impl ToString>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// Names of the ways of measuring, in order.
fn names<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        let name = row.setup.name();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Median times along the sweep `at`, a line for each way of measuring, where the other quantities
/// have their first values; nothing for a quantity that does not vary.
fn plot_sweep(rows: &[Row], at: usize) -> Option<Result<String, String>> {
    let first = rows.first()?;
    let sweep = &SWEEPS[at];
    let others = || SWEEPS.iter().enumerate().filter(|(other, _)| *other != at);
    let same = |row: &&Row| {
        row.work.rigs == first.work.rigs
            && others().all(|(_, other)| (other.value)(row) == (other.value)(first))
    };
    let rows: Vec<_> = rows.iter().filter(same).collect();
    if rows.iter().all(|row| (sweep.value)(row) == (sweep.value)(first)) {
        return None;
    }
    let line = |name: String| {
        let own = rows.iter().filter(|row| row.setup.name() == name);
        let mut points: Vec<_> =
            own.map(|row| [(sweep.value)(row) as f32, row.median_ms as f32]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Line { name, points }
    };
    let lines: Vec<_> = names(rows.iter().copied()).into_iter().map(line).collect();
    let fixed: Vec<_> =
        others().map(|(_, other)| format!("{} {}", other.label, (other.value)(first))).collect();
    let label = format!("{} ({})", sweep.label, fixed.join(", "));
    Some(plot::lines(&lines, &label, "ms a generation", PLOT))
}

/// All times of each way of measuring, where everything else has its first value; nothing where there
/// is one way alone.
fn plot_methods(rows: &[Row]) -> Option<Result<String, String>> {
    let first = rows.first()?;
    let same = |row: &&Row| {
        row.work.rigs == first.work.rigs
            && SWEEPS.iter().all(|sweep| (sweep.value)(row) == (sweep.value)(first))
    };
    let names = names(rows);
    let times = |name: &String| -> Vec<f32> {
        let own = rows.iter().filter(same).filter(|row| row.setup.name() == *name);
        own.flat_map(|row| row.walls.iter().map(|&wall| wall as f32)).collect()
    };
    let times: Vec<_> = names.iter().map(times).collect();
    let settings: Vec<_> = names
        .iter()
        .zip(&times)
        .map(|(label, values)| Setting { label, values, standard: false })
        .collect();
    let fixed: Vec<_> =
        SWEEPS.iter().map(|s| format!("{} {}", s.label, (s.value)(first))).collect();
    let panel = Panel { name: &fixed.join(", "), settings: &settings };
    (names.len() > 1).then(|| plot::sweep(&[panel], "ms a generation", PLOT))
}

/// Stages in a line.
const STAGES: usize = 4;

/// The benchmark for people.
pub fn show(bench: &Bench) -> String {
    let mut text = String::new();
    for scene in &bench.scenes {
        let (name, triangles, instances) = (&scene.scene, scene.triangles, scene.instances);
        text += &format!(
            "{name}: {triangles} triangles, instances: {instances}, ready in {:.0} ms\n",
            scene.load_ms
        );
    }
    let (setups, times, costs) = (setups(&bench.rows), times(&bench.rows), costs(&bench.rows));
    text += &format!("\n{setups}\n\n{times}\n\n{costs}\n");
    let timed = |(_, row): &(usize, &Row)| !row.stages_ms.is_empty();
    for (number, row) in (1..).zip(&bench.rows).filter(timed) {
        let time = |ms: &serde_json::Value| ms.as_f64().unwrap_or_default();
        let stages = row.stages_ms.iter().map(|(stage, ms)| format!("{stage} {:.3}", time(ms)));
        let stages: Vec<_> = stages.collect();
        let lines: Vec<_> = stages.chunks(STAGES).map(|stages| stages.join(", ")).collect();
        text += &format!("\nrow {number}, GPU ms:\n  {}\n", lines.join(",\n  "));
    }
    let wide = bench.rows.iter().filter(|row| !row.is_stable(bench.precision)).count();
    if wide > 0 {
        let (percent, all) = (100.0 * bench.precision, bench.rows.len());
        text += &format!(
            "\n{wide} of {all} medians are known less well than to {percent} %: give them\n\
             more --runs and --seconds, or a quieter machine.\n"
        );
    }
    text
}

/// What the rows measure; other tables name them by their numbers.
fn setups(rows: &[Row]) -> comfy_table::Table {
    let names = ["row", "method", "triangles", "size", "lights", "N", "rigs", "object pixels"];
    let mut table = print::columns(&names, &[]);
    for (number, row) in (1..).zip(rows) {
        table.add_row([
            number.to_string(),
            row.setup.name(),
            row.setup.triangles.to_string(),
            Size(row.setup.size).to_string(),
            row.work.lights.to_string(),
            row.work.population.to_string(),
            row.work.rigs.to_string(),
            row.setup.object_pixels.to_string(),
        ]);
    }
    table
}

fn known(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".into(), |value| format!("{value:.digits$}"))
}

fn times(rows: &[Row]) -> comfy_table::Table {
    let names = ["row", "runs", "median\nms", "± %", "p95\nms", "GPU\nms"];
    let more = ["evaluations\n/s", "M light-\npixels/s"];
    let mut table = print::columns(&names, &more);
    for (number, row) in (1..).zip(rows) {
        table.add_row([
            number.to_string(),
            row.runs.to_string(),
            format!("{:.3}", row.median_ms),
            known(row.spread().map(|spread| 100.0 * spread), 1),
            format!("{:.3}", row.p95_ms),
            known(row.gpu_ms, 3),
            format!("{:.0}", row.evaluations_per_second),
            format!("{:.1}", row.light_pixels_per_second * 1e-6),
        ]);
    }
    table
}

/// Operations, one-off costs and memory.
fn costs(rows: &[Row]) -> comfy_table::Table {
    let names = ["row", "GFLOP/s", "of floor", "ceiling\nGop/s"];
    let more = ["maps\nms", "first\nms", "host\nMiB", "device\nMiB"];
    let mut table = print::columns(&names, &more);
    let mebibytes = |bytes: Option<u64>| bytes.map_or("–".into(), |b| (b >> 20).to_string());
    for (number, row) in (1..).zip(rows) {
        table.add_row([
            number.to_string(),
            known(row.gflops, 1),
            row.floor_share.map_or("–".into(), |share| format!("{:.0} %", 100.0 * share)),
            known(row.setup.ceiling.map(|ceiling| ceiling.plain * 1e-9), 0),
            format!("{:.0}", row.setup.maps_ms),
            format!("{:.1}", row.first_ms),
            mebibytes(row.host_bytes),
            mebibytes(row.device_bytes),
        ]);
    }
    table
}
