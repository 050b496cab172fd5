/* An engine in C that lends klieg its device: with a lock for its queue and an allocator, at all three
 * levels, in its own command buffers.
 *
 * borrow [validate] [hazard] [forget] [leak]   under the validation layer; with a barrier that is missing;
 *                                              with klieg's objects left to a device that goes first; with an
 *                                              evaluator left behind */

#include "engine.h"

enum { LAYERS = 2, LIGHTS = 2, RIGS = 3 };

/* The engine's allocator and lock, which count. */
static int64_t alive;
static int held, locked;

static int32_t give(void *user, const klieg_memory_request *request, klieg_memory *memory) {
    EXPECT(user == &alive && strlen(request->name) > 0);
    const int mapped = request->access != KLIEG_ACCESS_DEVICE;
    const VkMemoryPropertyFlags host =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    memory->memory = allocate(request->requirements, mapped ? host : 0);
    if (mapped) {
        VK(vkMapMemory(device, memory->memory, 0, VK_WHOLE_SIZE, 0, &memory->mapped));
    }
    memory->token = (uint64_t)++alive;
    return 0;
}

static int32_t give_nothing(void *user, const klieg_memory_request *request, klieg_memory *memory) {
    (void)user, (void)request, (void)memory;
    return 5;
}

static void take_back(void *user, const klieg_memory *memory) {
    EXPECT(user == &alive && memory->token > 0);
    vkFreeMemory(device, memory->memory, NULL);
    alive--;
}

static uint64_t count_alive(void *user) { return (uint64_t) * (int64_t *)user; }

static void take_queue(void *user) {
    EXPECT(user == &queue && !held);
    held = 1;
    locked++;
}

static void give_queue(void *user) {
    EXPECT(user == &queue && held);
    held = 0;
}

static const klieg_allocator ALLOCATOR = {&alive, give, take_back, count_alive};

static klieg_device lent(void) {
    return (klieg_device){.get_instance_proc_addr = vkGetInstanceProcAddr,
                          .instance = instance,
                          .api_version = VK_API_VERSION_1_2,
                          .physical_device = physical,
                          .device = device,
                          .queue = queue,
                          .features = features,
                          .lock_queue = take_queue,
                          .unlock_queue = give_queue,
                          .queue_user = &queue,
                          .allocator = &ALLOCATOR};
}

static void make_rigs(klieg_light lights[RIGS * LIGHTS]) {
    for (int i = 0; i < RIGS * LIGHTS; i++) {
        lights[i] = (klieg_light){.role = KLIEG_ROLE_KEY,
                                  .kind = KLIEG_LIGHT_DIRECTIONAL,
                                  .elevation = 0.2f * (float)i,
                                  .azimuth = 0.3f,
                                  .distance = 1.0f,
                                  .diffuse = 1.0f,
                                  .specular = 0.5f};
    }
}

/* Recorded evaluations have the bits of immediate ones. */
static void record_rigs(klieg_evaluator *evaluator) {
    klieg_light lights[RIGS * LIGHTS];
    float expected[RIGS], scores[RIGS];
    floats target = make_floats(RIGS + 1);
    VkCommandBuffer commands = begin();
    make_rigs(lights);
    REFUSE(evaluator,
           klieg_evaluator_record(evaluator, commands, lights, RIGS, LIGHTS, VK_NULL_HANDLE, 0),
           KLIEG_ERROR_ARGUMENT, "no room");
    CHECK(evaluator, klieg_evaluator_evaluate(evaluator, lights, RIGS, LIGHTS, expected));
    EXPECT(expected[0] != expected[1] && expected[0] > 0.0f && expected[0] < 1.0f);
    CHECK(evaluator, klieg_evaluator_reserve(evaluator, RIGS, LIGHTS));
    CHECK(evaluator,
          klieg_evaluator_record(evaluator, commands, lights, RIGS, LIGHTS, VK_NULL_HANDLE, 0));
    CHECK(evaluator,
          klieg_evaluator_record(evaluator, commands, lights, RIGS, LIGHTS, target.buffer, 4));
    finish(commands);
    CHECK(evaluator, klieg_evaluator_read_scores(evaluator, scores, RIGS));
    EXPECT(memcmp(scores, expected, sizeof scores) == 0);
    EXPECT(memcmp(target.mapped + 1, expected, sizeof expected) == 0);
    drop_floats(target);
}

