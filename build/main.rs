//! Makes `$OUT_DIR/shaders.rs`: the SPIR-V of every shader of `shaders/`.
//!
//! With feature `shaderc` the shaders are compiled, also to `$OUT_DIR/spirv/`, and a shader's error or
//! warning fails the build with its file and line. Without it, what is checked in in `src/gpu/spirv/`
//! is taken, if it is what these sources give. `make spirv` copies the one folder to the other.

#[cfg(feature = "shaderc")]
mod compile;
#[cfg(not(feature = "shaderc"))]
mod stored;

mod glsl;
#[path = "../src/hash.rs"]
mod hash;

use hash::{FNV_START, fnv1a};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SHADERS: &str = "shaders";
const INCLUDES: &str = "shaders/include";

/// A shader: the name of its file and its SPIR-V words.
type Module = (String, Vec<u32>);

fn main() {
    // Cargo looks at everything below a folder, so that a file that comes or goes counts too.
    for input in [SHADERS, "build", "src/constants.rs", "src/hash.rs"] {
        println!("cargo::rerun-if-changed={input}");
    }
    #[cfg(not(feature = "shaderc"))]
    println!("cargo::rerun-if-changed={}", stored::FOLDER);
    if let Err(error) = make() {
        for line in error.to_string().lines().filter(|line| !line.is_empty()) {
            println!("cargo::error={line}");
        }
    }
}

fn make() -> Result<()> {
    let out_dir = PathBuf::from(env::var("OUT_DIR")?);
    let constants = glsl::constants();
    let sources = sources_hash(&constants)?;
    #[cfg(feature = "shaderc")]
    let modules = compile::all(&out_dir, constants, sources)?;
    #[cfg(not(feature = "shaderc"))]
    let modules = stored::all(sources)?;
    fs::write(out_dir.join("shaders.rs"), rust(&modules)?)?;
    Ok(())
}

/// The files of a folder, in the order of their names.
fn files(folder: &str) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{folder}: {error}"))?;
    let mut files = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_file() {
            files.push(entry.path());
        }
    }
    files.sort();
    Ok(files)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Of all that the SPIR-V is made of, whatever the ends of its lines.
fn sources_hash(constants: &str) -> Result<u64> {
    let mut hash = fnv1a(FNV_START, constants.as_bytes());
    for path in files(SHADERS)?.into_iter().chain(files(INCLUDES)?) {
        let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        hash = fnv1a(hash, name(&path).as_bytes());
        hash = text.lines().fold(hash, |hash, line| fnv1a(fnv1a(hash, line.as_bytes()), b"\n"));
    }
    Ok(hash)
}

/// The modules as constants, and a list of all.
fn rust(modules: &[Module]) -> Result<String> {
    let mut text = String::new();
    let mut all = String::new();
    for (file, words) in modules {
        let name = file.replace(['.', '-'], "_").to_uppercase();
        writeln!(text, "/// SPIR-V of `{SHADERS}/{file}`.")?;
        writeln!(text, "pub const {name}: &[u32] = &{words:?};")?;
        write!(all, "(\"{file}\", {name}), ")?;
    }
    writeln!(text, "/// Every shader: the name of its file and its SPIR-V.")?;
    writeln!(text, "pub const ALL: &[(&str, &[u32])] = &[{all}];")?;
    Ok(text)
}
