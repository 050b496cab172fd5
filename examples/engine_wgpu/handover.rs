//! wgpu's Vulkan objects, as klieg borrows them.

use crate::Result;
use crate::gpu::Gpu;
use ash::vk;
use klieg::gpu::{BorrowedDevice, Context, EnabledFeatures, Needs, Tuning};
use std::sync::Arc;
use wgpu::hal::api::Vulkan;

/// A context on the engine's device, for surfaces and pictures that the engine draws.
///
/// All submissions come from one thread, so there is no lock of the queue. wgpu does not share its own: an
/// engine with several threads puts one of its own around `Queue::submit` and gives that to klieg.
pub fn context(gpu: &Gpu) -> Result<Arc<Context>> {
    // SAFETY: the raw device is used beside wgpu's and not destroyed.
    let device = unsafe { gpu.device.as_hal::<Vulkan>() }.ok_or("wgpu is not on Vulkan")?;
    let instance = device.shared_instance();
    let borrowed = BorrowedDevice {
        instance: instance.raw_instance().clone(),
        // wgpu asks for no later version than 1.3, whatever the loader has.
        api_version: instance.instance_api_version().min(vk::API_VERSION_1_3),
        debug_utils: true,
        physical: device.raw_physical_device(),
        device: device.raw_device().clone(),
        queue: device.raw_queue(),
        queue_family: device.queue_family_index(),
        features: EnabledFeatures {
            // The feature by which wgpu gives fragment shaders the polygon's number.
            geometry_shader: gpu.device.features().contains(wgpu::Features::PRIMITIVE_INDEX),
            ..Default::default()
        },
        queue_lock: None,
        allocator: None,
    };
    // SAFETY: wgpu's handles belong together, and `Gpu` outlives what is made on them.
    Ok(unsafe { Context::borrow(borrowed, Needs::COMPUTE, &Tuning::default()) }?)
}

/// The Vulkan view of a wgpu view, valid as long as that.
pub fn raw_view(view: &wgpu::TextureView) -> Result<vk::ImageView> {
    // SAFETY: the raw view is read from and not destroyed.
    let raw = unsafe { view.as_hal::<Vulkan>() }.ok_or("wgpu is not on Vulkan")?;
    // SAFETY: as above.
    Ok(unsafe { raw.raw_handle() })
}

/// Records Vulkan commands into a command buffer of wgpu's, which has no other commands: wgpu's own
/// cannot follow or precede raw ones in the same encoder.
pub fn record<T>(
    gpu: &Gpu,
    body: impl FnOnce(vk::CommandBuffer) -> klieg::Result<T>,
) -> Result<(wgpu::CommandBuffer, T)> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    // SAFETY: klieg only adds commands, outside of a render pass, and does not end the buffer.
    let recorded =
        unsafe { encoder.as_hal_mut::<Vulkan, _, _>(|hal| hal.map(|hal| body(hal.raw_handle()))) };
    Ok((encoder.finish(), recorded.ok_or("wgpu is not on Vulkan")??))
}
