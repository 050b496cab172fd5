//! What all pages share, and the scene that one of them looks at.

use super::messages::{Camera, Look};
use super::scenes::{Held, Scenes};
use crate::Result;
use crate::design::Intent;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::session::config::Settings;
use crate::session::device::Opened;
use rayon::ThreadPool;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// What all pages share.
pub struct Studio {
    /// The settings of the command line, without what its intent makes of them.
    pub settings: Settings,
    /// What computes.
    pub device: Opened,
    /// The scenes.
    pub scenes: Scenes,
    /// Folder of the scenes that are posted.
    pub uploads: PathBuf,
    /// For work that no hand waits for: it has threads of its own, so that it never stands before what a hand waits for.
    pub background: ThreadPool,
}

impl Studio {
    /// The settings with what an intent makes of them.
    ///
    /// # Errors
    /// As [`Settings::steered`].
    pub fn steered(&self, intent: Intent) -> Result<Settings> {
        Settings { intent, ..self.settings.clone() }.steered()
    }
}

/// A scene that a page looks at.
#[derive(Clone)]
pub struct Hall {
    /// What all pages share.
    pub studio: Arc<Studio>,
    /// The scene.
    pub held: Arc<Held>,
    /// What casts shadows in the light frame of the last camera, which all views through it share.
    occluders: Arc<Mutex<LastOccluders>>,
}

/// A camera, and what casts shadows in its light frame.
type LastOccluders = Option<(Camera, Arc<Occluders>)>;

impl Hall {
    /// Of a scene that a page begins to look at.
    pub fn new(studio: Arc<Studio>, held: Arc<Held>) -> Self {
        Self { studio, held, occluders: Arc::default() }
    }

    /// What casts shadows in `view`, whose camera messages call `camera`; nothing where the settings have none.
    ///
    /// # Errors
    /// As [`Occluders::new`].
    pub fn occluders(&self, camera: &Camera, view: &View) -> Result<Option<Arc<Occluders>>> {
        if !self.settings().shadows.on {
            return Ok(None);
        }
        let mut last = self.occluders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, occluders)) = &*last
            && known == camera
        {
            return Ok(Some(Arc::clone(occluders)));
        }
        let occluders = Arc::new(Occluders::new(&self.held.scene, view)?);
        *last = Some((camera.clone(), Arc::clone(&occluders)));
        Ok(Some(occluders))
    }

    /// The settings of what a look wants: boxes, objective and wishes for objects.
    ///
    /// # Errors
    /// As [`Studio::steered`] and [`Look::objective`].
    pub fn wanted(&self, look: &Look) -> Result<Settings> {
        let steered = self.studio.steered(look.intent)?;
        let objective = look.objective(&steered.objective)?;
        let (focus, dim) = (look.focus.clone(), look.dim.clone());
        Ok(Settings { objective, focus, dim, ..steered })
    }

    /// As [`Studio::settings`].
    pub fn settings(&self) -> &Settings {
        &self.studio.settings
    }
}
