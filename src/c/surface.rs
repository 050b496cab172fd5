//! Level 2: the surface that an engine has drawn.

use super::context::klieg_context;
use super::edge::{
    Fault, Opaque, Outcome, body, call, choice, destroy, free_call, given, make, put,
};
use super::error::klieg_status;
use super::evaluator::{EvaluatorBody, Level, klieg_evaluator};
use super::settings::{as_objective, as_shading, klieg_objective, klieg_shading};
use crate::gpu::{EngineImage, ImportedSurface, SurfaceEvaluator, SurfaceImages};
use crate::scene::engine::{EngineCamera, NormalCode, NormalSpace, SurfaceFormat};
use ash::vk;
use glam::{DMat4, DVec3};

/// An engine's surface as an evaluator reads it. It may outlive the evaluator; then it is of no use.
pub struct klieg_surface(());

pub(super) struct SurfaceBody {
    surface: ImportedSurface,
    /// Number of the evaluator that it belongs to.
    evaluator: u64,
}

impl Opaque for klieg_surface {
    type Body = SurfaceBody;
}

/// An image of an engine.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_image {
    /// A two-dimensional view of one aspect, whose image may be sampled; `VK_NULL_HANDLE` where there is
    /// none.
    pub view: vk::ImageView,
    /// The layout that the image is in whenever klieg reads it, one that allows sampling.
    pub layout: vk::ImageLayout,
}

/// The images of an engine's surface, all of the evaluator's size. klieg reads them by texel fetch, so that
/// any float, normalised or sRGB format will do.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_surface_images {
    /// Depth as the engine's projection gives it: the depth aspect, or a colour of one component. It must
    /// be there.
    pub depth: klieg_image,
    /// Shading normals; without them normals are made of the depth.
    pub normal: klieg_image,
    /// Base colours.
    pub base_color: klieg_image,
    /// Roughness and metallic factor.
    pub roughness_metallic: klieg_image,
    /// Linear emitted radiance.
    pub emissive: klieg_image,
    /// Numbers of objects or polygons, unsigned integers; 0 is the background.
    pub ids: klieg_image,
}

/// Which space an engine's normals are in: one of `KLIEG_NORMALS_...`.
pub type klieg_normal_space = i32;
/// The world's.
pub const KLIEG_NORMALS_WORLD: klieg_normal_space = 0;
/// The eye's, of `klieg_engine_camera::view`.
pub const KLIEG_NORMALS_EYE: klieg_normal_space = 1;

/// How an engine's normals are coded: one of `KLIEG_NORMAL_CODE_...`.
pub type klieg_normal_code = i32;
/// Three components -1..1, of any length.
pub const KLIEG_NORMAL_CODE_SIGNED: klieg_normal_code = 0;
/// Three components 0..1, (n + 1) / 2.
pub const KLIEG_NORMAL_CODE_UNSIGNED: klieg_normal_code = 1;
/// Two components -1..1, octahedral (Cigolle et al. 2014).
pub const KLIEG_NORMAL_CODE_OCTAHEDRAL: klieg_normal_code = 2;
/// Two components 0..1, octahedral.
pub const KLIEG_NORMAL_CODE_OCTAHEDRAL_UNSIGNED: klieg_normal_code = 3;

/// How the images of an engine's surface are to be read.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_surface_format {
    /// Space of the normals; by default the world's.
    pub normal_space: klieg_normal_space,
    /// Code of the normals; by default signed. Normals that face away from the viewer are mirrored
    /// to face it.
    pub normal_code: klieg_normal_code,
    /// `VK_TRUE` where base colours come out of the image sRGB-encoded, which those of an sRGB format do
    /// not; by default `VK_FALSE`.
    pub base_color_encoded: vk::Bool32,
    /// Component of the roughness (perceptual, as glTF has it), 0 to 3; by default 1 (green).
    pub roughness_channel: u32,
    /// Component of the metallic factor, 0 to 3; by default 2 (blue).
    pub metallic_channel: u32,
    /// Depth of pixels where nothing is drawn, 0..1; by default 1. Without ids these are the background.
    pub cleared_depth: f32,
    /// `VK_TRUE` where the first row of the images is at y = 1 of clip space, as with a viewport of negative
    /// height; `VK_FALSE`, the default, where it is at y = -1 by Vulkan's own rule.
    pub flipped: vk::Bool32,
    /// Linear base colour where there is no image of it; by default 0.8.
    pub base_color: [f32; 3],
    /// Roughness where there is no image of it, 0..1; by default 1.
    pub roughness: f32,
    /// Metallic factor where there is no image of it, 0..1; by default 0.
    pub metallic: f32,
}

