//! What a file may make klieg take of memory and time: few bytes can stand for very much. `docs/LIMITS.md` is
//! the table of these numbers.

use super::Parsed;
use super::picture::Picture;
use crate::scene::{Vertex, memory};
use gltf::json::Root;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use std::cell::Cell;

/// Share of the machine's free memory that a scene may take.
const MEMORY: (u64, u64) = (3, 4);
/// Bytes of memory for each of parsed JSON, about.
const JSON: u64 = 64;
/// Drawings of meshes for each byte of a file (a fraction), and without any.
const INSTANCES: (u64, u64) = (4, 1 << 18);
/// Drawn triangles for each byte of a file, and without any.
const TRIANGLES: (u64, u64) = (64, 1 << 24);
/// Texels for each byte of the encoded images, and without any.
const TEXELS: (u64, u64) = (1024, 1 << 26);

/// How to raise what a file's size allows.
const LARGE: &str = "--allow-large takes it all the same";

/// What is left for a file.
#[derive(Debug)]
pub struct Budget {
    /// Bytes of memory.
    memory: Cell<u64>,
    /// Bytes of the file and what it names.
    bytes: u64,
    /// Whether only the machine limits.
    large: bool,
}

impl Budget {
    /// Of a file whose parts have so many bytes together.
    pub fn new(bytes: u64, large: bool) -> Self {
        Self::with_memory(bytes, large, memory::available() / MEMORY.1 * MEMORY.0)
    }

    fn with_memory(bytes: u64, large: bool, memory: u64) -> Self {
        Self { memory: Cell::new(memory), bytes, large }
    }

    /// Takes memory for a part of the scene.
    pub fn take(&self, bytes: u64) -> Parsed<()> {
        let left = self.memory.get();
        let left = left.checked_sub(bytes).ok_or_else(|| {
            let (needed, free) = (gibibytes(bytes), gibibytes(left));
            format!("needs {needed} GiB more memory, and {free} GiB are free for it here")
        })?;
        self.memory.set(left);
        Ok(())
    }

    /// Whether a scene may draw so many meshes and triangles.
    pub fn check_drawn(&self, instances: usize, triangles: u32) -> Parsed<()> {
        let (share, least) = INSTANCES;
        self.check("meshes", instances as u64, least + self.bytes / share)?;
        let (each, least) = TRIANGLES;
        self.check("triangles", triangles.into(), least + each.saturating_mul(self.bytes))
    }

    /// Whether images of so many encoded bytes may have so many texels.
    pub fn check_texels(&self, texels: u64, encoded: u64) -> Parsed<()> {
        let (each, least) = TEXELS;
        self.check("texels", texels, least + each.saturating_mul(encoded))
    }

    fn check(&self, what: &str, number: u64, most: u64) -> Parsed<()> {
        if number <= most || self.large {
            return Ok(());
        }
        Err(format!("has {number} {what} and more, where klieg takes {most} of its size: {LARGE}"))
    }

    /// Takes the memory that a primitive's mesh needs. Gives whether there is anything to draw: positions or
    /// indices without data are all the same, unless they are `compressed`.
    pub fn take_mesh(&self, root: &Root, primitive: &Primitive, compressed: bool) -> Parsed<bool> {
        let accessor = |index: gltf::json::Index<_>| root.get(index);
        let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(positions) = find(Semantic::Positions).and_then(accessor) else { return Ok(true) };
        let indices = primitive.indices.and_then(accessor);
        let parts = [Some(positions), indices].into_iter().flatten();
        if !compressed
            && parts.clone().any(|part| part.buffer_view.is_none() && part.sparse.is_none())
        {
            return Ok(false);
        }
        let (vertices, corners) = (positions.count.0, indices.unwrap_or(positions).count.0);
        let strip =
            matches!(primitive.mode, Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan));
        let corners = corners.saturating_mul(if strip { 3 } else { 1 });
        // Without normals each triangle has its own vertices.
        let used = if find(Semantic::Normals).is_some() { vertices.min(corners) } else { corners };
        let sparse = parts.filter(|part| part.sparse.is_some()).map(|part| part.count.0);
        let indices = corners.saturating_mul(2 * size_of::<u32>() as u64);
        let mesh = used.saturating_mul(size_of::<Vertex>() as u64 + 4).saturating_add(indices);
        self.take(mesh.saturating_add(sparse.fold(0, u64::saturating_add).saturating_mul(16)))?;
        Ok(true)
    }
}

