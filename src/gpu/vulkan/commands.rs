//! Recording and running commands, with labels.

use super::memory::{Buffer, Image};
use crate::gpu::Context;
use crate::gpu::vulkan::Call;
use crate::{Error, Result};
use ash::vk;
use bytemuck::Pod;
use std::ffi::CString;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long the end of a run is waited for awake: about as long as a generation takes on a large GPU.
const SPIN: Duration = Duration::from_micros(200);
/// How long the end of a run is waited for at most. Runs are made to take a second on a slow GPU, a software device may
/// take many.
const LIMIT: Duration = Duration::from_secs(600);

/// A command buffer with its pool and the fence that tells its end.
pub struct Commands {
    pool: vk::CommandPool,
    fence: vk::Fence,
    raw: vk::CommandBuffer,
    /// Whether a run was started whose end nobody has waited for.
    started: bool,
    context: Arc<Context>,
}

impl Commands {
    /// An empty command buffer.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>) -> Result<Self> {
        let device = context.device()?;
        let mut commands = Self {
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            raw: vk::CommandBuffer::null(),
            started: false,
            context: Arc::clone(context),
        };
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(context.queue_family());
        // SAFETY: the device is alive; every info is complete; a half-made `commands` is dropped
        // on failure.
        unsafe {
            commands.pool = device.create_command_pool(&pool, None).call("vkCreateCommandPool")?;
            commands.fence =
                device.create_fence(&vk::FenceCreateInfo::default(), None).call("vkCreateFence")?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(commands.pool)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            commands.raw =
                device.allocate_command_buffers(&info).call("vkAllocateCommandBuffers")?[0];
        }
        Ok(commands)
    }

    /// Records what `body` does in place of what was recorded before, behind a barrier after all that earlier
    /// submissions did to klieg's memory. [`Commands::run`] may then run it any number of times.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`], and what `body` returns.
    pub fn record(&mut self, body: impl FnOnce(vk::CommandBuffer) -> Result<()>) -> Result<()> {
        self.finish()?;
        let device = self.context.device()?;
        if self.context.is_dry() {
            return Ok(());
        }
        // SAFETY: the end of the last run was waited for, so the command buffer is not in use.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .call("vkResetCommandPool")?;
            device
                .begin_command_buffer(self.raw, &vk::CommandBufferBeginInfo::default())
                .call("vkBeginCommandBuffer")?;
        }
        // A fence tells the host of an end; it lets no later commands see what was written.
        self.context.follow_all(self.raw);
        body(self.raw)?;
        // SAFETY: recording has begun above.
        unsafe { device.end_command_buffer(self.raw) }.call("vkEndCommandBuffer")
    }

    /// Runs what was recorded and waits for its end.
    ///
    /// # Errors
    /// As [`Commands::start`] and [`Commands::finish`].
    pub fn run(&mut self) -> Result<()> {
        self.start()?;
        self.finish()
    }

    /// Hands what was recorded to the device, behind the end of the last run.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`], a lost device among them.
    pub fn start(&mut self) -> Result<()> {
        self.finish()?;
        let device = self.context.device()?;
        if self.context.is_dry() {
            return Ok(());
        }
        let buffers = [self.raw];
        let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: the fence is alive, and no work that would signal it is under way.
        unsafe { device.reset_fences(&[self.fence]) }.call("vkResetFences")?;
        self.context.submit(&submit, self.fence)?;
        self.started = true;
        Ok(())
    }

    /// Waits for the end of the run that was started, if any was. A device that does not come to it is forgotten
    /// ([`Context::forget_device`]): what it still works on stays.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`], a lost device among them.
    pub fn finish(&mut self) -> Result<()> {
        if !std::mem::take(&mut self.started) {
            return Ok(());
        }
        let ended = self.wait(LIMIT);
        if let Err(Error::Vulkan { result: vk::Result::TIMEOUT, .. }) = ended {
            self.context.forget_device();
        }
        ended
    }

    /// Waits for the fence: looks at it again and again for a while, as waking a thread takes longer
    /// than many a generation.
    fn wait(&self, limit: Duration) -> Result<()> {
        let device = self.context.device()?;
        let start = Instant::now();
        while start.elapsed() < SPIN {
            // SAFETY: the fence is alive.
            if unsafe { device.get_fence_status(self.fence) }.call("vkGetFenceStatus")? {
                return Ok(());
            }
            std::hint::spin_loop();
        }
        let limit = u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX);
        // SAFETY: as above.
        unsafe { device.wait_for_fences(&[self.fence], true, limit) }.call("vkWaitForFences")
    }

    /// Records `body`, runs it once and waits.
    ///
    /// # Errors
    /// As [`Commands::record`] and [`Commands::run`].
    pub fn once(
        context: &Arc<Context>,
        body: impl FnOnce(vk::CommandBuffer) -> Result<()>,
    ) -> Result<()> {
        let mut commands = Self::new(context)?;
        commands.record(body)?;
        commands.run()
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // A lost device has ended its work, and one that does not answer is forgotten.
        let _ = self.finish();
        // SAFETY: no run is under way; null handles are allowed.
        self.context.unless_gone(|device| unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        });
    }
}

