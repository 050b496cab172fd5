//! What a design was made of, and whether it is still there.

use super::items::Item;
use crate::cli::config::Settings;
use crate::cli::designer::{FILES, RESULT};
use crate::cli::file_stamp::FileStamp;
use crate::report::json;
use crate::scene::load::files;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;

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

/// `F` before and after a design.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Under the headlight.
    pub headlight: f32,
    /// Under the designed lights.
    pub score: f32,
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
    let scene = FileStamp::of(&item.scene).ok()?;
    let same =
        wanted == stamp && files.first() == Some(&scene) && files.iter().all(FileStamp::holds);
    let whole = FILES.iter().all(|name| folder.join(name).is_file())
        && result["score"] == stamp["score"]
        && result["headlight"]["score"] == stamp["headlight"];
    (same && whole).then_some(scores)
}
