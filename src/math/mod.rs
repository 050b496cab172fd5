//! What every other room counts with: colours, ranges of numbers, least squares, eigenvectors, and the light frame.

pub mod color;
pub(crate) mod eigen;
pub mod frame;
pub mod nnls;
pub mod range;