/// What an access to memory is: the pipeline stages and the kinds of access.
pub type Scope = (vk::PipelineStageFlags, vk::AccessFlags);

/// Compute shaders write.
pub const COMPUTE_WRITE: Scope =
    (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
/// Compute shaders read.
pub const COMPUTE_READ: Scope =
    (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
/// Fragments are written as colours.
pub const COLOR_WRITE: Scope =
    (vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT, vk::AccessFlags::COLOR_ATTACHMENT_WRITE);
/// Copies read.
pub const COPY_READ: Scope = (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ);
/// Copies write.
pub const COPY_WRITE: Scope = (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
/// The host reads mapped memory.
pub const HOST_READ: Scope = (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
/// Nothing came before.
pub const NOTHING: Scope = (vk::PipelineStageFlags::TOP_OF_PIPE, vk::AccessFlags::empty());

/// Whoever used klieg's memory before, on the device.
const EARLIER: Scope = (
    vk::PipelineStageFlags::from_raw(
        vk::PipelineStageFlags::ALL_GRAPHICS.as_raw()
            | vk::PipelineStageFlags::COMPUTE_SHADER.as_raw()
            | vk::PipelineStageFlags::TRANSFER.as_raw(),
    ),
    vk::AccessFlags::from_raw(
        vk::AccessFlags::MEMORY_READ.as_raw() | vk::AccessFlags::MEMORY_WRITE.as_raw(),
    ),
);
/// Bytes that one `vkCmdUpdateBuffer` may have at most.
const UPDATE_BYTES: usize = 65536;

impl Context {
    /// What klieg's recordings use, with the graphics stages where they draw.
    fn earlier(&self, draws: bool) -> Scope {
        match draws {
            true => EARLIER,
            false => (EARLIER.0 & !vk::PipelineStageFlags::ALL_GRAPHICS, EARLIER.1),
        }
    }

    /// Lets what follows in klieg's own commands use its memory after all that used it before.
    fn follow_all(&self, cmd: vk::CommandBuffer) {
        let all = self.earlier(self.needs().draws());
        self.barrier(cmd, all, all);
    }

    /// Lets what follows in an engine's commands use klieg's memory after all that used it in earlier
    /// recordings. Graphics stages take part only where recordings draw, so that an engine's own draws need
    /// not wait.
    pub(in crate::gpu) fn follow_earlier(&self, cmd: vk::CommandBuffer) {
        let earlier = self.earlier(self.needs().layers);
        self.barrier(cmd, earlier, earlier);
    }

    /// Copies `data` into the commands, and from there to the front of `to` when they run; shaders see
    /// it then. `to` may be a target of copies.
    pub(in crate::gpu) fn update<T: Pod>(&self, cmd: vk::CommandBuffer, to: &Buffer, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        for (i, piece) in bytes.chunks(UPDATE_BYTES).enumerate() {
            let offset = (i * UPDATE_BYTES) as u64;
            // SAFETY: `cmd` is being recorded on this device; the caller's buffer holds the data.
            unsafe { self.recorder().cmd_update_buffer(cmd, to.raw(), offset, piece) };
        }
        self.barrier(cmd, COPY_WRITE, self.earlier(self.needs().layers));
    }

    /// Makes what `before` wrote, in any memory, seen by `after`.
    pub(in crate::gpu) fn barrier(&self, cmd: vk::CommandBuffer, before: Scope, after: Scope) {
        let memory =
            [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: `cmd` is being recorded on this device.
        unsafe {
            self.recorder().cmd_pipeline_barrier(cmd, before.0, after.0, flags, &memory, &[], &[]);
        }
    }

    /// Moves an image to another layout between `before` and `after`.
    pub(in crate::gpu) fn transition(
        &self,
        cmd: vk::CommandBuffer,
        image: &Image,
        (from, to): (vk::ImageLayout, vk::ImageLayout),
        before: Scope,
        after: Scope,
    ) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(before.1)
            .dst_access_mask(after.1)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw())
            .subresource_range(image.range())];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: `cmd` is being recorded on this device, and the image is alive.
        unsafe {
            self.recorder().cmd_pipeline_barrier(cmd, before.0, after.0, flags, &[], &[], &barrier);
        }
    }

    /// Copies the front of `from` to one layer of `to`, which is in layout `GENERAL`.
    pub(in crate::gpu) fn upload(
        &self,
        cmd: vk::CommandBuffer,
        from: &Buffer,
        (to, layer): (&Image, u32),
    ) {
        let layout = vk::ImageLayout::GENERAL;
        // SAFETY: `cmd` is being recorded on this device; the caller's buffer holds a whole layer.
        unsafe {
            self.recorder().cmd_copy_buffer_to_image(
                cmd,
                from.raw(),
                to.raw(),
                layout,
                &[whole_layer(to, layer)],
            );
        }
    }

    /// Copies one layer of `from`, in the given layout, to the front of `to`.
    pub(in crate::gpu) fn download(
        &self,
        cmd: vk::CommandBuffer,
        (from, layout, layer): (&Image, vk::ImageLayout, u32),
        to: &Buffer,
    ) {
        let region = [whole_layer(from, layer)];
        // SAFETY: `cmd` is being recorded on this device; the caller's buffer holds a whole layer.
        unsafe {
            self.recorder().cmd_copy_image_to_buffer(cmd, from.raw(), layout, to.raw(), &region);
        }
    }

    /// Runs `body` between the begin and the end of a debug label.
    pub(in crate::gpu) fn labelled<T>(
        &self,
        cmd: vk::CommandBuffer,
        label: &str,
        body: impl FnOnce() -> T,
    ) -> T {
        let name = CString::new(label).unwrap_or_default();
        let info = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: `cmd` is being recorded; the extension is enabled where `debug` is present.
        unsafe {
            if let Some(debug) = self.debug() {
                debug.cmd_begin_debug_utils_label(cmd, &info);
            }
            let out = body();
            if let Some(debug) = self.debug() {
                debug.cmd_end_debug_utils_label(cmd);
            }
            out
        }
    }
}

fn whole_layer(image: &Image, layer: u32) -> vk::BufferImageCopy {
    let vk::Extent2D { width, height } = image.extent();
    vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: image.range().aspect_mask,
            mip_level: 0,
            base_array_layer: layer,
            layer_count: 1,
        })
        .image_extent(vk::Extent3D { width, height, depth: 1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;
    use crate::gpu::vulkan::memory::Access;

    /// Fills the same buffer twice, with or without a barrier between.
    fn fill_twice(context: &Arc<Context>, barrier: bool) {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(context, "filled twice", 64, usage, Access::Device).unwrap();
        Commands::once(context, |cmd| {
            for value in 0..2 {
                // SAFETY: the buffer is alive and may be filled.
                unsafe { context.recorder().cmd_fill_buffer(cmd, buffer.raw(), 0, 64, value) };
                if barrier {
                    context.barrier(cmd, COPY_WRITE, COPY_WRITE);
                }
            }
            Ok(())
        })
        .unwrap();
    }

    #[test]
    fn waits_have_a_limit() {
        let context = testing::context();
        let device = context.device().unwrap();
        // SAFETY: the device is alive, and the info complete.
        let event = unsafe { device.create_event(&vk::EventCreateInfo::default(), None) }.unwrap();
        let mut commands = Commands::new(&context).unwrap();
        let (from, to) = (vk::PipelineStageFlags::HOST, vk::PipelineStageFlags::TOP_OF_PIPE);
        let waits = |cmd| {
            // SAFETY: `cmd` is being recorded on the event's device.
            unsafe { device.cmd_wait_events(cmd, &[event], from, to, &[], &[], &[]) };
            Ok(())
        };
        commands.record(waits).unwrap();
        let buffers = [commands.raw];
        let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
        context.submit(&submit, commands.fence).unwrap();
        let begin = Instant::now();
        let fault = commands.wait(Duration::from_millis(20)).unwrap_err();
        assert!(fault.to_string().contains("vkWaitForFences") && fault.is_device(), "{fault}");
        assert!(begin.elapsed() < Duration::from_secs(5));
        // SAFETY: the event is alive; once it is set the commands end, and nobody uses it any more.
        unsafe {
            device.set_event(event).unwrap();
            commands.wait(LIMIT).unwrap();
            device.destroy_event(event, None);
        }
    }

    #[test]
    fn a_missing_barrier_is_reported() {
        let context = testing::context();
        fill_twice(&context, true);
        testing::assert_valid(&context);
        fill_twice(&context, false);
        let messages = context.validation_messages();
        assert!(
            messages.iter().any(|m| m.contains("SYNC-HAZARD-WRITE-AFTER-WRITE")),
            "{messages:?}"
        );
    }
}
