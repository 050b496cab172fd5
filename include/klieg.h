/*
 * klieg: finds good lighting for 3D scenes on Vulkan.
 *
 * Made of src/c by cbindgen: KLIEG_WRITE_HEADER=1 cargo test --test c_header
 *
 * Use
 *   A context works on a device: the engine's (klieg_context_borrow) or klieg's own
 *   (klieg_context_create). An evaluator measures lights against one view: of a scene that klieg draws
 *   (level 1), of a surface that the engine has drawn (level 2), or in pictures that the engine has
 *   rendered (level 3). A designer searches for the lights with the lowest score, a little every frame.
 *   klieg_lights_in_world gives them as the engine applies them.
 *
 * Results
 *   Functions return a klieg_status; klieg_error gives the message of what failed. A call that fails
 *   changes nothing that its description does not tell, and what it points to for results is undefined.
 *   No call throws, unwinds or ends the process; functions of yours that klieg calls must not either.
 *
 * Handles
 *   A handle is made by a function whose last argument is the place for it, NULL there where that
 *   fails, and ended by its ..._destroy. Handles may be destroyed in any order: each holds what it
 *   needs of the others. A destroyed handle must not be used.
 *
 * Memory
 *   Arrays and structures are the caller's. They are read or written during the call and not kept,
 *   unless a description says so. Where a count is 0 an array may be NULL. Structures with defaults
 *   have a klieg_..._defaults function, and those of a profile a klieg_..._profile function that takes its
 *   name ("paper" or "natural"); fill them with one, then change what matters, so that your program stays
 *   right when a member is added.
 *
 * Threads
 *   A context may be used by several threads at once, every other handle by one at a time, but not
 *   always the same. "Any thread" says that a function has no handle of the latter kind.
 *
 * Units
 *   World units are the engine's; the light frame has the scene's centre as its origin, the camera's axes
 *   (right, up, towards the viewer) and the scene's radius as its unit. Angles are radians where not
 *   said otherwise. Matrices are 16 doubles, column after column. Scores are lower for better pictures.
 *
 * Versions
 *   KLIEG_VERSION is checked where a context is made. Within one minor version before 1.0, and one major
 *   version after, structures and functions stay as they are and further functions may be added.
 */

#ifndef KLIEG_H
#define KLIEG_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version, status codes and messages */

// The version of the header, by the rules of Semantic Versioning: before 1.0 a minor version, after
// it a major version may change what is here.
#define KLIEG_VERSION_MAJOR 0

// See `KLIEG_VERSION_MAJOR`.
#define KLIEG_VERSION_MINOR 2

// See `KLIEG_VERSION_MAJOR`.
#define KLIEG_VERSION_PATCH 0

// The header's version in one number: major · 1,000,000 + minor · 1,000 + patch.
#define KLIEG_VERSION 2000

// How a call went: `KLIEG_OK`, a `KLIEG_ERROR_...` (negative), or `KLIEG_NOTHING_YET`.
typedef int32_t klieg_status;

// All went well.
#define KLIEG_OK 0

// There is nothing to give yet; no error.
#define KLIEG_NOTHING_YET 1

// An argument is out of its range, `NULL` where it must not be, or of the wrong handle.
#define KLIEG_ERROR_ARGUMENT -1

// A file, or a scene that was made of one, cannot be used.
#define KLIEG_ERROR_INPUT -2

// The device lacks something, or was not borrowed for this; the message lists all of it.
#define KLIEG_ERROR_UNSUPPORTED -3

// There is no Vulkan here, or no device.
#define KLIEG_ERROR_NO_VULKAN -4

// A Vulkan call failed; the message has its name and result.
#define KLIEG_ERROR_VULKAN -5

// The device is lost: nothing but destroying works on it any more.
#define KLIEG_ERROR_DEVICE_LOST -6

// `klieg_context_forget_device` was called: nothing but destroying works any more.
#define KLIEG_ERROR_FORGOTTEN -7

// There is not enough memory.
#define KLIEG_ERROR_MEMORY -8

// The program was built for a version of klieg that this library does not speak.
#define KLIEG_ERROR_VERSION -9

// A fault of klieg's own. Destroy the handles of the call; others may be used on.
#define KLIEG_ERROR_INTERNAL -10

// A file cannot be written.
#define KLIEG_ERROR_OUTPUT -11

// The version of the library that runs, as `KLIEG_VERSION`. It may be newer than the header's.
uint32_t klieg_version(void);

// The message of the last call that failed: on `handle`, of whatever type, where that is its first
// argument.
//
// Functions that make a handle and functions without one leave their message with the calling thread
// instead, for `klieg_error(NULL)`. Contexts have none of their own, as threads share them:
// `klieg_error(context)` is `klieg_error(NULL)`.
//
// UTF-8, in English; never `NULL`, empty where nothing failed. It stays valid until the next such call
// fails or the handle is destroyed.
const char *klieg_error(const void *handle);

/* What klieg asks of a device, and how an engine enables it */

// Bytes of a name in a structure, its terminating zero included.
#define KLIEG_NAME_SIZE 48

// Limits in `klieg_requirements`, at most.
#define KLIEG_MAX_LIMITS 16

// Formats in `klieg_requirements`, at most.
#define KLIEG_MAX_FORMATS 8

// What an engine will use klieg for, which decides what the device must have: a sum of
// `KLIEG_NEEDS_...`.
typedef uint32_t klieg_needs;

// Features of a device, each `VK_TRUE` or `VK_FALSE`.
typedef struct klieg_features {
    // `VkPhysicalDeviceFeatures::geometryShader`.
    VkBool32 geometry_shader;
    // `VkPhysicalDeviceVulkan12Features::shaderOutputLayer`.
    VkBool32 shader_output_layer;
    // `VkPhysicalDeviceFeatures::fullDrawIndexUint32`: never required; without it, meshes of a scene
    // have 2²⁴ vertices at most.
    VkBool32 full_draw_index_uint32;
    // Both `VkPhysicalDeviceVulkan13Features::subgroupSizeControl` and `computeFullSubgroups`, of Vulkan
    // 1.3 or of `VK_EXT_subgroup_size_control`: never required; without it, klieg measures in
    // `KLIEG_SHAPE_RUNS` on GPUs whose subgroups have several sizes, which is slower.
    VkBool32 subgroup_size_control;
} klieg_features;

// The least value of a member of `VkPhysicalDeviceLimits`.
typedef struct klieg_limit {
    // The member's name.
    char name[KLIEG_NAME_SIZE];
    // The least value.
    uint64_t least;
} klieg_limit;

// What must be possible with images of a format and optimal tiling.
typedef struct klieg_format {
    // The format.
    VkFormat format;
    // What must be possible.
    VkFormatFeatureFlags features;
} klieg_format;

// What a device must have.
typedef struct klieg_requirements {
    // The least Vulkan version of instance and device, as `VK_MAKE_API_VERSION` gives it.
    uint32_t api_version;
    // What the queue's family must be able to do.
    VkQueueFlags queue;
    // Features that must be enabled.
    struct klieg_features features;
    // Entries of `limits`.
    uint32_t limit_count;
    // Entries of `formats`.
    uint32_t format_count;
    // Least values of limits.
    struct klieg_limit limits[KLIEG_MAX_LIMITS];
    // Formats.
    struct klieg_format formats[KLIEG_MAX_FORMATS];
} klieg_requirements;

// Room for what `klieg_enable_features` adds to a chain. Its content is klieg's.
typedef struct klieg_feature_chain {
    // klieg's.
    uint64_t storage[64];
} klieg_feature_chain;

// An engine with pictures or a surface of its own, on pipeline `compute`: no feature and no graphics
// queue is needed.
#define KLIEG_NEEDS_COMPUTE 0

// The device draws scenes (`klieg_evaluator_of_scene`), else the CPU does: a graphics queue and
// `geometryShader`.
#define KLIEG_NEEDS_SCENE 1

// Pipelines `layered` and `forward`: a graphics queue and `shaderOutputLayer`.
#define KLIEG_NEEDS_LAYERS 2

// Everything that klieg can do.
#define KLIEG_NEEDS_ALL 3

// Tells what a device must have for `needs`. Any thread.
klieg_status klieg_requirements_for(klieg_needs needs, struct klieg_requirements *requirements);

