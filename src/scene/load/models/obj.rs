//! OBJ (Wavefront). Its materials are not read.

use super::Part;
use super::color::encoded;
use crate::scene::load::Parsed;
use std::io::BufRead;
use tobj::{LoadError, LoadOptions};

/// Reads a file's objects.
pub fn read(source: &mut impl BufRead) -> Parsed<Vec<Part>> {
    let options = LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let without_materials = |_: &_| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(source, &options, without_materials)
        .map_err(|error| format!("is not valid OBJ: {error}"))?;
    Ok(models.into_iter().map(part).collect())
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
    Part { name, positions, normals, colors, indices: mesh.indices }
}
