//! What is measured, and how surfaces shine.

use super::edge::{Fault, Outcome, choice, free_call, put, text};
use super::error::klieg_status;
use crate::constants::{MEAN_OF_SCENE, NO_BACKGROUND};
use crate::design::profile::{self, PROFILES, Profile};
use crate::lighting::shading::{Brdf, Shading};
use crate::objective::terms::TERMS;
use crate::objective::{MAX_TERMS, MeanTarget, Objective, Quality, Term, Terms};
use bytemuck::Zeroable;
use std::ffi::{CString, c_char};
use std::ptr::null;
use std::sync::OnceLock;

/// Most terms of an objective.
pub const KLIEG_MAX_TERMS: usize = 16;

/// A term of the objective by its name, with a number: its weight, or its value for a picture.
///
/// A picture is judged by a weighted sum of terms, each 0..1, lower is better. `klieg_term_at` lists them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_term {
    /// Its name. Names that klieg gives stay valid as long as the library is loaded.
    pub name: *const c_char,
    /// Weight or value.
    pub value: f32,
}

// SAFETY: `NULL` and 0 are a value.
unsafe impl Zeroable for klieg_term {}

/// What klieg can judge pictures by.
#[repr(C)]
pub struct klieg_term_info {
    /// Its name.
    pub name: *const c_char,
    /// What it is called before people.
    pub title: *const c_char,
    /// What it says of a picture, in English: a sentence without its subject.
    pub meaning: *const c_char,
    /// What pictures have to be measured for besides their brightness and gradients, which takes time:
    /// "detail", "channels", "irradiance", "target", "background", "example" or several of them with spaces between;
    /// empty for nothing.
    pub needs: *const c_char,
}

// SAFETY: the strings are klieg's own, and nobody changes or frees them.
unsafe impl Send for klieg_term_info {}
// SAFETY: as above.
unsafe impl Sync for klieg_term_info {}

/// A picture's quality.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_quality {
    /// The weighted sum of the terms: lower is better.
    pub score: f32,
    /// How many of `terms` there are.
    pub term_count: u32,
    /// The objective's terms, in the order of `klieg_term_at`. Terms of weight 0 are left out where only they need what
    /// was not measured.
    pub terms: [klieg_term; KLIEG_MAX_TERMS],
}

/// A full set of defaults that settings start from, by its name.
#[repr(C)]
pub struct klieg_profile_info {
    /// Its name, as `klieg_objective_profile`, `klieg_shading_profile`, `klieg_shadows_profile` and
    /// `klieg_design_profile` take it.
    pub name: *const c_char,
    /// What it is, in English.
    pub meaning: *const c_char,
}

// SAFETY: the strings are klieg's own, and nobody changes or frees them.
unsafe impl Send for klieg_profile_info {}
// SAFETY: as above.
unsafe impl Sync for klieg_profile_info {}

/// `klieg_objective::mean_target` that the scene sets: half of the mean luminance of its base colours,
/// encoded, kept in 0.25..0.72. An engine that gives no base colours has the uniform one that it names.
pub const KLIEG_MEAN_TARGET_SCENE: f32 = -1.0;
const _: () = assert!(KLIEG_MEAN_TARGET_SCENE == MEAN_OF_SCENE);

/// `klieg_objective::background` that is not known.
pub const KLIEG_NO_BACKGROUND: f32 = -1.0;
const _: () = assert!(KLIEG_NO_BACKGROUND == NO_BACKGROUND);

/// How surfaces reflect: one of `KLIEG_BRDF_...`.
pub type klieg_brdf = i32;
/// Lambert, and a Blinn-Phong lobe of the material's width.
pub const KLIEG_BRDF_BLINN_PHONG: klieg_brdf = 0;
/// As glTF 2.0 has it: Lambert under GGX.
pub const KLIEG_BRDF_GLTF: klieg_brdf = 1;
/// The same with what rough surfaces scatter more than once.
pub const KLIEG_BRDF_GLTF_SCATTERING: klieg_brdf = 2;

/// Settings of the quality function. The defaults are those of the profile "natural".
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_objective {
    /// Weight of each term, 0 or more, not all 0; terms that are not there do not count. By default those of
    /// ten terms, which do not sum to 1; "paper" gives 0.2 to each of "edge", "mean", "grad", "var" and
    /// "hist", so that its scores lie in 0..1. `klieg_objective_set_weight` changes one. Names that are not there are refused where an
    /// evaluator is made, with the known ones in the message.
    pub weights: [klieg_term; KLIEG_MAX_TERMS],
    /// How many of `weights` there are.
    pub weight_count: u32,
    /// Mean brightness aimed at, sRGB-encoded, 0..1, or `KLIEG_MEAN_TARGET_SCENE`, the default.
    pub mean_target: f32,
    /// Photographic stops by which that is moved, -4..4, one doubling its light; by default 0.
    pub mean_stops: f32,
    /// Standard deviation of the brightness that the term "spread" aims at, sRGB-encoded, 0..0.5; by default 0.2.
    pub spread_target: f32,
    /// Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel, above 0;
    /// by default 0.06.
    pub edge_contrast: f32,
    /// Sobel length of the depth above which a pixel can be an edge, scene radii a pixel; by default
    /// 0.02.
    pub edge_sobel: f32,
    /// Absolute Laplacian of the depth above which a pixel can be an edge, scene radii; by default 0.02.
    pub edge_laplace: f32,
    /// Luminance behind the objects, sRGB-encoded, 0..1, from which the term "outline" makes them stand out; or
    /// `KLIEG_NO_BACKGROUND`, the default, which makes the weights of terms that need one count as 0.
    pub background: f32,
}

