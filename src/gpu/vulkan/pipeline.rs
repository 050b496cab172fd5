//! Descriptor sets, pipeline layouts and compute pipelines.

use super::cache::PipelineKey;
use super::memory::{Buffer, Image, TexelBuffer};
use crate::Result;
use crate::gpu::Context;
use crate::gpu::vulkan::Call;
use ash::vk;
use std::ffi::CStr;
use std::sync::Arc;

/// The entry point of every shader.
const MAIN: &CStr = c"main";

/// A binding of a set: its number, its kind, and the stages that may use it.
pub type Binding = (u32, vk::DescriptorType, vk::ShaderStageFlags);

/// The layout of sets with `bindings`, which the context keeps.
///
/// # Errors
/// [`crate::Error::Vulkan`].
pub fn set_layout(context: &Context, bindings: &[Binding]) -> Result<vk::DescriptorSetLayout> {
    context.cache().set_layouts.get(bindings.to_vec(), || {
        let of = |&(binding, kind, stages): &Binding| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(stages)
        };
        let bindings: Vec<_> = bindings.iter().map(of).collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the device is alive; `info` is complete.
        unsafe { context.device()?.create_descriptor_set_layout(&info, None) }
            .call("vkCreateDescriptorSetLayout")
    })
}

/// A descriptor set and its layout.
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
            layout: set_layout(context, bindings)?,
            pool: vk::DescriptorPool::null(),
            raw: vk::DescriptorSet::null(),
            bindings: bindings.to_vec(),
            context: Arc::clone(context),
        };
        let size =
            |&(_, kind, _): &Binding| vk::DescriptorPoolSize { ty: kind, descriptor_count: 1 };
        let sizes: Vec<_> = bindings.iter().map(size).collect();
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let device = context.device()?;
        // SAFETY: the device is alive; every info is complete; a half-made `set` is dropped on
        // failure.
        unsafe {
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
        // SAFETY: set and buffer are alive, and the set is not in use.
        unsafe { self.context.write_descriptor(write) };
    }

    /// Puts the texels of a buffer at `binding`. The set must not be in use.
    pub fn write_texels(&mut self, binding: u32, texels: &TexelBuffer) {
        let views = [texels.view()];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.raw)
            .dst_binding(binding)
            .descriptor_type(self.kind(binding))
            .texel_buffer_view(&views);
        // SAFETY: set and view are alive, and the set is not in use.
        unsafe { self.context.write_descriptor(write) };
    }

    /// Puts an image in `layout` at `binding`. The set must not be in use.
    pub fn write_image(&mut self, binding: u32, image: &Image, layout: vk::ImageLayout) {
        self.write_view(binding, image.view(), layout);
    }

    /// Puts the image of a view, in `layout`, at `binding`. The set must not be in use.
    pub fn write_view(&mut self, binding: u32, view: vk::ImageView, layout: vk::ImageLayout) {
        let info = [vk::DescriptorImageInfo::default().image_view(view).image_layout(layout)];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.raw)
            .dst_binding(binding)
            .descriptor_type(self.kind(binding))
            .image_info(&info);
        // SAFETY: set and view are alive, and the set is not in use.
        unsafe { self.context.write_descriptor(write) };
    }
}

impl Context {
    /// Puts something at a binding, unless there is nothing on a dry context.
    ///
    /// # Safety
    /// The set and what is put there are alive, and the set is not in use.
    pub(in crate::gpu) unsafe fn write_descriptor(&self, write: vk::WriteDescriptorSet<'_>) {
        self.count_descriptors();
        if !self.is_dry() {
            // SAFETY: as the caller promises.
            self.unless_gone(|device| unsafe { device.update_descriptor_sets(&[write], &[]) });
        }
    }
}

impl Drop for DescriptorSet {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the set; a null handle is allowed.
        self.context
            .unless_gone(|device| unsafe { device.destroy_descriptor_pool(self.pool, None) });
    }
}

/// What pipelines take: descriptor sets and push constants. The context keeps it.
#[derive(Clone, Copy)]
pub struct PipelineLayout(vk::PipelineLayout);

