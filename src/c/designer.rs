//! The search, a little every frame.

use super::design::{as_genome, as_settings, klieg_design, optimizer};
use super::edge::{Fault, Opaque, array, body_mut, call, destroy, given, make, put, room};
use super::error::klieg_status;
use super::evaluator::klieg_evaluator;
use super::light::{as_frame, as_rig, fitting, klieg_frame, klieg_light, write_lights};
use crate::design::{Designer, Progress, start};
use crate::lighting::{Light, Rig};
use std::time::Duration;

/// A search for the lights with the lowest score, which its caller advances. One thread at a time. It knows of no device: scores come from an evaluator, at once or frames later.
pub struct klieg_designer(());

impl Opaque for klieg_designer {
    type Body = Designer;
}

/// How a search stands after a generation; before the first it is generation 0, with infinite scores.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_progress {
    /// Number of the generation; the first population is 1.
    pub generation: u64,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Lowest score so far, since the view last changed.
    pub best: f32,
    /// Mean score of what the search holds.
    pub mean: f32,
    /// Highest of these scores.
    pub worst: f32,
}

/// Gives the `design->lights` lights that the view suggests as a first rig: they face what is most of the
/// visible surface (k-means of its normals). Reads the view's maps back, so the commands of the view have
/// run. `design->first` does not count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_suggest(
    evaluator: *mut klieg_evaluator,
    design: *const klieg_design,
    lights: *mut klieg_light,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(evaluator, |evaluator| {
            let design = given(design, "design")?;
            let genome = as_genome(design)?;
            let to = room(lights, genome.lights(), "lights")?;
            write_lights(to, &genome.decode(&evaluator.suggestion(&genome, design.seed)?));
            Ok(())
        })
    }
}

/// Makes a designer. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` names the setting that is out of its range, and lists the optimizers where
/// `design->optimizer` is none of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_create(
    design: *const klieg_design,
    designer: *mut *mut klieg_designer,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(designer, || {
            let design = given(design, "design")?;
            let genome = as_genome(design)?;
            let first = match design.first.is_null() {
                true => None,
                false => {
                    let rig = as_rig(array(design.first, genome.lights(), "first")?)?;
                    Some(start::from_rig(&genome, &rig)?)
                }
            };
            let name = optimizer(design)?;
            Ok(Designer::new(genome, name, &as_settings(design), first, design.seed)?)
        })
    }
}

/// Ends the designer; `NULL` is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_destroy(designer: *mut klieg_designer) {
    // SAFETY: the caller's handle.
    unsafe { destroy(designer) };
}

/// Gives the rigs whose scores the search wants next: `*rigs` of them, one after the other, each with the
/// design's number of lights; none when the search has ended. `capacity` is the number of lights that
/// `lights` has room for. Of `"shade"`, `"ga"` and `"random"`, `klieg_design::population` · `klieg_design::lights` is in
/// any case enough; descents ask for two rigs for each value of each light of each descent, and `"cma-es"` for 1,025
/// at most. Asking again gives the same until `klieg_designer_tell`.
///
/// Elites of the genetic algorithm keep their scores, so that there are fewer rigs after the first
/// generation. `lights` may be `NULL` to be told their number alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_ask(
    designer: *mut klieg_designer,
    lights: *mut klieg_light,
    capacity: u32,
    rigs: *mut u32,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            put(rigs, designer.ask().len() as u32, "rigs")?;
            if lights.is_null() {
                return Ok(());
            }
            let asked: Vec<Light> = designer.rigs().flatten().collect();
            write_lights(fitting(lights, capacity, asked.len())?, &asked);
            Ok(())
        })
    }
}

/// Takes the scores of `klieg_designer_ask`, in order, `count` of them; `progress` may be `NULL`. Scores of
/// a population that was asked for before the view changed must not be told after.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_tell(
    designer: *mut klieg_designer,
    scores: *const f32,
    count: u32,
    progress: *mut klieg_progress,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            let told = designer.tell(array(scores, count as usize, "scores")?)?;
            report(progress, &told);
            Ok(())
        })
    }
}

/// Evaluates so many generations at once, or fewer where the search ends; `progress` may be `NULL`. The
/// evaluator is of level 1 or 2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_advance(
    designer: *mut klieg_designer,
    evaluator: *mut klieg_evaluator,
    generations: u32,
    progress: *mut klieg_progress,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            let evaluator = body_mut(evaluator, "evaluator")?.of_lights()?;
            report(progress, &designer.advance(evaluator, generations as usize)?);
            Ok(())
        })
    }
}

/// Evaluates generations for about `seconds` of wall time: the first is always made, another only where it
/// ends in time if it takes as long as the one before. `progress` may be `NULL`. The evaluator is of
/// level 1 or 2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_advance_for(
    designer: *mut klieg_designer,
    evaluator: *mut klieg_evaluator,
    seconds: f64,
    progress: *mut klieg_progress,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            let budget = Duration::try_from_secs_f64(seconds)
                .map_err(|_| Fault::argument(format!("a budget of {seconds} seconds")))?;
            let evaluator = body_mut(evaluator, "evaluator")?.of_lights()?;
            report(progress, &designer.advance_for(evaluator, budget)?);
            Ok(())
        })
    }
}

/// Gives the best rig so far, the design's number of lights, and its score; either pointer
/// may be `NULL`. `capacity` is the number of lights that `lights` has room for. It starts anew with the first
/// scores after a change of the view; until then it is the one from before, where it stands now.
///
/// `KLIEG_NOTHING_YET` before the first scores.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_best(
    designer: *mut klieg_designer,
    lights: *mut klieg_light,
    capacity: u32,
    score: *mut f32,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            let (rig, found): (Rig, f32) = designer.best().ok_or_else(Fault::nothing_yet)?;
            if !lights.is_null() {
                write_lights(fitting(lights, capacity, rig.len())?, &rig);
            }
            if let Some(score) = score.as_mut() {
                *score = found;
            }
            Ok(())
        })
    }
}

/// Goes on in another light frame, as the camera has moved: the lights stay where they are in the world, as
/// near as their roles allow, and are all scored anew. Where both frames are the same nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_follow(
    designer: *mut klieg_designer,
    from: *const klieg_frame,
    to: *const klieg_frame,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        call(designer, |designer| {
            let (from, to) = (as_frame(given(from, "from")?), as_frame(given(to, "to")?));
            Ok(designer.follow(&from, &to)?)
        })
    }
}

/// Goes on with what the search holds as it stands, all of it scored anew: the scene, or what the evaluator
/// measures, has changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_renew(designer: *mut klieg_designer) -> klieg_status {
    // SAFETY: the caller's handle.
    unsafe { call(designer, |designer| Ok(designer.renew()?)) }
}

/// # Safety
/// `to` is `NULL` or may be written to.
unsafe fn report(to: *mut klieg_progress, progress: &Progress) {
    let &Progress { generation, evaluations, best, mean, worst, .. } = progress;
    let (generation, evaluations) = (generation as u64, evaluations as u64);
    // SAFETY: the caller's promise.
    if let Some(to) = unsafe { to.as_mut() } {
        *to = klieg_progress { generation, evaluations, best, mean, worst };
    }
}
