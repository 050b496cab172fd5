//! Whether lights cast shadows.

use super::design::flag;
use super::edge::{Outcome, free_call, put};
use super::error::klieg_status;
use super::settings::as_profile;
use crate::design::profile::{self, Profile};
use crate::objective::shadows::ShadowSettings;
use std::ffi::c_char;

/// Shadows of a scene that klieg draws itself. The defaults are those of the profile "natural".
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_shadows {
    /// 1, the default, where lights cast shadows; 0 where they do not.
    pub on: u32,
    /// Directions along a side of the map in which each pixel is looked at, an odd number, 3..63; by default 31.
    pub side: u32,
    /// Most memory of the table of shadows, MiB, 1 or more; by default 1024. A table that would be larger has
    /// fewer directions.
    pub memory: u32,
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_shadows_defaults(shadows: *mut klieg_shadows) -> klieg_status {
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(shadows, c_shadows(profile::DEFAULT), "shadows") })
}

/// Sets what the profile of that name has. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for an unknown name, with the known ones in the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_shadows_profile(
    shadows: *mut klieg_shadows,
    profile: *const c_char,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    free_call(|| unsafe { put(shadows, c_shadows(as_profile(profile)?), "shadows") })
}

fn c_shadows(profile: &Profile) -> klieg_shadows {
    let ShadowSettings { side, memory, .. } = ShadowSettings::default();
    klieg_shadows { on: profile.shadows.into(), side, memory }
}

/// # Safety
/// `shadows` is `NULL`, for the defaults, or valid.
pub(super) unsafe fn as_shadows(shadows: *const klieg_shadows) -> Outcome<ShadowSettings> {
    // SAFETY: the caller's promise.
    let given = unsafe { shadows.as_ref() }.copied();
    let klieg_shadows { on, side, memory } = given.unwrap_or_else(|| c_shadows(profile::DEFAULT));
    let settings = ShadowSettings { on: flag(on, "shadows.on")?, side, memory };
    settings.check()?;
    Ok(settings)
}
