#include "lighting.hpp"
#include <algorithm>

namespace {

void copy(const Mat4& matrix, double (&to)[16]) { std::copy(matrix.m.begin(), matrix.m.end(), to); }

template <typename T, size_t N> void copy(Vec3 v, T (&to)[N]) {
    to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

} // namespace

void ask(klieg_status status, const void* handle) {
    if (status != KLIEG_OK) throw std::runtime_error(std::string("klieg: ") + klieg_error(handle));
}

Lighting::Lighting(const Device& device, const klieg_features& features, const Scene& scene,
                   const Camera& seen, const Renderer& renderer, uint32_t most_rigs,
                   uint32_t most_lights) {
    klieg_device lent{};
    lent.get_instance_proc_addr = vkGetInstanceProcAddr;
    lent.instance = device.instance;
    lent.api_version = VK_API_VERSION_1_3;
    lent.debug_utils = device.debug_utils;
    lent.physical_device = device.physical;
    lent.device = device.handle;
    lent.queue = device.queue;
    lent.queue_family = device.family;
    lent.features = features;
    ask(klieg_context_borrow(KLIEG_VERSION, &lent, KLIEG_NEEDS_SCENE, nullptr, out(context)));
    auto [width, height] = renderer.size;
    make_scene_evaluator(scene, seen, renderer.size);
    ask(klieg_evaluator_of_surface(context.get(), width, height, nullptr, nullptr,
                                   out(surface.evaluator)));
    ask(klieg_evaluator_of_pictures(context.get(), width, height, nullptr,
                                    out(pictures.evaluator)));

    auto image = [](const Image& image) { return klieg_image{image.view, Renderer::READ_LAYOUT}; };
    klieg_surface_images images{};
    images.depth = image(renderer.depth);
    images.normal = image(renderer.normal);
    images.base_color = image(renderer.base_color);
    images.roughness_metallic = image(renderer.roughness_metallic);
    images.ids = image(renderer.id);
    klieg_surface_format format;
    ask(klieg_surface_format_defaults(&format));
    format.roughness_channel = 0;
    format.metallic_channel = 1;
    format.cleared_depth = 0; // depth is reversed
    for (View* view : {&surface, &pictures}) {
        klieg_evaluator* evaluator = view->evaluator.get();
        ask(klieg_surface_create(evaluator, &images, &format, out(view->surface)));
        for (uint32_t lights = 1; lights <= most_lights; ++lights) {
            ask(klieg_evaluator_reserve(evaluator, most_rigs, lights), evaluator);
        }
    }
    ask(klieg_pictures_create(pictures.evaluator.get(), image(renderer.pictures), MAX_RIGS,
                              KLIEG_ENCODING_LINEAR, KLIEG_CHANNELS_RGB, out(layers)));
    copy(seen.view, camera.view);
    copy(seen.projection, camera.projection);
    copy(scene.center, camera.center);
    camera.radius = scene.radius;
}

void Lighting::make_scene_evaluator(const Scene& scene, const Camera& seen, VkExtent2D size) {
    Handle<klieg_scene, klieg_scene_destroy> made;
    ask(klieg_scene_create("engine", out(made)));
    for (const Object& object : scene.objects) {
        const auto& [base_color, roughness, metallic] = object.material;
        klieg_material material;
        ask(klieg_material_defaults(&material));
        copy(base_color, material.base_color);
        material.roughness = roughness;
        material.metallic = metallic;
        const Mesh& shape = scene.meshes[object.mesh];
        klieg_mesh mesh{};
        mesh.vertices = shape.positions.size();
        mesh.positions = &shape.positions.data()->x;
        mesh.normals = &shape.normals.data()->x;
        mesh.index_count = shape.indices.size();
        mesh.indices = shape.indices.data();
        ask(klieg_scene_add_material(made.get(), &material, &mesh.material), made.get());
        uint32_t number;
        ask(klieg_scene_add_mesh(made.get(), &mesh, &number), made.get());
        double world[16];
        copy(object.world_from_object, world);
        ask(klieg_scene_add_instance(made.get(), nullptr, number, world), made.get());
    }
    ask(klieg_scene_finish(made.get()), made.get());
    double view[16];
    copy(seen.view, view);
    klieg_camera through;
    ask(klieg_camera_from_view(view, KLIEG_LENS_PERSPECTIVE, seen.vertical_angle, seen.near, 0,
                               &through));
    klieg_shadows shadows;
    ask(klieg_shadows_defaults(&shadows));
    shadows.on = 0; // as at level 2, which this is compared with
    ask(klieg_evaluator_of_scene(context.get(), made.get(), &through, size.width, size.height,
                                 nullptr, nullptr, &shadows, out(scene_evaluator)));
}

std::vector<float> Lighting::score_scene(const Rigs& rigs) {
    std::vector<float> scores(rigs.count());
    klieg_evaluator* evaluator = scene_evaluator.get();
    ask(klieg_evaluator_evaluate(evaluator, rigs.all.data(), rigs.count(), rigs.lights,
                                 scores.data()),
        evaluator);
    return scores;
}

void Lighting::record_view(Level level, VkCommandBuffer cmd) {
    View& view = of(level);
    ask(klieg_evaluator_record_view(view.evaluator.get(), cmd, view.surface.get(), &camera),
        view.evaluator.get());
}

void Lighting::record(Level level, VkCommandBuffer cmd, const Rigs& rigs, uint32_t first_layer,
                      VkBuffer scores) {
    klieg_evaluator* evaluator = of(level).evaluator.get();
    ask(level == Level::SURFACE
            ? klieg_evaluator_record(evaluator, cmd, rigs.all.data(), rigs.count(), rigs.lights,
                                     scores, 0)
            : klieg_evaluator_record_pictures(evaluator, cmd, layers.get(), first_layer,
                                              rigs.count(), scores, 0),
        evaluator);
}

std::vector<Rig> Lighting::in_world(Level level, const Rigs& rigs) {
    klieg_frame frame;
    ask(klieg_evaluator_frame(of(level).evaluator.get(), &frame), of(level).evaluator.get());
    std::vector<klieg_world_light> world(rigs.all.size());
    ask(klieg_lights_in_world(&frame, rigs.all.data(), uint32_t(world.size()), world.data()));
    std::vector<Rig> result(rigs.count());
    for (size_t i = 0; i < world.size(); ++i) {
        const klieg_world_light& light = world[i];
        bool point = light.kind == KLIEG_LIGHT_POINT;
        auto vector = [](const double* v) { return Vec3{float(v[0]), float(v[1]), float(v[2])}; };
        Vec3 position = point ? vector(light.position) : -1.f * vector(light.direction);
        result[i / rigs.lights].push_back(
            {position, float(light.distance), light.diffuse, light.specular});
    }
    return result;
}

void Lighting::forget_device() { ask(klieg_context_forget_device(context.get())); }

Search::Search(uint64_t seed) {
    const klieg_role roles[LIGHTS] = {KLIEG_ROLE_KEY, KLIEG_ROLE_FILL};
    klieg_design design;
    ask(klieg_design_defaults(&design));
    design.roles = roles;
    design.lights = LIGHTS;
    design.population = POPULATION;
    design.seed = seed;
    ask(klieg_designer_create(&design, out(designer)));
}

Rigs Search::wanted() {
    Rigs rigs{std::vector<klieg_light>(POPULATION * LIGHTS), LIGHTS};
    uint32_t count;
    ask(klieg_designer_ask(designer.get(), rigs.all.data(), POPULATION * LIGHTS, &count),
        designer.get());
    rigs.all.resize(count * LIGHTS);
    return rigs;
}

void Search::tell(const float* scores, uint32_t count) {
    ask(klieg_designer_tell(designer.get(), scores, count, nullptr), designer.get());
}

Rigs Search::best() {
    Rigs rigs{std::vector<klieg_light>(LIGHTS), LIGHTS};
    ask(klieg_designer_best(designer.get(), rigs.all.data(), LIGHTS, nullptr), designer.get());
    return rigs;
}

Rigs headlight() {
    klieg_light lights[KLIEG_MAX_LIGHTS];
    uint32_t count;
    ask(klieg_preset_lights(KLIEG_PRESET_HEADLIGHT, lights, KLIEG_MAX_LIGHTS, &count));
    return {{lights, lights + count}, count};
}
