//! Files: what is read of them, and GLB containers (glTF 2.0, 4).

use super::Parsed;
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// Most bytes that a scene's files may have together.
pub const MAX_BYTES: u64 = 8 << 30;
/// Most bytes of its JSON, which takes many times its size in memory once it is parsed.
const MAX_JSON: u64 = 1 << 30;

/// The whole of a regular file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Parsed<Vec<u8>> {
    let part = FilePart::open(path, limit)?;
    part.read(0, part.length)
}

/// The text of a regular file of at most `limit` bytes.
#[cfg(feature = "cli")]
pub fn text(path: &Path, limit: u64) -> Parsed<String> {
    String::from_utf8(read(path, limit)?).map_err(|_| "is not UTF-8".into())
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

/// Why a file cannot be read.
pub fn reason(error: std::io::Error) -> String {
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
    super::budget::check_json(length)?;
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
        let end = chunk.end;
        match &kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if json.is_some() && bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        at = next_chunk(source, end)?;
    }
    Ok((json.ok_or("is a GLB file without a JSON chunk")?, bin))
}

/// Where the chunk after one that ends at `end` begins, which is where the source stands then. Chunks are multiples
/// of four bytes; of those that are not, some writers leave out the padding, others do not count it.
fn next_chunk(source: &mut (impl Read + Seek), end: u64) -> Parsed<u64> {
    let padded = end.next_multiple_of(4);
    let mut head = Vec::new();
    source.seek(SeekFrom::Start(end)).map_err(reason)?;
    source.by_ref().take(8).read_to_end(&mut head).map_err(reason)?;
    let next = if head.get(4..) == Some(b"BIN\0") { end } else { padded };
    source.seek(SeekFrom::Start(next)).map_err(reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_of_odd_sizes_are_read_with_and_without_their_padding() {
        for padding in [&b""[..], b" "] {
            let body = [b"\x03\0\0\0JSON{ }", padding, b"\x04\0\0\0BIN\x005678"].concat();
            let length = (12 + body.len() as u32).to_le_bytes();
            let glb = [b"glTF", &2u32.to_le_bytes(), &length, &body[..]].concat();
            assert_eq!(split(&glb).unwrap(), (&b"{ }"[..], Some(&b"5678"[..])), "{padding:?}");
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
