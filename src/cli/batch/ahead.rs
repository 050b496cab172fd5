//! The thread that loads the next scene while the present one is designed.

use super::guarded;
use crate::cli::file_stamp::FileStamp;
use crate::cli::session::Loaded;
use crate::scene::load::LoadOptions;
use anyhow::Result;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

/// A scene that waits for its design.
#[derive(Clone)]
pub struct Ready {
    /// The scene.
    pub scene: Loaded,
    /// Its files as they were when it was loaded.
    pub files: Arc<[FileStamp]>,
}

impl Ready {
    /// Loads a scene.
    ///
    /// # Errors
    /// [`crate::Error::Input`].
    pub fn read(path: &Path, options: &LoadOptions) -> Result<Self> {
        let scene = Loaded::read(path, options)?;
        Ok(Self { files: FileStamp::all(&scene.scene)?.into(), scene })
    }
}

/// Loads scenes in turn and hands each over. One that is asked for again at once is not loaded again.
/// Ends early when nobody takes them any more.
pub fn load_ahead<'a>(
    paths: impl Iterator<Item = &'a Path>,
    options: &LoadOptions,
    taker: &SyncSender<Result<Ready>>,
) {
    let mut last: Option<Ready> = None;
    for path in paths {
        // What is of no more use goes before the next scene is read.
        let mut again = last.take().filter(|ready| ready.scene.scene.path == path);
        if let Some(ready) = &mut again {
            ready.scene.load = 0.0;
        }
        let ready = again.map_or_else(|| guarded(|| Ready::read(path, options)), Ok);
        last = ready.as_ref().ok().cloned();
        if taker.send(ready).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::exit_code;
    use std::sync::mpsc;

    #[test]
    fn views_of_a_scene_share_it_and_a_fault_is_handed_over() {
        let scene = |name| Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
        let [pair, elephant, gone] = ["pair.glb", "elephant.glb", "gone.glb"].map(scene);
        let paths: [&Path; 5] = [&pair, &pair, &gone, &pair, &elephant];
        let (sender, scenes) = mpsc::sync_channel(0);
        let loaded: Vec<_> = std::thread::scope(|scope| {
            scope.spawn(move || load_ahead(paths.into_iter(), &LoadOptions::default(), &sender));
            scenes.iter().map(|ready| ready.map(|ready| ready.scene)).collect()
        });
        let [Ok(first), Ok(second), Err(fault), Ok(third), Ok(last)] = &loaded[..] else {
            panic!("{} scenes", loaded.len());
        };
        assert!(Arc::ptr_eq(&first.scene, &second.scene) && second.load == 0.0);
        assert!(exit_code(fault) == 2 && fault.to_string().contains("gone.glb"));
        assert!(!Arc::ptr_eq(&first.scene, &third.scene) && third.load > 0.0);
        assert_eq!((&third.scene.path, &last.scene.path), (&pair, &elephant));
    }

    #[test]
    fn nobody_who_takes_scenes_ends_the_thread() {
        let (sender, scenes) = mpsc::sync_channel(0);
        drop(scenes);
        let paths = std::iter::repeat(Path::new("gone.glb"));
        load_ahead(paths, &LoadOptions::default(), &sender);
    }
}