/// klieg's own shading, which levels 1 and 2 use. The defaults are those of the profile "natural".
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_shading {
    /// How surfaces reflect; by default as glTF has it.
    pub brdf: klieg_brdf,
    /// Share of the base colour that is seen without any light, 0 or more; by default 0.
    pub ambient: f32,
    /// Specular reflectance of dielectrics at normal incidence, 0..1; by default 0.04.
    pub dielectric: f32,
    /// Largest Blinn-Phong exponent, 1 or more; by default 4096.
    pub max_shininess: f32,
}

/// Describes the term of that number, counted from 0; `NULL` beyond the last, which is no error. The
/// description stays valid as long as the library is loaded. Any thread.
#[unsafe(no_mangle)]
pub extern "C" fn klieg_term_at(number: u32) -> *const klieg_term_info {
    usize::try_from(number).ok().and_then(|number| infos().get(number)).map_or(null(), |info| info)
}

/// Describes the profile of that number, counted from 0; `NULL` beyond the last, which is no error. The
/// description stays valid as long as the library is loaded. Any thread.
#[unsafe(no_mangle)]
pub extern "C" fn klieg_profile_at(number: u32) -> *const klieg_profile_info {
    static INFOS: OnceLock<Vec<klieg_profile_info>> = OnceLock::new();
    let infos = INFOS.get_or_init(|| {
        let info = |profile: &&Profile| klieg_profile_info {
            name: keep(profile.name),
            meaning: keep(profile.meaning),
        };
        PROFILES.iter().map(info).collect()
    });
    usize::try_from(number).ok().and_then(|number| infos.get(number)).map_or(null(), |info| info)
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_objective_defaults(objective: *mut klieg_objective) -> klieg_status {
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(objective, c_objective(profile::DEFAULT), "objective") })
}

/// Sets what the profile of that name has. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_objective_profile(
    objective: *mut klieg_objective,
    profile: *const c_char,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    free_call(|| unsafe { put(objective, c_objective(as_profile(profile)?), "objective") })
}

/// Gives a term its weight, 0 or more. The weights then stand in the order of `klieg_term_at`. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for a name that is none of a term, with the known ones in the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_objective_set_weight(
    objective: *mut klieg_objective,
    name: *const c_char,
    weight: f32,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        let (objective, name) = unsafe {
            let objective = objective.as_mut();
            let objective = objective.ok_or_else(|| Fault::argument("objective is NULL"))?;
            (objective, text(name, "name")?)
        };
        // SAFETY: the names are the caller's.
        let mut weights = unsafe { weights(objective) }?;
        weights.set(Term::named(name)?, weight)?;
        (objective.weight_count, objective.weights) = c_terms(&weights);
        Ok(())
    })
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_shading_defaults(shading: *mut klieg_shading) -> klieg_status {
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(shading, c_shading(profile::DEFAULT), "shading") })
}

/// Sets what the profile of that name has. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_shading_profile(
    shading: *mut klieg_shading,
    profile: *const c_char,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    free_call(|| unsafe { put(shading, c_shading(as_profile(profile)?), "shading") })
}

/// # Safety
/// The name is `NULL` or a string.
pub(super) unsafe fn as_profile(name: *const c_char) -> Outcome<&'static Profile> {
    // SAFETY: the caller's promise.
    Ok(Profile::named(unsafe { text(name, "profile") }?)?)
}

fn c_objective(profile: &Profile) -> klieg_objective {
    objective_in_c(&(profile.objective)())
}

pub(super) fn objective_in_c(objective: &Objective) -> klieg_objective {
    let &Objective { mean_stops, spread_target, edge_contrast, edge_sobel, edge_laplace, .. } =
        objective;
    let (weight_count, weights) = c_terms(&objective.weights);
    let mean_target = match objective.mean_target {
        MeanTarget::Value(value) => value,
        MeanTarget::Scene => KLIEG_MEAN_TARGET_SCENE,
    };
    let background = objective.background.unwrap_or(KLIEG_NO_BACKGROUND);
    klieg_objective {
        weights,
        weight_count,
        mean_target,
        mean_stops,
        spread_target,
        edge_contrast,
        edge_sobel,
        edge_laplace,
        background,
    }
}

/// In the order of `KLIEG_BRDF_...`.
const BRDFS: [Brdf; 3] = [Brdf::BlinnPhong, Brdf::Gltf, Brdf::GltfScattering];

