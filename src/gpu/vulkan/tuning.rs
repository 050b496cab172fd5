//! What a caller may choose of a device and of the evaluators on it.

use super::choice::{ComputeShape, PipelineKind, ShadowMaker};
use super::devices::DeviceChoice;
#[cfg(doc)]
use crate::gpu::Context;

/// How a [`Context`] on a device of its own is made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ContextOptions {
    /// Which device.
    pub device: DeviceChoice,
    /// Whether the validation layer, synchronisation included, watches every call: for tests. What
    /// it says is in [`Context::validation_messages`].
    pub validation: bool,
    /// How evaluators work.
    pub tuning: Tuning,
}

/// How the evaluators of a [`Context`] work.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tuning {
    /// Bytes for the pictures of a population, at most; a population that needs more is drawn in
    /// several parts. Half of the device's memory where not given.
    pub picture_memory: Option<u64>,
    /// How evaluators make the pictures; where not given the fastest for the device, or
    /// [`PipelineKind::Layered`] for a view with more object pixels than that can hold.
    pub pipeline: Option<PipelineKind>,
    /// The shape of [`PipelineKind::Compute`]; the faster for the device where not given.
    pub shape: Option<ComputeShape>,
    /// Who makes the shadow tables of scenes; the faster for the device where not given, and always the host
    /// where a scene is more than the device's buffers can hold.
    pub shadow_maker: Option<ShadowMaker>,
    /// Whether evaluators are made for coloured lights and spots from the start. An evaluator of a scene is
    /// made so when it first meets such a light; one that records into an engine's commands cannot be.
    pub any_lights: bool,
    /// What [`Context::pipeline_cache_data`] gave earlier: pipelines that are in it need not be compiled
    /// again. Data that are empty, damaged, or of another device, driver or version of klieg are as
    /// good as none.
    pub pipeline_cache: Vec<u8>,
}
