//! The program from the command line: one test program for all, which is built and linked once.

mod batch;
mod bench;
mod checkpoint;
mod console;
mod design;
mod device;
mod errors;
mod files;
mod gallery;
mod intent;
mod isolate;
mod lights;
mod limits;
mod literature;
mod measure;
mod optimizers;
mod profile;
mod render;
mod safety;
mod study;
mod together;
mod views;
