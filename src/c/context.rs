//! A Vulkan device to work on: klieg's own, or an engine's.

use super::device::{borrowed, klieg_device};
use super::edge::{
    self, Fault, Opaque, Outcome, array, body, choice, destroy, free_call, given, make, put, text,
};
use super::error::*;
use super::requirements::{as_needs, klieg_needs};
use crate::gpu::{ComputeShape, Context, ContextOptions, DeviceChoice, PipelineKind, Tuning};
use std::ffi::{CString, c_char, c_void};
use std::sync::Arc;

/// A Vulkan device, one queue of it, and memory. Threads may share it, each with evaluators of its own.
/// What is made on it holds it: it may be destroyed first.
pub struct klieg_context(());

pub(super) struct ContextBody {
    pub context: Arc<Context>,
    device_name: CString,
}

impl Opaque for klieg_context {
    type Body = ContextBody;
    const SHARED: bool = true;
}

/// How populations are measured: one of `KLIEG_PIPELINE_...`.
pub type klieg_pipeline = i32;
/// The fastest for the device.
pub const KLIEG_PIPELINE_AUTO: klieg_pipeline = 0;
/// Compute shaders, over object pixels alone.
pub const KLIEG_PIPELINE_COMPUTE: klieg_pipeline = 1;
/// Layered draws of the stored surface; needs `KLIEG_NEEDS_LAYERS`.
pub const KLIEG_PIPELINE_LAYERED: klieg_pipeline = 2;
/// Layered draws of the scene's geometry; needs `KLIEG_NEEDS_LAYERS`, and a scene.
pub const KLIEG_PIPELINE_FORWARD: klieg_pipeline = 3;

/// The shape of `KLIEG_PIPELINE_COMPUTE`: one of `KLIEG_SHAPE_...`.
pub type klieg_shape = i32;
/// The faster for the device.
pub const KLIEG_SHAPE_AUTO: klieg_shape = 0;
/// Runs of pixels, without shared memory: for software devices.
pub const KLIEG_SHAPE_RUNS: klieg_shape = 1;
/// Tiles in shared memory: for GPUs.
pub const KLIEG_SHAPE_TILES: klieg_shape = 2;

/// How the evaluators of a context work.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_tuning {
    /// Bytes of device memory for the pictures of a population, at most; 0 for half of the device's.
    pub picture_memory: u64,
    /// How populations are measured.
    pub pipeline: klieg_pipeline,
    /// The shape of pipeline `compute`.
    pub shape: klieg_shape,
    /// What `klieg_context_pipeline_cache` gave earlier, read during the call: pipelines that are in it need
    /// not be compiled again. Data that are damaged, or of another device, driver or version of klieg are
    /// as good as none; `NULL` for none.
    pub pipeline_cache: *const c_void,
    /// Bytes of it.
    pub pipeline_cache_size: usize,
}

/// What klieg has made and read since the context began.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_counters {
    /// Buffers and images that got memory.
    pub allocations: u64,
    /// Pipelines.
    pub pipelines: u64,
    /// Descriptor sets, allocated or written anew.
    pub descriptors: u64,
    /// Bytes that the host read from the device's buffers.
    pub bytes_read: u64,
    /// Bytes of device memory that are taken at the moment, what the allocator keeps for later included.
    pub memory: u64,
    /// Bytes of `klieg_tuning::pipeline_cache` that the driver began with.
    pub pipeline_cache: u64,
}

/// Sets everything to be chosen by klieg. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_tuning_defaults(tuning: *mut klieg_tuning) -> klieg_status {
    let defaults = klieg_tuning {
        picture_memory: 0,
        pipeline: KLIEG_PIPELINE_AUTO,
        shape: KLIEG_SHAPE_AUTO,
        pipeline_cache: std::ptr::null(),
        pipeline_cache_size: 0,
    };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(tuning, defaults, "tuning") })
}

/// Makes a context on a device of klieg's own. Any thread.
///
/// `version` is `KLIEG_VERSION`. `device` is a part of the device's name or its number among the
/// machine's Vulkan devices, `NULL` for the best. `tuning` may be `NULL`, for the defaults.
///
/// `KLIEG_ERROR_VERSION` for a program that was built for another klieg; `KLIEG_ERROR_NO_VULKAN` without
/// a Vulkan loader or device; `KLIEG_ERROR_UNSUPPORTED` for a device that lacks something.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_create(
    version: u32,
    device: *const c_char,
    tuning: *const klieg_tuning,
    context: *mut *mut klieg_context,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(context, || {
            check_version(version)?;
            let device = match text(device, "device")? {
                "" => DeviceChoice::Best,
                name => match name.parse() {
                    Ok(index) => DeviceChoice::Index(index),
                    Err(_) => DeviceChoice::Name(name.into()),
                },
            };
            let tuning = as_tuning(tuning)?;
            Ok(body_of(Context::new(&ContextOptions { device, tuning, ..Default::default() })?))
        })
    }
}

/// Makes a context on an engine's device, which stays the engine's: klieg destroys what it makes itself,
/// and no more. Any thread.
///
/// The handles of `device` are valid and belong together, and its features are enabled. They stay valid
/// until the context and everything that was made on it are destroyed, or until
/// `klieg_context_forget_device`. Other threads use the queue only with the lock held.
///
/// `version` is `KLIEG_VERSION`; `tuning` may be `NULL`, for the defaults.
///
/// `KLIEG_ERROR_VERSION` for a program that was built for another klieg; `KLIEG_ERROR_UNSUPPORTED` with
/// all that the device, its queue or its enabled features lack for `needs`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_borrow(
    version: u32,
    device: *const klieg_device,
    needs: klieg_needs,
    tuning: *const klieg_tuning,
    context: *mut *mut klieg_context,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the device.
    unsafe {
        make(context, || {
            check_version(version)?;
            let (needs, tuning) = (as_needs(needs)?, as_tuning(tuning)?);
            let device = borrowed(given(device, "device")?)?;
            Ok(body_of(Context::borrow(device, needs, &tuning)?))
        })
    }
}

