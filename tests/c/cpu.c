/* cpu SCENE FOLDER: klieg without any Vulkan device. Designs lights for a scene on the CPU, prints them as floats'
 * bits, and makes the lit scene in memory and as FOLDER/lit.glb, which must be the same. */

#include "check.h"
#include <math.h>

enum { LIGHTS = 2, WIDTH = 96, HEIGHT = 64 };

static void print(const char *name, const float *values, size_t count) {
    printf("%s", name);
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        printf(" %08x", bits);
    }
    printf("\n");
}

/* What a CPU evaluator cannot do, it says. */
static void refuse_devices(klieg_scene *scene, const klieg_camera *camera,
                           klieg_evaluator *evaluator) {
    klieg_context *context;
    klieg_evaluator *other;
    klieg_surface *surface;
    const klieg_light light = {.distance = 2.0f};
    const klieg_surface_images images = {0};
    klieg_surface_format format;
    float score;
    CHECK(NULL, klieg_surface_format_defaults(&format));
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, &context), KLIEG_ERROR_NO_VULKAN, "");
    REFUSE(NULL,
           klieg_evaluator_on_cpu(KLIEG_VERSION + 1000000, scene, camera, WIDTH, HEIGHT, NULL, NULL,
                                  NULL, &other),
           KLIEG_ERROR_VERSION, "");
    REFUSE(NULL,
           klieg_evaluator_on_cpu(KLIEG_VERSION, scene, camera, 0, HEIGHT, NULL, NULL, NULL, &other),
           KLIEG_ERROR_ARGUMENT, "");
    REFUSE(evaluator, klieg_evaluator_reserve(evaluator, 1, 1), KLIEG_ERROR_ARGUMENT, "CPU");
    REFUSE(evaluator, klieg_evaluator_record(evaluator, VK_NULL_HANDLE, &light, 1, 1, VK_NULL_HANDLE, 0),
           KLIEG_ERROR_ARGUMENT, "klieg_evaluator_evaluate");
    REFUSE(evaluator, klieg_evaluator_read_scores(evaluator, &score, 1), KLIEG_ERROR_ARGUMENT, "CPU");
    REFUSE(NULL, klieg_surface_create(evaluator, &images, &format, &surface), KLIEG_ERROR_ARGUMENT, "");
}

static void design_lights(klieg_evaluator *evaluator, klieg_light *lights) {
    const klieg_role roles[LIGHTS] = {KLIEG_ROLE_KEY, KLIEG_ROLE_FILL};
    klieg_design design;
    klieg_designer *designer;
    klieg_progress progress;
    klieg_quality quality;
    float score;
    CHECK(NULL, klieg_design_defaults(&design));
    design.roles = roles;
    design.lights = LIGHTS;
    design.seed = 7;
    CHECK(evaluator, klieg_evaluator_suggest(evaluator, &design, lights));
    design.first = lights;
    CHECK(NULL, klieg_designer_create(&design, &designer));
    CHECK(designer, klieg_designer_advance(designer, evaluator, 3, NULL));
    CHECK(designer, klieg_designer_advance_for(designer, evaluator, 0.0, &progress));
    CHECK(designer, klieg_designer_best(designer, lights, LIGHTS, &score));
    EXPECT(progress.generation == 4 && progress.best == score);
    CHECK(evaluator, klieg_evaluator_qualities(evaluator, lights, 1, LIGHTS, &quality));
    EXPECT(quality.score == score);
    print("score", &score, 1);
    for (int i = 0; i < LIGHTS; i++) {
        print("light", &lights[i].elevation, 5);
    }
    klieg_designer_destroy(designer);
}

/* The file has the bytes that memory has. */
static void compare(const char *path, const void *data, size_t size) {
    FILE *file = fopen(path, "rb");
    EXPECT(file != NULL);
    char *found = malloc(size + 1);
    EXPECT(fread(found, 1, size + 1, file) == size && memcmp(found, data, size) == 0);
    free(found);
    fclose(file);
}

static void write_lit(const klieg_scene *scene, const klieg_camera *camera, const klieg_light *lights,
                      const char *folder) {
    char path[4096];
    klieg_lit *lit;
    const void *data;
    size_t size;
    const klieg_light broken = {.distance = NAN};
    CHECK(NULL, klieg_lit_create(scene, camera, WIDTH, HEIGHT, lights, LIGHTS, &lit));
    CHECK(NULL, klieg_lit_data(lit, &data, &size));
    EXPECT(size > 20 && memcmp(data, "glTF", 4) == 0);
    snprintf(path, sizeof path, "%s/lit.glb", folder);
    CHECK(NULL, klieg_lit_write(lit, path));
    compare(path, data, size);
    snprintf(path, sizeof path, "%s/absent/lit.glb", folder);
    REFUSE(NULL, klieg_lit_write(lit, path), KLIEG_ERROR_OUTPUT, "absent");
    REFUSE(NULL, klieg_lit_write(lit, NULL), KLIEG_ERROR_ARGUMENT, "path");
    klieg_lit_destroy(lit);
    REFUSE(NULL, klieg_lit_create(scene, camera, WIDTH, HEIGHT, &broken, 1, &lit), KLIEG_ERROR_ARGUMENT,
           "");
    REFUSE(NULL, klieg_lit_create(scene, camera, WIDTH, HEIGHT, lights, 0, &lit), KLIEG_ERROR_ARGUMENT,
           "");
}

/* A scene of arrays has no file that could be lit. */
static void refuse_arrays(const klieg_camera *camera, const klieg_light *lights) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
    static const double here[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const klieg_mesh triangle = {
        .vertices = 3, .positions = positions, .material = KLIEG_DEFAULT_MATERIAL};
    klieg_scene *scene;
    klieg_lit *lit;
    uint32_t mesh;
    CHECK(NULL, klieg_scene_create("triangle", &scene));
    CHECK(scene, klieg_scene_add_mesh(scene, &triangle, &mesh));
    CHECK(scene, klieg_scene_add_instance(scene, NULL, mesh, here));
    CHECK(scene, klieg_scene_finish(scene));
    REFUSE(NULL, klieg_lit_create(scene, camera, WIDTH, HEIGHT, lights, LIGHTS, &lit),
           KLIEG_ERROR_ARGUMENT, "not loaded from a file");
    klieg_scene_destroy(scene);
}

int main(int count, char **arguments) {
    klieg_scene *scene;
    klieg_camera camera;
    klieg_evaluator *evaluator;
    klieg_light lights[LIGHTS];
    EXPECT(count == 3);
    CHECK(NULL, klieg_scene_load(arguments[1], &scene));
    CHECK(NULL, klieg_camera_frame(scene, NULL, (double)WIDTH / HEIGHT, &camera));
    CHECK(NULL, klieg_evaluator_on_cpu(KLIEG_VERSION, scene, &camera, WIDTH, HEIGHT, NULL, NULL, NULL,
                                       &evaluator));
    refuse_devices(scene, &camera, evaluator);
    design_lights(evaluator, lights);
    write_lit(scene, &camera, lights, arguments[2]);
    refuse_arrays(&camera, lights);
    klieg_evaluator_destroy(evaluator);
    klieg_scene_destroy(scene);
    return 0;
}
