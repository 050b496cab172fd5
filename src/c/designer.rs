//! The search for lights, a little every frame.

use super::edge::{
    Fault, Opaque, Outcome, array, body_mut, call, destroy, free_call, given, make, put, room,
};
use super::error::klieg_status;
use super::evaluator::klieg_evaluator;
use super::light::{
    KLIEG_LIGHT_POINT, as_color, as_frame, as_kind, as_rig, as_role, fitting, klieg_frame,
    klieg_light, klieg_light_kind, klieg_role, write_lights,
};
use crate::lighting::genome::{Boxes, Genome, RoleBox};
use crate::lighting::start::{self, StartSettings};
use crate::lighting::{Light, Rig};
use crate::optimize::{Designer, GeneticSettings, Progress};
use std::time::Duration;

/// A genetic search for the lights with the lowest score, which its caller advances. One thread at a
/// time. It knows of no device: scores come from an evaluator, at once or frames later.
pub struct klieg_designer(());

impl Opaque for klieg_designer {
    type Body = Designer;
}

/// The values that lights of a role may have, each the lowest and the highest.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_role_box {
    /// Elevation, degrees.
    pub elevation: [f32; 2],
    /// Azimuth, degrees, -360 or more; it does not wrap, so that 100..260 is the half circle behind.
    pub azimuth: [f32; 2],
    /// Diffuse intensity, 0 or more.
    pub diffuse: [f32; 2],
    /// Specular intensity, 0 or more.
    pub specular: [f32; 2],
    /// Distance from the scene's centre, scene radii, above 0.
    pub distance: [f32; 2],
    /// Half angle of a spot's cone, degrees, 0.1..90; that of its inner cone is half of it.
    pub cone: [f32; 2],
    /// Colour of the lights, linear RGB, 0 or more, whose brightness does not count; all 0: white.
    pub color: [f32; 3],
}

/// What a designer looks for, and how. `klieg_design_defaults` sets all but `roles`, `lights` and `first`,
/// which it makes empty.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_design {
    /// The role of each light.
    pub roles: *const klieg_role,
    /// Number of lights, 1..`KLIEG_MAX_LIGHTS`.
    pub lights: u32,
    /// Kind of all lights; by default point lights.
    pub kind: klieg_light_kind,
    /// Intensities of each light: 2, the default, for a diffuse and a specular one that are free of each
    /// other; 1 for one, as lamps have, in the range `diffuse` of its role.
    pub intensities: u32,
    /// What key lights may be; by default elevation 0..90, azimuth -90..90, intensities 0..2, distance
    /// 1.5..5.
    pub key: klieg_role_box,
    /// What fill lights may be; by default as key lights, but for elevation -30..90 and intensities 0..1.
    pub fill: klieg_role_box,
    /// What rim lights may be; by default as fill lights, but for azimuth 100..260.
    pub rim: klieg_role_box,
    /// Individuals of a generation, 2..131072; by default 30.
    pub population: u32,
    /// Generations after which the search ends, counted anew from a change of the view; 0, the default, for
    /// never.
    pub generations: u64,
    /// Generations without a better rig after which the search ends, counted likewise; 0, the default, for
    /// never.
    pub patience: u64,
    /// Share of the population, the best, that is copied with its scores; by default 0.1.
    pub elitism: f32,
    /// Probability that a child is a blend of two parents; by default 0.8.
    pub crossover: f32,
    /// Probability with which each value of a child is moved; by default 0.2.
    pub mutation: f32,
    /// Standard deviation of that move, as a share of the value's range; by default 0.2.
    pub mutation_step: f32,
    /// Individuals that compete to be a parent, 1 or more; by default 2.
    pub tournament: u32,
    /// Share of the first population that scatters around the first rig, 0..1; by default 0.3333. The rest
    /// is uniform.
    pub scattered: f32,
    /// Standard deviation of that scatter as a share of each value's range, 0..1; by default 0.1.
    pub spread: f32,
    /// The first rig, `lights` of them, each value moved to the nearest one that its role may have:
    /// `klieg_evaluator_suggest`, a rig of the engine's, or `NULL` for the middle of every range.
    pub first: *const klieg_light,
    /// What all random numbers come from: the same seed gives the same lights on the same device. By
    /// default 0.
    pub seed: u64,
}

/// How a search stands after a generation; before the first it is generation 0, with infinite scores.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_progress {
    /// Number of the generation; the first population is 1.
    pub generation: u64,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Lowest score of the generation.
    pub best: f32,
    /// Mean score of the generation.
    pub mean: f32,
    /// Highest score of the generation.
    pub worst: f32,
}

