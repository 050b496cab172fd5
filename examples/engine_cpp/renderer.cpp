#include "renderer.hpp"
#include <algorithm>
#include <cstddef>
#include <cstring>

namespace {

#include "picture.frag.h"
#include "picture.vert.h"
#include "shadow.vert.h"
#include "surface.frag.h"
#include "surface.vert.h"

constexpr VkExtent2D SHADOW_SIZE{512, 512};
constexpr VkShaderStageFlags STAGES = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr VkImageUsageFlags COLOR =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr VkImageUsageFlags DEPTH =
    VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr VkImageLayout UNDEFINED = VK_IMAGE_LAYOUT_UNDEFINED;
constexpr VkImageLayout DRAWN = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
constexpr VkImageLayout READ = Renderer::READ_LAYOUT;

struct Vertex {
    Vec3 position, normal;
};

// What shaders/frame.glsl declares of a draw.
struct Push {
    Mat4 world_from_object;
    Vec3 base_color;
    float roughness, metallic;
    uint32_t id;     // of the object, from 1
    uint32_t light;  // number of the light, or of the rig's first light
    uint32_t lights; // of the rig
};

// Elements of one of the arrays of all meshes.
template <typename T> size_t count(const Scene& scene, std::vector<T> Mesh::* array) {
    size_t sum = 0;
    for (const Mesh& mesh : scene.meshes) sum += (mesh.*array).size();
    return sum;
}

// The whole scene, seen from a light, which stands outside of it.
Mat4 shadow_from_world(const Light& light, const Scene& scene) {
    if (light.radius == 0) {
        return parallel(scene.radius) * look_at(scene.center, scene.center - light.position);
    }
    float distance = length(light.position - scene.center);
    float angle = 2 * std::asin(std::min(scene.radius / distance, 0.99f));
    float near = std::max(distance - scene.radius, 0.02f * scene.radius);
    return perspective(angle, 1, near) * look_at(light.position, scene.center);
}

// Begins to draw into images that are all cleared to 0.
void begin(VkCommandBuffer cmd, VkExtent2D size, const std::vector<VkImageView>& colors,
           VkImageView depth) {
    auto attachment = [](VkImageView view) {
        VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
        info.imageView = view;
        info.imageLayout = DRAWN;
        info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        return info;
    };
    std::vector<VkRenderingAttachmentInfo> attachments;
    for (VkImageView view : colors) attachments.push_back(attachment(view));
    VkRenderingAttachmentInfo depth_attachment = attachment(depth);
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea.extent = size;
    info.layerCount = 1;
    info.colorAttachmentCount = uint32_t(attachments.size());
    info.pColorAttachments = attachments.data();
    info.pDepthAttachment = depth ? &depth_attachment : nullptr;
    vkCmdBeginRendering(cmd, &info);
    VkViewport viewport{0, 0, float(size.width), float(size.height), 0, 1};
    vkCmdSetViewport(cmd, 0, 1, &viewport);
    vkCmdSetScissor(cmd, 0, 1, &info.renderArea);
}

} // namespace

