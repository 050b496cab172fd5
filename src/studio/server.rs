//! The server: the page's own files, what pages post and fetch, and their sockets.

use super::guard::{Guard, guard};
use super::hall::Studio;
use super::{save, socket, upload};
use axum::Router;
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use serde_json::json;
use std::sync::Arc;

/// All paths of the server.
pub fn router(studio: Arc<Studio>, own: Arc<Guard>) -> Router {
    Router::new()
        .route("/", asset("text/html; charset=utf-8", include_str!("../../studio/dist/index.html")))
        .route(
            "/studio.js",
            asset("text/javascript; charset=utf-8", include_str!("../../studio/dist/studio.js")),
        )
        .route(
            "/studio.css",
            asset("text/css; charset=utf-8", include_str!("../../studio/dist/studio.css")),
        )
        .route("/icon.svg", asset("image/svg+xml", include_str!("../../studio/dist/icon.svg")))
        .route("/ping", get(async || StatusCode::NO_CONTENT))
        .route("/scene", post(upload::scene))
        .route("/save/{what}", post(save::save))
        .route("/socket", get(socket::open))
        .layer(from_fn_with_state(own, guard))
        .with_state(studio)
}

fn asset(kind: &'static str, content: &'static str) -> MethodRouter<Arc<Studio>> {
    get(move || async move { ([(header::CONTENT_TYPE, kind)], content) })
}

/// A fault as pages read it.
pub fn fault(status: StatusCode, message: &str) -> Response {
    let body = json!({ "error": message }).to_string();
    (status, [(header::CONTENT_TYPE, "application/json")], body).into_response()
}

/// JSON.
pub fn json_of(value: &impl serde::Serialize) -> Response {
    match serde_json::to_string(value) {
        Ok(body) => ([(header::CONTENT_TYPE, "application/json")], body).into_response(),
        Err(error) => fault(StatusCode::INTERNAL_SERVER_ERROR, &error.to_string()),
    }
}
