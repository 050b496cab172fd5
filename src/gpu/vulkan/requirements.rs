//! What klieg asks of a Vulkan device, in one place: as data, as a check, and as a helper for those
//! who create the device themselves.

use super::choice::Together;
use super::features::{EnabledFeatures, has_extension};
use super::instance::API_VERSION;
use ash::vk;

/// What a client will use klieg for, which decides what the device must have.
///
/// Without either, klieg needs no feature and no graphics queue: enough for an engine that brings its
/// own surface or its own pictures, on pipeline `compute`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// klieg draws a scene itself.
    pub scene: bool,
    /// Pipelines that draw a population's pictures in layers: `layered` and `forward`.
    pub layers: bool,
}

impl Needs {
    /// Everything that klieg can do.
    pub const ALL: Self = Self { scene: true, layers: true };
    /// What an engine with pictures or a surface of its own needs.
    pub const COMPUTE: Self = Self { scene: false, layers: false };

    /// Most to least, of a device that klieg may use as far as it goes.
    const ALL_KINDS: [Self; 4] = [
        Self::ALL,
        Self { scene: true, layers: false },
        Self { scene: false, layers: true },
        Self::COMPUTE,
    ];

    /// Whether klieg draws anything itself.
    pub(in crate::gpu) fn draws(self) -> bool {
        self.scene || self.layers
    }

    /// What the device must have.
    pub fn requirements(self) -> Requirements {
        let drawn = if self.draws() { DRAWN } else { vk::FormatFeatureFlags::empty() };
        let mut formats = COMPUTED.map(|format| (format, READ_AND_WRITTEN | drawn)).to_vec();
        let mut queue = vk::QueueFlags::COMPUTE;
        let mut limits = COMPUTE_LIMITS.to_vec();
        if self.draws() {
            queue |= vk::QueueFlags::GRAPHICS;
            limits.extend(DRAW_LIMITS);
            let depth = vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT;
            formats.push((vk::Format::D32_SFLOAT, depth));
        }
        let features = EnabledFeatures {
            geometry_shader: self.scene,
            shader_output_layer: self.layers,
            ..EnabledFeatures::default()
        };
        Requirements { api_version: API_VERSION, queue, features, limits, formats }
    }
}

/// What a device must have.
#[derive(Debug, Clone)]
pub struct Requirements {
    /// The least version of instance and device.
    pub api_version: u32,
    /// What the queue can do.
    pub queue: vk::QueueFlags,
    /// Features that must be enabled. The others only help: `full_draw_index_uint32` meshes of more than
    /// 2²⁴ vertices, `subgroup_size_control` the speed on GPUs whose subgroups have several sizes.
    pub features: EnabledFeatures,
    /// Least values of limits.
    pub limits: Vec<Limit>,
    /// Formats of images with optimal tiling, and what must be possible with them.
    pub formats: Vec<(vk::Format, vk::FormatFeatureFlags)>,
}

/// The least value of a device limit.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// Its name in Vulkan.
    pub name: &'static str,
    /// The least value.
    pub least: u64,
    /// Finds it among the limits.
    pub read: fn(&vk::PhysicalDeviceLimits) -> u64,
}

const fn limit(
    name: &'static str,
    read: fn(&vk::PhysicalDeviceLimits) -> u64,
    least: u64,
) -> Limit {
    Limit { name, least, read }
}

/// Images that compute shaders write and read, and that draws write.
const COMPUTED: [vk::Format; 3] =
    [vk::Format::R32_SFLOAT, vk::Format::R32_UINT, vk::Format::R32G32B32A32_SFLOAT];
const DRAWN: vk::FormatFeatureFlags = vk::FormatFeatureFlags::COLOR_ATTACHMENT;
const READ_AND_WRITTEN: vk::FormatFeatureFlags = vk::FormatFeatureFlags::from_raw(
    vk::FormatFeatureFlags::SAMPLED_IMAGE.as_raw() | vk::FormatFeatureFlags::STORAGE_IMAGE.as_raw(),
);

