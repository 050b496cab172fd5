//! A device to work on, with its queue and its memory: klieg's own, or an engine's.

use super::allocator::{Blocks, DeviceAllocator};
use super::borrowed::{BorrowedDevice, Held, QueueLock};
use super::cache::Cache;
use super::choice::{ComputeShape, Lights, PipelineKind, ShadowMaker, Subgroups};
use super::devices::{self, DeviceReport};
use super::features::EnabledFeatures;
use super::instance::{API_VERSION, OwnedInstance};
use super::owner::{Owner, create_device};
use super::pipeline_cache::PipelineCache;
use super::requirements::{self, Given, Needs};
use super::tuning::{ContextOptions, Tuning};
use super::usage::Usage;
use crate::gpu::vulkan::Call;
use crate::{Error, Result};
use ash::{ext, vk};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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
    /// Bytes of [`Tuning::pipeline_cache`] that the driver began with.
    pub pipeline_cache: u64,
}

#[derive(Default)]
struct AtomicCounters {
    allocations: AtomicU64,
    pipelines: AtomicU64,
    descriptors: AtomicU64,
    bytes_read: AtomicU64,
}

/// A Vulkan device, one queue of it, and memory. Everything made on it holds it, so it goes last.
///
/// It may be shared between threads, each with evaluators of its own: submissions take turns. On a
/// device that is lost, whatever reaches the device fails ([`Error::is_device_lost`]); dropping what
/// was made on it is all that is left to do.
pub struct Context {
    allocator: ManuallyDrop<Mutex<Box<dyn DeviceAllocator>>>,
    queue: Mutex<vk::Queue>,
    queue_lock: Option<Arc<dyn QueueLock>>,
    cache: Cache,
    counters: AtomicCounters,
    debug: Option<ext::debug_utils::Device>,
    report: DeviceReport,
    limits: vk::PhysicalDeviceLimits,
    queue_family: u32,
    physical: vk::PhysicalDevice,
    needs: Needs,
    picture_memory: u64,
    /// Evaluators that share it.
    sharing: AtomicU32,
    any_lights: bool,
    pipeline: Option<PipelineKind>,
    shape: ComputeShape,
    shadow_maker: ShadowMaker,
    tiles: Option<Subgroups>,
    forgotten: AtomicBool,
    dry: bool,
    /// Memory in use.
    pub(super) usage: Usage,
    owner: ManuallyDrop<Owner>,
}

/// What a context is made of besides its device and instance.
struct Parts {
    report: DeviceReport,
    physical: vk::PhysicalDevice,
    queue: vk::Queue,
    queue_family: u32,
    queue_lock: Option<Arc<dyn QueueLock>>,
    allocator: Option<Box<dyn DeviceAllocator>>,
    needs: Needs,
    features: EnabledFeatures,
    api_version: u32,
    debug_utils: bool,
    dry: bool,
}

impl Context {
    /// A context on a device of its own. What the device cannot draw, the CPU draws for it: see
    /// [`DeviceReport::draws_scenes`] and [`DeviceReport::draws_layers`].
    ///
    /// # Errors
    /// [`Error::NoVulkan`] without a loader, a device, or the validation layer when it is asked
    /// for; [`Error::Argument`] when the named device is not there; [`Error::Unsupported`] when it
    /// lacks something; [`Error::Vulkan`] and [`Error::DeviceMemory`] when the driver fails.
    pub fn new(options: &ContextOptions) -> Result<Arc<Self>> {
        Self::on_own_device(options, false)
    }

    /// A context like that on which evaluators are made as there, but what they make gets no memory, pipelines are
    /// not compiled, and nothing runs: what is read back is zeros. It finds out what they would take
    /// ([`Context::memory_use`]).
    ///
    /// # Errors
    /// As [`Context::new`].
    pub(in crate::gpu) fn dry(options: &ContextOptions) -> Result<Arc<Self>> {
        Self::on_own_device(options, true)
    }

