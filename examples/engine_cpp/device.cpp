#include "device.hpp"
#include <iostream>

void check(VkResult result, const char* call) {
    if (result != VK_SUCCESS)
        throw std::runtime_error(call + (" failed: " + std::to_string(result)));
}

namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL note(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                    VkDebugUtilsMessageTypeFlagsEXT,
                                    const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    // Newer layers leave the broken rule's name out of the text.
    const char* rule = data->pMessageIdName ? data->pMessageIdName : "";
    validation_messages.push_back(rule + (": " + std::string(data->pMessage)));
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info() {
    VkDebugUtilsMessengerCreateInfoEXT info{
        VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    // The type PERFORMANCE is advice: no rule is broken.
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = note;
    return info;
}

template <typename Function> Function instance_function(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

VkImageView make_view(VkDevice device, const Image& image, VkImageViewType type, uint32_t first,
                      uint32_t count) {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image.handle;
    info.viewType = type;
    info.format = image.format;
    info.subresourceRange = {image.aspect, 0, 1, first, count};
    VkImageView view;
    check(vkCreateImageView(device, &info, nullptr, &view), "vkCreateImageView");
    return view;
}

VkDeviceMemory allocate(const Device& device, const VkMemoryRequirements& needed,
                        VkMemoryPropertyFlags wanted) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = needed.size;
    info.memoryTypeIndex = device.memory_type(needed.memoryTypeBits, wanted);
    VkDeviceMemory memory;
    check(vkAllocateMemory(device.handle, &info, nullptr, &memory), "vkAllocateMemory");
    return memory;
}

} // namespace

Device::Device(bool validate, const std::function<void(VkDeviceCreateInfo&)>& amend)
    : debug_utils(validate) {
    create_instance();
    create_device(amend);
}

void Device::create_instance() {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = "engine";
    application.apiVersion = VK_API_VERSION_1_3;
    const char* layers[] = {"VK_LAYER_KHRONOS_validation"};
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkValidationFeatureEnableEXT checks[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkDebugUtilsMessengerCreateInfoEXT messages = messenger_info();
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messages};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = checks;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    if (debug_utils) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = layers;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
    }
    check(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
    if (debug_utils) {
        auto create = instance_function<PFN_vkCreateDebugUtilsMessengerEXT>(
            instance, "vkCreateDebugUtilsMessengerEXT");
        check(create(instance, &messages, nullptr, &messenger), "vkCreateDebugUtilsMessengerEXT");
    }
}

// The first device of Vulkan 1.3 that has a queue for graphics and compute.
void Device::create_device(const std::function<void(VkDeviceCreateInfo&)>& amend) {
    uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> devices(count);
    check(vkEnumeratePhysicalDevices(instance, &count, devices.data()),
          "vkEnumeratePhysicalDevices");
    for (VkPhysicalDevice candidate : devices) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(candidate, &properties);
        vkGetPhysicalDeviceQueueFamilyProperties(candidate, &count, nullptr);
        std::vector<VkQueueFamilyProperties> families(count);
        vkGetPhysicalDeviceQueueFamilyProperties(candidate, &count, families.data());
        constexpr VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
        for (uint32_t i = 0; i < count && !physical; ++i) {
            if (properties.apiVersion >= VK_API_VERSION_1_3 &&
                (families[i].queueFlags & wanted) == wanted) {
                physical = candidate;
                family = i;
                std::cout << "device: " << properties.deviceName << "\n";
            }
        }
    }
    if (!physical) throw std::runtime_error("no Vulkan 1.3 device for graphics and compute");

    float priority = 1;
    VkDeviceQueueCreateInfo queues{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queues.queueFamilyIndex = family;
    queues.queueCount = 1;
    queues.pQueuePriorities = &priority;
    VkPhysicalDeviceVulkan13Features features{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    features.dynamicRendering = VK_TRUE;
    features.synchronization2 = VK_TRUE;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queues;
    amend(info);
    check(vkCreateDevice(physical, &info, nullptr, &handle), "vkCreateDevice");
    vkGetDeviceQueue(handle, family, 0, &queue);

    VkCommandPoolCreateInfo pools{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pools.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pools.queueFamilyIndex = family;
    check(vkCreateCommandPool(handle, &pools, nullptr, &pool), "vkCreateCommandPool");
}

Device::~Device() {
    if (handle) {
        vkDestroyCommandPool(handle, pool, nullptr);
        vkDestroyDevice(handle, nullptr);
    }
    if (messenger) {
        instance_function<PFN_vkDestroyDebugUtilsMessengerEXT>(
            instance, "vkDestroyDebugUtilsMessengerEXT")(instance, messenger, nullptr);
    }
    vkDestroyInstance(instance, nullptr);
}

void Device::run(const std::function<void(VkCommandBuffer)>& record) const {
    VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    buffers.commandPool = pool;
    buffers.commandBufferCount = 1;
    VkCommandBuffer cmd;
    check(vkAllocateCommandBuffers(handle, &buffers, &cmd), "vkAllocateCommandBuffers");
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");
    record(cmd);
    check(vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &cmd;
    check(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    check(vkQueueWaitIdle(queue), "vkQueueWaitIdle");
    vkFreeCommandBuffers(handle, pool, 1, &cmd);
}

uint32_t Device::memory_type(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        if (allowed >> i & 1 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    }
    throw std::runtime_error("no memory of the type that is needed");
}

Buffer::Buffer(const Device& device, VkDeviceSize size, VkBufferUsageFlags usage) : device(device) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size;
    info.usage = usage;
    check(vkCreateBuffer(device.handle, &info, nullptr, &handle), "vkCreateBuffer");
    VkMemoryRequirements needed;
    vkGetBufferMemoryRequirements(device.handle, handle, &needed);
    memory = allocate(device, needed,
                      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(device.handle, handle, memory, 0), "vkBindBufferMemory");
    check(vkMapMemory(device.handle, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
}

Buffer::~Buffer() {
    vkDestroyBuffer(device.handle, handle, nullptr);
    vkFreeMemory(device.handle, memory, nullptr);
}

Image::Image(const Device& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
             uint32_t count)
    : format(format), aspect(format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT
                                                            : VK_IMAGE_ASPECT_COLOR_BIT),
      device(device) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size.width, size.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = count;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = usage;
    check(vkCreateImage(device.handle, &info, nullptr, &handle), "vkCreateImage");
    VkMemoryRequirements needed;
    vkGetImageMemoryRequirements(device.handle, handle, &needed);
    memory = allocate(device, needed, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkBindImageMemory(device.handle, handle, memory, 0), "vkBindImageMemory");
    VkImageViewType type = count > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view = make_view(device.handle, *this, type, 0, count);
    for (uint32_t i = 0; i < count; ++i) {
        layers.push_back(make_view(device.handle, *this, VK_IMAGE_VIEW_TYPE_2D, i, 1));
    }
}

Image::~Image() {
    for (VkImageView layer : layers) vkDestroyImageView(device.handle, layer, nullptr);
    vkDestroyImageView(device.handle, view, nullptr);
    vkDestroyImage(device.handle, handle, nullptr);
    vkFreeMemory(device.handle, memory, nullptr);
}

void memory_barrier(VkCommandBuffer cmd, Access from, Access to) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = from.stage;
    barrier.srcAccessMask = from.access;
    barrier.dstStageMask = to.stage;
    barrier.dstAccessMask = to.access;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(cmd, &info);
}

void transition(VkCommandBuffer cmd, const Image& image, VkImageLayout from, VkImageLayout to,
                Access before, Access after) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = before.stage;
    barrier.srcAccessMask = before.access;
    barrier.dstStageMask = after.stage;
    barrier.dstAccessMask = after.access;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.image = image.handle;
    barrier.subresourceRange = {image.aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(cmd, &info);
}
