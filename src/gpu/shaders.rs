//! The shaders, as SPIR-V, by way of the build script.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