Renderer::Renderer(const Device& device, const Scene& scene, VkExtent2D size, uint32_t frame_count)
    : size(size), depth(device, VK_FORMAT_D32_SFLOAT, size, DEPTH),
      normal(device, VK_FORMAT_R16G16B16A16_SFLOAT, size, COLOR),
      base_color(device, VK_FORMAT_R8G8B8A8_SRGB, size, COLOR),
      roughness_metallic(device, VK_FORMAT_R8G8_UNORM, size, COLOR),
      id(device, VK_FORMAT_R32_UINT, size, COLOR),
      pictures(device, VK_FORMAT_R8G8B8A8_SRGB, size, COLOR | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
               MAX_RIGS),
      device(device), scene(scene),
      shadows(device, VK_FORMAT_D32_SFLOAT, SHADOW_SIZE, DEPTH, MAX_LIGHTS),
      vertices(device, count(scene, &Mesh::positions) * sizeof(Vertex),
               VK_BUFFER_USAGE_VERTEX_BUFFER_BIT),
      indices(device, count(scene, &Mesh::indices) * sizeof(uint32_t),
              VK_BUFFER_USAGE_INDEX_BUFFER_BIT) {
    auto* vertex = static_cast<Vertex*>(vertices.mapped);
    auto* index = static_cast<uint32_t*>(indices.mapped);
    for (const Mesh& mesh : scene.meshes) {
        first_vertex.push_back(int32_t(vertex - static_cast<Vertex*>(vertices.mapped)));
        first_index.push_back(uint32_t(index - static_cast<uint32_t*>(indices.mapped)));
        for (size_t i = 0; i < mesh.positions.size(); ++i)
            *vertex++ = {mesh.positions[i], mesh.normals[i]};
        for (uint32_t i : mesh.indices) *index++ = i;
    }
    for (uint32_t i = 0; i < frame_count; ++i) {
        frames.push_back(std::make_unique<Buffer>(device, sizeof(FrameData),
                                                  VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT));
    }
    make_descriptors();
    make_pipelines();
}

Renderer::~Renderer() {
    for (VkPipeline pipeline : {surface_pipeline, shadow_pipeline, picture_pipeline}) {
        vkDestroyPipeline(device.handle, pipeline, nullptr);
    }
    vkDestroyPipelineLayout(device.handle, layout, nullptr);
    vkDestroyDescriptorPool(device.handle, descriptors, nullptr);
    vkDestroyDescriptorSetLayout(device.handle, set_layout, nullptr);
    vkDestroySampler(device.handle, sampler, nullptr);
}

void Renderer::make_descriptors() {
    VkSamplerCreateInfo sampling{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampling.magFilter = sampling.minFilter = VK_FILTER_NEAREST;
    sampling.addressModeU = sampling.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    sampling.compareEnable = VK_TRUE;
    sampling.compareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;
    check(vkCreateSampler(device.handle, &sampling, nullptr, &sampler), "vkCreateSampler");

    std::vector<VkDescriptorSetLayoutBinding> bindings;
    auto bind = [&](VkDescriptorType type) {
        bindings.push_back({uint32_t(bindings.size()), type, 1, STAGES, nullptr});
    };
    bind(VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
    const Image* images[] = {&depth, &normal, &base_color, &roughness_metallic, &shadows};
    for (const Image* image : images) {
        bind(image == &shadows ? VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER
                               : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE);
    }
    VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    info.bindingCount = uint32_t(bindings.size());
    info.pBindings = bindings.data();
    check(vkCreateDescriptorSetLayout(device.handle, &info, nullptr, &set_layout),
          "vkCreateDescriptorSetLayout");

    uint32_t n = uint32_t(frames.size());
    VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, n},
                                    {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 4 * n},
                                    {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, n}};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = n;
    pool.poolSizeCount = 3;
    pool.pPoolSizes = sizes;
    check(vkCreateDescriptorPool(device.handle, &pool, nullptr, &descriptors),
          "vkCreateDescriptorPool");
    std::vector<VkDescriptorSetLayout> layouts(n, set_layout);
    VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocation.descriptorPool = descriptors;
    allocation.descriptorSetCount = n;
    allocation.pSetLayouts = layouts.data();
    sets.resize(n);
    check(vkAllocateDescriptorSets(device.handle, &allocation, sets.data()),
          "vkAllocateDescriptorSets");
    for (uint32_t frame = 0; frame < n; ++frame) {
        for (const VkDescriptorSetLayoutBinding& binding : bindings) {
            VkDescriptorBufferInfo buffer{frames[frame]->handle, 0, VK_WHOLE_SIZE};
            VkDescriptorImageInfo image{sampler, VK_NULL_HANDLE, READ};
            if (binding.binding > 0) image.imageView = images[binding.binding - 1]->view;
            VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            write.dstSet = sets[frame];
            write.dstBinding = binding.binding;
            write.descriptorCount = 1;
            write.descriptorType = binding.descriptorType;
            write.pBufferInfo = &buffer;
            write.pImageInfo = &image;
            vkUpdateDescriptorSets(device.handle, 1, &write, 0, nullptr);
        }
    }
}

