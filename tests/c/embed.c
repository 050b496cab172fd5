/* An engine in C: everything that klieg.h offers on a device of klieg's own. Prints what it finds, a name
 * and numbers a line, floats as their bits, for a comparison with the Rust interface.
 *
 * embed [leak]             all of it; with `leak`, leaves a scene behind
 * embed cycles N [leak]    makes and destroys everything but contexts N times, and tells the memory
 *                          that it takes; with `leak`, leaves the scenes behind
 * embed contexts N         the same with contexts */

#include "check.h"
#include <math.h>

static void print(const char *name, const float *values, size_t count) {
    printf("%s", name);
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        printf(" %08x", bits);
    }
    printf("\n");
}

static const klieg_light LIGHT = {.role = KLIEG_ROLE_KEY,
                                  .kind = KLIEG_LIGHT_POINT,
                                  .elevation = 0.5f,
                                  .azimuth = 0.25f,
                                  .distance = 2.0f,
                                  .diffuse = 1.5f,
                                  .specular = 0.5f};

static void print_lights(const char *name, const klieg_light *lights, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        print(name, &lights[i].elevation, 5);
    }
}

enum { WIDTH = 96, HEIGHT = 64 };

static const double EYE[3] = {3.0, 2.5, 5.0}, TARGET[3] = {0.0, 0.0, 0.0}, UP[3] = {0.0, 1.0, 0.0};
static const double HERE[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double THERE[16] = {0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 1.5, 0.5, 0, 1};

/* Two tetrahedra of a red, textured material. */
static klieg_scene *make_scene(void) {
    static const float positions[] = {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1};
    static const float uvs[] = {0, 0, 1, 0, 0, 1, 1, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    static const uint8_t texels[] = {255, 255, 255, 255, 64, 64, 64, 255,
                                     64,  64,  64,  255, 255, 255, 255, 255};
    klieg_scene *scene;
    uint32_t texture, material, mesh;
    CHECK(NULL, klieg_scene_create("two tetrahedra", &scene));
    const klieg_texture chequers = {"chequers", 2, 2, texels, VK_TRUE, {0, KLIEG_WRAP_CLAMP}};
    CHECK(scene, klieg_scene_add_texture(scene, &chequers, &texture));
    klieg_material red;
    CHECK(NULL, klieg_material_defaults(&red));
    red.name = "red";
    red.base_color[1] = red.base_color[2] = 0.25f;
    red.metallic = 0.0f;
    red.roughness = 0.5f;
    red.base_color_texture.texture = texture;
    CHECK(scene, klieg_scene_add_material(scene, &red, &material));
    klieg_mesh tetrahedron = {.vertices = 4,
                              .positions = positions,
                              .uvs = {uvs, NULL},
                              .index_count = COUNT(indices),
                              .indices = indices,
                              .material = material};
    CHECK(scene, klieg_scene_add_mesh(scene, &tetrahedron, &mesh));
    REFUSE(scene, klieg_scene_add_instance(scene, "", 7, HERE), KLIEG_ERROR_ARGUMENT, "mesh 7");
    CHECK(scene, klieg_scene_add_instance(scene, "large", mesh, HERE));
    CHECK(scene, klieg_scene_add_instance(scene, "small", mesh, THERE));
    CHECK(scene, klieg_scene_finish(scene));
    return scene;
}

static klieg_evaluator *make_evaluator_with(const klieg_context *context, const klieg_scene *scene,
                                            const klieg_objective *objective,
                                            const klieg_shading *shading) {
    klieg_camera camera;
    klieg_evaluator *evaluator;
    const klieg_lens lens = KLIEG_LENS_PERSPECTIVE;
    CHECK(NULL, klieg_camera_look_at(EYE, TARGET, UP, lens, 0.7, &camera));
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, objective,
                                            shading, NULL, &evaluator));
    return evaluator;
}

static klieg_evaluator *make_evaluator(const klieg_context *context, const klieg_scene *scene) {
    return make_evaluator_with(context, scene, NULL, NULL);
}

static void print_quality(const char *name, const klieg_quality *quality) {
    float values[1 + KLIEG_MAX_TERMS] = {quality->score};
    printf("%s of", name);
    for (uint32_t i = 0; i < quality->term_count; i++) {
        printf(" %s", quality->terms[i].name);
        values[1 + i] = quality->terms[i].value;
    }
    printf("\n");
    print(name, values, 1 + quality->term_count);
}