    fn on_own_device(options: &ContextOptions, dry: bool) -> Result<Arc<Self>> {
        let instance = OwnedInstance::new(options.validation)?;
        let (physical, report) = devices::choose(&instance.raw, &options.device)?;
        let queue_family = requirements::queue_family(&instance.raw, physical)
            .expect("a device that lacks nothing has the queue");
        let (device, features) = create_device(&instance.raw, physical, queue_family)?;
        // SAFETY: the device was created with one queue of this family.
        let queue = unsafe { device.raw.get_device_queue(queue_family, 0) };
        let needs = Needs { scene: report.draws_scenes, layers: report.draws_layers };
        let parts = Parts {
            report,
            physical,
            queue,
            queue_family,
            queue_lock: None,
            allocator: None,
            needs,
            features,
            api_version: API_VERSION,
            debug_utils: instance.debug_utils,
            dry,
        };
        Self::of(Owner::Owned { device, instance }, parts, &options.tuning)
    }

    /// A context on an engine's device, which stays the engine's: klieg destroys what it makes itself,
    /// and no more. Drop everything that klieg made on it before the device goes, or see
    /// [`Context::forget_device`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] with all that the device, its queue or its enabled features lack for
    /// `needs`; [`Error::Vulkan`] and [`Error::DeviceMemory`] when the driver fails.
    ///
    /// # Safety
    /// The handles are valid, belong together, and stay valid while anything holds the context. The
    /// features are enabled. Other threads use the queue only with the lock held.
    pub unsafe fn borrow(
        borrowed: BorrowedDevice,
        needs: Needs,
        tuning: &Tuning,
    ) -> Result<Arc<Self>> {
        let BorrowedDevice { instance, physical, device, queue, queue_family, .. } = borrowed;
        let given = Given {
            api_version: borrowed.api_version,
            enabled: borrowed.features,
            queue: requirements::family(&instance, physical, queue_family).map(|f| f.queue_flags),
        };
        let report = devices::report(&instance, (0, physical), Some(queue_family), given);
        let lacks = requirements::lacking(&instance, physical, needs, given);
        if !lacks.is_empty() {
            let lacks = format!("it lacks {}", lacks.join("; "));
            return Err(Error::Unsupported { device: report.info.name, lacks });
        }
        let parts = Parts {
            report,
            physical,
            queue,
            queue_family,
            queue_lock: borrowed.queue_lock,
            allocator: borrowed.allocator,
            needs,
            features: borrowed.features,
            api_version: borrowed.api_version,
            debug_utils: borrowed.debug_utils,
            dry: false,
        };
        Self::of(Owner::Borrowed { device, instance }, parts, tuning)
    }

    fn of(owner: Owner, parts: Parts, tuning: &Tuning) -> Result<Arc<Self>> {
        let Parts { report, physical, queue, queue_family, queue_lock, needs, .. } = parts;
        let instance = owner.instance();
        let versions = (parts.api_version, parts.features);
        let tiles = ComputeShape::tiles(requirements::together(instance, physical, versions)).ok();
        let shape = tuning.shape.unwrap_or(report.shape);
        let shadow_maker = tuning.shadow_maker.unwrap_or(report.shadow_maker);
        if shape == ComputeShape::Tiles && tiles.is_none() {
            let lacks = "it lacks the subgroups or the shared memory for tiles".into();
            return Err(Error::Unsupported { device: report.info.name, lacks });
        }
        let allocator = match parts.allocator {
            Some(allocator) => allocator,
            None => Box::new(Blocks::new(instance, physical, owner.device())?),
        };
        let debug =
            parts.debug_utils.then(|| ext::debug_utils::Device::new(instance, owner.device()));
        // SAFETY: `physical` is a device of the living instance.
        let mut limits = unsafe { instance.get_physical_device_properties(physical) }.limits;
        if !parts.features.full_draw_index_uint32 {
            limits.max_draw_indexed_index_value =
                limits.max_draw_indexed_index_value.min((1 << 24) - 1);
        }
        let picture_memory = tuning
            .picture_memory
            .unwrap_or(report.memory / 2)
            .min(requirements::largest_allocation(instance, physical));
        let compiled =
            PipelineCache::new(instance, physical, owner.device(), &tuning.pipeline_cache);
        Ok(Arc::new(Self {
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            queue: Mutex::new(queue),
            queue_lock,
            cache: Cache { compiled, ..Cache::default() },
            counters: AtomicCounters::default(),
            debug,
            report,
            limits,
            queue_family,
            physical,
            needs,
            picture_memory,
            sharing: AtomicU32::new(1),
            pipeline: tuning.pipeline,
            any_lights: tuning.any_lights,
            shape,
            shadow_maker,
            tiles,
            forgotten: AtomicBool::new(false),
            dry: parts.dry,
            usage: Usage::default(),
            owner: ManuallyDrop::new(owner),
        }))
    }

