//! An engine's own Vulkan: instance, device and queue, under the validation layer.

use ash::{ext, vk};
use klieg::gpu::{
    BorrowedDevice, ComputeShape, Context, EnabledFeatures, FeatureChain, Needs, PipelineKind,
    QueueLock, Tuning,
};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// All that klieg can make use of.
pub const ALL: EnabledFeatures = EnabledFeatures {
    geometry_shader: true,
    shader_output_layer: true,
    full_draw_index_uint32: false,
    subgroup_size_control: false,
};

/// Each way to measure.
pub fn tunings() -> [Tuning; 3] {
    let of = |pipeline, shape| Tuning { pipeline: Some(pipeline), shape, ..Tuning::default() };
    [
        of(PipelineKind::Layered, None),
        of(PipelineKind::Compute, Some(ComputeShape::Runs)),
        of(PipelineKind::Compute, Some(ComputeShape::Tiles)),
    ]
}

/// What an engine creates for itself before it knows of klieg.
pub struct Engine {
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub family: u32,
    pub features: EnabledFeatures,
    messenger: (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT),
    messages: Box<Mutex<Vec<String>>>,
    _entry: ash::Entry,
}

impl Engine {
    /// A device with the given features, enabled in a chain that has others too.
    pub fn new(wanted: EnabledFeatures) -> Self {
        Self::made(wanted, Watch::Synchronization)
    }

    /// The same for several threads: without the layer's checks of synchronisation, which share what they
    /// know of command buffers between threads without a lock (1.3.239), and crash.
    pub fn for_threads(wanted: EnabledFeatures) -> Self {
        Self::made(wanted, Watch::Calls)
    }

    /// The same without the validation layer, which remembers all that it has seen.
    pub fn unwatched(wanted: EnabledFeatures) -> Self {
        Self::made(wanted, Watch::Nothing)
    }

    fn made(wanted: EnabledFeatures, watch: Watch) -> Self {
        if watch != Watch::Nothing {
            crate::gpu::alone();
        }
        // SAFETY: the system's loader; every info and its chain outlive their calls.
        unsafe {
            let entry = ash::Entry::load().expect("a Vulkan loader");
            let messages = Box::<Mutex<Vec<String>>>::default();
            let instance = instance(&entry, watch);
            let messenger = messenger(&entry, &instance, &messages);
            let physical = instance.enumerate_physical_devices().expect("devices")[0];
            let family = 0;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[0.5])];
            let own = vk::PhysicalDeviceFeatures::default().independent_blend(true);
            let mut vulkan12 =
                vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true);
            let mut info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&own)
                .push_next(&mut vulkan12);
            let mut chain = FeatureChain::new(wanted);
            chain.fill(&mut info).expect("a chain for klieg");
            let features = EnabledFeatures::of(&info);
            let device = instance.create_device(physical, &info, None).expect("a device");
            let queue = device.get_device_queue(family, 0);
            Self {
                _entry: entry,
                instance,
                physical,
                device,
                queue,
                family,
                features,
                messenger,
                messages,
            }
        }
    }

    /// What klieg is given.
    pub fn lend(&self) -> BorrowedDevice {
        BorrowedDevice {
            instance: self.instance.clone(),
            api_version: vk::API_VERSION_1_2,
            debug_utils: true,
            physical: self.physical,
            device: self.device.clone(),
            queue: self.queue,
            queue_family: self.family,
            features: self.features,
            queue_lock: None,
            allocator: None,
        }
    }

    /// klieg on this device.
    pub fn context(&self, tuning: &Tuning) -> Arc<Context> {
        self.context_for(Needs::ALL, tuning)
    }

    /// klieg on this device, for some needs alone.
    pub fn context_for(&self, needs: Needs, tuning: &Tuning) -> Arc<Context> {
        // SAFETY: the tests keep the engine while they use the context.
        unsafe { Context::borrow(self.lend(), needs, tuning) }.unwrap()
    }

    /// Destroys the device; gives what the validation layer said of all the engine's life.
    pub fn end(self) -> Vec<String> {
        // SAFETY: the tests have dropped what they made on the device, or test what happens else.
        unsafe {
            let _ = self.device.device_wait_idle();
            self.device.destroy_device(None);
            self.messenger.0.destroy_debug_utils_messenger(self.messenger.1, None);
            self.instance.destroy_instance(None);
        }
        self.messages.lock().unwrap().clone()
    }
}