// Enables what `needs` requires in `info`, an engine's own structure: in its own feature structures
// where these are in the chain, else in ones that are put into `chain` and that `info` then points to.
// What the engine has enabled stays. Call it last, when `info` is complete; `chain` stays where it is
// until the device is created. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` when `shaderOutputLayer` is needed and the chain names features of Vulkan 1.2
// one by one, beside which Vulkan forbids `VkPhysicalDeviceVulkan12Features`, which holds it.
klieg_status klieg_enable_features(klieg_needs needs,
                                   VkDeviceCreateInfo *info,
                                   struct klieg_feature_chain *chain);

// Tells which features a device that is created with `info` has enabled, for
// `klieg_device::features`. Any thread.
klieg_status klieg_enabled_features(const VkDeviceCreateInfo *info,
                                    struct klieg_features *features);

/* A Vulkan device to work on: klieg's own, or an engine's */

// A Vulkan device, one queue of it, and memory. Threads may share it, each with evaluators of its own.
// What is made on it holds it: it may be destroyed first.
typedef struct klieg_context klieg_context;

// How populations are measured: one of `KLIEG_PIPELINE_...`.
typedef int32_t klieg_pipeline;

// The shape of `KLIEG_PIPELINE_COMPUTE`: one of `KLIEG_SHAPE_...`.
typedef int32_t klieg_shape;

// How the evaluators of a context work.
typedef struct klieg_tuning {
    // Bytes of device memory for the pictures of a population, at most; 0 for half of the device's.
    uint64_t picture_memory;
    // How populations are measured.
    klieg_pipeline pipeline;
    // The shape of pipeline `compute`.
    klieg_shape shape;
    // What `klieg_context_pipeline_cache` gave earlier, read during the call: pipelines that are in it need
    // not be compiled again. Data that are damaged, or of another device, driver or version of klieg are
    // as good as none; `NULL` for none.
    const void *pipeline_cache;
    // Bytes of it.
    size_t pipeline_cache_size;
} klieg_tuning;

// Who touches a piece of memory: one of `KLIEG_ACCESS_...`.
typedef int32_t klieg_access;

// What klieg asks an engine's allocator for: memory for one buffer, or for one image of optimal tiling.
typedef struct klieg_memory_request {
    // What it is for, for people; valid during the call.
    const char *name;
    // Size, alignment and possible memory types.
    VkMemoryRequirements requirements;
    // Who touches it.
    klieg_access access;
    // `VK_TRUE` for a buffer, `VK_FALSE` for an image: the two may have to keep a distance
    // (`bufferImageGranularity`).
    VkBool32 linear;
} klieg_memory_request;

// A piece of device memory.
typedef struct klieg_memory {
    // The memory that it is part of.
    VkDeviceMemory memory;
    // Its first byte there, aligned as asked for.
    VkDeviceSize offset;
    // Where its first byte is mapped for as long as it lives; `NULL` where it is not.
    void *mapped;
    // The allocator's own name for it.
    uint64_t token;
} klieg_memory;

// An engine's allocator. klieg calls it from one thread at a time, which need not be the one that
// made the context. `user` and the functions stay valid until the context's last user has gone.
typedef struct klieg_allocator {
    // Passed on to the functions.
    void *user;
    // Fills `*memory` and returns 0, or returns another number where there is none. The memory belongs
    // to klieg alone until it is freed.
    int32_t (*allocate)(void *user,
                        const struct klieg_memory_request *request,
                        struct klieg_memory *memory);
    // Takes back what `allocate` gave; the device no longer uses it.
    void (*free)(void *user, const struct klieg_memory *memory);
    // Bytes of device memory that the allocator holds for klieg at the moment, for
    // `klieg_counters::memory`; may be `NULL`.
    uint64_t (*capacity)(void *user);
} klieg_allocator;

// A device that an engine created, keeps and destroys.
typedef struct klieg_device {
    // `vkGetInstanceProcAddr` of the loader that the instance comes from.
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    // The instance.
    VkInstance instance;
    // The Vulkan version that the instance was created for (`VkApplicationInfo::apiVersion`).
    uint32_t api_version;
    // `VK_TRUE` where the instance was created with `VK_EXT_debug_utils`: then klieg names and labels
    // what it makes and records.
    VkBool32 debug_utils;
    // The physical device.
    VkPhysicalDevice physical_device;
    // The device.
    VkDevice device;
    // The queue that klieg submits to where it submits by itself.
    VkQueue queue;
    // Family of that queue, and of the command buffers that klieg records into.
    uint32_t queue_family;
    // What is enabled on the device: see `klieg_enabled_features`.
    klieg_features features;
    // Waits until the queue is free, and takes it: keeps the engine's threads off the queue while klieg
    // submits. Both functions, or neither where only one thread uses the queue. klieg holds the lock for
    // one `vkQueueSubmit` at a time and never while it waits.
    void (*lock_queue)(void *user);
    // Gives the queue back, on the same thread.
    void (*unlock_queue)(void *user);
    // Passed on to both; stays valid until the context's last user has gone.
    void *queue_user;
    // Where memory comes from; copied. klieg allocates blocks itself where it is `NULL`.
    const struct klieg_allocator *allocator;
} klieg_device;

// What klieg has made and read since the context began.
typedef struct klieg_counters {
    // Buffers and images that got memory.
    uint64_t allocations;
    // Pipelines.
    uint64_t pipelines;
    // Descriptor sets, allocated or written anew.
    uint64_t descriptors;
    // Bytes that the host read from the device's buffers.
    uint64_t bytes_read;
    // Bytes of device memory that are taken at the moment, what the allocator keeps for later included.
    uint64_t memory;
    // Bytes of `klieg_tuning::pipeline_cache` that the driver began with.
    uint64_t pipeline_cache;
} klieg_counters;

// The fastest for the device.
#define KLIEG_PIPELINE_AUTO 0

// Compute shaders, over object pixels alone.
#define KLIEG_PIPELINE_COMPUTE 1

// Layered draws of the stored surface; needs `KLIEG_NEEDS_LAYERS`.
#define KLIEG_PIPELINE_LAYERED 2

// Layered draws of the scene's geometry; needs `KLIEG_NEEDS_LAYERS`, and a scene.
#define KLIEG_PIPELINE_FORWARD 3

// The faster for the device.
#define KLIEG_SHAPE_AUTO 0

// Runs of pixels, without shared memory: for software devices.
#define KLIEG_SHAPE_RUNS 1

// Tiles in shared memory: for GPUs.
#define KLIEG_SHAPE_TILES 2

// The device alone.
#define KLIEG_ACCESS_DEVICE 0

// The host writes, the device reads: must be mapped and host-coherent.
#define KLIEG_ACCESS_UPLOAD 1

// The device writes, the host reads: must be mapped and host-coherent.
#define KLIEG_ACCESS_READBACK 2

// Sets everything to be chosen by klieg. Any thread.
klieg_status klieg_tuning_defaults(struct klieg_tuning *tuning);

// Makes a context on a device of klieg's own. Any thread.
//
// `version` is `KLIEG_VERSION`. `device` is a part of the device's name or its number among the
// machine's Vulkan devices, `NULL` for the best. `tuning` may be `NULL`, for the defaults.
//
// `KLIEG_ERROR_VERSION` for a program that was built for another klieg; `KLIEG_ERROR_NO_VULKAN` without
// a Vulkan loader or device; `KLIEG_ERROR_UNSUPPORTED` for a device that lacks something.
klieg_status klieg_context_create(uint32_t version,
                                  const char *device,
                                  const struct klieg_tuning *tuning,
                                  struct klieg_context **context);

// Makes a context on an engine's device, which stays the engine's: klieg destroys what it makes itself,
// and no more. Any thread.
//
// The handles of `device` are valid and belong together, and its features are enabled. They stay valid
// until the context and everything that was made on it are destroyed, or until
// `klieg_context_forget_device`. Other threads use the queue only with the lock held.
//
// `version` is `KLIEG_VERSION`; `tuning` may be `NULL`, for the defaults.
//
// `KLIEG_ERROR_VERSION` for a program that was built for another klieg; `KLIEG_ERROR_UNSUPPORTED` with
// all that the device, its queue or its enabled features lack for `needs`.
klieg_status klieg_context_borrow(uint32_t version,
                                  const struct klieg_device *device,
                                  klieg_needs needs,
                                  const struct klieg_tuning *tuning,
                                  struct klieg_context **context);

// Gives the context up; `NULL` is left alone. It goes when everything that was made on it has gone.
void klieg_context_destroy(struct klieg_context *context);

// Says that the device is gone, or soon will be, before all that klieg made on it: from now on klieg
// makes no Vulkan call. What it had made on the device is leaked there; everything but destroying fails
// with `KLIEG_ERROR_FORGOTTEN`. Any thread, while no other call on this device is under way.
klieg_status klieg_context_forget_device(const struct klieg_context *context);

