//! Scenes that pages post.

use super::hall::Studio;
use super::scenes::Held;
use super::server::{fault, json_of};
use crate::session::config::Settings;
use axum::body::{Body, BodyDataStream};
use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use futures_util::StreamExt;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;
use tokio::io::AsyncWriteExt;

/// Most bytes of a scene.
pub const MOST: u64 = 512 << 20;

/// Files that klieg reads, by the ends of their names.
const KINDS: [&str; 5] = ["glb", "gltf", "ply", "stl", "obj"];

/// What is posted.
#[derive(Debug, Deserialize)]
pub struct Posted {
    /// The file's name.
    name: String,
}

/// Takes in a scene and tells of it.
pub async fn scene(
    State(studio): State<Arc<Studio>>,
    Query(Posted { name }): Query<Posted>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    let declared = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok());
    if declared.and_then(|length| length.parse().ok()).is_some_and(|length: u64| length > MOST) {
        return too_large();
    }
    let (folder, path) = match place(&studio.uploads, &name) {
        Ok(place) => place,
        Err(message) => return fault(StatusCode::BAD_REQUEST, &message),
    };
    match receive(&path, body.into_data_stream(), MOST).await {
        Ok(()) => load(studio, (name, path, folder)).await,
        Err(Broken::TooLarge) => too_large(),
        Err(Broken::Off(error)) => fault(StatusCode::BAD_REQUEST, &error),
    }
}

fn too_large() -> Response {
    let message = format!("the scene is larger than {} MiB", MOST >> 20);
    fault(StatusCode::PAYLOAD_TOO_LARGE, &message)
}

/// A new folder and the file in it; it is called by a name of its own, whatever it was called before.
fn place(uploads: &Path, name: &str) -> Result<(TempDir, PathBuf), String> {
    let kind = Path::new(name).extension().map(|end| end.to_string_lossy().to_lowercase());
    let kind = kind.filter(|kind| KINDS.contains(&kind.as_str())).ok_or_else(|| {
        format!("'{name}' is no scene that klieg reads: there are .{}", KINDS.join(", ."))
    })?;
    let folder = tempfile::tempdir_in(uploads);
    let folder = folder.map_err(|error| format!("there is no place to keep the scene: {error}"))?;
    let path = folder.path().join(format!("scene.{kind}"));
    Ok((folder, path))
}

/// Why a post has not come.
enum Broken {
    TooLarge,
    Off(String),
}

/// Writes what comes, `most` bytes of it, to a file.
async fn receive(path: &Path, mut body: BodyDataStream, most: u64) -> Result<(), Broken> {
    let off = |error: &dyn std::fmt::Display| Broken::Off(format!("the scene broke off: {error}"));
    let mut file = tokio::fs::File::create(path).await.map_err(|error| off(&error))?;
    let mut length = 0;
    while let Some(piece) = body.next().await {
        let piece = piece.map_err(|error| off(&error))?;
        length += piece.len() as u64;
        if length > most {
            return Err(Broken::TooLarge);
        }
        file.write_all(&piece).await.map_err(|error| off(&error))?;
    }
    file.flush().await.map_err(|error| off(&error))
}

async fn load(studio: Arc<Studio>, (name, path, folder): (String, PathBuf, TempDir)) -> Response {
    let work = move || {
        let id = format!("{:016x}", rand::random::<u64>());
        // What a page posts is alone in its folder, and says nothing of how the scene of the command line is looked at.
        let view = crate::session::config::ViewSettings {
            size: studio.settings.view.size,
            ..Default::default()
        };
        let settings = Settings { view, allow_outside: false, ..studio.settings.clone() };
        let held = Held::load((id, name.clone()), &path, Some(folder), &settings);
        let shown = path.display().to_string();
        held.map(|held| studio.scenes.add(held).info.clone())
            .map_err(|error| error.to_string().replace(&shown, &name))
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(info)) => json_of(&info),
        Ok(Err(message)) => fault(StatusCode::BAD_REQUEST, &message),
        Err(panic) => fault(StatusCode::INTERNAL_SERVER_ERROR, &panic.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without a length nothing can be refused by it.
    #[tokio::test]
    async fn a_stream_is_cut_off_where_it_is_too_long() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        let pieces = || {
            let pieces = (0..100).map(|_| Ok::<_, std::io::Error>(vec![7u8; 100]));
            Body::from_stream(futures_util::stream::iter(pieces)).into_data_stream()
        };
        assert!(matches!(receive(&path, pieces(), 9_999).await, Err(Broken::TooLarge)));
        assert!(std::fs::metadata(&path).unwrap().len() < 10_000);
        assert!(receive(&path, pieces(), 10_000).await.is_ok());
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 10_000);
    }

    #[test]
    fn files_are_called_by_names_of_klieg_s_own() {
        let uploads = tempfile::tempdir().unwrap();
        for name in ["a.glb", "../../b.GLTF", "/etc/c.obj"] {
            let (folder, path) = place(uploads.path(), name).ok().unwrap();
            assert_eq!(path.parent(), Some(folder.path()));
            assert_eq!(folder.path().parent(), Some(uploads.path()));
        }
        for name in ["", "glb", "a", "a.exe", ".glb", "../.."] {
            assert!(place(uploads.path(), name).is_err(), "{name}");
        }
    }
}
