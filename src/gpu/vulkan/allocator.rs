//! Where device memory comes from: gpu-allocator, or the allocator of an engine.

use crate::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use std::collections::HashMap;
use std::ptr::NonNull;

/// Who touches a piece of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The device alone.
    Device,
    /// The host writes, the device reads.
    Upload,
    /// The device writes, the host reads.
    Readback,
}

/// What klieg asks an allocator for.
#[derive(Debug, Clone, Copy)]
pub struct MemoryRequest<'a> {
    /// What it is for, for people.
    pub name: &'a str,
    /// Size, alignment and possible memory types.
    pub requirements: vk::MemoryRequirements,
    /// Who touches it. All but [`Access::Device`] must be mapped, and host-coherent.
    pub access: Access,
    /// Whether it is for a buffer rather than an image of optimal tiling: the two may have to keep a
    /// distance (`bufferImageGranularity`).
    pub linear: bool,
}

/// A piece of device memory, bound to one buffer or image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceMemory {
    /// The memory that it is part of.
    pub memory: vk::DeviceMemory,
    /// Its first byte there, aligned as asked for.
    pub offset: u64,
    /// Where its first byte is mapped for as long as it lives.
    pub mapped: Option<NonNull<u8>>,
    /// The allocator's own name for it.
    pub token: u64,
}

// SAFETY: whoever holds the piece alone touches what is mapped, by the rules of its buffer.
unsafe impl Send for DeviceMemory {}
// SAFETY: as above.
unsafe impl Sync for DeviceMemory {}

/// Gives device memory. A [`Context`](crate::gpu::Context) calls it from one thread at a time.
///
/// # Safety
/// What [`DeviceAllocator::allocate`] gives satisfies its request, belongs to nobody else until it is
/// given to [`DeviceAllocator::free`], and lies where it lies until then.
pub unsafe trait DeviceAllocator: Send {
    /// Memory for one buffer or image.
    ///
    /// # Errors
    /// The reason why there is none.
    fn allocate(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<DeviceMemory, Box<dyn std::error::Error + Send + Sync>>;

    /// Takes back what [`DeviceAllocator::allocate`] gave; the device no longer uses it.
    fn free(&mut self, memory: DeviceMemory);

    /// Bytes of device memory that it holds at the moment, what it keeps for later included.
    fn capacity(&self) -> u64;
}

/// klieg's own: gpu-allocator, which takes device memory in blocks.
pub(in crate::gpu) struct Blocks {
    allocator: Allocator,
    given: HashMap<u64, Allocation>,
    next: u64,
}

impl Blocks {
    /// # Errors
    /// [`Error::DeviceMemory`].
    pub(in crate::gpu) fn new(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        device: &ash::Device,
    ) -> Result<Self> {
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })
        .map_err(|source| Error::DeviceMemory {
            what: "the allocator".into(),
            source: source.into(),
        })?;
        Ok(Self { allocator, given: HashMap::new(), next: 0 })
    }
}

// SAFETY: gpu-allocator gives each piece out once; its mapped types are host-coherent.
unsafe impl DeviceAllocator for Blocks {
    fn allocate(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<DeviceMemory, Box<dyn std::error::Error + Send + Sync>> {
        let allocation = self.allocator.allocate(&AllocationCreateDesc {
            name: request.name,
            requirements: request.requirements,
            location: match request.access {
                Access::Device => MemoryLocation::GpuOnly,
                Access::Upload => MemoryLocation::CpuToGpu,
                Access::Readback => MemoryLocation::GpuToCpu,
            },
            linear: request.linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        let token = self.next;
        self.next += 1;
        // SAFETY: the memory is used by the buffer or image that it is bound to alone.
        let memory = unsafe { allocation.memory() };
        let piece = DeviceMemory {
            memory,
            offset: allocation.offset(),
            mapped: allocation.mapped_ptr().map(NonNull::cast),
            token,
        };
        self.given.insert(token, allocation);
        Ok(piece)
    }

    fn free(&mut self, memory: DeviceMemory) {
        if let Some(allocation) = self.given.remove(&memory.token) {
            // It fails only for an allocation of another allocator.
            let _ = self.allocator.free(allocation);
        }
    }

    fn capacity(&self) -> u64 {
        self.allocator.capacity()
    }
}
