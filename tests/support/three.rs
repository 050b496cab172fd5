//! Pictures by three.js in headless Chromium, from `tests/three/render.mjs`.

use crate::{browser, npm};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Deserializer};
use std::path::Path;

/// The same view twice: PNG files, transparent in the background.
#[derive(Deserialize)]
pub struct Pictures {
    /// As three.js draws it by default.
    #[serde(deserialize_with = "decoded")]
    pub shipped: Vec<u8>,
    /// Without what three.js adds to the BRDF of the glTF specification: the energy of several reflections
    /// between microfacets, and roughness against aliasing.
    #[serde(deserialize_with = "decoded")]
    pub specification: Vec<u8>,
}

/// What three.js makes of a GLB through the file's first camera. Panics where Chromium or Node.js is missing.
pub fn render(scene: &Path, width: u32, height: u32) -> Pictures {
    let size = format!("{width}x{height}");
    let printed = npm::run("three", "render.mjs", &[&browser::chromium(), scene, Path::new(&size)]);
    serde_json::from_slice(&printed).expect("the pictures")
}

fn decoded<'de, D: Deserializer<'de>>(text: D) -> Result<Vec<u8>, D::Error> {
    let text = String::deserialize(text)?;
    STANDARD.decode(text).map_err(serde::de::Error::custom)
}
