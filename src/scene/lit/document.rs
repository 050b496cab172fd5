//! A glTF file as it stands: raw JSON and one binary chunk, so that what klieg does not know stays
//! untouched. Containers: glTF 2.0 specification, section 4 (GLB).

use crate::scene::load::files::{MAX_BYTES, read, split};
use crate::scene::load::models;
use crate::scene::load::picture::KTX2;
use crate::scene::load::resources::{Resources, is_data};
use crate::scene::load::used::Used;
use crate::scene::load::{FileAccess, Orientation};
use crate::{Error, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A JSON object.
pub type Object = Map<String, Value>;

/// A glTF file.
pub struct Document {
    /// The root object.
    pub root: Object,
    /// The GLB's binary chunk, which is buffer 0's data.
    binary: Option<Vec<u8>>,
    /// Where it came from.
    source: PathBuf,
}

impl Document {
    /// Reads a .gltf or .glb file, told apart by their first bytes, or what a file of triangles amounts to.
    ///
    /// # Errors
    /// [`Error::Input`] when it cannot be read or is none of these.
    pub fn read(source: &Path, orientation: &Orientation, access: FileAccess) -> Result<Self> {
        let fault = |fault: String| Error::input(source, fault);
        if let Some(model) = models::read(source, orientation, access).map_err(fault)? {
            let models::Model { root, bin, .. } = model;
            let root = root.as_object().cloned().unwrap_or_default();
            return Ok(Self { root, binary: Some(bin), source: source.to_owned() });
        }
        let bytes = read(source, MAX_BYTES).map_err(fault)?;
        let (json, binary) = split(&bytes).map_err(fault)?;
        let root = serde_json::from_slice(json)
            .map_err(|error| fault(format!("not a glTF file: {error}")))?;
        Ok(Self { root, binary: binary.map(<[u8]>::to_vec), source: source.to_owned() })
    }

    /// The array `key` of the root object, created where there is none.
    ///
    /// # Errors
    /// [`Error::Input`] when it is something else than an array.
    pub fn array(&mut self, key: &str) -> Result<&mut Vec<Value>> {
        array(&mut self.root, key)
            .ok_or_else(|| Error::input(&self.source, format!("'{key}' is not an array")))
    }

    /// A fault of this file.
    pub fn fault(&self, fault: impl std::fmt::Display) -> Error {
        Error::input(&self.source, fault)
    }

    /// Takes in all buffers and images that lie in other files. Buffer 0 becomes the binary chunk,
    /// other buffers data URIs, and images buffer views at its end; no index changes. Files that
    /// nothing uses are not read: a byte stands for such a buffer, and a pixel for such an image, as for
    /// one that is missing: what the drawn scene needs was there when it was loaded. Buffers whose views
    /// read beyond the length that the file gives them are as long as those need.
    ///
    /// # Errors
    /// [`Error::Input`] when a buffer is missing, one of them is too short or not among those that `access` allows.
    pub fn embed_files(&mut self, access: FileAccess) -> Result<()> {
        let source = self.source.clone();
        let mut resources = Resources::new(&source, access, 0);
        let used = Used::of(&self.root);
        for index in 0..self.array_len("buffers") {
            self.embed_buffer(index, used.buffers.contains(&index), &mut resources)?;
        }
        for index in 0..self.array_len("images") {
            self.embed_image(index, used.images.contains(&index), &mut resources)?;
        }
        Ok(())
    }

    fn array_len(&self, key: &str) -> usize {
        self.root.get(key).and_then(Value::as_array).map_or(0, Vec::len)
    }

    fn embed_buffer(
        &mut self,
        index: usize,
        is_used: bool,
        resources: &mut Resources,
    ) -> Result<()> {
        let declared = |buffer: &Value| buffer["byteLength"].as_u64();
        let reach = self.reach(index);
        let buffer = &mut self.root["buffers"][index];
        let is_whole = declared(buffer).is_some_and(|length| length >= reach);
        let Some(uri) = buffer["uri"].as_str() else {
            let there = self.binary.as_ref().map_or(0, Vec::len) as u64;
            if index == 0 && !is_whole && reach <= there {
                buffer["byteLength"] = reach.into();
            }
            return Ok(());
        };
        if index > 0 && is_data(uri) && is_whole {
            return Ok(());
        }
        let mut data = vec![0];
        if is_used || is_data(uri) {
            let fault = |fault| Error::input(&self.source, format!("buffers[{index}]: {fault}"));
            data = resources.fetch(uri).map_err(fault)?;
        } else {
            buffer["byteLength"] = data.len().into();
            self.shrink_views(index);
        }
        let reach = self.reach(index).min(data.len() as u64);
        let buffer = &mut self.root["buffers"][index];
        let length = declared(buffer).map(|length| length.max(reach));
        match length.and_then(|length| usize::try_from(length).ok()) {
            Some(length) if length <= data.len() => {
                data.truncate(length);
                buffer["byteLength"] = length.into();
            }
            _ => {
                let fault = format!("buffer {index} has only {} bytes", data.len());
                return Err(self.fault(fault));
            }
        }
        if index > 0 {
            let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&data));
            buffer["uri"] = uri.into();
        } else {
            buffer.as_object_mut().and_then(|buffer| buffer.shift_remove("uri"));
            self.binary = Some(data);
        }
        Ok(())
    }

    /// Bytes of a buffer up to the end of its views.
    fn reach(&self, buffer: usize) -> u64 {
        let views = self.root.get("bufferViews").and_then(Value::as_array);
        let of_buffer = |view: &&Value| view["buffer"].as_u64() == Some(buffer as u64);
        let end = |view: &Value| {
            view["byteLength"].as_u64()?.checked_add(view["byteOffset"].as_u64().unwrap_or(0))
        };
        views.into_iter().flatten().filter(of_buffer).filter_map(end).max().unwrap_or(0)
    }

    /// Lets the views of a buffer that nothing uses be as long as that is now.
    fn shrink_views(&mut self, buffer: usize) {
        let views = self.root.get_mut("bufferViews").and_then(Value::as_array_mut);
        for view in views.into_iter().flatten().filter_map(Value::as_object_mut) {
            if view.get("buffer").and_then(Value::as_u64) == Some(buffer as u64) {
                view.retain(|key, _| key != "byteOffset" && key != "byteStride");
                view.insert("byteLength".into(), 1.into());
            }
        }
    }

    fn embed_image(
        &mut self,
        index: usize,
        is_used: bool,
        resources: &mut Resources,
    ) -> Result<()> {
        let image = &self.root["images"][index];
        let Some(uri) = image["uri"].as_str().filter(|uri| !is_data(uri)) else {
            return Ok(());
        };
        let fault = |fault| Error::input(&self.source, format!("images[{index}]: {fault}"));
        let data = if is_used && !resources.is_missing(uri) {
            resources.fetch(uri).map_err(fault)?
        } else {
            PIXEL.to_vec()
        };
        let mime_type = match mime_type(&data).or(image["mimeType"].as_str()) {
            Some(mime_type) => mime_type.to_owned(),
            None => {
                // Nobody can show it, but it is no fault of the lights.
                let data = STANDARD.encode(&data);
                let uri = format!("data:application/octet-stream;base64,{data}");
                self.root["images"][index]["uri"] = uri.into();
                return Ok(());
            }
        };
        let view = self.append_view(&data)?;
        let Some(image) = self.root["images"][index].as_object_mut() else { return Ok(()) };
        image.shift_remove("uri");
        image.insert("mimeType".into(), mime_type.into());
        image.insert("bufferView".into(), view.into());
        Ok(())
    }

    /// Appends `data` to the binary chunk and gives the index of its buffer view.
    fn append_view(&mut self, data: &[u8]) -> Result<usize> {
        if self.array("buffers")?.is_empty() {
            self.array("buffers")?.push(json!({ "byteLength": 0 }));
            self.binary = Some(Vec::new());
        }
        let Some(binary) = &mut self.binary else {
            return Err(self.fault("buffer 0 has no data"));
        };
        let offset = binary.len().next_multiple_of(4);
        binary.resize(offset, 0);
        binary.extend_from_slice(data);
        let length = binary.len();
        match self.array("buffers")?.first_mut().and_then(Value::as_object_mut) {
            Some(buffer) => buffer.insert("byteLength".into(), length.into()),
            None => return Err(self.fault("buffer 0 is not an object")),
        };
        let views = self.array("bufferViews")?;
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": data.len() }));
        Ok(views.len() - 1)
    }

    /// Writes the file as a GLB: whole under its name, or not at all.
    ///
    /// # Errors
    /// [`Error::Output`], also when it would be longer than a GLB can be.
    pub fn write(&self, out: &Path) -> Result<()> {
        save(out, |to| self.put(to))
    }

    /// The file as a GLB, in memory.
    ///
    /// # Errors
    /// [`Error::Input`] that names the source when it would be longer than a GLB can be.
    pub fn glb(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.put(&mut bytes).map_err(|fault| self.fault(fault.to_string()))?;
        Ok(bytes)
    }

    fn put(&self, to: impl Write) -> std::io::Result<()> {
        let json = serde_json::to_vec(&self.root)?;
        let binary = self.binary.as_deref();
        let length = glb_length(json.len(), binary.map(<[u8]>::len)).ok_or_else(|| {
            std::io::Error::new(
                std::io::ErrorKind::FileTooLarge,
                "the scene with its buffers and images is over the 4 GiB that a GLB can hold",
            )
        })?;
        let header = gltf::binary::Header { magic: *b"glTF", version: 2, length };
        let glb = gltf::binary::Glb { header, json: json.into(), bin: binary.map(Into::into) };
        glb.to_writer(to).map_err(|error| match error {
            gltf::Error::Io(error) => error,
            other => std::io::Error::other(other),
        })
    }
}

