//! The engine's instance, device, queue, memory and shaders.

use crate::Result;
use ash::{ext, vk};
use bytemuck::{NoUninit, Pod};
use klieg::gpu::{BorrowedDevice, EnabledFeatures, FeatureChain, Needs};
use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What the validation layer says.
pub type Messages = Mutex<Vec<String>>;

pub struct Gpu {
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub family: u32,
    features: EnabledFeatures,
    memory: vk::PhysicalDeviceMemoryProperties,
    messenger: (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT),
    deletions: RefCell<Vec<Deletion>>,
    _messages: Arc<Messages>,
    _entry: ash::Entry,
}

/// Destroys something of the device.
type Deletion = Box<dyn FnOnce(&ash::Device)>;

impl Gpu {
    /// A device with what klieg needs and a feature of the engine's own.
    pub fn new(messages: &Arc<Messages>, needs: Needs) -> Result<Self> {
        // SAFETY: every structure and all that it points to outlive the calls.
        unsafe {
            let entry = ash::Entry::load()?;
            let instance = instance(&entry)?;
            let messenger = messenger(&entry, &instance, messages)?;
            let (physical, family) = choose(&instance)?;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let own = vk::PhysicalDeviceFeatures::default().independent_blend(true);
            let mut info =
                vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&own);
            let mut chain = FeatureChain::new(needs.requirements().features);
            chain.fill(&mut info)?;
            let features = EnabledFeatures::of(&info);
            let device = instance.create_device(physical, &info, None)?;
            let queue = device.get_device_queue(family, 0);
            let memory = instance.get_physical_device_memory_properties(physical);
            Ok(Self {
                instance,
                physical,
                device,
                queue,
                family,
                features,
                memory,
                messenger,
                deletions: RefCell::default(),
                _messages: Arc::clone(messages),
                _entry: entry,
            })
        }
    }

    /// What klieg borrows. There is one thread, so the queue needs no lock.
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

    /// Has `deletion` run when the device goes, the last one first.
    pub fn finally(&self, deletion: impl FnOnce(&ash::Device) + 'static) {
        self.deletions.borrow_mut().push(Box::new(deletion));
    }

    fn allocate(
        &self,
        needed: vk::MemoryRequirements,
        wanted: vk::MemoryPropertyFlags,
    ) -> Result<vk::DeviceMemory> {
        let fits = |&i: &u32| {
            needed.memory_type_bits >> i & 1 != 0
                && self.memory.memory_types[i as usize].property_flags.contains(wanted)
        };
        let kind = (0..self.memory.memory_type_count).find(fits).ok_or("no memory of this kind")?;
        let info =
            vk::MemoryAllocateInfo::default().allocation_size(needed.size).memory_type_index(kind);
        // SAFETY: the device is alive; the memory goes after what is bound to it.
        let memory = unsafe { self.device.allocate_memory(&info, None)? };
        // SAFETY: at the end nothing uses it any more.
        self.finally(move |device| unsafe { device.free_memory(memory, None) });
        Ok(memory)
    }

    /// Compiles GLSL.
    pub fn shader(&self, kind: shaderc::ShaderKind, source: &str) -> Result<vk::ShaderModule> {
        let compiler = shaderc::Compiler::new()?;
        let mut options = shaderc::CompileOptions::new()?;
        options.set_include_callback(|name, _, _, _| {
            let (resolved_name, content) = (name.into(), include_str!("shaders/frame.glsl").into());
            Ok(shaderc::ResolvedInclude { resolved_name, content })
        });
        let code = compiler.compile_into_spirv(source, kind, "shader", "main", Some(&options))?;
        let info = vk::ShaderModuleCreateInfo::default().code(code.as_binary());
        // SAFETY: the device is alive, and the code is a compiler's.
        let module = unsafe { self.device.create_shader_module(&info, None)? };
        // SAFETY: at the end nothing uses it any more.
        self.finally(move |device| unsafe { device.destroy_shader_module(module, None) });
        Ok(module)
    }

    /// A buffer that the host fills or reads.
    pub fn buffer(&self, size: usize, usage: vk::BufferUsageFlags) -> Result<Buffer> {
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let info = vk::BufferCreateInfo::default().size(size as u64).usage(usage);
        // SAFETY: the device is alive; the memory is the buffer's own.
        unsafe {
            let raw = self.device.create_buffer(&info, None)?;
            let memory = self.allocate(self.device.get_buffer_memory_requirements(raw), host)?;
            self.finally(move |device| device.destroy_buffer(raw, None));
            self.device.bind_buffer_memory(raw, memory, 0)?;
            let flags = vk::MemoryMapFlags::empty();
            let mapped = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, flags)?.cast();
            Ok(Buffer { raw, mapped, size })
        }
    }

    /// A buffer full of `data`.
    pub fn filled<T: NoUninit>(&self, data: &[T], usage: vk::BufferUsageFlags) -> Result<Buffer> {
        let buffer = self.buffer(size_of_val(data), usage)?;
        buffer.write(data);
        Ok(buffer)
    }

    /// An image that is drawn to.
    pub fn image(
        &self,
        [width, height]: [u32; 2],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Image> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let info = match format {
            vk::Format::R8G8B8A8_SRGB => info.flags(vk::ImageCreateFlags::MUTABLE_FORMAT),
            _ => info,
        };
        // SAFETY: the device is alive; the memory is the image's own.
        unsafe {
            let raw = self.device.create_image(&info, None)?;
            let needed = self.device.get_image_memory_requirements(raw);
            let memory = self.allocate(needed, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
            self.finally(move |device| device.destroy_image(raw, None));
            self.device.bind_image_memory(raw, memory, 0)?;
            let view = self.view(raw, format)?;
            Ok(Image { raw, view, format })
        }
    }

    /// A view of an image in a format that it may have.
    pub fn view(&self, image: vk::Image, format: vk::Format) -> Result<vk::ImageView> {
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(aspect(format))
            .level_count(1)
            .layer_count(1);
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(range);
        // SAFETY: the image is of this device; the view goes before it.
        let view = unsafe { self.device.create_image_view(&info, None)? };
        // SAFETY: at the end nothing uses it any more.
        self.finally(move |device| unsafe { device.destroy_image_view(view, None) });
        Ok(view)
    }
}