static klieg_evaluator *level_1(const klieg_context *context) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 1, -1, -1, 2, -1, 0, 1, 1, 0};
    static const double here[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const klieg_mesh triangles = {
        .vertices = 6, .positions = positions, .material = KLIEG_DEFAULT_MATERIAL};
    klieg_scene *scene;
    klieg_camera camera;
    klieg_evaluator *evaluator;
    uint32_t mesh;
    CHECK(NULL, klieg_scene_create("triangles", &scene));
    CHECK(scene, klieg_scene_add_mesh(scene, &triangles, &mesh));
    CHECK(scene, klieg_scene_add_instance(scene, NULL, mesh, here));
    CHECK(scene, klieg_scene_finish(scene));
    CHECK(NULL, klieg_camera_frame(scene, NULL, 1.0, &camera));
    CHECK(context,
          klieg_evaluator_of_scene(context, scene, &camera, SIDE, SIDE, NULL, NULL, NULL, &evaluator));
    klieg_scene_destroy(scene);
    return evaluator;
}

static klieg_surface *take_surface(klieg_evaluator *evaluator, picture depth) {
    const klieg_surface_images images = {.depth = {depth.view, VK_IMAGE_LAYOUT_GENERAL}};
    const klieg_surface_images none = {0};
    klieg_surface_format format;
    klieg_surface *surface;
    CHECK(NULL, klieg_surface_format_defaults(&format));
    REFUSE(evaluator, klieg_surface_create(NULL, &images, &format, &surface), KLIEG_ERROR_ARGUMENT, "");
    REFUSE(NULL, klieg_surface_create(evaluator, &none, &format, &surface), KLIEG_ERROR_ARGUMENT,
           "no depth");
    format.normal_code = 4;
    REFUSE(NULL, klieg_surface_create(evaluator, &images, &format, &surface), KLIEG_ERROR_ARGUMENT,
           "normal code 4");
    format.normal_code = KLIEG_NORMAL_CODE_SIGNED;
    CHECK(NULL, klieg_surface_create(evaluator, &images, &format, &surface));
    return surface;
}

static void level_2(const klieg_context *context, picture depth) {
    klieg_evaluator *evaluator, *other;
    klieg_frame frame;
    CHECK(context, klieg_evaluator_of_surface(context, SIDE, SIDE, NULL, NULL, &evaluator));
    CHECK(context, klieg_evaluator_of_surface(context, SIDE, SIDE, NULL, NULL, &other));
    klieg_surface *surface = take_surface(evaluator, depth);
    REFUSE(other, klieg_evaluator_look(other, surface, &CAMERA), KLIEG_ERROR_ARGUMENT, "another");
    klieg_engine_camera squeezed = CAMERA;
    squeezed.view[0] = 2.0;
    REFUSE(evaluator, klieg_evaluator_look(evaluator, surface, &squeezed), KLIEG_ERROR_ARGUMENT,
           "rotation");
    VkCommandBuffer commands = begin();
    CHECK(evaluator, klieg_evaluator_record_view(evaluator, commands, surface, &CAMERA));
    finish(commands);
    CHECK(evaluator, klieg_evaluator_frame(evaluator, &frame));
    EXPECT(frame.radius == 1.5 && frame.back[2] == 1.0);
    record_rigs(evaluator);
    klieg_evaluator_destroy(evaluator);
    klieg_evaluator_destroy(other);
    klieg_surface_destroy(surface);
}

static void level_3(const klieg_context *context, picture depth) {
    klieg_evaluator *evaluator;
    klieg_pictures *pictures;
    float scores[LAYERS], recorded[LAYERS];
    klieg_quality qualities[LAYERS];
    klieg_light light = {0};
    CHECK(context, klieg_evaluator_of_pictures(context, SIDE, SIDE, NULL, &evaluator));
    klieg_surface *surface = take_surface(evaluator, depth);
    CHECK(evaluator, klieg_evaluator_look(evaluator, surface, &CAMERA));
    floats content = make_floats(LAYERS * PIXELS);
    for (int i = 0; i < LAYERS * PIXELS; i++) {
        content.mapped[i] = i < PIXELS ? (float)(i % SIDE) / SIDE : 0.1f;
    }
    picture layers = make_picture(LAYERS, content.buffer);
    const klieg_image image = {layers.view, VK_IMAGE_LAYOUT_GENERAL};
    REFUSE(NULL, klieg_pictures_create(evaluator, image, LAYERS, 2, 0, &pictures), KLIEG_ERROR_ARGUMENT,
           "encoding 2");
    CHECK(NULL, klieg_pictures_create(evaluator, image, LAYERS, KLIEG_ENCODING_LINEAR,
                                      KLIEG_CHANNELS_RED, &pictures));
    CHECK(evaluator, klieg_evaluator_evaluate_pictures(evaluator, pictures, LAYERS, scores));
    CHECK(evaluator, klieg_evaluator_qualities_of_pictures(evaluator, pictures, LAYERS, qualities));
    EXPECT(scores[0] < scores[1] && qualities[1].score == scores[1]);
    CHECK(evaluator, klieg_evaluator_reserve(evaluator, LAYERS, 0));
    VkCommandBuffer commands = begin();
    REFUSE(evaluator,
           klieg_evaluator_record_pictures(evaluator, commands, pictures, 1, LAYERS, VK_NULL_HANDLE, 0),
           KLIEG_ERROR_ARGUMENT, "layer");
    CHECK(evaluator, klieg_evaluator_record_pictures(evaluator, commands, pictures, 0, LAYERS,
                                                     VK_NULL_HANDLE, 0));
    finish(commands);
    CHECK(evaluator, klieg_evaluator_read_scores(evaluator, recorded, LAYERS));
    EXPECT(memcmp(recorded, scores, sizeof scores) == 0);
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &light, 1, 1, scores), KLIEG_ERROR_ARGUMENT,
           "pictures, not lights");
    klieg_pictures_destroy(pictures);
    klieg_surface_destroy(surface);
    klieg_evaluator_destroy(evaluator);
    drop_picture(layers);
    drop_floats(content);
}

