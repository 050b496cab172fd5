//! `klieg devices`: what can compute here.

mod memory;

use self::memory::{ForOptions, Plan, Search};
use super::device::{self, Chosen};
use super::print;
use super::values::Device;
use crate::evaluate::DeviceInfo;
use crate::gpu::DeviceReport;
use crate::report::json;
use anyhow::Result;
use clap::Args;
use serde::Serialize;

/// List the devices and what they can do for klieg
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    memory: ForOptions,
    /// Print JSON on standard output
    #[arg(long)]
    json: bool,
}

/// What `klieg devices --json` prints.
#[derive(Serialize)]
struct Listing {
    schema: &'static str,
    klieg: &'static str,
    /// Number that `auto` takes.
    auto: usize,
    /// Number that `vulkan` takes; none where no Vulkan device can run klieg.
    vulkan: Option<usize>,
    /// Why there is no Vulkan here.
    no_vulkan: Option<String>,
    /// The search whose memory is told, where one is asked for.
    #[serde(rename = "for", skip_serializing_if = "Option::is_none")]
    search: Option<Search>,
    devices: Vec<Entry>,
}

/// A device; the native CPU evaluator has no Vulkan properties.
#[derive(Serialize)]
#[serde(untagged)]
enum Entry {
    Vulkan {
        #[serde(flatten)]
        report: Box<DeviceReport>,
        /// What each pipeline takes for the search.
        #[serde(skip_serializing_if = "Option::is_none")]
        plans: Option<Vec<Plan>>,
    },
    Cpu {
        index: usize,
        #[serde(flatten)]
        info: DeviceInfo,
        lacks: [String; 0],
    },
}

pub(super) fn run(options: &Options) -> Result<()> {
    let search = options.memory.search()?;
    let (reports, fault) = device::list();
    let cpu = reports.len();
    let number = |chosen| match chosen {
        Chosen::Cpu => cpu,
        Chosen::Vulkan(index) => index,
    };
    let auto = number(device::choose(&Device::Auto, &reports)?);
    let vulkan = device::choose(&Device::Vulkan, &reports).ok().map(number);
    let native = Entry::Cpu { index: cpu, info: crate::cpu::device(), lacks: [] };
    let vulkan_entry = |report: DeviceReport| -> Result<Entry> {
        let plans = search.as_ref().map(|search| search.plans(&report)).transpose()?;
        Ok(Entry::Vulkan { report: Box::new(report), plans })
    };
    let entries: Result<Vec<_>> = reports.into_iter().map(vulkan_entry).collect();
    let listing = Listing {
        schema: "klieg.devices/1",
        klieg: env!("CARGO_PKG_VERSION"),
        auto,
        vulkan,
        no_vulkan: fault.map(|fault| fault.to_string()),
        devices: entries?.into_iter().chain([native]).collect(),
        search,
    };
    if options.json { print::out(json::text(&listing)?) } else { print::out(show(&listing)) }
}

fn show(listing: &Listing) -> String {
    let mut table = print::columns(&["device", "what it is and does"], &[]);
    table.column_iter_mut().for_each(|c| c.set_cell_alignment(comfy_table::CellAlignment::Left));
    for entry in &listing.devices {
        let (index, info, able) = match entry {
            Entry::Vulkan { report, .. } => (report.index, &report.info, abilities(report)),
            Entry::Cpu { index, info, .. } => (*index, info, "runs klieg".into()),
        };
        let mut names = vec![index.to_string()];
        if index == listing.auto {
            names.push("auto".into());
        }
        if Some(index) == listing.vulkan {
            names.push("vulkan".into());
        }
        if matches!(entry, Entry::Cpu { .. }) {
            names.push("cpu".into());
        }
        let DeviceInfo { name, kind, driver } = info;
        table.add_row([names.join(", "), format!("{name}: {kind}, {driver}\n{able}")]);
    }
    let fault = listing.no_vulkan.as_ref().map(|fault| format!("\n{fault}\n"));
    let table = print::wrapped(table);
    let plans = listing.devices.iter().filter_map(|entry| match entry {
        Entry::Vulkan { report, plans: Some(plans) } => Some((report.index, &plans[..])),
        _ => None,
    });
    let memory = listing.search.as_ref().map(|search| format!("\n{}", search.table(plans)));
    format!("{table}\n{}{}", fault.unwrap_or_default(), memory.unwrap_or_default())
}

/// What a Vulkan device can and cannot do.
fn abilities(report: &DeviceReport) -> String {
    if !report.lacks.is_empty() {
        return format!("cannot run klieg: lacks {}", report.lacks.join(", "));
    }
    let timed = if report.timestamps { "timed stages" } else { "no timed stages" };
    let (layers, side) = (report.max_layers, report.max_size);
    let memory = report.memory as f64 / f64::from(1 << 30);
    let (pipeline, reason) = (report.pipeline, report.pipeline_reason);
    let drawing = match report.draws_layers {
        true => format!("{layers} pictures a draw"),
        false => "pipeline compute alone".into(),
    };
    let mut can = format!(
        "runs klieg: {drawing}, {side} pixels a side, {memory:.1} GiB, {timed}\n\
         pipeline {pipeline}: {reason}"
    );
    if !report.draws_scenes {
        can += "\nthe CPU draws the scene for it";
    }
    if !report.lacks_for_drawing.is_empty() {
        can += &format!("\nto draw itself it lacks {}", report.lacks_for_drawing.join(", "));
    }
    can
}
