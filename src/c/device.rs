//! An engine's device, its queue's lock and its memory, as C hands them over.

use super::edge::{Fault, GetInstanceProcAddr, Outcome, given};
use super::requirements::{as_features, klieg_features};
use crate::gpu::{Access, BorrowedDevice, DeviceAllocator, DeviceMemory, MemoryRequest, QueueLock};
use ash::vk;
use std::ffi::{CString, c_char, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

/// Who touches a piece of memory: one of `KLIEG_ACCESS_...`.
pub type klieg_access = i32;
/// The device alone.
pub const KLIEG_ACCESS_DEVICE: klieg_access = 0;
/// The host writes, the device reads: must be mapped and host-coherent.
pub const KLIEG_ACCESS_UPLOAD: klieg_access = 1;
/// The device writes, the host reads: must be mapped and host-coherent.
pub const KLIEG_ACCESS_READBACK: klieg_access = 2;

/// What klieg asks an engine's allocator for: memory for one buffer, or for one image of optimal tiling.
#[repr(C)]
pub struct klieg_memory_request {
    /// What it is for, for people; valid during the call.
    pub name: *const c_char,
    /// Size, alignment and possible memory types.
    pub requirements: vk::MemoryRequirements,
    /// Who touches it.
    pub access: klieg_access,
    /// `VK_TRUE` for a buffer, `VK_FALSE` for an image: the two may have to keep a distance
    /// (`bufferImageGranularity`).
    pub linear: vk::Bool32,
}

/// A piece of device memory.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_memory {
    /// The memory that it is part of.
    pub memory: vk::DeviceMemory,
    /// Its first byte there, aligned as asked for.
    pub offset: vk::DeviceSize,
    /// Where its first byte is mapped for as long as it lives; `NULL` where it is not.
    pub mapped: *mut c_void,
    /// The allocator's own name for it.
    pub token: u64,
}

/// An engine's allocator. klieg calls it from one thread at a time, which need not be the one that
/// made the context. `user` and the functions stay valid until the context's last user has gone.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_allocator {
    /// Passed on to the functions.
    pub user: *mut c_void,
    /// Fills `*memory` and returns 0, or returns another number where there is none. The memory belongs
    /// to klieg alone until it is freed.
    pub allocate: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            request: *const klieg_memory_request,
            memory: *mut klieg_memory,
        ) -> i32,
    >,
    /// Takes back what `allocate` gave; the device no longer uses it.
    pub free: Option<unsafe extern "C" fn(user: *mut c_void, memory: *const klieg_memory)>,
    /// Bytes of device memory that the allocator holds for klieg at the moment, for
    /// `klieg_counters::memory`; may be `NULL`.
    pub capacity: Option<unsafe extern "C" fn(user: *mut c_void) -> u64>,
}

/// A device that an engine created, keeps and destroys.
#[repr(C)]
pub struct klieg_device {
    /// `vkGetInstanceProcAddr` of the loader that the instance comes from.
    pub get_instance_proc_addr: GetInstanceProcAddr,
    /// The instance.
    pub instance: vk::Instance,
    /// The Vulkan version that the instance was created for (`VkApplicationInfo::apiVersion`).
    pub api_version: u32,
    /// `VK_TRUE` where the instance was created with `VK_EXT_debug_utils`: then klieg names and labels
    /// what it makes and records.
    pub debug_utils: vk::Bool32,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: vk::Device,
    /// The queue that klieg submits to where it submits by itself.
    pub queue: vk::Queue,
    /// Family of that queue, and of the command buffers that klieg records into.
    pub queue_family: u32,
    /// What is enabled on the device: see `klieg_enabled_features`.
    pub features: klieg_features,
    /// Waits until the queue is free, and takes it: keeps the engine's threads off the queue while klieg
    /// submits. Both functions, or neither where only one thread uses the queue. klieg holds the lock for
    /// one `vkQueueSubmit` at a time and never while it waits.
    pub lock_queue: Option<unsafe extern "C" fn(user: *mut c_void)>,
    /// Gives the queue back, on the same thread.
    pub unlock_queue: Option<unsafe extern "C" fn(user: *mut c_void)>,
    /// Passed on to both; stays valid until the context's last user has gone.
    pub queue_user: *mut c_void,
    /// Where memory comes from; copied. klieg allocates blocks itself where it is `NULL`.
    pub allocator: *const klieg_allocator,
}

