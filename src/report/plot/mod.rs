//! Plots as SVG text, from plain data.
//!
//! Every plot takes its size (width, height) in pixels and scales with the page it stands in; below
//! about 480 pixels across there is no room for its text. [`theme`] has what they share, and how a
//! page gives them its own colours.

mod bands;
mod convergence;
mod field;
mod heat_map;
mod lines;
mod overlay;
mod paired;
mod summary;
mod surface;
mod sweep;
pub mod theme;

pub use bands::{Band, bands};
pub use convergence::convergence;
pub use field::Field;
pub use heat_map::{Mark, Path, Symbol, heat_map};
pub use lines::{Line, lines};
pub use paired::{Group, paired};
pub use surface::surface;
pub use sweep::{Panel, Setting, sweep};
