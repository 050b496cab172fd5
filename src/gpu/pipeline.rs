//! Descriptor sets, pipeline layouts and compute pipelines.

use super::memory::{Buffer, Image};
use super::{Call, Context};
use crate::Result;
use ash::vk;
use std::ffi::CStr;
use std::sync::Arc;

/// The entry point of every shader.
const MAIN: &CStr = c"main";

/// A binding of a set: its number, its kind, and the stages that may use it.
pub type Binding = (u32, vk::DescriptorType, vk::ShaderStageFlags);

/// The layout of a descriptor set and its one set.
pub struct DescriptorSet {
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    raw: vk::DescriptorSet,
    bindings: Vec<Binding>,
    context: Arc<Context>,
}

impl DescriptorSet {
    /// A set with nothing in it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, name: &str, bindings: &[Binding]) -> Result<Self> {
        let mut set = Self {
            layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            raw: vk::DescriptorSet::null(),
            bindings: bindings.to_vec(),
            context: Arc::clone(context),
        };
        let of = |&(binding, kind, stages): &Binding| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(stages)
        };
        let layout_bindings: Vec<_> = bindings.iter().map(of).collect();
        let layout = vk::DescriptorSetLayoutCreateInfo::default().bindings(&layout_bindings);
        let size =
            |&(_, kind, _): &Binding| vk::DescriptorPoolSize { ty: kind, descriptor_count: 1 };
        let sizes: Vec<_> = bindings.iter().map(size).collect();
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let device = context.device();
        // SAFETY: the device is alive; every info is complete; a half-made `set` is dropped on
        // failure.
        unsafe {
            set.layout = device
                .create_descriptor_set_layout(&layout, None)
                .call("vkCreateDescriptorSetLayout")?;
            set.pool = device.create_descriptor_pool(&pool, None).call("vkCreateDescriptorPool")?;
            let layouts = [set.layout];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(set.pool)
                .set_layouts(&layouts);
            set.raw = device.allocate_descriptor_sets(&info).call("vkAllocateDescriptorSets")?[0];
        }
        context.count_descriptors();
        context.name(set.raw, name);
        Ok(set)
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::DescriptorSet {
        self.raw
    }

    /// The layout's Vulkan handle.
    pub fn layout(&self) -> vk::DescriptorSetLayout {
        self.layout
    }

    fn kind(&self, binding: u32) -> vk::DescriptorType {
        let found = self.bindings.iter().find(|b| b.0 == binding);
        found.expect("a binding of the layout").1
    }

    /// Puts a whole buffer at `binding`. The set must not be in use.
    pub fn write_buffer(&mut self, binding: u32, buffer: &Buffer) {
        self.write_window(binding, buffer, vk::WHOLE_SIZE);
    }

    /// Puts `range` bytes of a buffer, from the front or from a dynamic offset, at `binding`. The set
    /// must not be in use.
    pub fn write_window(&mut self, binding: u32, buffer: &Buffer, range: u64) {
        let info = [vk::DescriptorBufferInfo::default().buffer(buffer.raw()).range(range)];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.raw)
            .dst_binding(binding)
            .descriptor_type(self.kind(binding))
            .buffer_info(&info);
        self.context.count_descriptors();
        // SAFETY: set and buffer are alive, and the set is not in use.
        unsafe { self.context.device().update_descriptor_sets(&[write], &[]) };
    }

    /// Puts an image in `layout` at `binding`. The set must not be in use.
    pub fn write_image(&mut self, binding: u32, image: &Image, layout: vk::ImageLayout) {
        let info =
            [vk::DescriptorImageInfo::default().image_view(image.view()).image_layout(layout)];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.raw)
            .dst_binding(binding)
            .descriptor_type(self.kind(binding))
            .image_info(&info);
        self.context.count_descriptors();
        // SAFETY: set and image are alive, and the set is not in use.
        unsafe { self.context.device().update_descriptor_sets(&[write], &[]) };
    }
}

impl Drop for DescriptorSet {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the set; null handles are allowed.
        self.context.destroy(|device| unsafe {
            device.destroy_descriptor_pool(self.pool, None);
            device.destroy_descriptor_set_layout(self.layout, None);
        });
    }
}

/// What pipelines take: descriptor sets and push constants.
pub struct PipelineLayout {
    raw: vk::PipelineLayout,
    context: Arc<Context>,
}

impl PipelineLayout {
    /// A layout of `sets`, in order, and `push_bytes` of push constants for `push_stages`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        sets: &[&DescriptorSet],
        push_stages: vk::ShaderStageFlags,
        push_bytes: u32,
    ) -> Result<Self> {
        let layouts: Vec<_> = sets.iter().map(|set| set.layout).collect();
        let push =
            [vk::PushConstantRange { stage_flags: push_stages, offset: 0, size: push_bytes }];
        let push = if push_bytes == 0 { &[][..] } else { &push[..] };
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&layouts)
            .push_constant_ranges(push);
        // SAFETY: the device and the set layouts are alive.
        let raw = unsafe { context.device().create_pipeline_layout(&info, None) }
            .call("vkCreatePipelineLayout")?;
        Ok(Self { raw, context: Arc::clone(context) })
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::PipelineLayout {
        self.raw
    }
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        // SAFETY: pipelines and command buffers may outlive their layout.
        self.context.destroy(|device| unsafe { device.destroy_pipeline_layout(self.raw, None) });
    }
}

