//! What klieg asks of a Vulkan device, in one place.

use super::choice::Together;
use super::instance::API_VERSION;
use ash::vk;

/// Images of a view and of a generation: format, what is done with it.
const FORMATS: [(vk::Format, &str, vk::FormatFeatureFlags); 4] = [
    (vk::Format::R32_SFLOAT, "R32_SFLOAT", DRAWN_AND_READ),
    (vk::Format::R32_UINT, "R32_UINT", DRAWN_AND_READ),
    (vk::Format::R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", DRAWN_AND_READ),
    (vk::Format::D32_SFLOAT, "D32_SFLOAT", vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT),
];

const DRAWN_AND_READ: vk::FormatFeatureFlags = vk::FormatFeatureFlags::from_raw(
    vk::FormatFeatureFlags::COLOR_ATTACHMENT.as_raw()
        | vk::FormatFeatureFlags::SAMPLED_IMAGE.as_raw()
        | vk::FormatFeatureFlags::STORAGE_IMAGE.as_raw(),
);

/// The least value of each limit: its name, how to read it, and the value.
type Limit = (&'static str, fn(&vk::PhysicalDeviceLimits) -> u64, u64);
const LIMITS: [Limit; 10] = [
    // The surface of the visibility draw.
    ("maxColorAttachments", |l| l.max_color_attachments.into(), 5),
    ("maxFragmentOutputAttachments", |l| l.max_fragment_output_attachments.into(), 5),
    // The same beside the instances and the materials.
    ("maxFragmentCombinedOutputResources", |l| l.max_fragment_combined_output_resources.into(), 7),
    // 16 lights of 6 components as flat varyings, beside the position.
    ("maxVertexOutputComponents", |l| l.max_vertex_output_components.into(), 104),
    ("maxFragmentInputComponents", |l| l.max_fragment_input_components.into(), 96),
    // The bindings of the view's set.
    (
        "maxPerStageDescriptorStorageImages",
        |l| l.max_per_stage_descriptor_storage_images.into(),
        16,
    ),
    (
        "maxPerStageDescriptorStorageBuffers",
        |l| l.max_per_stage_descriptor_storage_buffers.into(),
        16,
    ),
    (
        "maxPerStageDescriptorSampledImages",
        |l| l.max_per_stage_descriptor_sampled_images.into(),
        16,
    ),
    ("maxPerStageResources", |l| l.max_per_stage_resources.into(), 48),
    ("maxComputeWorkGroupInvocations", |l| l.max_compute_work_group_invocations.into(), 128),
];

/// What `device` lacks, in words; empty where klieg can run.
pub(super) fn lacking(instance: &ash::Instance, device: vk::PhysicalDevice) -> Vec<String> {
    // SAFETY: `device` is a physical device of `instance`.
    let properties = unsafe { instance.get_physical_device_properties(device) };
    if properties.api_version < API_VERSION {
        let (major, minor) = (
            vk::api_version_major(properties.api_version),
            vk::api_version_minor(properties.api_version),
        );
        return vec![format!("Vulkan 1.2 (it has {major}.{minor})")];
    }
    let mut lacks = Vec::new();
    let (geometry_shader, output_layer) = features(instance, device);
    if !geometry_shader {
        lacks.push("feature geometryShader (the polygon's number in the fragment shader)".into());
    }
    if !output_layer {
        lacks.push("feature shaderOutputLayer (the layer from the vertex shader)".into());
    }
    lacks.extend(short_limits(&properties.limits));
    for (format, name, needed) in FORMATS {
        // SAFETY: as above.
        let has = unsafe { instance.get_physical_device_format_properties(device, format) };
        let missing = needed & !has.optimal_tiling_features;
        if !missing.is_empty() {
            lacks.push(format!("format {name} as {missing:?}"));
        }
    }
    if queue_family(instance, device).is_none() {
        lacks.push("a queue for both graphics and compute".into());
    }
    lacks
}

/// The limits that are too low, in words.
fn short_limits(limits: &vk::PhysicalDeviceLimits) -> impl Iterator<Item = String> {
    LIMITS.into_iter().filter_map(move |(name, read, least)| {
        let has = read(limits);
        (has < least).then(|| format!("{name} of {least} (it has {has})"))
    })
}

/// Whether the device has `geometryShader` and `shaderOutputLayer`.
fn features(instance: &ash::Instance, device: vk::PhysicalDevice) -> (bool, bool) {
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
    // SAFETY: a Vulkan 1.2 device of `instance`; the chain lives until the call returns.
    unsafe { instance.get_physical_device_features2(device, &mut features) };
    let geometry_shader = features.features.geometry_shader == vk::TRUE;
    (geometry_shader, vulkan12.shader_output_layer == vk::TRUE)
}

/// Whether an index may have any 32-bit value.
pub(super) fn full_indices(instance: &ash::Instance, device: vk::PhysicalDevice) -> bool {
    // SAFETY: `device` is a physical device of `instance`.
    let features = unsafe { instance.get_physical_device_features(device) };
    features.full_draw_index_uint32 == vk::TRUE
}

/// What the invocations of compute shaders can do together; `device` has Vulkan 1.1 or later.
pub(super) fn together(instance: &ash::Instance, device: vk::PhysicalDevice) -> Together {
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
    // SAFETY: `device` is a physical device of `instance`; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(device, &mut chain) };
    let limits = chain.properties.limits;
    let compute = subgroups.supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
    Together {
        subgroup: subgroups.subgroup_size,
        operations: if compute { subgroups.supported_operations } else { Default::default() },
        group: limits.max_compute_work_group_invocations,
        shared: limits.max_compute_shared_memory_size,
    }
}

/// Bytes of the largest single piece of memory that the device, of Vulkan 1.1 or later, can give.
pub(super) fn largest_allocation(instance: &ash::Instance, device: vk::PhysicalDevice) -> u64 {
    let mut limits = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: `device` is a physical device of `instance`; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(device, &mut chain) };
    limits.max_memory_allocation_size
}

/// The first queue family for both graphics and compute, and whether it has timestamps.
pub(super) fn queue_family(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
) -> Option<(u32, bool)> {
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: `device` is a physical device of `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let index = families.iter().position(|family| family.queue_flags.contains(needed))?;
    Some((index as u32, families[index].timestamp_valid_bits > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_that_is_too_low_is_named() {
        let none = vk::PhysicalDeviceLimits::default();
        assert_eq!(short_limits(&none).count(), LIMITS.len());
        let one = vk::PhysicalDeviceLimits { max_color_attachments: 4, ..none };
        let said: Vec<_> = short_limits(&one).collect();
        assert!(said[0].contains("maxColorAttachments of 5 (it has 4)"), "{said:?}");
        let enough = vk::PhysicalDeviceLimits { max_color_attachments: 5, ..none };
        assert_eq!(short_limits(&enough).count(), LIMITS.len() - 1);
    }
}