/// A lock that counts.
#[derive(Default)]
pub struct CountedLock {
    held: Mutex<bool>,
    pub taken: std::sync::atomic::AtomicU32,
}

impl QueueLock for CountedLock {
    fn lock(&self) {
        let mut held = self.held.lock().unwrap();
        assert!(!*held, "klieg holds the lock twice");
        *held = true;
        self.taken.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }

    fn unlock(&self) {
        *self.held.lock().unwrap() = false;
    }
}

/// The lock as klieg takes it.
pub fn counted_lock() -> (Arc<CountedLock>, Option<Arc<dyn QueueLock>>) {
    let lock = Arc::<CountedLock>::default();
    (Arc::clone(&lock), Some(lock))
}

/// What the validation layer looks at.
#[derive(Clone, Copy, PartialEq)]
enum Watch {
    Nothing,
    Calls,
    Synchronization,
}

unsafe fn instance(entry: &ash::Entry, watch: Watch) -> ash::Instance {
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
    let layers = [VALIDATION.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    let info = match watch {
        Watch::Nothing => info.enabled_extension_names(&extensions[..1]),
        Watch::Calls => info.enabled_layer_names(&layers).enabled_extension_names(&extensions[..1]),
        Watch::Synchronization => info
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .push_next(&mut features),
    };
    // SAFETY: the caller's loader; every pointer outlives the call.
    unsafe { entry.create_instance(&info, None) }.expect("an instance, with its layer")
}

unsafe fn messenger(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Mutex<Vec<String>>,
) -> (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT) {
    use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
    use vk::DebugUtilsMessageTypeFlagsEXT as Kind;
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Kind::GENERAL | Kind::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast());
    // SAFETY: the extension is enabled, and the messages are boxed and outlive the messenger.
    let raw = unsafe { loader.create_debug_utils_messenger(&info, None) }.expect("a messenger");
    (loader, raw)
}

unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and the pointer that the messenger was made with.
    unsafe {
        let id = (*data).message_id_name_as_c_str();
        let text = (*data).message_as_c_str().map_or("".into(), CStr::to_string_lossy);
        // What layers that drivers bring ask of each other is neither klieg's nor the engine's doing.
        if id != Some(c"WARNING-vkGetDeviceProcAddr-device") {
            (*messages.cast::<Mutex<Vec<String>>>()).lock().unwrap().push(text.into_owned());
        }
    }
    vk::FALSE
}

/// A command buffer of the engine, submitted any number of times.
pub struct Frame<'a> {
    engine: &'a Engine,
    pool: vk::CommandPool,
    pub cmd: vk::CommandBuffer,
    fence: vk::Fence,
}

impl<'a> Frame<'a> {
    /// Records `body`.
    pub fn record(engine: &'a Engine, body: impl FnOnce(vk::CommandBuffer)) -> Self {
        let device = &engine.device;
        // SAFETY: the device is alive; every info is complete.
        unsafe {
            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(engine.family);
            let pool = device.create_command_pool(&pool, None).expect("a pool");
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let cmd = device.allocate_command_buffers(&info).expect("commands")[0];
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).expect("fence");
            let begin = vk::CommandBufferBeginInfo::default();
            device.begin_command_buffer(cmd, &begin).expect("a beginning");
            body(cmd);
            device.end_command_buffer(cmd).expect("an end");
            Self { engine, pool, cmd, fence }
        }
    }

    /// Submits it.
    pub fn submit(&self) {
        let cmds = [self.cmd];
        let info = [vk::SubmitInfo::default().command_buffers(&cmds)];
        // SAFETY: the commands are recorded, the fence is unsignalled.
        unsafe { self.engine.device.queue_submit(self.engine.queue, &info, self.fence) }
            .expect("a submission");
    }

    /// Waits for its end.
    pub fn wait(&self) {
        let fences = [self.fence];
        // SAFETY: the fence is alive and will be signalled.
        unsafe {
            self.engine.device.wait_for_fences(&fences, true, u64::MAX).expect("an end");
            self.engine.device.reset_fences(&fences).expect("a reset");
        }
    }
}