impl PipelineLayout {
    /// A layout of sets with the layouts `sets`, in order, and `push_bytes` of push constants for
    /// `push_stages`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Context,
        sets: &[vk::DescriptorSetLayout],
        push_stages: vk::ShaderStageFlags,
        push_bytes: u32,
    ) -> Result<Self> {
        let key = (sets.to_vec(), push_stages, push_bytes);
        let make = || {
            let push =
                [vk::PushConstantRange { stage_flags: push_stages, offset: 0, size: push_bytes }];
            let push = if push_bytes == 0 { &[][..] } else { &push[..] };
            let info = vk::PipelineLayoutCreateInfo::default()
                .set_layouts(sets)
                .push_constant_ranges(push);
            // SAFETY: the device and the set layouts are alive.
            unsafe { context.device()?.create_pipeline_layout(&info, None) }
                .call("vkCreatePipelineLayout")
        };
        context.cache().layouts.get(key, make).map(Self)
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::PipelineLayout {
        self.0
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
        let raw = unsafe { context.device()?.create_shader_module(&info, None) }
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
        self.context.unless_gone(|device| unsafe { device.destroy_shader_module(self.raw, None) });
    }
}

/// What pipelines are specialised to of a population's rigs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RigKind {
    /// Lights of each.
    pub lights: usize,
    /// Whether shadows of lights that stand within the scene have to be traced.
    pub near: bool,
}

/// Pipelines that are specialised to rigs.
#[derive(Default)]
pub struct ByRigs(Vec<(RigKind, Pipeline)>);

impl ByRigs {
    /// Makes the pipeline for some rigs, unless it is there.
    ///
    /// # Errors
    /// What `make` reports.
    pub fn prepare(
        &mut self,
        rigs: RigKind,
        make: impl FnOnce() -> Result<Pipeline>,
    ) -> Result<()> {
        if !self.has(rigs) {
            self.0.push((rigs, make()?));
        }
        Ok(())
    }

    /// Whether such rigs were prepared.
    pub fn has(&self, rigs: RigKind) -> bool {
        self.0.iter().any(|(kind, _)| *kind == rigs)
    }

    /// The pipeline for rigs that were prepared.
    pub fn of(&self, rigs: RigKind) -> &Pipeline {
        let found = self.0.iter().find(|(kind, _)| *kind == rigs);
        &found.expect("prepared rigs").1
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

/// A pipeline, which the context keeps.
#[derive(Clone, Copy)]
pub struct Pipeline(vk::Pipeline);

impl Pipeline {
    /// A compute stage, made now unless the context has it: shader `spirv`, always the same for a
    /// stem, with its specialisation constants.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn compute(
        context: &Arc<Context>,
        stem: &'static str,
        spirv: &[u32],
        layout: &PipelineLayout,
        constants: &[u32],
    ) -> Result<Self> {
        Self::compute_in_subgroups(context, stem, spirv, layout, constants, None)
    }

    /// The same whose subgroups, all full, have the `required` size, where that is given: always the same
    /// for the other arguments.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn compute_in_subgroups(
        context: &Arc<Context>,
        stem: &'static str,
        spirv: &[u32],
        layout: &PipelineLayout,
        constants: &[u32],
        required: Option<u32>,
    ) -> Result<Self> {
        let pass = vk::RenderPass::null();
        let key = PipelineKey { stem, constants: constants.to_vec(), layout: layout.0, pass };
        Self::cached(context, key, || {
            let module = ShaderModule::new(context, spirv)?;
            let specialization = Specialization::new(constants);
            let specialization = specialization.info();
            let mut stage = shader_stage(vk::ShaderStageFlags::COMPUTE, &module, &specialization);
            let mut size = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default();
            if let Some(required) = required {
                size.required_subgroup_size = required;
                stage.p_next = (&raw const size).cast();
                stage.flags |= vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS;
            }
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.0)];
            let cache = context.cache().compiled.raw;
            // SAFETY: module, layout and size are alive, and the shader was written for the layout; a size
            // is required only where the feature is enabled and the device offers it.
            let made = unsafe { context.device()?.create_compute_pipelines(cache, &info, None) };
            made.map(|made| made[0]).map_err(|(_, result)| result).call("vkCreateComputePipelines")
        })
    }

    /// The context's pipeline of `key`, made now unless it is there.
    ///
    /// # Errors
    /// What `make` reports.
    pub fn cached(
        context: &Context,
        key: PipelineKey,
        make: impl FnOnce() -> Result<vk::Pipeline>,
    ) -> Result<Self> {
        if context.is_dry() {
            return Ok(Self(vk::Pipeline::null()));
        }
        let stem = key.stem;
        let make = || {
            let raw = make()?;
            context.count_pipeline();
            context.name(raw, stem);
            Ok(raw)
        };
        context.cache().pipelines.get(key, make).map(Self)
    }

    /// The Vulkan handle.
    pub fn raw(&self) -> vk::Pipeline {
        self.0
    }
}
