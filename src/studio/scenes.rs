//! Scenes that pages look at, each loaded once.

use super::answers::{NamedCamera, SceneInfo};
use super::convert::orbit;
use super::messages::{Document, Light};
use super::session_file;
use crate::scene::load::LoadOptions;
use crate::scene::view::bounds;
use crate::scene::{self, Scene};
use crate::session::config::Settings;
use crate::session::{focus, view};
use crate::{Error, Result};
use glam::DVec3;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;

/// Scenes that are kept though no page may look at them.
const KEPT: usize = 4;

/// Most objects whose names pages are told.
const MOST_OBJECTS: usize = 400;

/// A scene that pages look at.
pub struct Held {
    /// What messages call it.
    pub id: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its centre and its radius.
    pub bounds: (DVec3, f64),
    /// Its file.
    pub source: PathBuf,
    /// How that was loaded.
    pub options: LoadOptions,
    /// What pages are told of it.
    pub info: SceneInfo,
    /// The folder of a file that was posted, which goes with the scene.
    _folder: Option<TempDir>,
}

impl Held {
    /// Loads the file `source`, which messages call `id` and people `name`.
    ///
    /// # Errors
    /// [`crate::Error::Input`], and faults of the settings.
    pub fn load(
        (id, name): (String, String),
        source: &Path,
        folder: Option<TempDir>,
        settings: &Settings,
    ) -> Result<Self> {
        let options = settings.loading();
        let scene = Arc::new(scene::load::load_with(source, options.clone())?);
        let document = session_file::document(source);
        let bounds = bounds(&scene)?;
        let info = info((id.clone(), name), &scene, bounds, document, settings)?;
        let source = source.to_owned();
        Ok(Self { id, scene, bounds, source, options, info, _folder: folder })
    }
}

/// What pages are told of a scene.
fn info(
    (id, name): (String, String),
    scene: &Scene,
    bounds: (DVec3, f64),
    mut document: Option<Document>,
    settings: &Settings,
) -> Result<SceneInfo> {
    let view = view(scene, &settings.view)?;
    let said = |camera: &scene::view::Camera| {
        let named = scene.cameras.iter().any(|own| own.name == camera.name);
        let named = named.then(|| camera.name.clone());
        super::messages::Camera { named, ..orbit(camera, bounds) }
    };
    let named = |camera: &scene::view::Camera| NamedCamera {
        name: camera.name.clone(),
        camera: said(camera),
    };
    let mut warnings = scene.warnings.clone();
    let lights = match scene.lights.is_empty() {
        true => Vec::new(),
        false => match scene::lights::rig(scene, &view) {
            Ok((rig, more)) => {
                warnings.extend(more);
                Light::all(&rig)
            }
            Err(fault) => {
                warnings.push(fault.to_string());
                Vec::new()
            }
        },
    };
    if let Some(document) = &mut document {
        document.scene = Some(id.clone());
    }
    Ok(SceneInfo {
        id,
        name,
        triangles: scene.polygons(),
        center: bounds.0.to_array(),
        radius: bounds.1,
        objects: objects(scene),
        cameras: scene.cameras.iter().map(named).collect(),
        camera: said(&view.camera),
        size: [view.width, view.height],
        lights,
        document,
        warnings,
    })
}

/// The names of its objects, each once; of more than [`MOST_OBJECTS`] none.
fn objects(scene: &Scene) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut known = HashSet::new();
    for instance in &scene.instances {
        let name = focus::object_name(scene, instance);
        if !name.is_empty() && known.insert(name) {
            names.push(name.into());
        }
    }
    if names.len() > MOST_OBJECTS { Vec::new() } else { names }
}

/// The fault of a scene that is not here.
pub fn gone() -> Error {
    Error::Argument("the scene is here no more: post it again".into())
}

/// The scenes that there are: those of the last posts, and the command line's for good.
pub struct Scenes {
    first: Option<Arc<Held>>,
    posted: Mutex<Vec<Arc<Held>>>,
}

impl Scenes {
    /// With the scene of the command line, if there is one.
    pub fn new(first: Option<Held>) -> Self {
        Self { first: first.map(Arc::new), posted: Mutex::default() }
    }

    /// Takes in a scene that was posted; the oldest of too many leaves.
    pub fn add(&self, held: Held) -> Arc<Held> {
        let held = Arc::new(held);
        let mut posted = self.posted.lock().unwrap_or_else(PoisonError::into_inner);
        if posted.len() >= KEPT {
            posted.remove(0);
        }
        posted.push(Arc::clone(&held));
        held
    }

    /// The scene of that id; without one that of the command line, if there is any.
    ///
    /// # Errors
    /// [`Error::Argument`] for a scene that is here no more.
    pub fn find(&self, id: Option<&str>) -> Result<Option<Arc<Held>>> {
        let Some(id) = id else { return Ok(self.first.clone()) };
        let posted = self.posted.lock().unwrap_or_else(PoisonError::into_inner);
        let held = posted.iter().chain(&self.first).find(|held| held.id == id).cloned();
        held.ok_or_else(gone).map(Some)
    }
}