// The device's name: UTF-8, valid until the context is destroyed; empty where `context` is `NULL`. Any
// thread.
const char *klieg_context_device_name(const struct klieg_context *context);

// Tells what klieg has made and read so far. Any thread.
klieg_status klieg_context_counters(const struct klieg_context *context,
                                    struct klieg_counters *counters);

// Gives the pipelines compiled so far, and those of earlier runs, for `klieg_tuning::pipeline_cache` of a
// later one: `*size` bytes, written to `data` where it has `room` for them. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` where `room` is not enough; `*size` is told all the same. `data` may be `NULL`
// where `room` is 0, which asks for the size alone.
klieg_status klieg_context_pipeline_cache(const struct klieg_context *context,
                                          void *data,
                                          size_t room,
                                          size_t *size);

/* Lights, the frame that they stand in, and where they are in the world */

// Lights that a rig can have at most; the least is 1.
#define KLIEG_MAX_LIGHTS 16

// Rigs that people use without looking at the scene: one of `KLIEG_PRESET_...`.
typedef int32_t klieg_preset;

// What a light is for, which decides the values that a search may give it: one of `KLIEG_ROLE_...`.
typedef int32_t klieg_role;

// How a light reaches the scene: one of `KLIEG_LIGHT_...`.
typedef int32_t klieg_light_kind;

// A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii. From
// `color` on, 0 is the default of each.
typedef struct klieg_light {
    // What it is for.
    klieg_role role;
    // Point, directional or spot.
    klieg_light_kind kind;
    // Elevation above the camera's horizontal plane, radians.
    float elevation;
    // Azimuth, radians: 0 from the viewer, positive to the viewer's right.
    float azimuth;
    // Distance R from the scene's centre, scene radii; a directional light ignores it.
    float distance;
    // Diffuse intensity, 0 or more: the radiance that a white matt surface shows which faces the light
    // at the scene's centre. 1 is the brightest that is shown.
    float diffuse;
    // Specular intensity, 0 or more, of which a highlight is made.
    float specular;
    // Colour, linear RGB, 0 or more, whose brightness does not count; as klieg gives it its luminance is 1.
    // All 0: white.
    float color[3];
    // Radius of the light itself, scene radii, 0 or more.
    float size;
    // Half angle of a spot's fully bright inner cone, radians, 0 or more.
    float cone_inner;
    // Half angle of a spot's whole cone, radians, more than `cone_inner`, π/2 at most. 0: π/4.
    float cone_outer;
    // Axis of a spot's cone, away from the light. All 0: towards the scene's centre.
    float aim[3];
} klieg_light;

// The light frame of a view: the camera's unit axes in the world, at the scene's centre.
typedef struct klieg_frame {
    // Centre of the scene, world units.
    double center[3];
    // Radius of the scene around it, world units.
    double radius;
    // To the viewer's right.
    double right[3];
    // Up.
    double up[3];
    // From the scene to the viewer.
    double back[3];
} klieg_frame;

// A light in the world, as an engine applies it.
typedef struct klieg_world_light {
    // What it is for.
    klieg_role role;
    // Point, directional or spot.
    klieg_light_kind kind;
    // Where it stands, world units; the scene's centre for a directional light.
    double position[3];
    // Unit vector along which light reaches the scene's centre.
    double direction[3];
    // Unit axis of a spot's cone, away from the light; all 0 for other lights.
    double axis[3];
    // Distance R from the scene's centre, world units; 0 for a directional light.
    double distance;
    // Physical intensity of the diffuse part: lux of a directional light, candela of any other, for
    // world units of a metre. A white matt surface that faces it at the scene's centre has the
    // radiance `diffuse`.
    double intensity;
    // Diffuse intensity, relative: that of a point light at the distance d is `diffuse`·(R/d)².
    float diffuse;
    // Specular intensity, relative in the same way.
    float specular;
    // Colour, linear RGB of luminance 1, which all intensities are multiplied with.
    float color[3];
    // Half angle of a spot's fully bright inner cone, radians; 0 for other lights.
    float cone_inner;
    // Half angle of a spot's whole cone, radians; 0 for other lights. Between the two the light falls off
    // as KHR_lights_punctual has it.
    float cone_outer;
    // Radius of the light itself, world units.
    double size;
} klieg_world_light;

// The main light, in front and above.
#define KLIEG_ROLE_KEY 0

// Softens the key's shadows, from the front.
#define KLIEG_ROLE_FILL 1

// From behind, to draw the outline.
#define KLIEG_ROLE_RIM 2

// Stands in the scene already: it can be evaluated, but no search changes it.
#define KLIEG_ROLE_SCENE 3

// From a point at the distance R from the scene's centre, with falloff (R/d)².
#define KLIEG_LIGHT_POINT 0

// Parallel, without falloff.
#define KLIEG_LIGHT_DIRECTIONAL 1

// As a point light, within a cone.
#define KLIEG_LIGHT_SPOT 2

// One light from the viewer.
#define KLIEG_PRESET_HEADLIGHT 0

// VTK's `vtkLightKit` with its default angles and ratios, white.
#define KLIEG_PRESET_LIGHT_KIT 1

// The photographer's key, fill and back light.
#define KLIEG_PRESET_THREE_POINT 2

// Gives the lights of a preset, all directional, and their number. `capacity` is the number of lights
// that `lights` has room for: `KLIEG_MAX_LIGHTS` are enough. Any thread.
klieg_status klieg_preset_lights(klieg_preset preset,
                                 struct klieg_light *lights,
                                 uint32_t capacity,
                                 uint32_t *count);

// Gives `count` lights of a frame, such as `klieg_evaluator_frame` gives, as they stand in the world.
// Any thread.
klieg_status klieg_lights_in_world(const struct klieg_frame *frame,
                                   const struct klieg_light *lights,
                                   uint32_t count,
                                   struct klieg_world_light *world);

/* Scenes: from a glTF file, or from an engine's arrays */

// No texture.
#define KLIEG_NO_TEXTURE 4294967295

// glTF's default material, for `klieg_mesh::material`.
#define KLIEG_DEFAULT_MATERIAL 4294967295

// A scene. One thread at a time; evaluators that are made of it do not need it any more.
typedef struct klieg_scene klieg_scene;

// Which files a scene may name: one of `KLIEG_FILES_...`.
typedef int32_t klieg_file_access;

// How a texture continues outside 0..1: one of `KLIEG_WRAP_...`.
typedef int32_t klieg_wrap;

// A texture's texels and how they are read.
typedef struct klieg_texture {
    // UTF-8, for people; may be `NULL`.
    const char *name;
    // Texels in a row, 1..16384.
    uint32_t width;
    // Rows, 1..16384.
    uint32_t height;
    // RGBA, 8 bits each, rows from the top: 4·`width`·`height` bytes. Copied.
    const uint8_t *texels;
    // `VK_TRUE` where RGB is sRGB-encoded, as base colours and emitted light usually are.
    VkBool32 srgb;
    // Horizontal and vertical wrap.
    klieg_wrap wrap[2];
} klieg_texture;

// A material's use of a texture.
typedef struct klieg_texture_ref {
    // The number that `klieg_scene_add_texture` gave, or `KLIEG_NO_TEXTURE`.
    uint32_t texture;
    // Which of the vertices' coordinate sets, 0 or 1.
    uint32_t uv_set;
    // Transform of the coordinates, two rows: u' = row 0 · (u, v, 1), v' = row 1 · (u, v, 1).
    float transform[2][3];
} klieg_texture_ref;

// A metallic-roughness material, as glTF has it.
typedef struct klieg_material {
    // UTF-8, for people; may be `NULL`.
    const char *name;
    // Linear base colour and alpha, multiplied by texture and vertex colour; by default 1.
    float base_color[4];
    // 0..1, multiplied by the texture's blue component; by default 1.
    float metallic;
    // 0..1, multiplied by the texture's green component; by default 1.
    float roughness;
    // Linear emitted radiance; by default 0.
    float emissive[3];
    // Scale of the normal texture's x and y; by default 1.
    float normal_scale;
    // Pixels whose alpha is below are not drawn; by default 0, for opaque materials.
    float alpha_cutoff;
    // `VK_TRUE` where back faces are drawn; by default `VK_FALSE`.
    VkBool32 double_sided;
    // Base colour and alpha.
    struct klieg_texture_ref base_color_texture;
    // Linear; roughness in green, metallic in blue.
    struct klieg_texture_ref metallic_roughness_texture;
    // Linear tangent-space normals.
    struct klieg_texture_ref normal_texture;
    // Emitted light.
    struct klieg_texture_ref emissive_texture;
} klieg_material;

