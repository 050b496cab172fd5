//! Devices.

use crate::error::OrRaise as _;
use crate::settings::Settings;
use klieg::session::device::{self, Opened};
use klieg::session::values;
use pyo3::prelude::*;

/// A device that is open.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct Device(pub Opened);

#[pymethods]
impl Device {
    /// Opens the device of the settings.
    #[new]
    fn new(py: Python<'_>, settings: &Settings) -> PyResult<Self> {
        let Settings(settings) = settings;
        py.detach(|| device::open(&settings.device, settings)).or_raise().map(Self)
    }

    /// Name, kind and driver.
    fn info(&self) -> (String, &'static str, String) {
        let info = match &self.0 {
            Opened::Cpu => klieg::cpu::device(),
            Opened::Vulkan(stored) => stored.context.report().info.clone(),
        };
        (info.name, info.kind, info.driver)
    }
}

/// Number, name, kind and driver of each device, what each lacks to run klieg, and whether `auto` is it.
type Entry = (usize, String, &'static str, String, Vec<String>, bool);

/// All devices of this machine.
#[pyfunction]
pub fn devices(py: Python<'_>) -> PyResult<Vec<Entry>> {
    let (reports, _) = py.detach(device::list);
    let auto = match device::choose(&values::Device::Auto, &reports).or_raise()? {
        device::Chosen::Cpu => reports.len(),
        device::Chosen::Vulkan(index) => index,
    };
    let native = (reports.len(), klieg::cpu::device(), Vec::new());
    let vulkan = reports.into_iter().map(|r| (r.index, r.info, lacks(&r.lacks)));
    let entry = |(index, info, lacks): (usize, klieg::evaluate::DeviceInfo, Vec<String>)| {
        (index, info.name, info.kind, info.driver, lacks, index == auto)
    };
    Ok(vulkan.chain([native]).map(entry).collect())
}

fn lacks<T: ToString>(lacks: &[T]) -> Vec<String> {
    lacks.iter().map(ToString::to_string).collect()
}
