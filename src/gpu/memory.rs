//! Buffers and images with their memory.

use super::{Call, Context};
use crate::Result;
use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Who touches a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The device alone.
    Device,
    /// The host writes, the device reads.
    Upload,
    /// The device writes, the host reads.
    Readback,
}

/// A buffer, mapped for as long as it lives unless only the device touches it.
pub struct Buffer {
    raw: vk::Buffer,
    allocation: Option<Allocation>,
    size: u64,
    context: Arc<Context>,
}

impl Buffer {
    /// A buffer of `size` bytes (at least 1).
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`], [`crate::Error::DeviceMemory`].
    pub fn new(
        context: &Arc<Context>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        access: Access,
    ) -> Result<Self> {
        let info = vk::BufferCreateInfo::default().size(size.max(1)).usage(usage);
        let device = context.device();
        // SAFETY: the device is alive; `info` is complete.
        let raw = unsafe { device.create_buffer(&info, None) }.call("vkCreateBuffer")?;
        let mut buffer = Self { raw, allocation: None, size, context: Arc::clone(context) };
        // SAFETY: the buffer was made on this device.
        let requirements = unsafe { device.get_buffer_memory_requirements(raw) };
        let allocation = context.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: match access {
                Access::Device => MemoryLocation::GpuOnly,
                Access::Upload => MemoryLocation::CpuToGpu,
                Access::Readback => MemoryLocation::GpuToCpu,
            },
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the memory is fresh, large enough and of a type that the buffer allows.
        let bound =
            unsafe { device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        buffer.allocation = Some(allocation);
        bound.call("vkBindBufferMemory")?;
        context.name(raw, name);
        Ok(buffer)
    }

    /// A buffer that the host fills once with `data`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn of<T: Pod>(
        context: &Arc<Context>,
        name: &str,
        data: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let size = size_of_val(data) as u64;
        let mut buffer = Self::new(context, name, size, usage, Access::Upload)?;
        buffer.write(data);
        Ok(buffer)
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Buffer {
        self.raw
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Writes `data` at the front; the device sees it in the next submission.
    ///
    /// # Panics
    /// When the buffer is not [`Access::Upload`] or too small.
    pub fn write<T: Pod>(&mut self, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        mapped.expect("a mapped buffer")[..bytes.len()].copy_from_slice(bytes);
    }

    /// Reads the front of the buffer; the work that wrote it must have ended. Counted in
    /// [`super::Counters::bytes_read`].
    ///
    /// # Panics
    /// When the buffer is not [`Access::Readback`] or too small.
    pub fn read<T: Pod>(&self, out: &mut [T]) {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(out);
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_slice);
        bytes.copy_from_slice(&mapped.expect("a mapped buffer")[..bytes.len()]);
        self.context.count_read(bytes.len());
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the buffer before they drop it.
        unsafe { self.context.device().destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            self.context.free(allocation);
        }
    }
}

/// What an [`Image`] is made of.
#[derive(Debug, Clone, Copy)]
pub struct ImageDesc<'a> {
    /// For debuggers.
    pub name: &'a str,
    /// Format of a texel.
    pub format: vk::Format,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Layers; the view is an array where given, even of one layer.
    pub layers: Option<u32>,
    /// Mip levels, at least 1.
    pub mips: u32,
    /// What is done with it.
    pub usage: vk::ImageUsageFlags,
}

/// A two-dimensional image in device memory, with a view of all of it.
pub struct Image {
    raw: vk::Image,
    view: vk::ImageView,
    allocation: Option<Allocation>,
    range: vk::ImageSubresourceRange,
    extent: vk::Extent2D,
    format: vk::Format,
    context: Arc<Context>,
}

impl Image {
    /// An image in layout `UNDEFINED`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`], [`crate::Error::DeviceMemory`].
    pub fn new(context: &Arc<Context>, desc: &ImageDesc<'_>) -> Result<Self> {
        let aspect = match desc.format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let layers = desc.layers.unwrap_or(1);
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.width, height: desc.height, depth: 1 })
            .mip_levels(desc.mips)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(desc.usage);
        // SAFETY: the device is alive; `info` is complete.
        let raw = unsafe { context.device().create_image(&info, None) }.call("vkCreateImage")?;
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            range: vk::ImageSubresourceRange::default()
                .aspect_mask(aspect)
                .level_count(desc.mips)
                .layer_count(layers),
            extent: vk::Extent2D { width: desc.width, height: desc.height },
            format: desc.format,
            context: Arc::clone(context),
        };
        image.bind(desc.name)?;
        image.create_view(desc.layers.is_some())?;
        context.name(raw, desc.name);
        Ok(image)
    }

    fn bind(&mut self, name: &str) -> Result<()> {
        let device = self.context.device();
        // SAFETY: the image was made on this device.
        let requirements = unsafe { device.get_image_memory_requirements(self.raw) };
        let allocation = self.context.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the memory is fresh, large enough and of a type that the image allows.
        let bound =
            unsafe { device.bind_image_memory(self.raw, allocation.memory(), allocation.offset()) };
        self.allocation = Some(allocation);
        bound.call("vkBindImageMemory")
    }

    fn create_view(&mut self, array: bool) -> Result<()> {
        let kind =
            if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.format)
            .subresource_range(self.range);
        // SAFETY: the image is bound and alive.
        self.view = unsafe { self.context.device().create_image_view(&info, None) }
            .call("vkCreateImageView")?;
        Ok(())
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Image {
        self.raw
    }

    /// A view of all of it.
    pub fn view(&self) -> vk::ImageView {
        self.view
    }

    /// All of it.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        self.range
    }

    /// Width and height, pixels.
    pub fn extent(&self) -> vk::Extent2D {
        self.extent
    }

    /// Format of a texel.
    pub fn format(&self) -> vk::Format {
        self.format
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        let device = self.context.device();
        // SAFETY: owners wait for the work that uses the image before they drop it; null handles
        // are allowed.
        unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.context.free(allocation);
        }
    }
}