/// # Safety
/// The device's handles are valid and belong together; what it points to is valid.
pub(super) unsafe fn borrowed(device: &klieg_device) -> Outcome<BorrowedDevice> {
    let Some(get_instance_proc_addr) = device.get_instance_proc_addr else {
        return Err(Fault::argument("the device's get_instance_proc_addr is NULL"));
    };
    let null = [
        ("instance", device.instance == vk::Instance::null()),
        ("physical_device", device.physical_device == vk::PhysicalDevice::null()),
        ("device", device.device == vk::Device::null()),
        ("queue", device.queue == vk::Queue::null()),
    ];
    if let Some((name, _)) = null.into_iter().find(|(_, null)| *null) {
        return Err(Fault::argument(format!("the device's {name} is NULL")));
    }
    let loader = ash::StaticFn { get_instance_proc_addr };
    // SAFETY: the caller's promise.
    let (instance, raw) = unsafe {
        let instance = ash::Instance::load(&loader, device.instance);
        let raw = ash::Device::load(instance.fp_v1_0(), device.device);
        (instance, raw)
    };
    Ok(BorrowedDevice {
        instance,
        api_version: device.api_version,
        debug_utils: device.debug_utils != vk::FALSE,
        physical: device.physical_device,
        device: raw,
        queue: device.queue,
        queue_family: device.queue_family,
        features: as_features(&device.features),
        queue_lock: queue_lock(device)?,
        // SAFETY: as above.
        allocator: unsafe { allocator(device.allocator) }?,
    })
}

/// An engine's lock, by its functions.
struct Lock {
    lock: unsafe extern "C" fn(*mut c_void),
    unlock: unsafe extern "C" fn(*mut c_void),
    user: *mut c_void,
}

// SAFETY: a lock that only one thread could use would be none.
unsafe impl Send for Lock {}
// SAFETY: as above.
unsafe impl Sync for Lock {}

impl QueueLock for Lock {
    fn lock(&self) {
        // SAFETY: the engine's function and its own argument.
        unsafe { (self.lock)(self.user) };
    }

    fn unlock(&self) {
        // SAFETY: as above.
        unsafe { (self.unlock)(self.user) };
    }
}

fn queue_lock(device: &klieg_device) -> Outcome<Option<Arc<dyn QueueLock>>> {
    match (device.lock_queue, device.unlock_queue) {
        (Some(lock), Some(unlock)) => {
            Ok(Some(Arc::new(Lock { lock, unlock, user: device.queue_user })))
        }
        (None, None) => Ok(None),
        _ => Err(Fault::argument("of lock_queue and unlock_queue, one is NULL")),
    }
}

/// An engine's allocator, by its functions.
struct Functions {
    allocate:
        unsafe extern "C" fn(*mut c_void, *const klieg_memory_request, *mut klieg_memory) -> i32,
    free: unsafe extern "C" fn(*mut c_void, *const klieg_memory),
    capacity: Option<unsafe extern "C" fn(*mut c_void) -> u64>,
    user: *mut c_void,
}

// SAFETY: the header says that any thread may call, one at a time.
unsafe impl Send for Functions {}

/// # Safety
/// `allocator` is `NULL` or valid.
unsafe fn allocator(
    allocator: *const klieg_allocator,
) -> Outcome<Option<Box<dyn DeviceAllocator>>> {
    if allocator.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let klieg_allocator { user, allocate, free, capacity } =
        *unsafe { given(allocator, "the allocator") }?;
    match (allocate, free) {
        (Some(allocate), Some(free)) => {
            Ok(Some(Box::new(Functions { allocate, free, capacity, user })))
        }
        _ => Err(Fault::argument("the allocator's allocate or free is NULL")),
    }
}

// SAFETY: the header asks the engine's functions for what the trait asks for.
unsafe impl DeviceAllocator for Functions {
    fn allocate(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<DeviceMemory, Box<dyn std::error::Error + Send + Sync>> {
        let name = CString::new(request.name)?;
        let asked = klieg_memory_request {
            name: name.as_ptr(),
            requirements: request.requirements,
            access: match request.access {
                Access::Device => KLIEG_ACCESS_DEVICE,
                Access::Upload => KLIEG_ACCESS_UPLOAD,
                Access::Readback => KLIEG_ACCESS_READBACK,
            },
            linear: request.linear.into(),
        };
        let memory = vk::DeviceMemory::null();
        let mut given = klieg_memory { memory, offset: 0, mapped: std::ptr::null_mut(), token: 0 };
        // SAFETY: the engine's function and its own argument; the others live during the call.
        match unsafe { (self.allocate)(self.user, &asked, &mut given) } {
            0 => {}
            code => return Err(format!("the engine's allocator said {code}").into()),
        }
        let memory = DeviceMemory {
            memory: given.memory,
            offset: given.offset,
            mapped: NonNull::new(given.mapped.cast()),
            token: given.token,
        };
        if request.access != Access::Device && memory.mapped.is_none() {
            self.free(memory);
            return Err("the engine's allocator gave memory that is not mapped".into());
        }
        Ok(memory)
    }

    fn free(&mut self, memory: DeviceMemory) {
        let DeviceMemory { memory, offset, mapped, token } = memory;
        let mapped = mapped.map_or(std::ptr::null_mut(), |mapped| mapped.as_ptr().cast());
        let memory = klieg_memory { memory, offset, mapped, token };
        // SAFETY: as above.
        unsafe { (self.free)(self.user, &memory) };
    }

    fn capacity(&self) -> u64 {
        // SAFETY: as above.
        self.capacity.map_or(0, |capacity| unsafe { capacity(self.user) })
    }
}
