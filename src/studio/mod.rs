//! `klieg studio`: a server on the loopback interface, and the page in which people light a model by hand and by search.
//!
//! The page owns the document, which is scene, camera, lights, weights and targets; the server computes. Each page has a
//! socket and a thread of its own (`worker`); they share scenes and device (`hall`). What is shown is what is judged:
//! picture and score come from one stored surface and one shadow table (`stage`). `docs/STUDIO_PROTOCOL.md` has the protocol.

mod alternatives;
pub mod answers;
mod convert;
mod guard;
mod hall;
mod landscape;
mod mailbox;
pub mod messages;
mod opening;
mod placing;
mod save;
mod scenes;
#[cfg(test)]
mod schema;
mod searching;
mod server;
mod session_file;
mod socket;
mod stage;
mod steering;
mod task;
mod upload;
mod worker;

use crate::evaluate::DeviceInfo;
use crate::session::config::Settings;
use crate::session::device::{self, Opened};
use crate::session::focus;
use anyhow::{Context, Result};
use axum::serve::ListenerExt;
use guard::Guard;
use hall::Studio;
use scenes::{Held, Scenes};
use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use tokio::net::TcpListener;

impl Studio {
    /// What computes.
    fn device_info(&self) -> DeviceInfo {
        match &self.device {
            Opened::Cpu => crate::cpu::device(),
            Opened::Vulkan(stored) => stored.context.report().info.clone(),
        }
    }
}

/// Serves pages until `end`; `ready` gets the page's address, with its token, as soon as it can be opened.
///
/// # Errors
/// Faults of the settings, the scene, the device and the port.
pub fn serve(
    scene: Option<&Path>,
    port: u16,
    settings: Settings,
    ready: impl FnOnce(&str) -> Result<()>,
    end: impl Future<Output = ()> + Send + 'static,
) -> Result<()> {
    settings.check()?;
    let token = guard::token(std::env::var(guard::TOKEN_VARIABLE).ok())?;
    let device = device::open(&settings.device, &settings)?;
    let scene = scene.map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Held::load(("first".into(), name), path, None, &settings)
    });
    let scene = scene.transpose()?;
    if let Some(held) = &scene {
        for names in [&settings.focus, &settings.dim] {
            focus::objects(&held.scene, names)?;
        }
    }
    let scenes = Scenes::new(scene);
    let background = rayon::ThreadPoolBuilder::new().build().context("starting threads")?;
    // It goes with this function, whatever pages' threads hold at the end.
    let folder = tempfile::Builder::new().prefix("klieg-studio-").tempdir();
    let folder = folder.context("making a folder for scenes")?;
    let uploads = folder.path().to_owned();
    let studio = Arc::new(Studio { settings, device, scenes, uploads, background });
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("starting the server")?;
    runtime.block_on(async {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        let listener =
            TcpListener::bind(address).await.with_context(|| format!("listening on {address}"))?;
        let guard = Arc::new(Guard::new(listener.local_addr()?.port(), token));
        ready(&guard.address())?;
        // A judgement follows its picture at once, rather than when the picture's arrival is confirmed.
        let listener = listener.tap_io(|stream| {
            if let Err(fault) = stream.set_nodelay(true) {
                tracing::debug!("a socket waits for confirmations: {fault}");
            }
        });
        let serving = async { axum::serve(listener, server::router(studio, guard)).await };
        tokio::select! {
            served = serving => served.context("serving"),
            () = end => Ok(()),
        }
    })?;
    // Whatever a page has begun goes with the process.
    runtime.shutdown_background();
    Ok(())
}