/// The camera that an engine has drawn with, and the bounds of its scene. Matrices have 16 numbers, column
/// after column.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_engine_camera {
    /// Eye space from world space, a rotation and a translation: x to the right, y up, the view along -z.
    pub view: [f64; 16],
    /// Clip space from eye space, as the engine draws with it: depth 0 to 1 or reversed, far plane finite or
    /// not, perspective or parallel.
    pub projection: [f64; 16],
    /// Centre of the scene, world units: lights are placed around it.
    pub center: [f64; 3],
    /// Radius of the scene around it, world units: the unit of the lights' lengths.
    pub radius: f64,
}

/// Makes an evaluator of level 2, for surfaces of `width` by `height` pixels. Before the first view its
/// picture is empty. `objective` and `shading` may be `NULL`, for the defaults. Lights cast no shadows. Any
/// thread.
///
/// `KLIEG_ERROR_ARGUMENT` for a picture larger than the device can take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_of_surface(
    context: *const klieg_context,
    width: u32,
    height: u32,
    objective: *const klieg_objective,
    shading: *const klieg_shading,
    evaluator: *mut *mut klieg_evaluator,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(evaluator, || {
            let context = &body(context, "context")?.context;
            let (objective, shading) = (as_objective(objective)?, as_shading(shading)?);
            let made = SurfaceEvaluator::new(context, [width, height], objective, shading)?;
            Ok(EvaluatorBody::new(Level::Surface(Box::new(made))))
        })
    }
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_surface_format_defaults(
    format: *mut klieg_surface_format,
) -> klieg_status {
    let default = SurfaceFormat::default();
    let defaults = klieg_surface_format {
        normal_space: KLIEG_NORMALS_WORLD,
        normal_code: KLIEG_NORMAL_CODE_SIGNED,
        base_color_encoded: default.base_color_encoded.into(),
        roughness_channel: default.roughness_channel,
        metallic_channel: default.metallic_channel,
        cleared_depth: default.cleared_depth,
        flipped: default.flipped.into(),
        base_color: default.base_color,
        roughness: default.roughness,
        metallic: default.metallic,
    };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(format, defaults, "format") })
}

/// Takes an engine's images in, for this evaluator of level 2 or 3: once for each set of images that the
/// engine draws into. At level 3 only depth, normals and ids count. `format` may be `NULL`, for the
/// defaults. The thread that uses the evaluator.
///
/// The views are of the context's device and of the evaluator's size, and stay alive as long as what is
/// recorded with the surface runs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_surface_create(
    evaluator: *const klieg_evaluator,
    images: *const klieg_surface_images,
    format: *const klieg_surface_format,
    surface: *mut *mut klieg_surface,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the images.
    unsafe {
        make(surface, || {
            let evaluator = body(evaluator, "evaluator")?;
            let images = as_images(given(images, "images")?)?;
            let format = as_format(format)?;
            let surface = match &evaluator.level {
                Level::Surface(of_surface) => of_surface.import(&images, &format)?,
                Level::Pictures(of_pictures) => of_pictures.import_surface(&images, &format)?,
                Level::Scene(..) | Level::Cpu(..) => return Err(draws_itself()),
            };
            Ok(SurfaceBody { surface, evaluator: evaluator.number })
        })
    }
}

/// Ends the surface, not its images; `NULL` is left alone. No recording with it may be in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_surface_destroy(surface: *mut klieg_surface) {
    // SAFETY: the caller's handle.
    unsafe { destroy(surface) };
}

