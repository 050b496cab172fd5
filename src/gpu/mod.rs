//! Vulkan evaluator: device, memory, pipelines and the stages that run on them.
//!
//! A stage carries one name everywhere: its shader in `shaders/`, its pipeline here, its plain twin
//! in [`crate::cpu`], its debug label and its row of timings.

mod allocator;
mod borrowed;
mod cache;
mod choice;
mod commands;
mod context;
mod devices;
mod drawable;
mod drawn;
mod evaluator;
mod features;
mod forward;
mod generation;
mod geometry;
mod graphics;
mod home;
mod instance;
mod layered;
pub mod layout;
mod maps;
mod memory;
mod picture_evaluator;
mod pictures;
mod pipeline;
mod pixels;
mod population;
mod readback;
mod requirements;
mod runs;
pub mod shaders;
mod staging;
mod surface;
#[cfg(test)]
mod testing;
mod textures;
mod tiles;
mod view;
mod visibility;

pub use allocator::{Access, DeviceAllocator, DeviceMemory, MemoryRequest};
pub use borrowed::{BorrowedDevice, QueueLock};
pub use choice::{ComputeShape, PipelineKind};
pub use context::{Context, ContextOptions, Counters, Tuning};
pub use devices::{DeviceChoice, DeviceReport, devices};
pub use evaluator::GpuEvaluator;
pub use features::{EnabledFeatures, FeatureChain};
pub use generation::ScoreTarget;
pub use picture_evaluator::PictureEvaluator;
pub use pictures::ImportedPictures;
pub use readback::ReadbackEvaluator;
pub use requirements::{Limit, Needs, Requirements};
pub use surface::{EngineImage, ImportedSurface, SurfaceEvaluator, SurfaceImages};

use crate::{Error, Result};
use ash::vk;

/// Names the Vulkan call that a result belongs to.
trait Call<T> {
    /// The value, or [`Error::Vulkan`] with the call's name.
    fn call(self, call: &'static str) -> Result<T>;
}

impl<T> Call<T> for ash::prelude::VkResult<T> {
    fn call(self, call: &'static str) -> Result<T> {
        self.map_err(|result: vk::Result| Error::Vulkan { call, result })
    }
}
