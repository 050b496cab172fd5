//! The checked-in SPIR-V.

use super::{Module, Result, SHADERS, files, name};
use crate::hash::{FNV_START, fnv1a};
use std::fs;

/// Where it is.
pub const FOLDER: &str = "src/gpu/spirv";

/// The module of every shader, if they are what the sources with this hash give.
pub fn all(sources: u64) -> Result<Vec<Module>> {
    let manifest = format!("{FOLDER}/manifest");
    let told = fs::read_to_string(&manifest).map_err(|error| format!("{manifest}: {error}"))?;
    let mut modules = Vec::new();
    let mut hash = FNV_START;
    for shader in files(SHADERS)? {
        let file = name(&shader);
        let path = format!("{FOLDER}/{file}.spv");
        let bytes = fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
        hash = fnv1a(hash, &bytes);
        let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        modules.push((file, words.collect()));
    }
    for (what, hash) in [("sources", sources), ("modules", hash)] {
        if !told.lines().any(|line| line == format!("{what} {hash:016x}")) {
            let fault = format!("{FOLDER} is of other {what}: make it anew with `make spirv`");
            return Err(fault.into());
        }
    }
    Ok(modules)
}
