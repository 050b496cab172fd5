//! Compiled pipelines from one run to the next: the data of Vulkan's pipeline cache, with a header of
//! klieg's own before it.
//!
//! A driver may take any data that begins with its own header for good, so whatever was not written whole,
//! for this device and driver, by this version of klieg, is not handed on to it.

use super::Call;
use crate::Result;
use crate::gpu::Context;
use crate::hash::{FNV_START, fnv1a};
use ash::vk;
use bytemuck::{Pod, Zeroable};

const MAGIC: [u8; 8] = *b"klieg pc";

/// What stands before the driver's data.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    key: u64,
    length: u64,
    checksum: u64,
}

/// Names what compiled pipelines are good for: a device with its driver, and a version of klieg.
/// `physical` is a device of Vulkan 1.1 or later.
pub fn key(instance: &ash::Instance, physical: vk::PhysicalDevice) -> u64 {
    let mut ids = vk::PhysicalDeviceIDProperties::default();
    let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
    // SAFETY: `physical` is a device of `instance`; the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(physical, &mut chain) };
    let properties = chain.properties;
    let numbers = [properties.vendor_id, properties.device_id, properties.driver_version];
    let parts: [&[u8]; 5] = [
        env!("CARGO_PKG_VERSION").as_bytes(),
        bytemuck::bytes_of(&numbers),
        &properties.pipeline_cache_uuid,
        &ids.device_uuid,
        &ids.driver_uuid,
    ];
    parts.into_iter().fold(FNV_START, fnv1a)
}

/// The driver's data, with what is needed to know it again.
fn wrap(key: u64, data: &[u8]) -> Vec<u8> {
    let checksum = fnv1a(FNV_START, data);
    let header = Header { magic: MAGIC, key, length: data.len() as u64, checksum };
    [bytemuck::bytes_of(&header), data].concat()
}

/// The driver's data, if it is whole and for `key`.
fn unwrap(key: u64, wrapped: &[u8]) -> Option<&[u8]> {
    let (header, data) = wrapped.split_at_checked(size_of::<Header>())?;
    let header: Header = bytemuck::pod_read_unaligned(header);
    let whole = header.length == data.len() as u64 && header.checksum == fnv1a(FNV_START, data);
    (header.magic == MAGIC && header.key == key && whole).then_some(data)
}

/// Whether the data begin as the driver of `properties` begins them (Vulkan 1.3 specification,
/// `VkPipelineCacheHeaderVersionOne`).
fn is_of_driver(properties: &vk::PhysicalDeviceProperties, data: &[u8]) -> bool {
    let numbers = [32, 1, properties.vendor_id, properties.device_id];
    data.strip_prefix(bytemuck::bytes_of(&numbers))
        .is_some_and(|rest| rest.starts_with(&properties.pipeline_cache_uuid))
}

/// A context's pipeline cache.
#[derive(Default)]
pub struct PipelineCache {
    /// Null where the driver gives none, which only costs time.
    pub raw: vk::PipelineCache,
    /// Bytes that it began with.
    pub given: u64,
    key: u64,
}

impl PipelineCache {
    /// One that begins with what [`Context::pipeline_cache_data`] gave earlier, as far as that is of use.
    pub fn new(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        device: &ash::Device,
        earlier: &[u8],
    ) -> Self {
        let key = key(instance, physical);
        // SAFETY: `physical` is a device of the living instance.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let create = |data: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
            // SAFETY: the device is alive, and the data are empty or came whole from this driver.
            unsafe { device.create_pipeline_cache(&info, None) }
        };
        let data = unwrap(key, earlier).filter(|data| is_of_driver(&properties, data));
        let made = data.and_then(|data| Some((create(data).ok()?, data.len() as u64)));
        let (raw, given) = made.unwrap_or_else(|| (create(&[]).unwrap_or_default(), 0));
        Self { raw, given, key }
    }
}

impl Context {
    /// The pipelines compiled so far, and those of earlier runs, for
    /// [`Tuning::pipeline_cache`](crate::gpu::Tuning::pipeline_cache) of a later one. What these bytes are
    /// good for, [`DeviceReport::pipeline_cache_key`](crate::gpu::DeviceReport::pipeline_cache_key)
    /// names.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan), and [`Error::Forgotten`](crate::Error::Forgotten) after
    /// [`Context::forget_device`].
    pub fn pipeline_cache_data(&self) -> Result<Vec<u8>> {
        self.check_present()?;
        let cache = &self.cache().compiled;
        if cache.raw == vk::PipelineCache::null() {
            return Ok(wrap(cache.key, &[]));
        }
        // SAFETY: device and cache are alive.
        let data = unsafe { self.device()?.get_pipeline_cache_data(cache.raw) };
        Ok(wrap(cache.key, &data.call("vkGetPipelineCacheData")?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Tuning, testing};

    const KEY: u64 = 0x0123_4567_89ab_cdef;

    #[test]
    fn data_that_are_cut_changed_or_foreign_are_not_taken() {
        let data: Vec<u8> = (0..200).collect();
        let wrapped = wrap(KEY, &data);
        assert_eq!(unwrap(KEY, &wrapped), Some(&data[..]));
        assert_eq!(unwrap(KEY + 1, &wrapped), None);
        for length in 0..wrapped.len() {
            assert_eq!(unwrap(KEY, &wrapped[..length]), None, "{length}");
        }
        assert_eq!(unwrap(KEY, &[&wrapped[..], &[0]].concat()), None);
        for at in 0..wrapped.len() {
            let mut changed = wrapped.clone();
            changed[at] ^= 0x10;
            assert_eq!(unwrap(KEY, &changed), None, "{at}");
        }
    }

    fn context_with(pipeline_cache: Vec<u8>) -> std::sync::Arc<Context> {
        testing::with_tuning(Tuning { pipeline_cache, ..Tuning::default() })
    }

    #[test]
    fn a_driver_gets_nothing_that_begins_otherwise_than_its_own() {
        let first = context_with(Vec::new());
        let key = first.report().pipeline_cache_key;
        let data = first.pipeline_cache_data().unwrap();
        let driver = unwrap(key, &data).expect("whole data");
        assert!(driver.len() >= 32);
        for at in 0..32 {
            let mut changed = driver.to_vec();
            changed[at] ^= 1;
            let begun = context_with(wrap(key, &changed)).counters().pipeline_cache;
            assert_eq!(begun, 0, "{at}");
        }
        let second = context_with(data.clone());
        assert_eq!(second.counters().pipeline_cache, driver.len() as u64);
        testing::assert_valid(&second);
    }
}
