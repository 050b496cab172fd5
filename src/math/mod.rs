//! What every other room counts with: colours, ranges of numbers, least squares, and the light frame.

pub mod color;
pub mod frame;
pub mod nnls;
pub mod range;
