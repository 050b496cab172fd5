//! What several formats have: colours of vertices, polygons, and strips.

use crate::math::color::srgb_decode;

/// Linear, 65535 = 1, of an sRGB colour and alpha of 0..1.
pub fn encoded([r, g, b, a]: [f32; 4]) -> [u16; 4] {
    let unit = |value: f32| if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
    let [r, g, b] = [r, g, b].map(|value| srgb_decode(unit(value)));
    [r, g, b, unit(a)].map(|value| (value * 65535.0).round() as u16)
}

/// Appends a polygon's triangles, all from its first corner, as glTF's fans have them.
pub fn triangulated(corners: &[u32], indices: &mut Vec<u32>) {
    if let Some((&first, rest)) = corners.split_first() {
        indices.extend(rest.windows(2).flat_map(|edge| [first, edge[0], edge[1]]));
    }
}

/// Appends the triangles of a strip, every second of which turns the other way round, as glTF's have them. Those without
/// extent, by which one strip goes on with another, are left out.
pub fn unstripped(corners: &[u32], indices: &mut Vec<u32>) {
    for (number, corners) in corners.windows(3).enumerate() {
        let (a, b, c) = (corners[0], corners[1], corners[2]);
        if a != b && b != c && c != a {
            indices.extend(if number % 2 == 0 { [a, b, c] } else { [b, a, c] });
        }
    }
}
