//! How files of a run come to stand in the output folder: together, or not at all, and never in the place
//! of what the run was made of.

use crate::{Error, Result};
use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// What names of staging folders begin with.
const PREFIX: &str = ".klieg-staging-";

/// The staging folders of this process, for one that has to end at once.
static OPEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Files that a run reads, which its outputs must not replace.
#[derive(Debug, Clone, Default)]
pub struct Inputs(HashSet<PathBuf>);

impl Inputs {
    /// Those at these paths; what is not there needs no care.
    pub fn new<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Self {
        Self(paths.into_iter().filter_map(|path| path.as_ref().canonicalize().ok()).collect())
    }

    /// Takes more of them.
    pub fn extend(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// Whether files of these names may come to stand in the folder `target`.
    ///
    /// # Errors
    /// [`Error::Argument`] where one would replace an input, or a folder has its name.
    pub fn spare<N: AsRef<OsStr>>(
        &self,
        target: &Path,
        names: impl IntoIterator<Item = N>,
    ) -> Result<()> {
        for name in names {
            let path = target.join(name.as_ref());
            let Ok(real) = path.canonicalize() else { continue };
            let path = path.display();
            if self.0.contains(&real) {
                let fault = format!("{path} would be overwritten: choose another --out");
                return Err(Error::Argument(fault));
            }
            if real.is_dir() {
                let fault = format!("{path} is a folder, not a file: choose another --out");
                return Err(Error::Argument(fault));
            }
        }
        Ok(())
    }
}

/// A hidden folder inside the output folder, which holds a run's files until all are complete. What
/// processes that were killed have left of theirs is removed by the next one.
#[derive(Debug)]
pub struct Staging {
    target: PathBuf,
    folder: tempfile::TempDir,
    /// Locked as long as this process lives: others know by it that the folder is in use.
    _lock: Option<File>,
    names: Vec<OsString>,
    inputs: Inputs,
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
        // As long as the target is locked, nobody looks for folders without a lock in it.
        let looking = locked(target, 100);
        if looking.is_some() {
            remove_left(target);
        }
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(target).map_err(fault)?;
        let _lock = locked(folder.path(), 1);
        open().push(folder.path().into());
        let (target, inputs) = (target.into(), Inputs::default());
        Ok(Self { target, folder, _lock, names: Vec::new(), inputs })
    }

    /// The same, but what is published must not replace `inputs`.
    #[must_use]
    pub fn sparing(mut self, inputs: Inputs) -> Self {
        self.inputs.extend(inputs);
        self
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
    /// [`Error::Argument`], before any file is moved, where one would replace an input or a folder has its
    /// name, and [`Error::Output`].
    pub fn publish(self) -> Result<Vec<PathBuf>> {
        self.inputs.spare(&self.target, &self.names)?;
        // Whoever publishes into the same folder waits, so that all files are of one run.
        let _publishing = locked(&self.target, 1000);
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

impl Drop for Staging {
    fn drop(&mut self) {
        open().retain(|folder| folder != self.folder.path());
    }
}

/// Removes the staging folders of this process, which ends at once.
pub fn abandon() {
    for folder in open().drain(..) {
        // What cannot be removed now, a later run removes.
        let _ = std::fs::remove_dir_all(folder);
    }
}

fn open() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder's lock, which goes with the file or the process; none where the system has no such locks, or
/// another process has it for as long as `tries` tries.
fn locked(folder: &Path, tries: usize) -> Option<File> {
    let file = File::open(folder).ok()?;
    for _ in 0..tries {
        match file.try_lock() {
            Ok(()) => return Some(file),
            Err(std::fs::TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(5)),
            Err(std::fs::TryLockError::Error(_)) => return None,
        }
    }
    None
}

/// Removes staging folders that no process has locked.
fn remove_left(target: &Path) {
    for entry in std::fs::read_dir(target).into_iter().flatten().flatten() {
        let is_staging = entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes())
            && entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_staging && locked(&entry.path(), 1).is_some() {
            // Whoever removes it first has done it; a folder of another user stays.
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visible(target: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(target).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<_> = entries.map(|n| n.into_string().unwrap()).collect();
        names.retain(|name| !name.starts_with('.'));
        names.sort();
        names
    }

    #[test]
    fn nothing_is_there_before_all_is() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a/b");
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

    #[test]
    fn inputs_and_folders_are_not_replaced_and_nothing_is_moved_then() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path();
        std::fs::write(target.join("input"), "precious").unwrap();
        std::fs::create_dir(target.join("folder")).unwrap();
        for (name, fault) in [("input", "would be overwritten"), ("folder", "is a folder")] {
            let inputs = Inputs::new([target.join("input"), target.join("absent")]);
            let mut staging = Staging::new(target).unwrap().sparing(inputs);
            staging.write("first", "1").unwrap();
            staging.write(name, "2").unwrap();
            let error = staging.publish().unwrap_err();
            assert!(error.is_input() && error.to_string().contains(fault), "{error}");
            assert_eq!(visible(target), ["folder", "input"]);
        }
        assert_eq!(std::fs::read(target.join("input")).unwrap(), b"precious");
    }

    #[test]
    #[cfg(unix)]
    fn what_a_killed_process_left_goes_and_what_is_in_use_stays() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path();
        let left = target.join(format!("{PREFIX}abc123"));
        std::fs::create_dir(&left).unwrap();
        std::fs::write(left.join("best.png"), "half").unwrap();
        // Neither of these is klieg's.
        std::fs::create_dir(target.join(".klieg-backup")).unwrap();
        let file = target.join(format!("{PREFIX}file"));
        std::fs::write(&file, "a file").unwrap();
        let mut first = Staging::new(target).unwrap();
        first.write("one", "1").unwrap();
        let second = Staging::new(target).unwrap();
        assert!(!left.exists() && file.exists() && target.join(".klieg-backup").exists());
        drop(second);
        assert_eq!(first.publish().unwrap(), [target.join("one")]);
    }
}