// A mesh's arrays, with an entry for each vertex. All are copied.
typedef struct klieg_mesh {
    // UTF-8, for people; may be `NULL`.
    const char *name;
    // Vertices.
    size_t vertices;
    // Positions in the mesh's own space, 3 numbers each.
    const float *positions;
    // Normals of any length, 3 numbers each; `NULL` for flat triangles.
    const float *normals;
    // Tangents and the bitangents' signs (1 or -1), 4 numbers each; `NULL` to have them computed where a normal texture
    // needs them.
    const float *tangents;
    // Texture coordinate sets 0 and 1, 2 numbers each, (0, 0) at the texture's first texel; `NULL` where there is none.
    const float *uvs[2];
    // Linear vertex colours, 4 bytes each (RGBA), 255 = 1; `NULL` for white.
    const uint8_t *colors;
    // Entries of `indices`, a multiple of 3.
    size_t index_count;
    // Three vertices for each triangle, counter-clockwise seen from the front; `NULL` where every three
    // vertices are a triangle.
    const uint32_t *indices;
    // The number that `klieg_scene_add_material` gave, or `KLIEG_DEFAULT_MATERIAL`.
    uint32_t material;
} klieg_mesh;

// Files in the folder of the scene's own file, and below; for scenes of unknown origin.
#define KLIEG_FILES_IN_SCENE_FOLDER 0

// All files that the program may read.
#define KLIEG_FILES_ANYWHERE 1

// Tiled.
#define KLIEG_WRAP_REPEAT 0

// Tiled, every other tile mirrored.
#define KLIEG_WRAP_MIRROR 1

// The border's texel.
#define KLIEG_WRAP_CLAMP 2

// Loads a glTF 2.0 file, `.glb` or `.gltf`, or a PLY, STL or OBJ file, as `klieg_scene_load_with` does with
// `KLIEG_FILES_IN_SCENE_FOLDER`. Any thread.
klieg_status klieg_scene_load(const char *path,
                              struct klieg_scene **scene);

// Loads a glTF 2.0 file, `.glb` or `.gltf`, or a PLY, STL or OBJ file, that may name the files which `access` allows; `path` is
// UTF-8. The scene is finished. Any thread.
//
// `KLIEG_ERROR_INPUT` for a file that cannot be used.
klieg_status klieg_scene_load_with(const char *path,
                                   klieg_file_access access,
                                   struct klieg_scene **scene);

// Begins a scene that is made of arrays; `name` is UTF-8, for people, and may be `NULL`. Add textures,
// then the materials that use them, then meshes, then instances; then finish it. Any thread.
klieg_status klieg_scene_create(const char *name,
                                struct klieg_scene **scene);

// Ends the scene; `NULL` is left alone.
void klieg_scene_destroy(struct klieg_scene *scene);

// Adds a texture, and makes its mip levels; gives its number for `klieg_texture_ref::texture`.
klieg_status klieg_scene_add_texture(struct klieg_scene *scene,
                                     const struct klieg_texture *texture,
                                     uint32_t *number);

// Sets glTF's default material, without textures. Any thread.
klieg_status klieg_material_defaults(struct klieg_material *material);

// Adds a material; gives its number for `klieg_mesh::material`.
klieg_status klieg_scene_add_material(struct klieg_scene *scene,
                                      const struct klieg_material *material,
                                      uint32_t *number);

// Adds a mesh; gives its number for `klieg_scene_add_instance`.
//
// `KLIEG_ERROR_ARGUMENT` names the mesh and what is wrong: no triangles, an index out of range, a number
// that is not finite, a material that was not added before, missing coordinates of its textures.
klieg_status klieg_scene_add_mesh(struct klieg_scene *scene,
                                  const struct klieg_mesh *mesh,
                                  uint32_t *number);

// Draws a mesh once more. `world` leads from the mesh's own space into the world: 16 numbers, column
// after column, affine. `name` is UTF-8, for people, and may be `NULL`.
klieg_status klieg_scene_add_instance(struct klieg_scene *scene,
                                      const char *name,
                                      uint32_t mesh,
                                      const double *world);

// Finishes a scene that was made of arrays: now it can be used, and nothing can be added any more.
//
// `KLIEG_ERROR_ARGUMENT` when nothing is drawn, or nothing that has any extent; the scene is then empty
// and can be begun anew.
klieg_status klieg_scene_finish(struct klieg_scene *scene);

// Gives the centre of a finished scene's bounding box (3 numbers), the largest distance of a vertex from it (both
// world units), and the number of triangles, instances counted each. Each pointer may be `NULL`.
klieg_status klieg_scene_bounds(struct klieg_scene *scene,
                                double *center,
                                double *radius,
                                uint32_t *triangles);

// What was left out or replaced in making a finished scene, for people: lines of UTF-8, often none.
// Valid until the scene is destroyed; never `NULL`.
const char *klieg_scene_warnings(const struct klieg_scene *scene);

/* Cameras that klieg draws scenes through */

// A lens: one of `KLIEG_LENS_...`.
typedef int32_t klieg_lens;

// A camera in the world, right handed. The picture's own aspect ratio decides the width.
typedef struct klieg_camera {
    // Position, world units.
    double eye[3];
    // Unit axis to the viewer's right.
    double right[3];
    // Unit axis up.
    double up[3];
    // Unit axis from the scene to the viewer.
    double back[3];
    // Lens.
    klieg_lens lens;
    // What the lens says.
    double size;
    // Distance of the near clipping plane, world units: above 0, or from 0 on for an orthographic lens.
    double near_plane;
    // Distance of the far clipping plane; 0 where there is none.
    double far_plane;
} klieg_camera;

// From where, how wide and how closely a scene is looked at.
typedef struct klieg_framing {
    // Towards the scene's right (+x) from its front (+z), radians; by default 30 degrees.
    double azimuth;
    // Upwards (+y), radians; by default 15 degrees.
    double elevation;
    // Vertical field of view, radians; by default 35 degrees.
    double fov;
    // Share of the picture's height or width, whichever binds, that the scene takes, above 0 and at most
    // 1; by default 0.85.
    double fill;
} klieg_framing;

// `klieg_camera::size` is the vertical field of view, radians, below pi.
#define KLIEG_LENS_PERSPECTIVE 0

// `klieg_camera::size` is half of the picture's height, world units.
#define KLIEG_LENS_ORTHOGRAPHIC 1

// Makes a camera at `eye` that looks at `target`, with `up` above, 3 numbers each. Its near plane stands at a thousandth
// of the distance (an orthographic one's at the eye), and there is no far plane; both can be set. Any
// thread.
klieg_status klieg_camera_look_at(const double *eye,
                                  const double *target,
                                  const double *up,
                                  klieg_lens lens,
                                  double size,
                                  struct klieg_camera *camera);

// Makes the camera of an engine's view matrix: eye space from world space, right handed, looking along
// -z, a rotation and a translation; 16 numbers, column after column. `near_plane` and `far_plane` as in
// `klieg_camera`. Any thread.
klieg_status klieg_camera_from_view(const double *view,
                                    klieg_lens lens,
                                    double size,
                                    double near_plane,
                                    double far_plane,
                                    struct klieg_camera *camera);

// Gives the camera of a finished scene that `name` names, or else numbers from 0. Any thread, while
// nobody changes the scene.
klieg_status klieg_camera_of_scene(const klieg_scene *scene,
                                   const char *name,
                                   struct klieg_camera *camera);

// Sets the defaults. Any thread.
klieg_status klieg_framing_defaults(struct klieg_framing *framing);

// Makes the camera that shows all of a finished scene in the middle of a picture whose width is `aspect`
// times its height. `framing` may be `NULL`, for the defaults. Any thread, while nobody changes the
// scene.
klieg_status klieg_camera_frame(const klieg_scene *scene,
                                const struct klieg_framing *framing,
                                double aspect,
                                struct klieg_camera *camera);

/* Evaluators: lights in, scores out */

// Most terms of an objective.
#define KLIEG_MAX_TERMS 16

// `klieg_objective::mean_target` that the scene sets: half of the mean luminance of its base colours,
// encoded, kept in 0.25..0.72. An engine that gives no base colours has the uniform one that it names.
#define KLIEG_MEAN_TARGET_SCENE -1.0

// `klieg_objective::background` that is not known.
#define KLIEG_NO_BACKGROUND -1.0

