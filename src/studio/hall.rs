//! What all pages share, and the scene that one of them looks at.

use super::scenes::{Held, Scenes};
use crate::session::config::Settings;
use crate::session::device::Opened;
use rayon::ThreadPool;
use std::sync::Arc;

/// What all pages share.
pub struct Studio {
    /// The settings of the command line.
    pub settings: Settings,
    /// What computes.
    pub device: Opened,
    /// The scenes.
    pub scenes: Scenes,
    /// For work that no hand waits for: it has threads of its own, so that it never stands before what a hand waits for.
    pub background: ThreadPool,
}

/// A scene that a page looks at.
#[derive(Clone)]
pub struct Hall {
    /// What all pages share.
    pub studio: Arc<Studio>,
    /// The scene.
    pub held: Arc<Held>,
}

impl Hall {
    /// The settings of the command line.
    pub fn settings(&self) -> &Settings {
        &self.studio.settings
    }
}
