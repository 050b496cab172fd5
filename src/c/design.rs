//! The search for lights.

use super::edge::{Fault, Outcome, array, free_call, put, text};
use super::error::klieg_status;
use super::light::{as_color, as_kind, as_role, kind, klieg_light, klieg_light_kind, klieg_role};
use super::settings::as_profile;
use crate::design::profile::{self, Profile};
use crate::lighting::genome::{Boxes, Genome, RoleBox};
use crate::optimize::shade;
use crate::optimize::{
    Entry, GeneticSettings, GreedySettings, Settings, ShadeSettings, StartSettings,
};
use glam::Vec3;
use std::ffi::{CStr, c_char};

/// The values that lights of a role may have, each the lowest and the highest.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_role_box {
    /// Elevation, degrees.
    pub elevation: [f32; 2],
    /// Azimuth, degrees, -360 or more; it does not wrap, so that 100..260 is the half circle behind.
    pub azimuth: [f32; 2],
    /// 1 for azimuths that are measured from the first key light's, positive to the left of a key on the right
    /// and to the right of any other; else 0. For fill and rim lights beside a key.
    pub azimuth_from_key: u32,
    /// 1 for intensities that are shares of the first key light's; else 0. For fill and rim lights beside a
    /// key.
    pub share_of_key: u32,
    /// Diffuse intensity, 0 or more.
    pub diffuse: [f32; 2],
    /// Specular intensity, 0 or more.
    pub specular: [f32; 2],
    /// Distance from the scene's centre, scene radii, above 0.
    pub distance: [f32; 2],
    /// Half angle of a spot's cone, degrees, 0.1..90; that of its inner cone is half of it.
    pub cone: [f32; 2],
    /// Angle that a light covers seen from the scene's centre, degrees, 0..60.
    pub softness: f32,
    /// Colour of the lights, linear RGB, 0 or more, whose brightness does not count; all 0: white.
    pub color: [f32; 3],
}

/// What a designer looks for, and how. The defaults are those of the profile "natural".
/// `klieg_design_defaults` sets all but `roles`, `lights` and `first`, which it makes empty.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_design {
    /// The role of each light.
    pub roles: *const klieg_role,
    /// Number of lights, 1..`KLIEG_MAX_LIGHTS`.
    pub lights: u32,
    /// Kind of all lights; by default point lights.
    pub kind: klieg_light_kind,
    /// Intensities of each light: 1, the default, for one, as lamps have, in the range `diffuse` of its role; 2
    /// for a diffuse and a specular one that are free of each other.
    pub intensities: u32,
    /// What key lights may be; by default elevation 0..90, azimuth -90..90, intensity 0..6, distance 1.5..5,
    /// softness 4.
    pub key: klieg_role_box,
    /// What fill lights may be; by default as key lights, but for elevation -10..45, azimuth 20..110 from the
    /// key's and 0.05..0.6 of its intensity.
    pub fill: klieg_role_box,
    /// What rim lights may be; by default as key lights, but for elevation 10..80, azimuth 110..250 and
    /// 0.1..1.5 of the key's intensity.
    pub rim: klieg_role_box,
    /// How the lights are searched: `"shade"`, the differential evolution SHADE, which `NULL` stands for; `"ga"`, the
    /// paper's genetic algorithm; `"cma-es"`, BIPOP-CMA-ES; `"greedy"`, steepest descents; `"restarts"`, such descents
    /// one after another; or `"random"`.
    pub optimizer: *const c_char,
    /// Individuals of a generation, 2..131072; by default 20, of the profile "paper" 30. Of SHADE and random
    /// search too.
    pub population: u32,
    /// Generations after which the search ends, counted anew from a change of the view; 0, the default, for
    /// never. Of SHADE and random search too, and descents with restarts end after as many evaluations; greedy
    /// descents end where the ground is level, until the view changes.
    pub generations: u64,
    /// Generations without a better rig after which the search ends, counted likewise; 0, the default, for
    /// never. Of SHADE too.
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
    /// Greedy descents side by side, 1..1024; by default 1. The first begins with the first rig, the others
    /// with random ones.
    pub greedy_starts: u32,
    /// Distance of a descent's probes, above 0, to 1, as a share of each value's range; by default 0.005.
    pub greedy_probe: f32,
    /// Length of a descent's first step, such a share; by default 0.1.
    pub greedy_step: f32,
    /// Length of a step below which a descent has ended, such a share; by default 0.001.
    pub greedy_end: f32,
    /// Entries of SHADE's history of successful parameters, 1..4096; by default 10.
    pub shade_history: u32,
    /// Individuals of its archive, as a multiple of the population, 0..10; by default 1.
    pub shade_archive: f32,
    /// Largest share of the population that counts as its best, 0..1; by default 0.2.
    pub shade_best: f32,
    /// Its population has settled when the scores differ by no more than this share of the lowest, to 1; by
    /// default 0.003. Below 0 (to -1) it never has.
    pub shade_settled: f32,
    /// Populations one after another, each from random rigs where the one before it has settled; 0, the default,
    /// for no end.
    pub shade_starts: u64,
    /// Unit vector upwards in the light frame (`klieg_frame`), so that no light stands below the horizon of the scene's
    /// centre; all 0, the default, where lights may stand below.
    pub up: [f32; 3],
    /// The first rig, `lights` of them, each value moved to the nearest one that its role may have:
    /// `klieg_evaluator_suggest`, a rig of the engine's, or `NULL` for the middle of every range.
    pub first: *const klieg_light,
    /// What all random numbers come from: the same seed gives the same lights on the same device. By
    /// default 0.
    pub seed: u64,
}