// Measures lights against a view. There are three levels, by what the engine gives:
// 1. a scene and a camera (`klieg_evaluator_of_scene`, or `klieg_evaluator_on_cpu` without any Vulkan device): klieg
//    draws them itself;
// 2. the surface that the engine has drawn (`klieg_evaluator_of_surface`): klieg shades it;
// 3. the surface, and pictures of it under lights (`klieg_evaluator_of_pictures`): klieg judges them.
//
// One thread at a time. Functions that record never submit, wait or make anything. Functions that evaluate,
// and those that make an evaluator, submit to the context's queue and wait.
typedef struct klieg_evaluator klieg_evaluator;

// A term of the objective by its name, with a number: its weight, or its value for a picture.
//
// A picture is judged by a weighted sum of terms, each 0..1, lower is better. `klieg_term_at` lists them.
typedef struct klieg_term {
    // Its name. Names that klieg gives stay valid as long as the library is loaded.
    const char *name;
    // Weight or value.
    float value;
} klieg_term;

// Settings of the quality function. The defaults are those of the profile "natural".
typedef struct klieg_objective {
    // Weight of each term, 0 or more, not all 0; terms that are not there do not count. By default those of
    // ten terms, which do not sum to 1; "paper" gives 0.2 to each of "edge", "mean", "grad", "var" and
    // "hist", so that its scores lie in 0..1. `klieg_objective_set_weight` changes one. Names that are not there are refused where an
    // evaluator is made, with the known ones in the message.
    struct klieg_term weights[KLIEG_MAX_TERMS];
    // How many of `weights` there are.
    uint32_t weight_count;
    // Mean brightness aimed at, sRGB-encoded, 0..1, or `KLIEG_MEAN_TARGET_SCENE`, the default.
    float mean_target;
    // Photographic stops by which that is moved, -4..4, one doubling its light; by default 0.
    float mean_stops;
    // Standard deviation of the brightness that the term "spread" aims at, sRGB-encoded, 0..0.5; by default 0.2.
    float spread_target;
    // Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel, above 0;
    // by default 0.06.
    float edge_contrast;
    // Sobel length of the depth above which a pixel can be an edge, scene radii a pixel; by default
    // 0.02.
    float edge_sobel;
    // Absolute Laplacian of the depth above which a pixel can be an edge, scene radii; by default 0.02.
    float edge_laplace;
    // Luminance behind the objects, sRGB-encoded, 0..1, from which the term "outline" makes them stand out; or
    // `KLIEG_NO_BACKGROUND`, the default, which makes the weights of terms that need one count as 0.
    float background;
} klieg_objective;

// How surfaces reflect: one of `KLIEG_BRDF_...`.
typedef int32_t klieg_brdf;

// klieg's own shading, which levels 1 and 2 use. The defaults are those of the profile "natural".
typedef struct klieg_shading {
    // How surfaces reflect; by default as glTF has it.
    klieg_brdf brdf;
    // Share of the base colour that is seen without any light, 0 or more; by default 0.
    float ambient;
    // Specular reflectance of dielectrics at normal incidence, 0..1; by default 0.04.
    float dielectric;
    // Largest Blinn-Phong exponent, 1 or more; by default 4096.
    float max_shininess;
} klieg_shading;

// Shadows of a scene that klieg draws itself. The defaults are those of the profile "natural".
typedef struct klieg_shadows {
    // 1, the default, where lights cast shadows; 0 where they do not.
    uint32_t on;
    // Directions along a side of the map in which each pixel is looked at, an odd number, 3..63; by default 31.
    uint32_t side;
    // Most memory of the table of shadows, MiB, 1 or more; by default 1024. A table that would be larger has
    // fewer directions.
    uint32_t memory;
} klieg_shadows;

// A picture's quality.
typedef struct klieg_quality {
    // The weighted sum of the terms: lower is better.
    float score;
    // How many of `terms` there are.
    uint32_t term_count;
    // The objective's terms, in the order of `klieg_term_at`. Terms of weight 0 are left out where only they need what
    // was not measured.
    struct klieg_term terms[KLIEG_MAX_TERMS];
} klieg_quality;

// What klieg can judge pictures by.
typedef struct klieg_term_info {
    // Its name.
    const char *name;
    // What it is called before people.
    const char *title;
    // What it says of a picture, in English: a sentence without its subject.
    const char *meaning;
    // What pictures have to be measured for besides their brightness and gradients, which takes time:
    // "detail", "channels", "irradiance", "target", "background", "example" or several of them with spaces between;
    // empty for nothing.
    const char *needs;
} klieg_term_info;

// A full set of defaults that settings start from, by its name.
typedef struct klieg_profile_info {
    // Its name, as `klieg_objective_profile`, `klieg_shading_profile`, `klieg_shadows_profile` and
    // `klieg_design_profile` take it.
    const char *name;
    // What it is, in English.
    const char *meaning;
} klieg_profile_info;

// Lambert, and a Blinn-Phong lobe of the material's width.
#define KLIEG_BRDF_BLINN_PHONG 0

// As glTF 2.0 has it: Lambert under GGX.
#define KLIEG_BRDF_GLTF 1

// The same with what rough surfaces scatter more than once.
#define KLIEG_BRDF_GLTF_SCATTERING 2

// Makes an evaluator of level 1: of a finished scene, through a camera, at `width` by `height` pixels.
// It draws the scene, and keeps nothing of it that the caller has. `objective`, `shading` and `shadows` may be
// `NULL`, for the defaults. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for a picture larger than the device can draw, `KLIEG_ERROR_UNSUPPORTED` on a
// device that was not borrowed with `KLIEG_NEEDS_SCENE`.
klieg_status klieg_evaluator_of_scene(const klieg_context *context,
                                      const klieg_scene *scene,
                                      const klieg_camera *camera,
                                      uint32_t width,
                                      uint32_t height,
                                      const struct klieg_objective *objective,
                                      const struct klieg_shading *shading,
                                      const struct klieg_shadows *shadows,
                                      struct klieg_evaluator **evaluator);

// Makes an evaluator of level 1 that works on the CPU: no Vulkan device and no context are needed. Everything else is
// as with `klieg_evaluator_of_scene`, and scores are the same to 1e-4. It uses all processors. What records does not
// work with it. Any thread.
//
// `version` is `KLIEG_VERSION`. `KLIEG_ERROR_VERSION` for a program that was built for another klieg,
// `KLIEG_ERROR_ARGUMENT` as with `klieg_evaluator_of_scene`.
klieg_status klieg_evaluator_on_cpu(uint32_t version,
                                    const klieg_scene *scene,
                                    const klieg_camera *camera,
                                    uint32_t width,
                                    uint32_t height,
                                    const struct klieg_objective *objective,
                                    const struct klieg_shading *shading,
                                    const struct klieg_shadows *shadows,
                                    struct klieg_evaluator **evaluator);

// Ends the evaluator; `NULL` is left alone. None of its recordings may be in use.
void klieg_evaluator_destroy(struct klieg_evaluator *evaluator);

// Gives the light frame of the view that was made or recorded last: all lights stand in it.
//
// `KLIEG_NOTHING_YET` before the first view of an evaluator of level 2 or 3.
klieg_status klieg_evaluator_frame(struct klieg_evaluator *evaluator, klieg_frame *into);

// Makes memory and pipelines for populations of up to `rigs` rigs of `lights_per_rig` lights, so that recording
// finds all that it needs. None of the evaluator's recordings may be in use. At level 3, `rigs` is the
// number of pictures, and `lights_per_rig` does not count.
klieg_status klieg_evaluator_reserve(struct klieg_evaluator *evaluator,
                                     uint32_t rigs,
                                     uint32_t lights_per_rig);

// Records the evaluation of `rigs` rigs of `lights_per_rig` lights each, one rig after the other, into
// an engine's command buffer (levels 1 and 2).
//
// The lights are copied into the commands, so that the array may change at once and a recording may be
// made while the last one runs. What was recorded before, on the same queue, is waited for by a barrier
// first. When the commands have run, the scores are in `buffer` from the byte `offset` on, a float for
// each rig, as a write of `VK_ACCESS_TRANSFER_WRITE_BIT` in `VK_PIPELINE_STAGE_TRANSFER_BIT`, which the
// engine makes visible to its readers; or, where `buffer` is `VK_NULL_HANDLE`, with
// `klieg_evaluator_read_scores` until the next recording runs. Pipeline, sets and push constants that were bound are not any more.
//
// `commands` is being recorded, outside render passes, on the context's device for the family of its
// queue. Its submissions run one after the other, none beside functions that evaluate, and the
// evaluator outlives them. `buffer` has `VK_BUFFER_USAGE_TRANSFER_DST_BIT`, and `offset` is a multiple of
// 4.
//
// `KLIEG_ERROR_ARGUMENT` for a population that `klieg_evaluator_reserve` has made no room for.
klieg_status klieg_evaluator_record(struct klieg_evaluator *evaluator,
                                    VkCommandBuffer commands,
                                    const klieg_light *lights,
                                    uint32_t rigs,
                                    uint32_t lights_per_rig,
                                    VkBuffer buffer,
                                    VkDeviceSize offset);

