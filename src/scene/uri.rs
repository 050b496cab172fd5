//! What a URI of a glTF file stands for (glTF 2.0 specification, section 2.8): a data URI's bytes
//! (RFC 2397), or a file named relative to the scene's.

use crate::{Error, Result};
use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::path::Path;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Whether `uri` carries its bytes itself.
pub fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// The data URI of some bytes.
pub fn from_bytes(bytes: &[u8], mime_type: &str) -> String {
    format!("data:{mime_type};base64,{}", BASE64.encode(bytes))
}

/// The bytes that `uri` stands for in the file `scene`.
///
/// # Errors
/// [`Error::Input`] naming `scene` when a data URI is malformed, or the file cannot be read or is no
/// file at all.
pub fn read(scene: &Path, uri: &str) -> Result<Vec<u8>> {
    if is_data(uri) {
        return decode(&uri[5..]).map_err(|fault| Error::input(scene, fault));
    }
    if uri.contains("://") {
        return Err(Error::input(scene, format!("'{uri}' is not a file beside the scene")));
    }
    let name = String::from_utf8(percent_decode(uri))
        .map_err(|_| Error::input(scene, format!("'{uri}' is not UTF-8")))?;
    std::fs::read(scene.with_file_name("").join(name))
        .map_err(|error| Error::input(scene, format!("cannot read '{uri}': {error}")))
}

/// The bytes of a data URI, given what follows its scheme.
fn decode(rest: &str) -> Result<Vec<u8>, String> {
    let (header, data) = rest.split_once(',').ok_or("a data URI has no data")?;
    if header.ends_with(";base64") {
        BASE64.decode(data).map_err(|error| format!("a data URI is not base64: {error}"))
    } else {
        Ok(percent_decode(data))
    }
}

/// Undoes percent-encoding; a `%` that two hexadecimal digits do not follow stands for itself.
fn percent_decode(text: &str) -> Vec<u8> {
    let mut rest = text.as_bytes();
    let mut out = Vec::with_capacity(rest.len());
    while let Some((&byte, tail)) = rest.split_first() {
        let escaped = (byte == b'%')
            .then(|| tail.first_chunk::<2>())
            .flatten()
            .filter(|digits| digits.iter().all(u8::is_ascii_hexdigit))
            .and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok());
        out.push(escaped.unwrap_or(byte));
        rest = if escaped.is_some() { &tail[2..] } else { tail };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_are_decoded() {
        let path = Path::new("scene.gltf");
        let read = |uri: &str| read(path, uri).map_err(|error| error.to_string());
        assert_eq!(read("data:application/octet-stream;base64,AQID/w=="), Ok(vec![1, 2, 3, 255]));
        assert_eq!(read("data:;base64,AQID/w"), Ok(vec![1, 2, 3, 255]));
        assert_eq!(read("data:text/plain,a%20b%"), Ok(b"a b%".to_vec()));
        assert_eq!(read("data:nothing"), Err("scene.gltf: a data URI has no data".into()));
        assert!(read("data:;base64,?").is_err_and(|e| e.contains("not base64")));
        assert_eq!(read(&from_bytes(&[1, 2, 3], "image/png")), Ok(vec![1, 2, 3]));
    }

    #[test]
    fn files_lie_beside_the_scene_under_their_decoded_names() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(dir.path().join("ä b%2.bin"), [7]).expect("a file");
        let scene = dir.path().join("scene.gltf");
        assert_eq!(read(&scene, "%C3%A4%20b%2.bin").ok(), Some(vec![7]));
        for missing in ["other.bin", "http://example.com/a.bin", "%FF.bin"] {
            let error = read(&scene, missing).expect_err("no such file");
            assert!(error.is_input() && error.to_string().contains(missing), "{error}");
        }
    }
}
