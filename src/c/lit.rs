//! Lit scenes: the file that a scene was loaded from, with the lights that were found.

use super::camera::{as_camera, klieg_camera};
use super::edge::{Fault, Opaque, array, body, destroy, free_call, given, make, put, text};
use super::error::klieg_status;
use super::light::{as_rig, klieg_light};
use super::scene::klieg_scene;
use crate::lighting::check_number;
use crate::scene::{lit, view::View};
use std::ffi::{c_char, c_void};
use std::path::Path;

/// A lit scene: a whole glTF 2.0 file (GLB) in memory. One thread at a time.
pub struct klieg_lit(());

impl Opaque for klieg_lit {
    type Body = Vec<u8>;
}

/// Makes the lit scene of a scene that was loaded from a file: the file, which is read anew, with `count` lights
/// (KHR_lights_punctual, physical units) in place of its own, and with the camera, all in one GLB. The lights stand in
/// the frame of the view through `camera` at `width` by `height` pixels: the one that the evaluator was made of. Any
/// thread.
///
/// `KLIEG_ERROR_INPUT` for a file that cannot be used any more, `KLIEG_ERROR_ARGUMENT` for a scene that was made of
/// arrays and for a light that glTF cannot express.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_lit_create(
    scene: *const klieg_scene,
    camera: *const klieg_camera,
    width: u32,
    height: u32,
    lights: *const klieg_light,
    count: u32,
    lit: *mut *mut klieg_lit,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(lit, || {
            let (scene, access) = body(scene, "scene")?.loaded()?;
            let view = View::new(scene, as_camera(given(camera, "camera")?)?, width, height)?;
            check_number(count as usize)?;
            let rig = as_rig(array(lights, count as usize, "lights")?)?;
            Ok(lit::glb(&scene.path, access, &view, &rig)?)
        })
    }
}

/// Ends the lit scene; `NULL` is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_lit_destroy(lit: *mut klieg_lit) {
    // SAFETY: the caller's handle.
    unsafe { destroy(lit) };
}

/// Gives the bytes of the lit scene, `*size` of them, valid until it is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_lit_data(
    lit: *const klieg_lit,
    data: *mut *const c_void,
    size: *mut usize,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's handle and pointers.
        unsafe {
            let bytes = body(lit, "lit")?;
            put(data, bytes.as_ptr().cast(), "data")?;
            put(size, bytes.len(), "size")
        }
    })
}

/// Writes the lit scene to a file, whole or not at all; a file of that name is replaced. `path` is UTF-8.
///
/// `KLIEG_ERROR_OUTPUT` where it cannot be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_lit_write(
    lit: *const klieg_lit,
    path: *const c_char,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's handle and pointer.
        let (bytes, path) = unsafe { (body(lit, "lit")?, Path::new(text(path, "path")?)) };
        if path.as_os_str().is_empty() {
            return Err(Fault::argument("path is empty"));
        }
        Ok(lit::save(bytes, path)?)
    })
}