// Reads the first `count` scores of the last recording without a buffer. Its commands have run: the
// caller has waited for their fence.
klieg_status klieg_evaluator_read_scores(struct klieg_evaluator *evaluator,
                                         float *scores,
                                         uint32_t count);

// Evaluates `rigs` rigs of `lights_per_rig` lights each, one rig after the other, and waits for the
// scores, one for each rig: lower is better (levels 1 and 2).
klieg_status klieg_evaluator_evaluate(struct klieg_evaluator *evaluator,
                                      const klieg_light *lights,
                                      uint32_t rigs,
                                      uint32_t lights_per_rig,
                                      float *scores);

// As `klieg_evaluator_evaluate`, with the terms of each rig beside its score.
klieg_status klieg_evaluator_qualities(struct klieg_evaluator *evaluator,
                                       const klieg_light *lights,
                                       uint32_t rigs,
                                       uint32_t lights_per_rig,
                                       struct klieg_quality *qualities);

// Describes the term of that number, counted from 0; `NULL` beyond the last, which is no error. The
// description stays valid as long as the library is loaded. Any thread.
const struct klieg_term_info *klieg_term_at(uint32_t number);

// Describes the profile of that number, counted from 0; `NULL` beyond the last, which is no error. The
// description stays valid as long as the library is loaded. Any thread.
const struct klieg_profile_info *klieg_profile_at(uint32_t number);

// Sets the defaults. Any thread.
klieg_status klieg_objective_defaults(struct klieg_objective *objective);

// Sets what the profile of that name has. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
klieg_status klieg_objective_profile(struct klieg_objective *objective, const char *profile);

// Gives a term its weight, 0 or more. The weights then stand in the order of `klieg_term_at`. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for a name that is none of a term, with the known ones in the message.
klieg_status klieg_objective_set_weight(struct klieg_objective *objective,
                                        const char *name,
                                        float weight);

// Sets the defaults. Any thread.
klieg_status klieg_shading_defaults(struct klieg_shading *shading);

// Sets what the profile of that name has. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
klieg_status klieg_shading_profile(struct klieg_shading *shading, const char *profile);

// Sets the defaults. Any thread.
klieg_status klieg_shadows_defaults(struct klieg_shadows *shadows);

// Sets what the profile of that name has. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
klieg_status klieg_shadows_profile(struct klieg_shadows *shadows, const char *profile);

/* Level 2: the surface that an engine has drawn */

// An engine's surface as an evaluator reads it. It may outlive the evaluator; then it is of no use.
typedef struct klieg_surface klieg_surface;

// Which space an engine's normals are in: one of `KLIEG_NORMALS_...`.
typedef int32_t klieg_normal_space;

// How an engine's normals are coded: one of `KLIEG_NORMAL_CODE_...`.
typedef int32_t klieg_normal_code;

// How the images of an engine's surface are to be read.
typedef struct klieg_surface_format {
    // Space of the normals; by default the world's.
    klieg_normal_space normal_space;
    // Code of the normals; by default signed. Normals that face away from the viewer are mirrored
    // to face it.
    klieg_normal_code normal_code;
    // `VK_TRUE` where base colours come out of the image sRGB-encoded, which those of an sRGB format do
    // not; by default `VK_FALSE`.
    VkBool32 base_color_encoded;
    // Component of the roughness (perceptual, as glTF has it), 0 to 3; by default 1 (green).
    uint32_t roughness_channel;
    // Component of the metallic factor, 0 to 3; by default 2 (blue).
    uint32_t metallic_channel;
    // Depth of pixels where nothing is drawn, 0..1; by default 1. Without ids these are the background.
    float cleared_depth;
    // `VK_TRUE` where the first row of the images is at y = 1 of clip space, as with a viewport of negative
    // height; `VK_FALSE`, the default, where it is at y = -1 by Vulkan's own rule.
    VkBool32 flipped;
    // Linear base colour where there is no image of it; by default 0.8.
    float base_color[3];
    // Roughness where there is no image of it, 0..1; by default 1.
    float roughness;
    // Metallic factor where there is no image of it, 0..1; by default 0.
    float metallic;
} klieg_surface_format;

// An image of an engine.
typedef struct klieg_image {
    // A two-dimensional view of one aspect, whose image may be sampled; `VK_NULL_HANDLE` where there is
    // none.
    VkImageView view;
    // The layout that the image is in whenever klieg reads it, one that allows sampling.
    VkImageLayout layout;
} klieg_image;

// The images of an engine's surface, all of the evaluator's size. klieg reads them by texel fetch, so that
// any float, normalised or sRGB format will do.
typedef struct klieg_surface_images {
    // Depth as the engine's projection gives it: the depth aspect, or a colour of one component. It must
    // be there.
    struct klieg_image depth;
    // Shading normals; without them normals are made of the depth.
    struct klieg_image normal;
    // Base colours.
    struct klieg_image base_color;
    // Roughness and metallic factor.
    struct klieg_image roughness_metallic;
    // Linear emitted radiance.
    struct klieg_image emissive;
    // Numbers of objects or polygons, unsigned integers; 0 is the background.
    struct klieg_image ids;
} klieg_surface_images;

// The camera that an engine has drawn with, and the bounds of its scene. Matrices have 16 numbers, column
// after column.
typedef struct klieg_engine_camera {
    // Eye space from world space, a rotation and a translation: x to the right, y up, the view along -z.
    double view[16];
    // Clip space from eye space, as the engine draws with it: depth 0 to 1 or reversed, far plane finite or
    // not, perspective or parallel.
    double projection[16];
    // Centre of the scene, world units: lights are placed around it.
    double center[3];
    // Radius of the scene around it, world units: the unit of the lights' lengths.
    double radius;
} klieg_engine_camera;

// The world's.
#define KLIEG_NORMALS_WORLD 0

// The eye's, of `klieg_engine_camera::view`.
#define KLIEG_NORMALS_EYE 1

// Three components -1..1, of any length.
#define KLIEG_NORMAL_CODE_SIGNED 0

// Three components 0..1, (n + 1) / 2.
#define KLIEG_NORMAL_CODE_UNSIGNED 1

// Two components -1..1, octahedral (Cigolle et al. 2014).
#define KLIEG_NORMAL_CODE_OCTAHEDRAL 2

// Two components 0..1, octahedral.
#define KLIEG_NORMAL_CODE_OCTAHEDRAL_UNSIGNED 3

// Makes an evaluator of level 2, for surfaces of `width` by `height` pixels. Before the first view its
// picture is empty. `objective` and `shading` may be `NULL`, for the defaults. Lights cast no shadows. Any
// thread.
//
// `KLIEG_ERROR_ARGUMENT` for a picture larger than the device can take.
klieg_status klieg_evaluator_of_surface(const klieg_context *context,
                                        uint32_t width,
                                        uint32_t height,
                                        const klieg_objective *objective,
                                        const klieg_shading *shading,
                                        klieg_evaluator **evaluator);

// Sets the defaults. Any thread.
klieg_status klieg_surface_format_defaults(struct klieg_surface_format *format);

// Takes an engine's images in, for this evaluator of level 2 or 3: once for each set of images that the
// engine draws into. At level 3 only depth, normals and ids count. `format` may be `NULL`, for the
// defaults. The thread that uses the evaluator.
//
// The views are of the context's device and of the evaluator's size, and stay alive as long as what is
// recorded with the surface runs.
klieg_status klieg_surface_create(const klieg_evaluator *evaluator,
                                  const struct klieg_surface_images *images,
                                  const struct klieg_surface_format *format,
                                  struct klieg_surface **surface);

// Ends the surface, not its images; `NULL` is left alone. No recording with it may be in use.
void klieg_surface_destroy(struct klieg_surface *surface);

