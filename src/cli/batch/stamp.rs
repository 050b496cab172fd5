//! What a design was made of, and whether it is still there.

use super::items::Item;
use crate::cli::config::Settings;
use crate::cli::designer::{FILES, RESULT};
use crate::report::json;
use crate::scene::Scene;
use crate::scene::load::files;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// The stamp's file beside a design's own.
pub const STAMP: &str = "item.json";

/// Most bytes of what an earlier run has left.
const MAX_BYTES: u64 = 64 << 20;

/// `item.json`.
#[derive(Serialize)]
struct Stamp<'a> {
    schema: &'static str,
    klieg: &'static str,
    settings: &'a Settings,
    files: &'a [FileStamp],
    #[serde(flatten)]
    scores: Scores,
}

/// What tells a file from a changed one.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct FileStamp {
    /// The real path.
    path: String,
    bytes: u64,
    /// Time of the last change, nanoseconds since 1970.
    modified_ns: u64,
}

/// `F` before and after a design.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Under the headlight.
    pub headlight: f32,
    /// Under the designed lights.
    pub score: f32,
}

impl FileStamp {
    fn of(path: &Path) -> std::io::Result<Self> {
        let (path, metadata) = (path.canonicalize()?, path.metadata()?);
        let age = metadata.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
        Ok(Self {
            path: path.to_string_lossy().into_owned(),
            bytes: metadata.len(),
            modified_ns: u64::try_from(age.as_nanos()).unwrap_or(u64::MAX),
        })
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

/// The content of `item.json`.
///
/// # Errors
/// As [`json::text`].
pub fn text(
    settings: &Settings,
    files: &[FileStamp],
    scores: Scores,
) -> serde_json::Result<String> {
    let (schema, klieg) = ("klieg.item/1", env!("CARGO_PKG_VERSION"));
    json::text(&Stamp { schema, klieg, settings, files, scores })
}

/// Takes the stamp away: until the next one is there, the design counts as unfinished.
///
/// # Errors
/// [`Error::Output`].
pub fn remove(folder: &Path) -> Result<()> {
    let path = folder.join(STAMP);
    match std::fs::remove_file(&path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::Output { path, source }),
        _ => Ok(()),
    }
}

/// The scores of an item whose design in `folder` is complete, and made by this version with the
/// item's settings of the files as they are now.
pub fn finished(item: &Item, folder: &Path) -> Option<Scores> {
    let read =
        |name| serde_json::from_slice(&files::read(&folder.join(name), MAX_BYTES).ok()?).ok();
    let (stamp, result): (Value, Value) = (read(STAMP)?, read(RESULT)?);
    let files = Vec::<FileStamp>::deserialize(&stamp["files"]).ok()?;
    let scores = Scores::deserialize(&stamp).ok()?;
    let wanted: Value = serde_json::from_str(&text(&item.settings, &files, scores).ok()?).ok()?;
    let unchanged =
        |file: &FileStamp| FileStamp::of(Path::new(&file.path)).is_ok_and(|now| now == *file);
    let scene = FileStamp::of(&item.scene).ok()?;
    let same = wanted == stamp && files.first() == Some(&scene) && files.iter().all(unchanged);
    let whole = FILES.iter().all(|name| folder.join(name).is_file())
        && result["score"] == stamp["score"]
        && result["headlight"]["score"] == stamp["headlight"];
    (same && whole).then_some(scores)
}
