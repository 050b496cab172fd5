//! The engine's device: wgpu on Vulkan, with the validation layer's messages collected.

use crate::Result;
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, MutexGuard, PoisonError};
use wgpu::hal::api::Vulkan;
use wgpu::hal::vulkan::CreateInstanceCallbackArgs;

/// A wgpu device and its queue.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    // Fields are dropped in order: the messenger before the instance it belongs to.
    messenger: Messenger,
    instance: wgpu::Instance,
}

impl Gpu {
    /// The default adapter of wgpu's Vulkan backend, validated.
    pub fn new() -> Result<Self> {
        let instance = instance()?;
        let messenger = Messenger::new(&instance)?;
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        Ok(Self { device, queue, messenger, instance })
    }

    /// Destroys the device, on which nothing must be left, and returns what the validation layer has
    /// said since the instance was made.
    pub fn finish(self) -> Vec<String> {
        let Self { device, queue, messenger, instance } = self;
        drop((device, queue));
        let messages = std::mem::take(&mut *messenger.lock());
        drop(messenger);
        drop(instance);
        messages
    }

    /// Waits for everything submitted through wgpu.
    pub fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

/// A validated instance with `VK_EXT_debug_utils`. wgpu's flag `DEBUG` would enable the extension too,
/// but makes naga name WGSL as the source language, which older validation layers do not
/// know: <https://github.com/gfx-rs/wgpu/issues/7375>.
fn instance() -> Result<wgpu::Instance> {
    let info = wgpu::hal::InstanceDescriptor {
        name: "engine_wgpu",
        flags: wgpu::InstanceFlags::VALIDATION,
        memory_budget_thresholds: Default::default(),
        backend_options: Default::default(),
        telemetry: None,
        display: None,
    };
    let debug_utils = Box::new(|arguments: CreateInstanceCallbackArgs<'_, '_, '_>| {
        arguments.extensions.push(ext::debug_utils::NAME);
    });
    // SAFETY: the callback adds an extension, which the Vulkan loader brings.
    let hal = unsafe { wgpu::hal::vulkan::Instance::init_with_callback(&info, Some(debug_utils)) }?;
    // SAFETY: a new instance of this backend.
    Ok(unsafe { wgpu::Instance::from_hal::<Vulkan>(hal) })
}

/// A messenger of our own beside wgpu's, which only passes messages to the `log` crate and leaves
/// out some that it knows.
struct Messenger {
    functions: ext::debug_utils::Instance,
    raw: vk::DebugUtilsMessengerEXT,
    messages: Box<Mutex<Vec<String>>>,
}

impl Messenger {
    fn new(instance: &wgpu::Instance) -> Result<Self> {
        // SAFETY: the raw instance is used to add a messenger alone, and not destroyed.
        let hal = unsafe { instance.as_hal::<Vulkan>() }.ok_or("wgpu is not on Vulkan")?;
        let shared = hal.shared_instance();
        // SAFETY: the library is loaded as long as the instance, and layers are only listed.
        let layers = unsafe { shared.entry().enumerate_instance_layer_properties() }?;
        if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(c"VK_LAYER_KHRONOS_validation")) {
            return Err("the validation layer is not installed".into());
        }
        let functions = ext::debug_utils::Instance::new(shared.entry(), shared.raw_instance());
        let messages = Box::new(Mutex::new(Vec::new()));
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::ERROR
                    | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(collect))
            .user_data(&raw const *messages as *mut c_void);
        // SAFETY: the instance has VK_EXT_debug_utils; the messages have an address of their own and
        // live as long as the messenger.
        let raw = unsafe { functions.create_debug_utils_messenger(&info, None) }?;
        let messenger = Self { functions, raw, messages };
        messenger.check()?;
        Ok(messenger)
    }

    /// # Errors
    /// Unless it hears, so that silence later means that there is nothing to say.
    fn check(&self) -> Result<()> {
        let error = vk::DebugUtilsMessageSeverityFlagsEXT::ERROR;
        let kind = vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION;
        let data = vk::DebugUtilsMessengerCallbackDataEXT::default().message(c"a test");
        // SAFETY: the instance is alive, and the data for the call.
        unsafe { self.functions.submit_debug_utils_message(error, kind, &data) };
        match self.lock().pop() {
            Some(_) => Ok(()),
            None => Err("the messenger hears nothing".into()),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<String>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: made from this instance, which is alive, and destroyed once.
        unsafe { self.functions.destroy_debug_utils_messenger(self.raw, None) };
    }
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid data, and `messages` is what the messenger was made with.
    let (data, messages) = unsafe { (&*data, &*messages.cast::<Mutex<Vec<String>>>()) };
    // SAFETY: a string that ends in zero, or null.
    let text = unsafe { data.message_as_c_str() }.map(CStr::to_string_lossy);
    let text = text.unwrap_or_default().into_owned();
    messages.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    vk::FALSE
}
