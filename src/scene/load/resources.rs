//! What the URIs in a scene name: data, and files (glTF 2.0, 2.8).

use super::files::{Buffer, FilePart, MAX_BYTES, reason};
use super::{Parsed, quoted};
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::json::Root;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Exporters leave the padding out now and then.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Which files the URIs in a scene may name.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FileAccess {
    /// Files in the folder of the scene's own file, and below; symbolic links count as what they
    /// lead to. For scenes of unknown origin.
    #[default]
    SceneFolder,
    /// All files that the program may read: `..`, absolute paths, `file:` URIs and symbolic links
    /// may lead out of that folder.
    Anywhere,
}

/// The file's own folder and what its resources may still read.
pub struct Resources<'a> {
    folder: &'a Path,
    access: FileAccess,
    left: u64,
    /// The file and all that were fetched.
    pub files: Vec<PathBuf>,
}

impl<'a> Resources<'a> {
    /// Resources of the file at `path`, of which `used` bytes are taken already.
    pub fn new(path: &'a Path, access: FileAccess, used: u64) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self { folder, access, left: MAX_BYTES.saturating_sub(used), files: vec![path.into()] }
    }

    /// What a URI names: base64 data or a file.
    pub fn fetch(&mut self, uri: &str) -> Parsed<Vec<u8>> {
        match self.open(uri)? {
            Buffer::Memory(bytes) => Ok(bytes),
            Buffer::File(part) => {
                part.read(0, part.len()).map_err(|fault| format!("{}: {fault}", quoted(uri)))
            }
        }
    }

    /// The same, a file being opened but not read.
    pub fn open(&mut self, uri: &str) -> Parsed<Buffer> {
        let buffer = match data(uri) {
            Some(rest) => Buffer::Memory(data_uri(rest)?),
            None => self.file(uri).map_err(|fault| format!("{}: {fault}", quoted(uri)))?,
        };
        self.left = self.left.saturating_sub(buffer.len());
        Ok(buffer)
    }

    /// The files that the buffers and images of a file name, wherever they lead.
    pub fn named(&self, root: &Root) -> Vec<PathBuf> {
        let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        let images = root.images.iter().filter_map(|image| image.uri.as_deref());
        let files = buffers.chain(images).filter(|uri| !is_data(uri));
        files.filter_map(|uri| Some(self.folder.join(file_path(uri).ok()?))).collect()
    }

    /// Whether a URI names a file of the scene's folder that is not there.
    pub fn is_missing(&self, uri: &str) -> bool {
        let named = file_path(uri).ok().filter(|named| !is_data(uri) && !leads_out(named));
        named.is_some_and(|named| matches!(self.folder.join(named).try_exists(), Ok(false)))
    }

    /// Opens the file that a URI names.
    fn file(&mut self, uri: &str) -> Parsed<Buffer> {
        let named = file_path(uri)?;
        let path = self.folder.join(&named);
        let part = match self.access {
            FileAccess::Anywhere => FilePart::open(&path, self.left)?,
            FileAccess::SceneFolder => {
                if leads_out(&named) {
                    return Err(OUTSIDE.into());
                }
                let real = |path: &Path| path.canonicalize().map_err(reason);
                let (file, folder) = (real(&path)?, real(&self.folder.join("."))?);
                if !file.starts_with(folder) {
                    return Err(OUTSIDE.into());
                }
                FilePart::open(&file, self.left)?
            }
        };
        self.files.push(path);
        Ok(Buffer::File(part))
    }
}

const OUTSIDE: &str = "leads out of the scene's folder: put the file there, or allow files outside \
                       of it (--allow-outside)";

/// Whether a URI carries its bytes itself.
pub fn is_data(uri: &str) -> bool {
    data(uri).is_some()
}

/// What follows the scheme of a data URI.
fn data(uri: &str) -> Option<&str> {
    uri.split_once(':').filter(|(scheme, _)| scheme.eq_ignore_ascii_case("data")).map(|uri| uri.1)
}

fn data_uri(rest: &str) -> Parsed<Vec<u8>> {
    let (head, data) = rest.split_once(',').ok_or("data URI without a comma")?;
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Err("data URI that is not base64".into());
    }
    let data = percent_decoded(data).map_err(|fault| format!("data URI: {fault}"))?;
    BASE64.decode(data.as_bytes()).map_err(|error| format!("data URI: {error}"))
}

