//! What an engine has drawn itself: its surface, and its pictures under lights of its own.

pub mod picture_evaluator;
pub mod pictures;
pub mod surface;
pub mod surface_evaluator;
