//! Makes the scene files: `cargo run --release --example scenes -- scenes`.

mod generator;

use std::path::PathBuf;
use std::{env, fs, io};

use generator::elephant::Elephant;

fn main() -> io::Result<()> {
    let folder = PathBuf::from(env::args_os().nth(1).unwrap_or_else(|| "scenes".into()));
    fs::create_dir_all(&folder)?;
    for (name, bytes) in generator::files(&Elephant::new()) {
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
