//! A compute stage as it is recorded.

use super::pipeline::{Pipeline, PipelineLayout};
use crate::gpu::Context;
use ash::vk;

/// One run of a compute stage.
pub struct Dispatch<'a> {
    /// The stage.
    pub pipeline: &'a Pipeline,
    /// The layout that it was made for.
    pub layout: PipelineLayout,
    /// Set 0 and those behind it.
    pub sets: &'a [vk::DescriptorSet],
    /// Offsets of the dynamic buffers in them, bytes.
    pub offsets: &'a [u32],
    /// Push constants, whole, and who reads them.
    pub push: Option<(vk::ShaderStageFlags, &'a [u8])>,
    /// Work groups along each axis.
    pub groups: [u32; 3],
}

impl Context {
    /// Records a compute stage. What it reads must be visible to compute shaders.
    pub(in crate::gpu) fn dispatch(&self, cmd: vk::CommandBuffer, run: &Dispatch<'_>) {
        let device = self.recorder();
        let (point, layout) = (vk::PipelineBindPoint::COMPUTE, run.layout.raw());
        let [x, y, z] = run.groups;
        // SAFETY: `cmd` is being recorded on this device; pipeline, sets, offsets and push constants are those
        // of the layout, and whoever records keeps them.
        unsafe {
            device.cmd_bind_pipeline(cmd, point, run.pipeline.raw());
            device.cmd_bind_descriptor_sets(cmd, point, layout, 0, run.sets, run.offsets);
            if let Some((stages, bytes)) = run.push {
                device.cmd_push_constants(cmd, layout, stages, 0, bytes);
            }
            device.cmd_dispatch(cmd, x, y, z);
        }
    }
}
