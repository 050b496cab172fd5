//! What is measured, and how surfaces shine.

use super::edge::{free_call, put};
use super::error::klieg_status;
use crate::lighting::shading::Shading;
use crate::objective::{Objective, Quality, Terms};
use bytemuck::Zeroable;

/// One number for each of the five terms of the quality function, each 0..1, lower is better.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_terms {
    /// Edge distinctness.
    pub edge: f32,
    /// Mean brightness.
    pub mean: f32,
    /// Mean shading gradient.
    pub grad: f32,
    /// Intensity range.
    pub var: f32,
    /// Evenness of the histogram.
    pub hist: f32,
}

/// A picture's quality.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_quality {
    /// The weighted sum of the terms: lower is better.
    pub score: f32,
    /// The terms.
    pub terms: klieg_terms,
}

/// Settings of the quality function.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_objective {
    /// Weight of each term, 0 or more; by default each 0.2, so that scores lie in 0..1.
    pub weights: klieg_terms,
    /// Mean brightness aimed at, sRGB-encoded, 0..1; by default 0.5.
    pub mean_target: f32,
    /// Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel, above 0;
    /// by default 0.06.
    pub edge_contrast: f32,
    /// Sobel length of the depth above which a pixel can be an edge, scene radii a pixel; by default
    /// 0.02.
    pub edge_sobel: f32,
    /// Absolute Laplacian of the depth above which a pixel can be an edge, scene radii; by default 0.02.
    pub edge_laplace: f32,
}

/// Constants of klieg's own shading, which levels 1 and 2 use.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_shading {
    /// Share of the base colour that is seen without any light, 0 or more; by default 0.03.
    pub ambient: f32,
    /// Specular reflectance of dielectrics at normal incidence, 0..1; by default 0.04.
    pub dielectric: f32,
    /// Largest Blinn-Phong exponent, 1 or more; by default 4096.
    pub max_shininess: f32,
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_objective_defaults(objective: *mut klieg_objective) -> klieg_status {
    let Objective { weights, mean_target, edge_contrast, edge_sobel, edge_laplace } =
        Objective::default();
    let weights = terms(weights);
    let defaults =
        klieg_objective { weights, mean_target, edge_contrast, edge_sobel, edge_laplace };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(objective, defaults, "objective") })
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_shading_defaults(shading: *mut klieg_shading) -> klieg_status {
    let Shading { ambient, dielectric, max_shininess, .. } = Shading::default();
    let defaults = klieg_shading { ambient, dielectric, max_shininess };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(shading, defaults, "shading") })
}

/// # Safety
/// `objective` is `NULL`, for the defaults, or valid.
pub(super) unsafe fn as_objective(objective: *const klieg_objective) -> Objective {
    // SAFETY: the caller's promise.
    unsafe { objective.as_ref() }.map_or_else(Objective::default, |given| {
        let klieg_terms { edge, mean, grad, var, hist } = given.weights;
        Objective {
            weights: Terms::named([
                ("edge", edge),
                ("mean", mean),
                ("grad", grad),
                ("var", var),
                ("hist", hist),
            ])
            .unwrap_or_default(),
            mean_target: given.mean_target,
            edge_contrast: given.edge_contrast,
            edge_sobel: given.edge_sobel,
            edge_laplace: given.edge_laplace,
        }
    })
}

/// # Safety
/// `shading` is `NULL`, for the defaults, or valid.
pub(super) unsafe fn as_shading(shading: *const klieg_shading) -> Shading {
    // SAFETY: the caller's promise.
    unsafe { shading.as_ref() }.map_or_else(Shading::default, |given| {
        let &klieg_shading { ambient, dielectric, max_shininess } = given;
        Shading { ambient, dielectric, max_shininess, ..Shading::default() }
    })
}

fn terms(terms: Terms) -> klieg_terms {
    let [edge, mean, grad, var, hist] =
        ["edge", "mean", "grad", "var", "hist"].map(|name| terms.get(name).unwrap_or(0.0));
    klieg_terms { edge, mean, grad, var, hist }
}

pub(super) fn write_qualities(to: &mut [klieg_quality], qualities: &[Quality]) {
    for (to, quality) in to.iter_mut().zip(qualities) {
        *to = klieg_quality { score: quality.score, terms: terms(quality.terms) };
    }
}
