//! What tells a file from a changed one, without reading it.

use crate::scene::Scene;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// What tells a file from a changed one.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct FileStamp {
    /// The real path.
    path: String,
    bytes: u64,
    /// Time of the last change, nanoseconds since 1970.
    modified_ns: u64,
}

impl FileStamp {
    /// The stamp of a file as it is now.
    ///
    /// # Errors
    /// Why it cannot be looked at.
    pub fn of(path: &Path) -> std::io::Result<Self> {
        let (path, metadata) = (path.canonicalize()?, path.metadata()?);
        let age = metadata.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
        Ok(Self {
            path: path.to_string_lossy().into_owned(),
            bytes: metadata.len(),
            modified_ns: u64::try_from(age.as_nanos()).unwrap_or(u64::MAX),
        })
    }

    /// Whether the file is still as it was.
    pub fn holds(&self) -> bool {
        Self::of(Path::new(&self.path)).is_ok_and(|now| now == *self)
    }

    /// Stamps of all files of a scene.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that is no longer there.
    pub fn all(scene: &Scene) -> Result<Vec<Self>> {
        let stamp = |path: &PathBuf| Self::of(path).map_err(|fault| Error::input(path, fault));
        scene.files.iter().map(stamp).collect()
    }
}
