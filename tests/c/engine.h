/* What an engine in C has of its own before it knows of klieg, and what it shows klieg. */

#include "check.h"

#define VK(call) expect((call) == VK_SUCCESS, #call, __LINE__)

enum { SIDE = 32, PIXELS = SIDE * SIDE };

static VkInstance instance;
/* Keeps the driver loaded, so that a leak's report can name it. */
static VkInstance kept;
static VkDebugUtilsMessengerEXT messenger;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static VkCommandPool pool;
static klieg_features features;

/* Prints what the validation layer complains of, the name of the broken rule first. */
static VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                               VkDebugUtilsMessageTypeFlagsEXT types,
                                               const VkDebugUtilsMessengerCallbackDataEXT *data,
                                               void *user) {
    (void)severity, (void)types, (void)user;
    printf("complaint %s: %s\n", data->pMessageIdName ? data->pMessageIdName : "", data->pMessage);
    return VK_FALSE;
}

static void listen(void) {
    const VkDebugUtilsMessengerCreateInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = complain};
    const PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance,
                                                                  "vkCreateDebugUtilsMessengerEXT");
    VK(create(instance, &info, NULL, &messenger));
}

static void destroy_instance(void) {
    if (messenger) {
        const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
                instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(instance, messenger, NULL);
    }
    vkDestroyInstance(instance, NULL);
}

static void make_device(int validate) {
    const char *layer = "VK_LAYER_KHRONOS_validation";
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT synchronization =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT checks = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = &synchronization};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_2};
    const VkInstanceCreateInfo of_instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                              .pNext = validate ? &checks : NULL,
                                              .pApplicationInfo = &application,
                                              .enabledLayerCount = validate ? 1 : 0,
                                              .ppEnabledLayerNames = &layer,
                                              .enabledExtensionCount = validate ? 2 : 0,
                                              .ppEnabledExtensionNames = extensions};
    VK(vkCreateInstance(&of_instance, NULL, &kept));
    VK(vkCreateInstance(&of_instance, NULL, &instance));
    if (validate) {
        listen();
    }
    uint32_t one = 1;
    const VkResult found = vkEnumeratePhysicalDevices(instance, &one, &physical);
    EXPECT(found == VK_SUCCESS || found == VK_INCOMPLETE);
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queues = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                            .queueCount = 1,
                                            .pQueuePriorities = &priority};
    VkPhysicalDeviceFeatures own = {.independentBlend = VK_TRUE};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queues,
                               .pEnabledFeatures = &own};
    klieg_feature_chain chain;
    REFUSE(NULL, klieg_enable_features(4, &info, &chain), KLIEG_ERROR_ARGUMENT, "0x4");
    CHECK(NULL, klieg_enable_features(KLIEG_NEEDS_ALL, &info, &chain));
    CHECK(NULL, klieg_enabled_features(&info, &features));
    EXPECT(features.geometry_shader && features.shader_output_layer);
    EXPECT(info.pEnabledFeatures->independentBlend);
    VK(vkCreateDevice(physical, &info, NULL, &device));
    vkGetDeviceQueue(device, 0, 0, &queue);
    const VkCommandPoolCreateInfo of_pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    VK(vkCreateCommandPool(device, &of_pool, NULL, &pool));
}

static VkCommandBuffer begin(void) {
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = pool,
                                              .commandBufferCount = 1};
    const VkCommandBufferBeginInfo beginning = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VK(vkAllocateCommandBuffers(device, &info, &commands));
    VK(vkBeginCommandBuffer(commands, &beginning));
    return commands;
}

static void finish(VkCommandBuffer commands) {
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &commands};
    VK(vkEndCommandBuffer(commands));
    VK(vkQueueSubmit(queue, 1, &info, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(queue));
    vkFreeCommandBuffers(device, pool, 1, &commands);
}

static uint32_t memory_type(uint32_t bits, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    uint32_t type = 0;
    while (!(bits >> type & 1) || (types.memoryTypes[type].propertyFlags & wanted) != wanted) {
        type++;
    }
    return type;
}

static VkDeviceMemory allocate(VkMemoryRequirements needed, VkMemoryPropertyFlags wanted) {
    VkDeviceMemory memory;
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .allocationSize = needed.size,
                                       .memoryTypeIndex = memory_type(needed.memoryTypeBits, wanted)};
    VK(vkAllocateMemory(device, &info, NULL, &memory));
    return memory;
}

/* An image of floats, or an array of them, in layout GENERAL. */
typedef struct picture {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
} picture;

static picture make_picture(uint32_t layers, VkBuffer content) {
    picture made;
    const VkImageCreateInfo of_image = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = VK_FORMAT_R32_SFLOAT,
        .extent = {SIDE, SIDE, 1},
        .mipLevels = 1,
        .arrayLayers = layers,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    VkMemoryRequirements needed;
    VK(vkCreateImage(device, &of_image, NULL, &made.image));
    vkGetImageMemoryRequirements(device, made.image, &needed);
    made.memory = allocate(needed, 0);
    VK(vkBindImageMemory(device, made.image, made.memory, 0));
    const VkImageViewCreateInfo of_view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = made.image,
        .viewType = layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
        .format = VK_FORMAT_R32_SFLOAT,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers}};
    VK(vkCreateImageView(device, &of_view, NULL, &made.view));

    VkCommandBuffer commands = begin();
    VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                    .dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                    .newLayout = VK_IMAGE_LAYOUT_GENERAL,
                                    .image = made.image,
                                    .subresourceRange = of_view.subresourceRange};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                         0, NULL, 0, NULL, 1, &barrier);
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers},
                                      .imageExtent = {SIDE, SIDE, 1}};
    vkCmdCopyBufferToImage(commands, content, made.image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_GENERAL;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                         0, 0, NULL, 0, NULL, 1, &barrier);
    finish(commands);
    return made;
}

static void drop_picture(picture dropped) {
    vkDestroyImageView(device, dropped.view, NULL);
    vkDestroyImage(device, dropped.image, NULL);
    vkFreeMemory(device, dropped.memory, NULL);
}

/* A buffer of floats that the host sees. */
typedef struct floats {
    VkBuffer buffer;
    VkDeviceMemory memory;
    float *mapped;
} floats;

static floats make_floats(uint32_t count) {
    floats made;
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = count * sizeof(float),
        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkMemoryRequirements needed;
    void *mapped;
    VK(vkCreateBuffer(device, &info, NULL, &made.buffer));
    vkGetBufferMemoryRequirements(device, made.buffer, &needed);
    made.memory = allocate(needed, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                       VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(device, made.buffer, made.memory, 0));
    VK(vkMapMemory(device, made.memory, 0, VK_WHOLE_SIZE, 0, &mapped));
    made.mapped = mapped;
    return made;
}

static void drop_floats(floats dropped) {
    vkDestroyBuffer(device, dropped.buffer, NULL);
    vkFreeMemory(device, dropped.memory, NULL);
}

/* An orthographic look along -z at a depth that waves. */
static const klieg_engine_camera CAMERA = {
    .view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -2, 1},
    .projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -0.25, 0, 0, 0, 0, 1},
    .center = {0, 0, 0},
    .radius = 1.5};

static picture make_depth(void) {
    floats content = make_floats(PIXELS);
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % SIDE, y = i / SIDE;
        content.mapped[i] = x < 4 ? 1.0f : 0.4f + 0.003f * (float)((x - 18) * (x - 18) + y) / 4.0f;
    }
    picture depth = make_picture(1, content.buffer);
    drop_floats(content);
    return depth;
}
