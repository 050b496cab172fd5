//! Files and URIs: GLB containers, external files and data URIs (glTF 2.0, 3.6.1 and 4).

use super::{Parsed, quoted};
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Most bytes that a scene's files may have together.
pub const MAX_BYTES: u64 = 8 << 30;
/// Most bytes of its JSON, which takes many times its size in memory once it is parsed.
const MAX_JSON: u64 = 1 << 30;

/// Exporters leave the padding out now and then.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The whole of a regular file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Parsed<Vec<u8>> {
    let part = FilePart::open(path, limit)?;
    part.read(0, part.length)
}

/// Bytes of a file that are read as they are needed.
#[derive(Debug)]
pub struct FilePart {
    file: File,
    start: u64,
    length: u64,
}

impl FilePart {
    /// All of a regular file of at most `limit` bytes.
    pub fn open(path: &Path, limit: u64) -> Parsed<Self> {
        // Looked at before it is opened: opening a pipe would wait for its other end.
        let metadata = std::fs::metadata(path).map_err(reason)?;
        if metadata.is_dir() {
            return Err("is a directory, not a file".into());
        }
        if !metadata.is_file() {
            return Err("is not a regular file".into());
        }
        let length = metadata.len();
        if length > limit {
            return Err(format!("has {length} bytes, more than klieg reads ({limit})"));
        }
        Ok(Self { file: File::open(path).map_err(reason)?, start: 0, length })
    }

    /// Number of bytes.
    pub fn len(&self) -> u64 {
        self.length
    }

    /// `length` bytes from `offset` on.
    pub fn read(&self, offset: u64, length: u64) -> Parsed<Vec<u8>> {
        let mut bytes = vec![0; usize::try_from(length).map_err(|_| "is too large")?];
        self.fill(offset, &mut bytes)?;
        Ok(bytes)
    }

    /// Reads the bytes from `offset` on into `bytes`.
    pub fn fill(&self, offset: u64, bytes: &mut [u8]) -> Parsed<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.start + offset))
            .and_then(|_| file.read_exact(bytes))
            .map_err(reason)
    }
}

fn reason(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "file not found".to_owned(),
        std::io::ErrorKind::UnexpectedEof => "became shorter while it was read".to_owned(),
        _ => format!("cannot be read: {error}"),
    }
}

/// The content of a buffer.
#[derive(Debug)]
pub enum Buffer {
    /// In memory.
    Memory(Vec<u8>),
    /// In a file.
    File(FilePart),
}

impl Buffer {
    /// Number of bytes.
    pub fn len(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::File(part) => part.len(),
        }
    }
}

/// The JSON of a `.gltf` or `.glb` file, told apart by content, and the GLB's binary chunk, which
/// stays in the file.
pub fn open(path: &Path) -> Parsed<(Vec<u8>, Option<FilePart>)> {
    let file = FilePart::open(path, MAX_BYTES)?;
    let (json, bin) = places(&mut BufReader::new(&file.file), file.length)?;
    let json = file.read(json.start, json.end - json.start)?;
    let bin = bin.map(|bin| FilePart { start: bin.start, length: bin.end - bin.start, ..file });
    Ok((json, bin))
}

/// The same of a file that is in memory.
pub fn split(data: &[u8]) -> Parsed<(&[u8], Option<&[u8]>)> {
    let (json, bin) = places(&mut Cursor::new(data), data.len() as u64)?;
    let slice = |range: Range<u64>| &data[range.start as usize..range.end as usize];
    Ok((slice(json), bin.map(slice)))
}

/// Where the JSON and the binary chunk lie in a source of `length` bytes.
fn places(
    source: &mut (impl Read + Seek),
    length: u64,
) -> Parsed<(Range<u64>, Option<Range<u64>>)> {
    let (json, bin) = chunks(source, length)?;
    let length = json.end - json.start;
    if length > MAX_JSON {
        return Err(format!(
            "has {length} bytes of JSON, more than klieg reads ({MAX_JSON}): put buffers and images \
             into files of their own, or into a GLB"
        ));
    }
    Ok((json, bin))
}

/// The same of any lengths.
fn chunks(
    source: &mut (impl Read + Seek),
    length: u64,
) -> Parsed<(Range<u64>, Option<Range<u64>>)> {
    let mut head = Vec::new();
    source.take(4).read_to_end(&mut head).map_err(reason)?;
    match &head[..] {
        [] => return Err("is empty".into()),
        b"glTF" => return glb_places(source, length),
        _ => {}
    }
    let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    source.seek(SeekFrom::Start(mark)).map_err(reason)?;
    let mut byte = [b' '];
    while byte[0].is_ascii_whitespace() && source.read(&mut byte).map_err(reason)? == 1 {}
    match byte[0] {
        b'{' => Ok((mark..length, None)),
        _ => Err("is not glTF: it begins neither with the GLB magic nor as JSON".into()),
    }
}

fn glb_places(
    source: &mut (impl Read + Seek),
    available: u64,
) -> Parsed<(Range<u64>, Option<Range<u64>>)> {
    if available < 12 {
        return Err("is truncated within the GLB header".into());
    }
    let mut word = || {
        let mut bytes = [0; 4];
        source.read_exact(&mut bytes).map_err(reason).map(|()| u32::from_le_bytes(bytes))
    };
    let (version, length) = (word()?, u64::from(word()?));
    if version != 2 {
        return Err(format!("is GLB version {version}; klieg reads version 2"));
    }
    if length > available {
        return Err(format!("is truncated: {available} of {length} bytes are there"));
    }
    let (mut json, mut bin, mut at) = (None, None, 12);
    while at + 8 <= length {
        let mut head = [0; 8];
        source.read_exact(&mut head).map_err(reason)?;
        let [a, b, c, d, kind @ ..] = head;
        let size = u64::from(u32::from_le_bytes([a, b, c, d]));
        let chunk = at + 8..at + 8 + size;
        if chunk.end > length {
            return Err(format!("is truncated within the GLB chunk at byte {at}"));
        }
        match &kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if json.is_some() && bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        let size = size.next_multiple_of(4);
        source.seek_relative(size as i64).map_err(reason)?;
        at += 8 + size;
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
    /// Resources of the file at `path`, of which `used` bytes are taken already.
    pub fn new(path: &'a Path, used: u64) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self { folder, left: MAX_BYTES.saturating_sub(used), files: vec![path.into()] }
    }

    /// What a URI names: base64 data or a file relative to the scene's.
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
        let data = match uri.split_once(':') {
            Some((scheme, rest)) if scheme.eq_ignore_ascii_case("data") => {
                Buffer::Memory(data_uri(rest)?)
            }
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
                let part = FilePart::open(&path, self.left)
                    .map_err(|fault| format!("{}: {fault}", quoted(uri)))?;
                self.files.push(path);
                Buffer::File(part)
            }
        };
        self.left = self.left.saturating_sub(data.len());
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
