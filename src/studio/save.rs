//! What pages save: lit scenes, pictures, rigs and sessions.

use super::convert::rig;
use super::hall::Studio;
use super::messages::Save;
use super::scenes::{Held, gone};
use super::server::fault;
use super::session_file;
use super::stage::Sight;
use crate::Error;
use crate::lighting::{Light, LightRecord, Rig};
use crate::render;
use crate::report::json::LightRecord as Written;
use crate::report::picture::final_png;
use crate::scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::session::picture;
use anyhow::anyhow;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use std::sync::Arc;

/// A file of the page: its name's end, its type, and its bytes.
struct Saved {
    end: &'static str,
    kind: &'static str,
    bytes: Vec<u8>,
}

/// Answers with a file.
pub async fn save(
    State(studio): State<Arc<Studio>>,
    Path(what): Path<String>,
    body: Bytes,
) -> Response {
    let save: Save = match serde_json::from_slice(&body) {
        Ok(save) => save,
        Err(error) => {
            return fault(StatusCode::BAD_REQUEST, &format!("it cannot be read: {error}"));
        }
    };
    let work = move || {
        let held = studio.scenes.find(save.document.scene.as_deref())?.ok_or_else(gone)?;
        let saved = make(&studio, &held, &what, &save)?;
        anyhow::Ok((held.info.name.clone(), saved))
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok((name, saved))) => answer(&name, saved),
        Ok(Err(error)) => {
            let ours = !crate::session::is_input(&error) && error.downcast_ref::<Error>().is_some();
            let status =
                if ours { StatusCode::INTERNAL_SERVER_ERROR } else { StatusCode::BAD_REQUEST };
            fault(status, &crate::session::describe(&error))
        }
        Err(panic) => fault(StatusCode::INTERNAL_SERVER_ERROR, &panic.to_string()),
    }
}

/// The file, called as the scene is, of which letters, digits and a few marks stay.
fn answer(scene: &str, Saved { end, kind, bytes }: Saved) -> Response {
    let stem = std::path::Path::new(scene).file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(plain).take(64).collect();
    let disposition = format!("attachment; filename=\"{name}{end}\"");
    let headers =
        [(header::CONTENT_TYPE, kind.to_owned()), (header::CONTENT_DISPOSITION, disposition)];
    (headers, bytes).into_response()
}

fn make(studio: &Studio, held: &Held, what: &str, save: &Save) -> anyhow::Result<Saved> {
    let document = &save.document;
    let [width, height] = document.size;
    let size = [save.width.unwrap_or(width), save.height.unwrap_or(height)];
    let rig = rig(&document.look.lights)?;
    let view = |size| Sight { camera: document.look.camera.clone(), size }.final_view(held);
    let lit = |view: &View| scene::lit::glb(&held.source, held.options.clone(), view, &rig);
    let with = |glb: Vec<u8>, document| {
        session_file::with_document(&glb, document).map_err(|fault| anyhow!(fault))
    };
    let glb = "model/gltf-binary";
    Ok(match what {
        "glb" => {
            Saved { end: ".lit.glb", kind: glb, bytes: with(lit(&view(document.size)?)?, None)? }
        }
        "session" => {
            document.look.objective(&studio.settings.objective)?;
            let bytes = with(lit(&view(document.size)?)?, Some(document))?;
            Saved { end: ".session.glb", kind: glb, bytes }
        }
        "rig" => {
            let bytes = written(&rig, &view(document.size)?)?;
            Saved { end: ".rig.json", kind: "application/json", bytes }
        }
        "png" => {
            let bytes = png(studio, held, &view(size)?, (&rig, save.samples))?;
            Saved { end: ".png", kind: "image/png", bytes }
        }
        other => return Err(Error::Argument(format!("nothing is saved as '{other}'")).into()),
    })
}

/// A rig as `klieg render --rig` reads it.
fn written(rig: &Rig, view: &View) -> anyhow::Result<Vec<u8>> {
    let frame = &view.frame;
    let camera = json!({ "right": frame.right, "up": frame.up, "back": frame.back });
    let rig = json!({ "camera": camera, "lights": Written::rig(rig, view) });
    Ok(serde_json::to_vec_pretty(&rig)?)
}

fn png(
    studio: &Studio,
    held: &Held,
    view: &View,
    (rig, samples): (&Rig, Option<u32>),
) -> anyhow::Result<Vec<u8>> {
    let mut settings = studio.settings.picture;
    settings.samples = samples.unwrap_or(settings.samples);
    let occluders: Option<Occluders> = picture::occluders(&held.scene, view, &studio.settings)?;
    let records: Vec<LightRecord> = rig.iter().map(Light::record).collect();
    let seen = render::Stage {
        scene: &held.scene,
        view,
        shading: &studio.settings.shading,
        occluders: occluders.as_ref(),
    };
    let made = studio.background.install(|| render::draw(&seen, &records, &settings))?;
    Ok(final_png(&made.image)?)
}