/// What the pipeline layouts have at most, as a test finds it in all of them, and the widest work group.
const COMPUTE_LIMITS: [Limit; 5] = [
    limit(
        "maxPerStageDescriptorStorageImages",
        |l| l.max_per_stage_descriptor_storage_images.into(),
        4,
    ),
    limit(
        "maxPerStageDescriptorStorageBuffers",
        |l| l.max_per_stage_descriptor_storage_buffers.into(),
        14,
    ),
    limit(
        "maxPerStageDescriptorSampledImages",
        |l| l.max_per_stage_descriptor_sampled_images.into(),
        16,
    ),
    limit("maxPerStageResources", |l| l.max_per_stage_resources.into(), 37),
    limit("maxComputeWorkGroupInvocations", |l| l.max_compute_work_group_invocations.into(), 256),
];

const DRAW_LIMITS: [Limit; 5] = [
    // The surface of the visibility draw.
    limit("maxColorAttachments", |l| l.max_color_attachments.into(), 5),
    limit("maxFragmentOutputAttachments", |l| l.max_fragment_output_attachments.into(), 5),
    // The same beside the instances and the materials.
    limit(
        "maxFragmentCombinedOutputResources",
        |l| l.max_fragment_combined_output_resources.into(),
        7,
    ),
    // 16 lights of 6 components as flat varyings, beside the position.
    limit("maxVertexOutputComponents", |l| l.max_vertex_output_components.into(), 104),
    limit("maxFragmentInputComponents", |l| l.max_fragment_input_components.into(), 96),
];

/// What a client gives: the version that it uses, what is enabled, and what its queue can do.
#[derive(Debug, Clone, Copy)]
pub(in crate::gpu) struct Given {
    pub api_version: u32,
    pub enabled: EnabledFeatures,
    pub queue: Option<vk::QueueFlags>,
}

impl Given {
    /// All that klieg could get by creating the device itself, with a queue of `family`.
    pub fn by_creation(
        instance: &ash::Instance,
        device: vk::PhysicalDevice,
        queue_family: Option<u32>,
    ) -> Self {
        let family = queue_family.and_then(|family| self::family(instance, device, family));
        Self {
            api_version: API_VERSION,
            enabled: EnabledFeatures::supported(instance, device),
            queue: family.map(|family| family.queue_flags),
        }
    }
}

/// The most that a device can be used for, and what it lacks for everything; for nothing, what it lacks
/// for the least.
pub(in crate::gpu) fn possible(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    given: Given,
) -> (Option<Needs>, Vec<String>) {
    let lacks = |needs| lacking(instance, device, needs, given);
    match Needs::ALL_KINDS.into_iter().find(|&needs| lacks(needs).is_empty()) {
        Some(needs) => (Some(needs), lacks(Needs::ALL)),
        None => (None, lacks(Needs::COMPUTE)),
    }
}

/// What is missing for `needs`, in words; empty where klieg can run.
pub(in crate::gpu) fn lacking(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    needs: Needs,
    given: Given,
) -> Vec<String> {
    let required = needs.requirements();
    // SAFETY: `device` is a physical device of `instance`.
    let properties = unsafe { instance.get_physical_device_properties(device) };
    let version = properties.api_version.min(given.api_version);
    if version < required.api_version {
        let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
        return vec![format!("Vulkan 1.2 (it has {major}.{minor})")];
    }
    let supported = EnabledFeatures::supported(instance, device);
    let mut lacks = short_features(required.features, given.enabled, supported);
    lacks.extend(short_limits(&required.limits, &properties.limits));
    for (format, needed) in required.formats {
        // SAFETY: as above.
        let has = unsafe { instance.get_physical_device_format_properties(device, format) };
        let missing = needed & !has.optimal_tiling_features;
        if !missing.is_empty() {
            lacks.push(format!("format {format:?} as {missing:?}"));
        }
    }
    if !given.queue.is_some_and(|queue| queue.contains(required.queue)) {
        lacks.push(match needs.draws() {
            true => "a queue for both graphics and compute".into(),
            false => "a queue for compute".into(),
        });
    }
    lacks
}

/// The features that are not enabled, in words.
fn short_features(
    required: EnabledFeatures,
    enabled: EnabledFeatures,
    supported: EnabledFeatures,
) -> Vec<String> {
    let said = |name: &str, why: &str, supported: bool| match supported {
        true => format!("feature {name} ({why}), which it has but which is not enabled"),
        false => format!("feature {name} ({why})"),
    };
    let mut lacks = Vec::new();
    if required.geometry_shader && !enabled.geometry_shader {
        let why = "the polygon's number in the fragment shader";
        lacks.push(said("geometryShader", why, supported.geometry_shader));
    }
    if required.shader_output_layer && !enabled.shader_output_layer {
        let why = "the layer from the vertex shader";
        lacks.push(said("shaderOutputLayer", why, supported.shader_output_layer));
    }
    lacks
}