impl Drop for Frame<'_> {
    fn drop(&mut self) {
        // SAFETY: the tests wait for what they submit.
        unsafe {
            self.engine.device.destroy_fence(self.fence, None);
            self.engine.device.destroy_command_pool(self.pool, None);
        }
    }
}

/// A buffer of the engine that the host reads or fills.
pub struct HostBuffer<'a> {
    engine: &'a Engine,
    pub raw: vk::Buffer,
    memory: vk::DeviceMemory,
    mapped: *mut f32,
}

impl<'a> HostBuffer<'a> {
    /// Room for so many floats.
    pub fn new(engine: &'a Engine, floats: usize) -> Self {
        let device = &engine.device;
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: the device is alive; every info is complete.
        unsafe {
            let info = vk::BufferCreateInfo::default()
                .size(4 * floats as u64)
                .usage(vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC);
            let raw = device.create_buffer(&info, None).expect("a buffer");
            let needed = device.get_buffer_memory_requirements(raw);
            let types = engine.instance.get_physical_device_memory_properties(engine.physical);
            let fits = |&i: &u32| {
                needed.memory_type_bits >> i & 1 != 0
                    && types.memory_types[i as usize].property_flags.contains(host)
            };
            let kind = (0..types.memory_type_count).find(fits).expect("a memory type");
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needed.size)
                .memory_type_index(kind);
            let memory = device.allocate_memory(&info, None).expect("memory");
            device.bind_buffer_memory(raw, memory, 0).expect("a bound buffer");
            let flags = vk::MemoryMapFlags::empty();
            let mapped = device.map_memory(memory, 0, vk::WHOLE_SIZE, flags).expect("mapped");
            Self { engine, raw, memory, mapped: mapped.cast() }
        }
    }

    /// Full of `bytes`.
    pub fn filled(engine: &'a Engine, bytes: &[u8]) -> Self {
        let buffer = Self::new(engine, bytes.len().div_ceil(4).max(1));
        // SAFETY: so many bytes are mapped, and nothing uses them yet.
        unsafe { buffer.mapped.cast::<u8>().copy_from(bytes.as_ptr(), bytes.len()) };
        buffer
    }

    /// The floats from `first` on.
    pub fn read(&self, first: usize, count: usize) -> Vec<f32> {
        // SAFETY: so many floats are mapped, and the tests wait for the device.
        unsafe { std::slice::from_raw_parts(self.mapped.add(first), count) }.to_vec()
    }
}

impl Drop for HostBuffer<'_> {
    fn drop(&mut self) {
        // SAFETY: the tests wait for what they submit.
        unsafe {
            self.engine.device.destroy_buffer(self.raw, None);
            self.engine.device.free_memory(self.memory, None);
        }
    }
}

/// A picture of the engine, in layout `SHADER_READ_ONLY_OPTIMAL`.
pub struct Texture<'a> {
    engine: &'a Engine,
    raw: vk::Image,
    memory: vk::DeviceMemory,
    range: vk::ImageSubresourceRange,
    extent: vk::Extent3D,
    pub view: vk::ImageView,
}

