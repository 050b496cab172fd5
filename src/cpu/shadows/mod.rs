//! The shadow table of a view, by rays: all object pixels, all directions of the map. Reference of
//! `shaders/shadows.comp`.
//!
//! [`reference`] walks once for each pixel and direction. [`table`] makes the same bits faster: rays of one
//! direction are parallel, so that a tile of pixels walks the tree together (`beam.rs`).

mod beam;

use crate::objective::maps::Surface;
use crate::objective::shadows::{
    BLOCK, ShadowSettings, Shadows, direction, row_words, solid_angle, words,
};
use crate::scene::occluders::{Occluders, leave};
use beam::Tile;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Columns and rows of a tile.
const TILE: [u32; 2] = [8, 4];

/// Tiles whose bits are made before they go into the table; it bounds the memory.
const BATCH: usize = 1 << 14;

/// The shadow table of what a view shows. Of a side that would take more than the settings' memory it has
/// the largest that fits.
pub fn table(surface: &Surface, occluders: Arc<Occluders>, settings: &ShadowSettings) -> Shadows {
    let object = surface.code.iter().map(|&code| code != 0);
    let side = settings.fitting_side(object.clone().filter(|object| *object).count() as u64);
    let mut shadows = Shadows::new(side, object, occluders);
    let directions = directions(side);
    let tiles = tiles(surface);
    for tiles in tiles.chunks(BATCH) {
        let made: Vec<_> = tiles
            .par_iter()
            .map(|pixels| {
                let tile = Tile::new(surface, pixels);
                (pixels, beam::trace(&tile, shadows.occluders(), &directions, words(side)))
            })
            .collect();
        for (pixels, bits) in made {
            for (lane, &at) in pixels.iter().enumerate() {
                if let Some(number) = shadows.number(at as usize) {
                    let first = number / BLOCK * words(side) * BLOCK + number % BLOCK;
                    for (word, bits) in bits.chunks_exact(beam::LANES).enumerate() {
                        shadows.blocks_mut()[first + word * BLOCK] = bits[lane];
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
            let first = number / BLOCK * words(side) * BLOCK + number % BLOCK;
            shadows.blocks_mut()[first + d.word * BLOCK] |= u32::from(free) << d.bit;
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
    let rows = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
    let of = |[x, y]: [u32; 2]| Direction {
        towards: direction(side, [x, y]),
        word: y as usize * row_words(side) + (x / 32) as usize,
        bit: x % 32,
    };
    rows.map(of).collect()
}

/// The object pixels, tile by tile.
fn tiles(surface: &Surface) -> Vec<Vec<u32>> {
    let (width, height) = (surface.width, surface.height);
    let [columns, rows] = TILE;
    let corners = (0..height)
        .step_by(rows as usize)
        .flat_map(|top| (0..width).step_by(columns as usize).map(move |left| [left, top]));
    let object = |&at: &u32| surface.code[at as usize] != 0;
    let pixels = |[left, top]: [u32; 2]| -> Vec<u32> {
        let rows = top..(top + rows).min(height);
        let row = |y| (left..(left + columns).min(width)).map(move |x| y * width + x);
        rows.flat_map(row).filter(object).collect()
    };
    corners.map(pixels).filter(|pixels| !pixels.is_empty()).collect()
}

/// Adds how open each pixel is.
fn finish(surface: &Surface, mut shadows: Shadows) -> Shadows {
    let object: Vec<usize> = (0..surface.code.len()).filter(|&at| surface.code[at] != 0).collect();
    let weighted = weighted_directions(shadows.side());
    let open = |(number, &at): (usize, &usize)| {
        openness(&shadows, &weighted, number, surface.normal[at].into())
    };
    let openness = object.par_iter().enumerate().map(open).collect();
    shadows.set_openness(openness);
    shadows
}

/// Directions of the map with their shares of the sphere.
fn weighted_directions(side: u32) -> Vec<([u32; 2], Vec3)> {
    let rows = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
    rows.map(|at| (at, direction(side, at) * solid_angle(side, at))).collect()
}

/// Ambient occlusion: the cosine-weighted share of the directions above a surface of the unit normal `n`
/// from which light comes to an object pixel.
fn openness(shadows: &Shadows, weighted: &[([u32; 2], Vec3)], number: usize, n: Vec3) -> f32 {
    let (mut open, mut all) = (0.0, 0.0);
    for &(at, direction) in weighted {
        let weight = n.dot(direction).max(0.0);
        all += weight;
        open += if shadows.bit(number, at) { weight } else { 0.0 };
    }
    open / all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::build::SceneBuilder;
}
