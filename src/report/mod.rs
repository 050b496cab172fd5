//! What is written for people and other programs: pictures, plots, tables, arrays and sheets.
//!
//! Files of one run appear together: they are made in a [`Staging`] folder and moved to their place
//! when all are there.

pub mod csv;
pub mod exhibit;
pub mod html;
pub mod json;
pub mod npy;
pub mod paper;
pub mod picture;
pub mod plot;

use crate::{Error, Result};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// A hidden folder inside the output folder, which holds a run's files until all are complete.
#[derive(Debug)]
pub struct Staging {
    target: PathBuf,
    folder: tempfile::TempDir,
    names: Vec<OsString>,
}

impl Staging {
    /// Creates `target`, with its parents, where it is absent.
    ///
    /// # Errors
    /// [`Error::Output`] when it cannot be created or written to.
    pub fn new(target: &Path) -> Result<Self> {
        let fault = |source| Error::Output { path: target.into(), source };
        if target.is_file() {
            return Err(fault(std::io::Error::other("it is a file, not a folder")));
        }
        std::fs::create_dir_all(target).map_err(fault)?;
        let folder =
            tempfile::Builder::new().prefix(".klieg-").tempdir_in(target).map_err(fault)?;
        Ok(Self { target: target.into(), folder, names: Vec::new() })
    }

    /// Where to write the file `name` for now.
    pub fn path(&mut self, name: impl AsRef<OsStr>) -> PathBuf {
        self.names.push(name.as_ref().into());
        self.folder.path().join(name.as_ref())
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// [`Error::Output`] that names the file in its final place.
    pub fn write(&mut self, name: impl AsRef<OsStr>, contents: impl AsRef<[u8]>) -> Result<()> {
        let path = self.path(&name);
        std::fs::write(path, contents)
            .map_err(|source| Error::Output { path: self.target.join(name.as_ref()), source })
    }

    /// Moves all files to their places, and gives these in order of writing. Files of an earlier run
    /// are replaced.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn publish(self) -> Result<Vec<PathBuf>> {
        let publish = |name: &OsString| {
            let path = self.target.join(name);
            match std::fs::rename(self.folder.path().join(name), &path) {
                Ok(()) => Ok(path),
                Err(source) => Err(Error::Output { path, source }),
            }
        };
        self.names.iter().map(publish).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_there_before_all_is() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a/b");
        let visible = |target: &Path| {
            let entries = std::fs::read_dir(target).unwrap().map(|e| e.unwrap().file_name());
            let mut names: Vec<_> = entries.map(|n| n.into_string().unwrap()).collect();
            names.retain(|name| !name.starts_with('.'));
            names.sort();
            names
        };
        let mut staging = Staging::new(&target).unwrap();
        staging.write("one", "1").unwrap();
        staging.write("two", "2").unwrap();
        assert!(visible(&target).is_empty());
        assert_eq!(staging.publish().unwrap(), [target.join("one"), target.join("two")]);
        assert_eq!(visible(&target), ["one", "two"]);
        assert_eq!(std::fs::read_dir(&target).unwrap().count(), 2);

        drop(Staging::new(&target).unwrap());
        assert_eq!(visible(&target), ["one", "two"]);
        assert!(matches!(Staging::new(&target.join("one")), Err(Error::Output { .. })));
    }
}