/// The limits that are too low, in words.
fn short_limits(
    required: &[Limit],
    limits: &vk::PhysicalDeviceLimits,
) -> impl Iterator<Item = String> {
    required.iter().filter_map(move |Limit { name, least, read }| {
        let has = read(limits);
        (has < *least).then(|| format!("{name} of {least} (it has {has})"))
    })
}

/// What the invocations of compute shaders can do together on a device of Vulkan 1.1 or later, used by an
/// instance of `api_version` and with the given features enabled.
pub(in crate::gpu) fn together(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    (api_version, enabled): (u32, EnabledFeatures),
) -> Together {
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    let mut sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
    // SAFETY: `device` is a physical device of `instance`.
    let version = unsafe { instance.get_physical_device_properties(device) }.api_version;
    let tells_sizes = version.min(api_version) >= vk::API_VERSION_1_3
        || has_extension(instance, device, vk::EXT_SUBGROUP_SIZE_CONTROL_NAME);
    if tells_sizes {
        chain = chain.push_next(&mut sizes);
    }
    // SAFETY: as above; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(device, &mut chain) };
    let limits = chain.properties.limits;
    let compute = subgroups.supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
    Together {
        subgroup: subgroups.subgroup_size,
        subgroup_range: tells_sizes.then_some([sizes.min_subgroup_size, sizes.max_subgroup_size]),
        required_subgroups: match enabled.subgroup_size_control
            && sizes.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE)
        {
            true => sizes.max_compute_workgroup_subgroups,
            false => 0,
        },
        operations: if compute { subgroups.supported_operations } else { Default::default() },
        group: limits.max_compute_work_group_invocations,
        shared: limits.max_compute_shared_memory_size,
    }
}

/// Bytes of the largest single piece of memory that the device, of Vulkan 1.1 or later, can give.
pub(in crate::gpu) fn largest_allocation(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
) -> u64 {
    let mut limits = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: `device` is a physical device of `instance`; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(device, &mut chain) };
    limits.max_memory_allocation_size
}

/// The first queue family for both graphics and compute, else the first for compute.
pub(in crate::gpu) fn queue_family(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
) -> Option<u32> {
    // SAFETY: `device` is a physical device of `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let first = |needs: Needs| {
        let needed = needs.requirements().queue;
        families.iter().position(|family| family.queue_flags.contains(needed))
    };
    first(Needs::ALL).or_else(|| first(Needs::COMPUTE)).map(|index| index as u32)
}

/// A queue family, where there is one of that number.
pub(in crate::gpu) fn family(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    family: u32,
) -> Option<vk::QueueFamilyProperties> {
    // SAFETY: `device` is a physical device of `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    families.get(family as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_that_is_too_low_is_named() {
        let required = Needs::ALL.requirements().limits;
        let none = vk::PhysicalDeviceLimits::default();
        assert_eq!(short_limits(&required, &none).count(), required.len());
        let one = vk::PhysicalDeviceLimits { max_color_attachments: 4, ..none };
        let said: Vec<_> = short_limits(&required, &one).collect();
        let words = "maxColorAttachments of 5 (it has 4)".to_owned();
        assert!(said.contains(&words), "{said:?}");
        let enough = vk::PhysicalDeviceLimits { max_color_attachments: 5, ..none };
        assert_eq!(short_limits(&required, &enough).count(), required.len() - 1);
    }

    #[test]
    fn every_feature_that_is_not_enabled_is_named() {
        let all = Needs::ALL.requirements().features;
        let none = EnabledFeatures::default();
        let said = short_features(all, none, EnabledFeatures { geometry_shader: true, ..none });
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].contains("geometryShader") && said[0].contains("not enabled"), "{said:?}");
        assert!(said[1].contains("shaderOutputLayer") && !said[1].contains("enabled"), "{said:?}");
        assert_eq!(short_features(all, all, all), [""; 0]);
        let compute = Needs::COMPUTE.requirements();
        assert_eq!(short_features(compute.features, none, none), [""; 0]);
        assert_eq!(compute.queue, vk::QueueFlags::COMPUTE);
    }
}
