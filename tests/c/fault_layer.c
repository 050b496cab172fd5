/* A Vulkan layer by which devices fail, or are weaker than they are. KLIEG_TEST_FAULT names a call, how often it works,
 * and what it returns from then on (a VkResult), such as "vkQueueSubmit 3 -4". With KLIEG_TEST_KIND every device says
 * that it is of this VkPhysicalDeviceType. KLIEG_TEST_WEAK is a list such as "maxImageArrayLayers=256 geometryShader=0":
 * limits and features, by their names in Vulkan; graphics=0 takes graphics from all queues. The file is what the layer's
 * manifest names as its library. */

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

static PFN_vkGetInstanceProcAddr instance_next;
static PFN_vkGetDeviceProcAddr device_next;
static PFN_vkCreateInstance create_instance;
static PFN_vkGetPhysicalDeviceProperties properties;
static PFN_vkGetPhysicalDeviceProperties2 properties2;
static PFN_vkGetPhysicalDeviceFeatures features;
static PFN_vkGetPhysicalDeviceFeatures2 features2;
static PFN_vkGetPhysicalDeviceQueueFamilyProperties queues;
static VkInstance instance;

/* What the call returns now. */
static VkResult fault(const char *call) {
    static int calls;
    const char *text = getenv("KLIEG_TEST_FAULT");
    char name[64];
    int works, result;
    if (!text || sscanf(text, "%63s %d %d", name, &works, &result) != 3 || strcmp(name, call)) {
        return VK_SUCCESS;
    }
    return __sync_fetch_and_add(&calls, 1) < works ? VK_SUCCESS : (VkResult)result;
}

/* What KLIEG_TEST_WEAK says of a name, else `as_it_is`. */
static uint32_t weak(const char *name, uint32_t as_it_is) {
    const char *text = getenv("KLIEG_TEST_WEAK");
    size_t length = strlen(name);
    for (; text && *text; text += strcspn(text, " "), text += strspn(text, " ")) {
        if (!strncmp(text, name, length) && text[length] == '=') {
            return (uint32_t)strtoul(text + length + 1, NULL, 10);
        }
    }
    return as_it_is;
}

#define WEAKEN(of, name) (of)->name = weak(#name, (of)->name)

static void weaken(VkPhysicalDeviceProperties *of) {
    const char *text = getenv("KLIEG_TEST_KIND");
    if (text) {
        of->deviceType = (VkPhysicalDeviceType)atoi(text);
    }
    VkPhysicalDeviceLimits *limits = &of->limits;
    WEAKEN(limits, maxComputeSharedMemorySize);
    WEAKEN(limits, maxStorageBufferRange);
    WEAKEN(limits, maxImageArrayLayers);
    WEAKEN(limits, maxImageDimension2D);
    WEAKEN(limits, maxFramebufferLayers);
    WEAKEN(limits, maxVertexOutputComponents);
    WEAKEN(limits, maxPerStageDescriptorStorageImages);
    WEAKEN(limits, maxComputeWorkGroupInvocations);
    WEAKEN(limits, maxDrawIndexedIndexValue);
    WEAKEN(limits, timestampComputeAndGraphics);
}

static void weaken_features(VkPhysicalDeviceFeatures *of) {
    WEAKEN(of, geometryShader);
    WEAKEN(of, fullDrawIndexUint32);
}

