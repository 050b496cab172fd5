//! Version, status codes and messages.

use super::edge::{LAST, Message};
use std::ffi::{c_char, c_void};

/// The version of the header, by the rules of Semantic Versioning: before 1.0 a minor version, after
/// it a major version may change what is here.
pub const KLIEG_VERSION_MAJOR: u32 = 0;
/// See `KLIEG_VERSION_MAJOR`.
pub const KLIEG_VERSION_MINOR: u32 = 2;
/// See `KLIEG_VERSION_MAJOR`.
pub const KLIEG_VERSION_PATCH: u32 = 0;
/// The header's version in one number: major · 1,000,000 + minor · 1,000 + patch.
pub const KLIEG_VERSION: u32 = 2_000;

/// How a call went: `KLIEG_OK`, a `KLIEG_ERROR_...` (negative), or `KLIEG_NOTHING_YET`.
pub type klieg_status = i32;

/// All went well.
pub const KLIEG_OK: klieg_status = 0;
/// There is nothing to give yet; no error.
pub const KLIEG_NOTHING_YET: klieg_status = 1;
/// An argument is out of its range, `NULL` where it must not be, or of the wrong handle.
pub const KLIEG_ERROR_ARGUMENT: klieg_status = -1;
/// A file, or a scene that was made of one, cannot be used.
pub const KLIEG_ERROR_INPUT: klieg_status = -2;
/// The device lacks something, or was not borrowed for this; the message lists all of it.
pub const KLIEG_ERROR_UNSUPPORTED: klieg_status = -3;
/// There is no Vulkan here, or no device.
pub const KLIEG_ERROR_NO_VULKAN: klieg_status = -4;
/// A Vulkan call failed; the message has its name and result.
pub const KLIEG_ERROR_VULKAN: klieg_status = -5;
/// The device is lost: nothing but destroying works on it any more.
pub const KLIEG_ERROR_DEVICE_LOST: klieg_status = -6;
/// `klieg_context_forget_device` was called: nothing but destroying works any more.
pub const KLIEG_ERROR_FORGOTTEN: klieg_status = -7;
/// There is not enough memory.
pub const KLIEG_ERROR_MEMORY: klieg_status = -8;
/// The program was built for a version of klieg that this library does not speak.
pub const KLIEG_ERROR_VERSION: klieg_status = -9;
/// A fault of klieg's own. Destroy the handles of the call; others may be used on.
pub const KLIEG_ERROR_INTERNAL: klieg_status = -10;
/// A file cannot be written.
pub const KLIEG_ERROR_OUTPUT: klieg_status = -11;

/// The version of the library that runs, as `KLIEG_VERSION`. It may be newer than the header's.
#[unsafe(no_mangle)]
pub extern "C" fn klieg_version() -> u32 {
    KLIEG_VERSION
}

/// The message of the last call that failed: on `handle`, of whatever type, where that is its first
/// argument.
///
/// Functions that make a handle and functions without one leave their message with the calling thread
/// instead, for `klieg_error(NULL)`. Contexts have none of their own, as threads share them:
/// `klieg_error(context)` is `klieg_error(NULL)`.
///
/// UTF-8, in English; never `NULL`, empty where nothing failed. It stays valid until the next such call
/// fails or the handle is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_error(handle: *const c_void) -> *const c_char {
    // SAFETY: the caller's handle; every handle begins with its message.
    let message = unsafe { handle.cast::<Message>().as_ref() };
    match message {
        Some(Message::Own(text)) => text.as_ptr(),
        Some(Message::Thread) | None => {
            LAST.try_with(|text| text.borrow().as_ptr()).unwrap_or(c"".as_ptr())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_the_packages() {
        let parts = [KLIEG_VERSION_MAJOR, KLIEG_VERSION_MINOR, KLIEG_VERSION_PATCH];
        let [major, minor, patch] = parts;
        assert_eq!(env!("CARGO_PKG_VERSION"), format!("{major}.{minor}.{patch}"));
        assert_eq!(KLIEG_VERSION, major * 1_000_000 + minor * 1_000 + patch);
    }
}