fn c_shading(profile: &Profile) -> klieg_shading {
    let Shading { brdf, ambient, dielectric, max_shininess } = (profile.shading)();
    let brdf = match brdf {
        Brdf::BlinnPhong => KLIEG_BRDF_BLINN_PHONG,
        Brdf::Gltf => KLIEG_BRDF_GLTF,
        Brdf::GltfScattering => KLIEG_BRDF_GLTF_SCATTERING,
    };
    klieg_shading { brdf, ambient, dielectric, max_shininess }
}

/// # Safety
/// `objective` is `NULL`, for the defaults, or valid.
pub(super) unsafe fn as_objective(objective: *const klieg_objective) -> Outcome<Objective> {
    // SAFETY: the caller's promise.
    let Some(given) = (unsafe { objective.as_ref() }) else {
        return Ok((profile::DEFAULT.objective)());
    };
    // SAFETY: the caller's promise.
    let objective = unsafe { read_objective(given) }?;
    objective.check()?;
    objective.check_without_target()?;
    Ok(objective)
}

/// What is given, unchecked.
///
/// # Safety
/// The names of the weights are valid.
pub(super) unsafe fn read_objective(given: &klieg_objective) -> Outcome<Objective> {
    Ok(Objective {
        // SAFETY: the caller's promise.
        weights: unsafe { weights(given) }?,
        mean_target: match given.mean_target {
            KLIEG_MEAN_TARGET_SCENE => MeanTarget::Scene,
            value => MeanTarget::Value(value),
        },
        mean_stops: given.mean_stops,
        spread_target: given.spread_target,
        edge_contrast: given.edge_contrast,
        edge_sobel: given.edge_sobel,
        edge_laplace: given.edge_laplace,
        example: None,
        background: Some(given.background).filter(|&b| b != KLIEG_NO_BACKGROUND),
    })
}

/// As [`as_objective`], without the terms that pictures do not tell where their weights are the defaults'.
///
/// # Safety
/// The same.
pub(super) unsafe fn as_objective_of_pictures(
    objective: *const klieg_objective,
) -> Outcome<Objective> {
    // SAFETY: the caller's promise.
    let mut given = unsafe { as_objective(objective) }?;
    let (weights, defaults) = (given.weights, (profile::DEFAULT.objective)().weights);
    let asked = |term: &Term| weights.get(term.name) != defaults.get(term.name);
    given.weights = weights.filter(|term| !term.needs.irradiance || asked(term));
    Ok(given)
}

/// # Safety
/// The names are `NULL` or strings.
unsafe fn weights(objective: &klieg_objective) -> Outcome<Terms> {
    let count = objective.weight_count as usize;
    let given = objective.weights.get(..count).ok_or_else(|| {
        Fault::argument(format!("{count} weights: an objective has at most {KLIEG_MAX_TERMS}"))
    })?;
    let mut weights = Terms::default();
    for term in given {
        // SAFETY: the caller's promise.
        let name = unsafe { text(term.name, "the name of a term") }?;
        weights.set(Term::named(name)?, term.value)?;
    }
    Ok(weights)
}

/// # Safety
/// `shading` is `NULL`, for the defaults, or valid.
pub(super) unsafe fn as_shading(shading: *const klieg_shading) -> Outcome<Shading> {
    // SAFETY: the caller's promise.
    let Some(given) = (unsafe { shading.as_ref() }) else {
        return Ok((profile::DEFAULT.shading)());
    };
    let &klieg_shading { brdf, ambient, dielectric, max_shininess } = given;
    let brdf = choice(&BRDFS, brdf, "brdf")?;
    Ok(Shading { brdf, ambient, dielectric, max_shininess })
}

/// What `klieg_term_at` gives, in the order of [`TERMS`].
fn infos() -> &'static [klieg_term_info] {
    static INFOS: OnceLock<Vec<klieg_term_info>> = OnceLock::new();
    INFOS.get_or_init(|| {
        let info = |term: &&Term| klieg_term_info {
            name: keep(term.name),
            title: keep(term.title),
            meaning: keep(term.meaning),
            needs: keep(&term.needs.names().collect::<Vec<_>>().join(" ")),
        };
        TERMS.iter().map(info).collect()
    })
}

/// Strings that the library's users may keep are never freed.
fn keep(text: &str) -> *const c_char {
    CString::new(text).unwrap_or_default().into_raw().cast_const()
}

/// klieg's own terms and their numbers, as C has them.
fn c_terms(terms: &Terms) -> (u32, [klieg_term; KLIEG_MAX_TERMS]) {
    let mut all = [klieg_term::zeroed(); KLIEG_MAX_TERMS];
    for (to, (term, value)) in all.iter_mut().zip(terms.iter()) {
        let info = TERMS.iter().zip(infos()).find(|(own, _)| **own == term);
        *to = klieg_term { name: info.map_or(null(), |(_, info)| info.name), value };
    }
    (terms.iter().count() as u32, all)
}

pub(super) fn write_qualities(to: &mut [klieg_quality], qualities: &[Quality]) {
    for (to, quality) in to.iter_mut().zip(qualities) {
        let (term_count, terms) = c_terms(&quality.terms);
        *to = klieg_quality { score: quality.score, term_count, terms };
    }
}

const _: () = assert!(KLIEG_MAX_TERMS == MAX_TERMS);
