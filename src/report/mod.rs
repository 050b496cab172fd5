//! What is written for people and other programs: pictures, plots, tables, arrays and sheets.
//!
//! Files of one run appear together: they are made in a [`Staging`] folder and moved to their place
//! when all are there.

pub mod animation;
pub mod csv;
mod dome;
pub mod exhibit;
pub mod gallery;
pub mod html;
pub mod json;
pub mod npy;
pub mod overview;
pub mod paper;
pub mod picture;
pub mod plot;
mod staging;
pub mod text;

pub use staging::{Inputs, Staging, abandon};
