// A deferred renderer: a G-buffer, then any number of pictures of it under different lights.
#pragma once
#include "device.hpp"
#include "scene.hpp"
#include <memory>

constexpr uint32_t MAX_RIGS = 32;  // pictures a frame
constexpr uint32_t MAX_LIGHTS = 4; // lights a rig

struct Camera {
    Camera(Vec3 eye, Vec3 at, float aspect)
        : eye(eye), view(look_at(eye, at)), projection(perspective(vertical_angle, aspect, near)) {}

    Vec3 eye;
    float vertical_angle = 0.66f, near = 0.1f; // radians, world units
    Mat4 view, projection;
};

struct Light {
    Vec3 position; // in the world; the direction towards a directional light
    float radius;  // the distance at which the intensities hold; 0 for a directional light
    float diffuse, specular; // intensities
};

using Rig = std::vector<Light>;

class Renderer {
public:
    Renderer(const Device& device, const Scene& scene, VkExtent2D size, uint32_t frames);
    ~Renderer();
    Renderer(const Renderer&) = delete;

    // Tells what a frame shows; its commands must not be running.
    void set(uint32_t frame, const Camera& camera, const std::vector<Rig>& rigs);
    // Draws the G-buffer, which fragment and compute shaders may read afterwards.
    void draw_surface(VkCommandBuffer cmd, uint32_t frame);
    // Draws a picture of the G-buffer for each rig, one a layer, to be read in the same way.
    void draw_pictures(VkCommandBuffer cmd, uint32_t frame, const std::vector<Rig>& rigs);
    // The first picture, 4 bytes a pixel, when the commands that draw it have run.
    std::vector<uint8_t> read_picture();

    static constexpr VkImageLayout READ_LAYOUT = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    const VkExtent2D size;
    Image depth, normal, base_color, roughness_metallic, id;
    Image pictures;

private:
    struct Code {
        const uint32_t* words = nullptr;
        size_t size = 0; // bytes
    };

    // What shaders/frame.glsl declares of a frame.
    struct FrameData {
        Mat4 clip_from_world;
        Vec3 eye;
        float padding;
        struct {
            Light light;
            float padding[2];
            Mat4 shadow_from_world;
        } lights[MAX_RIGS * MAX_LIGHTS];
    };

    void make_descriptors();
    void make_pipelines();
    VkPipeline make_pipeline(Code vertex, Code fragment, const std::vector<VkFormat>& colors,
                             VkFormat depth) const;
    void draw_objects(VkCommandBuffer cmd, uint32_t frame, uint32_t light) const;

    const Device& device;
    const Scene& scene;
    Image shadows; // one layer for each light of the rig at work
    Buffer vertices, indices;
    std::vector<int32_t> first_vertex; // of each mesh
    std::vector<uint32_t> first_index;
    std::vector<std::unique_ptr<Buffer>> frames;
    VkSampler sampler;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool descriptors;
    std::vector<VkDescriptorSet> sets; // one a frame
    VkPipelineLayout layout;
    VkPipeline surface_pipeline, shadow_pipeline, picture_pipeline;
};
