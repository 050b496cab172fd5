//! Render passes, pipelines and descriptor sets.

use crate::Result;
use crate::renderer::SAMPLED;
use crate::vulkan::{Buffer, Gpu, Image, aspect};
use ash::vk;
use shaderc::ShaderKind;

/// Stages that read the frame's set and the draws' constants.
pub const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);
const CONSTANTS: u32 = 96;
/// The sampled images of the set, after the uniforms.
const IMAGES: u32 = 5;

/// The layouts of the frame's set and of both pipelines.
pub fn layouts(gpu: &Gpu) -> Result<(vk::DescriptorSetLayout, vk::PipelineLayout)> {
    let binding = |i| {
        let kind = match i {
            0 => vk::DescriptorType::UNIFORM_BUFFER,
            _ => vk::DescriptorType::SAMPLED_IMAGE,
        };
        let binding = vk::DescriptorSetLayoutBinding::default().binding(i).descriptor_type(kind);
        binding.descriptor_count(1).stage_flags(STAGES)
    };
    let bindings: Vec<_> = (0..=IMAGES).map(binding).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    let constants = [vk::PushConstantRange::default().stage_flags(STAGES).size(CONSTANTS)];
    // SAFETY: the device is alive; every info is complete.
    unsafe {
        let set = gpu.device.create_descriptor_set_layout(&info, None)?;
        gpu.finally(move |device| device.destroy_descriptor_set_layout(set, None));
        let sets = [set];
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&sets)
            .push_constant_ranges(&constants);
        let layout = gpu.device.create_pipeline_layout(&info, None)?;
        gpu.finally(move |device| device.destroy_pipeline_layout(layout, None));
        Ok((set, layout))
    }
}

/// A frame's set: its uniforms and the G-buffer.
pub fn set(
    gpu: &Gpu,
    layout: vk::DescriptorSetLayout,
    uniforms: &Buffer,
    g_buffer: &[Image],
) -> Result<vk::DescriptorSet> {
    let size = |ty, descriptor_count| vk::DescriptorPoolSize { ty, descriptor_count };
    let (block, image) = (vk::DescriptorType::UNIFORM_BUFFER, vk::DescriptorType::SAMPLED_IMAGE);
    let sizes = [size(block, 1), size(image, IMAGES)];
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
    let layouts = [layout];
    let buffer = [vk::DescriptorBufferInfo::default().buffer(uniforms.raw).range(vk::WHOLE_SIZE)];
    let image_info =
        |i: &Image| vk::DescriptorImageInfo::default().image_view(i.view).image_layout(SAMPLED);
    let images: Vec<_> = g_buffer.iter().map(image_info).collect();
    // SAFETY: the device is alive; every info is complete; the set is not in use yet.
    unsafe {
        let pool = gpu.device.create_descriptor_pool(&info, None)?;
        gpu.finally(move |device| device.destroy_descriptor_pool(pool, None));
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        let set = gpu.device.allocate_descriptor_sets(&info)?[0];
        let write = vk::WriteDescriptorSet::default().dst_set(set);
        let mut writes = vec![write.descriptor_type(block).buffer_info(&buffer)];
        writes.extend(images.chunks(1).zip(1..).map(|(images, binding)| {
            write.dst_binding(binding).descriptor_type(image).image_info(images)
        }));
        gpu.device.update_descriptor_sets(&writes, &[]);
        Ok(set)
    }
}

/// A render pass on its images, and the pipeline that draws in it.
pub struct Pass {
    raw: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    pipeline: vk::Pipeline,
    clears: Vec<vk::ClearValue>,
    size: vk::Extent2D,
}

impl Pass {
    /// A pass that clears `images` and leaves them in `layout`, and a pipeline of vertex and fragment
    /// shader. With a depth image it draws meshes, else the whole screen.
    pub fn new(
        gpu: &Gpu,
        images: &[Image],
        layout: vk::ImageLayout,
        [width, height]: [u32; 2],
        pipeline_layout: vk::PipelineLayout,
        [vertex, fragment]: [&str; 2],
    ) -> Result<Self> {
        let shaders =
            [gpu.shader(ShaderKind::Vertex, vertex)?, gpu.shader(ShaderKind::Fragment, fragment)?];
        let size = vk::Extent2D { width, height };
        let raw = render_pass(gpu, images, layout)?;
        let views: Vec<_> = images.iter().map(|image| image.view).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(raw)
            .attachments(&views)
            .width(width)
            .height(height)
            .layers(1);
        // SAFETY: pass and views are of this device.
        let framebuffer = unsafe { gpu.device.create_framebuffer(&info, None)? };
        // SAFETY: at the end nothing uses it any more.
        gpu.finally(move |device| unsafe { device.destroy_framebuffer(framebuffer, None) });
        // All is cleared to zeros: the depth because it is reversed, the ids for the background.
        let clears = vec![vk::ClearValue::default(); images.len()];
        let meshes = images.iter().any(is_depth);
        let colors = images.len() - usize::from(meshes);
        let pipeline = pipeline(gpu, raw, pipeline_layout, shaders, size, (meshes, colors))?;
        Ok(Self { raw, framebuffer, pipeline, clears, size })
    }

