//! The shadow table of a view, by rays: all object pixels, all directions of the map. Reference of
//! `shaders/shadows.comp`.
//!
//! [`reference()`] walks once for each pixel and direction. [`table`] makes the same bits faster: rays of one
//! direction are parallel, so that a tile of pixels walks the tree together (`tile.rs`), or where triangles are
//! smaller than pixels, all rays of a pixel in neighbouring directions (`rays.rs`).

mod beam;
mod rays;
mod tile;
mod wide;

use crate::objective::maps::Surface;
use crate::objective::shadows::{
    BLOCK, ShadowSettings, Shadows, direction, row_words, solid_angle, words,
};
use crate::scene::occluders::{Occluders, RAYS, leave};
use crate::{Error, Result};
use glam::Vec3;
use multiversion::multiversion;
use rayon::prelude::*;
use std::sync::Arc;
use tile::Tile;
use wide::Tree;

/// Columns and rows of a tile.
const TILE: [u32; 2] = [8, 4];

/// The same of a part of a tile.
const PART: [u32; 2] = [4, 2];

/// Tiles whose bits are made before they go into the table; it bounds the memory.
const BATCH: usize = 1 << 14;

/// The shadow table of what a view shows. Of a side that would take more than the settings' memory it has
/// the largest that fits.
pub fn table(surface: &Surface, occluders: Arc<Occluders>, settings: &ShadowSettings) -> Shadows {
    made(surface, occluders, settings, &|| true)
}

/// As [`table`], as long as `go_on` says so, which is asked for every tile of pixels.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn table_while(
    surface: &Surface,
    occluders: Arc<Occluders>,
    settings: &ShadowSettings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Shadows> {
    let table = made(surface, occluders, settings, go_on);
    if go_on() { Ok(table) } else { Err(Error::Interrupted) }
}

