//! The scene files, made from nothing but arithmetic: the same bytes on every machine.

mod curve;
pub mod elephant;
mod field;
pub mod glb;
pub mod mesh;
pub mod pair;
mod polygonize;
mod still_life;
mod texture;
mod vessel;

use elephant::Elephant;

/// Every scene file: its name and its bytes.
pub fn files(elephant: &Elephant) -> [(&'static str, Vec<u8>); 3] {
    [
        ("elephant.glb", elephant::scene(elephant)),
        ("pair.glb", pair::scene(elephant, pair::PLACE)),
        ("still-life.glb", still_life::scene()),
    ]
}