static void measure(klieg_evaluator *evaluator) {
    for (klieg_preset preset = 0; preset < 3; preset++) {
        klieg_light rig[KLIEG_MAX_LIGHTS];
        uint32_t lights;
        klieg_quality quality;
        float score;
        CHECK(NULL, klieg_preset_lights(preset, rig, KLIEG_MAX_LIGHTS, &lights));
        CHECK(evaluator, klieg_evaluator_evaluate(evaluator, rig, 1, lights, &score));
        CHECK(evaluator, klieg_evaluator_qualities(evaluator, rig, 1, lights, &quality));
        EXPECT(score == quality.score);
        print_quality("preset", &quality);
    }
}

/* What pictures can be judged by. */
static void list_terms(void) {
    const klieg_term_info *term;
    uint32_t count = 0;
    for (; (term = klieg_term_at(count)) != NULL; count++) {
        printf("term %s, %s: %s; %s\n", term->name, term->title, term->meaning, term->needs);
    }
    EXPECT(count > 5 && count <= KLIEG_MAX_TERMS && klieg_term_at(UINT32_MAX) == NULL);
}

/* What NULL stands for is what the functions for the defaults give, at all levels. */
static void judge_by_default(const klieg_context *context, const klieg_scene *scene) {
    klieg_camera camera;
    klieg_evaluator *by_default, *by_null, *of_pictures;
    klieg_objective objective;
    klieg_shading shading;
    klieg_shadows shadows;
    klieg_design design;
    klieg_light rig[KLIEG_MAX_LIGHTS];
    float scores[2];
    uint32_t lights;
    CHECK(NULL, klieg_objective_defaults(&objective));
    CHECK(NULL, klieg_shading_defaults(&shading));
    CHECK(NULL, klieg_shadows_defaults(&shadows));
    CHECK(NULL, klieg_design_defaults(&design));
    EXPECT(objective.weight_count == 10 && objective.mean_target == KLIEG_MEAN_TARGET_SCENE);
    EXPECT(shading.brdf == KLIEG_BRDF_GLTF_SCATTERING && shading.ambient == 0.0f && shadows.on);
    EXPECT(design.intensities == 1 && design.fill.share_of_key && design.rim.share_of_key);
    CHECK(NULL, klieg_camera_look_at(EYE, TARGET, UP, KLIEG_LENS_PERSPECTIVE, 0.7, &camera));
    CHECK(NULL, klieg_preset_lights(KLIEG_PRESET_THREE_POINT, rig, COUNT(rig), &lights));
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, &objective, &shading,
                                            &shadows, &by_default));
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, NULL, NULL, NULL,
                                            &by_null));
    CHECK(by_default, klieg_evaluator_evaluate(by_default, rig, 1, lights, &scores[0]));
    CHECK(by_null, klieg_evaluator_evaluate(by_null, rig, 1, lights, &scores[1]));
    EXPECT(scores[0] == scores[1]);
    klieg_evaluator_destroy(by_default);
    klieg_evaluator_destroy(by_null);

    CHECK(context, klieg_evaluator_of_pictures(context, 8, 8, NULL, &of_pictures));
    klieg_evaluator_destroy(of_pictures);
    CHECK(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &of_pictures));
    klieg_evaluator_destroy(of_pictures);
    CHECK(NULL, klieg_objective_set_weight(&objective, "unlit", 0.5f));
    REFUSE(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &of_pictures),
           KLIEG_ERROR_ARGUMENT, "irradiance");
}

