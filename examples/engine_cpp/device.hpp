// Vulkan, as far as this engine needs it: owners that release what they hold.
#pragma once
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan.h>

// Throws unless a call has succeeded.
void check(VkResult result, const char* call);

// The instance, its messenger, one device with one queue.
class Device {
public:
    // `amend` may add to what the device is created with.
    Device(bool validate, const std::function<void(VkDeviceCreateInfo&)>& amend);
    ~Device();
    Device(const Device&) = delete;

    // Submits the commands and waits for their end.
    void run(const std::function<void(VkCommandBuffer)>& record) const;
    uint32_t memory_type(uint32_t allowed, VkMemoryPropertyFlags wanted) const;

    const bool debug_utils; // whether the instance has that extension
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice handle = VK_NULL_HANDLE;
    uint32_t family = 0;
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;

private:
    void create_instance();
    void create_device(const std::function<void(VkDeviceCreateInfo&)>& amend);
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
};

// What the validation layer has said so far, of all devices.
inline std::vector<std::string> validation_messages;

// Memory that the host writes or reads directly.
class Buffer {
public:
    Buffer(const Device& device, VkDeviceSize size, VkBufferUsageFlags usage);
    ~Buffer();
    Buffer(const Buffer&) = delete;

    VkBuffer handle = VK_NULL_HANDLE;
    void* mapped = nullptr;

private:
    const Device& device;
    VkDeviceMemory memory = VK_NULL_HANDLE;
};

// An image of one or more layers, all of which `view` shows; `layers` show one each.
class Image {
public:
    Image(const Device& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
          uint32_t layers = 1);
    ~Image();
    Image(const Image&) = delete;

    VkFormat format;
    VkImageAspectFlags aspect;
    VkImage handle = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    std::vector<VkImageView> layers;

private:
    const Device& device;
    VkDeviceMemory memory = VK_NULL_HANDLE;
};

// Where and how memory is accessed.
struct Access {
    VkPipelineStageFlags2 stage;
    VkAccessFlags2 access;
};

constexpr Access COLOR_WRITE{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                             VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT};
constexpr Access DEPTH_WRITE{
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT};
// By the engine's own fragment shaders, and by klieg's compute shaders.
constexpr Access SHADER_READ{
    VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    VK_ACCESS_2_SHADER_READ_BIT};
constexpr Access COPY_READ{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT};
constexpr Access COPY_WRITE{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT};
constexpr Access HOST_READ{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT};

void memory_barrier(VkCommandBuffer cmd, Access from, Access to);
void transition(VkCommandBuffer cmd, const Image& image, VkImageLayout from, VkImageLayout to,
                Access before, Access after);
