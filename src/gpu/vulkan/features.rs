//! The features of a device that klieg can use: which are enabled, and how an engine enables them.

use crate::{Error, Result};
use ash::vk;
use std::ffi::CStr;

/// Features of a device, as `VkPhysicalDeviceFeatures`, `VkPhysicalDeviceVulkan12Features` and
/// `VkPhysicalDeviceVulkan13Features` name them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EnabledFeatures {
    /// `geometryShader`: a fragment shader knows the polygon's number.
    pub geometry_shader: bool,
    /// `shaderOutputLayer`: a vertex shader chooses the layer.
    pub shader_output_layer: bool,
    /// `fullDrawIndexUint32`: meshes of more than 2²⁴ vertices.
    pub full_draw_index_uint32: bool,
    /// `subgroupSizeControl` and `computeFullSubgroups`, of Vulkan 1.3 or the enabled extension
    /// `VK_EXT_subgroup_size_control`: [`ComputeShape::Tiles`](crate::gpu::ComputeShape::Tiles) on devices
    /// whose subgroups have several sizes.
    pub subgroup_size_control: bool,
}

impl EnabledFeatures {
    /// The features of a device that was created with `info`.
    ///
    /// # Safety
    /// `info` and what it points to are valid.
    pub unsafe fn of(info: &vk::DeviceCreateInfo<'_>) -> Self {
        let mut found = Self::default();
        // SAFETY: the caller's promise.
        unsafe {
            if let Some(core) = info.p_enabled_features.as_ref() {
                found.read_core(core);
            }
            for link in links(info) {
                match link {
                    Link::Core(core) => found.read_core(&*core),
                    Link::Vulkan12(vulkan12) => {
                        found.shader_output_layer = (*vulkan12).shader_output_layer == vk::TRUE;
                    }
                    Link::Vulkan13(vulkan13) => {
                        found.subgroup_size_control = (*vulkan13).subgroup_size_control == vk::TRUE
                            && (*vulkan13).compute_full_subgroups == vk::TRUE;
                    }
                    Link::SubgroupSize(control) => found.read_control(&*control),
                    Link::Promoted => {}
                }
            }
        }
        found
    }

    fn read_control(&mut self, control: &vk::PhysicalDeviceSubgroupSizeControlFeatures<'_>) {
        self.subgroup_size_control =
            control.subgroup_size_control == vk::TRUE && control.compute_full_subgroups == vk::TRUE;
    }

    fn read_core(&mut self, core: &vk::PhysicalDeviceFeatures) {
        self.geometry_shader = core.geometry_shader == vk::TRUE;
        self.full_draw_index_uint32 = core.full_draw_index_uint32 == vk::TRUE;
    }

    fn write_core(self, core: &mut vk::PhysicalDeviceFeatures) {
        core.geometry_shader |= vk::Bool32::from(self.geometry_shader);
        core.full_draw_index_uint32 |= vk::Bool32::from(self.full_draw_index_uint32);
    }

    /// What a device has.
    pub(in crate::gpu) fn supported(instance: &ash::Instance, device: vk::PhysicalDevice) -> Self {
        // SAFETY: `device` is a physical device of `instance`.
        let version = unsafe { instance.get_physical_device_properties(device) }.api_version;
        let mut found = Self::default();
        if version < vk::API_VERSION_1_2 {
            // SAFETY: as above.
            found.read_core(&unsafe { instance.get_physical_device_features(device) });
            return found;
        }
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut control = vk::PhysicalDeviceSubgroupSizeControlFeatures::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
        if has_extension(instance, device, vk::EXT_SUBGROUP_SIZE_CONTROL_NAME) {
            features = features.push_next(&mut control);
        }
        // SAFETY: a Vulkan 1.2 device of `instance`; the chain lives until the call returns.
        unsafe { instance.get_physical_device_features2(device, &mut features) };
        found.read_core(&features.features);
        found.read_control(&control);
        found.shader_output_layer = vulkan12.shader_output_layer == vk::TRUE;
        found
    }
}

/// Adds features to the chain of an engine's `VkDeviceCreateInfo`. It holds what the chain lacks, so it
/// stays where it is, and alive, until the device is created.
pub struct FeatureChain {
    wanted: EnabledFeatures,
    core: vk::PhysicalDeviceFeatures,
    vulkan12: vk::PhysicalDeviceVulkan12Features<'static>,
    control: vk::PhysicalDeviceSubgroupSizeControlFeatures<'static>,
}

impl FeatureChain {
    /// For the given features, such as those of [`Needs::requirements`](crate::gpu::Needs::requirements).
    pub fn new(wanted: EnabledFeatures) -> Self {
        let (core, vulkan12, control) = Default::default();
        Self { wanted, core, vulkan12, control }
    }