/// Records the making of the maps of what the engine has drawn into the surface's images (levels 2 and 3).
/// What is recorded or evaluated later, until the next view, is measured against this view, and its frame
/// is that of `klieg_evaluator_frame`.
///
/// `commands` as for `klieg_evaluator_record`; evaluator and surface outlive its submissions. The images
/// are in their stated layouts and visible to `VK_ACCESS_SHADER_READ_BIT` in
/// `VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT`. They are left as they are, and may be written again after a
/// barrier from that stage.
///
/// `KLIEG_ERROR_ARGUMENT` for a camera that is not finite, not rigid, or neither perspective nor parallel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_record_view(
    evaluator: *mut klieg_evaluator,
    commands: vk::CommandBuffer,
    surface: *const klieg_surface,
    camera: *const klieg_engine_camera,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the commands and the images.
    unsafe {
        call(evaluator, |evaluator| {
            let (surface, camera) = (own(evaluator, surface)?, as_engine_camera(camera)?);
            match &mut evaluator.level {
                Level::Surface(of_surface) => {
                    of_surface.record_view(commands, surface, &camera)?;
                }
                Level::Pictures(of_pictures) => {
                    of_pictures.record_view(commands, surface, &camera)?;
                }
                Level::Scene(..) | Level::Cpu(..) => return Err(draws_itself()),
            }
            Ok(())
        })
    }
}

/// As `klieg_evaluator_record_view`, submitted and waited for at once. No recording of this evaluator may
/// be in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_look(
    evaluator: *mut klieg_evaluator,
    surface: *const klieg_surface,
    camera: *const klieg_engine_camera,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the images.
    unsafe {
        call(evaluator, |evaluator| {
            let (surface, camera) = (own(evaluator, surface)?, as_engine_camera(camera)?);
            match &mut evaluator.level {
                Level::Surface(of_surface) => of_surface.look(surface, &camera)?,
                Level::Pictures(of_pictures) => of_pictures.look(surface, &camera)?,
                Level::Scene(..) | Level::Cpu(..) => return Err(draws_itself()),
            }
            Ok(())
        })
    }
}

fn draws_itself() -> Fault {
    Fault::argument("this evaluator draws its scene itself: it takes no surface")
}

/// The evaluator's own surface.
///
/// # Safety
/// `surface` is `NULL` or alive.
unsafe fn own<'a>(
    evaluator: &EvaluatorBody,
    surface: *const klieg_surface,
) -> Outcome<&'a ImportedSurface> {
    // SAFETY: the caller's promise.
    let surface = unsafe { body(surface, "surface") }?;
    match surface.evaluator == evaluator.number {
        true => Ok(&surface.surface),
        false => Err(Fault::argument("the surface is another evaluator's")),
    }
}

pub(super) fn as_image(image: klieg_image) -> Option<EngineImage> {
    let klieg_image { view, layout } = image;
    (view != vk::ImageView::null()).then_some(EngineImage { view, layout })
}

fn as_images(images: &klieg_surface_images) -> Outcome<SurfaceImages> {
    let depth = as_image(images.depth).ok_or_else(|| Fault::argument("there is no depth image"))?;
    Ok(SurfaceImages {
        depth,
        normal: as_image(images.normal),
        base_color: as_image(images.base_color),
        roughness_metallic: as_image(images.roughness_metallic),
        emissive: as_image(images.emissive),
        ids: as_image(images.ids),
    })
}

/// # Safety
/// `format` is `NULL`, for the defaults, or valid.
unsafe fn as_format(format: *const klieg_surface_format) -> Outcome<SurfaceFormat> {
    // SAFETY: the caller's promise.
    let Some(format) = (unsafe { format.as_ref() }) else { return Ok(SurfaceFormat::default()) };
    let spaces = [NormalSpace::World, NormalSpace::Eye];
    let codes = [
        NormalCode::Signed,
        NormalCode::Unsigned,
        NormalCode::Octahedral,
        NormalCode::OctahedralUnsigned,
    ];
    Ok(SurfaceFormat {
        normal_space: choice(&spaces, format.normal_space, "normal space")?,
        normal_code: choice(&codes, format.normal_code, "normal code")?,
        base_color_encoded: format.base_color_encoded != vk::FALSE,
        roughness_channel: format.roughness_channel,
        metallic_channel: format.metallic_channel,
        cleared_depth: format.cleared_depth,
        flipped: format.flipped != vk::FALSE,
        base_color: format.base_color,
        roughness: format.roughness,
        metallic: format.metallic,
    })
}

/// # Safety
/// `camera` is `NULL` or valid.
unsafe fn as_engine_camera(camera: *const klieg_engine_camera) -> Outcome<EngineCamera> {
    // SAFETY: the caller's promise.
    let camera = unsafe { given(camera, "camera") }?;
    Ok(EngineCamera {
        view: DMat4::from_cols_array(&camera.view),
        projection: DMat4::from_cols_array(&camera.projection),
        center: DVec3::from(camera.center),
        radius: camera.radius,
    })
}
