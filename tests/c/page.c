/* The C of docs/EMBEDDING.md, as an engine runs it: each part of the page stands here as it stands there. */

#include "engine.h"
#include <math.h>

static const uint32_t family = 0;

static void submit_and_wait(VkCommandBuffer commands) { finish(commands); }

/* What the thread's last call that failed on purpose has said. */
static char before[256];

static void none_failed(const void *handle) {
    EXPECT(strcmp(klieg_error(handle), handle ? "" : before) == 0);
}

static klieg_context *borrow(void) {
    klieg_context *context;
    const klieg_features enabled = features;
    klieg_device lent = {
        .get_instance_proc_addr = vkGetInstanceProcAddr,
        .instance = instance,
        .api_version = VK_API_VERSION_1_2,
        .physical_device = physical,
        .device = device,
        .queue = queue,
        .queue_family = family,
        .features = enabled, /* klieg_enabled_features; all 0 is enough for levels 2 and 3 */
    };
    if (klieg_context_borrow(KLIEG_VERSION, &lent, KLIEG_NEEDS_SCENE, NULL, &context) != KLIEG_OK) {
        fprintf(stderr, "%s\n", klieg_error(NULL));
    }
    return context;
}

static klieg_designer *make_designer(void) {
    klieg_design design;
    klieg_designer *designer;
    klieg_design_defaults(&design);
    design.roles = (const klieg_role[]){KLIEG_ROLE_KEY, KLIEG_ROLE_RIM};
    design.lights = 2;
    klieg_designer_create(&design, &designer);
    return designer;
}

static klieg_surface_images images_of(picture depth) {
    return (klieg_surface_images){.depth = {depth.view, VK_IMAGE_LAYOUT_GENERAL}};
}

static void level_2(klieg_context *context, picture depth, VkBuffer buffer, const float *scores) {
    const uint32_t width = SIDE, height = SIDE;
    const klieg_surface_images images = images_of(depth);
    const klieg_engine_camera camera = CAMERA;
    klieg_designer *designer = make_designer();
    klieg_surface_format format;
    klieg_surface_format_defaults(&format);
    VkCommandBuffer cmd = begin();

    enum { ROOM = 64 };
    klieg_light lights[ROOM];
    klieg_evaluator *evaluator;
    klieg_surface *surface;
    uint32_t rigs;
    float score;
    /* Once. */
    klieg_evaluator_of_surface(context, width, height, NULL, NULL, &evaluator);
    klieg_evaluator_reserve(evaluator, 30, 2);
    klieg_surface_create(evaluator, &images, &format, &surface); /* for each set of images */

    /* In each frame, after the G-buffer pass. */
    klieg_evaluator_record_view(evaluator, cmd, surface, &camera);
    klieg_designer_ask(designer, lights, ROOM, &rigs);
    klieg_evaluator_record(evaluator, cmd, lights, rigs, 2, buffer, 0);
    submit_and_wait(cmd); /* the engine's own, frames later by its fence */
    klieg_designer_tell(designer, scores, rigs, NULL);
    klieg_designer_best(designer, lights, ROOM, &score);

    none_failed(evaluator), none_failed(designer), none_failed(NULL);
    EXPECT(rigs == 20 && score > 0.0f && score < 1.0f);
    klieg_surface_destroy(surface);
    klieg_evaluator_destroy(evaluator);
    klieg_designer_destroy(designer);
}

static klieg_evaluator *level_1(klieg_context *context, klieg_scene **made) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 1, -1, -1, 2, -1, 0, 1, 1, 0};
    static const double world[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double eye[3] = {0, 0, 5}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    klieg_designer *designer = make_designer();

    klieg_scene *scene;
    klieg_camera camera;
    klieg_evaluator *evaluator;
    uint32_t mesh;
    const klieg_mesh triangles = {
        .vertices = 6,
        .positions = positions,
        .material = KLIEG_DEFAULT_MATERIAL, /* or what klieg_scene_add_material gives */
    };
    klieg_scene_create("statue", &scene);
    klieg_scene_add_mesh(scene, &triangles, &mesh);
    klieg_scene_add_instance(scene, "statue", mesh, world);
    klieg_scene_finish(scene);
    klieg_camera_look_at(eye, target, up, KLIEG_LENS_PERSPECTIVE, 0.7, &camera);
    klieg_evaluator_of_scene(context, scene, &camera, 512, 512, NULL, NULL, NULL, &evaluator);
    klieg_designer_advance_for(designer, evaluator, 0.004, NULL); /* each frame */

    none_failed(scene), none_failed(evaluator), none_failed(designer), none_failed(NULL);
    float score;
    EXPECT(klieg_designer_best(designer, NULL, 0, &score) == KLIEG_OK && isfinite(score));
    klieg_designer_destroy(designer);
    *made = scene;
    return evaluator;
}

