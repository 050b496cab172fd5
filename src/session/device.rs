//! From the name of a device to the device.
//!
//! Devices are numbered as `klieg devices` lists them: Vulkan devices in the driver's order, then the
//! native CPU evaluator.

use super::config::Settings;
use super::describe;
use super::pipelines::{self, Stored};
use super::values::Device;
use super::warn;
use crate::evaluate::DeviceInfo;
use crate::gpu::{self, Context, ContextOptions, DeviceChoice, DeviceReport, Tuning};
use crate::{Error, Result};
use std::sync::Arc;

/// A device that is ready for an evaluator.
#[derive(Clone)]
pub enum Opened {
    /// The native CPU evaluator.
    Cpu,
    /// A Vulkan device, whose pipelines are stored when its last user has gone.
    Vulkan(Arc<Stored>),
}

/// What a [`Device`] stands for on this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chosen {
    /// The native CPU evaluator.
    Cpu,
    /// The Vulkan device of this number.
    Vulkan(usize),
}

/// All Vulkan devices, and why there are none where Vulkan itself is missing.
pub fn list() -> (Vec<DeviceReport>, Option<Error>) {
    match gpu::devices() {
        Ok(reports) => (reports, None),
        Err(fault) => (Vec::new(), Some(fault)),
    }
}

/// Opens the device that `device` names, for evaluators with the pipeline and the memory of `settings`; where one
/// fails that nobody has named, that is the CPU.
///
/// # Errors
/// [`Error::Argument`] for a device that is not there, and what opening it reports.
pub fn open(device: &Device, settings: &Settings) -> Result<Opened> {
    match open_named(device, settings) {
        Err(fault) if *device == Device::Auto => {
            warn(&[format!("{fault}: the CPU takes its place")]);
            Ok(Opened::Cpu)
        }
        opened => opened,
    }
}

fn open_named(device: &Device, settings: &Settings) -> Result<Opened> {
    if *device == Device::Cpu {
        return Ok(Opened::Cpu);
    }
    let (reports, fault) = list();
    match (choose(device, &reports), fault) {
        (Ok(Chosen::Cpu), _) => Ok(Opened::Cpu),
        (Ok(Chosen::Vulkan(index)), _) => {
            let folder = pipelines::folder();
            let earlier = folder.as_deref().map_or_else(Vec::new, |folder| {
                pipelines::load(folder, reports[index].pipeline_cache_key)
            });
            let tuning = Tuning {
                pipeline_cache: earlier.clone(),
                pipeline: settings.pipeline.kind(),
                picture_memory: settings.memory.map(|mebibytes| u64::from(mebibytes) << 20),
                ..Tuning::default()
            };
            let device = DeviceChoice::Index(index);
            let options = ContextOptions { device, tuning, ..ContextOptions::default() };
            let context = Context::new(&options)?;
            Ok(Opened::Vulkan(Arc::new(Stored::new(context, folder, earlier))))
        }
        (Err(_), Some(no_vulkan)) => Err(no_vulkan),
        (Err(fault), None) => Err(fault),
    }
}

/// What `work` makes with these settings; where a device fails that nobody has named, what it makes on the CPU.
///
/// # Errors
/// Those of `work`.
pub fn or_cpu<T>(
    settings: Settings,
    mut work: impl FnMut(Settings) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    match work(settings.clone()) {
        Err(fault) if settings.device == Device::Auto && is_device(&fault) => {
            let fault = describe(&fault);
            warn(&[format!("{fault}: all is done again on the CPU (--device names another one)")]);
            work(Settings { device: Device::Cpu, ..settings })
        }
        made => made,
    }
}

/// Whether a device is at fault, or Vulkan itself.
pub fn is_device(fault: &anyhow::Error) -> bool {
    let device = |fault: &Error| fault.is_device() || matches!(fault, Error::NoVulkan(_));
    fault.chain().any(|cause| cause.downcast_ref().is_some_and(device))
}

/// Which of `reports`, or the native CPU evaluator, `device` stands for. The best is the first of the
/// most able kind; one that cannot run klieg is taken only where it is named.
///
/// # Errors
/// [`Error::Argument`] for a device that is not there, [`Error::NoVulkan`] without any able one.
pub fn choose(device: &Device, reports: &[DeviceReport]) -> Result<Chosen> {
    let able = || reports.iter().filter(|report| report.lacks.is_empty());
    let best = |kinds: &[&str]| {
        let rank = |report: &&DeviceReport| kinds.iter().position(|kind| *kind == report.info.kind);
        let ranked = able().filter_map(|report| Some((rank(&report)?, report.index)));
        ranked.min().map(|(_, index)| Chosen::Vulkan(index))
    };
    match device {
        Device::Cpu => Ok(Chosen::Cpu),
        Device::Auto => Ok(best(&["discrete", "integrated"]).unwrap_or(Chosen::Cpu)),
        Device::Vulkan => best(&["discrete", "integrated", "virtual", "other", "software"])
            .ok_or_else(|| Error::NoVulkan(unable(reports))),
        Device::Index(index) if *index < reports.len() => Ok(Chosen::Vulkan(*index)),
        Device::Index(index) if *index == reports.len() => Ok(Chosen::Cpu),
        Device::Index(index) => Err(missing(&format!("with number {index}"), reports)),
        Device::Name(part) => by_name(part, reports),
    }
}

fn by_name(part: &str, reports: &[DeviceReport]) -> Result<Chosen> {
    let wanted = part.to_lowercase();
    let named = |info: &DeviceInfo| info.name.to_lowercase().contains(&wanted);
    let mut found: Vec<_> = reports.iter().filter(|report| named(&report.info)).collect();
    found.sort_by_key(|report| !report.lacks.is_empty());
    if let Some(report) = found.first() {
        return Ok(Chosen::Vulkan(report.index));
    }
    if named(&crate::cpu::device()) {
        return Ok(Chosen::Cpu);
    }
    Err(missing(&format!("named '{part}'"), reports))
}

fn missing(what: &str, reports: &[DeviceReport]) -> Error {
    let names = reports.iter().map(|report| report.info.name.clone());
    let names = names.chain([crate::cpu::device().name]).enumerate();
    let names: Vec<_> = names.map(|(i, name)| format!("{i}: {name}")).collect();
    Error::Argument(format!("there is no device {what}; there are {}", names.join(", ")))
}

fn unable(reports: &[DeviceReport]) -> String {
    if reports.is_empty() {
        return "there is no Vulkan device".into();
    }
    let fault = |r: &DeviceReport| format!("{} lacks {}", r.info.name, r.lacks.join(", "));
    reports.iter().map(fault).collect::<Vec<_>>().join("; ")
}
