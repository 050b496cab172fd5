//! The C interface: `include/klieg.h` is made of these files, in their order and with their words,
//! so what is public here bears the names of the header. Contexts, handles, arrays and callbacks
//! come in as raw pointers; what they have to fulfil stands in the header.

#![allow(non_camel_case_types, reason = "the names are the header's")]
#![allow(clippy::missing_safety_doc, reason = "the header says what a caller owes")]

pub mod camera;
pub mod context;
pub mod design;
pub mod designer;
pub mod device;
mod edge;
pub mod error;
pub mod evaluator;
pub mod intent;
pub mod light;
pub mod lit;
pub mod pictures;
pub mod requirements;
pub mod scene;
pub mod settings;
mod shadows;
pub mod surface;
