/* A Vulkan layer that tells what a driver has made of each shader: one line for each executable of each named pipeline,
 *
 *     pipeline TAB stage TAB subgroup size TAB statistic=value TAB ...
 *
 * on standard error, or in the file that KLIEG_STATISTICS names, to which it is appended. It asks every device that can
 * for VK_KHR_pipeline_executable_properties. The file is what the layer's manifest names as its library. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#define MOST_EXTENSIONS 64
#define MOST_EXECUTABLES 8
#define MOST_STATISTICS 64

static PFN_vkGetInstanceProcAddr instance_next;
static PFN_vkGetDeviceProcAddr device_next;
static PFN_vkCreateDevice create_device;
static PFN_vkCreateComputePipelines create_compute;
static PFN_vkCreateGraphicsPipelines create_graphics;
static PFN_vkSetDebugUtilsObjectNameEXT set_name;
static PFN_vkGetPipelineExecutablePropertiesKHR executables_of;
static PFN_vkGetPipelineExecutableStatisticsKHR statistics_of;
static VkInstance instance;

/* The link of the chain that is meant for this layer. */
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
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)instance_next(NULL, "vkCreateInstance");
    VkResult result = create(info, allocator, made);
    if (result == VK_SUCCESS) {
        instance = *made;
    }
    return result;
}

/* Whether a device has the extension. */
static int has_statistics(VkPhysicalDevice physical) {
    PFN_vkEnumerateDeviceExtensionProperties enumerate =
        (PFN_vkEnumerateDeviceExtensionProperties)instance_next(
            instance, "vkEnumerateDeviceExtensionProperties");
    uint32_t count = 0;
    enumerate(physical, NULL, &count, NULL);
    VkExtensionProperties *all = calloc(count ? count : 1, sizeof *all);
    int found = 0;
    if (all && enumerate(physical, NULL, &count, all) >= VK_SUCCESS) {
        for (uint32_t i = 0; i < count; i++) {
            found |= !strcmp(all[i].extensionName, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
        }
    }
    free(all);
    return found;
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
    create_device = (PFN_vkCreateDevice)next(instance, "vkCreateDevice");

    const char *names[MOST_EXTENSIONS + 1];
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR feature = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
        (void *)info->pNext,
        VK_TRUE,
    };
    VkDeviceCreateInfo more = *info;
    int told = info->enabledExtensionCount <= MOST_EXTENSIONS && has_statistics(physical);
    if (told) {
        memcpy(names, info->ppEnabledExtensionNames, info->enabledExtensionCount * sizeof *names);
        names[info->enabledExtensionCount] = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
        more.enabledExtensionCount += 1;
        more.ppEnabledExtensionNames = names;
        more.pNext = &feature;
    }
    VkResult result = create_device(physical, &more, allocator, device);
    if (result == VK_SUCCESS) {
#define NEXT(variable, type, name) variable = (type)device_next(*device, name)
        NEXT(create_compute, PFN_vkCreateComputePipelines, "vkCreateComputePipelines");
        NEXT(create_graphics, PFN_vkCreateGraphicsPipelines, "vkCreateGraphicsPipelines");
        NEXT(set_name, PFN_vkSetDebugUtilsObjectNameEXT, "vkSetDebugUtilsObjectNameEXT");
        executables_of = NULL;
        if (told) {
            NEXT(executables_of, PFN_vkGetPipelineExecutablePropertiesKHR,
                 "vkGetPipelineExecutablePropertiesKHR");
            NEXT(statistics_of, PFN_vkGetPipelineExecutableStatisticsKHR,
                 "vkGetPipelineExecutableStatisticsKHR");
        }
    }
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL make_compute(VkDevice device, VkPipelineCache cache,
                                                   uint32_t count,
                                                   const VkComputePipelineCreateInfo *infos,
                                                   const VkAllocationCallbacks *allocator,
                                                   VkPipeline *pipelines) {
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count && result == VK_SUCCESS; i++) {
        VkComputePipelineCreateInfo info = infos[i];
        if (executables_of) {
            info.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
        }
        result = create_compute(device, cache, 1, &info, allocator, &pipelines[i]);
    }
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL make_graphics(VkDevice device, VkPipelineCache cache,
                                                    uint32_t count,
                                                    const VkGraphicsPipelineCreateInfo *infos,
                                                    const VkAllocationCallbacks *allocator,
                                                    VkPipeline *pipelines) {
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count && result == VK_SUCCESS; i++) {
        VkGraphicsPipelineCreateInfo info = infos[i];
        if (executables_of) {
            info.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
        }
        result = create_graphics(device, cache, 1, &info, allocator, &pipelines[i]);
    }
    return result;
}

static void tell(FILE *out, const VkPipelineExecutableStatisticKHR *statistic) {
    const VkPipelineExecutableStatisticValueKHR *value = &statistic->value;
    fprintf(out, "\t%s=", statistic->name);
    switch (statistic->format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
        fprintf(out, "%u", value->b32);
        break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
        fprintf(out, "%lld", (long long)value->i64);
        break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
        fprintf(out, "%llu", (unsigned long long)value->u64);
        break;
    default:
        fprintf(out, "%g", value->f64);
    }
}

/* Tells of a pipeline once it has its name. */
static VKAPI_ATTR VkResult VKAPI_CALL name_object(VkDevice device,
                                                  const VkDebugUtilsObjectNameInfoEXT *name) {
    if (executables_of && name->objectType == VK_OBJECT_TYPE_PIPELINE) {
        VkPipelineInfoKHR pipeline = {VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, NULL,
                                      (VkPipeline)name->objectHandle};
        VkPipelineExecutablePropertiesKHR executables[MOST_EXECUTABLES];
        uint32_t count = MOST_EXECUTABLES;
        memset(executables, 0, sizeof executables);
        for (uint32_t i = 0; i < count; i++) {
            executables[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
        }
        executables_of(device, &pipeline, &count, executables);
        const char *path = getenv("KLIEG_STATISTICS");
        FILE *out = path ? fopen(path, "a") : stderr;
        for (uint32_t i = 0; out && i < count; i++) {
            VkPipelineExecutableInfoKHR which = {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, NULL,
                                                 pipeline.pipeline, i};
            VkPipelineExecutableStatisticKHR statistics[MOST_STATISTICS];
            uint32_t told = MOST_STATISTICS;
            memset(statistics, 0, sizeof statistics);
            for (uint32_t j = 0; j < told; j++) {
                statistics[j].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
            }
            statistics_of(device, &which, &told, statistics);
            fprintf(out, "%s\t%s\t%u", name->pObjectName, executables[i].name,
                    executables[i].subgroupSize);
            for (uint32_t j = 0; j < told; j++) {
                tell(out, &statistics[j]);
            }
            fputc('\n', out);
        }
        if (out && out != stderr) {
            fclose(out);
        }
    }
    return set_name ? set_name(device, name) : VK_SUCCESS;
}

static PFN_vkVoidFunction own(const char *name) {
#define OWN(call, function)                                                                      \
    if (!strcmp(name, call)) {                                                                   \
        return (PFN_vkVoidFunction)function;                                                     \
    }
    OWN("vkCreateComputePipelines", make_compute)
    OWN("vkCreateGraphicsPipelines", make_graphics)
    OWN("vkSetDebugUtilsObjectNameEXT", name_object)
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
