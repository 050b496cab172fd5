//! Which Vulkan devices there are, and which of them is taken.

use super::choice::{ComputeShape, PipelineKind, ShadowMaker, Together};
use super::instance::OwnedInstance;
use super::pipeline_cache;
use super::requirements::{self, Given, Needs};
use crate::evaluate::DeviceInfo;
use crate::gpu::vulkan::Call;
use crate::{Error, Result};
use ash::vk;
use serde::Serialize;
use std::ffi::CStr;

/// Which device a [`crate::gpu::Context`] is made on.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The best: discrete before integrated, virtual, software; the first of equals.
    #[default]
    Best,
    /// The device with this index in [`devices`].
    Index(usize),
    /// The best device whose name contains this, in any case.
    Name(String),
}

/// A device, and whether it will do.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceReport {
    /// Index for [`DeviceChoice::Index`].
    pub index: usize,
    /// Name, type and driver.
    #[serde(flatten)]
    pub info: DeviceInfo,
    /// Vulkan version, such as `1.3.238`.
    pub api_version: String,
    /// Pictures that one draw can make at most.
    pub max_layers: u32,
    /// Pixels of a picture's side at most.
    pub max_size: u32,
    /// Bytes of device-local memory.
    pub memory: u64,
    /// Whether the stages can be timed.
    pub timestamps: bool,
    /// Invocations of a subgroup, as the device reports them.
    pub subgroup_size: u32,
    /// Invocations of a subgroup of [`ComputeShape::Tiles`]; `None` where that cannot run.
    pub tiles_subgroup: Option<u32>,
    /// The fastest pipeline.
    pub pipeline: PipelineKind,
    /// Its shape, where it is [`PipelineKind::Compute`].
    pub shape: ComputeShape,
    /// Why.
    pub pipeline_reason: &'static str,
    /// Who makes shadow tables.
    pub shadow_maker: ShadowMaker,
    /// Why.
    pub shadow_reason: &'static str,
    /// Names what [`Context::pipeline_cache_data`](crate::gpu::Context::pipeline_cache_data) is good for: the
    /// device with its driver, and this version of klieg.
    #[serde(skip)]
    pub pipeline_cache_key: u64,
    /// Whether it draws scenes; where it does not, the CPU draws them for it.
    pub draws_scenes: bool,
    /// Whether it draws a population's pictures in layers: pipelines `layered` and `forward`.
    pub draws_layers: bool,
    /// What it lacks for what it does not draw, in words.
    pub lacks_for_drawing: Vec<String>,
    /// What it lacks for klieg, in words; empty where klieg can run.
    pub lacks: Vec<String>,
}

/// All Vulkan devices of the machine, in the driver's order.
///
/// # Errors
/// [`Error::NoVulkan`] without a Vulkan loader.
pub fn devices() -> Result<Vec<DeviceReport>> {
    let instance = OwnedInstance::new(false)?;
    all_reports(&instance.raw).map(|(_, reports)| reports)
}

fn all_reports(instance: &ash::Instance) -> Result<(Vec<vk::PhysicalDevice>, Vec<DeviceReport>)> {
    // SAFETY: the instance is alive.
    let physical =
        unsafe { instance.enumerate_physical_devices() }.call("vkEnumeratePhysicalDevices")?;
    let report = |(index, &device)| {
        let family = requirements::queue_family(instance, device);
        let given = Given::by_creation(instance, device, family);
        report(instance, (index, device), family, given)
    };
    let reports = physical.iter().enumerate().map(report).collect();
    Ok((physical, reports))
}

/// The chosen device, able to run klieg.
///
/// # Errors
/// [`Error::NoVulkan`] without any device, [`Error::Argument`] for one that is not there,
/// [`Error::Unsupported`] where it lacks something.
pub(in crate::gpu) fn choose(
    instance: &ash::Instance,
    choice: &DeviceChoice,
) -> Result<(vk::PhysicalDevice, DeviceReport)> {
    let (physical, reports) = all_reports(instance)?;
    let found = find(&reports, choice)?;
    let report = reports[found].clone();
    if !report.lacks.is_empty() {
        return Err(Error::Unsupported {
            device: report.info.name,
            lacks: format!("it lacks {}", report.lacks.join("; ")),
        });
    }
    Ok((physical[found], report))
}

/// The index of the chosen device. A device that can run klieg goes before one that cannot.
fn find(reports: &[DeviceReport], choice: &DeviceChoice) -> Result<usize> {
    if reports.is_empty() {
        return Err(Error::NoVulkan("there is no Vulkan device".into()));
    }
    let best = |candidates: &mut dyn Iterator<Item = &DeviceReport>| {
        candidates.min_by_key(|r| (!r.lacks.is_empty(), rank(r.info.kind))).map(|r| r.index)
    };
    let names = || {
        let named = |r: &DeviceReport| format!("{}: {}", r.index, r.info.name);
        reports.iter().map(named).collect::<Vec<_>>().join(", ")
    };
    let found = match choice {
        DeviceChoice::Best => best(&mut reports.iter()),
        DeviceChoice::Index(index) => (*index < reports.len()).then_some(*index),
        DeviceChoice::Name(part) => {
            let part = part.to_lowercase();
            best(&mut reports.iter().filter(|r| r.info.name.to_lowercase().contains(&part)))
        }
    };
    found.ok_or_else(|| match choice {
        DeviceChoice::Name(part) => {
            Error::Argument(format!("no Vulkan device is named '{part}'; there are {}", names()))
        }
        DeviceChoice::Index(index) => {
            Error::Argument(format!("there is no Vulkan device {index}; there are {}", names()))
        }
        DeviceChoice::Best => Error::NoVulkan("there is no Vulkan device".into()),
    })
}

