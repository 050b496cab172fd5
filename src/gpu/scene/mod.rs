//! The scene on the device, as the draws of its geometry read it.

pub mod drawable;
pub mod geometry;
pub mod textures;
