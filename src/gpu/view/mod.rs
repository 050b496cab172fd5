//! A view on the device: the draw of its visible surface and the maps that are made of it.

pub mod drawn;
pub mod g_buffer;
pub mod maps;
pub mod memory;
pub mod reader;
pub mod records;
pub mod shadows;
pub mod visibility;
