//! Buffers and images with their memory.

pub use super::allocator::Access;
use super::allocator::MemoryRequest;
use super::usage::Piece;
use crate::Result;
use crate::gpu::Context;
use crate::gpu::vulkan::Call;
use ash::vk;
use bytemuck::Pod;
use std::ptr::NonNull;
use std::sync::Arc;

/// A buffer, mapped for as long as it lives unless only the device touches it.
pub struct Buffer {
    raw: vk::Buffer,
    piece: Option<Piece>,
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
        let device = context.device()?;
        // SAFETY: the device is alive; `info` is complete.
        let raw = unsafe { device.create_buffer(&info, None) }.call("vkCreateBuffer")?;
        let mut buffer = Self { raw, piece: None, size, context: Arc::clone(context) };
        // SAFETY: the buffer was made on this device.
        let requirements = unsafe { device.get_buffer_memory_requirements(raw) };
        let request = MemoryRequest { name, requirements, access, linear: true };
        let piece = buffer.piece.insert(context.allocate(&request)?);
        if let Some(memory) = piece.memory {
            // SAFETY: the memory is fresh, large enough and of a type that the buffer allows.
            unsafe { device.bind_buffer_memory(raw, memory.memory, memory.offset) }
                .call("vkBindBufferMemory")?;
        }
        context.name(raw, name);
        Ok(buffer)
    }

    /// A buffer of `size` bytes that the device alone touches, once it has been filled by a copy.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn device(
        context: &Arc<Context>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        Self::new(context, name, size, usage | vk::BufferUsageFlags::TRANSFER_DST, Access::Device)
    }

    /// A storage buffer of `size` bytes that the device alone touches.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when that is more than the device can take, and as [`Buffer::new`].
    pub fn storage(context: &Arc<Context>, name: &str, size: u64) -> Result<Self> {
        let largest = u64::from(context.limits().max_storage_buffer_range);
        if size > largest {
            return Err(context.unsupported(format!("{size} bytes of {name} (it has {largest})")));
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        Self::device(context, name, size, usage)
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
        buffer.write(data)?;
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
    /// # Errors
    /// [`crate::Error::Forgotten`].
    ///
    /// # Panics
    /// When the buffer is not [`Access::Upload`] or too small.
    pub fn write<T: Pod>(&mut self, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        if let Some(to) = self.mapped(bytes.len())? {
            // SAFETY: so many bytes are mapped there, for this buffer alone.
            unsafe { to.copy_from_nonoverlapping(NonNull::from(bytes).cast(), bytes.len()) };
        }
        Ok(())
    }

    /// Reads the front of the buffer; the work that wrote it must have ended. Counted in
    /// [`crate::gpu::Counters::bytes_read`].
    ///
    /// # Errors
    /// [`crate::Error::Forgotten`].
    ///
    /// # Panics
    /// When the buffer is not [`Access::Readback`] or too small.
    pub fn read<T: Pod>(&self, out: &mut [T]) -> Result<()> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(out);
        if let Some(from) = self.mapped(bytes.len())? {
            // SAFETY: so many bytes are mapped there, and the device no longer writes them.
            unsafe { from.copy_to_nonoverlapping(NonNull::from(&mut *bytes).cast(), bytes.len()) };
        }
        self.context.count_read(bytes.len());
        Ok(())
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        self.piece.as_ref().map_or(0, |piece| piece.bytes)
    }

    /// The first of `bytes` mapped bytes, which are there as long as the device is; none on a dry context.
    fn mapped(&self, bytes: usize) -> Result<Option<NonNull<u8>>> {
        self.context.check_present()?;
        assert!(bytes as u64 <= self.size, "{bytes} bytes in a buffer of {}", self.size);
        let memory = self.piece.as_ref().and_then(|piece| piece.memory);
        Ok(memory.map(|memory| memory.mapped.expect("a mapped buffer")))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the buffer before they drop it.
        self.context.unless_gone(|device| unsafe { device.destroy_buffer(self.raw, None) });
        if let Some(piece) = self.piece.take() {
            self.context.free(piece);
        }
    }
}

/// A buffer in device memory that shaders read as texels.
pub struct TexelBuffer {
    buffer: Buffer,
    view: vk::BufferView,
}

