//! OBJ (Wavefront).

use super::Part;
use super::color::encoded;
use super::mtl::Libraries;
use crate::scene::load::Parsed;
use std::cell::RefCell;
use std::io::{BufRead, BufReader, Read, Result, Take};
use tobj::{LoadOptions, Material};

/// Most bytes of a line that are looked at together.
const LINE: u64 = 1 << 20;

/// Reads a file's objects and the materials that they name.
pub fn read(
    source: &mut impl BufRead,
    libraries: &mut Libraries,
) -> Parsed<(Vec<Part>, Vec<Material>)> {
    let options = LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let mut lines = BufReader::new(Lines { source: source.take(LINE), line: Vec::new(), at: 0 });
    let libraries = RefCell::new(libraries);
    let load = |path: &_| libraries.borrow_mut().load(path);
    let (models, materials) = tobj::load_obj_buf(&mut lines, &options, load)
        .map_err(|error| format!("is not valid OBJ: {error}"))?;
    // What is wrong with them stands in the warnings.
    let materials = materials.unwrap_or_default();
    Ok((models.into_iter().map(part).collect(), materials))
}

fn part(model: tobj::Model) -> Part {
    let tobj::Model { mesh, name } = model;
    let triples = |values: &[f32]| values.as_chunks::<3>().0.to_vec();
    let positions = triples(&mesh.positions);
    let mut normals = triples(&mesh.normals);
    if normals.len() != positions.len() {
        normals.clear();
    }
    let colors = triples(&mesh.vertex_color).into_iter().map(|[r, g, b]| encoded([r, g, b, 1.0]));
    let mut colors: Vec<_> = colors.collect();
    if colors.len() != positions.len() {
        colors.clear();
    }
    // Textures have their origin below.
    let pairs = mesh.texcoords.as_chunks::<2>().0;
    let mut texture_coordinates: Vec<_> = pairs.iter().map(|&[u, v]| [u, 1.0 - v]).collect();
    if texture_coordinates.len() != positions.len() {
        texture_coordinates.clear();
    }
    let (indices, material) = (mesh.indices, mesh.material_id);
    Part { name, positions, normals, colors, texture_coordinates, indices, material }
}

/// The lines of a file as its parser takes them: UTF-8, those that a backslash ends joined with the next one, and
/// without those that name no material.
struct Lines<R> {
    source: Take<R>,
    line: Vec<u8>,
    at: usize,
}

impl<R: BufRead> Lines<R> {
    fn next(&mut self) -> Result<()> {
        (self.at, self.line) = (0, Vec::new());
        self.source.set_limit(LINE);
        self.source.read_until(b'\n', &mut self.line)?;
        if str::from_utf8(&self.line).is_err() {
            self.line = String::from_utf8_lossy(&self.line).into_owned().into_bytes();
        }
        if let Some(continued) = self.line.trim_ascii_end().strip_suffix(b"\\") {
            let length = continued.len();
            self.line.truncate(length);
            self.line.push(b' ');
        } else if self.line.trim_ascii() == b"usemtl" {
            self.line = b"\n".to_vec();
        }
        Ok(())
    }
}

impl<R: BufRead> Read for Lines<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.at == self.line.len() {
            self.next()?;
        }
        let length = out.len().min(self.line.len() - self.at);
        out[..length].copy_from_slice(&self.line[self.at..self.at + length]);
        self.at += length;
        Ok(length)
    }
}
