//! What every other room counts with: colours, ranges of numbers, and the light frame.

pub mod color;
pub mod frame;
pub mod range;
