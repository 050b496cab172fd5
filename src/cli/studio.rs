//! `klieg studio`: a page in which people light a model by hand and by search.

use super::input::SceneFile;
use super::options::{LookOptions, SearchOptions, TargetOptions, completed};
use super::picture::PictureOptions;
use super::print;
use crate::design::profile;
use crate::session::config::Settings;
use crate::studio;
use anyhow::{Context, Result};
use clap::Args;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::oneshot;

/// Light a model in the browser, by hand and by search
///
/// Serves a page on this machine alone, at an address with a secret token, and opens it. Ctrl-C ends it.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Scene to begin with: a .gltf or .glb file, or a .ply, .stl or .obj one; '-' for glTF on standard input
    /// [default: the page asks for one]
    scene: Option<SceneFile>,
    /// Port of the server [default: a free one]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the page's address and open no browser
    #[arg(long)]
    no_open: bool,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    target: TargetOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    picture: PictureOptions,
}

impl Options {
    fn settings(&self) -> crate::Result<Settings> {
        let settings = self.look.settings(profile::DEFAULT)?;
        completed(settings, (&self.target, &self.search, &self.picture))
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    let scene = options.scene.as_ref().map(SceneFile::path).transpose()?;
    let (interrupt, interrupted) = oneshot::channel();
    let interrupt = Arc::new(Mutex::new(Some(interrupt)));
    let end = move || {
        let mut interrupt = interrupt.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(interrupt) = interrupt.take() {
            // Nobody listens any more where the server has ended already.
            let _ = interrupt.send(());
        }
    };
    ctrlc::set_handler(end).context("listening for Ctrl-C")?;
    let ready = |address: &str| {
        print::out(format!("studio: {address}\n"))?;
        if !options.no_open
            && let Err(fault) = open::that_detached(address)
        {
            tracing::warn!("no browser opens ({fault}): open the address by hand");
        }
        Ok(())
    };
    let end = async {
        // The sender lives in the handler, for good.
        let _ = interrupted.await;
    };
    studio::serve(scene, options.port, options.settings()?, ready, end)
}