/// The table, without the tiles for which `go_on` has said no.
fn made(
    surface: &Surface,
    occluders: Arc<Occluders>,
    settings: &ShadowSettings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Shadows {
    let object = surface.code.iter().map(|&code| code != 0);
    let side = settings.fitting_side(object.clone().filter(|object| *object).count() as u64);
    let mut shadows = Shadows::new(side, object, Arc::clone(&occluders));
    let tree = Tree::new(&occluders);
    let directions = squares(side);
    let tiles = tiles(surface);
    for tiles in tiles.chunks(BATCH) {
        let made: Vec<_> = tiles
            .par_iter()
            .filter(|_| go_on())
            .map(|pixels| {
                let tile = Tile::new(surface, pixels);
                (pixels, tile::trace(&tile, &tree, &directions, words(side)))
            })
            .collect();
        for (pixels, bits) in made {
            for (lane, &at) in pixels.iter().enumerate() {
                if let Some(number) = shadows.number(at as usize) {
                    for (word, bits) in bits.chunks_exact(tile::LANES).enumerate() {
                        *shadows.word_mut(number, word) = bits[lane];
                    }
                }
            }
        }
    }
    finish(surface, shadows)
}

/// The same, ray by ray.
pub fn reference(surface: &Surface, occluders: Arc<Occluders>, side: u32) -> Shadows {
    let mut shadows = Shadows::new(side, surface.code.iter().map(|&code| code != 0), occluders);
    let directions = directions(side);
    for at in 0..surface.code.len() {
        let Some(number) = shadows.number(at) else { continue };
        let face = Vec3::from(surface.face[at]);
        let from = leave(surface.position[at].into(), face);
        for d in &directions {
            let free = face.dot(d.towards) <= 0.0
                || !shadows.occluders().blocked(from, d.towards, f32::INFINITY);
            *shadows.word_mut(number, d.word) |= u32::from(free) << d.bit;
        }
    }
    finish(surface, shadows)
}

/// A direction of the map and its bit in the words of a pixel.
#[derive(Debug, Clone, Copy)]
struct Direction {
    towards: Vec3,
    word: usize,
    bit: u32,
}

fn directions(side: u32) -> Vec<Direction> {
    grid(side).map(|at| numbered(side, at)).collect()
}

/// The same in squares of the map: no more together than a packet has rays.
fn squares(side: u32) -> Vec<Vec<Direction>> {
    let edge = RAYS.isqrt() as u32;
    let corners = grid(side.div_ceil(edge)).map(|corner| corner.map(|c| c * edge));
    let square = |[left, top]: [u32; 2]| {
        let inside = grid(edge).map(|[x, y]| [left + x, top + y]);
        let inside = inside.filter(|at| at.iter().all(|&c| c < side));
        inside.map(|at| numbered(side, at)).collect()
    };
    corners.map(square).collect()
}

/// Columns and rows of a square, row by row.
fn grid(side: u32) -> impl Iterator<Item = [u32; 2]> {
    (0..side).flat_map(move |y| (0..side).map(move |x| [x, y]))
}

fn numbered(side: u32, [x, y]: [u32; 2]) -> Direction {
    Direction {
        towards: direction(side, [x, y]),
        word: y as usize * row_words(side) + (x / 32) as usize,
        bit: x % 32,
    }
}

/// The object pixels, tile by tile, and in each of them part by part.
fn tiles(surface: &Surface) -> Vec<Vec<u32>> {
    let size = [surface.width, surface.height];
    let object = |&at: &u32| surface.code[at as usize] != 0;
    let pixels = |tile| {
        let parts = corners(tile, TILE, PART);
        let places = parts.flat_map(|part| corners(part, PART, [1, 1]));
        let seen = places.filter(|[x, y]| *x < size[0] && *y < size[1]);
        seen.map(|[x, y]| y * size[0] + x).filter(object).collect()
    };
    corners([0, 0], size, TILE).map(pixels).filter(|pixels: &Vec<_>| !pixels.is_empty()).collect()
}

/// The upper left corners of what a rectangle is cut into, row by row.
fn corners(
    [left, top]: [u32; 2],
    [width, height]: [u32; 2],
    [columns, rows]: [u32; 2],
) -> impl Iterator<Item = [u32; 2]> {
    let tops = (top..top + height).step_by(rows as usize);
    tops.flat_map(move |y| (left..left + width).step_by(columns as usize).map(move |x| [x, y]))
}

/// Adds how open each pixel is.
fn finish(surface: &Surface, mut shadows: Shadows) -> Shadows {
    let object: Vec<usize> = (0..surface.code.len()).filter(|&at| surface.code[at] != 0).collect();
    let weighted = weighted_directions(shadows.side());
    let words = words(shadows.side());
    let blocks = shadows.blocks().par_chunks(words * BLOCK).zip(object.par_chunks(BLOCK));
    let open = blocks.flat_map_iter(|(block, pixels)| {
        let mut normal = [[0.0; BLOCK]; 3];
        for (lane, &at) in pixels.iter().enumerate() {
            (0..3).for_each(|axis| normal[axis][lane] = surface.normal[at][axis]);
        }
        openness(block, &weighted, &normal).into_iter().take(pixels.len())
    });
    let openness = open.collect();
    shadows.set_openness(openness);
    shadows
}

/// Directions of the map with their shares of the sphere.
fn weighted_directions(side: u32) -> Vec<Direction> {
    let shares = grid(side).map(|at| solid_angle(side, at));
    let weigh = |(d, share): (Direction, f32)| Direction { towards: d.towards * share, ..d };
    directions(side).into_iter().zip(shares).map(weigh).collect()
}

/// Ambient occlusion: the cosine-weighted share of the directions above surfaces of the unit normals
/// `normal`, by axis, from which light comes to the pixels of a block of the table.
#[multiversion(targets = "simd")]
fn openness(block: &[u32], weighted: &[Direction], normal: &[[f32; BLOCK]; 3]) -> [f32; BLOCK] {
    let (mut open, mut all) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
    let [x, y, z] = normal;
    for d in weighted {
        let words = &block[d.word * BLOCK..][..BLOCK];
        for lane in 0..BLOCK {
            let cosine = x[lane] * d.towards.x + y[lane] * d.towards.y + z[lane] * d.towards.z;
            let weight = if cosine > 0.0 { cosine } else { 0.0 };
            all[lane] += weight;
            open[lane] += if words[lane] >> d.bit & 1 != 0 { weight } else { 0.0 };
        }
    }
    for lane in 0..BLOCK {
        open[lane] /= if all[lane] > 0.0 { all[lane] } else { 1.0 };
    }
    open
}

#[cfg(test)]
mod tests;