/* Another objective than the default. */
static void judge(const klieg_context *context, const klieg_scene *scene) {
    klieg_camera camera;
    klieg_evaluator *evaluator;
    klieg_objective objective;
    klieg_quality quality;
    klieg_light rig[KLIEG_MAX_LIGHTS];
    uint32_t lights;
    CHECK(NULL, klieg_camera_look_at(EYE, TARGET, UP, KLIEG_LENS_PERSPECTIVE, 0.7, &camera));
    CHECK(NULL, klieg_objective_profile(&objective, "paper"));
    EXPECT(objective.weight_count == 5 && objective.weights[4].value == 0.2f);
    objective.weights[0].value = 0.0f;
    CHECK(NULL, klieg_objective_set_weight(&objective, "mean", 0.5f));
    CHECK(NULL, klieg_objective_set_weight(&objective, "range", 0.25f));
    EXPECT(objective.weight_count == 6 && objective.weights[1].value == 0.5f);
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, &objective, NULL, NULL,
                                            &evaluator));
    CHECK(NULL, klieg_preset_lights(KLIEG_PRESET_HEADLIGHT, rig, COUNT(rig), &lights));
    CHECK(evaluator, klieg_evaluator_qualities(evaluator, rig, 1, lights, &quality));
    print_quality("judged", &quality);
    klieg_evaluator_destroy(evaluator);

    /* A list of one's own; the name may be anywhere. */
    char name[] = "hist";
    objective.weights[0] = (klieg_term){name, 1.0f};
    objective.weight_count = 1;
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, &objective, NULL, NULL,
                                            &evaluator));
    name[0] = 'x';
    CHECK(evaluator, klieg_evaluator_qualities(evaluator, rig, 1, lights, &quality));
    EXPECT(strcmp(quality.terms[0].name, "hist") == 0);
    EXPECT(fabsf(quality.terms[0].value - quality.score) < 1e-6f);
    klieg_evaluator_destroy(evaluator);

    REFUSE(NULL, klieg_objective_set_weight(&objective, "range", 1.0f), KLIEG_ERROR_ARGUMENT,
           "no term 'xist'");
    REFUSE(context, klieg_evaluator_of_scene(context, scene, &camera, 8, 8, &objective, NULL, NULL,
                                            &evaluator),
           KLIEG_ERROR_ARGUMENT, "edge, mean");
    objective.weights[0].name = NULL;
    REFUSE(context, klieg_evaluator_of_surface(context, 8, 8, &objective, NULL, &evaluator),
           KLIEG_ERROR_ARGUMENT, "no term ''");
    objective.weight_count = KLIEG_MAX_TERMS + 1;
    REFUSE(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &evaluator),
           KLIEG_ERROR_ARGUMENT, "17 weights");
    objective.weight_count = 0;
    REFUSE(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &evaluator),
           KLIEG_ERROR_ARGUMENT, "weights");
    CHECK(NULL, klieg_objective_set_weight(&objective, "edge", -1.0f));
    REFUSE(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &evaluator),
           KLIEG_ERROR_ARGUMENT, "weight edge");
    CHECK(NULL, klieg_objective_defaults(&objective));
    CHECK(NULL, klieg_objective_set_weight(&objective, "target", 1.0f));
    REFUSE(context, klieg_evaluator_of_pictures(context, 8, 8, &objective, &evaluator),
           KLIEG_ERROR_ARGUMENT, "target picture");
    REFUSE(NULL, klieg_objective_set_weight(NULL, "edge", 1.0f), KLIEG_ERROR_ARGUMENT, "NULL");
}

