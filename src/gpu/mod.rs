//! Vulkan evaluator: device, memory, pipelines and the stages that run on them.
//!
//! A stage carries one name everywhere: its shader in `shaders/`, its pipeline here, its CPU reference
//! in [`crate::cpu`], its debug label and its row of timings. The rooms, each of which knows only those
//! before it: `vulkan`, `scene`, `view`, `measure`, the evaluators, `engine`.

mod engine;
mod evaluator;
pub mod layout;
mod measure;
mod readback;
mod scene;
pub mod shaders;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod view;
mod vulkan;

pub use engine::picture_evaluator::PictureEvaluator;
pub use engine::pictures::ImportedPictures;
pub use engine::surface::{EngineImage, ImportedSurface, SurfaceImages};
pub use engine::surface_evaluator::SurfaceEvaluator;
pub use evaluator::GpuEvaluator;
pub use evaluator::plan::MemoryPlan;
pub use measure::generation::ScoreTarget;
pub use readback::ReadbackEvaluator;
pub use vulkan::allocator::{Access, DeviceAllocator, DeviceMemory, MemoryRequest};
pub use vulkan::borrowed::{BorrowedDevice, QueueLock};
pub use vulkan::choice::{ComputeShape, PipelineKind, ShadowMaker};
pub use vulkan::context::{Context, Counters};
pub use vulkan::devices::{DeviceChoice, DeviceReport, devices};
pub use vulkan::features::{EnabledFeatures, FeatureChain};
pub use vulkan::requirements::{Limit, Needs, Requirements};
pub use vulkan::tuning::{ContextOptions, Tuning};
pub use vulkan::usage::MemoryUse;
