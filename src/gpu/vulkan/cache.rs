//! What a context keeps and lends out again: the layouts, render passes and pipelines of all
//! evaluators, each made once.
//!
//! None of them depends on a scene or on a picture's size, so there are few: every stage's, and
//! those of some stages once more for each number of lights a rig.

use super::pipeline::Binding;
use super::pipeline_cache::PipelineCache;
use crate::Result;
#[cfg(doc)]
use crate::gpu::Context;
use ash::vk;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What pipelines of the same device differ in.
#[derive(PartialEq, Eq, Hash)]
pub struct PipelineKey {
    /// The stage's stem, which stands for its shaders and their fixed state.
    pub stem: &'static str,
    /// Specialisation constants.
    pub constants: Vec<u32>,
    /// Sets and push constants.
    pub layout: vk::PipelineLayout,
    /// Null for a compute stage.
    pub pass: vk::RenderPass,
}

/// All that a [`Context`] keeps. The handles are valid as long as it lives.
#[derive(Default)]
pub struct Cache {
    /// By bindings.
    pub set_layouts: Kept<Vec<Binding>, vk::DescriptorSetLayout>,
    /// By set layouts, and stages and bytes of the push constants.
    pub layouts:
        Kept<(Vec<vk::DescriptorSetLayout>, vk::ShaderStageFlags, u32), vk::PipelineLayout>,
    /// By the stem of the stage that draws, and the attachments' formats.
    pub passes: Kept<(&'static str, Vec<vk::Format>), vk::RenderPass>,
    /// By all that they differ in.
    pub pipelines: Kept<PipelineKey, vk::Pipeline>,
    /// What the driver has compiled for them, in this run and in earlier ones.
    pub compiled: PipelineCache,
}

impl Cache {
    /// The bindings of each pipeline layout, all sets together.
    #[cfg(test)]
    pub fn bound(&self) -> Vec<Vec<Binding>> {
        let sets = self.set_layouts.lock();
        let of_set = |wanted: &vk::DescriptorSetLayout| {
            let found = sets.iter().find(|(_, layout)| *layout == wanted);
            found.map_or(Vec::new(), |(bindings, _)| bindings.clone())
        };
        self.layouts
            .lock()
            .keys()
            .map(|(sets, ..)| sets.iter().flat_map(of_set).collect())
            .collect()
    }

    /// Destroys everything.
    ///
    /// # Safety
    /// No work on `device`, from which all of it came, may use it any more.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the handles are the device's and unused, as the caller promises, and none stays
        // behind to be destroyed twice.
        unsafe {
            self.pipelines.drain(|pipeline| device.destroy_pipeline(pipeline, None));
            self.passes.drain(|pass| device.destroy_render_pass(pass, None));
            self.layouts.drain(|layout| device.destroy_pipeline_layout(layout, None));
            self.set_layouts.drain(|layout| device.destroy_descriptor_set_layout(layout, None));
            device.destroy_pipeline_cache(self.compiled.raw, None);
        }
    }
}

/// Handles by what they were made of.
pub struct Kept<K, H>(Mutex<HashMap<K, H>>);

impl<K, H> Default for Kept<K, H> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, H: Copy> Kept<K, H> {
    /// The handle of `key`, made now unless it is there. Threads that ask at once wait for each
    /// other, so that none makes it twice.
    ///
    /// # Errors
    /// What `make` reports.
    pub fn get(&self, key: K, make: impl FnOnce() -> Result<H>) -> Result<H> {
        let mut kept = self.lock();
        if let Some(handle) = kept.get(&key) {
            return Ok(*handle);
        }
        let handle = make()?;
        kept.insert(key, handle);
        Ok(handle)
    }

    fn drain(&self, destroy: impl FnMut(H)) {
        self.lock().drain().map(|(_, handle)| handle).for_each(destroy);
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<K, H>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
