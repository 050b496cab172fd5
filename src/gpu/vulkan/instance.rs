//! The Vulkan loader, our instance, and what the validation layer says.

use crate::gpu::vulkan::Call;
use crate::{Error, Result};
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";
/// The instance's and every device's least version.
pub(in crate::gpu) const API_VERSION: u32 = vk::API_VERSION_1_2;

/// A rule that klieg cannot break: layers that drivers bring ask for the address of every function that they
/// know, some by the wrong object (NVIDIA 580 for one of video encoding).
const OF_OTHER_LAYERS: &str = "WARNING-vkGetDeviceProcAddr-device";

/// What the validation layer reported, in order.
#[derive(Default)]
pub(in crate::gpu) struct Messages(Mutex<Vec<String>>);

impl Messages {
    fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    pub(in crate::gpu) fn list(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// An instance that we created and destroy.
pub(in crate::gpu) struct OwnedInstance {
    pub(in crate::gpu) raw: ash::Instance,
    /// Present where the system has the extension: names and labels for debuggers.
    pub(in crate::gpu) debug_utils: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Boxed, as the messenger keeps its address.
    pub(in crate::gpu) messages: Box<Messages>,
    _entry: ash::Entry,
}

impl OwnedInstance {
    /// # Errors
    /// [`Error::NoVulkan`] without a loader, or without the validation layer when it is asked for.
    pub(in crate::gpu) fn new(validation: bool) -> Result<Self> {
        let entry = load()?;
        if validation {
            require_validation(&entry)?;
        }
        // SAFETY: `entry` is a loaded Vulkan loader.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
            .call("vkEnumerateInstanceExtensionProperties")?;
        let debug_utils = validation || has_extension(&extensions, ext::debug_utils::NAME);
        keep_drivers()?;
        let messages = Box::<Messages>::default();
        let raw = create(&entry, validation, debug_utils, &messages)?;
        let mut instance = Self { raw, debug_utils, messenger: None, messages, _entry: entry };
        if validation {
            let loader = ext::debug_utils::Instance::new(&instance._entry, &instance.raw);
            let info = messenger_info(&instance.messages);
            // SAFETY: the instance was created with the extension, and the callback's user data is
            // boxed and outlives the messenger, which `drop` destroys first.
            let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
                .call("vkCreateDebugUtilsMessengerEXT")?;
            instance.messenger = Some((loader, messenger));
        }
        Ok(instance)
    }
}

impl Drop for OwnedInstance {
    fn drop(&mut self) {
        // SAFETY: everything made from the instance is gone: its owner drops the device first.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn load() -> Result<ash::Entry> {
    // SAFETY: the system's Vulkan loader has no preconditions for being loaded; the entry is
    // kept as long as anything made from it.
    unsafe { ash::Entry::load() }
        .map_err(|error| Error::NoVulkan(format!("no Vulkan loader: {error}")))
}

/// Keeps the drivers in memory until the process ends, by an instance that is never destroyed: the loader takes them
/// out with the last instance, and NVIDIA's can be loaded 30 times in a process and no more (580.159: "cannot
/// allocate memory in static TLS block").
fn keep_drivers() -> Result<()> {
    static KEPT: Mutex<Option<(ash::Instance, ash::Entry)>> = Mutex::new(None);
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if kept.is_none() {
        let entry = load()?;
        *kept = Some((create(&entry, false, false, &Messages::default())?, entry));
    }
    Ok(())
}

fn create(
    entry: &ash::Entry,
    validation: bool,
    debug_utils: bool,
    messages: &Messages,
) -> Result<ash::Instance> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"klieg")
        .engine_name(c"klieg")
        .api_version(API_VERSION);
    let layers: &[_] = if validation { &[VALIDATION.as_ptr()] } else { &[] };
    let mut extensions = Vec::new();
    if debug_utils {
        extensions.push(ext::debug_utils::NAME.as_ptr());
    }
    if validation {
        extensions.push(ext::validation_features::NAME.as_ptr());
    }
    let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
    let mut messenger = messenger_info(messages);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(layers)
        .enabled_extension_names(&extensions);
    if validation {
        info = info.push_next(&mut features).push_next(&mut messenger);
    }
    // SAFETY: every pointer in `info` lives until the call returns.
    unsafe { entry.create_instance(&info, None) }
        .map_err(|result| Error::NoVulkan(format!("vkCreateInstance failed: {result}")))
}

/// The layer must be there, with the extension that switches synchronisation validation on.
fn require_validation(entry: &ash::Entry) -> Result<()> {
    // SAFETY: `entry` is a loaded Vulkan loader.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .call("vkEnumerateInstanceLayerProperties")?;
    let found = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION));
    if !found {
        return Err(Error::NoVulkan("the layer VK_LAYER_KHRONOS_validation is missing".into()));
    }
    // SAFETY: as above; the layer exists.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(Some(VALIDATION)) }
        .call("vkEnumerateInstanceExtensionProperties")?;
    if !has_extension(&extensions, ext::validation_features::NAME) {
        return Err(Error::NoVulkan(
            "VK_LAYER_KHRONOS_validation lacks VK_EXT_validation_features".into(),
        ));
    }
    Ok(())
}

fn has_extension(extensions: &[vk::ExtensionProperties], name: &CStr) -> bool {
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}

fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        // The type PERFORMANCE is advice, such as against layout GENERAL: no rule is broken.
        .message_type(Type::GENERAL | Type::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast())
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid callback data, and `user_data` is the `Messages` that the
    // messenger was created with, which outlives it.
    unsafe {
        let messages = &*user_data.cast::<Messages>();
        let id = (*data).message_id_name_as_c_str().map_or("".into(), CStr::to_string_lossy);
        let text = (*data).message_as_c_str().map_or("".into(), CStr::to_string_lossy);
        if id != OF_OTHER_LAYERS {
            messages.push(named(&id, &text));
        }
    }
    vk::FALSE
}

/// A message with the name of the broken rule, such as `SYNC-HAZARD-WRITE-AFTER-WRITE`: older layers
/// write it into their text, newer ones hand it over beside the text.
fn named(id: &str, text: &str) -> String {
    match text.contains(id) {
        true => text.into(),
        false => format!("[ {id} ] {text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_names_its_rule_once() {
        let id = "SYNC-HAZARD-WRITE-AFTER-WRITE";
        let newer = "vkCmdFillBuffer(): WRITE_AFTER_WRITE hazard detected.";
        let older = format!("Validation Error: [ {id} ] Object 0: | vkCmdFillBuffer: Hazard");
        assert_eq!(named(id, newer), format!("[ {id} ] {newer}"));
        assert_eq!(named(id, &older), older);
        assert_eq!(named("", "of the loader"), "of the loader");
    }
}