// Records the making of the maps of what the engine has drawn into the surface's images (levels 2 and 3).
// What is recorded or evaluated later, until the next view, is measured against this view, and its frame
// is that of `klieg_evaluator_frame`.
//
// `commands` as for `klieg_evaluator_record`; evaluator and surface outlive its submissions. The images
// are in their stated layouts and visible to `VK_ACCESS_SHADER_READ_BIT` in
// `VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT`. They are left as they are, and may be written again after a
// barrier from that stage.
//
// `KLIEG_ERROR_ARGUMENT` for a camera that is not finite, not rigid, or neither perspective nor parallel.
klieg_status klieg_evaluator_record_view(klieg_evaluator *evaluator,
                                         VkCommandBuffer commands,
                                         const struct klieg_surface *surface,
                                         const struct klieg_engine_camera *camera);

// As `klieg_evaluator_record_view`, submitted and waited for at once. No recording of this evaluator may
// be in use.
klieg_status klieg_evaluator_look(klieg_evaluator *evaluator,
                                  const struct klieg_surface *surface,
                                  const struct klieg_engine_camera *camera);

/* Level 3: pictures that an engine has rendered */

// An engine's pictures as an evaluator reads them. They may outlive the evaluator.
typedef struct klieg_pictures klieg_pictures;

// How the colours of an engine's pictures are encoded: one of `KLIEG_ENCODING_...`.
typedef int32_t klieg_encoding;

// Which components of an engine's pictures count: one of `KLIEG_CHANNELS_...`.
typedef int32_t klieg_channels;

// Linear radiance, of which 1 is the brightest that is shown: what float images hold, and what images of an
// sRGB format give.
#define KLIEG_ENCODING_LINEAR 0

// sRGB-encoded: what 8-bit images of a plain format hold.
#define KLIEG_ENCODING_SRGB 1

// Red, green and blue, with Rec. 709 primaries.
#define KLIEG_CHANNELS_RGB 0

// The first alone, a luminance.
#define KLIEG_CHANNELS_RED 1

// Makes an evaluator of level 3, for pictures of `width` by `height` pixels. It needs a surface and a view
// of it as level 2 does (`klieg_surface_create`, `klieg_evaluator_record_view`): before the first view
// its picture is empty. `objective` may be `NULL`, for the defaults. Pictures do not tell the irradiance: terms
// that need it do not count where their weights are those of the defaults. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for such terms with other weights above 0, and for a picture larger than the device can
// take.
klieg_status klieg_evaluator_of_pictures(const klieg_context *context,
                                         uint32_t width,
                                         uint32_t height,
                                         const klieg_objective *objective,
                                         klieg_evaluator **evaluator);

// Takes an engine's pictures in, for evaluators of this context: once for each layered image that the
// engine renders into. klieg reads them by texel fetch, so that any float, normalised or sRGB format will
// do. The thread that uses the evaluator.
//
// `image` is a two-dimensional array view of `layers` layers of the evaluator's size, on the context's
// device; it stays alive as long as the handle is used.
klieg_status klieg_pictures_create(const klieg_evaluator *evaluator,
                                   klieg_image image,
                                   uint32_t layers,
                                   klieg_encoding encoding,
                                   klieg_channels channels,
                                   struct klieg_pictures **pictures);

// Ends the pictures, not their image; `NULL` is left alone. No recording with them may be in use.
void klieg_pictures_destroy(struct klieg_pictures *pictures);

// Records the evaluation of `count` pictures from layer `first` on, which show the view that was recorded
// last. `commands`, `buffer` and `offset` as for `klieg_evaluator_record`; evaluator and pictures
// outlive its submissions. The image's state as for `klieg_evaluator_record_view`.
//
// `KLIEG_ERROR_ARGUMENT` for layers that are not there, and for more pictures than
// `klieg_evaluator_reserve` has made room for.
klieg_status klieg_evaluator_record_pictures(klieg_evaluator *evaluator,
                                             VkCommandBuffer commands,
                                             const struct klieg_pictures *pictures,
                                             uint32_t first,
                                             uint32_t count,
                                             VkBuffer buffer,
                                             VkDeviceSize offset);

// Evaluates the first `count` pictures and waits for the scores: lower is better. The image's state as for
// `klieg_evaluator_record_view`.
klieg_status klieg_evaluator_evaluate_pictures(klieg_evaluator *evaluator,
                                               const struct klieg_pictures *pictures,
                                               uint32_t count,
                                               float *scores);

// As `klieg_evaluator_evaluate_pictures`, with the terms of each picture beside its score.
klieg_status klieg_evaluator_qualities_of_pictures(klieg_evaluator *evaluator,
                                                   const struct klieg_pictures *pictures,
                                                   uint32_t count,
                                                   klieg_quality *qualities);

/* The search for lights */

// A search for the lights with the lowest score, which its caller advances. One thread at a time. It knows of no device: scores come from an evaluator, at once or frames later.
typedef struct klieg_designer klieg_designer;

// The values that lights of a role may have, each the lowest and the highest.
typedef struct klieg_role_box {
    // Elevation, degrees.
    float elevation[2];
    // Azimuth, degrees, -360 or more; it does not wrap, so that 100..260 is the half circle behind.
    float azimuth[2];
    // 1 for azimuths that are measured from the first key light's, positive to the left of a key on the right
    // and to the right of any other; else 0. For fill and rim lights beside a key.
    uint32_t azimuth_from_key;
    // 1 for intensities that are shares of the first key light's; else 0. For fill and rim lights beside a
    // key.
    uint32_t share_of_key;
    // Diffuse intensity, 0 or more.
    float diffuse[2];
    // Specular intensity, 0 or more.
    float specular[2];
    // Distance from the scene's centre, scene radii, above 0.
    float distance[2];
    // Half angle of a spot's cone, degrees, 0.1..90; that of its inner cone is half of it.
    float cone[2];
    // Angle that a light covers seen from the scene's centre, degrees, 0..60.
    float softness;
    // Colour of the lights, linear RGB, 0 or more, whose brightness does not count; all 0: white.
    float color[3];
} klieg_role_box;

// What a designer looks for, and how. The defaults are those of the profile "natural".
// `klieg_design_defaults` sets all but `roles`, `lights` and `first`, which it makes empty.
typedef struct klieg_design {
    // The role of each light.
    const klieg_role *roles;
    // Number of lights, 1..`KLIEG_MAX_LIGHTS`.
    uint32_t lights;
    // Kind of all lights; by default point lights.
    klieg_light_kind kind;
    // Intensities of each light: 1, the default, for one, as lamps have, in the range `diffuse` of its role; 2
    // for a diffuse and a specular one that are free of each other.
    uint32_t intensities;
    // What key lights may be; by default elevation 0..90, azimuth -90..90, intensity 0..6, distance 1.5..5,
    // softness 4.
    struct klieg_role_box key;
    // What fill lights may be; by default as key lights, but for elevation -10..45, azimuth 20..110 from the
    // key's and 0.05..0.6 of its intensity.
    struct klieg_role_box fill;
    // What rim lights may be; by default as key lights, but for elevation 10..80, azimuth 110..250 and
    // 0.1..1.5 of the key's intensity.
    struct klieg_role_box rim;
    // How the lights are searched: `"shade"`, the differential evolution SHADE, which `NULL` stands for; `"ga"`, the
    // paper's genetic algorithm; `"cma-es"`, BIPOP-CMA-ES; `"greedy"`, steepest descents; `"restarts"`, such descents
    // one after another; or `"random"`.
    const char *optimizer;
    // Individuals of a generation, 2..131072; by default 20, of the profile "paper" 30. Of SHADE and random
    // search too.
    uint32_t population;
    // Generations after which the search ends, counted anew from a change of the view; 0, the default, for
    // never. Of SHADE and random search too, and descents with restarts end after as many evaluations; greedy
    // descents end where the ground is level, until the view changes.
    uint64_t generations;
    // Generations without a better rig after which the search ends, counted likewise; 0, the default, for
    // never. Of SHADE too.
    uint64_t patience;
    // Share of the population, the best, that is copied with its scores; by default 0.1.
    float elitism;
    // Probability that a child is a blend of two parents; by default 0.8.
    float crossover;
    // Probability with which each value of a child is moved; by default 0.2.
    float mutation;
    // Standard deviation of that move, as a share of the value's range; by default 0.2.
    float mutation_step;
    // Individuals that compete to be a parent, 1 or more; by default 2.
    uint32_t tournament;
    // Share of the first population that scatters around the first rig, 0..1; by default 0.3333. The rest
    // is uniform.
    float scattered;
    // Standard deviation of that scatter as a share of each value's range, 0..1; by default 0.1.
    float spread;
    // Greedy descents side by side, 1..1024; by default 1. The first begins with the first rig, the others
    // with random ones.
    uint32_t greedy_starts;
    // Distance of a descent's probes, above 0, to 1, as a share of each value's range; by default 0.005.
    float greedy_probe;
    // Length of a descent's first step, such a share; by default 0.1.
    float greedy_step;
    // Length of a step below which a descent has ended, such a share; by default 0.001.
    float greedy_end;
    // Entries of SHADE's history of successful parameters, 1..4096; by default 10.
    uint32_t shade_history;
    // Individuals of its archive, as a multiple of the population, 0..10; by default 1.
    float shade_archive;
    // Largest share of the population that counts as its best, 0..1; by default 0.2.
    float shade_best;
    // Its population has settled when the scores differ by no more than this share of the lowest, to 1; by
    // default 0.003. Below 0 (to -1) it never has.
    float shade_settled;
    // Populations one after another, each from random rigs where the one before it has settled; 0, the default,
    // for no end.
    uint64_t shade_starts;
    // Unit vector upwards in the light frame (`klieg_frame`), so that no light stands below the horizon of the scene's
    // centre; all 0, the default, where lights may stand below.
    float up[3];
    // The first rig, `lights` of them, each value moved to the nearest one that its role may have:
    // `klieg_evaluator_suggest`, a rig of the engine's, or `NULL` for the middle of every range.
    const klieg_light *first;
    // What all random numbers come from: the same seed gives the same lights on the same device. By
    // default 0.
    uint64_t seed;
} klieg_design;

