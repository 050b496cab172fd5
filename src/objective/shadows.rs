//! The shadow table of a view: from which directions each object pixel can be lit.
//!
//! Camera and geometry stand fast; only lights move. A light outside the scene's ball is seen from a pixel
//! or not by the direction to it alone, so that one bit for each of some directions tells all. The
//! directions are the vertices of an octahedral map (Meyer et al. 2010): bit `x` of row `y` is the direction
//! of [`direction`]; between the four around a direction it is blended.

use crate::constants::{NO_PIXEL, SHADOW_BLOCK};
use crate::lighting::LightRecord;
use crate::scene::occluders::{Occluders, leave};
use crate::{Error, Result};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Object pixels that stand side by side in the table.
pub const BLOCK: usize = SHADOW_BLOCK as usize;

/// Whether lights cast shadows, and how fine the table of them is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowSettings {
    /// Whether lights cast shadows.
    pub on: bool,
    /// Directions along a side of the octahedral map: an odd number, 3..=63.
    pub side: u32,
    /// Most memory of the table, MiB; a table that would be larger has fewer directions.
    pub memory: u32,
}

impl Default for ShadowSettings {
    fn default() -> Self {
        Self { on: false, side: 31, memory: 1024 }
    }
}

impl ShadowSettings {
    /// # Errors
    /// [`Error::Argument`] for a side that is even or out of its range, and no memory.
    pub fn check(&self) -> Result<()> {
        if !(3..=63).contains(&self.side) || self.side.is_multiple_of(2) {
            let fault = format!("shadows.side is {}: it must be an odd number, 3 to 63", self.side);
            return Err(Error::Argument(fault));
        }
        if self.memory == 0 {
            return Err(Error::Argument("shadows.memory is 0 MiB: it must be 1 or more".into()));
        }
        Ok(())
    }

    /// The side of the largest table for so many entries (pixels) that fits the memory, 3 at least.
    pub fn fitting_side(&self, pixels: u64) -> u32 {
        let bytes = u64::from(self.memory) << 20;
        let fits = |side: &u32| 4 * pixels * words(*side) as u64 <= bytes;
        (3..=self.side).rev().step_by(2).find(fits).unwrap_or(3)
    }
}

/// Words of a pixel: `ceil(side / 32)` for each row.
pub const fn words(side: u32) -> usize {
    side as usize * row_words(side)
}

/// Words of a row.
pub const fn row_words(side: u32) -> usize {
    side.div_ceil(32) as usize
}

/// The direction of bit `x` of row `y`, light frame.
pub fn direction(side: u32, [x, y]: [u32; 2]) -> Vec3 {
    let coordinate = |at: u32| 2.0 * at as f32 / (side - 1) as f32 - 1.0;
    let (u, v) = (coordinate(x), coordinate(y));
    let z = 1.0 - u.abs() - v.abs();
    if z >= 0.0 {
        return Vec3::new(u, v, z).normalize();
    }
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    Vec3::new((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v), z).normalize()
}

/// Place of a direction, of any length, in the octahedral map: 0..=1 along both sides.
pub fn place(d: Vec3) -> [f32; 2] {
    let inverse = 1.0 / (d.x.abs() + d.y.abs() + d.z.abs());
    let (u, v) = (d.x * inverse, d.y * inverse);
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    let (u, v) =
        if d.z < 0.0 { ((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v)) } else { (u, v) };
    [0.5 * u + 0.5, 0.5 * v + 0.5]
}

/// Share of the sphere that a vertex of the map stands for, times a constant: vertices on the map's border
/// come twice, its corners four times.
pub fn solid_angle(side: u32, at: [u32; 2]) -> f32 {
    let d = direction(side, at);
    // The area of an octahedron's face as the sphere's centre sees it.
    let area = (d.x.abs() + d.y.abs() + d.z.abs()).powi(3);
    at.iter().fold(area, |area, &c| if c == 0 || c == side - 1 { 0.5 * area } else { area })
}

/// The shadow table of a view, with what casts the shadows.
#[derive(Debug, Clone)]
pub struct Shadows {
    side: u32,
    /// Of each pixel of the picture its number among the object's; `u32::MAX` in the background.
    numbers: Vec<u32>,
    /// Blocks of [`BLOCK`] object pixels: a word of each of them, then the next word.
    blocks: Vec<u32>,
    /// Cosine-weighted share of the directions from which each object pixel can be lit.
    openness: Vec<f32>,
    occluders: Arc<Occluders>,
}

impl PartialEq for Shadows {
    fn eq(&self, other: &Self) -> bool {
        (self.side, &self.numbers, &self.blocks) == (other.side, &other.numbers, &other.blocks)
    }
}

