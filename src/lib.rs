//! klieg finds good lighting for a 3D scene by itself.
//!
//! It takes a glTF scene and a view, and searches the positions and intensities of lights for the
//! picture in which shapes, details and depth are easiest to see. The method is *Perception-based
//! Lighting Design* (Ha and Olivier, 2006); `docs/METHOD.md` says where its numbers are ours.
//!
//! The rooms, each of which knows only those before it: [`error`], [`math`], [`lighting`], [`scene`],
//! [`objective`], [`evaluate`], [`cpu`], [`render`] and [`gpu`], [`optimize`] (which knows the first two alone),
//! [`design`], [`study`]; then reports, sessions, the command line and the C interface.

/// Declares the constants of `src/constants.rs`; `build/glsl.rs` has a macro of this name that writes them in
/// GLSL.
macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $type = $value;)*
    };
}

/// Lets files hold types as the texts that `FromStr` reads and `Display` writes.
macro_rules! text_form {
    ($($name:ident),*) => {$(
        impl TryFrom<String> for $name {
            type Error = String;

            fn try_from(text: String) -> std::result::Result<Self, String> {
                text.parse()
            }
        }

        impl From<$name> for String {
            fn from(value: $name) -> Self {
                value.to_string()
            }
        }
    )*};
}

mod constants;
pub mod cpu;
pub mod design;
pub mod error;
pub mod evaluate;
pub mod gpu;
mod hash;
pub mod lighting;
pub mod math;
pub mod objective;
pub mod optimize;
pub mod render;
pub mod scene;
pub mod study;

#[cfg(any(feature = "c", test))]
pub mod c;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod session;
#[cfg(feature = "studio")]
pub mod studio;

pub use error::{Error, Result};
// In the versions that the library's interface speaks.
pub use {ash, glam, rand};
