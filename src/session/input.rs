//! Files that commands read, of which `-` is standard input.

use crate::scene::load::files;
use crate::{Error, Result};
use std::ffi::OsString;
use std::io::{Read, copy};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use tempfile::TempDir;

/// Most bytes of a scene on standard input: as many as a GLB can have.
const MAX_SCENE: u64 = u32::MAX as u64;

/// The path that stands for standard input and output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The file as faults name it.
pub fn name(path: &Path) -> &Path {
    if is_standard(path) { Path::new("standard input") } else { path }
}

/// A text file, or the text on standard input.
///
/// # Errors
/// [`Error::Input`] for what cannot be read, is longer than `most` bytes, or no text.
pub fn text(path: &Path, most: u64) -> Result<String> {
    if !is_standard(path) {
        return files::text(path, most).map_err(|fault| Error::input(path, fault));
    }
    let fault = |fault: &dyn std::fmt::Display| Error::input("standard input", fault);
    let mut text = String::new();
    let read = std::io::stdin().take(most + 1).read_to_string(&mut text);
    match read.map_err(|error| fault(&error))? {
        length if length as u64 > most => Err(fault(&format!("is longer than {most} bytes"))),
        _ => Ok(text),
    }
}

/// A scene's file. One on standard input is kept in a temporary folder, as scenes are read in any order and more than
/// once; it may name no other files.
#[derive(Debug, Clone)]
pub struct SceneFile {
    given: PathBuf,
    kept: OnceLock<(Arc<TempDir>, PathBuf)>,
}

impl From<OsString> for SceneFile {
    fn from(given: OsString) -> Self {
        Self { given: given.into(), kept: OnceLock::new() }
    }
}

impl SceneFile {
    /// The file that holds it.
    ///
    /// # Errors
    /// [`Error::Input`] when standard input cannot be read, [`Error::Output`] when it cannot be kept.
    pub fn path(&self) -> Result<&Path> {
        if !is_standard(&self.given) {
            return Ok(&self.given);
        }
        if self.kept.get().is_none() {
            // Nobody else can have set it meanwhile.
            let _ = self.kept.set(keep()?);
        }
        Ok(self.kept.get().map_or(&self.given, |(_, file)| file))
    }
}

fn keep() -> Result<(Arc<TempDir>, PathBuf)> {
    let folder = tempfile::Builder::new().prefix("klieg-").tempdir();
    let unkept = |path: &Path, source| Error::Output { path: path.into(), source };
    let folder = folder.map_err(|source| unkept(&std::env::temp_dir(), source))?;
    let path = folder.path().join("standard-input");
    let mut file = std::fs::File::create(&path).map_err(|source| unkept(&path, source))?;
    let mut given = std::io::stdin().take(MAX_SCENE + 1);
    let length = copy(&mut given, &mut file).map_err(|source| unkept(&path, source))?;
    if length > MAX_SCENE {
        return Err(Error::input("standard input", "is longer than the 4 GiB that a GLB can have"));
    }
    Ok((Arc::new(folder), path))
}
