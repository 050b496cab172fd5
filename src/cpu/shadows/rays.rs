//! The rays of one pixel in neighbouring directions walk the tree together: where a tile of pixels shows many
//! triangles, they meet far fewer of them than a beam does.

use super::Direction;
use super::tile::{LANES, Tile};
use crate::scene::occluders::{Occluders, Packet};

/// What [`super::tile::trace`] finds, by directions of which each part fits a packet.
pub fn trace(
    tile: &Tile,
    occluders: &Occluders,
    directions: &[Vec<Direction>],
    words: usize,
) -> Vec<u32> {
    let mut bits = vec![0; words * LANES];
    for lane in 0..LANES {
        let (from, face) = (tile.origin(lane), tile.face(lane));
        for part in directions {
            let mut packet = Packet::default();
            // Below the polygon's own horizon nothing is looked for.
            let above = |d: &&Direction| face.dot(d.towards) > 0.0;
            part.iter().filter(above).for_each(|d| packet.push(from, d.towards, f32::INFINITY));
            let mut blocked = occluders.blocked_rays(&packet);
            for d in part {
                let mut free = 1;
                if above(&d) {
                    free = !blocked & 1;
                    blocked >>= 1;
                }
                bits[d.word * LANES + lane] |= free << d.bit;
            }
        }
    }
    bits
}