/// Gives the context up; `NULL` is left alone. It goes when everything that was made on it has gone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_destroy(context: *mut klieg_context) {
    // SAFETY: the caller's handle.
    unsafe { destroy(context) };
}

/// Says that the device is gone, or soon will be, before all that klieg made on it: from now on klieg
/// makes no Vulkan call. What it had made on the device is leaked there; everything but destroying fails
/// with `KLIEG_ERROR_FORGOTTEN`. Any thread, while no other call on this device is under way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_forget_device(
    context: *const klieg_context,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's handle.
        unsafe { body(context, "context") }?.context.forget_device();
        Ok(())
    })
}

/// The device's name: UTF-8, valid until the context is destroyed; empty where `context` is `NULL`. Any
/// thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_device_name(context: *const klieg_context) -> *const c_char {
    // SAFETY: the caller's handle.
    let body = unsafe { body(context, "context") };
    body.map_or(c"".as_ptr(), |body| body.device_name.as_ptr())
}

/// Tells what klieg has made and read so far. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_counters(
    context: *const klieg_context,
    counters: *mut klieg_counters,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's handle.
        let context = &unsafe { body(context, "context") }?.context;
        let made = context.counters();
        let told = klieg_counters {
            allocations: made.allocations,
            pipelines: made.pipelines,
            descriptors: made.descriptors,
            bytes_read: made.bytes_read,
            memory: context.memory_taken(),
            pipeline_cache: made.pipeline_cache,
        };
        // SAFETY: the caller's pointer.
        unsafe { put(counters, told, "counters") }
    })
}

/// Gives the pipelines compiled so far, and those of earlier runs, for `klieg_tuning::pipeline_cache` of a
/// later one: `*size` bytes, written to `data` where it has `room` for them. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` where `room` is not enough; `*size` is told all the same. `data` may be `NULL`
/// where `room` is 0, which asks for the size alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_context_pipeline_cache(
    context: *const klieg_context,
    data: *mut c_void,
    room: usize,
    size: *mut usize,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's handle and pointers.
        unsafe {
            put(size, 0, "size")?;
            let compiled = body(context, "context")?.context.pipeline_cache_data()?;
            put(size, compiled.len(), "size")?;
            if room == 0 {
                return Ok(());
            }
            let room = edge::room(data.cast::<u8>(), room, "data")?;
            let Some(place) = room.get_mut(..compiled.len()) else {
                let text = format!("data has room for {} of {} bytes", room.len(), compiled.len());
                return Err(Fault::argument(text));
            };
            place.copy_from_slice(&compiled);
            Ok(())
        }
    })
}

/// A program built for `version` finds here what it expects: all of its own minor version, and no more
/// than compatible changes.
pub(super) fn check_version(version: u32) -> Outcome {
    let (major, rest) = (version / 1_000_000, version % 1_000_000);
    let minor = rest / 1_000;
    let same_major = major == KLIEG_VERSION_MAJOR;
    let speaks = match major {
        0 => same_major && minor == KLIEG_VERSION_MINOR,
        _ => same_major && minor <= KLIEG_VERSION_MINOR,
    };
    match speaks {
        true => Ok(()),
        false => Err(Fault::new(
            KLIEG_ERROR_VERSION,
            format!(
                "the program was built for klieg {major}.{minor}, this is {}",
                env!("CARGO_PKG_VERSION")
            ),
        )),
    }
}

/// # Safety
/// `tuning` is `NULL` or valid, and so is what it points to.
unsafe fn as_tuning(tuning: *const klieg_tuning) -> Outcome<Tuning> {
    use PipelineKind::{Compute, Forward, Layered};
    let pipelines = [None, Some(Compute), Some(Layered), Some(Forward)];
    let shapes = [None, Some(ComputeShape::Runs), Some(ComputeShape::Tiles)];
    // SAFETY: the caller's promise.
    match unsafe { tuning.as_ref() } {
        None => Ok(Tuning::default()),
        Some(tuning) => {
            let (data, size) = (tuning.pipeline_cache.cast::<u8>(), tuning.pipeline_cache_size);
            Ok(Tuning {
                any_lights: false,
                shadow_maker: None,
                picture_memory: (tuning.picture_memory > 0).then_some(tuning.picture_memory),
                pipeline: choice(&pipelines, tuning.pipeline, "pipeline")?,
                shape: choice(&shapes, tuning.shape, "shape")?,
                // SAFETY: the caller's promise.
                pipeline_cache: unsafe { array(data, size, "pipeline_cache") }?.to_vec(),
            })
        }
    }
}

fn body_of(context: Arc<Context>) -> ContextBody {
    let device_name = CString::new(context.report().info.name.as_str()).unwrap_or_default();
    ContextBody { context, device_name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_for_other_versions_are_refused() {
        assert!(check_version(KLIEG_VERSION).is_ok());
        assert!(check_version(KLIEG_VERSION + 1).is_ok(), "a patch changes nothing here");
        for other in [0, KLIEG_VERSION + 1_000, KLIEG_VERSION + 1_000_000] {
            assert!(check_version(other).is_err(), "{other}");
        }
    }
}
