//! Evaluators: lights in, scores out.

use super::camera::{as_camera, klieg_camera};
use super::context::{check_version, klieg_context};
use super::edge::{Fault, Opaque, Outcome, body, call, destroy, given, make, put, room};
use super::error::klieg_status;
use super::light::{frame, klieg_frame, klieg_light, population};
use super::scene::klieg_scene;
use super::settings::{
    as_objective, as_shading, klieg_objective, klieg_quality, klieg_shading, write_qualities,
};
use super::shadows::{as_shadows, klieg_shadows};
use crate::cpu::{self, CpuEvaluator};
use crate::design::start;
use crate::evaluate::Evaluator;
use crate::gpu::{GpuEvaluator, PictureEvaluator, ScoreTarget, SurfaceEvaluator};
use crate::lighting::genome::Genome;
use crate::math::frame::Frame;
use crate::objective::maps::Maps;
use crate::scene::Scene;
use crate::scene::view::View;
use ash::vk;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::{AtomicU64, Ordering};

/// Measures lights against a view. There are three levels, by what the engine gives:
/// 1. a scene and a camera (`klieg_evaluator_of_scene`, or `klieg_evaluator_on_cpu` without any Vulkan device): klieg
///    draws them itself;
/// 2. the surface that the engine has drawn (`klieg_evaluator_of_surface`): klieg shades it;
/// 3. the surface, and pictures of it under lights (`klieg_evaluator_of_pictures`): klieg judges them.
///
/// One thread at a time. Functions that record never submit, wait or make anything. Functions that evaluate,
/// and those that make an evaluator, submit to the context's queue and wait.
pub struct klieg_evaluator(());

pub(super) struct EvaluatorBody {
    pub level: Level,
    /// Tells evaluators apart.
    pub number: u64,
}

pub(super) enum Level {
    Scene(Box<GpuEvaluator>, Frame),
    Cpu(Box<CpuEvaluator>, Frame),
    Surface(Box<SurfaceEvaluator>),
    Pictures(Box<PictureEvaluator>),
}

impl Opaque for klieg_evaluator {
    type Body = EvaluatorBody;
}

impl EvaluatorBody {
    pub fn new(level: Level) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { level, number: NEXT.fetch_add(1, Ordering::Relaxed) }
    }

    /// What measures lights.
    pub fn of_lights(&mut self) -> Outcome<&mut dyn Evaluator> {
        match &mut self.level {
            Level::Cpu(evaluator, _) => Ok(&mut **evaluator),
            level => Ok(on_device(level)?),
        }
    }

    /// What measures lights on a Vulkan device.
    fn on_device(&mut self) -> Outcome<&mut GpuEvaluator> {
        on_device(&mut self.level)
    }

    fn maps(&mut self) -> Outcome<&Maps> {
        Ok(match &mut self.level {
            Level::Scene(evaluator, _) => evaluator.maps()?,
            Level::Cpu(evaluator, _) => evaluator.maps()?,
            Level::Surface(evaluator) => evaluator.evaluator().maps()?,
            Level::Pictures(evaluator) => evaluator.maps()?,
        })
    }

    /// The light frame; `None` before the first view.
    fn frame(&self) -> Option<&Frame> {
        match &self.level {
            Level::Scene(_, frame) | Level::Cpu(_, frame) => Some(frame),
            Level::Surface(evaluator) => evaluator.view().map(|view| &view.frame),
            Level::Pictures(evaluator) => evaluator.view().map(|view| &view.frame),
        }
    }

    /// The lights that k-means of the visible surface's normals suggests.
    pub fn suggestion(&mut self, genome: &Genome, seed: u64) -> Outcome<Vec<f32>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Ok(start::first_of_surface(self.maps()?, genome, &mut rng))
    }
}

/// A finished scene, and the view of it through a camera.
unsafe fn viewed<'a>(
    scene: *const klieg_scene,
    camera: *const klieg_camera,
    [width, height]: [u32; 2],
) -> Outcome<(&'a Scene, View)> {
    // SAFETY: the caller's pointers.
    unsafe {
        let scene = body(scene, "scene")?.finished()?;
        let camera = as_camera(given(camera, "camera")?)?;
        Ok((scene, View::new(scene, camera, width, height)?))
    }
}

