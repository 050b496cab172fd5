//! Small tiling textures, and PNG files with stored (uncompressed) data, so that their bytes
//! depend on no encoder.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::field::smoothstep;

const TURN: f64 = 2.0 * std::f64::consts::PI;

/// A square RGB picture as a PNG file; `colour` of `(u, v) ∈ [0, 1)²`, components in `[0, 1]`.
fn png(size: u32, colour: impl Fn(DVec2) -> DVec3) -> Vec<u8> {
    let mut rows = Vec::new();
    for y in 0..size {
        rows.push(0); // no row filter
        for x in 0..size {
            let uv = (dvec2(f64::from(x), f64::from(y)) + 0.5) / f64::from(size);
            let rgb = (colour(uv).clamp(DVec3::ZERO, DVec3::ONE) * 255.0 + 0.5).as_uvec3();
            rows.extend(rgb.to_array().map(|component| component as u8));
        }
    }
    let mut header = [size.to_be_bytes(), size.to_be_bytes()].concat();
    header.extend([8, 2, 0, 0, 0]); // 8 bits, RGB
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in [(b"IHDR", header), (b"IDAT", stored(&rows)), (b"IEND", Vec::new())] {
        file.extend((data.len() as u32).to_be_bytes());
        let checked = [kind.as_slice(), &data].concat();
        file.extend(&checked);
        file.extend(crc32(&checked).to_be_bytes());
    }
    file
}

/// A zlib stream (RFC 1950) of stored deflate blocks.
fn stored(data: &[u8]) -> Vec<u8> {
    let mut stream = vec![0x78, 0x01];
    let mut blocks = data.chunks(usize::from(u16::MAX)).peekable();
    while let Some(block) = blocks.next() {
        let length = block.len() as u16;
        stream.push(u8::from(blocks.peek().is_none()));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in data {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}

fn crc32(data: &[u8]) -> u32 {
    !data.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xEDB8_8320 * (c & 1)))
    })
}

/// A pseudo-random number in `[0, 1)` for a lattice point.
fn random(x: i64, y: i64, seed: u32) -> f64 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77);
    h ^= seed.wrapping_mul(0xC2B2_AE3D);
    for _ in 0..2 {
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    }
    f64::from(h ^ (h >> 15)) / 4_294_967_296.0
}

/// Value noise in `[0, 1]` with `cells` periods across the tile.
fn noise(uv: DVec2, cells: [i64; 2], seed: u32) -> f64 {
    let p = uv * dvec2(cells[0] as f64, cells[1] as f64);
    let (x, y) = (libm::floor(p.x), libm::floor(p.y));
    let (s, t) = (smoothstep(0.0, 1.0, p.x - x), smoothstep(0.0, 1.0, p.y - y));
    let at = |dx: i64, dy: i64| {
        random((x as i64 + dx).rem_euclid(cells[0]), (y as i64 + dy).rem_euclid(cells[1]), seed)
    };
    let below = at(0, 0) + (at(1, 0) - at(0, 0)) * s;
    let above = at(0, 1) + (at(1, 1) - at(0, 1)) * s;
    below + (above - below) * t
}

/// Oak boards along u, sRGB.
pub fn wood() -> Vec<u8> {
    const BOARDS: f64 = 4.0;
    png(256, |uv| {
        let board = libm::floor(uv.y * BOARDS);
        let across = uv.y * BOARDS - board;
        let seed = 10 + board as u32;
        let figure = noise(uv, [3, 12], seed) * 2.2 + noise(uv, [6, 32], seed) * 0.6;
        let rings = 0.5 + 0.5 * libm::sin(TURN * (across * 4.0 + figure));
        let grain = noise(uv, [12, 128], 3) * 0.6 + noise(uv, [40, 250], 4) * 0.4;
        let gap = smoothstep(0.0, 0.02, across) * (1.0 - smoothstep(0.98, 1.0, across));
        let tone = 0.82 + 0.18 * random(board as i64, 7, 5);
        let light = tone * (0.74 + 0.16 * rings + 0.16 * grain) * (0.45 + 0.55 * gap);
        dvec3(0.74, 0.53, 0.34) * light
    })
}

/// Checked linen, sRGB.
pub fn linen() -> Vec<u8> {
    png(128, |uv| {
        let stripe = |x: f64| {
            let x = (x * 2.0).fract();
            0.85 * (smoothstep(0.08, 0.1, x) - smoothstep(0.5, 0.52, x))
                + 0.6 * (smoothstep(0.7, 0.72, x) - smoothstep(0.78, 0.8, x))
        };
        let dye = 0.5 * (stripe(uv.x) + stripe(uv.y));
        let thread = libm::sin(TURN * 32.0 * uv.x) * libm::sin(TURN * 32.0 * uv.y);
        let slub = noise(uv, [4, 64], 1) + noise(uv, [64, 4], 2) - 1.0;
        let cloth = dvec3(0.93, 0.90, 0.83).lerp(dvec3(0.60, 0.13, 0.12), dye);
        cloth * (0.95 + 0.05 * thread + 0.05 * slub)
    })
}

/// Overlapping hammer marks: a tangent-space normal map.
pub fn hammered() -> Vec<u8> {
    png(128, |uv| {
        const STEP: f64 = 1.0 / 512.0;
        let slope =
            |axis: DVec2| (dents(uv + axis * STEP) - dents(uv - axis * STEP)) / (2.0 * STEP);
        // Rows run downwards, the bitangent upwards.
        dvec3(-slope(DVec2::X), slope(DVec2::Y), 1.0).normalize() * 0.5 + 0.5
    })
}

/// Height of a sheet under round hammer marks: each point belongs to the nearest mark's bowl.
fn dents(uv: DVec2) -> f64 {
    const CELLS: i64 = 7;
    let p = uv * CELLS as f64;
    let (x, y) = (libm::floor(p.x) as i64, libm::floor(p.y) as i64);
    let mut nearest = f64::INFINITY;
    for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
        let (i, j) = ((x + dx).rem_euclid(CELLS), (y + dy).rem_euclid(CELLS));
        let jitter = dvec2(random(i, j, 21), random(i, j, 22)) * 0.7 + 0.15;
        let mark = dvec2((x + dx) as f64, (y + dy) as f64) + jitter;
        nearest = nearest.min((p - mark).length_squared());
    }
    0.055 * nearest
}