/* Writes the same memory twice, with nothing between. */
static void write_twice(void) {
    floats target = make_floats(1);
    VkCommandBuffer commands = begin();
    for (uint32_t value = 0; value < 2; value++) {
        vkCmdFillBuffer(commands, target.buffer, 0, VK_WHOLE_SIZE, value);
    }
    finish(commands);
    drop_floats(target);
}

static void refuse_devices(void) {
    klieg_context *context;
    klieg_device poor = lent();
    poor.features = (klieg_features){0};
    klieg_status status = klieg_context_borrow(KLIEG_VERSION, &poor, KLIEG_NEEDS_ALL, NULL, &context);
    refuse(status, KLIEG_ERROR_UNSUPPORTED, NULL, "geometryShader", __LINE__);
    refuse(status, KLIEG_ERROR_UNSUPPORTED, NULL, "shaderOutputLayer", __LINE__);
    klieg_device half_locked = lent();
    half_locked.unlock_queue = NULL;
    REFUSE(NULL, klieg_context_borrow(KLIEG_VERSION, &half_locked, 0, NULL, &context),
           KLIEG_ERROR_ARGUMENT, "unlock_queue");
    const klieg_allocator mean = {&alive, give_nothing, take_back, NULL};
    klieg_device empty = lent();
    klieg_evaluator *evaluator;
    empty.allocator = &mean;
    CHECK(NULL, klieg_context_borrow(KLIEG_VERSION, &empty, 0, NULL, &context));
    REFUSE(context, klieg_evaluator_of_surface(context, SIDE, SIDE, NULL, NULL, &evaluator),
           KLIEG_ERROR_MEMORY, "said 5");
    klieg_context_destroy(context);
}

static int given(int count, char **arguments, const char *wanted) {
    for (int i = 1; i < count; i++) {
        if (strcmp(arguments[i], wanted) == 0) {
            return 1;
        }
    }
    return 0;
}

int main(int count, char **arguments) {
    klieg_context *context;
    klieg_counters counters;
    make_device(given(count, arguments, "validate"));
    refuse_devices();
    const klieg_device mine = lent();
    CHECK(NULL, klieg_context_borrow(KLIEG_VERSION, &mine, KLIEG_NEEDS_ALL, NULL, &context));
    picture depth = make_depth();
    klieg_evaluator *evaluator = level_1(context);
    record_rigs(evaluator);
    level_2(context, depth);
    level_3(context, depth);
    if (given(count, arguments, "hazard")) {
        write_twice();
    }
    CHECK(context, klieg_context_counters(context, &counters));
    EXPECT(locked > 10 && !held && alive > 0 && counters.memory == (uint64_t)alive);
    EXPECT(counters.pipelines > 0 && counters.allocations >= (uint64_t)alive);
    if (given(count, arguments, "forget")) {
        float score;
        klieg_light light = {0};
        CHECK(context, klieg_context_forget_device(context));
        REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &light, 1, 1, &score),
               KLIEG_ERROR_FORGOTTEN, "gone");
    }
    klieg_context_destroy(context);
    if (!given(count, arguments, "leak")) {
        klieg_evaluator_destroy(evaluator);
        EXPECT(given(count, arguments, "forget") || alive == 0);
    }
    drop_picture(depth);
    vkDestroyCommandPool(device, pool, NULL);
    if (!given(count, arguments, "leak")) {
        vkDestroyDevice(device, NULL);
        destroy_instance();
    }
    return 0;
}