    /// Enables the features in `info`: in its own structures where these are in the chain, else in
    /// ones of this chain, which it then points to. Call it last, when the chain is complete.
    ///
    /// # Errors
    /// [`Error::Argument`] when `shaderOutputLayer` is wanted and the chain names features of Vulkan
    /// 1.2 one by one, beside which Vulkan forbids the structure that holds it.
    ///
    /// # Safety
    /// `info` and what it points to are valid, and its chain may be written to. `info` is not used
    /// after this chain is dropped or moved.
    pub unsafe fn fill(&mut self, info: &mut vk::DeviceCreateInfo<'_>) -> Result<()> {
        let wanted = self.wanted;
        let (mut core, mut vulkan12, mut control, mut promoted) = (false, false, false, false);
        // SAFETY: the caller's promise; no reference into the chain is alive.
        unsafe {
            for link in links(info) {
                match link {
                    Link::Core(features) => {
                        wanted.write_core(&mut *features);
                        core = true;
                    }
                    Link::Vulkan12(features) => {
                        (*features).shader_output_layer |= u32::from(wanted.shader_output_layer);
                        vulkan12 = true;
                    }
                    Link::Vulkan13(features) => {
                        let wanted = u32::from(wanted.subgroup_size_control);
                        (*features).subgroup_size_control |= wanted;
                        (*features).compute_full_subgroups |= wanted;
                        control = true;
                    }
                    Link::SubgroupSize(features) => {
                        let wanted = u32::from(wanted.subgroup_size_control);
                        (*features).subgroup_size_control |= wanted;
                        (*features).compute_full_subgroups |= wanted;
                        control = true;
                    }
                    Link::Promoted => promoted = true,
                }
            }
            if !core {
                if let Some(given) = info.p_enabled_features.as_ref() {
                    self.core = *given;
                }
                wanted.write_core(&mut self.core);
                info.p_enabled_features = &raw const self.core;
            }
        }
        if wanted.shader_output_layer && !vulkan12 {
            if promoted {
                let fault = "shaderOutputLayer is a member of VkPhysicalDeviceVulkan12Features, \
                             which this device's chain must use for all features of Vulkan 1.2";
                return Err(Error::Argument(fault.into()));
            }
            self.vulkan12.shader_output_layer = vk::TRUE;
            self.vulkan12.p_next = info.p_next.cast_mut();
            info.p_next = (&raw mut self.vulkan12).cast_const().cast();
        }
        if wanted.subgroup_size_control && !control {
            self.control.subgroup_size_control = vk::TRUE;
            self.control.compute_full_subgroups = vk::TRUE;
            self.control.p_next = info.p_next.cast_mut();
            info.p_next = (&raw mut self.control).cast_const().cast();
        }
        Ok(())
    }
}