/* Settings that start from a profile. */
static void judge_by_profile(const klieg_context *context, const klieg_scene *scene) {
    klieg_camera camera;
    klieg_evaluator *evaluator;
    klieg_objective objective;
    klieg_shading shading;
    klieg_shadows shadows;
    klieg_design design;
    klieg_designer *designer;
    klieg_quality quality;
    klieg_light rig[KLIEG_MAX_LIGHTS];
    const klieg_profile_info *profile;
    const klieg_role roles[] = {KLIEG_ROLE_KEY, KLIEG_ROLE_FILL};
    uint32_t lights, count = 0;
    for (; (profile = klieg_profile_at(count)) != NULL; count++) {
        printf("profile %s: %s\n", profile->name, profile->meaning);
    }
    CHECK(NULL, klieg_objective_profile(&objective, "natural"));
    CHECK(NULL, klieg_shading_profile(&shading, "natural"));
    CHECK(NULL, klieg_shadows_profile(&shadows, "paper"));
    EXPECT(!shadows.on && shadows.side == 31 && shadows.memory == 1024);
    CHECK(NULL, klieg_shadows_profile(&shadows, "natural"));
    EXPECT(shadows.on && shadows.side == 31);
    EXPECT(objective.mean_target == KLIEG_MEAN_TARGET_SCENE && shading.brdf == KLIEG_BRDF_GLTF_SCATTERING);
    EXPECT(objective.background == KLIEG_NO_BACKGROUND);
    objective.background = 0.5f;
    shadows.side = 15;
    CHECK(NULL, klieg_camera_look_at(EYE, TARGET, UP, KLIEG_LENS_PERSPECTIVE, 0.7, &camera));
    CHECK(context, klieg_evaluator_of_scene(context, scene, &camera, WIDTH, HEIGHT, &objective, &shading,
                                            &shadows, &evaluator));
    CHECK(NULL, klieg_preset_lights(KLIEG_PRESET_THREE_POINT, rig, COUNT(rig), &lights));
    CHECK(evaluator, klieg_evaluator_qualities(evaluator, rig, 1, lights, &quality));
    print_quality("natural", &quality);

    klieg_intent intent;
    CHECK(NULL, klieg_design_profile(&design, "natural"));
    CHECK(NULL, klieg_intent_defaults(&intent));
    CHECK(NULL, klieg_intent_steer(&intent, &objective, &design));
    EXPECT(objective.mean_stops == 0.0f && objective.spread_target == 0.2f && design.fill.diffuse[1] == 0.6f);
    intent.brightness = 1.0f;
    intent.contrast = -1.0f;
    intent.mood = KLIEG_MOOD_SOFT;
    CHECK(NULL, klieg_intent_steer(&intent, &objective, &design));
    EXPECT(objective.mean_stops > 0.0f && objective.spread_target < 0.2f && design.fill.diffuse[1] > 0.6f);
    intent.mood = 3;
    REFUSE(NULL, klieg_intent_steer(&intent, &objective, &design), KLIEG_ERROR_ARGUMENT, "mood 3");
    intent.mood = KLIEG_MOOD_NATURAL;
    intent.brightness = 3.0f;
    REFUSE(NULL, klieg_intent_steer(&intent, &objective, &design), KLIEG_ERROR_ARGUMENT, "brightness is 3");
    REFUSE(NULL, klieg_intent_steer(&intent, NULL, &design), KLIEG_ERROR_ARGUMENT, "objective is NULL");
    design.up[1] = 2.0f;
    design.roles = roles;
    design.lights = COUNT(roles);
    REFUSE(NULL, klieg_designer_create(&design, &designer), KLIEG_ERROR_ARGUMENT, "no direction upwards");

    CHECK(NULL, klieg_design_profile(&design, "natural"));
    EXPECT(design.intensities == 1 && design.fill.azimuth_from_key && !design.key.share_of_key);
    design.roles = roles;
    design.lights = COUNT(roles);
    CHECK(NULL, klieg_designer_create(&design, &designer));
    CHECK(designer, klieg_designer_advance(designer, evaluator, 2, NULL));
    CHECK(designer, klieg_designer_best(designer, rig, COUNT(rig), NULL));
    print_lights("natural", rig, COUNT(roles));
    klieg_designer_destroy(designer);
    klieg_evaluator_destroy(evaluator);

    REFUSE(NULL, klieg_objective_profile(&objective, "film"), KLIEG_ERROR_ARGUMENT, "paper, natural");
    REFUSE(NULL, klieg_shading_profile(&shading, NULL), KLIEG_ERROR_ARGUMENT, "no profile ''");
    REFUSE(NULL, klieg_design_profile(NULL, "paper"), KLIEG_ERROR_ARGUMENT, "NULL");
    design.fill.share_of_key = 2;
    REFUSE(NULL, klieg_designer_create(&design, &designer), KLIEG_ERROR_ARGUMENT, "share_of_key is 2");
    shading.brdf = 3;
    REFUSE(context, klieg_evaluator_of_scene(context, scene, &camera, 8, 8, NULL, &shading, NULL, &evaluator),
           KLIEG_ERROR_ARGUMENT, "brdf 3");
    objective.background = 2.0f;
    REFUSE(context, klieg_evaluator_of_surface(context, 8, 8, &objective, NULL, &evaluator),
           KLIEG_ERROR_ARGUMENT, "objective.background");
    shadows.side = 16;
    REFUSE(context, klieg_evaluator_of_scene(context, scene, &camera, 8, 8, NULL, NULL, &shadows, &evaluator),
           KLIEG_ERROR_ARGUMENT, "shadows.side is 16");
    shadows.on = 2;
    REFUSE(context, klieg_evaluator_of_scene(context, scene, &camera, 8, 8, NULL, NULL, &shadows, &evaluator),
           KLIEG_ERROR_ARGUMENT, "shadows.on is 2");
    REFUSE(NULL, klieg_shadows_profile(&shadows, "film"), KLIEG_ERROR_ARGUMENT, "paper, natural");
}

