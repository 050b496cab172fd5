//! How much of a light the pixels of a group see: the shadow table's lookup, in lanes.

use super::super::compact::{LANES, Lanes};
use crate::lighting::LightRecord;
use crate::objective::shadows::{BLOCK, Shadows, row_words, words};

const _: () = assert!(BLOCK == LANES, "a block of the table is a group");

/// What shading reads besides the surface.
#[derive(Debug, Clone, Copy, Default)]
pub struct Casting<'a> {
    /// The shadow table, if lights cast shadows.
    pub shadows: Option<&'a Shadows>,
    /// Positions and polygons' normals of all object pixels; for lights within the scene.
    pub places: &'a [[[f32; 3]; 2]],
    /// Number of the first group among all.
    pub first: usize,
}

/// Places of a group's directions in the table: a cell, and where in it.
#[derive(Clone, Copy, Default)]
struct Places {
    cell: [[u32; LANES]; 2],
    within: [Lanes; 2],
}

/// Multiplies what a group receives of a light with the light's visibility.
#[inline(always)]
pub(super) fn shadow(
    casting: &Casting,
    shadows: &Shadows,
    group: usize,
    light: &LightRecord,
    towards: &[Lanes; 3],
    received: &mut Lanes,
) {
    let number = casting.first + group;
    if light.is_near() {
        return shadow_of_near(casting, shadows, number, light, received);
    }
    let side = shadows.side();
    let block = &shadows.blocks()[number * words(side) * LANES..][..words(side) * LANES];
    let mut places = Places::default();
    find(towards, side, &mut places);
    let mut taps = [[0u32; LANES]; 4];
    match row_words(side) {
        1 => read_narrow(block, &places, &mut taps),
        _ => read_wide(block, &places, &mut taps),
    }
    let [fx, fy] = &places.within;
    for k in 0..LANES {
        let (a, b) = (taps[0][k] as i32 as f32, taps[1][k] as i32 as f32);
        let (c, d) = (taps[2][k] as i32 as f32, taps[3][k] as i32 as f32);
        let above = fx[k].mul_add(b - a, a);
        let below = fx[k].mul_add(d - c, c);
        received[k] *= fy[k].mul_add(below - above, above);
    }
}

/// As [`crate::objective::shadows::place`].
#[inline(always)]
fn find([x, y, z]: &[Lanes; 3], side: u32, places: &mut Places) {
    let last = (side - 1) as f32;
    let most = (side - 2) as f32;
    let [cells_x, cells_y] = &mut places.cell;
    let [within_x, within_y] = &mut places.within;
    for k in 0..LANES {
        let inverse = 1.0 / (x[k].abs() + y[k].abs() + z[k].abs());
        let (u, v) = (x[k] * inverse, y[k] * inverse);
        let folded_u = (1.0 - v.abs()).copysign(u);
        let folded_v = (1.0 - u.abs()).copysign(v);
        let (u, v) = if z[k] < 0.0 { (folded_u, folded_v) } else { (u, v) };
        let (u, v) = ((0.5 * u + 0.5) * last, (0.5 * v + 0.5) * last);
        let (cell_u, cell_v) = (floor(u, most), floor(v, most));
        cells_x[k] = integer(cell_u);
        cells_y[k] = integer(cell_v);
        within_x[k] = u - cell_u;
        within_y[k] = v - cell_v;
    }
}

/// The integer below `x`, 0..=`most`; 0 of what is not a number.
#[inline(always)]
fn floor(x: f32, most: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < most { x } else { most };
    x.floor()
}

/// A small integer, 0 or more, as such.
#[inline(always)]
fn integer(x: f32) -> u32 {
    /// From here on the last bit of a number is worth 1.
    const UNIT: f32 = 8_388_608.0;
    (x + UNIT).to_bits() - UNIT.to_bits()
}

/// Rows of one word each.
#[inline(always)]
fn read_narrow(block: &[u32], places: &Places, taps: &mut [[u32; LANES]; 4]) {
    let [cells_x, cells_y] = &places.cell;
    let (mut above, mut below) = ([0; LANES], [0; LANES]);
    let last = block.len() - 1;
    for k in 0..LANES {
        let first = cells_y[k] as usize * LANES + k;
        // Never more than the last, but a bound that the compiler knows keeps panics out of the loop.
        (above[k], below[k]) = (block[first.min(last)], block[(first + LANES).min(last)]);
    }
    let [a, b, c, d] = taps;
    for k in 0..LANES {
        let x = cells_x[k];
        a[k] = above[k] >> (x & 31) & 1;
        b[k] = above[k] >> ((x + 1) & 31) & 1;
        c[k] = below[k] >> (x & 31) & 1;
        d[k] = below[k] >> ((x + 1) & 31) & 1;
    }
}

/// Rows of two words each.
#[inline(always)]
fn read_wide(block: &[u32], places: &Places, taps: &mut [[u32; LANES]; 4]) {
    for (tap, taps) in taps.iter_mut().enumerate() {
        for k in 0..LANES {
            let [x, y] =
                [places.cell[0][k] as usize + tap % 2, places.cell[1][k] as usize + tap / 2];
            taps[k] = block[(2 * y + x / 32) * LANES + k] >> (x % 32) & 1;
        }
    }
}

/// A light within the scene's ball is looked for by rays of its own.
#[inline(never)]
fn shadow_of_near(
    casting: &Casting,
    shadows: &Shadows,
    group: usize,
    light: &LightRecord,
    received: &mut Lanes,
) {
    let places = casting.places.iter().skip(group * LANES);
    for (received, &[p, face]) in received.iter_mut().zip(places) {
        if *received > 0.0 && shadows.light(0, light, p.into(), face.into()) == 0.0 {
            *received = 0.0;
        }
    }
}