/// A structure of a chain, which the chain's owner may read, and write where it may be written to.
#[derive(Clone, Copy)]
enum Link {
    Core(*mut vk::PhysicalDeviceFeatures),
    Vulkan12(*mut vk::PhysicalDeviceVulkan12Features<'static>),
    Vulkan13(*mut vk::PhysicalDeviceVulkan13Features<'static>),
    SubgroupSize(*mut vk::PhysicalDeviceSubgroupSizeControlFeatures<'static>),
    /// Features of Vulkan 1.2 that have a structure of their own.
    Promoted,
}

/// The structures of features in the chain. They are pointers, as a chain that is only read is shared.
///
/// # Safety
/// The chain is valid.
unsafe fn links(info: &vk::DeviceCreateInfo<'_>) -> Vec<Link> {
    let mut found = Vec::new();
    let mut next = info.p_next.cast_mut().cast::<vk::BaseOutStructure<'_>>();
    while !next.is_null() {
        // SAFETY: every structure of a chain begins with its type and the next one's address.
        let (kind, after) = unsafe { ((*next).s_type, (*next).p_next) };
        match kind {
            vk::StructureType::PHYSICAL_DEVICE_FEATURES_2 => {
                let features = next.cast::<vk::PhysicalDeviceFeatures2<'_>>();
                // SAFETY: the structure is of this type; no reference to it is made.
                found.push(Link::Core(unsafe { &raw mut (*features).features }));
            }
            vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES => {
                found.push(Link::Vulkan12(next.cast()));
            }
            vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES => {
                found.push(Link::Vulkan13(next.cast()));
            }
            vk::StructureType::PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES => {
                found.push(Link::SubgroupSize(next.cast()));
            }
            kind if PROMOTED.contains(&kind) => found.push(Link::Promoted),
            _ => {}
        }
        next = after;
    }
    found
}

/// Whether a device has an extension.
pub(in crate::gpu) fn has_extension(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    name: &CStr,
) -> bool {
    // SAFETY: `device` is a physical device of `instance`.
    let all = unsafe { instance.enumerate_device_extension_properties(device) };
    all.is_ok_and(|all| all.iter().any(|e| e.extension_name_as_c_str() == Ok(name)))
}

/// The structures that VUID-VkDeviceCreateInfo-pNext-02830 forbids beside
/// `VkPhysicalDeviceVulkan12Features`.
const PROMOTED: [vk::StructureType; 12] = [
    vk::StructureType::PHYSICAL_DEVICE_8BIT_STORAGE_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_SHADER_ATOMIC_INT64_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_IMAGELESS_FRAMEBUFFER_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_UNIFORM_BUFFER_STANDARD_LAYOUT_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_SHADER_SUBGROUP_EXTENDED_TYPES_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_HOST_QUERY_RESET_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
    vk::StructureType::PHYSICAL_DEVICE_VULKAN_MEMORY_MODEL_FEATURES,
];

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: EnabledFeatures = EnabledFeatures {
        geometry_shader: true,
        shader_output_layer: true,
        full_draw_index_uint32: true,
        subgroup_size_control: true,
    };

    #[test]
    fn an_empty_chain_gets_what_it_lacks() {
        let (mut chain, mut info) = (FeatureChain::new(ALL), vk::DeviceCreateInfo::default());
        // SAFETY: `info` is valid, and `chain` outlives its use.
        unsafe {
            assert_eq!(EnabledFeatures::of(&info), EnabledFeatures::default());
            chain.fill(&mut info).unwrap();
            assert_eq!(EnabledFeatures::of(&info), ALL);
        }
    }

    #[test]
    fn what_the_engine_enables_stays_enabled() {
        let core = vk::PhysicalDeviceFeatures::default().wide_lines(true);
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true);
        let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut info = vk::DeviceCreateInfo::default()
            .enabled_features(&core)
            .push_next(&mut vulkan12)
            .push_next(&mut vulkan13);
        let mut chain = FeatureChain::new(ALL);
        // SAFETY: `info` and its chain are valid, and `chain` outlives their use.
        unsafe {
            chain.fill(&mut info).unwrap();
            assert_eq!(EnabledFeatures::of(&info), ALL);
            assert_eq!((*info.p_enabled_features).wide_lines, vk::TRUE);
        }
        assert_eq!(vulkan12.timeline_semaphore, vk::TRUE);
        assert_eq!(vulkan12.shader_output_layer, vk::TRUE);
        assert_eq!(vulkan13.subgroup_size_control, vk::TRUE);
        assert_eq!(vulkan13.compute_full_subgroups, vk::TRUE);

        let mut features2 = vk::PhysicalDeviceFeatures2::default();
        features2.features.wide_lines = vk::TRUE;
        let mut info = vk::DeviceCreateInfo::default().push_next(&mut features2);
        let mut chain = FeatureChain::new(ALL);
        // SAFETY: as above.
        unsafe {
            chain.fill(&mut info).unwrap();
            assert!(info.p_enabled_features.is_null());
            assert_eq!(EnabledFeatures::of(&info), ALL);
        }
        assert_eq!(features2.features.wide_lines, vk::TRUE);
    }

    #[test]
    fn sizes_of_subgroups_need_both_features() {
        let mut control =
            vk::PhysicalDeviceSubgroupSizeControlFeatures::default().subgroup_size_control(true);
        let mut info = vk::DeviceCreateInfo::default().push_next(&mut control);
        let only = EnabledFeatures { subgroup_size_control: true, ..Default::default() };
        let mut chain = FeatureChain::new(only);
        // SAFETY: `info` and its chain are valid, and `chain` outlives their use.
        unsafe {
            assert_eq!(EnabledFeatures::of(&info), EnabledFeatures::default());
            chain.fill(&mut info).unwrap();
            assert_eq!(EnabledFeatures::of(&info), only);
        }
        assert_eq!(control.compute_full_subgroups, vk::TRUE);
    }

    #[test]
    fn a_chain_that_forbids_the_structure_is_refused() {
        let mut timeline = vk::PhysicalDeviceTimelineSemaphoreFeatures::default();
        let mut info = vk::DeviceCreateInfo::default().push_next(&mut timeline);
        // SAFETY: `info` and its chain are valid, and the chains outlive their use.
        unsafe {
            let error = FeatureChain::new(ALL).fill(&mut info).unwrap_err();
            assert!(error.to_string().contains("VkPhysicalDeviceVulkan12Features"), "{error}");
            let core = EnabledFeatures { shader_output_layer: false, ..ALL };
            let mut chain = FeatureChain::new(core);
            chain.fill(&mut info).unwrap();
            assert_eq!(EnabledFeatures::of(&info), core);
        }
    }
}
