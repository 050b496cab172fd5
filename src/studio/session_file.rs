//! Session files: a lit scene whose `asset.extras` hold a page's document.

use super::messages::Document;
use serde::Deserialize;
use serde_json::{Value, json};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Name of the block in `asset.extras`.
const BLOCK: &str = "klieg_studio";

/// Bytes of a GLB before its first chunk's data (glTF 2.0, 4.4).
const BEFORE_JSON: usize = 20;

/// Most bytes of JSON in which a document is looked for.
const MOST: u32 = 256 << 20;

/// What a session file keeps; none of any other file.
pub fn document(path: &Path) -> Option<Document> {
    let mut file = File::open(path).ok()?;
    let mut head = [0; BEFORE_JSON];
    file.read_exact(&mut head).ok()?;
    let word = |at: usize| head[at..at + 4].try_into().ok().map(u32::from_le_bytes);
    if &head[..4] != b"glTF" || word(12)? > MOST {
        return None;
    }
    let mut json = Vec::new();
    file.take(word(12)?.into()).read_to_end(&mut json).ok()?;
    let mut root: Value = serde_json::from_slice(&json).ok()?;
    Document::deserialize(root["asset"]["extras"][BLOCK].take()).ok()
}

/// A GLB with a document in the place of any that it has; without one where there is none.
///
/// # Errors
/// In words, for what is no GLB.
pub fn with_document(glb: &[u8], document: Option<&Document>) -> Result<Vec<u8>, String> {
    let mut glb = gltf::binary::Glb::from_slice(glb).map_err(|fault| fault.to_string())?;
    let mut root: Value = serde_json::from_slice(&glb.json).map_err(|fault| fault.to_string())?;
    let extras = &mut root["asset"]["extras"];
    match document {
        Some(document) if extras.is_null() || extras.is_object() => {
            extras[BLOCK] = json!(document);
        }
        Some(document) => *extras = json!({ BLOCK: document }),
        None => {
            extras.as_object_mut().map(|extras| extras.shift_remove(BLOCK));
            if extras.is_null() {
                root["asset"].as_object_mut().map(|asset| asset.shift_remove("extras"));
            }
        }
    }
    glb.json = serde_json::to_vec(&root).map_err(|fault| fault.to_string())?.into();
    glb.to_vec().map_err(|fault| fault.to_string())
}