/// Whether there is memory for JSON of so many bytes.
pub fn check_json(bytes: u64) -> Parsed<()> {
    Budget::new(0, true)
        .take(bytes.saturating_mul(JSON))
        .map_err(|fault| format!("its JSON {fault}"))
}

/// The picture, where its data can hold the pixels that a PNG or a JPEG claims.
pub fn check_claim(picture: Picture) -> Parsed<Picture> {
    let Ok([width, height]) = picture.size() else { return Ok(picture) };
    match held(picture.bytes(), [width, height]) {
        true => Ok(picture),
        false => {
            let bytes = picture.bytes().len();
            Err(format!("it claims {width}x{height} pixels, which its {bytes} bytes cannot hold"))
        }
    }
}

/// Whether the data of a PNG or a JPEG can hold so many pixels.
fn held(data: &[u8], [width, height]: [u32; 2]) -> bool {
    let pixels = u64::from(width) * u64::from(height);
    let bytes = data.len() as u64;
    let most = match data {
        // The IHDR chunk comes first: bits of a sample and kind of colour (PNG, third edition, 11.2.1).
        [0x89, b'P', b'N', b'G', ..] => {
            let depth = data.get(24).map_or(1, |&depth| u64::from(depth.max(1)));
            let channels = match data.get(25) {
                Some(2) => 3,
                Some(4) => 2,
                Some(6) => 4,
                _ => 1,
            };
            bytes.saturating_mul(DEFLATE * 8) / (depth * channels)
        }
        // A bit at least for each block of 8x8 (ITU T.81, F.1.2).
        [0xff, 0xd8, ..] => bytes.saturating_mul(8 * 64),
        _ => u64::MAX,
    };
    pixels <= most
}

/// Most bytes that a deflated one stands for (RFC 1951: a match of 258 in two bits).
const DEFLATE: u64 = 1032;

fn gibibytes(bytes: u64) -> f64 {
    (bytes as f64 / f64::from(1 << 30) * 10.0).ceil() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_limits_always_and_the_size_unless_large_ones_are_allowed() {
        let budget = Budget::with_memory(1000, false, 100);
        budget.take(60).unwrap();
        assert!(budget.take(60).unwrap_err().contains("memory"));
        budget.take(40).unwrap();
        budget.check_drawn(1 << 18, 1 << 24).unwrap();
        for (instances, triangles) in [(1 << 19, 1), (1, 1 << 25)] {
            let fault = budget.check_drawn(instances, triangles).unwrap_err();
            assert!(fault.contains("--allow-large"), "{fault}");
        }
        budget.check_texels(1 << 26, 0).unwrap();
        assert!(budget.check_texels(1 << 27, 1000).unwrap_err().contains("texels"));
        let large = Budget::with_memory(0, true, 100);
        large.check_drawn(1 << 22, u32::MAX).unwrap();
        assert!(large.take(101).is_err());
        assert!(check_json(u64::MAX).unwrap_err().contains("JSON"));
    }

    #[test]
    fn pictures_cannot_claim_more_than_their_data_holds() {
        let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\0\0\0\0\0\x01\0\0\0\0".to_vec();
        png.resize(1000, 0);
        assert!(held(&png, [2048, 2048]) && !held(&png, [4096, 4096]));
        (png[24], png[25]) = (8, 6);
        assert!(!held(&png, [1024, 512]));
        let mut jpeg = vec![0xff, 0xd8];
        jpeg.resize(1000, 0);
        assert!(held(&jpeg, [512, 1000]) && !held(&jpeg, [513, 1000]));
    }
}