pub fn aspect(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

#[derive(Clone, Copy)]
pub struct Image {
    pub raw: vk::Image,
    pub view: vk::ImageView,
    pub format: vk::Format,
}

pub struct Buffer {
    pub raw: vk::Buffer,
    mapped: *mut u8,
    size: usize,
}

impl Buffer {
    /// Writes to its front; no commands that read it may run.
    pub fn write<T: NoUninit>(&self, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        assert!(bytes.len() <= self.size);
        // SAFETY: so many bytes are mapped.
        unsafe { self.mapped.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
    }

    /// Reads from its front; the commands that write it have run.
    pub fn read<T: Pod>(&self, data: &mut [T]) {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(data);
        assert!(bytes.len() <= self.size);
        // SAFETY: so many bytes are mapped.
        unsafe { self.mapped.copy_to_nonoverlapping(bytes.as_mut_ptr(), bytes.len()) };
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: all that the engine made goes here; klieg's context borrowed it and went before.
        unsafe {
            let _ = self.device.device_wait_idle();
            self.deletions.take().into_iter().rev().for_each(|delete| delete(&self.device));
            self.device.destroy_device(None);
            self.messenger.0.destroy_debug_utils_messenger(self.messenger.1, None);
            self.instance.destroy_instance(None);
        }
    }
}

fn instance(entry: &ash::Entry) -> Result<ash::Instance> {
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
    let layers = [VALIDATION.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
    let info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: every pointer outlives the call.
    Ok(unsafe { entry.create_instance(&info, None)? })
}

/// The first device with a queue that draws and computes.
fn choose(instance: &ash::Instance) -> Result<(vk::PhysicalDevice, u32)> {
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the instance is alive, and the devices are its own.
    unsafe {
        for physical in instance.enumerate_physical_devices()? {
            let families = instance.get_physical_device_queue_family_properties(physical);
            if let Some(i) = families.iter().position(|f| f.queue_flags.contains(wanted)) {
                return Ok((physical, i as u32));
            }
        }
    }
    Err("no Vulkan device draws and computes".into())
}

/// Collects what the layer says. The messages must outlive the messenger.
fn messenger(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Arc<Messages>,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
    use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
    use vk::DebugUtilsMessageTypeFlagsEXT as Kind;
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Kind::GENERAL | Kind::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(Arc::as_ptr(messages).cast_mut().cast());
    // SAFETY: the extension is enabled; the messages outlive the messenger.
    let raw = unsafe { loader.create_debug_utils_messenger(&info, None)? };
    Ok((loader, raw))
}

unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and the pointer that the messenger was made with.
    unsafe {
        let text = (*data).message_as_c_str().map_or("".into(), CStr::to_string_lossy);
        if let Ok(mut messages) = (*messages.cast::<Messages>()).lock() {
            messages.push(text.into_owned());
        }
    }
    vk::FALSE
}
