//! Native evaluator and the CPU references of the GPU stages.
//!
//! Each stage of the pipeline has a module of its name here, written as plainly as its formula: it is
//! what the GPU's stage and the fast [`CpuEvaluator`] are tested against.

pub mod appearance;
pub mod edges;
pub mod fitness;
pub mod gradient;
pub mod histogram;
pub mod moments;
pub mod normal_detail;
pub mod objects;
pub mod pictures;
pub mod pixel_types;
pub mod pixels;
pub mod population;
pub mod shadows;
pub mod shape;
pub mod subsample;
pub mod surface;
pub mod visibility;
pub mod visible;

mod bands;
mod compact;
mod evaluator;
mod fast_math;
mod kernels;
pub(crate) mod neighbourhood;
mod painter;

pub use evaluator::{CpuEvaluator, device};
pub use painter::Painter;

use crate::objective::Objective;
use crate::objective::maps::{Maps, PixelCounts, Surface};
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::{Error, Result};
use std::sync::Arc;

/// Most pixels of triangles' boxes that are drawn: for each pixel of the picture, and without any.
const FILLED: (u64, u64) = (1 << 10, 1 << 34);

/// The maps of a view of a scene, with the shadow table where the settings have shadows on: of the occluders in
/// the view's light frame, which are found here where none are given.
///
/// # Errors
/// As [`Scene::check`], [`View::check`], [`Objective::check`], [`ShadowSettings::check`] and
/// [`Occluders::new`]; [`Error::Input`] for triangles that cover each other too many times.
pub fn draw(
    scene: &Scene,
    view: &View,
    objective: &Objective,
    (settings, occluders): (&ShadowSettings, Option<Arc<Occluders>>),
) -> Result<Maps> {
    objective.check()?;
    settings.check()?;
    let surface = seen(scene, view)?;
    let mut maps = maps(surface, objective);
    if settings.on {
        let occluders = match occluders {
            Some(occluders) => occluders,
            None => Arc::new(Occluders::new(scene, view)?),
        };
        maps.shadows = Some(shadows::table(&maps.surface, occluders, settings));
    }
    Ok(maps)
}

/// The visible surface of a scene.
fn seen(scene: &Scene, view: &View) -> Result<Surface> {
    scene.check()?;
    view.check()?;
    let most = FILLED.1 + FILLED.0 * u64::from(view.width) * u64::from(view.height);
    visibility::draw_within(scene, view, most).ok_or_else(|| {
        let fault =
            "its triangles cover each other so many times that drawing them would take very long";
        Error::input(&scene.path, format!("{fault}: a smaller picture takes less"))
    })
}

/// Object pixels of a view.
///
/// # Errors
/// As [`draw`], but for its settings.
pub fn objects(scene: &Scene, view: &View) -> Result<u32> {
    Ok(seen(scene, view)?.code.iter().filter(|&&code| code != 0).count() as u32)
}

/// The maps of a view whose visible surface is `surface`, with the thresholds of `objective`.
///
/// The depth of the background is set to the largest object depth + 1 (1 in a picture without any
/// object), whatever it was.
///
/// # Panics
/// Unless every map of the surface has an entry for each pixel.
pub fn maps(mut surface: Surface, objective: &Objective) -> Maps {
    set_background_depth(&mut surface);
    let (sobel, laplace) = edges::depth_gradients(&surface);
    let types = pixel_types::classify(&surface.code, &sobel, &laplace, objective);
    let counts = PixelCounts::of(&types);
    let visible = visible::visible(&surface.code);
    let (normal_gradient, normal_detail) = normal_detail::normal_detail(&surface, &types);
    let shape = shape::shape(&surface, &types, &normal_gradient);
    let target = Vec::new();
    let shadows = None;
    Maps {
        surface,
        sobel,
        laplace,
        types,
        counts,
        visible,
        normal_gradient,
        normal_detail,
        shape,
        target,
        shadows,
    }
}

fn set_background_depth(surface: &mut Surface) {
    let pixels = || surface.code.iter().zip(&surface.depth);
    let largest =
        pixels().filter(|&(&code, _)| code != 0).map(|(_, &d)| d).fold(f32::NEG_INFINITY, f32::max);
    let background = if largest.is_finite() { largest + 1.0 } else { 1.0 };
    for (&code, depth) in surface.code.iter().zip(&mut surface.depth) {
        if code == 0 {
            *depth = background;
        }
    }
}