/// Sets the defaults: a search without an end for point lights of the profile "natural", by SHADE. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_design_defaults(design: *mut klieg_design) -> klieg_status {
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(design, c_design(profile::DEFAULT), "design") })
}

/// As `klieg_design_defaults`, with the lights and the optimiser as the profile of that name has them. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_design_profile(
    design: *mut klieg_design,
    profile: *const c_char,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    free_call(|| unsafe { put(design, c_design(as_profile(profile)?), "design") })
}

fn c_design(profile: &Profile) -> klieg_design {
    let boxes = (profile.boxes)();
    let Settings { start: StartSettings { scattered, spread }, genetic, shade, greedy } =
        Settings::default();
    klieg_design {
        roles: std::ptr::null(),
        lights: 0,
        kind: kind(profile.kind),
        intensities: if boxes.key.specular.is_some() { 2 } else { 1 },
        key: box_in_c(&boxes.key),
        fill: box_in_c(&boxes.fill),
        rim: box_in_c(&boxes.rim),
        optimizer: name_in_c(&profile.optimizer),
        population: profile.population as u32,
        generations: 0,
        patience: genetic.patience as u64,
        elitism: genetic.elitism,
        crossover: genetic.crossover,
        mutation: genetic.mutation,
        mutation_step: genetic.mutation_step,
        tournament: genetic.tournament as u32,
        scattered,
        spread,
        greedy_starts: greedy.starts as u32,
        greedy_probe: greedy.probe,
        greedy_step: greedy.step,
        greedy_end: greedy.end,
        shade_history: shade.history as u32,
        shade_archive: shade.archive,
        shade_best: shade.best,
        shade_settled: shade.settled,
        shade_starts: 0,
        up: [0.0; 3],
        first: std::ptr::null(),
        seed: 0,
    }
}

/// The profiles' optimisers, as C reads their names.
const NAMES: [&CStr; 2] = [c"ga", c"shade"];

/// The name of an optimiser; `NULL` for one that is none of a profile's.
fn name_in_c(optimizer: &Entry) -> *const c_char {
    let name = NAMES.into_iter().find(|name| name.to_bytes() == optimizer.name.as_bytes());
    name.map_or(std::ptr::null(), CStr::as_ptr)
}

pub(super) fn box_in_c(space: &RoleBox) -> klieg_role_box {
    klieg_role_box {
        elevation: space.elevation.into(),
        azimuth: space.azimuth.into(),
        azimuth_from_key: space.azimuth_from_key.into(),
        share_of_key: space.share_of_key.into(),
        diffuse: space.diffuse.into(),
        specular: space.specular.unwrap_or(space.diffuse).into(),
        distance: space.distance.into(),
        cone: space.cone.into(),
        softness: space.softness,
        color: space.color.linear(),
    }
}

pub(super) fn as_box(space: &klieg_role_box, intensities: u32) -> Outcome<RoleBox> {
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
        azimuth_from_key: flag(space.azimuth_from_key, "azimuth_from_key")?,
        share_of_key: flag(space.share_of_key, "share_of_key")?,
        diffuse: space.diffuse.into(),
        specular,
        distance: space.distance.into(),
        cone: space.cone.into(),
        softness: space.softness,
        color: as_color(space.color)?,
    })
}

pub(super) fn flag(value: u32, name: &str) -> Outcome<bool> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Fault::argument(format!("{name} is {other}: it is 0 or 1"))),
    }
}

/// # Safety
/// The design's roles are valid.
pub(super) unsafe fn as_genome(design: &klieg_design) -> Outcome<Genome> {
    // SAFETY: the caller's promise.
    let roles = unsafe { array(design.roles, design.lights as usize, "roles") }?;
    let roles: Vec<_> = roles.iter().map(|&role| as_role(role)).collect::<Outcome<_>>()?;
    let space = |space| as_box(space, design.intensities);
    let boxes =
        Boxes { key: space(&design.key)?, fill: space(&design.fill)?, rim: space(&design.rim)? };
    let genome = Genome::new(&roles, as_kind(design.kind)?, &boxes)?;
    match Vec3::from(design.up) {
        Vec3::ZERO => Ok(genome),
        up => Ok(genome.above_horizon(up)?),
    }
}

/// The name of the optimiser.
///
/// # Safety
/// The design's name is valid.
pub(super) unsafe fn optimizer(design: &klieg_design) -> Outcome<&str> {
    match design.optimizer.is_null() {
        true => Ok(shade::NAME),
        // SAFETY: the caller's promise.
        false => unsafe { text(design.optimizer, "optimizer") },
    }
}

pub(super) fn as_settings(design: &klieg_design) -> Settings {
    let count = |value: u64| usize::try_from(value).unwrap_or(usize::MAX);
    let genetic = GeneticSettings {
        population: design.population as usize,
        generations: if design.generations == 0 { usize::MAX } else { count(design.generations) },
        elitism: design.elitism,
        crossover: design.crossover,
        mutation: design.mutation,
        mutation_step: design.mutation_step,
        tournament: design.tournament as usize,
        patience: count(design.patience),
    };
    let greedy = GreedySettings {
        starts: design.greedy_starts as usize,
        probe: design.greedy_probe,
        step: design.greedy_step,
        end: design.greedy_end,
    };
    let start = StartSettings { scattered: design.scattered, spread: design.spread };
    let shade = ShadeSettings {
        history: design.shade_history as usize,
        archive: design.shade_archive,
        best: design.shade_best,
        settled: design.shade_settled,
        starts: if design.shade_starts == 0 { usize::MAX } else { count(design.shade_starts) },
    };
    Settings { start, genetic, shade, greedy }
}