    /// Begins the pass with its pipeline.
    ///
    /// # Safety
    /// `cmd` is being recorded, outside render passes.
    pub unsafe fn begin(&self, device: &ash::Device, cmd: vk::CommandBuffer) {
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.raw)
            .framebuffer(self.framebuffer)
            .render_area(self.size.into())
            .clear_values(&self.clears);
        // SAFETY: the caller's promise.
        unsafe {
            device.cmd_begin_render_pass(cmd, &info, vk::SubpassContents::INLINE);
            device.cmd_bind_pipeline(cmd, vk::PipelineBindPoint::GRAPHICS, self.pipeline);
        }
    }
}

fn is_depth(image: &Image) -> bool {
    aspect(image.format) == vk::ImageAspectFlags::DEPTH
}

/// The pass begins when the readers of the frame before are done, klieg among them, and ends with the
/// images visible to whoever reads them in this one.
fn render_pass(gpu: &Gpu, images: &[Image], layout: vk::ImageLayout) -> Result<vk::RenderPass> {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let attachment = |image: &Image| {
        vk::AttachmentDescription::default()
            .format(image.format)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .final_layout(layout)
    };
    let attachments: Vec<_> = images.iter().map(attachment).collect();
    let reference = |depth, layout| {
        let numbers = (0_u32..).zip(images).filter(move |(_, image)| is_depth(image) == depth);
        let of = move |(i, _)| vk::AttachmentReference::default().attachment(i).layout(layout);
        numbers.map(of).collect::<Vec<_>>()
    };
    let colors = reference(false, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
    let depths = reference(true, vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    let mut subpass = vk::SubpassDescription::default().color_attachments(&colors);
    if let Some(depth) = depths.first() {
        subpass = subpass.depth_stencil_attachment(depth);
    }
    let readers = Stage::COMPUTE_SHADER | Stage::FRAGMENT_SHADER | Stage::TRANSFER;
    let drawing =
        Stage::COLOR_ATTACHMENT_OUTPUT | Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    let written = Access::COLOR_ATTACHMENT_WRITE | Access::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let before = vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(readers | drawing)
        .src_access_mask(written)
        .dst_stage_mask(drawing)
        .dst_access_mask(written | Access::DEPTH_STENCIL_ATTACHMENT_READ);
    let after = vk::SubpassDependency::default()
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(drawing)
        .src_access_mask(written)
        .dst_stage_mask(readers)
        .dst_access_mask(Access::SHADER_READ | Access::TRANSFER_READ);
    let (subpasses, dependencies) = ([subpass], [before, after]);
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: the device is alive; the info is complete.
    let pass = unsafe { gpu.device.create_render_pass(&info, None)? };
    // SAFETY: at the end nothing uses it any more.
    gpu.finally(move |device| unsafe { device.destroy_render_pass(pass, None) });
    Ok(pass)
}

type Vertices = (Vec<vk::VertexInputBindingDescription>, Vec<vk::VertexInputAttributeDescription>);

/// Positions and normals, each in a buffer of its own.
fn vertices() -> Vertices {
    let input = |i| {
        let binding = vk::VertexInputBindingDescription::default().binding(i).stride(12);
        let attribute = vk::VertexInputAttributeDescription::default().binding(i).location(i);
        (binding, attribute.format(vk::Format::R32G32B32_SFLOAT))
    };
    (0..2).map(input).unzip()
}

/// Draws meshes with a depth test and nothing blended, or a triangle without vertices.
fn pipeline(
    gpu: &Gpu,
    pass: vk::RenderPass,
    layout: vk::PipelineLayout,
    shaders: [vk::ShaderModule; 2],
    size: vk::Extent2D,
    (meshes, colors): (bool, usize),
) -> Result<vk::Pipeline> {
    let stage = |stage, module| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main")
    };
    let stages = [
        stage(vk::ShaderStageFlags::VERTEX, shaders[0]),
        stage(vk::ShaderStageFlags::FRAGMENT, shaders[1]),
    ];
    let (bindings, attributes) = if meshes { vertices() } else { Default::default() };
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let (width, height) = (size.width as f32, size.height as f32);
    let viewports = [vk::Viewport { width, height, max_depth: 1.0, ..Default::default() }];
    let scissors = [size.into()];
    let viewport =
        vk::PipelineViewportStateCreateInfo::default().viewports(&viewports).scissors(&scissors);
    // Counter-clockwise fronts, as klieg has them.
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .cull_mode(if meshes { vk::CullModeFlags::BACK } else { vk::CullModeFlags::NONE })
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(meshes)
        .depth_write_enable(meshes)
        .depth_compare_op(vk::CompareOp::GREATER);
    let all = vk::ColorComponentFlags::RGBA;
    let opaque = vk::PipelineColorBlendAttachmentState::default().color_write_mask(all);
    let blends = vec![opaque; colors];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let info = [vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .layout(layout)
        .render_pass(pass)];
    // SAFETY: shaders, layout and pass are of this device and belong together.
    let made =
        unsafe { gpu.device.create_graphics_pipelines(vk::PipelineCache::null(), &info, None) };
    let pipeline = made.map_err(|(_, result)| result)?[0];
    // SAFETY: at the end nothing uses it any more.
    gpu.finally(move |device| unsafe { device.destroy_pipeline(pipeline, None) });
    Ok(pipeline)
}