/// Makes an evaluator of level 1: of a finished scene, through a camera, at `width` by `height` pixels.
/// It draws the scene, and keeps nothing of it that the caller has. `objective`, `shading` and `shadows` may be
/// `NULL`, for the defaults. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for a picture larger than the device can draw, `KLIEG_ERROR_UNSUPPORTED` on a
/// device that was not borrowed with `KLIEG_NEEDS_SCENE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_of_scene(
    context: *const klieg_context,
    scene: *const klieg_scene,
    camera: *const klieg_camera,
    width: u32,
    height: u32,
    objective: *const klieg_objective,
    shading: *const klieg_shading,
    shadows: *const klieg_shadows,
    evaluator: *mut *mut klieg_evaluator,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(evaluator, || {
            let context = &body(context, "context")?.context;
            let (scene, view) = viewed(scene, camera, [width, height])?;
            let (objective, shading) = (as_objective(objective)?, as_shading(shading)?);
            let (both, shadows) = ((objective, shading), as_shadows(shadows)?);
            let made = GpuEvaluator::with_shadows(context, scene, &view, both, &shadows)?;
            Ok(EvaluatorBody::new(Level::Scene(Box::new(made), view.frame)))
        })
    }
}

/// Makes an evaluator of level 1 that works on the CPU: no Vulkan device and no context are needed. Everything else is
/// as with `klieg_evaluator_of_scene`, and scores are the same to 1e-4. It uses all processors. What records does not
/// work with it. Any thread.
///
/// `version` is `KLIEG_VERSION`. `KLIEG_ERROR_VERSION` for a program that was built for another klieg,
/// `KLIEG_ERROR_ARGUMENT` as with `klieg_evaluator_of_scene`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_on_cpu(
    version: u32,
    scene: *const klieg_scene,
    camera: *const klieg_camera,
    width: u32,
    height: u32,
    objective: *const klieg_objective,
    shading: *const klieg_shading,
    shadows: *const klieg_shadows,
    evaluator: *mut *mut klieg_evaluator,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(evaluator, || {
            check_version(version)?;
            let (scene, view) = viewed(scene, camera, [width, height])?;
            let (objective, shading) = (as_objective(objective)?, as_shading(shading)?);
            let maps = cpu::draw(scene, &view, &objective, (&as_shadows(shadows)?, None))?;
            let made = CpuEvaluator::new(maps, &view, objective, shading)?;
            Ok(EvaluatorBody::new(Level::Cpu(Box::new(made), view.frame)))
        })
    }
}

/// Ends the evaluator; `NULL` is left alone. None of its recordings may be in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_destroy(evaluator: *mut klieg_evaluator) {
    // SAFETY: the caller's handle.
    unsafe { destroy(evaluator) };
}

/// Gives the light frame of the view that was made or recorded last: all lights stand in it.
///
/// `KLIEG_NOTHING_YET` before the first view of an evaluator of level 2 or 3.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_frame(
    evaluator: *mut klieg_evaluator,
    into: *mut klieg_frame,
) -> klieg_status {
    let tell = |evaluator: &mut EvaluatorBody| match evaluator.frame() {
        // SAFETY: the caller's pointer.
        Some(found) => unsafe { put(into, frame(found), "the place for the frame") },
        None => Err(Fault::nothing_yet()),
    };
    // SAFETY: the caller's handle.
    unsafe { call(evaluator, tell) }
}

/// Makes memory and pipelines for populations of up to `rigs` rigs of `lights_per_rig` lights, so that recording
/// finds all that it needs. None of the evaluator's recordings may be in use. At level 3, `rigs` is the
/// number of pictures, and `lights_per_rig` does not count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_reserve(
    evaluator: *mut klieg_evaluator,
    rigs: u32,
    lights_per_rig: u32,
) -> klieg_status {
    let reserve = |evaluator: &mut EvaluatorBody| match &mut evaluator.level {
        Level::Pictures(pictures) => Ok(pictures.reserve(rigs)?),
        _ => Ok(evaluator.on_device()?.reserve(rigs, lights_per_rig as usize)?),
    };
    // SAFETY: the caller's handle.
    unsafe { call(evaluator, reserve) }
}