impl Shadows {
    /// A table of `side` rows, all bits 0, for the pixels of a picture that show an object.
    pub(crate) fn new(
        side: u32,
        object: impl Iterator<Item = bool>,
        occluders: Arc<Occluders>,
    ) -> Self {
        let mut count = 0;
        let mut number = |object: bool| {
            let number = if object { count } else { NO_PIXEL };
            count += u32::from(object);
            number
        };
        let numbers = object.map(&mut number).collect();
        let blocks = vec![0; (count as usize).div_ceil(BLOCK) * BLOCK * words(side)];
        Self { side, numbers, blocks, openness: vec![1.0; count as usize], occluders }
    }

    /// The table of a picture of some of these pixels: of each of its own the place here, none in the background.
    pub(crate) fn of_pixels(&self, pixels: &[Option<usize>]) -> Self {
        let numbers = pixels.iter().map(|at| at.and_then(|at| self.number(at)));
        let object = numbers.clone().map(|number| number.is_some());
        let mut part = Self::new(self.side, object, Arc::clone(&self.occluders));
        for (number, old) in numbers.flatten().enumerate() {
            for word in 0..words(self.side) {
                *part.word_mut(number, word) = self.word(old, word);
            }
            part.openness[number] = self.openness[old];
        }
        part
    }

    /// Directions along a side of the map.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Object pixels.
    pub fn pixels(&self) -> usize {
        self.openness.len()
    }

    /// What casts the shadows.
    pub fn occluders(&self) -> &Arc<Occluders> {
        &self.occluders
    }

    /// The words of [`BLOCK`] object pixels, block after block: of every pixel a word, then of every pixel
    /// the next one; bits are 1 where light comes through.
    pub fn blocks(&self) -> &[u32] {
        &self.blocks
    }

    /// Of each object pixel the cosine-weighted share of the directions that light comes from, 0..=1.
    pub fn openness(&self) -> &[f32] {
        &self.openness
    }

    pub(crate) fn set_openness(&mut self, openness: Vec<f32>) {
        self.openness = openness;
    }

    /// The number among the object's pixels of pixel `at` of the picture; none in the background.
    pub fn number(&self, at: usize) -> Option<usize> {
        let number = self.numbers[at];
        (number != NO_PIXEL).then_some(number as usize)
    }

    /// A word of an object pixel.
    pub fn word(&self, number: usize, word: usize) -> u32 {
        self.blocks[self.place_of(number, word)]
    }

    /// As [`Shadows::word`], to be filled.
    pub(crate) fn word_mut(&mut self, number: usize, word: usize) -> &mut u32 {
        let place = self.place_of(number, word);
        &mut self.blocks[place]
    }

    /// Where a word of an object pixel stands in the blocks.
    fn place_of(&self, number: usize, word: usize) -> usize {
        (number / BLOCK * words(self.side) + word) * BLOCK + number % BLOCK
    }

    /// Whether light from direction `(x, y)` of the map comes to an object pixel.
    pub fn bit(&self, number: usize, [x, y]: [u32; 2]) -> bool {
        let word = y as usize * row_words(self.side) + (x / 32) as usize;
        self.word(number, word) >> (x % 32) & 1 == 1
    }

    /// Visibility 0..=1 from an object pixel in a direction, which need not be of unit length.
    pub fn towards(&self, number: usize, direction: Vec3) -> f32 {
        let last = (self.side - 1) as f32;
        let at = place(direction).map(|c| c * last);
        let cell = at.map(|c| (c as u32).min(self.side - 2));
        let [fx, fy] = [0, 1].map(|k| at[k] - cell[k] as f32);
        let bit = |dx, dy| if self.bit(number, [cell[0] + dx, cell[1] + dy]) { 1.0 } else { 0.0 };
        let row = |dy| bit(0, dy) + fx * (bit(1, dy) - bit(0, dy));
        row(0) + fy * (row(1) - row(0))
    }

    /// Visibility 0..=1 of a light from an object pixel at `p` on a polygon of the unit normal `face`; one
    /// that stands within the scene's ball is looked for itself.
    pub fn light(&self, number: usize, light: &LightRecord, p: Vec3, face: Vec3) -> f32 {
        let position = Vec3::from(light.position);
        let to_light = if light.radius2 > 0.0 { position - p } else { position };
        if !light.is_near() {
            return self.towards(number, to_light);
        }
        if self.sees(to_light, p, face) { 1.0 } else { 0.0 }
    }

    /// Whether the way from `p` over `to_light` is free. What lies below the polygon's horizon counts as
    /// free, as in the table.
    pub fn sees(&self, to_light: Vec3, p: Vec3, face: Vec3) -> bool {
        let distance = to_light.length();
        let direction = to_light / distance;
        face.dot(direction) <= 0.0 || !self.occluders.blocked(leave(p, face), direction, distance)
    }
}