static void place(klieg_evaluator *evaluator) {
    klieg_frame frame;
    klieg_light light = LIGHT;
    klieg_world_light world;
    CHECK(evaluator, klieg_evaluator_frame(evaluator, &frame));
    CHECK(NULL, klieg_lights_in_world(&frame, &light, 1, &world));
    const float numbers[] = {(float)world.position[0], (float)world.position[1],
                             (float)world.position[2], (float)world.direction[0],
                             (float)world.intensity,   (float)world.distance};
    print("world", numbers, COUNT(numbers));

    klieg_light spot = light;
    spot.kind = KLIEG_LIGHT_SPOT;
    spot.color[0] = 1.0f, spot.color[1] = 0.5f, spot.color[2] = 0.25f;
    spot.size = 0.125f;
    spot.cone_inner = 0.25f, spot.cone_outer = 0.5f;
    spot.aim[1] = -0.6f, spot.aim[2] = -0.8f;
    CHECK(NULL, klieg_lights_in_world(&frame, &spot, 1, &world));
    const float of_spot[] = {(float)world.axis[0], (float)world.axis[1], (float)world.axis[2],
                             world.color[0],       world.color[1],       world.color[2],
                             world.cone_inner,     world.cone_outer,     (float)world.size};
    print("spot", of_spot, COUNT(of_spot));
    const klieg_light both[] = {light, spot};
    float scores[COUNT(both)];
    CHECK(evaluator, klieg_evaluator_evaluate(evaluator, both, COUNT(both), 1, scores));
    print("scores", scores, COUNT(scores));
}

static void search(klieg_evaluator *evaluator) {
    const klieg_role roles[] = {KLIEG_ROLE_KEY, KLIEG_ROLE_RIM};
    klieg_design design;
    klieg_designer *designer, *other;
    klieg_progress progress, told;
    klieg_light first[COUNT(roles)], best[COUNT(roles)], all[12 * COUNT(roles)];
    float score, scores[12];
    uint32_t rigs;
    CHECK(NULL, klieg_design_defaults(&design));
    design.roles = roles;
    design.lights = COUNT(roles);
    design.population = COUNT(scores);
    design.seed = 7;
    CHECK(evaluator, klieg_evaluator_suggest(evaluator, &design, first));
    print_lights("first", first, design.lights);
    design.first = first;
    CHECK(NULL, klieg_designer_create(&design, &designer));
    CHECK(NULL, klieg_designer_create(&design, &other));
    EXPECT(klieg_designer_best(designer, NULL, 0, &score) == KLIEG_NOTHING_YET);
    CHECK(designer, klieg_designer_advance(designer, evaluator, 4, &progress));
    EXPECT(progress.generation == 4);

    /* The same by asking and telling. */
    for (int generation = 0; generation < 4; generation++) {
        CHECK(other, klieg_designer_ask(other, all, COUNT(all), &rigs));
        CHECK(evaluator, klieg_evaluator_evaluate(evaluator, all, rigs, design.lights, scores));
        REFUSE(other, klieg_designer_tell(other, scores, rigs - 1, NULL), KLIEG_ERROR_ARGUMENT,
               "scores");
        CHECK(other, klieg_designer_tell(other, scores, rigs, &told));
    }
    EXPECT(progress.generation == told.generation && progress.evaluations == told.evaluations);
    EXPECT(memcmp(&progress.best, &told.best, 3 * sizeof told.best) == 0);
    print("progress", &progress.best, 3);

    CHECK(designer, klieg_designer_best(designer, best, design.lights, &score));
    print("best", &score, 1);
    print_lights("best", best, design.lights);
    CHECK(designer, klieg_designer_advance_for(designer, evaluator, 0.0, &progress));
    EXPECT(progress.generation == 5);

    klieg_frame frame, turned;
    CHECK(evaluator, klieg_evaluator_frame(evaluator, &frame));
    turned = frame;
    for (int i = 0; i < 3; i++) {
        turned.right[i] = frame.back[i];
        turned.back[i] = -frame.right[i];
    }
    CHECK(designer, klieg_designer_follow(designer, &frame, &turned));
    CHECK(designer, klieg_designer_renew(designer));
    CHECK(designer, klieg_designer_ask(designer, NULL, 0, &rigs));
    EXPECT(rigs == COUNT(scores));
    klieg_designer_destroy(designer);
    klieg_designer_destroy(other);

    /* Any other optimizer, by its name. */
    const char *const names[] = {"ga", "shade", "cma-es", "greedy", "restarts", "random"};
    for (size_t i = 0; i < COUNT(names); i++) {
        design.optimizer = names[i];
        CHECK(NULL, klieg_designer_create(&design, &other));
        CHECK(other, klieg_designer_advance(other, evaluator, 3, &told));
        EXPECT(told.generation == 3);
        CHECK(other, klieg_designer_follow(other, &frame, &turned));
        CHECK(other, klieg_designer_advance(other, evaluator, 1, NULL));
        CHECK(other, klieg_designer_best(other, best, design.lights, &score));
        klieg_designer_destroy(other);
    }
    design.greedy_starts = 0;
    REFUSE(NULL, klieg_designer_create(&design, &other), KLIEG_ERROR_ARGUMENT, "greedy.starts");
    design.optimizer = "annealing";
    REFUSE(NULL, klieg_designer_create(&design, &other), KLIEG_ERROR_ARGUMENT, "restarts");
}

