//! Timestamps of the stages.

use crate::Result;
use crate::gpu::Context;
use crate::gpu::vulkan::Call;
use ash::vk;
use std::sync::Arc;

/// Times the stages of recorded commands by GPU timestamps, where the queue has them.
pub struct StageTimer {
    pool: vk::QueryPool,
    capacity: u32,
    stems: Vec<&'static str>,
    ticks: Vec<[u64; 2]>,
    rows: Vec<(&'static str, f64)>,
    context: Arc<Context>,
}

impl StageTimer {
    /// A timer of at most `capacity` stages; one of none only labels them.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, capacity: u32) -> Result<Self> {
        let mut timer = Self {
            pool: vk::QueryPool::null(),
            capacity,
            stems: Vec::with_capacity(capacity as usize),
            ticks: Vec::with_capacity(capacity as usize),
            rows: Vec::new(),
            context: Arc::clone(context),
        };
        if capacity > 0 && context.report().timestamps {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(2 * capacity);
            // SAFETY: the device is alive; `info` is complete.
            timer.pool = unsafe { context.device()?.create_query_pool(&info, None) }
                .call("vkCreateQueryPool")?;
        }
        Ok(timer)
    }

    /// Forgets the stages; comes first in a recording.
    pub fn reset(&mut self, cmd: vk::CommandBuffer) {
        self.stems.clear();
        if self.pool != vk::QueryPool::null() {
            // SAFETY: `cmd` is being recorded on the pool's device.
            unsafe {
                self.context.recorder().cmd_reset_query_pool(cmd, self.pool, 0, 2 * self.capacity);
            }
        }
    }

    /// Records `body` as the stage `stem`, with its label and its two timestamps.
    pub fn stage(&mut self, cmd: vk::CommandBuffer, stem: &'static str, body: impl FnOnce()) {
        let timed = self.pool != vk::QueryPool::null() && self.stems.len() < self.capacity as usize;
        let query = 2 * self.stems.len() as u32;
        let stamp = |stage, query| {
            if timed {
                // SAFETY: `cmd` is being recorded, and the query was reset in it.
                unsafe {
                    self.context.recorder().cmd_write_timestamp(cmd, stage, self.pool, query);
                }
            }
        };
        self.context.labelled(cmd, stem, || {
            stamp(vk::PipelineStageFlags::TOP_OF_PIPE, query);
            body();
            stamp(vk::PipelineStageFlags::BOTTOM_OF_PIPE, query + 1);
        });
        if timed {
            self.stems.push(stem);
        }
    }

    /// Reads the times of the run that has ended; none where the queue has no timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read(&mut self) -> Result<()> {
        self.rows.clear();
        self.ticks.resize(self.stems.len(), [0; 2]);
        if self.stems.is_empty() {
            return Ok(());
        }
        let (device, flags) = (self.context.device()?, vk::QueryResultFlags::TYPE_64);
        let ticks = self.ticks.as_flattened_mut();
        // SAFETY: the pool holds two 64-bit queries for each stem.
        unsafe { device.get_query_pool_results(self.pool, 0, ticks, flags) }
            .call("vkGetQueryPoolResults")?;
        let period = f64::from(self.context.limits().timestamp_period) * 1e-6;
        for (&stem, &[begin, end]) in self.stems.iter().zip(&self.ticks) {
            let milliseconds = end.saturating_sub(begin) as f64 * period;
            match self.rows.iter_mut().find(|row| row.0 == stem) {
                Some(row) => row.1 += milliseconds,
                None => self.rows.push((stem, milliseconds)),
            }
        }
        Ok(())
    }

    /// Milliseconds of each stage, as read last, in order of first occurrence; a stage that ran
    /// several times counts with its sum.
    pub fn rows(&self) -> &[(&'static str, f64)] {
        &self.rows
    }
}

impl Drop for StageTimer {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work before they drop the timer; null is allowed.
        self.context.unless_gone(|device| unsafe { device.destroy_query_pool(self.pool, None) });
    }
}
