//! Pieces of a picture that are drawn one after another.

use super::pixel::{Counts, Painter};
use super::{Settings, Stage};
use crate::cpu::visibility;
use crate::lighting::LightRecord;
use crate::scene::view::View;
use crate::{Error, Result};
use glam::{DMat4, DVec3};
use image::{Rgba, RgbaImage};
use rayon::prelude::*;

/// Samples of a tile's side: 100 MiB of surface.
const SIDE: u32 = 1024;

/// A rectangle of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Tile {
    /// Its left upper pixel.
    corner: [u32; 2],
    /// Width and height, pixels.
    size: [u32; 2],
}

impl Tile {
    /// The tiles of a picture of `size`, in rows, where a pixel has `samples` samples a side.
    pub fn all([width, height]: [u32; 2], samples: u32) -> impl Iterator<Item = Self> {
        let side = (SIDE / samples).max(1);
        let starts = move |end: u32| (0..end).step_by(side as usize);
        starts(height).flat_map(move |y| {
            starts(width).map(move |x| Self {
                corner: [x, y],
                size: [side.min(width - x), side.min(height - y)],
            })
        })
    }

    /// Draws the tile into its place in the picture of each rig, and counts what it shows.
    ///
    /// # Errors
    /// [`Error::Interrupted`] as soon as `go_on` says no.
    pub fn draw(
        &self,
        (stage, settings): (&Stage, &Settings),
        rigs: &[&[LightRecord]],
        go_on: &(dyn Fn() -> bool + Sync),
        drawn: &mut [(RgbaImage, Counts)],
    ) -> Result<()> {
        if !go_on() {
            return Err(Error::Interrupted);
        }
        let side = settings.side();
        let surface = visibility::draw(stage.scene, &self.view(stage.view, side));
        let painter = Painter { stage, settings, surface: &surface };
        let [width, height] = self.size;
        let [left, top] = self.corner;
        let row = |y: u32| {
            let (mut samples, mut pixels) = (Vec::new(), Vec::new());
            for x in 0..width {
                painter.samples([x, y], &mut samples);
                pixels.extend(painter.pixel([left + x, top + y], &samples, rigs));
            }
            go_on().then_some(pixels).ok_or(Error::Interrupted)
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
        for (y, row) in (top..).zip(rows) {
            for (x, pixel) in (left..).zip(row.chunks_exact(rigs.len().max(1))) {
                for ((image, counts), &(color, counted)) in drawn.iter_mut().zip(pixel) {
                    image.put_pixel(x, y, Rgba(color));
                    *counts += counted;
                }
            }
        }
        Ok(())
    }

    /// The view of this tile alone, a pixel of it for each sample.
    fn view(&self, whole: &View, samples: u32) -> View {
        let scale = |axis: usize, all: u32| f64::from(all) / f64::from(self.size[axis]);
        let (x, y) = (scale(0, whole.width), scale(1, whole.height));
        let offset = |axis: usize, all: u32| {
            let from_left = f64::from(all) - 2.0 * f64::from(self.corner[axis]);
            from_left / f64::from(self.size[axis]) - 1.0
        };
        let moved = DVec3::new(offset(0, whole.width), offset(1, whole.height), 0.0);
        let part = DMat4::from_translation(moved) * DMat4::from_scale(DVec3::new(x, y, 1.0));
        let clip_from_frame = (part * whole.clip_from_frame.as_dmat4()).as_mat4();
        let [width, height] = self.size.map(|size| size * samples);
        View { width, height, clip_from_frame, ..whole.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once() {
        for size in [[1, 1], [256, 256], [257, 300], [1000, 3]] {
            let tiles: Vec<_> = Tile::all(size, 4).collect();
            let area: u32 = tiles.iter().map(|tile| tile.size[0] * tile.size[1]).sum();
            assert_eq!(area, size[0] * size[1]);
            assert!(tiles.iter().all(|tile| {
                let inside = |axis: usize| tile.corner[axis] + tile.size[axis] <= size[axis];
                inside(0) && inside(1) && tile.size.iter().all(|side| (1..=256).contains(side))
            }));
        }
        assert_eq!(Tile::all([2048, 2048], 4).count(), 64);
    }
}