void Renderer::make_pipelines() {
    VkPushConstantRange push{STAGES, 0, sizeof(Push)};
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = 1;
    info.pSetLayouts = &set_layout;
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &push;
    check(vkCreatePipelineLayout(device.handle, &info, nullptr, &layout), "vkCreatePipelineLayout");
    std::vector<VkFormat> surface{normal.format, base_color.format, roughness_metallic.format,
                                  id.format};
    surface_pipeline = make_pipeline({surface_vert, sizeof surface_vert},
                                     {surface_frag, sizeof surface_frag}, surface, depth.format);
    shadow_pipeline = make_pipeline({shadow_vert, sizeof shadow_vert}, {}, {}, shadows.format);
    picture_pipeline =
        make_pipeline({picture_vert, sizeof picture_vert}, {picture_frag, sizeof picture_frag},
                      {pictures.format}, VK_FORMAT_UNDEFINED);
}

// A pipeline with depth draws the scene's triangles, one without the whole picture.
VkPipeline Renderer::make_pipeline(Code vertex, Code fragment, const std::vector<VkFormat>& colors,
                                   VkFormat depth_format) const {
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    for (auto [code, stage] : {std::pair(vertex, VK_SHADER_STAGE_VERTEX_BIT),
                               {fragment, VK_SHADER_STAGE_FRAGMENT_BIT}}) {
        if (!code.words) continue;
        VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        module.codeSize = code.size;
        module.pCode = code.words;
        VkPipelineShaderStageCreateInfo& info = stages.emplace_back();
        info = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                nullptr,
                0,
                stage,
                VK_NULL_HANDLE,
                "main"};
        check(vkCreateShaderModule(device.handle, &module, nullptr, &info.module),
              "vkCreateShaderModule");
    }
    bool geometry = depth_format != VK_FORMAT_UNDEFINED;
    VkVertexInputBindingDescription binding{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
    VkVertexInputAttributeDescription attributes[] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, normal)}};
    VkPipelineVertexInputStateCreateInfo input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    input.vertexBindingDescriptionCount = geometry ? 1 : 0;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = geometry ? (fragment.words ? 2 : 1) : 0;
    input.pVertexAttributeDescriptions = attributes;
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{
        VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{
        VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{
        VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth_test{
        VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth_test.depthTestEnable = depth_test.depthWriteEnable = geometry;
    depth_test.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState write_all{};
    write_all.colorWriteMask = 0xF;
    std::vector<VkPipelineColorBlendAttachmentState> blends(colors.size(), write_all);
    VkPipelineColorBlendStateCreateInfo blend{
        VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = uint32_t(blends.size());
    blend.pAttachments = blends.data();
    VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamics{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamics.dynamicStateCount = 2;
    dynamics.pDynamicStates = dynamic;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = uint32_t(colors.size());
    rendering.pColorAttachmentFormats = colors.data();
    rendering.depthAttachmentFormat = depth_format;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = uint32_t(stages.size());
    info.pStages = stages.data();
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth_test;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamics;
    info.layout = layout;
    VkPipeline pipeline;
    check(vkCreateGraphicsPipelines(device.handle, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines");
    for (const auto& stage : stages) vkDestroyShaderModule(device.handle, stage.module, nullptr);
    return pipeline;
}

void Renderer::set(uint32_t frame, const Camera& camera, const std::vector<Rig>& rigs) {
    auto& data = *static_cast<FrameData*>(frames[frame]->mapped);
    data.clip_from_world = camera.projection * camera.view;
    data.eye = camera.eye;
    for (size_t rig = 0; rig < rigs.size(); ++rig) {
        for (size_t i = 0; i < rigs[rig].size(); ++i) {
            const Light& light = rigs[rig][i];
            data.lights[MAX_LIGHTS * rig + i] = {light, {}, shadow_from_world(light, scene)};
        }
    }
}

void Renderer::draw_objects(VkCommandBuffer cmd, uint32_t frame, uint32_t light) const {
    VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(cmd, 0, 1, &vertices.handle, &offset);
    vkCmdBindIndexBuffer(cmd, indices.handle, 0, VK_INDEX_TYPE_UINT32);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &sets[frame], 0,
                            nullptr);
    uint32_t id = 0;
    for (const Object& object : scene.objects) {
        const Material& material = object.material;
        Push push{object.world_from_object,
                  material.base_color,
                  material.roughness,
                  material.metallic,
                  ++id,
                  light,
                  0};
        vkCmdPushConstants(cmd, layout, STAGES, 0, sizeof push, &push);
        uint32_t count = uint32_t(scene.meshes[object.mesh].indices.size());
        vkCmdDrawIndexed(cmd, count, 1, first_index[object.mesh], first_vertex[object.mesh], 0);
    }
}

void Renderer::draw_surface(VkCommandBuffer cmd, uint32_t frame) {
    const Image* colors[] = {&normal, &base_color, &roughness_metallic, &id};
    transition(cmd, depth, UNDEFINED, DRAWN, SHADER_READ, DEPTH_WRITE);
    for (const Image* image : colors)
        transition(cmd, *image, UNDEFINED, DRAWN, SHADER_READ, COLOR_WRITE);
    begin(cmd, size, {normal.view, base_color.view, roughness_metallic.view, id.view}, depth.view);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, surface_pipeline);
    draw_objects(cmd, frame, 0);
    vkCmdEndRendering(cmd);
    transition(cmd, depth, DRAWN, READ, DEPTH_WRITE, SHADER_READ);
    for (const Image* image : colors)
        transition(cmd, *image, DRAWN, READ, COLOR_WRITE, SHADER_READ);
}

void Renderer::draw_pictures(VkCommandBuffer cmd, uint32_t frame, const std::vector<Rig>& rigs) {
    transition(cmd, pictures, UNDEFINED, DRAWN, SHADER_READ, COLOR_WRITE);
    for (uint32_t rig = 0; rig < rigs.size(); ++rig) {
        uint32_t first = MAX_LIGHTS * rig, lights = uint32_t(rigs[rig].size());
        transition(cmd, shadows, UNDEFINED, DRAWN, SHADER_READ, DEPTH_WRITE);
        for (uint32_t i = 0; i < lights; ++i) {
            begin(cmd, SHADOW_SIZE, {}, shadows.layers[i]);
            vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, shadow_pipeline);
            draw_objects(cmd, frame, first + i);
            vkCmdEndRendering(cmd);
        }
        transition(cmd, shadows, DRAWN, READ, DEPTH_WRITE, SHADER_READ);
        begin(cmd, size, {pictures.layers[rig]}, VK_NULL_HANDLE);
        vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, picture_pipeline);
        vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &sets[frame], 0,
                                nullptr);
        Push push{};
        push.light = first;
        push.lights = lights;
        vkCmdPushConstants(cmd, layout, STAGES, 0, sizeof push, &push);
        vkCmdDraw(cmd, 3, 1, 0, 0);
        vkCmdEndRendering(cmd);
    }
    transition(cmd, pictures, DRAWN, READ, COLOR_WRITE, SHADER_READ);
}

std::vector<uint8_t> Renderer::read_picture() {
    std::vector<uint8_t> texels(size_t(4) * size.width * size.height);
    Buffer buffer(device, texels.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    device.run([&](VkCommandBuffer cmd) {
        constexpr VkImageLayout COPIED = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        transition(cmd, pictures, READ, COPIED, SHADER_READ, COPY_READ);
        VkBufferImageCopy region{};
        region.imageSubresource = {pictures.aspect, 0, 0, 1};
        region.imageExtent = {size.width, size.height, 1};
        vkCmdCopyImageToBuffer(cmd, pictures.handle, COPIED, buffer.handle, 1, &region);
        memory_barrier(cmd, COPY_WRITE, HOST_READ);
        transition(cmd, pictures, COPIED, READ, COPY_READ, SHADER_READ);
    });
    std::memcpy(texels.data(), buffer.mapped, texels.size());
    return texels;
}
