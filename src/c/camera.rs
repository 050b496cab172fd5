//! Cameras that klieg draws scenes through.

use super::edge::{Fault, Outcome, body, free_call, numbers, put, text};
use super::error::klieg_status;
use super::scene::klieg_scene;
use crate::scene::camera::choose;
use crate::scene::framing::{Framing, frame};
use crate::scene::view::{Camera, Projection};
use glam::{DMat3, DMat4, DVec3};

/// A lens: one of `KLIEG_LENS_...`.
pub type klieg_lens = i32;
/// `klieg_camera::size` is the vertical field of view, radians, below pi.
pub const KLIEG_LENS_PERSPECTIVE: klieg_lens = 0;
/// `klieg_camera::size` is half of the picture's height, world units.
pub const KLIEG_LENS_ORTHOGRAPHIC: klieg_lens = 1;

/// A camera in the world, right handed. The picture's own aspect ratio decides the width.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_camera {
    /// Position, world units.
    pub eye: [f64; 3],
    /// Unit axis to the viewer's right.
    pub right: [f64; 3],
    /// Unit axis up.
    pub up: [f64; 3],
    /// Unit axis from the scene to the viewer.
    pub back: [f64; 3],
    /// Lens.
    pub lens: klieg_lens,
    /// What the lens says.
    pub size: f64,
    /// Distance of the near clipping plane, world units: above 0, or from 0 on for an orthographic lens.
    pub near_plane: f64,
    /// Distance of the far clipping plane; 0 where there is none.
    pub far_plane: f64,
}

/// From where, how wide and how closely a scene is looked at.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_framing {
    /// Towards the scene's right (+x) from its front (+z), radians; by default 30 degrees.
    pub azimuth: f64,
    /// Upwards (+y), radians; by default 15 degrees.
    pub elevation: f64,
    /// Vertical field of view, radians; by default 35 degrees.
    pub fov: f64,
    /// Share of the picture's height or width, whichever binds, that the scene takes, above 0 and at most
    /// 1; by default 0.85.
    pub fill: f64,
}

/// Makes a camera at `eye` that looks at `target`, with `up` above, 3 numbers each. Its near plane stands at a thousandth
/// of the distance (an orthographic one's at the eye), and there is no far plane; both can be set. Any
/// thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_camera_look_at(
    eye: *const f64,
    target: *const f64,
    up: *const f64,
    lens: klieg_lens,
    size: f64,
    camera: *mut klieg_camera,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        unsafe {
            let [eye, target, up] =
                [numbers(eye, "eye")?, numbers(target, "target")?, numbers(up, "up")?];
            let [eye, target, up] = [eye, target, up].map(DVec3::from_array);
            let made = Camera::look_at(eye, target, up, as_projection(lens, size)?)?;
            put(camera, in_c(&made), "camera")
        }
    })
}

/// Makes the camera of an engine's view matrix: eye space from world space, right handed, looking along
/// -z, a rotation and a translation; 16 numbers, column after column. `near_plane` and `far_plane` as in
/// `klieg_camera`. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_camera_from_view(
    view: *const f64,
    lens: klieg_lens,
    size: f64,
    near_plane: f64,
    far_plane: f64,
    camera: *mut klieg_camera,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        unsafe {
            let view = DMat4::from_cols_array(&numbers(view, "view")?);
            let (projection, far) = (as_projection(lens, size)?, as_far(far_plane));
            let made = Camera::from_view(&view, projection, near_plane, far)?;
            put(camera, in_c(&made), "camera")
        }
    })
}

/// Gives the camera of a finished scene that `name` names, or else numbers from 0. Any thread, while
/// nobody changes the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_camera_of_scene(
    scene: *const klieg_scene,
    name: *const std::ffi::c_char,
    camera: *mut klieg_camera,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        unsafe {
            let scene = body(scene, "scene")?.finished()?;
            put(camera, in_c(&choose(scene, text(name, "name")?)?), "camera")
        }
    })
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_framing_defaults(framing: *mut klieg_framing) -> klieg_status {
    let Framing { azimuth, elevation, fov, fill } = Framing::default();
    // SAFETY: the caller's pointer.
    free_call(|| unsafe {
        put(framing, klieg_framing { azimuth, elevation, fov, fill }, "framing")
    })
}

/// Makes the camera that shows all of a finished scene in the middle of a picture whose width is `aspect`
/// times its height. `framing` may be `NULL`, for the defaults. Any thread, while nobody changes the
/// scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_camera_frame(
    scene: *const klieg_scene,
    framing: *const klieg_framing,
    aspect: f64,
    camera: *mut klieg_camera,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        unsafe {
            let framing = framing.as_ref().map_or_else(Framing::default, |given| {
                let &klieg_framing { azimuth, elevation, fov, fill } = given;
                Framing { azimuth, elevation, fov, fill }
            });
            let scene = body(scene, "scene")?.finished()?;
            put(camera, in_c(&frame(scene, &framing, aspect)?), "camera")
        }
    })
}

fn as_projection(lens: klieg_lens, size: f64) -> Outcome<Projection> {
    match lens {
        KLIEG_LENS_PERSPECTIVE => Ok(Projection::Perspective { yfov: size }),
        KLIEG_LENS_ORTHOGRAPHIC => Ok(Projection::Orthographic { ymag: size }),
        _ => Err(Fault::argument(format!("lens {lens} is not there"))),
    }
}

fn as_far(far_plane: f64) -> Option<f64> {
    (far_plane != 0.0).then_some(far_plane)
}

pub(super) fn as_camera(camera: &klieg_camera) -> Outcome<Camera> {
    let [eye, right, up, back] =
        [camera.eye, camera.right, camera.up, camera.back].map(DVec3::from);
    let axes = DMat3::from_cols(right, up, back).transpose();
    let view = DMat4::from_mat3(axes) * DMat4::from_translation(-eye);
    let projection = as_projection(camera.lens, camera.size)?;
    let far = as_far(camera.far_plane);
    // It is checked as a matrix, and keeps the bits that it has.
    let checked = Camera::from_view(&view, projection, camera.near_plane, far)?;
    Ok(Camera { eye, right, up, back, ..checked })
}

fn in_c(camera: &Camera) -> klieg_camera {
    let (lens, size) = match camera.projection {
        Projection::Perspective { yfov } => (KLIEG_LENS_PERSPECTIVE, yfov),
        Projection::Orthographic { ymag } => (KLIEG_LENS_ORTHOGRAPHIC, ymag),
    };
    klieg_camera {
        eye: camera.eye.to_array(),
        right: camera.right.to_array(),
        up: camera.up.to_array(),
        back: camera.back.to_array(),
        lens,
        size,
        near_plane: camera.near,
        far_plane: camera.far.unwrap_or(0.0),
    }
}
