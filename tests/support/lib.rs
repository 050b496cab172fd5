//! What klieg's test programs share.

#![allow(missing_docs, reason = "names in tests speak for themselves")]
#![allow(clippy::new_without_default, reason = "a fixture is no default")]

pub mod browser;
pub mod common;
pub mod drawn;
pub mod engine;
pub mod figures;
pub mod gpu;
pub mod npm;
pub mod reference;
pub mod shapes;
pub mod studio;
pub mod surfaces;
pub mod swiftshader;
pub mod three;

use std::path::PathBuf;

/// The project's folder, or that which `KLIEG_ROOT` names, where a test program runs on another machine.
pub fn root() -> PathBuf {
    let built = || concat!(env!("CARGO_MANIFEST_DIR"), "/../..").into();
    std::env::var_os("KLIEG_ROOT").map_or_else(built, PathBuf::from)
}

/// A folder for files that outlive a test, below the target folder: what cargo calls `CARGO_TARGET_TMPDIR`
/// where it compiles test programs, which run in `target/<profile>/deps`.
pub fn temporary() -> PathBuf {
    let program = std::env::current_exe().expect("a running program");
    program.ancestors().nth(3).expect("a target folder").join("tmp")
}
