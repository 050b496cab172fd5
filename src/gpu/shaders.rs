//! The shaders, compiled to SPIR-V by `build.rs`.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
