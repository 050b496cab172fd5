//! klieg on a device that an engine created and keeps.

use ash::vk;
use engine::{ALL, Engine, counted_lock};
use klieg::Error;
use klieg::evaluate::Evaluator;
use klieg::gpu::{
    BorrowedDevice, Context, DeviceAllocator, DeviceMemory, EnabledFeatures, GpuEvaluator,
    MemoryRequest, Needs, PipelineKind, Tuning,
};
use klieg::lighting::LightKind;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg_support::{engine, gpu as support};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use support::{ball, population, rigs, view};

fn borrow(device: BorrowedDevice, needs: Needs) -> klieg::Result<Arc<Context>> {
    // SAFETY: the tests keep the engine while they use the context, or forget the device.
    unsafe { Context::borrow(device, needs, &Tuning::default()) }
}

fn tuned(engine: &Engine, pipeline: PipelineKind) -> Arc<Context> {
    engine.context(&Tuning { pipeline: Some(pipeline), ..Tuning::default() })
}

fn evaluator(context: &Arc<Context>) -> klieg::Result<GpuEvaluator> {
    let (maps, view) = (ball(41, 33), view(41, 33, false));
    GpuEvaluator::with_maps(context, &maps, &view, Objective::default(), Shading::default())
}

fn scores(evaluator: &mut GpuEvaluator) -> klieg::Result<Vec<f32>> {
    let population = population(&rigs(5, 9, 2, LightKind::POINT));
    let mut scores = vec![0.0; population.len()];
    evaluator.evaluate(&population, &mut scores)?;
    Ok(scores)
}