/* What is wrong is told, and nothing breaks. */
static void provoke(klieg_context *context, klieg_evaluator *evaluator) {
    klieg_light light = LIGHT;
    klieg_context *none = context;
    klieg_scene *scene;
    klieg_evaluator *of_surface;
    klieg_frame frame;
    klieg_camera camera;
    float score;
    uint32_t count;
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION + 1000, NULL, NULL, &none),
           KLIEG_ERROR_VERSION, "built for");
    EXPECT(none == NULL);
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION, "no such device", NULL, &none),
           KLIEG_ERROR_ARGUMENT, "no such device");
    klieg_tuning tuning;
    CHECK(NULL, klieg_tuning_defaults(&tuning));
    tuning.pipeline = 9;
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION, NULL, &tuning, &none), KLIEG_ERROR_ARGUMENT,
           "pipeline 9");
    REFUSE(NULL, klieg_context_borrow(KLIEG_VERSION, NULL, 0, NULL, &none), KLIEG_ERROR_ARGUMENT,
           "device is NULL");
    const klieg_device nothing = {0};
    REFUSE(NULL, klieg_context_borrow(KLIEG_VERSION, &nothing, 0, NULL, &none),
           KLIEG_ERROR_ARGUMENT, "get_instance_proc_addr");
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, NULL), KLIEG_ERROR_ARGUMENT,
           "NULL");

    REFUSE(NULL, klieg_scene_load("no such file.glb", &scene), KLIEG_ERROR_INPUT, "no such file");
    REFUSE(NULL, klieg_scene_load("\xff", &scene), KLIEG_ERROR_ARGUMENT, "UTF-8");
    REFUSE(NULL, klieg_scene_load_with("no such file.glb", KLIEG_FILES_ANYWHERE, &scene),
           KLIEG_ERROR_INPUT, "no such file");
    REFUSE(NULL, klieg_scene_load_with("no such file.glb", 9, &scene), KLIEG_ERROR_ARGUMENT,
           "access 9");
    CHECK(NULL, klieg_scene_create(NULL, &scene));
    EXPECT(strcmp(klieg_error(scene), "") == 0);
    REFUSE(scene, klieg_scene_finish(scene), KLIEG_ERROR_ARGUMENT, "nothing");
    REFUSE(scene, klieg_scene_add_mesh(scene, NULL, &count), KLIEG_ERROR_ARGUMENT, "mesh is NULL");
    klieg_mesh huge = {.vertices = SIZE_MAX / 2, .positions = &light.elevation};
    REFUSE(scene, klieg_scene_add_mesh(scene, &huge, &count), KLIEG_ERROR_ARGUMENT, "positions");
    CHECK(NULL, klieg_camera_look_at(EYE, TARGET, UP, KLIEG_LENS_PERSPECTIVE, 0.7, &camera));
    REFUSE(context, klieg_evaluator_of_scene(context, scene, &camera, 8, 8, NULL, NULL, NULL, &of_surface),
           KLIEG_ERROR_ARGUMENT, "not finished");
    klieg_scene_destroy(scene);
    REFUSE(NULL, klieg_camera_look_at(EYE, EYE, UP, KLIEG_LENS_PERSPECTIVE, 0.7, &camera),
           KLIEG_ERROR_ARGUMENT, "one");

    REFUSE(NULL, klieg_evaluator_evaluate(NULL, &light, 1, 1, &score), KLIEG_ERROR_ARGUMENT, "NULL");
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, NULL, 1, 1, &score),
           KLIEG_ERROR_ARGUMENT, "lights is NULL");
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &light, 1, 0, &score),
           KLIEG_ERROR_ARGUMENT, "0 lights");
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &light, 1, 1, NULL),
           KLIEG_ERROR_ARGUMENT, "scores is NULL");
    klieg_light wrong = light;
    wrong.color[1] = -1.0f;
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &wrong, 1, 1, &score),
           KLIEG_ERROR_ARGUMENT, "colour");
    wrong = light;
    wrong.cone_inner = wrong.cone_outer = 0.5f;
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &wrong, 1, 1, &score),
           KLIEG_ERROR_ARGUMENT, "cone");
    wrong = light;
    wrong.aim[2] = INFINITY;
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &wrong, 1, 1, &score),
           KLIEG_ERROR_ARGUMENT, "direction");
    light.role = -1;
    REFUSE(evaluator, klieg_evaluator_evaluate(evaluator, &light, 1, 1, &score),
           KLIEG_ERROR_ARGUMENT, "role -1");
    REFUSE(evaluator, klieg_evaluator_look(evaluator, NULL, NULL), KLIEG_ERROR_ARGUMENT, "surface");
    CHECK(context, klieg_evaluator_of_surface(context, 8, 8, NULL, NULL, &of_surface));
    REFUSE(of_surface, klieg_evaluator_frame(of_surface, &frame), KLIEG_NOTHING_YET, "nothing");
    REFUSE(of_surface, klieg_evaluator_evaluate_pictures(of_surface, NULL, 1, &score),
           KLIEG_ERROR_ARGUMENT, "pictures is NULL");
    klieg_evaluator_destroy(of_surface);
    REFUSE(NULL, klieg_preset_lights(3, &light, 1, &count), KLIEG_ERROR_ARGUMENT, "preset 3");
    REFUSE(NULL, klieg_preset_lights(1, &light, 1, &count), KLIEG_ERROR_ARGUMENT, "room for 1");
    klieg_context_destroy(NULL);
}

