//! Loading of glTF: what the loader must read, and what it must refuse.

mod compressed;
mod faults;
mod file;
mod geometry;
mod materials;
mod models;
mod outside;
mod pictures;
mod pose;
mod stage;
