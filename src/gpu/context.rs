//! A device to work on, with its queue and its memory.

use super::Call;
use super::choice::{ComputeShape, PipelineKind};
use super::devices::{self, DeviceChoice, DeviceReport};
use super::instance::OwnedInstance;
use super::requirements;
use crate::{Error, Result};
use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator, AllocatorCreateDesc};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How a [`Context`] is made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ContextOptions {
    /// Which device.
    pub device: DeviceChoice,
    /// Whether the validation layer, synchronisation included, watches every call: for tests. What
    /// it says is in [`Context::validation_messages`].
    pub validation: bool,
    /// Bytes for the pictures of a population, at most; a population that needs more is drawn in
    /// several parts. Half of the device's memory where not given.
    pub picture_memory: Option<u64>,
    /// How evaluators make the pictures; where not given the fastest for the device, or
    /// [`PipelineKind::Layered`] for a view with more object pixels than that can hold.
    pub pipeline: Option<PipelineKind>,
    /// The shape of [`PipelineKind::Compute`]; the faster for the device where not given.
    pub shape: Option<ComputeShape>,
}

/// What has been made and read back since the context began.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Buffers and images that got memory.
    pub allocations: u64,
    /// Pipelines.
    pub pipelines: u64,
    /// Descriptor sets, allocated or written anew.
    pub descriptors: u64,
    /// Bytes that the host read from the device's buffers.
    pub bytes_read: u64,
}

#[derive(Default)]
struct AtomicCounters {
    allocations: AtomicU64,
    pipelines: AtomicU64,
    descriptors: AtomicU64,
    bytes_read: AtomicU64,
}

/// A Vulkan device, one queue for graphics and compute, and the memory allocator. Everything made
/// on it holds it, so it goes last.
pub struct Context {
    allocator: ManuallyDrop<Mutex<Allocator>>,
    queue: Mutex<vk::Queue>,
    counters: AtomicCounters,
    debug: Option<ext::debug_utils::Device>,
    report: DeviceReport,
    limits: vk::PhysicalDeviceLimits,
    queue_family: u32,
    physical: vk::PhysicalDevice,
    picture_memory: u64,
    pipeline: Option<PipelineKind>,
    shape: ComputeShape,
    // Dropped in this order.
    device: OwnedDevice,
    instance: OwnedInstance,
}