    /// Says that the device is gone, or soon will be, before all that klieg made on it: from now on klieg
    /// makes no Vulkan call and touches no mapped memory. What it had made on the device is leaked there,
    /// and so is a device of klieg's own; whatever would reach the device fails with
    /// [`Error::Forgotten`].
    ///
    /// The device may go once this and every other call on the context and on what was made on it have
    /// returned.
    pub fn forget_device(&self) {
        self.forgotten.store(true, Ordering::Release);
    }

    /// # Errors
    /// [`Error::Forgotten`] after [`Context::forget_device`].
    pub(in crate::gpu) fn check_present(&self) -> Result<()> {
        match self.forgotten.load(Ordering::Acquire) {
            true => Err(Error::Forgotten),
            false => Ok(()),
        }
    }

    /// Calls functions of the device that cannot fail, unless it is gone: they destroy objects or write
    /// descriptors.
    pub(in crate::gpu) fn unless_gone(&self, body: impl FnOnce(&ash::Device)) {
        if let Ok(device) = self.device() {
            body(device);
        }
    }

    /// What the device was imported for.
    pub(in crate::gpu) fn needs(&self) -> Needs {
        self.needs
    }

    /// # Errors
    /// [`Error::Unsupported`] unless `covered`: whether the device can be used for `what`, and was imported for
    /// it.
    pub(in crate::gpu) fn check_needs(&self, covered: bool, what: &str) -> Result<()> {
        if covered {
            return Ok(());
        }
        let DeviceReport { info, lacks_for_drawing, .. } = &self.report;
        let lacks = match &lacks_for_drawing[..] {
            [] => format!("it was not imported for {what}"),
            lacks => format!("for {what} it lacks {}", lacks.join("; ")),
        };
        Err(Error::Unsupported { device: info.name.clone(), lacks })
    }

    /// The device.
    pub fn report(&self) -> &DeviceReport {
        &self.report
    }

    /// What the validation layer has reported so far, each with the name of the broken rule; always
    /// empty without it, and on an engine's device, whose instance hears it.
    pub fn validation_messages(&self) -> Vec<String> {
        match &*self.owner {
            Owner::Owned { instance, .. } => instance.messages.list(),
            Owner::Borrowed { .. } => Vec::new(),
        }
    }

    /// What has been made and read back so far.
    pub fn counters(&self) -> Counters {
        Counters {
            allocations: self.counters.allocations.load(Ordering::Relaxed),
            pipelines: self.counters.pipelines.load(Ordering::Relaxed),
            descriptors: self.counters.descriptors.load(Ordering::Relaxed),
            bytes_read: self.counters.bytes_read.load(Ordering::Relaxed),
            pipeline_cache: self.cache.compiled.given,
        }
    }

    /// Bytes of device memory that are taken at the moment, what the allocator keeps for later
    /// included; 0 after [`Context::forget_device`].
    pub fn memory_taken(&self) -> u64 {
        if self.check_present().is_err() {
            return 0;
        }
        self.allocator().capacity()
    }

    /// The device's functions: the one way to make, write, submit or read anything.
    ///
    /// # Errors
    /// [`Error::Forgotten`] after [`Context::forget_device`].
    pub(in crate::gpu) fn device(&self) -> Result<&ash::Device> {
        self.check_present()?;
        Ok(self.owner.device())
    }

    /// The functions `vkCmd…`. Whoever began the command buffer that they record into has found the device
    /// present.
    pub(in crate::gpu) fn recorder(&self) -> &ash::Device {
        self.owner.device()
    }