/* Kilobytes that the process has in memory. */
static long resident(void) {
    long size = 0, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    EXPECT(file != NULL && fscanf(file, "%ld %ld", &size, &pages) == 2);
    fclose(file);
    return pages * 4;
}

static void cycle_once(const klieg_context *context, int leak) {
    klieg_scene *scene = make_scene();
    klieg_objective objective;
    klieg_shading shading;
    /* With shadows, but the paper's terms: Mesa's lavapipe maps more and more memory for its shaders
     * under those of "natural", until the device goes. */
    CHECK(NULL, klieg_objective_profile(&objective, "paper"));
    CHECK(NULL, klieg_shading_profile(&shading, "paper"));
    klieg_evaluator *evaluator = make_evaluator_with(context, scene, &objective, &shading);
    klieg_light rig[KLIEG_MAX_LIGHTS];
    uint32_t lights;
    float score;
    CHECK(NULL, klieg_preset_lights(KLIEG_PRESET_THREE_POINT, rig, COUNT(rig), &lights));
    CHECK(evaluator, klieg_evaluator_evaluate(evaluator, rig, 1, lights, &score));
    if (!leak) {
        klieg_scene_destroy(scene);
    }
    klieg_evaluator_destroy(evaluator);
    klieg_design design;
    klieg_designer *designer;
    const klieg_role role = KLIEG_ROLE_KEY;
    CHECK(NULL, klieg_design_defaults(&design));
    design.roles = &role;
    design.lights = 1;
    CHECK(NULL, klieg_designer_create(&design, &designer));
    klieg_designer_destroy(designer);
}

