//! The device and the instance of a context: klieg's own, which it destroys, or an engine's.

use super::features::{EnabledFeatures, FeatureChain};
use super::instance::OwnedInstance;
use crate::Result;
use crate::gpu::vulkan::Call;
use ash::vk;

/// Whose device and instance they are.
pub(in crate::gpu) enum Owner {
    /// Dropped in this order.
    Owned { device: OwnedDevice, instance: OwnedInstance },
    /// The engine's, which destroys them.
    Borrowed { device: ash::Device, instance: ash::Instance },
}

impl Owner {
    pub(in crate::gpu) fn device(&self) -> &ash::Device {
        match self {
            Self::Owned { device, .. } => &device.raw,
            Self::Borrowed { device, .. } => device,
        }
    }

    pub(in crate::gpu) fn instance(&self) -> &ash::Instance {
        match self {
            Self::Owned { instance, .. } => &instance.raw,
            Self::Borrowed { instance, .. } => instance,
        }
    }
}

/// A device that we created and destroy.
pub(in crate::gpu) struct OwnedDevice {
    pub(in crate::gpu) raw: ash::Device,
}

impl Drop for OwnedDevice {
    fn drop(&mut self) {
        // SAFETY: everything made on the device held the context and is gone; a failed wait means a
        // lost device, which may be destroyed all the same.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.raw.destroy_device(None);
        }
    }
}

/// A device with all that klieg can use, and what that is.
///
/// # Errors
/// [`crate::Error::Vulkan`].
pub(in crate::gpu) fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
) -> Result<(OwnedDevice, EnabledFeatures)> {
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&[1.0])];
    let wanted = EnabledFeatures::supported(instance, physical);
    let mut chain = FeatureChain::new(wanted);
    let control = [vk::EXT_SUBGROUP_SIZE_CONTROL_NAME.as_ptr()];
    let extensions = if wanted.subgroup_size_control { &control[..] } else { &[] };
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(extensions);
    // SAFETY: the device has the features and extensions; `info` and the chain outlive the call.
    let raw = unsafe {
        chain.fill(&mut info)?;
        instance.create_device(physical, &info, None).call("vkCreateDevice")?
    };
    Ok((OwnedDevice { raw }, wanted))
}