    /// The device's limits.
    pub(crate) fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.limits
    }

    /// An error that says what is more than the device can take.
    pub(in crate::gpu) fn unsupported(&self, lacks: String) -> Error {
        Error::Unsupported { device: self.report().info.name.clone(), lacks }
    }

    /// Under which lights evaluators will shade.
    pub(in crate::gpu) fn lights(&self) -> Lights {
        if self.any_lights { Lights::Any } else { Lights::Plain }
    }

    /// Lets so many evaluators share the memory for the pictures of populations: those that make theirs from now on take
    /// a part each.
    pub fn share_picture_memory(&self, evaluators: u32) {
        self.sharing.store(evaluators.max(1), Ordering::Relaxed);
    }

    /// Bytes for the pictures of a population.
    pub(in crate::gpu) fn picture_memory(&self) -> u64 {
        self.picture_memory / u64::from(self.sharing.load(Ordering::Relaxed))
    }

    /// How evaluators make the pictures, where that is given.
    pub(in crate::gpu) fn pipeline(&self) -> Option<PipelineKind> {
        self.pipeline
    }

    /// The shape of [`PipelineKind::Compute`].
    pub(in crate::gpu) fn shape(&self) -> ComputeShape {
        self.shape
    }

    /// Who makes shadow tables.
    pub(in crate::gpu) fn shadow_maker(&self) -> ShadowMaker {
        self.shadow_maker
    }

    /// The subgroups of [`ComputeShape::Tiles`], where that can run.
    pub(in crate::gpu) fn tiles(&self) -> Option<Subgroups> {
        self.tiles
    }

    /// The family of the queue.
    pub(in crate::gpu) fn queue_family(&self) -> u32 {
        self.queue_family
    }

    /// Layers and bytes that an image of `format` and `usage` can have at most.
    pub(in crate::gpu) fn image_limits(
        &self,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<vk::ImageFormatProperties> {
        self.check_present()?;
        // SAFETY: `physical` is a device of the living instance.
        unsafe {
            self.owner.instance().get_physical_device_image_format_properties(
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

    /// Submits to the queue, alone.
    pub(in crate::gpu) fn submit(
        &self,
        submits: &[vk::SubmitInfo<'_>],
        fence: vk::Fence,
    ) -> Result<()> {
        let device = self.device()?;
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let _engine = self.queue_lock.as_deref().map(Held::new);
        // SAFETY: the queue is locked, against the engine too; the caller's commands are recorded and
        // its fence is unsignalled.
        unsafe { device.queue_submit(*queue, submits, fence) }.call("vkQueueSubmit")
    }

    /// Layouts, render passes and pipelines, for all who work on the device.
    pub(in crate::gpu) fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Labels for debuggers, where there are any.
    pub(in crate::gpu) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    /// Names an object for debuggers and validation messages.
    pub(in crate::gpu) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let (Some(debug), Ok(_), Ok(name)) =
            (&self.debug, self.check_present(), std::ffi::CString::new(name))
        else {
            return;
        };
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: `object` is alive and belongs to this device. A name that cannot be kept is lost
        // for the debugger only.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Whether what is made gets no memory, and nothing runs.
    pub(in crate::gpu) fn is_dry(&self) -> bool {
        self.dry
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Box<dyn DeviceAllocator>> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn count_allocation(&self) {
        self.counters.allocations.fetch_add(1, Ordering::Relaxed);
    }

    pub(in crate::gpu) fn count_pipeline(&self) {
        self.counters.pipelines.fetch_add(1, Ordering::Relaxed);
    }

    pub(in crate::gpu) fn count_descriptors(&self) {
        self.counters.descriptors.fetch_add(1, Ordering::Relaxed);
    }

    pub(in crate::gpu) fn count_read(&self, bytes: usize) {
        self.counters.bytes_read.fetch_add(bytes as u64, Ordering::Relaxed);
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: whoever used the pipelines held the context, waited for his work, and is gone.
        self.unless_gone(|device| unsafe { self.cache.destroy(device) });
        // An allocator of a device that is gone must not free its memory there, and a device on which
        // objects were left must not be destroyed.
        if self.check_present().is_ok() {
            // SAFETY: each is dropped once, here; the memory is given back before the device goes.
            unsafe {
                ManuallyDrop::drop(&mut self.allocator);
                ManuallyDrop::drop(&mut self.owner);
            }
        }
    }
}