// How a search stands after a generation; before the first it is generation 0, with infinite scores.
typedef struct klieg_progress {
    // Number of the generation; the first population is 1.
    uint64_t generation;
    // Evaluations so far.
    uint64_t evaluations;
    // Lowest score so far, since the view last changed.
    float best;
    // Mean score of what the search holds.
    float mean;
    // Highest of these scores.
    float worst;
} klieg_progress;

// The character of a light: one of `KLIEG_MOOD_...`.
typedef int32_t klieg_mood;

// What light is wanted. `klieg_intent_defaults` wants nothing. That no light stands below the horizon is said by
// `klieg_design::up`.
typedef struct klieg_intent {
    // Steps of brightness, -2..2; by default 0.
    float brightness;
    // Steps of contrast, -2..2; by default 0.
    float contrast;
    // The character; by default natural.
    klieg_mood mood;
} klieg_intent;

// Large lights, a strong fill, little contrast.
#define KLIEG_MOOD_SOFT 0

// As the profile has it.
#define KLIEG_MOOD_NATURAL 1

// A small key from anywhere in front, hardly any fill, shadows that may be black.
#define KLIEG_MOOD_DRAMATIC 2

// Sets the defaults: a search without an end for point lights of the profile "natural", by SHADE. Any thread.
klieg_status klieg_design_defaults(struct klieg_design *design);

// As `klieg_design_defaults`, with the lights and the optimiser as the profile of that name has them. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
klieg_status klieg_design_profile(struct klieg_design *design,
                                  const char *profile);

// Gives the `design->lights` lights that the view suggests as a first rig: they face what is most of the
// visible surface (k-means of its normals). Reads the view's maps back, so the commands of the view have
// run. `design->first` does not count.
klieg_status klieg_evaluator_suggest(klieg_evaluator *evaluator,
                                     const struct klieg_design *design,
                                     klieg_light *lights);

// Makes a designer. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` names the setting that is out of its range, and lists the optimizers where
// `design->optimizer` is none of them.
klieg_status klieg_designer_create(const struct klieg_design *design,
                                   struct klieg_designer **designer);

// Ends the designer; `NULL` is left alone.
void klieg_designer_destroy(struct klieg_designer *designer);

// Gives the rigs whose scores the search wants next: `*rigs` of them, one after the other, each with the
// design's number of lights; none when the search has ended. `capacity` is the number of lights that
// `lights` has room for. Of `"shade"`, `"ga"` and `"random"`, `klieg_design::population` · `klieg_design::lights` is in
// any case enough; descents ask for two rigs for each value of each light of each descent, and `"cma-es"` for 1,025
// at most. Asking again gives the same until `klieg_designer_tell`.
//
// Elites of the genetic algorithm keep their scores, so that there are fewer rigs after the first
// generation. `lights` may be `NULL` to be told their number alone.
klieg_status klieg_designer_ask(struct klieg_designer *designer,
                                klieg_light *lights,
                                uint32_t capacity,
                                uint32_t *rigs);

// Takes the scores of `klieg_designer_ask`, in order, `count` of them; `progress` may be `NULL`. Scores of
// a population that was asked for before the view changed must not be told after.
klieg_status klieg_designer_tell(struct klieg_designer *designer,
                                 const float *scores,
                                 uint32_t count,
                                 struct klieg_progress *progress);

// Evaluates so many generations at once, or fewer where the search ends; `progress` may be `NULL`. The
// evaluator is of level 1 or 2.
klieg_status klieg_designer_advance(struct klieg_designer *designer,
                                    klieg_evaluator *evaluator,
                                    uint32_t generations,
                                    struct klieg_progress *progress);

// Evaluates generations for about `seconds` of wall time: the first is always made, another only where it
// ends in time if it takes as long as the one before. `progress` may be `NULL`. The evaluator is of
// level 1 or 2.
klieg_status klieg_designer_advance_for(struct klieg_designer *designer,
                                        klieg_evaluator *evaluator,
                                        double seconds,
                                        struct klieg_progress *progress);

// Gives the best rig so far, the design's number of lights, and its score; either pointer
// may be `NULL`. `capacity` is the number of lights that `lights` has room for. It starts anew with the first
// scores after a change of the view; until then it is the one from before, where it stands now.
//
// `KLIEG_NOTHING_YET` before the first scores.
klieg_status klieg_designer_best(struct klieg_designer *designer,
                                 klieg_light *lights,
                                 uint32_t capacity,
                                 float *score);

// Goes on in another light frame, as the camera has moved: the lights stay where they are in the world, as
// near as their roles allow, and are all scored anew. Where both frames are the same nothing happens.
klieg_status klieg_designer_follow(struct klieg_designer *designer,
                                   const klieg_frame *from,
                                   const klieg_frame *to);

// Goes on with what the search holds as it stands, all of it scored anew: the scene, or what the evaluator
// measures, has changed.
klieg_status klieg_designer_renew(struct klieg_designer *designer);

// Sets the defaults. Any thread.
klieg_status klieg_intent_defaults(struct klieg_intent *intent);

// Changes the targets and weights of `objective` and the boxes of `design`, from which an evaluator and a designer are
// then made, into those of such light. Where nothing is wanted they stay as they are. Any thread.
//
// `KLIEG_ERROR_ARGUMENT` for a step out of its range and for settings that are wrong already.
klieg_status klieg_intent_steer(const struct klieg_intent *intent,
                                klieg_objective *objective,
                                struct klieg_design *design);

/* Lit scenes: the file that a scene was loaded from, with the lights that were found */

// A lit scene: a whole glTF 2.0 file (GLB) in memory. One thread at a time.
typedef struct klieg_lit klieg_lit;

// Makes the lit scene of a scene that was loaded from a file: the file, which is read anew, with `count` lights
// (KHR_lights_punctual, physical units) in place of its own, and with the camera, all in one GLB. The lights stand in
// the frame of the view through `camera` at `width` by `height` pixels: the one that the evaluator was made of. Any
// thread.
//
// `KLIEG_ERROR_INPUT` for a file that cannot be used any more, `KLIEG_ERROR_ARGUMENT` for a scene that was made of
// arrays and for a light that glTF cannot express.
klieg_status klieg_lit_create(const klieg_scene *scene,
                              const klieg_camera *camera,
                              uint32_t width,
                              uint32_t height,
                              const klieg_light *lights,
                              uint32_t count,
                              struct klieg_lit **lit);

// Ends the lit scene; `NULL` is left alone.
void klieg_lit_destroy(struct klieg_lit *lit);

// Gives the bytes of the lit scene, `*size` of them, valid until it is destroyed.
klieg_status klieg_lit_data(const struct klieg_lit *lit, const void **data, size_t *size);

// Writes the lit scene to a file, whole or not at all; a file of that name is replaced. `path` is UTF-8.
//
// `KLIEG_ERROR_OUTPUT` where it cannot be written.
klieg_status klieg_lit_write(const struct klieg_lit *lit,
                             const char *path);

#ifdef __cplusplus
}
#endif

#endif