/// Writes a file whole under its name, or not at all.
///
/// # Errors
/// [`Error::Output`].
pub fn save(out: &Path, content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    let save = || {
        let builder = &mut tempfile::Builder::new();
        #[cfg(unix)]
        {
            // As any other new file; a temporary file would be for its owner alone.
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        let mut writer = std::io::BufWriter::new(file.as_file_mut());
        content(&mut writer)?;
        writer.flush()?;
        drop(writer);
        file.persist(out)?;
        Ok(())
    };
    save().map_err(|source| Error::Output { path: out.to_owned(), source })
}

/// The array `key` of `object`, created where there is none; `None` where it is something else.
pub fn array<'a>(object: &'a mut Object, key: &str) -> Option<&'a mut Vec<Value>> {
    object.entry(key).or_insert_with(|| json!([])).as_array_mut()
}

/// The object `key` of `object`, created where there is none; `None` where it is something else.
pub fn object<'a>(object: &'a mut Object, key: &str) -> Option<&'a mut Object> {
    object.entry(key).or_insert_with(|| json!({})).as_object_mut()
}

/// Bytes of a GLB with chunks of the given lengths; `None` when its 32-bit length cannot say it.
fn glb_length(json: usize, binary: Option<usize>) -> Option<u32> {
    let chunk = |length: usize| length.checked_next_multiple_of(4)?.checked_add(8);
    let binary = binary.map_or(Some(0), chunk)?;
    let length = chunk(json)?.checked_add(binary)?.checked_add(12)?;
    u32::try_from(length).ok()
}