impl<'a> Texture<'a> {
    /// `layers` pictures of `size` pixels, an array even of one where `array` says so.
    pub fn new(
        engine: &'a Engine,
        size: [u32; 2],
        (layers, array): (u32, bool),
        format: vk::Format,
        texels: &[u8],
    ) -> Self {
        let device = &engine.device;
        let depth = format == vk::Format::D32_SFLOAT;
        let aspect = if depth { vk::ImageAspectFlags::DEPTH } else { vk::ImageAspectFlags::COLOR };
        let extent = vk::Extent3D { width: size[0], height: size[1], depth: 1 };
        // SAFETY: the device is alive; every info is complete.
        let texture = unsafe {
            let info = vk::ImageCreateInfo::default()
                .image_type(vk::ImageType::TYPE_2D)
                .format(format)
                .extent(extent)
                .mip_levels(1)
                .array_layers(layers)
                .samples(vk::SampleCountFlags::TYPE_1)
                .usage(vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST);
            let raw = device.create_image(&info, None).expect("an image");
            let needed = device.get_image_memory_requirements(raw);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needed.size)
                .memory_type_index(needed.memory_type_bits.trailing_zeros());
            let memory = device.allocate_memory(&info, None).expect("memory");
            device.bind_image_memory(raw, memory, 0).expect("a bound image");
            let kind =
                if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
            let range = vk::ImageSubresourceRange::default()
                .aspect_mask(aspect)
                .level_count(1)
                .layer_count(layers);
            let info = vk::ImageViewCreateInfo::default()
                .image(raw)
                .view_type(kind)
                .format(format)
                .subresource_range(range);
            let view = device.create_image_view(&info, None).expect("a view");
            Self { engine, raw, memory, range, extent, view }
        };
        let staging = HostBuffer::filled(engine, texels);
        let frame = Frame::record(engine, |cmd| {
            let nothing = (vk::PipelineStageFlags::TOP_OF_PIPE, vk::AccessFlags::empty());
            texture.overwrite(cmd, &staging, nothing, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        });
        frame.submit();
        frame.wait();
        texture
    }

    /// Records the filling of all layers after those before have been used, and leaves them to compute
    /// shaders in `layout`.
    pub fn overwrite(
        &self,
        cmd: vk::CommandBuffer,
        from: &HostBuffer<'_>,
        before: (vk::PipelineStageFlags, vk::AccessFlags),
        layout: vk::ImageLayout,
    ) {
        let range = self.range;
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(range.aspect_mask)
            .layer_count(range.layer_count);
        let region =
            [vk::BufferImageCopy::default().image_subresource(layers).image_extent(self.extent)];
        let copied = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let write = (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
        let read = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
        self.transition(cmd, (vk::ImageLayout::UNDEFINED, copied), before, write);
        // SAFETY: `cmd` is being recorded; the image is alive, and the buffer holds all layers.
        unsafe {
            let device = &self.engine.device;
            device.cmd_copy_buffer_to_image(cmd, from.raw, self.raw, copied, &region);
        }
        self.transition(cmd, (copied, layout), write, read);
    }

    fn transition(
        &self,
        cmd: vk::CommandBuffer,
        (from, to): (vk::ImageLayout, vk::ImageLayout),
        before: (vk::PipelineStageFlags, vk::AccessFlags),
        after: (vk::PipelineStageFlags, vk::AccessFlags),
    ) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .image(self.raw)
            .old_layout(from)
            .new_layout(to)
            .src_access_mask(before.1)
            .dst_access_mask(after.1)
            .subresource_range(self.range)];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: `cmd` is being recorded; the image is alive.
        unsafe {
            let device = &self.engine.device;
            device.cmd_pipeline_barrier(cmd, before.0, after.0, flags, &[], &[], &barrier);
        }
    }
}

impl Drop for Texture<'_> {
    fn drop(&mut self) {
        // SAFETY: the tests wait for what they submit.
        unsafe {
            self.engine.device.destroy_image_view(self.view, None);
            self.engine.device.destroy_image(self.raw, None);
            self.engine.device.free_memory(self.memory, None);
        }
    }
}
