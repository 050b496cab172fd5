//! Files and URIs: GLB containers, external files and data URIs (glTF 2.0, 3.6.1 and 4).

use super::{Parsed, quoted};
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Most bytes that a scene's files may have together.
pub const MAX_BYTES: u64 = 8 << 30;

/// Exporters leave the padding out now and then.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The whole of a regular file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Parsed<Vec<u8>> {
    let reason = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "file not found".to_owned(),
        _ => format!("cannot be read: {error}"),
    };
    // Looked at before it is opened: opening a pipe would wait for its other end.
    let metadata = std::fs::metadata(path).map_err(reason)?;
    if metadata.is_dir() {
        return Err("is a directory, not a file".into());
    }
    if !metadata.is_file() {
        return Err("is not a regular file".into());
    }
    if metadata.len() > limit {
        return Err(format!("has {} bytes, more than klieg reads ({limit})", metadata.len()));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(limit).read_to_end(&mut bytes))
        .map_err(reason)?;
    Ok(bytes)
}

/// The JSON of a `.gltf` or `.glb` file, told apart by content, and the GLB's binary chunk.
pub fn split(data: &[u8]) -> Parsed<(&[u8], Option<&[u8]>)> {
    if data.is_empty() {
        return Err("is empty".into());
    }
    if data.starts_with(b"glTF") {
        return split_glb(data);
    }
    let json = data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(data);
    match json.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok((json, None)),
        _ => Err("is not glTF: it begins neither with the GLB magic nor as JSON".into()),
    }
}

fn split_glb(data: &[u8]) -> Parsed<(&[u8], Option<&[u8]>)> {
    let word = |at: usize| {
        let bytes = data.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        bytes.map(u32::from_le_bytes).ok_or("is truncated within the GLB header")
    };
    let (version, length) = (word(4)?, word(8)? as usize);
    if version != 2 {
        return Err(format!("is GLB version {version}; klieg reads version 2"));
    }
    if length > data.len() {
        return Err(format!("is truncated: {} of {length} bytes are there", data.len()));
    }
    let (mut json, mut bin, mut at) = (None, None, 12);
    while at + 8 <= length {
        let (size, kind) = (word(at)? as usize, word(at + 4)?);
        let chunk = (at + 8).checked_add(size).and_then(|end| data[..length].get(at + 8..end));
        let Some(chunk) = chunk else {
            return Err(format!("is truncated within the GLB chunk at byte {at}"));
        };
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if json.is_some() && bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        at += 8 + size.next_multiple_of(4);
    }
    Ok((json.ok_or("is a GLB file without a JSON chunk")?, bin))
}

/// The file's own folder and what its resources may still read.
pub struct Resources<'a> {
    folder: &'a Path,
    left: u64,
    /// The file and all that were fetched.
    pub files: Vec<PathBuf>,
}

impl<'a> Resources<'a> {
    /// Resources of the file at `path`, of which `used` bytes are already in memory.
    pub fn new(path: &'a Path, used: usize) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self { folder, left: MAX_BYTES.saturating_sub(used as u64), files: vec![path.into()] }
    }

    /// What a URI names: base64 data or a file relative to the scene's.
    pub fn fetch(&mut self, uri: &str) -> Parsed<Vec<u8>> {
        let data = match uri.split_once(':') {
            Some((scheme, rest)) if scheme.eq_ignore_ascii_case("data") => data_uri(rest)?,
            Some((scheme, _)) if is_scheme(scheme) => {
                return Err(format!(
                    "{} is not a relative path: klieg reads no '{}:' URIs",
                    quoted(uri),
                    scheme.to_ascii_lowercase()
                ));
            }
            _ => {
                let relative = percent_decoded(uri)?.replace('\\', "/");
                if relative.is_empty() || relative.starts_with('/') {
                    return Err(format!("{} is not a relative path", quoted(uri)));
                }
                let path = self.folder.join(relative);
                let data =
                    read(&path, self.left).map_err(|fault| format!("{}: {fault}", quoted(uri)))?;
                self.files.push(path);
                data
            }
        };
        self.left = self.left.saturating_sub(data.len() as u64);
        Ok(data)
    }
}

fn is_scheme(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
}

fn data_uri(rest: &str) -> Parsed<Vec<u8>> {
    let (head, data) = rest.split_once(',').ok_or("data URI without a comma")?;
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Err("data URI that is not base64".into());
    }
    BASE64.decode(percent_decoded(data)?.as_bytes()).map_err(|error| format!("data URI: {error}"))
}

/// RFC 3986, 2.1.
fn percent_decoded(uri: &str) -> Parsed<Cow<'_, str>> {
    if !uri.contains('%') {
        return Ok(Cow::Borrowed(uri));
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let code = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        (rest, _) = match (first, code) {
            (b'%', Some(code)) => (&tail[2..], bytes.push(code)),
            _ => (tail, bytes.push(*first)),
        };
    }
    let text = String::from_utf8(bytes).map_err(|_| format!("{} is not UTF-8", quoted(uri)))?;
    if text.contains('\0') {
        return Err(format!("{} has a NUL character", quoted(uri)));
    }
    Ok(Cow::Owned(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_codes_are_decoded() {
        assert_eq!(percent_decoded("a%20b%C3%A9.png").unwrap(), "a bé.png");
        assert_eq!(percent_decoded("100%.bin").unwrap(), "100%.bin");
        assert!(percent_decoded("%ff").is_err());
        assert!(percent_decoded("a%00").is_err());
    }

    #[test]
    fn data_uris_are_base64_with_or_without_padding() {
        let mut resources = Resources::new(Path::new("x.gltf"), 0);
        let data = |uri| Resources::fetch(&mut Resources::new(Path::new("x"), 0), uri);
        assert_eq!(data("data:application/octet-stream;base64,AAEC/w==").unwrap(), [0, 1, 2, 255]);
        assert_eq!(data("DATA:;base64,AAEC/w").unwrap(), [0, 1, 2, 255]);
        assert!(data("data:text/plain,hello").is_err());
        assert!(data("data:;base64,!").is_err());
        for uri in ["http://h/a.bin", "HTTPS://h/a", "file:///etc/passwd", "/etc/passwd", ""] {
            let fault = resources.fetch(uri).unwrap_err();
            assert!(fault.contains("relative"), "{fault}");
        }
    }

    #[test]
    fn unknown_chunks_are_skipped() {
        let chunk = |kind: &[u8; 4], data: &[u8]| {
            [&(data.len() as u32).to_le_bytes(), &kind[..], data].concat()
        };
        let body =
            [chunk(b"JSON", b"{}  "), chunk(b"ABCD", b"1234"), chunk(b"BIN\0", b"5678")].concat();
        let length = (12 + body.len() as u32).to_le_bytes();
        let glb = [b"glTF", &2u32.to_le_bytes(), &length, &body[..]].concat();
        assert_eq!(split(&glb).unwrap(), (&b"{}  "[..], Some(&b"5678"[..])));
        for end in 0..glb.len() {
            assert!(split(&glb[..end]).is_err(), "{end}");
        }
    }
}