impl TexelBuffer {
    /// A buffer of `texels` texels of `size` bytes, written as `usage` says.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] for more texels than the device can address, and as
    /// [`Buffer::new`].
    pub fn new(
        context: &Arc<Context>,
        name: &str,
        texels: u64,
        (format, size): (vk::Format, u64),
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let most = u64::from(context.limits().max_texel_buffer_elements);
        if texels > most {
            let lacks = format!("{texels} texels of {name} (it has {most})");
            return Err(context.unsupported(lacks));
        }
        let usage =
            usage | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        let buffer = Buffer::new(context, name, texels * size, usage, Access::Device)?;
        let mut texels = Self { buffer, view: vk::BufferView::null() };
        if context.is_dry() {
            return Ok(texels);
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(texels.buffer.raw)
            .format(format)
            .range(vk::WHOLE_SIZE);
        // SAFETY: the buffer is bound and alive.
        texels.view = unsafe { context.device()?.create_buffer_view(&info, None) }
            .call("vkCreateBufferView")?;
        Ok(texels)
    }

    /// The buffer itself.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// A view of all of it.
    pub fn view(&self) -> vk::BufferView {
        self.view
    }
}

impl Drop for TexelBuffer {
    fn drop(&mut self) {
        let context = &self.buffer.context;
        // SAFETY: owners wait for the work that uses the buffer before they drop it; a null handle
        // is allowed.
        context.unless_gone(|device| unsafe { device.destroy_buffer_view(self.view, None) });
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
    piece: Option<Piece>,
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
        let raw = unsafe { context.device()?.create_image(&info, None) }.call("vkCreateImage")?;
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            piece: None,
            range: vk::ImageSubresourceRange::default()
                .aspect_mask(aspect)
                .level_count(desc.mips)
                .layer_count(layers),
            extent: vk::Extent2D { width: desc.width, height: desc.height },
            format: desc.format,
            context: Arc::clone(context),
        };
        image.bind(desc.name)?;
        let kind = match desc.layers {
            Some(_) => vk::ImageViewType::TYPE_2D_ARRAY,
            None => vk::ImageViewType::TYPE_2D,
        };
        image.view = image.create_view(kind, image.range)?;
        context.name(raw, desc.name);
        Ok(image)
    }

    fn bind(&mut self, name: &str) -> Result<()> {
        let device = self.context.device()?;
        // SAFETY: the image was made on this device.
        let requirements = unsafe { device.get_image_memory_requirements(self.raw) };
        let request = MemoryRequest { name, requirements, access: Access::Device, linear: false };
        let Some(memory) = self.piece.insert(self.context.allocate(&request)?).memory else {
            return Ok(());
        };
        // SAFETY: the memory is fresh, large enough and of a type that the image allows.
        unsafe { device.bind_image_memory(self.raw, memory.memory, memory.offset) }
            .call("vkBindImageMemory")
    }

    fn create_view(
        &self,
        kind: vk::ImageViewType,
        range: vk::ImageSubresourceRange,
    ) -> Result<vk::ImageView> {
        if self.context.is_dry() {
            return Ok(vk::ImageView::null());
        }
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.format)
            .subresource_range(range);
        // SAFETY: the image is bound and alive.
        unsafe { self.context.device()?.create_image_view(&info, None) }.call("vkCreateImageView")
    }

    /// A view of one layer, which a draw can write.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn layer_view(&self, layer: u32) -> Result<LayerView> {
        let range =
            vk::ImageSubresourceRange { base_array_layer: layer, layer_count: 1, ..self.range };
        let raw = self.create_view(vk::ImageViewType::TYPE_2D, range)?;
        Ok(LayerView { raw, context: Arc::clone(&self.context) })
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Image {
        self.raw
    }

    /// A view of all of it.
    pub fn view(&self) -> vk::ImageView {
        self.view
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        self.piece.as_ref().map_or(0, |piece| piece.bytes)
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

/// A view of one layer of an [`Image`], whose owner keeps it for as long.
pub struct LayerView {
    raw: vk::ImageView,
    context: Arc<Context>,
}

impl LayerView {
    /// The Vulkan handle.
    pub fn raw(&self) -> vk::ImageView {
        self.raw
    }
}

impl Drop for LayerView {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the view before they drop it.
        self.context.unless_gone(|device| unsafe { device.destroy_image_view(self.raw, None) });
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the image before they drop it; null handles
        // are allowed.
        self.context.unless_gone(|device| unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.raw, None);
        });
        if let Some(piece) = self.piece.take() {
            self.context.free(piece);
        }
    }
}