fn rank(kind: &str) -> usize {
    let order = ["discrete", "integrated", "virtual", "other"];
    order.iter().position(|&k| k == kind).unwrap_or(order.len())
}

/// What a device can do with a queue of `family` and with what is `given`; what it lacks, if created by
/// klieg.
pub(in crate::gpu) fn report(
    instance: &ash::Instance,
    (index, device): (usize, vk::PhysicalDevice),
    family: Option<u32>,
    given: Given,
) -> DeviceReport {
    // SAFETY: `device` is a physical device of the living instance.
    let (properties, memory) = unsafe {
        (
            instance.get_physical_device_properties(device),
            instance.get_physical_device_memory_properties(device),
        )
    };
    let limits = &properties.limits;
    let version = properties.api_version;
    let (together, pipeline_cache_key) = match version >= vk::API_VERSION_1_1 {
        true => (
            requirements::together(instance, device, (given.api_version, given.enabled)),
            pipeline_cache::key(instance, device),
        ),
        false => (Together::default(), 0),
    };
    let software = properties.device_type == vk::PhysicalDeviceType::CPU;
    let (shape, pipeline_reason) = ComputeShape::best(software, together);
    let (shadow_maker, shadow_reason) = ShadowMaker::best(software);
    let heaps = &memory.memory_heaps[..memory.memory_heap_count as usize];
    let created =
        Given::by_creation(instance, device, requirements::queue_family(instance, device));
    let (needs, lacks) = requirements::possible(instance, device, created);
    let (lacks_for_drawing, lacks) = match needs {
        Some(_) => (lacks, Vec::new()),
        None => (Vec::new(), lacks),
    };
    let needs = needs.unwrap_or(Needs::COMPUTE);
    DeviceReport {
        index,
        info: info(instance, device, &properties),
        api_version: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        max_layers: limits.max_framebuffer_layers.min(limits.max_image_array_layers),
        max_size: limits
            .max_image_dimension2_d
            .min(limits.max_framebuffer_width)
            .min(limits.max_framebuffer_height)
            .min(limits.max_viewport_dimensions[0])
            .min(limits.max_viewport_dimensions[1]),
        memory: heaps
            .iter()
            .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|heap| heap.size)
            .max()
            .unwrap_or(0),
        timestamps: family
            .and_then(|family| requirements::family(instance, device, family))
            .is_some_and(|family| family.timestamp_valid_bits > 0),
        subgroup_size: together.subgroup,
        tiles_subgroup: ComputeShape::tiles(together).ok().map(|subgroups| subgroups.size),
        pipeline: PipelineKind::Compute,
        shape,
        pipeline_reason,
        shadow_maker,
        shadow_reason,
        pipeline_cache_key,
        draws_scenes: needs.scene,
        draws_layers: needs.layers,
        lacks_for_drawing,
        lacks,
    }
}

fn info(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
) -> DeviceInfo {
    let text = |s: Result<&CStr, _>| s.map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let mut driver = format!("{:#x}", properties.driver_version);
    if properties.api_version >= vk::API_VERSION_1_2 {
        let mut details = vk::PhysicalDeviceDriverProperties::default();
        let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut details);
        // SAFETY: a Vulkan 1.2 device of the living instance; the chain outlives the call.
        unsafe { instance.get_physical_device_properties2(device, &mut chain) };
        let name = text(details.driver_name_as_c_str());
        driver = format!("{name} {}", text(details.driver_info_as_c_str())).trim().to_owned();
    }
    let kind = match properties.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "software",
        _ => "other",
    };
    DeviceInfo { name: text(properties.device_name_as_c_str()), kind, driver }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(index: usize, name: &str, kind: &'static str, lacks: &[&str]) -> DeviceReport {
        DeviceReport {
            index,
            info: DeviceInfo { name: name.into(), kind, driver: String::new() },
            api_version: "1.3.0".into(),
            max_layers: 2048,
            max_size: 16384,
            memory: 0,
            timestamps: true,
            subgroup_size: 32,
            tiles_subgroup: Some(32),
            pipeline: PipelineKind::Compute,
            shape: ComputeShape::Tiles,
            pipeline_reason: "",
            shadow_maker: ShadowMaker::Device,
            shadow_reason: "",
            pipeline_cache_key: 0,
            draws_scenes: true,
            draws_layers: true,
            lacks_for_drawing: Vec::new(),
            lacks: lacks.iter().map(ToString::to_string).collect(),
        }
    }

    #[test]
    fn the_best_device_is_discrete_and_able() {
        let reports = [
            report(0, "Soft One", "software", &[]),
            report(1, "Built In", "integrated", &[]),
            report(2, "Old Card", "discrete", &["something"]),
            report(3, "New Card", "discrete", &[]),
            report(4, "Other Card", "discrete", &[]),
        ];
        let name = |part: &str| DeviceChoice::Name(part.into());
        for (choice, expected) in [
            (DeviceChoice::Best, 3),
            (DeviceChoice::Index(2), 2),
            (name("card"), 3),
            (name("OLD"), 2),
            (name("other"), 4),
            (name("soft"), 0),
        ] {
            assert_eq!(find(&reports, &choice).ok(), Some(expected), "{choice:?}");
        }
        assert_eq!(find(&reports[..3], &DeviceChoice::Best).ok(), Some(1));
        assert!(matches!(find(&reports, &name("none")), Err(Error::Argument(_))));
        assert!(matches!(find(&reports, &DeviceChoice::Index(5)), Err(Error::Argument(_))));
        assert!(matches!(find(&[], &DeviceChoice::Best), Err(Error::NoVulkan(_))));
    }
}
