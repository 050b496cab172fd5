//! What klieg asks of a device, and how an engine enables it.

use super::edge::{Outcome, free_call, given, put};
use super::error::klieg_status;
use crate::gpu::{EnabledFeatures, FeatureChain, Needs, Requirements};
use ash::vk;

/// What an engine will use klieg for, which decides what the device must have: a sum of
/// `KLIEG_NEEDS_...`.
pub type klieg_needs = u32;
/// An engine with pictures or a surface of its own, on pipeline `compute`: no feature and no graphics
/// queue is needed.
pub const KLIEG_NEEDS_COMPUTE: klieg_needs = 0;
/// The device draws scenes (`klieg_evaluator_of_scene`), else the CPU does: a graphics queue and
/// `geometryShader`.
pub const KLIEG_NEEDS_SCENE: klieg_needs = 1;
/// Pipelines `layered` and `forward`: a graphics queue and `shaderOutputLayer`.
pub const KLIEG_NEEDS_LAYERS: klieg_needs = 2;
/// Everything that klieg can do.
pub const KLIEG_NEEDS_ALL: klieg_needs = 3;

/// Features of a device, each `VK_TRUE` or `VK_FALSE`.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct klieg_features {
    /// `VkPhysicalDeviceFeatures::geometryShader`.
    pub geometry_shader: vk::Bool32,
    /// `VkPhysicalDeviceVulkan12Features::shaderOutputLayer`.
    pub shader_output_layer: vk::Bool32,
    /// `VkPhysicalDeviceFeatures::fullDrawIndexUint32`: never required; without it, meshes of a scene
    /// have 2²⁴ vertices at most.
    pub full_draw_index_uint32: vk::Bool32,
    /// Both `VkPhysicalDeviceVulkan13Features::subgroupSizeControl` and `computeFullSubgroups`, of Vulkan
    /// 1.3 or of `VK_EXT_subgroup_size_control`: never required; without it, klieg measures in
    /// `KLIEG_SHAPE_RUNS` on GPUs whose subgroups have several sizes, which is slower.
    pub subgroup_size_control: vk::Bool32,
}

/// Bytes of a name in a structure, its terminating zero included.
pub const KLIEG_NAME_SIZE: usize = 48;
/// Limits in `klieg_requirements`, at most.
pub const KLIEG_MAX_LIMITS: usize = 16;
/// Formats in `klieg_requirements`, at most.
pub const KLIEG_MAX_FORMATS: usize = 8;

/// The least value of a member of `VkPhysicalDeviceLimits`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_limit {
    /// The member's name.
    pub name: [std::ffi::c_char; KLIEG_NAME_SIZE],
    /// The least value.
    pub least: u64,
}

/// What must be possible with images of a format and optimal tiling.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_format {
    /// The format.
    pub format: vk::Format,
    /// What must be possible.
    pub features: vk::FormatFeatureFlags,
}

/// What a device must have.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_requirements {
    /// The least Vulkan version of instance and device, as `VK_MAKE_API_VERSION` gives it.
    pub api_version: u32,
    /// What the queue's family must be able to do.
    pub queue: vk::QueueFlags,
    /// Features that must be enabled.
    pub features: klieg_features,
    /// Entries of `limits`.
    pub limit_count: u32,
    /// Entries of `formats`.
    pub format_count: u32,
    /// Least values of limits.
    pub limits: [klieg_limit; KLIEG_MAX_LIMITS],
    /// Formats.
    pub formats: [klieg_format; KLIEG_MAX_FORMATS],
}

/// Room for what `klieg_enable_features` adds to a chain. Its content is klieg's.
#[repr(C)]
pub struct klieg_feature_chain {
    /// klieg's.
    pub storage: [u64; 64],
}

const _: () = assert!(size_of::<FeatureChain>() <= size_of::<klieg_feature_chain>());
const _: () = assert!(align_of::<FeatureChain>() <= align_of::<klieg_feature_chain>());
const _: () = assert!(!std::mem::needs_drop::<FeatureChain>());