/// A PNG of one black pixel.
const PIXEL: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\0\0\0\0:~\x9bU\
    \0\0\0\nIDATx\xdac`\0\0\0\x02\0\x01\xe5'\xde\xfc\0\0\0\0IEND\xaeB`\x82";

/// Media type of an image file, by its first bytes.
fn mime_type(data: &[u8]) -> Option<&'static str> {
    if data.starts_with(KTX2) {
        return Some("image/ktx2");
    }
    image::guess_format(data).ok().map(|format| format.to_mime_type())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glb_ends_at_four_gib() {
        assert_eq!(glb_length(1, None), Some(24));
        assert_eq!(glb_length(4, Some(5)), Some(12 + 12 + 16));
        let most = u32::MAX as usize - 3 - (12 + 12 + 8);
        assert_eq!(glb_length(4, Some(most)), Some(u32::MAX - 3));
        assert_eq!(glb_length(4, Some(most + 1)), None);
        assert_eq!(glb_length(usize::MAX, None), None);
    }

    #[test]
    fn images_are_known_by_their_first_bytes() {
        assert_eq!(mime_type(b"\x89PNG\r\n\x1A\n"), Some("image/png"));
        assert_eq!(mime_type(b"\xFF\xD8\xFF\xE0"), Some("image/jpeg"));
        assert_eq!(mime_type(b"RIFF\0\0\0\0WEBPVP8 "), Some("image/webp"));
        assert_eq!(mime_type(b"\xABKTX 20\xBB\r\n\x1A\n"), Some("image/ktx2"));
        assert_eq!(mime_type(b"text"), None);
    }
}