/// Values of specialisation constants, `u32` each: constant `i` has the number `i`.
pub struct Specialization<'a> {
    entries: Vec<vk::SpecializationMapEntry>,
    values: &'a [u32],
}

impl<'a> Specialization<'a> {
    /// Of the values in the order of their numbers.
    pub fn new(values: &'a [u32]) -> Self {
        let entry = |i: usize| vk::SpecializationMapEntry {
            constant_id: i as u32,
            offset: 4 * i as u32,
            size: 4,
        };
        Self { entries: (0..values.len()).map(entry).collect(), values }
    }

    /// For a shader stage of a pipeline.
    pub fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default()
            .map_entries(&self.entries)
            .data(bytemuck::cast_slice(self.values))
    }
}

/// A shader module, which only its pipelines' making needs.
pub struct ShaderModule {
    raw: vk::ShaderModule,
    context: Arc<Context>,
}

impl ShaderModule {
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, spirv: &[u32]) -> Result<Self> {
        let info = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: the SPIR-V comes from our own build.
        let raw = unsafe { context.device().create_shader_module(&info, None) }
            .call("vkCreateShaderModule")?;
        Ok(Self { raw, context: Arc::clone(context) })
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::ShaderModule {
        self.raw
    }
}

impl Drop for ShaderModule {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once made.
        self.context.destroy(|device| unsafe { device.destroy_shader_module(self.raw, None) });
    }
}

/// Pipelines that are specialised to the number of lights of a rig.
#[derive(Default)]
pub struct ByLights(Vec<(usize, Pipeline)>);

impl ByLights {
    /// Makes the pipeline for `lights` lights, unless it is there.
    ///
    /// # Errors
    /// What `make` reports.
    pub fn prepare(
        &mut self,
        lights: usize,
        make: impl FnOnce() -> Result<Pipeline>,
    ) -> Result<()> {
        if !self.has(lights) {
            self.0.push((lights, make()?));
        }
        Ok(())
    }

    /// Whether a number of lights was prepared.
    pub fn has(&self, lights: usize) -> bool {
        self.0.iter().any(|(l, _)| *l == lights)
    }

    /// The pipeline for a number of lights that was prepared.
    pub fn of(&self, lights: usize) -> &Pipeline {
        let found = self.0.iter().find(|(l, _)| *l == lights);
        &found.expect("a prepared number of lights").1
    }
}

/// One of a pipeline's stages.
pub fn shader_stage<'a>(
    stage: vk::ShaderStageFlags,
    module: &ShaderModule,
    specialization: &'a vk::SpecializationInfo<'a>,
) -> vk::PipelineShaderStageCreateInfo<'a> {
    vk::PipelineShaderStageCreateInfo::default()
        .stage(stage)
        .module(module.raw())
        .name(MAIN)
        .specialization_info(specialization)
}

/// A pipeline that is destroyed with its owner.
pub struct Pipeline {
    raw: vk::Pipeline,
    context: Arc<Context>,
}

impl Pipeline {
    /// A compute stage: shader `spirv` with its specialisation constants.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn compute(
        context: &Arc<Context>,
        stem: &str,
        spirv: &[u32],
        layout: &PipelineLayout,
        constants: &[u32],
    ) -> Result<Self> {
        let module = ShaderModule::new(context, spirv)?;
        let specialization = Specialization::new(constants);
        let specialization = specialization.info();
        let stage = shader_stage(vk::ShaderStageFlags::COMPUTE, &module, &specialization);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw)];
        let cache = vk::PipelineCache::null();
        // SAFETY: module and layout are alive, and the shader was written for the layout.
        let made = unsafe { context.device().create_compute_pipelines(cache, &info, None) };
        Self::made(context, stem, made)
    }

    /// A graphics pipeline.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn graphics(
        context: &Arc<Context>,
        stem: &str,
        info: vk::GraphicsPipelineCreateInfo<'_>,
    ) -> Result<Self> {
        let cache = vk::PipelineCache::null();
        // SAFETY: everything that `info` names is alive, as its lifetime says for its pointers and
        // the caller for its handles.
        let made = unsafe { context.device().create_graphics_pipelines(cache, &[info], None) };
        Self::made(context, stem, made)
    }

    fn made(
        context: &Arc<Context>,
        stem: &str,
        made: Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
    ) -> Result<Self> {
        let raw = made.map_err(|(_, result)| result).call("vkCreatePipelines")?[0];
        context.count_pipeline();
        context.name(raw, stem);
        Ok(Self { raw, context: Arc::clone(context) })
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Pipeline {
        self.raw
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the pipeline before they drop it.
        self.context.destroy(|device| unsafe { device.destroy_pipeline(self.raw, None) });
    }
}