/* What has been compiled goes into another context. */
static void keep_pipelines(const klieg_context *context) {
    klieg_tuning tuning;
    klieg_context *next;
    klieg_counters counters;
    size_t size = 0, again = 0;
    CHECK(NULL, klieg_context_pipeline_cache(context, NULL, 0, &size));
    char *data = malloc(size);
    EXPECT(size > 32 && data != NULL);
    REFUSE(NULL, klieg_context_pipeline_cache(context, data, 7, &again), KLIEG_ERROR_ARGUMENT,
           "room for 7");
    EXPECT(again == size);
    CHECK(NULL, klieg_context_pipeline_cache(context, data, size, &again));
    CHECK(NULL, klieg_tuning_defaults(&tuning));
    tuning.pipeline_cache = data;
    tuning.pipeline_cache_size = size;
    for (int damaged = 0; damaged < 2; damaged++) {
        data[size - 1] = (char)(data[size - 1] + damaged);
        CHECK(NULL, klieg_context_create(KLIEG_VERSION, NULL, &tuning, &next));
        CHECK(next, klieg_context_counters(next, &counters));
        EXPECT((counters.pipeline_cache > 0) == !damaged);
        klieg_context_destroy(next);
    }
    tuning.pipeline_cache = NULL;
    REFUSE(NULL, klieg_context_create(KLIEG_VERSION, NULL, &tuning, &next), KLIEG_ERROR_ARGUMENT,
           "pipeline_cache is NULL");
    free(data);
}

/* Everything but contexts. */
static void cycles(int count, int leak) {
    klieg_context *context;
    klieg_counters before, after;
    long resident_before = 0;
    CHECK(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, &context));
    for (int i = 0; i < count; i++) {
        if (i == count / 5) {
            resident_before = resident();
            CHECK(context, klieg_context_counters(context, &before));
        }
        cycle_once(context, leak);
    }
    CHECK(context, klieg_context_counters(context, &after));
    printf("resident %ld %ld\n", resident_before, resident());
    printf("memory %llu %llu\n", (unsigned long long)before.memory,
           (unsigned long long)after.memory);
    printf("pipelines %llu %llu\n", (unsigned long long)before.pipelines,
           (unsigned long long)after.pipelines);
    klieg_context_destroy(context);
}

static void contexts(int count) {
    long resident_before = 0;
    for (int i = 0; i < count; i++) {
        klieg_context *context;
        if (i == count / 5) {
            resident_before = resident();
        }
        CHECK(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, &context));
        klieg_context_destroy(context);
    }
    printf("resident %ld %ld\n", resident_before, resident());
}

/* Keeps the driver loaded, so that a leak's report can name it. */
static klieg_context *kept;

int main(int count, char **arguments) {
    if (count >= 3 && strcmp(arguments[1], "cycles") == 0) {
        cycles(atoi(arguments[2]), count > 3);
        return 0;
    }
    if (count == 3 && strcmp(arguments[1], "contexts") == 0) {
        contexts(atoi(arguments[2]));
        return 0;
    }
    klieg_context *context;
    EXPECT(klieg_version() == KLIEG_VERSION);
    CHECK(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, &kept));
    CHECK(NULL, klieg_context_create(KLIEG_VERSION, NULL, NULL, &context));
    EXPECT(strlen(klieg_context_device_name(context)) > 0);
    klieg_requirements requirements;
    CHECK(NULL, klieg_requirements_for(KLIEG_NEEDS_ALL, &requirements));
    EXPECT(requirements.features.geometry_shader && requirements.limit_count > 0);
    EXPECT(strncmp(requirements.limits[0].name, "max", 3) == 0);

    keep_pipelines(context);

    klieg_scene *scene = make_scene();
    double center[3], radius;
    uint32_t triangles;
    CHECK(scene, klieg_scene_bounds(scene, center, &radius, &triangles));
    EXPECT(triangles == 8 && radius > 1.0 && center[0] > 0.0);
    EXPECT(strcmp(klieg_scene_warnings(scene), "") == 0);
    klieg_evaluator *evaluator = make_evaluator(context, scene);
    list_terms();
    judge_by_default(context, scene);
    judge(context, scene);
    judge_by_profile(context, scene);
    if (count == 1) {
        klieg_scene_destroy(scene);
    }
    measure(evaluator);
    place(evaluator);
    search(evaluator);
    provoke(context, evaluator);
    /* The context may go first. */
    klieg_context_destroy(context);
    measure(evaluator);
    klieg_evaluator_destroy(evaluator);
    return 0;
}