static void level_3(klieg_context *context, picture depth, VkBuffer buffer, const float *scores) {
    const uint32_t width = SIDE, height = SIDE, rigs = 2;
    const klieg_surface_images images = images_of(depth);
    const klieg_engine_camera camera = CAMERA;
    klieg_surface_format format;
    klieg_surface_format_defaults(&format);
    floats content = make_floats(2 * PIXELS);
    for (int i = 0; i < 2 * PIXELS; i++) {
        content.mapped[i] = i < PIXELS ? (float)(i % SIDE) / SIDE : 0.1f;
    }
    picture layers = make_picture(2, content.buffer);
    const klieg_image array = {layers.view, VK_IMAGE_LAYOUT_GENERAL};
    VkCommandBuffer cmd = begin();

    klieg_evaluator *evaluator;
    klieg_surface *surface;
    klieg_pictures *pictures;
    /* Once. */
    klieg_evaluator_of_pictures(context, width, height, NULL, &evaluator);
    klieg_evaluator_reserve(evaluator, rigs, 0);
    klieg_surface_create(evaluator, &images, &format, &surface);
    klieg_pictures_create(evaluator, array, rigs, KLIEG_ENCODING_SRGB, KLIEG_CHANNELS_RGB, &pictures);

    /* In each frame, when the engine has rendered a layer for each rig of klieg_designer_ask. */
    klieg_evaluator_record_view(evaluator, cmd, surface, &camera);
    klieg_evaluator_record_pictures(evaluator, cmd, pictures, 0, rigs, buffer, 0);

    finish(cmd);
    none_failed(evaluator), none_failed(NULL);
    EXPECT(scores[0] > 0.0f && scores[0] < scores[1]);
    klieg_pictures_destroy(pictures);
    klieg_surface_destroy(surface);
    klieg_evaluator_destroy(evaluator);
    drop_picture(layers);
    drop_floats(content);
}

static void judge(klieg_context *context, klieg_scene *scene) {
    const klieg_light lights[2] = {{.distance = 2.0f, .diffuse = 1.0f}, {.distance = 2.0f}};
    klieg_camera camera;
    klieg_evaluator *evaluator, *unshadowed;
    klieg_quality quality;
    klieg_camera_frame(scene, NULL, 1.0, &camera);

    klieg_objective objective;
    klieg_objective_defaults(&objective);
    klieg_objective_set_weight(&objective, "burnt", 0.2f);
    klieg_evaluator_of_scene(context, scene, &camera, 512, 512, &objective, NULL, NULL, &evaluator);
    klieg_evaluator_qualities(evaluator, lights, 1, 2, &quality);
    for (uint32_t i = 0; i < quality.term_count; i++) {
        printf("%s %.3f\n", quality.terms[i].name, quality.terms[i].value);
    }

    klieg_shadows shadows;
    klieg_shadows_defaults(&shadows);
    shadows.on = 0; /* or fewer directions: shadows.side */
    klieg_evaluator_of_scene(context, scene, &camera, 512, 512, NULL, NULL, &shadows, &unshadowed);

    none_failed(evaluator), none_failed(unshadowed), none_failed(NULL);
    EXPECT(quality.term_count == 9);
    klieg_evaluator_destroy(evaluator);
    klieg_evaluator_destroy(unshadowed);
}

int main(void) {
    klieg_scene *scene;
    make_device(0);
    klieg_context *context = borrow();
    picture depth = make_depth();
    floats target = make_floats(64);
    snprintf(before, sizeof before, "%s", klieg_error(NULL));
    level_2(context, depth, target.buffer, target.mapped);
    klieg_evaluator *evaluator = level_1(context, &scene);
    level_3(context, depth, target.buffer, target.mapped);
    judge(context, scene);
    klieg_evaluator_destroy(evaluator);
    klieg_scene_destroy(scene);
    klieg_context_destroy(context);
    drop_picture(depth);
    drop_floats(target);
    vkDestroyCommandPool(device, pool, NULL);
    vkDestroyDevice(device, NULL);
    destroy_instance();
    return 0;
}