/// Tells what a device must have for `needs`. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_requirements_for(
    needs: klieg_needs,
    requirements: *mut klieg_requirements,
) -> klieg_status {
    free_call(|| {
        let required = as_needs(needs)?.requirements();
        // SAFETY: the caller's pointer.
        unsafe { put(requirements, in_c(&required), "requirements") }
    })
}

/// Enables what `needs` requires in `info`, an engine's own structure: in its own feature structures
/// where these are in the chain, else in ones that are put into `chain` and that `info` then points to.
/// What the engine has enabled stays. Call it last, when `info` is complete; `chain` stays where it is
/// until the device is created. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` when `shaderOutputLayer` is needed and the chain names features of Vulkan 1.2
/// one by one, beside which Vulkan forbids `VkPhysicalDeviceVulkan12Features`, which holds it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_enable_features(
    needs: klieg_needs,
    info: *mut vk::DeviceCreateInfo<'_>,
    chain: *mut klieg_feature_chain,
) -> klieg_status {
    free_call(|| {
        let wanted = as_needs(needs)?.requirements().features;
        // SAFETY: the caller's pointers; the storage is large enough and aligned.
        unsafe {
            given(info, "info")?;
            put(chain.cast(), FeatureChain::new(wanted), "chain")?;
            (*chain.cast::<FeatureChain>()).fill(&mut *info)?;
        }
        Ok(())
    })
}

/// Tells which features a device that is created with `info` has enabled, for
/// `klieg_device::features`. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_enabled_features(
    info: *const vk::DeviceCreateInfo<'_>,
    features: *mut klieg_features,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        unsafe {
            let enabled = EnabledFeatures::of(given(info, "info")?);
            put(features, features_in_c(enabled), "features")
        }
    })
}

pub(super) fn as_needs(needs: klieg_needs) -> Outcome<Needs> {
    match needs & !KLIEG_NEEDS_ALL {
        0 => Ok(Needs {
            scene: needs & KLIEG_NEEDS_SCENE != 0,
            layers: needs & KLIEG_NEEDS_LAYERS != 0,
        }),
        unknown => Err(super::edge::Fault::argument(format!("needs {unknown:#x} are unknown"))),
    }
}

pub(super) fn as_features(features: &klieg_features) -> EnabledFeatures {
    EnabledFeatures {
        geometry_shader: features.geometry_shader != vk::FALSE,
        shader_output_layer: features.shader_output_layer != vk::FALSE,
        full_draw_index_uint32: features.full_draw_index_uint32 != vk::FALSE,
        subgroup_size_control: features.subgroup_size_control != vk::FALSE,
    }
}

fn features_in_c(features: EnabledFeatures) -> klieg_features {
    klieg_features {
        geometry_shader: features.geometry_shader.into(),
        shader_output_layer: features.shader_output_layer.into(),
        full_draw_index_uint32: features.full_draw_index_uint32.into(),
        subgroup_size_control: features.subgroup_size_control.into(),
    }
}

fn in_c(required: &Requirements) -> klieg_requirements {
    let none = klieg_format { format: vk::Format::UNDEFINED, features: Default::default() };
    let mut limits = [klieg_limit { name: [0; KLIEG_NAME_SIZE], least: 0 }; KLIEG_MAX_LIMITS];
    let mut formats = [none; KLIEG_MAX_FORMATS];
    for (to, from) in limits.iter_mut().zip(&required.limits) {
        to.least = from.least;
        let name = from.name.bytes().take(KLIEG_NAME_SIZE - 1);
        to.name.iter_mut().zip(name).for_each(|(to, byte)| *to = byte as std::ffi::c_char);
    }
    for (to, &(format, features)) in formats.iter_mut().zip(&required.formats) {
        *to = klieg_format { format, features };
    }
    klieg_requirements {
        api_version: required.api_version,
        queue: required.queue,
        features: features_in_c(required.features),
        limit_count: required.limits.len() as u32,
        format_count: required.formats.len() as u32,
        limits,
        formats,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requirements_fit_their_arrays() {
        let all = Needs::ALL.requirements();
        assert!(all.limits.len() <= KLIEG_MAX_LIMITS && all.formats.len() <= KLIEG_MAX_FORMATS);
        assert!(all.limits.iter().all(|limit| limit.name.len() < KLIEG_NAME_SIZE));
    }
}