/// Records the evaluation of `rigs` rigs of `lights_per_rig` lights each, one rig after the other, into
/// an engine's command buffer (levels 1 and 2).
///
/// The lights are copied into the commands, so that the array may change at once and a recording may be
/// made while the last one runs. What was recorded before, on the same queue, is waited for by a barrier
/// first. When the commands have run, the scores are in `buffer` from the byte `offset` on, a float for
/// each rig, as a write of `VK_ACCESS_TRANSFER_WRITE_BIT` in `VK_PIPELINE_STAGE_TRANSFER_BIT`, which the
/// engine makes visible to its readers; or, where `buffer` is `VK_NULL_HANDLE`, with
/// `klieg_evaluator_read_scores` until the next recording runs. Pipeline, sets and push constants that were bound are not any more.
///
/// `commands` is being recorded, outside render passes, on the context's device for the family of its
/// queue. Its submissions run one after the other, none beside functions that evaluate, and the
/// evaluator outlives them. `buffer` has `VK_BUFFER_USAGE_TRANSFER_DST_BIT`, and `offset` is a multiple of
/// 4.
///
/// `KLIEG_ERROR_ARGUMENT` for a population that `klieg_evaluator_reserve` has made no room for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_record(
    evaluator: *mut klieg_evaluator,
    commands: vk::CommandBuffer,
    lights: *const klieg_light,
    rigs: u32,
    lights_per_rig: u32,
    buffer: vk::Buffer,
    offset: vk::DeviceSize,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the commands.
    unsafe {
        call(evaluator, |evaluator| {
            let population = population(lights, rigs, lights_per_rig)?;
            let target = target(buffer, offset);
            Ok(evaluator.on_device()?.record(commands, &population, target)?)
        })
    }
}

/// Reads the first `count` scores of the last recording without a buffer. Its commands have run: the
/// caller has waited for their fence.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_read_scores(
    evaluator: *mut klieg_evaluator,
    scores: *mut f32,
    count: u32,
) -> klieg_status {
    let read = |evaluator: &mut EvaluatorBody| {
        // SAFETY: the caller's pointer.
        let scores = unsafe { room(scores, count as usize, "scores") }?;
        match &mut evaluator.level {
            Level::Pictures(pictures) => Ok(pictures.read_scores(scores)?),
            _ => Ok(evaluator.on_device()?.read_scores(scores)?),
        }
    };
    // SAFETY: the caller's handle.
    unsafe { call(evaluator, read) }
}

/// Evaluates `rigs` rigs of `lights_per_rig` lights each, one rig after the other, and waits for the
/// scores, one for each rig: lower is better (levels 1 and 2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_evaluate(
    evaluator: *mut klieg_evaluator,
    lights: *const klieg_light,
    rigs: u32,
    lights_per_rig: u32,
    scores: *mut f32,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(evaluator, |evaluator| {
            let population = population(lights, rigs, lights_per_rig)?;
            let scores = room(scores, rigs as usize, "scores")?;
            Ok(evaluator.of_lights()?.evaluate(&population, scores)?)
        })
    }
}

/// As `klieg_evaluator_evaluate`, with the terms of each rig beside its score.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_qualities(
    evaluator: *mut klieg_evaluator,
    lights: *const klieg_light,
    rigs: u32,
    lights_per_rig: u32,
    qualities: *mut klieg_quality,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(evaluator, |evaluator| {
            let population = population(lights, rigs, lights_per_rig)?;
            let to = room(qualities, rigs as usize, "qualities")?;
            write_qualities(to, &evaluator.of_lights()?.qualities(&population)?);
            Ok(())
        })
    }
}

fn on_device(level: &mut Level) -> Outcome<&mut GpuEvaluator> {
    match level {
        Level::Scene(evaluator, _) => Ok(evaluator),
        Level::Surface(evaluator) => Ok(evaluator.evaluator()),
        Level::Cpu(..) => Err(Fault::argument(
            "this evaluator works on the CPU, which records nothing: use klieg_evaluator_evaluate",
        )),
        Level::Pictures(_) => Err(Fault::argument("this evaluator measures pictures, not lights")),
    }
}

/// Where recorded scores go.
pub(super) fn target(buffer: vk::Buffer, offset: vk::DeviceSize) -> ScoreTarget {
    match buffer == vk::Buffer::null() {
        true => ScoreTarget::Mapped,
        false => ScoreTarget::Buffer { buffer, offset },
    }
}
