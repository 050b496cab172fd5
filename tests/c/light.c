/* light SCENE LIT.glb: finds two lights for a scene, tells where they stand, and writes the lit scene. */

#include <klieg.h>
#include <stdio.h>
#include <stdlib.h>

enum { LIGHTS = 2, SIDE = 128 };

/* Ends the program where a call fails. `handle` is the call's first argument, where that is a handle. */
static void check(klieg_status status, const void *handle) {
    if (status != KLIEG_OK) {
        fprintf(stderr, "%s\n", klieg_error(handle));
        exit(1);
    }
}

int main(int count, char **arguments) {
    const klieg_role roles[LIGHTS] = {KLIEG_ROLE_KEY, KLIEG_ROLE_FILL};
    klieg_scene *scene;
    klieg_context *context;
    klieg_evaluator *evaluator;
    klieg_designer *designer;
    klieg_lit *lit;
    klieg_camera camera;
    klieg_design design;
    klieg_frame frame;
    klieg_light lights[LIGHTS];
    klieg_world_light world[LIGHTS];
    if (count != 3) {
        fprintf(stderr, "usage: light SCENE LIT.glb\n");
        return 2;
    }
    check(klieg_scene_load(arguments[1], &scene), NULL);
    check(klieg_camera_frame(scene, NULL, 1.0, &camera), NULL);
    if (klieg_context_create(KLIEG_VERSION, NULL, NULL, &context) == KLIEG_OK) {
        check(klieg_evaluator_of_scene(context, scene, &camera, SIDE, SIDE, NULL, NULL, NULL,
                                       &evaluator),
              NULL);
    } else { /* no Vulkan device: the same on the CPU */
        check(klieg_evaluator_on_cpu(KLIEG_VERSION, scene, &camera, SIDE, SIDE, NULL, NULL, NULL,
                                     &evaluator),
              NULL);
    }

    check(klieg_design_defaults(&design), NULL);
    design.roles = roles;
    design.lights = LIGHTS;
    check(klieg_evaluator_suggest(evaluator, &design, lights), evaluator);
    design.first = lights; /* where the search begins */
    check(klieg_designer_create(&design, &designer), NULL);
    check(klieg_designer_advance(designer, evaluator, 20, NULL), designer);
    check(klieg_designer_best(designer, lights, LIGHTS, NULL), designer);

    check(klieg_evaluator_frame(evaluator, &frame), evaluator);
    check(klieg_lights_in_world(&frame, lights, LIGHTS, world), NULL);
    for (int i = 0; i < LIGHTS; i++) {
        const double *at = world[i].position;
        printf("a light of %.2f cd at %.3f, %.3f, %.3f\n", world[i].intensity, at[0], at[1], at[2]);
    }
    check(klieg_lit_create(scene, &camera, SIDE, SIDE, lights, LIGHTS, &lit), NULL);
    check(klieg_lit_write(lit, arguments[2]), NULL);

    klieg_lit_destroy(lit);
    klieg_designer_destroy(designer);
    klieg_evaluator_destroy(evaluator);
    klieg_context_destroy(context);
    klieg_scene_destroy(scene);
    return 0;
}