#[test]
fn a_borrowed_device_gives_the_bits_of_an_own_one() {
    let engine = Engine::new(ALL);
    for pipeline in [PipelineKind::Layered, PipelineKind::Compute] {
        let own = support::with_tuning(Tuning { pipeline: Some(pipeline), ..Tuning::default() });
        let expected = scores(&mut evaluator(&own).unwrap()).unwrap();
        let context = tuned(&engine, pipeline);
        assert_eq!(scores(&mut evaluator(&context).unwrap()).unwrap(), expected);
    }
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn what_is_missing_is_named_all_at_once() {
    let engine = Engine::new(EnabledFeatures::default());
    let said = |device: BorrowedDevice, needs| match borrow(device, needs) {
        Err(error @ Error::Unsupported { .. }) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => String::new(),
    };
    let all = said(engine.lend(), Needs::ALL);
    for part in ["geometryShader", "shaderOutputLayer"] {
        assert!(all.contains(part), "{all}");
    }
    let scene = said(engine.lend(), Needs { scene: true, layers: false });
    assert!(scene.contains("geometryShader") && !scene.contains("shaderOutputLayer"), "{scene}");
    let layers = said(engine.lend(), Needs { scene: false, layers: true });
    assert!(layers.contains("shaderOutputLayer") && !layers.contains("geometry"), "{layers}");
    assert_eq!(said(engine.lend(), Needs::COMPUTE), "");
    let no_queue = BorrowedDevice { queue_family: 99, ..engine.lend() };
    let no_queue = said(no_queue, Needs::ALL);
    assert!(no_queue.contains("geometryShader") && no_queue.contains("a queue"), "{no_queue}");
    let old = BorrowedDevice { api_version: vk::API_VERSION_1_1, ..engine.lend() };
    assert!(said(old, Needs::COMPUTE).contains("Vulkan 1.2 (it has 1.1)"));
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn a_device_without_features_computes_and_draws_nothing() {
    let engine = Engine::new(EnabledFeatures::default());
    let context = engine.context_for(Needs::COMPUTE, &Tuning::default());
    assert!(scores(&mut evaluator(&context).unwrap()).is_ok());
    drop(context);
    let tuning = Tuning { pipeline: Some(PipelineKind::Layered), ..Tuning::default() };
    let context = engine.context_for(Needs::COMPUTE, &tuning);
    let error = evaluator(&context).err().expect("an error").to_string();
    assert!(error.contains("not imported for pictures drawn in layers"), "{error}");
    drop(context);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn submissions_hold_the_engines_lock() {
    let engine = Engine::new(ALL);
    let (lock, queue_lock) = counted_lock();
    let context = borrow(BorrowedDevice { queue_lock, ..engine.lend() }, Needs::ALL).unwrap();
    let mut evaluator = evaluator(&context).unwrap();
    let before = lock.taken.load(Ordering::Relaxed);
    scores(&mut evaluator).unwrap();
    scores(&mut evaluator).unwrap();
    assert_eq!(lock.taken.load(Ordering::Relaxed), before + 2);
    drop((evaluator, context));
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn threads_have_evaluators_of_their_own_on_one_device() {
    let engine = Engine::for_threads(ALL);
    let context = engine.context(&Tuning::default());
    let expected = scores(&mut evaluator(&context).unwrap()).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                let mut mine = evaluator(&context).unwrap();
                for _ in 0..3 {
                    assert_eq!(scores(&mut mine).unwrap(), expected);
                }
            });
        }
    });
    drop(context);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn klieg_first_leaves_the_engine_nothing_to_clean() {
    let engine = Engine::new(ALL);
    let context = engine.context(&Tuning::default());
    let evaluator = evaluator(&context).unwrap();
    drop(context);
    drop(evaluator);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn a_device_that_goes_first_is_forgotten() {
    let engine = Engine::new(ALL);
    let context = engine.context(&Tuning::default());
    let mut made = evaluator(&context).unwrap();
    scores(&mut made).unwrap();
    context.forget_device();
    // The layer names what klieg had made and leaves behind.
    assert!(engine.end().iter().any(|m| m.contains("vkDestroyDevice") || m.contains("leak")));
    assert!(matches!(scores(&mut made), Err(Error::Forgotten)));
    assert!(made.maps().is_ok(), "known maps need no device");
    assert!(matches!(evaluator(&context), Err(Error::Forgotten)));
    assert!(matches!(context.pipeline_cache_data(), Err(Error::Forgotten)));
    drop((made, context));
}

/// An engine's allocator: one block for each request.
struct OneByOne {
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    sizes: HashMap<u64, u64>,
    next: u64,
    alive: Arc<AtomicI64>,
    asked: Arc<Mutex<Vec<String>>>,
}

// SAFETY: every request has memory of its own.
unsafe impl DeviceAllocator for OneByOne {
    fn allocate(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<DeviceMemory, Box<dyn std::error::Error + Send + Sync>> {
        use klieg::gpu::Access;
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let wanted = match request.access {
            Access::Device => vk::MemoryPropertyFlags::DEVICE_LOCAL,
            Access::Upload | Access::Readback => host,
        };
        // SAFETY: the engine's device is alive; the info is complete.
        unsafe {
            let types = self.instance.get_physical_device_memory_properties(self.physical);
            let fits = |&i: &u32| {
                request.requirements.memory_type_bits >> i & 1 != 0
                    && types.memory_types[i as usize].property_flags.contains(wanted)
            };
            let kind = (0..types.memory_type_count).find(fits).ok_or("no memory type")?;
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(request.requirements.size)
                .memory_type_index(kind);
            let memory = self.device.allocate_memory(&info, None)?;
            let mapped = match request.access {
                Access::Device => None,
                _ => {
                    let flags = vk::MemoryMapFlags::empty();
                    let at = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, flags)?;
                    std::ptr::NonNull::new(at.cast())
                }
            };
            self.next += 1;
            self.sizes.insert(self.next, request.requirements.size);
            self.alive.fetch_add(1, Ordering::Relaxed);
            self.asked.lock().unwrap().push(request.name.to_owned());
            Ok(DeviceMemory { memory, offset: 0, mapped, token: self.next })
        }
    }

    fn free(&mut self, memory: DeviceMemory) {
        self.sizes.remove(&memory.token).expect("memory that was given");
        self.alive.fetch_sub(1, Ordering::Relaxed);
        // SAFETY: klieg has destroyed what was bound to it.
        unsafe { self.device.free_memory(memory.memory, None) };
    }

    fn capacity(&self) -> u64 {
        self.sizes.values().sum()
    }
}

#[test]
fn memory_can_come_from_the_engine() {
    let engine = Engine::new(ALL);
    let (alive, asked) = (Arc::<AtomicI64>::default(), Arc::<Mutex<Vec<String>>>::default());
    let allocator = OneByOne {
        instance: engine.instance.clone(),
        physical: engine.physical,
        device: engine.device.clone(),
        sizes: HashMap::new(),
        next: 0,
        alive: Arc::clone(&alive),
        asked: Arc::clone(&asked),
    };
    let device = BorrowedDevice { allocator: Some(Box::new(allocator)), ..engine.lend() };
    let context = borrow(device, Needs::ALL).unwrap();
    let mut made = evaluator(&context).unwrap();
    let expected = scores(&mut evaluator(&support::context()).unwrap()).unwrap();
    assert_eq!(scores(&mut made).unwrap(), expected);
    assert!(context.memory_taken() > 0 && alive.load(Ordering::Relaxed) > 5);
    assert!(asked.lock().unwrap().iter().any(|name| name == "lights"));
    drop((made, context));
    assert_eq!(alive.load(Ordering::Relaxed), 0);
    assert_eq!(engine.end(), [""; 0]);
}

static SUBMIT: OnceLock<vk::PFN_vkQueueSubmit> = OnceLock::new();
static LOST: AtomicBool = AtomicBool::new(false);

/// `vkQueueSubmit` of a device that may be lost.
unsafe extern "system" fn submit_unless_lost(
    queue: vk::Queue,
    count: u32,
    submits: *const vk::SubmitInfo<'_>,
    fence: vk::Fence,
) -> vk::Result {
    match SUBMIT.get() {
        // SAFETY: the caller's arguments for the function that they are meant for.
        Some(submit) if !LOST.load(Ordering::Relaxed) => unsafe {
            submit(queue, count, submits, fence)
        },
        _ => vk::Result::ERROR_DEVICE_LOST,
    }
}

#[test]
fn a_lost_device_is_an_error_and_may_be_dropped() {
    let engine = Engine::new(ALL);
    let mut lent = engine.lend();
    let _ = SUBMIT.set(engine.device.fp_v1_0().queue_submit);
    let get = engine.instance.fp_v1_0().get_device_proc_addr;
    // SAFETY: the function table is that of the engine's device, but for one function of the same type.
    lent.device = unsafe {
        ash::Device::load_with(
            |name| match name.to_bytes() {
                b"vkQueueSubmit" => submit_unless_lost as *const _,
                _ => get(engine.device.handle(), name.as_ptr())
                    .map_or(std::ptr::null(), |f| f as *const _),
            },
            engine.device.handle(),
        )
    };
    let context = borrow(lent, Needs::ALL).unwrap();
    let mut made = evaluator(&context).unwrap();
    scores(&mut made).unwrap();
    LOST.store(true, Ordering::Relaxed);
    for error in [scores(&mut made).err(), evaluator(&context).err()] {
        let error = error.expect("the device is lost");
        assert!(error.is_device_lost() && !error.is_input(), "{error}");
    }
    drop((made, context));
    assert_eq!(engine.end(), [""; 0]);
}

static BEGIN: OnceLock<vk::PFN_vkBeginCommandBuffer> = OnceLock::new();
static BARRIER: OnceLock<vk::PFN_vkCmdPipelineBarrier> = OnceLock::new();
/// Command buffers that were begun, and whether the last has had no barrier yet.
static BEGUN: AtomicU32 = AtomicU32::new(0);
static FRESH: AtomicBool = AtomicBool::new(false);
/// Command buffers whose first barrier is after everything.
static FOLLOWING: AtomicU32 = AtomicU32::new(0);

unsafe extern "system" fn begin(
    cmd: vk::CommandBuffer,
    info: *const vk::CommandBufferBeginInfo<'_>,
) -> vk::Result {
    BEGUN.fetch_add(1, Ordering::Relaxed);
    FRESH.store(true, Ordering::Relaxed);
    // SAFETY: the caller's arguments for the function that they are meant for.
    BEGIN.get().map_or(vk::Result::ERROR_UNKNOWN, |begin| unsafe { begin(cmd, info) })
}

unsafe extern "system" fn barrier(
    cmd: vk::CommandBuffer,
    before: vk::PipelineStageFlags,
    after: vk::PipelineStageFlags,
    flags: vk::DependencyFlags,
    memory_count: u32,
    memory: *const vk::MemoryBarrier<'_>,
    buffer_count: u32,
    buffers: *const vk::BufferMemoryBarrier<'_>,
    image_count: u32,
    images: *const vk::ImageMemoryBarrier<'_>,
) {
    let writers = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
    let everything = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    let memory_barriers = match memory_count {
        0 => &[],
        // SAFETY: so many barriers are there.
        count => unsafe { std::slice::from_raw_parts(memory, count as usize) },
    };
    let whole = memory_barriers
        .iter()
        .any(|m| m.src_access_mask.contains(everything) && m.dst_access_mask.contains(everything));
    if FRESH.swap(false, Ordering::Relaxed) && before.contains(writers) && whole {
        FOLLOWING.fetch_add(1, Ordering::Relaxed);
    }
    if let Some(barrier) = BARRIER.get() {
        // SAFETY: the caller's arguments for the function that they are meant for.
        unsafe {
            barrier(
                cmd,
                before,
                after,
                flags,
                memory_count,
                memory,
                buffer_count,
                buffers,
                image_count,
                images,
            );
        }
    }
}

#[test]
fn commands_begin_after_all_that_was_submitted_before() {
    let engine = Engine::new(ALL);
    let mut lent = engine.lend();
    let _ = BEGIN.set(engine.device.fp_v1_0().begin_command_buffer);
    let _ = BARRIER.set(engine.device.fp_v1_0().cmd_pipeline_barrier);
    let get = engine.instance.fp_v1_0().get_device_proc_addr;
    // SAFETY: the function table is that of the engine's device, but for functions of the same types.
    lent.device = unsafe {
        ash::Device::load_with(
            |name| match name.to_bytes() {
                b"vkBeginCommandBuffer" => begin as *const _,
                b"vkCmdPipelineBarrier" => barrier as *const _,
                _ => get(engine.device.handle(), name.as_ptr())
                    .map_or(std::ptr::null(), |f| f as *const _),
            },
            engine.device.handle(),
        )
    };
    let context = borrow(lent, Needs::ALL).unwrap();
    scores(&mut evaluator(&context).unwrap()).unwrap();
    let begun = BEGUN.load(Ordering::Relaxed);
    assert!(begun > 3);
    assert_eq!(FOLLOWING.load(Ordering::Relaxed), begun);
    drop(context);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn a_borrowed_device_begins_with_pipelines_of_an_earlier_run() {
    let engine = Engine::new(ALL);
    let context = engine.context(&Tuning::default());
    assert_eq!(context.counters().pipeline_cache, 0);
    let pipeline_cache = context.pipeline_cache_data().unwrap();
    let next =
        engine.context(&Tuning { pipeline_cache: pipeline_cache.clone(), ..Tuning::default() });
    assert!(next.counters().pipeline_cache >= 32);
    assert_eq!(next.pipeline_cache_data().unwrap(), pipeline_cache);
    drop((context, next));
    assert_eq!(engine.end(), [""; 0]);
}