/// Sets the defaults: a search without an end for point lights, with the paper's genetic algorithm. Any
/// thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_design_defaults(design: *mut klieg_design) -> klieg_status {
    let (boxes, genetic) = (Boxes::default(), GeneticSettings::default());
    let StartSettings { scattered, spread } = StartSettings::default();
    let defaults = klieg_design {
        roles: std::ptr::null(),
        lights: 0,
        kind: KLIEG_LIGHT_POINT,
        intensities: 2,
        key: box_in_c(&boxes.key),
        fill: box_in_c(&boxes.fill),
        rim: box_in_c(&boxes.rim),
        population: genetic.population as u32,
        generations: 0,
        patience: genetic.patience as u64,
        elitism: genetic.elitism,
        crossover: genetic.crossover,
        mutation: genetic.mutation,
        mutation_step: genetic.mutation_step,
        tournament: genetic.tournament as u32,
        scattered,
        spread,
        first: std::ptr::null(),
        seed: 0,
    };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(design, defaults, "design") })
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
/// `KLIEG_ERROR_ARGUMENT` names the setting that is out of its range.
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
            let &klieg_design { scattered, spread, seed, .. } = design;
            let start = StartSettings { scattered, spread };
            Ok(Designer::new(genome, as_genetic(design), start, first, seed)?)
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
/// `lights` has room for, `klieg_design::population` · `klieg_design::lights` in any case enough. Asking
/// again gives the same until `klieg_designer_tell`.
///
/// Elites keep their scores, so that there are fewer rigs after the first generation. `lights` may be `NULL`
/// to be told their number alone.
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

/// Gives the best rig of the last generation, the design's number of lights, and its score; either pointer
/// may be `NULL`. `capacity` is the number of lights that `lights` has room for. Between a change of the
/// view and the next scores it is the one from before, where it stands now.
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

/// Goes on from the present generation as it stands, all of it scored anew: the scene, or what the
/// evaluator measures, has changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_designer_renew(designer: *mut klieg_designer) -> klieg_status {
    let renew = |designer: &mut Designer| {
        designer.renew();
        Ok(())
    };
    // SAFETY: the caller's handle.
    unsafe { call(designer, renew) }
}

fn box_in_c(space: &RoleBox) -> klieg_role_box {
    klieg_role_box {
        elevation: space.elevation.into(),
        azimuth: space.azimuth.into(),
        diffuse: space.diffuse.into(),
        specular: space.specular.unwrap_or(space.diffuse).into(),
        distance: space.distance.into(),
        cone: space.cone.into(),
        color: space.color.linear(),
    }
}

fn as_box(space: &klieg_role_box, intensities: u32) -> Outcome<RoleBox> {
    let specular = match intensities {
        1 => None,
        2 => Some(space.specular.into()),
        other => {
            return Err(Fault::argument(format!("{other} intensities: a light has 1 or 2")));
        }
    };
    Ok(RoleBox {
        elevation: space.elevation.into(),
        azimuth: space.azimuth.into(),
        diffuse: space.diffuse.into(),
        specular,
        distance: space.distance.into(),
        cone: space.cone.into(),
        color: as_color(space.color)?,
    })
}

/// # Safety
/// The design's roles are valid.
unsafe fn as_genome(design: &klieg_design) -> Outcome<Genome> {
    // SAFETY: the caller's promise.
    let roles = unsafe { array(design.roles, design.lights as usize, "roles") }?;
    let roles: Vec<_> = roles.iter().map(|&role| as_role(role)).collect::<Outcome<_>>()?;
    let space = |space| as_box(space, design.intensities);
    let boxes =
        Boxes { key: space(&design.key)?, fill: space(&design.fill)?, rim: space(&design.rim)? };
    Ok(Genome::new(&roles, as_kind(design.kind)?, &boxes)?)
}

fn as_genetic(design: &klieg_design) -> GeneticSettings {
    let count = |value: u64| usize::try_from(value).unwrap_or(usize::MAX);
    GeneticSettings {
        population: design.population as usize,
        generations: if design.generations == 0 { usize::MAX } else { count(design.generations) },
        elitism: design.elitism,
        crossover: design.crossover,
        mutation: design.mutation,
        mutation_step: design.mutation_step,
        tournament: design.tournament as usize,
        patience: count(design.patience),
    }
}

/// # Safety
/// `to` is `NULL` or may be written to.
unsafe fn report(to: *mut klieg_progress, progress: &Progress) {
    let &Progress { generation, evaluations, best, mean, worst } = progress;
    let (generation, evaluations) = (generation as u64, evaluations as u64);
    // SAFETY: the caller's promise.
    if let Some(to) = unsafe { to.as_mut() } {
        *to = klieg_progress { generation, evaluations, best, mean, worst };
    }
}
