//! The device: whose it is, what it can do, its memory, and the commands and pipelines that run on it.

pub mod allocator;
pub mod borrowed;
pub mod cache;
pub mod choice;
pub mod commands;
pub mod context;
pub mod devices;
pub mod dispatch;
pub mod features;
pub mod graphics;
pub mod instance;
pub mod memory;
pub mod owner;
pub mod pipeline;
pub mod pipeline_cache;
pub mod requirements;
pub mod staging;
pub mod timer;
pub mod tuning;
pub mod usage;

use crate::{Error, Result};
use ash::vk;

/// Names the Vulkan call that a result belongs to.
pub trait Call<T> {
    /// The value, or [`Error::Vulkan`] with the call's name.
    fn call(self, call: &'static str) -> Result<T>;
}

impl<T> Call<T> for ash::prelude::VkResult<T> {
    fn call(self, call: &'static str) -> Result<T> {
        self.map_err(|result: vk::Result| Error::Vulkan { call, result })
    }
}
