//! Filling of triangles by integer edge functions (Pineda 1988) with Vulkan's rules: samples at
//! pixel centres, 8 bits of subpixel precision, top-left rule, depth linear in screen space.

use glam::DVec4;
use std::ops::Range;

/// Subpixel steps in a pixel.
const SUBPIXEL: i32 = 256;

/// Subpixel steps from the picture's corner, at most, so that products of them fit in 64 bits.
const FARTHEST: i32 = 1 << 29;

/// A corner in the picture: subpixel units from the left and the top, and depth.
#[derive(Debug, Clone, Copy, Default)]
pub struct Corner {
    x: i32,
    y: i32,
    depth: f64,
}

impl Corner {
    /// Where a point of clip space falls in a picture of the given size.
    pub fn project(clip: DVec4, width: u32, height: u32) -> Self {
        // In f32, as GPUs do it: the snapped position hangs on the last bit.
        let reciprocal = 1.0 / clip.w as f32;
        let snap = |position: f64, size: u32| {
            let half = size as f32 * 0.5;
            let steps = ((position as f32 * reciprocal) * half + half) * SUBPIXEL as f32;
            // What lies at the very eye may be projected beyond the guard band.
            (steps.round_ties_even() as i32).clamp(-FARTHEST, FARTHEST)
        };
        Self {
            x: snap(clip.x, width),
            y: snap(clip.y, height),
            depth: f64::from(clip.z as f32 * reciprocal),
        }
    }
}

/// A triangle in the picture, clockwise as seen.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    corners: [Corner; 3],
    /// Its polygon's number.
    pub code: u32,
    /// Whether each pixel has to pass the alpha test.
    pub masked: bool,
}

/// Which way round a triangle is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Winding {
    /// As seen in the picture.
    Clockwise,
    /// As seen in the picture.
    CounterClockwise,
}

/// The rows of the picture that one call fills.
pub struct Target<'a> {
    /// Pixels in a row of the picture.
    pub width: u32,
    /// Which rows.
    pub rows: Range<u32>,
    /// Reversed depth, 0 where nothing is drawn.
    pub depth: &'a mut [f32],
    /// Colour code, 0 where nothing is drawn.
    pub code: &'a mut [u32],
}

impl Triangle {
    /// A triangle and its winding; `None` when it has no area.
    pub fn new(mut corners: [Corner; 3], code: u32, masked: bool) -> Option<(Self, Winding)> {
        let area = edge(&corners[0], &corners[1], corners[2].x, corners[2].y);
        let winding = match area {
            0 => return None,
            1.. => Winding::Clockwise,
            _ => {
                corners.swap(1, 2);
                Winding::CounterClockwise
            }
        };
        Some((Self { corners, code, masked }, winding))
    }

    /// Rows whose pixel centres lie between the corners.
    pub fn rows(&self, height: u32) -> Range<u32> {
        centres(self.corners.map(|c| c.y), 0..height)
    }

    /// Columns whose pixel centres lie between the corners.
    pub fn columns(&self, width: u32) -> Range<u32> {
        centres(self.corners.map(|c| c.x), 0..width)
    }

    /// Draws the triangle where it is nearer than what is there and `passes(x, y)`.
    pub fn fill(&self, target: &mut Target, passes: impl Fn(u32, u32) -> bool) {
        let [a, b, c] = &self.corners;
        let rows = centres(self.corners.map(|c| c.y), target.rows.clone());
        let columns = centres(self.corners.map(|c| c.x), 0..target.width);
        let edges = [(b, c), (c, a), (a, b)];
        let area = edge(a, b, c.x, c.y) as f64;
        let slope = [(b.depth - a.depth) / area, (c.depth - a.depth) / area];
        // A pixel centre on an edge belongs to the triangle whose top or left edge it is.
        let bias = edges.map(|(from, to)| {
            let top_left = to.y < from.y || (to.y == from.y && to.x > from.x);
            i64::from(!top_left)
        });
        let step = edges.map(|(from, to)| i64::from(from.y - to.y) * i64::from(SUBPIXEL));
        for y in rows {
            let (px, py) = (centre(columns.start), centre(y));
            let mut e: [i64; 3] =
                std::array::from_fn(|k| edge(edges[k].0, edges[k].1, px, py) - bias[k]);
            let row = ((y - target.rows.start) * target.width) as usize;
            for x in columns.clone() {
                if (e[0] | e[1] | e[2]) >= 0 {
                    let at = row + x as usize;
                    let along = [(e[1] + bias[1]) as f64, (e[2] + bias[2]) as f64];
                    let depth = (a.depth + along[0] * slope[0] + along[1] * slope[1]) as f32;
                    if depth > target.depth[at] && passes(x, y) {
                        target.depth[at] = depth;
                        target.code[at] = self.code;
                    }
                }
                for k in 0..3 {
                    e[k] += step[k];
                }
            }
        }
    }
}

/// Twice the area of the triangle `from`, `to`, (x, y); positive when clockwise as seen.
fn edge(from: &Corner, to: &Corner, x: i32, y: i32) -> i64 {
    let along = [i64::from(to.x) - i64::from(from.x), i64::from(to.y) - i64::from(from.y)];
    let off = [i64::from(x) - i64::from(from.x), i64::from(y) - i64::from(from.y)];
    along[0] * off[1] - along[1] * off[0]
}

fn centre(pixel: u32) -> i32 {
    pixel as i32 * SUBPIXEL + SUBPIXEL / 2
}

/// Pixels of `within` whose centres lie between the smallest and the largest coordinate.
fn centres(coordinates: [i32; 3], within: Range<u32>) -> Range<u32> {
    let [a, b, c] = coordinates;
    let first = (a.min(b).min(c) + SUBPIXEL / 2 - 1).div_euclid(SUBPIXEL);
    let last = (a.max(b).max(c) - SUBPIXEL / 2).div_euclid(SUBPIXEL);
    let start = i64::from(first).clamp(within.start.into(), within.end.into()) as u32;
    let end = (i64::from(last) + 1).clamp(start.into(), within.end.into()) as u32;
    start..end
}
