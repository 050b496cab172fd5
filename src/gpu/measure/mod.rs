//! A population on the device: its pictures, what is measured in them, and the scores.

pub mod forward;
pub mod generation;
pub mod layered;
pub mod pixels;
pub mod population;
pub mod runs;
pub mod tiles;