/// The path that a URI names, with slashes: exporters on Windows write backslashes.
fn file_path(uri: &str) -> Parsed<String> {
    let is_scheme = |text: &&str| {
        text.starts_with(|first: char| first.is_ascii_alphabetic())
            && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
    };
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(is_scheme);
    let path = match scheme.map(str::to_ascii_lowercase).as_deref() {
        Some("file") => local_path(&uri["file:".len()..])?,
        Some(scheme) if scheme.len() > 1 => {
            return Err(format!("is not a relative path: klieg reads no '{scheme}:' URIs"));
        }
        _ => uri,
    };
    let path = percent_decoded(path)?.replace('\\', "/");
    match path.as_str() {
        "" => Err("is not a relative path".into()),
        path if path.contains('\0') => Err("has a NUL character".into()),
        // RFC 8089, E.2: a drive stands behind a slash.
        path if cfg!(windows) && path.starts_with('/') && has_drive(&path[1..]) => {
            Ok(path[1..].to_owned())
        }
        _ => Ok(path),
    }
}

/// The path of a `file:` URI without its scheme (RFC 8089), absolute.
fn local_path(rest: &str) -> Parsed<&str> {
    let path = match rest.strip_prefix("//") {
        Some(rest) => rest.strip_prefix("localhost").unwrap_or(rest),
        None => rest,
    };
    let local = path.starts_with('/');
    local.then_some(path).ok_or_else(|| "is not a file of this computer".into())
}

/// RFC 3986, 2.1; a `%` without two hexadecimal digits stands for itself.
fn percent_decoded(text: &str) -> Parsed<Cow<'_, str>> {
    percent_decode_str(text).decode_utf8().map_err(|_| "is not UTF-8".into())
}

/// Whether a path is absolute, or climbs above its start on its way.
fn leads_out(path: &str) -> bool {
    let mut depth = 0u32;
    let mut climbs = |part: Component| {
        let after = match part {
            Component::Normal(_) => depth.checked_add(1),
            Component::CurDir => Some(depth),
            Component::ParentDir => depth.checked_sub(1),
            Component::RootDir | Component::Prefix(_) => None,
        };
        depth = after.unwrap_or_default();
        after.is_none()
    };
    has_drive(path) || Path::new(path).components().any(&mut climbs)
}

/// Whether a path begins with a drive of Windows, which is refused on all systems alike.
fn has_drive(path: &str) -> bool {
    matches!(path.as_bytes(), [drive, b':', ..] if drive.is_ascii_alphabetic())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(uri: &str) -> Parsed<String> {
        file_path(uri)
    }

    #[test]
    fn percent_codes_are_decoded_once() {
        assert_eq!(decoded("a%20b%C3%A9.png").unwrap(), "a bé.png");
        assert_eq!(decoded("%252e%252e%252fa").unwrap(), "%2e%2e%2fa");
        for text in ["100%.bin", "%+5", "%-5", "% 5", "%4", "%zz", "%", "%%", "%4\u{e9}"] {
            assert_eq!(decoded(text).unwrap(), text);
        }
        assert_eq!(decoded("%%41").unwrap(), "%A");
        for (uri, fault) in [("%ff", "UTF-8"), ("%C3", "UTF-8"), ("a%00", "NUL"), ("\0", "NUL")] {
            assert!(decoded(uri).unwrap_err().contains(fault), "{uri:?}");
        }
    }

    #[test]
    fn data_uris_are_base64_with_or_without_padding() {
        let data = |uri| Resources::new(Path::new("x.gltf"), FileAccess::SceneFolder, 0).fetch(uri);
        assert_eq!(data("data:application/octet-stream;base64,AAEC/w==").unwrap(), [0, 1, 2, 255]);
        assert_eq!(data("DATA:;base64,AAEC/w").unwrap(), [0, 1, 2, 255]);
        assert!(data("data:text/plain,hello").is_err());
        assert!(data("data:;base64,!").is_err());
        for uri in ["http://h/a.bin", "HTTPS://h/a", ""] {
            let fault = data(uri).unwrap_err();
            assert!(fault.contains("relative"), "{fault}");
        }
    }

    #[test]
    fn file_uris_name_absolute_paths_here() {
        for uri in ["file:///a%20b", "FILE:/a%20b", "file://localhost/a%20b"] {
            assert_eq!(file_path(uri).unwrap(), "/a b");
        }
        for uri in ["file://host/a", "file:a", "file:", "file://", "file://localhostess/a"] {
            assert!(file_path(uri).is_err(), "{uri}");
        }
    }

    #[test]
    fn paths_that_lead_out_are_seen() {
        for uri in [
            "..",
            "../a",
            "a/../../a",
            "./../a",
            "%2e%2e/a",
            "%2E%2e%2fa",
            "..%5ca",
            "..\\a",
            "a\\..\\..\\a",
            "/a",
            "%2fa",
            "\\a",
            "\\\\host\\a",
            "//host/a",
            "C:\\a",
            "c:a",
            "C%3A/a",
            "file:///a",
            "\\\\?\\C:\\a",
        ] {
            assert!(leads_out(&file_path(uri).unwrap()), "{uri}");
        }
        for uri in ["a", "./a", "a/../b", "a/./b", "...", "..a/b", "a//b", "%252e%252e/a"] {
            assert!(!leads_out(&file_path(uri).unwrap()), "{uri}");
        }
    }
}
