// klieg in the engine: what it is told of device, scene and pictures, and what it is asked.
#pragma once
#include "renderer.hpp"
#include <klieg.h>

// Rigs of klieg's, one after the other, each with the same number of lights.
struct Rigs {
    std::vector<klieg_light> all;
    uint32_t lights = 1;
    uint32_t count() const { return uint32_t(all.size()) / lights; }
};

// Throws klieg's message unless a call has succeeded: the handle's, or the thread's.
void ask(klieg_status status, const void* handle = nullptr);

// A handle of klieg's with its end.
template <typename T, void (*DESTROY)(T*)> struct Destroy {
    void operator()(T* handle) const { DESTROY(handle); }
};
template <typename T, void (*DESTROY)(T*)> using Handle = std::unique_ptr<T, Destroy<T, DESTROY>>;

// Passes the place for a handle to a function that makes one.
template <typename Owner> struct Out {
    Owner& owner;
    typename Owner::pointer made = nullptr;
    ~Out() { owner.reset(made); }
    operator typename Owner::pointer*() { return &made; }
};
template <typename Owner> Out<Owner> out(Owner& owner) { return {owner}; }

// What the engine gives of a frame: its surface, which klieg shades, or its own pictures as well.
enum class Level { SURFACE, PICTURES };

class Lighting {
public:
    Lighting(const Device& device, const klieg_features& features, const Scene& scene,
             const Camera& camera, const Renderer& renderer, uint32_t most_rigs,
             uint32_t most_lights);

    // The scores of the scene as klieg draws it by itself: lower is better.
    std::vector<float> score_scene(const Rigs& rigs);
    // Records klieg's look at the G-buffer, outside of any drawing. The lights of `in_world` and of
    // `record` belong to this view.
    void record_view(Level level, VkCommandBuffer cmd);
    // Records the scores of rigs, whose pictures, where they count, begin at a layer.
    void record(Level level, VkCommandBuffer cmd, const Rigs& rigs, uint32_t first_layer,
                VkBuffer scores);
    // The rigs as the engine applies them.
    std::vector<Rig> in_world(Level level, const Rigs& rigs);
    // The device will go before this does.
    void forget_device();

private:
    using Evaluator = Handle<klieg_evaluator, klieg_evaluator_destroy>;
    using Surface = Handle<klieg_surface, klieg_surface_destroy>;

    struct View {
        Evaluator evaluator;
        Surface surface;
    };

    void make_scene_evaluator(const Scene& scene, const Camera& camera, VkExtent2D size);
    View& of(Level level) { return level == Level::SURFACE ? surface : pictures; }

    Handle<klieg_context, klieg_context_destroy> context;
    Evaluator scene_evaluator;
    View surface, pictures;
    Handle<klieg_pictures, klieg_pictures_destroy> layers;
    klieg_engine_camera camera;
};

// A search for lights: one key light and one that fills the shadows.
class Search {
public:
    static constexpr uint32_t POPULATION = 16, LIGHTS = 2;

    explicit Search(uint64_t seed);
    // The rigs whose scores it wants next.
    Rigs wanted();
    void tell(const float* scores, uint32_t count);
    // The best of them so far.
    Rigs best();

private:
    Handle<klieg_designer, klieg_designer_destroy> designer;
};

// One light from the viewer.
Rigs headlight();