/// A device that we created and destroy.
struct OwnedDevice {
    raw: ash::Device,
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

impl Context {
    /// A context on the device of `options`.
    ///
    /// # Errors
    /// [`Error::NoVulkan`] without a loader, a device, or the validation layer when it is asked
    /// for; [`Error::Argument`] when the named device is not there; [`Error::Unsupported`] when it
    /// lacks something; [`Error::Vulkan`] and [`Error::DeviceMemory`] when the driver fails.
    pub fn new(options: &ContextOptions) -> Result<Arc<Self>> {
        let instance = OwnedInstance::new(options.validation)?;
        let (physical, report) = devices::choose(&instance, &options.device)?;
        let (queue_family, _) = requirements::queue_family(&instance.raw, physical)
            .expect("a device that lacks nothing has the queue");
        let device = create_device(&instance.raw, physical, queue_family)?;
        // SAFETY: the device was created with one queue of this family.
        let queue = unsafe { device.raw.get_device_queue(queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })
        .map_err(|source| Error::DeviceMemory { what: "the allocator".into(), source })?;
        let debug =
            instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &device.raw));
        // SAFETY: `physical` is a device of the living instance.
        let limits = unsafe { instance.raw.get_physical_device_properties(physical) }.limits;
        let picture_memory = options
            .picture_memory
            .unwrap_or(report.memory / 2)
            .min(requirements::largest_allocation(&instance.raw, physical));
        let pipeline = options.pipeline;
        let shape = options.shape.unwrap_or(report.shape);
        let together = requirements::together(&instance.raw, physical);
        if shape == ComputeShape::Tiles && !ComputeShape::tiles_possible(together) {
            let lacks = "it lacks the subgroups or the shared memory for tiles".into();
            return Err(Error::Unsupported { device: report.info.name, lacks });
        }
        Ok(Arc::new(Self {
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            queue: Mutex::new(queue),
            counters: AtomicCounters::default(),
            debug,
            report,
            limits,
            queue_family,
            physical,
            picture_memory,
            pipeline,
            shape,
            device,
            instance,
        }))
    }

    /// The device.
    pub fn report(&self) -> &DeviceReport {
        &self.report
    }

    /// What the validation layer has reported so far; always empty without it.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.messages.list()
    }

    /// What has been made and read back so far.
    pub fn counters(&self) -> Counters {
        Counters {
            allocations: self.counters.allocations.load(Ordering::Relaxed),
            pipelines: self.counters.pipelines.load(Ordering::Relaxed),
            descriptors: self.counters.descriptors.load(Ordering::Relaxed),
            bytes_read: self.counters.bytes_read.load(Ordering::Relaxed),
        }
    }

    /// Bytes of device memory that are taken at the moment, what the allocator keeps for later
    /// included.
    pub fn memory_taken(&self) -> u64 {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner).capacity()
    }

    /// The device's functions.
    pub(crate) fn device(&self) -> &ash::Device {
        &self.device.raw
    }

    /// The device's limits.
    pub(crate) fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.limits
    }

    /// Bytes for the pictures of a population.
    pub(super) fn picture_memory(&self) -> u64 {
        self.picture_memory
    }

    /// How evaluators make the pictures, where that is given.
    pub(super) fn pipeline(&self) -> Option<PipelineKind> {
        self.pipeline
    }

    /// The shape of [`PipelineKind::Compute`].
    pub(super) fn shape(&self) -> ComputeShape {
        self.shape
    }

    /// The family of the queue.
    pub(super) fn queue_family(&self) -> u32 {
        self.queue_family
    }

    /// Layers and bytes that an image of `format` and `usage` can have at most.
    pub(super) fn image_limits(
        &self,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<vk::ImageFormatProperties> {
        // SAFETY: `physical` is a device of the living instance.
        unsafe {
            self.instance.raw.get_physical_device_image_format_properties(
                self.physical,
                format,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                usage,
                vk::ImageCreateFlags::empty(),
            )
        }
        .call("vkGetPhysicalDeviceImageFormatProperties")
    }

    /// The queue, for one submission at a time.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Labels for debuggers, where there are any.
    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    /// Names an object for debuggers and validation messages.
    pub(super) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let (Some(debug), Ok(name)) = (&self.debug, std::ffi::CString::new(name)) else { return };
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: `object` is alive and belongs to this device. A name that cannot be kept is lost
        // for the debugger only.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    pub(super) fn allocate(&self, desc: &AllocationCreateDesc<'_>) -> Result<Allocation> {
        self.counters.allocations.fetch_add(1, Ordering::Relaxed);
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        allocator
            .allocate(desc)
            .map_err(|source| Error::DeviceMemory { what: desc.name.to_owned(), source })
    }

    pub(super) fn free(&self, allocation: Allocation) {
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        // It fails only for an allocation of another allocator; ours come from `allocate`.
        let _ = allocator.free(allocation);
    }

    pub(super) fn count_pipeline(&self) {
        self.counters.pipelines.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn count_descriptors(&self) {
        self.counters.descriptors.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn count_read(&self, bytes: usize) {
        self.counters.bytes_read.fetch_add(bytes as u64, Ordering::Relaxed);
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: dropped once, here, as its memory must be given back before the device goes.
        unsafe { ManuallyDrop::drop(&mut self.allocator) };
    }
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
) -> Result<OwnedDevice> {
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&[1.0])];
    let features = vk::PhysicalDeviceFeatures::default()
        .geometry_shader(true)
        .full_draw_index_uint32(requirements::full_indices(instance, physical));
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default().shader_output_layer(true);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .push_next(&mut vulkan12);
    // SAFETY: the device has the features (its report lacks nothing), and the chain outlives the
    // call.
    let raw = unsafe { instance.create_device(physical, &info, None) }.call("vkCreateDevice")?;
    Ok(OwnedDevice { raw })
}
