//! An engine's device, as klieg borrows it.

use super::allocator::DeviceAllocator;
use super::features::EnabledFeatures;
use ash::vk;
use std::sync::Arc;

/// A device that an engine created, keeps and destroys.
pub struct BorrowedDevice {
    /// The instance.
    pub instance: ash::Instance,
    /// The Vulkan version that the instance was created for.
    pub api_version: u32,
    /// Whether the instance was created with `VK_EXT_debug_utils`: then klieg names and labels what it
    /// makes and records.
    pub debug_utils: bool,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// The queue that klieg submits to where it submits by itself.
    pub queue: vk::Queue,
    /// Family of that queue, and of the command buffers that klieg records into.
    pub queue_family: u32,
    /// What is enabled on the device.
    pub features: EnabledFeatures,
    /// What keeps the engine off the queue while klieg submits; needed where they are different threads.
    pub queue_lock: Option<Arc<dyn QueueLock>>,
    /// Where memory comes from; gpu-allocator where not given.
    pub allocator: Option<Box<dyn DeviceAllocator>>,
}

/// An engine's lock of its queue. klieg holds it for one `vkQueueSubmit` at a time and never while it
/// waits.
pub trait QueueLock: Send + Sync {
    /// Waits until the queue is free, and takes it.
    fn lock(&self);
    /// Gives it back, on the same thread.
    fn unlock(&self);
}

/// Holds a lock for as long as it lives.
pub(in crate::gpu) struct Held<'a>(&'a dyn QueueLock);

impl<'a> Held<'a> {
    pub(in crate::gpu) fn new(lock: &'a dyn QueueLock) -> Self {
        lock.lock();
        Self(lock)
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.0.unlock();
    }
}