/* A function that passes its call on to the driver unless it is to fail. */
#define FAILING(name, parameters, arguments)                                                     \
    static PFN_vk##name name##_next;                                                             \
    static VKAPI_ATTR VkResult VKAPI_CALL name parameters {                                      \
        VkResult result = fault("vk" #name);                                                     \
        return result == VK_SUCCESS ? name##_next arguments : result;                            \
    }

FAILING(QueueSubmit, (VkQueue q, uint32_t n, const VkSubmitInfo *s, VkFence f), (q, n, s, f))
FAILING(AllocateMemory,
        (VkDevice d, const VkMemoryAllocateInfo *i, const VkAllocationCallbacks *a, VkDeviceMemory *m),
        (d, i, a, m))
FAILING(CreateComputePipelines,
        (VkDevice d, VkPipelineCache c, uint32_t n, const VkComputePipelineCreateInfo *i,
         const VkAllocationCallbacks *a, VkPipeline *p),
        (d, c, n, i, a, p))
FAILING(CreateGraphicsPipelines,
        (VkDevice d, VkPipelineCache c, uint32_t n, const VkGraphicsPipelineCreateInfo *i,
         const VkAllocationCallbacks *a, VkPipeline *p),
        (d, c, n, i, a, p))
FAILING(CreateShaderModule,
        (VkDevice d, const VkShaderModuleCreateInfo *i, const VkAllocationCallbacks *a, VkShaderModule *m),
        (d, i, a, m))
FAILING(CreateBuffer,
        (VkDevice d, const VkBufferCreateInfo *i, const VkAllocationCallbacks *a, VkBuffer *b),
        (d, i, a, b))
FAILING(CreateImage,
        (VkDevice d, const VkImageCreateInfo *i, const VkAllocationCallbacks *a, VkImage *m),
        (d, i, a, m))
FAILING(CreateDevice,
        (VkPhysicalDevice p, const VkDeviceCreateInfo *i, const VkAllocationCallbacks *a, VkDevice *d),
        (p, i, a, d))

/* The link of the chain that is meant for this layer, which is taken out of it. */
static VkLayerInstanceCreateInfo *link_of(const void *next, VkStructureType type) {
    VkLayerInstanceCreateInfo *info = (VkLayerInstanceCreateInfo *)next;
    while (info && (info->sType != type || info->function != VK_LAYER_LINK_INFO)) {
        info = (VkLayerInstanceCreateInfo *)info->pNext;
    }
    return info;
}

static VKAPI_ATTR VkResult VKAPI_CALL make_instance(const VkInstanceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkInstance *made) {
    VkLayerInstanceCreateInfo *link =
        link_of(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    instance_next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    create_instance = (PFN_vkCreateInstance)instance_next(NULL, "vkCreateInstance");
    VkResult result = create_instance(info, allocator, made);
    if (result == VK_SUCCESS) {
        instance = *made;
        properties = (PFN_vkGetPhysicalDeviceProperties)instance_next(
            instance, "vkGetPhysicalDeviceProperties");
        properties2 = (PFN_vkGetPhysicalDeviceProperties2)instance_next(
            instance, "vkGetPhysicalDeviceProperties2");
        features = (PFN_vkGetPhysicalDeviceFeatures)instance_next(
            instance, "vkGetPhysicalDeviceFeatures");
        features2 = (PFN_vkGetPhysicalDeviceFeatures2)instance_next(
            instance, "vkGetPhysicalDeviceFeatures2");
        queues = (PFN_vkGetPhysicalDeviceQueueFamilyProperties)instance_next(
            instance, "vkGetPhysicalDeviceQueueFamilyProperties");
    }
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL make_device(VkPhysicalDevice physical,
                                                  const VkDeviceCreateInfo *info,
                                                  const VkAllocationCallbacks *allocator,
                                                  VkDevice *device) {
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)link_of(
        info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    device_next = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    CreateDevice_next = (PFN_vkCreateDevice)next(instance, "vkCreateDevice");
    VkResult result = CreateDevice(physical, info, allocator, device);
    if (result == VK_SUCCESS) {
#define NEXT(name) name##_next = (PFN_vk##name)device_next(*device, "vk" #name)
        NEXT(QueueSubmit);
        NEXT(AllocateMemory);
        NEXT(CreateComputePipelines);
        NEXT(CreateGraphicsPipelines);
        NEXT(CreateShaderModule);
        NEXT(CreateBuffer);
        NEXT(CreateImage);
    }
    return result;
}

static VKAPI_ATTR void VKAPI_CALL get_properties(VkPhysicalDevice device,
                                                 VkPhysicalDeviceProperties *out) {
    properties(device, out);
    weaken(out);
}

static VKAPI_ATTR void VKAPI_CALL get_properties2(VkPhysicalDevice device,
                                                  VkPhysicalDeviceProperties2 *out) {
    properties2(device, out);
    weaken(&out->properties);
}

static VKAPI_ATTR void VKAPI_CALL get_features(VkPhysicalDevice device,
                                               VkPhysicalDeviceFeatures *out) {
    features(device, out);
    weaken_features(out);
}

static VKAPI_ATTR void VKAPI_CALL get_features2(VkPhysicalDevice device,
                                                VkPhysicalDeviceFeatures2 *out) {
    features2(device, out);
    weaken_features(&out->features);
    for (VkBaseOutStructure *next = out->pNext; next; next = next->pNext) {
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES) {
            VkPhysicalDeviceVulkan12Features *vulkan12 = (VkPhysicalDeviceVulkan12Features *)next;
            WEAKEN(vulkan12, shaderOutputLayer);
        }
    }
}

static VKAPI_ATTR void VKAPI_CALL get_queues(VkPhysicalDevice device, uint32_t *count,
                                             VkQueueFamilyProperties *out) {
    queues(device, count, out);
    for (uint32_t i = 0; out && i < *count && !weak("graphics", 1); i++) {
        out[i].queueFlags &= ~(VkQueueFlags)VK_QUEUE_GRAPHICS_BIT;
    }
}

static PFN_vkVoidFunction own(const char *name) {
#define OWN(call, function)                                                                      \
    if (!strcmp(name, call)) {                                                                   \
        return (PFN_vkVoidFunction)function;                                                     \
    }
    OWN("vkQueueSubmit", QueueSubmit)
    OWN("vkAllocateMemory", AllocateMemory)
    OWN("vkCreateComputePipelines", CreateComputePipelines)
    OWN("vkCreateGraphicsPipelines", CreateGraphicsPipelines)
    OWN("vkCreateShaderModule", CreateShaderModule)
    OWN("vkCreateBuffer", CreateBuffer)
    OWN("vkCreateImage", CreateImage)
    return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device(VkDevice device, const char *name) {
    OWN("vkGetDeviceProcAddr", get_device)
    PFN_vkVoidFunction function = own(name);
    return function ? function : device_next(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance(VkInstance of, const char *name) {
    OWN("vkGetInstanceProcAddr", get_instance)
    OWN("vkGetDeviceProcAddr", get_device)
    OWN("vkCreateInstance", make_instance)
    OWN("vkCreateDevice", make_device)
    OWN("vkGetPhysicalDeviceProperties", get_properties)
    OWN("vkGetPhysicalDeviceProperties2", get_properties2)
    OWN("vkGetPhysicalDeviceFeatures", get_features)
    OWN("vkGetPhysicalDeviceFeatures2", get_features2)
    OWN("vkGetPhysicalDeviceQueueFamilyProperties", get_queues)
    PFN_vkVoidFunction function = own(name);
    return function ? function : instance_next(of, name);
}

VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *interface) {
    interface->loaderLayerInterfaceVersion = 2;
    interface->pfnGetInstanceProcAddr = get_instance;
    interface->pfnGetDeviceProcAddr = get_device;
    interface->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
