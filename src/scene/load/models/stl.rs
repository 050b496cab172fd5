//! STL, binary and as text.

use super::Part;
use crate::scene::load::Parsed;
use std::io::{Read, Seek, SeekFrom};

/// Bytes of a binary file before its triangles, and of each of these.
const HEADER: u64 = 84;
const TRIANGLE: usize = 50;

/// Reads a file of `length` bytes. Its normals are those of its triangles, and not looked at.
pub fn read(source: &mut (impl Read + Seek), length: u64) -> Parsed<Part> {
    let fault = |error: std::io::Error| format!("is not valid STL: {error}");
    let mut head = Vec::new();
    source.take(HEADER).read_to_end(&mut head).map_err(fault)?;
    let count = head.last_chunk().map_or(0, |count| u64::from(u32::from_le_bytes(*count)));
    // Binary files may begin as text does; only their length tells them for sure.
    let expected = HEADER + TRIANGLE as u64 * count;
    let is_text = head.starts_with(b"solid");
    if head.len() as u64 == HEADER && (length == expected || !is_text) {
        return match length < expected {
            true => Err(format!("is truncated: {length} of {expected} bytes of STL are there")),
            false => binary(source, count).map_err(fault),
        };
    }
    source.seek(SeekFrom::Start(0)).map_err(fault)?;
    let mut part = part();
    for triangle in stl_io::create_stl_reader(source).map_err(fault)? {
        let vertices = triangle.map_err(fault)?.vertices;
        part.positions.extend(vertices.map(|vertex| [vertex[0], vertex[1], vertex[2]]));
    }
    Ok(part)
}

fn part() -> Part {
    Part { name: "STL".into(), ..Part::default() }
}

fn binary(source: &mut impl Read, count: u64) -> std::io::Result<Part> {
    let mut part = part();
    part.positions.reserve_exact(3 * count as usize);
    let mut triangle = [0; TRIANGLE];
    for _ in 0..count {
        source.read_exact(&mut triangle)?;
        // A normal of three numbers stands before the corners.
        let numbers = triangle[12..48].as_chunks::<4>().0;
        let corner = |k: usize| [0, 1, 2].map(|axis| f32::from_le_bytes(numbers[3 * k + axis]));
        part.positions.extend([0, 1, 2].map(corner));
    }
    Ok(part)
}
