//! Loading of glTF: what the loader must read, and what it must refuse.

mod faults;
mod file;
mod geometry;
mod materials;
mod outside;
mod pose;
mod stage;
