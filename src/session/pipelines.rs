//! Compiled pipelines in the user's cache folder, so that a later run need not compile them again.
//!
//! There is one file for each device, driver and version of klieg. Whatever goes wrong with them costs time
//! and nothing else, so none of it is an error.

use crate::gpu::Context;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;
use std::{env, io};

/// A file that is larger is not read, and not written.
const MAX_BYTES: u64 = 32 << 20;
/// The files that were written last stay.
const MAX_FILES: usize = 4;
const PREFIX: &str = "pipelines-";

/// A context whose pipelines are stored at the end, for the next run.
pub struct Stored {
    /// The context.
    pub context: Arc<Context>,
    folder: Option<PathBuf>,
    /// What was stored before.
    earlier: Vec<u8>,
}

impl Stored {
    /// Of a context that began with `earlier`, of [`load`].
    pub fn new(context: Arc<Context>, folder: Option<PathBuf>, earlier: Vec<u8>) -> Self {
        Self { context, folder, earlier }
    }
}

impl Drop for Stored {
    fn drop(&mut self) {
        let Some(folder) = &self.folder else { return };
        let key = self.context.report().pipeline_cache_key;
        match self.context.pipeline_cache_data() {
            Ok(data) if data != self.earlier && data.len() as u64 <= MAX_BYTES => {
                // The next run compiles them again.
                let _ = store(folder, key, &data);
            }
            _ => {}
        }
    }
}

/// The user's cache folder for klieg, by the XDG base directory specification.
pub fn folder() -> Option<PathBuf> {
    let absolute = |name| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(caches.join("klieg"))
}

fn file(folder: &Path, key: u64) -> PathBuf {
    folder.join(format!("{PREFIX}{key:016x}"))
}

/// What an earlier run has stored for `key`; empty where there is nothing that can be read.
pub fn load(folder: &Path, key: u64) -> Vec<u8> {
    let read = || -> io::Result<Vec<u8>> {
        let path = file(folder, key);
        let found = fs::metadata(&path)?;
        if !found.is_file() || found.len() > MAX_BYTES {
            return Ok(Vec::new());
        }
        let mut data = Vec::new();
        File::open(path)?.take(MAX_BYTES).read_to_end(&mut data)?;
        Ok(data)
    };
    read().unwrap_or_default()
}

/// Puts `data` in the place of what was stored for `key`, whole or not at all, and removes the oldest of
/// too many files.
fn store(folder: &Path, key: u64, data: &[u8]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let mut made = tempfile::Builder::new().prefix(PREFIX).tempfile_in(folder)?;
    made.write_all(data)?;
    made.persist(file(folder, key))?;
    let mut files: Vec<(SystemTime, PathBuf)> = fs::read_dir(folder)?
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX))
        .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
        .collect();
    files.sort();
    let spare = files.len().saturating_sub(MAX_FILES);
    files.drain(..spare).try_for_each(|(_, path)| fs::remove_file(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{ContextOptions, Tuning};
    use std::time::Duration;

    /// A run that stores its pipelines, and how many bytes of earlier ones its driver began with.
    fn run(folder: &Path) -> u64 {
        let key = crate::gpu::devices().expect("devices")[0].pipeline_cache_key;
        let earlier = load(folder, key);
        let tuning = Tuning { pipeline_cache: earlier.clone(), ..Tuning::default() };
        let device = crate::gpu::DeviceChoice::Index(0);
        let options = ContextOptions { device, tuning, ..ContextOptions::default() };
        let context = Context::new(&options).expect("a Vulkan device");
        let begun = context.counters().pipeline_cache;
        drop(Stored::new(context, Some(folder.to_owned()), earlier));
        begun
    }

    fn only_file(folder: &Path) -> PathBuf {
        let entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        let [path] = &entries[..] else { panic!("{entries:?}") };
        path.clone()
    }

    #[test]
    fn a_second_run_begins_with_the_pipelines_of_the_first() {
        let folder = tempfile::tempdir().unwrap();
        let klieg = folder.path().join("a/klieg");
        assert_eq!(run(&klieg), 0);
        let begun = run(&klieg);
        assert!(begun >= 32);
        let path = only_file(&klieg);
        let whole = fs::read(&path).unwrap();
        for broken in [&whole[..whole.len() - 1], b"", b"something else"] {
            fs::write(&path, broken).unwrap();
            assert_eq!(run(&klieg), 0, "a damaged file counts as none");
            assert_eq!(run(&klieg), begun, "and is replaced");
        }
    }

    #[test]
    fn files_are_bounded_in_size_and_number() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let other = folder.join("of-another-program");
        fs::write(&other, "x").unwrap();
        for key in 0..=MAX_FILES as u64 {
            store(folder, key, b"data").unwrap();
            let age = Duration::from_secs(1000 - key);
            let stored = File::options().write(true).open(file(folder, key)).unwrap();
            stored.set_modified(SystemTime::now() - age).unwrap();
        }
        store(folder, 9, b"data").unwrap();
        let there = |key: &u64| file(folder, *key).exists();
        assert_eq!((0..10).filter(there).collect::<Vec<_>>(), [2, 3, 4, 9]);
        assert!(other.exists());
        assert_eq!(load(folder, 9), b"data");
        File::create(file(folder, 9)).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert_eq!(load(folder, 9), b"");
    }

    #[test]
    fn what_cannot_be_stored_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("klieg");
        fs::write(&taken, "a file").unwrap();
        assert_eq!((run(&taken), run(&taken)), (0, 0));
        assert_eq!(load(&taken, 1), b"");
        fs::create_dir_all(file(folder.path(), 1)).unwrap();
        assert_eq!(load(folder.path(), 1), b"");
        assert!(store(folder.path(), 1, b"data").is_err());
    }
}
