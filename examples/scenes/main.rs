//! Makes the scene files: `cargo run --release --example scenes -- scenes`.

mod curve;
mod elephant;
mod field;
mod glb;
mod mesh;
mod polygonize;

use std::path::PathBuf;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = PathBuf::from(env::args_os().nth(1).unwrap_or_else(|| "scenes".into()));
    fs::create_dir_all(&folder)?;
    let elephant = elephant::Elephant::new(elephant::CELL);
    for (name, bytes) in [("elephant.glb", elephant::scene(&elephant))] {
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
