//! Maps as pictures that a person can read, and PNG files.

use crate::lighting::clusters::Clustering;
use crate::objective::maps::{Maps, PixelType};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ImageError, Rgb, RgbImage, RgbaImage};
use std::io::Cursor;

const BLACK: [u8; 3] = [0; 3];

/// The bytes of a PNG file.
///
/// # Errors
/// When the picture is too large for PNG.
pub fn png(picture: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    picture.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png)?;
    Ok(bytes)
}

/// The bytes of a PNG file of a final picture, with alpha where it is transparent anywhere.
///
/// # Errors
/// When the picture is too large for PNG.
pub fn final_png(picture: &RgbaImage) -> Result<Vec<u8>, ImageError> {
    if picture.pixels().all(|pixel| pixel.0[3] == u8::MAX) {
        let (width, height) = picture.dimensions();
        return png(&RgbImage::from_fn(width, height, |x, y| {
            let [r, g, b, _] = picture.get_pixel(x, y).0;
            Rgb([r, g, b])
        }));
    }
    let mut bytes = Vec::new();
    picture.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png)?;
    Ok(bytes)
}

/// The URI of a PNG, which needs no escaping in HTML and SVG.
pub fn uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// The picture as the URI of a PNG.
///
/// # Errors
/// When the picture is too large for PNG.
pub fn data_uri(picture: &RgbImage) -> Result<String, ImageError> {
    Ok(uri(&png(picture)?))
}

/// Colour code: every polygon in a colour of its own, the background black.
pub fn code(maps: &Maps) -> RgbImage {
    draw(maps, |at| scatter(maps.surface.code[at]))
}

/// Depth: the nearest pixel white, the farthest dark grey, the background black.
pub fn depth(maps: &Maps) -> RgbImage {
    let surface = &maps.surface;
    let objects = || surface.depth.iter().zip(&surface.code).filter(|(_, code)| **code != 0);
    let (near, far) =
        objects().fold((f32::INFINITY, f32::NEG_INFINITY), |(n, f), (&d, _)| (n.min(d), f.max(d)));
    let range = (far - near).max(f32::MIN_POSITIVE);
    draw(maps, |at| [grey(1.0 - 0.8 * (surface.depth[at] - near) / range); 3])
}

/// Edges: EDGE pixels white; elsewhere on objects the Sobel length of the depth in grey, up to the
/// threshold `edge_sobel`.
pub fn edges(maps: &Maps, edge_sobel: f32) -> RgbImage {
    draw(maps, |at| match maps.types[at] {
        PixelType::Edge => [255; 3],
        _ => [grey(0.12 + 0.38 * (maps.sobel[at] / edge_sobel).min(1.0)); 3],
    })
}

/// Pixel types: EDGE orange, SURFACE blue, BACKGROUND black.
pub fn types(maps: &Maps) -> RgbImage {
    draw(maps, |at| match maps.types[at] {
        PixelType::Edge => [255, 176, 32],
        _ => [44, 92, 148],
    })
}

/// Unit normals of the light frame, `(n + 1) / 2` in red, green and blue.
pub fn normals(maps: &Maps) -> RgbImage {
    draw(maps, |at| maps.surface.normal[at].map(|x| grey(0.5 * x + 0.5)))
}

/// The cluster of each pixel's polygon in the colours of [`CLUSTERS`].
pub fn clusters(maps: &Maps, clustering: &Clustering) -> RgbImage {
    draw(maps, |at| {
        let place = maps.visible.binary_search(&maps.surface.code[at]);
        let label = place.ok().and_then(|place| clustering.labels.get(place));
        label.map_or(BLACK, |&label| CLUSTERS[label % CLUSTERS.len()])
    })
}

/// Colours of clusters, the largest first: as many as a rig can have lights.
pub const CLUSTERS: [[u8; 3]; 16] = [
    [255, 183, 77],
    [79, 134, 247],
    [102, 187, 106],
    [236, 88, 140],
    [77, 208, 225],
    [171, 106, 222],
    [255, 241, 118],
    [239, 83, 80],
    [158, 157, 36],
    [188, 170, 164],
    [0, 137, 123],
    [244, 180, 208],
    [121, 85, 72],
    [197, 225, 165],
    [92, 107, 192],
    [207, 216, 220],
];

/// A picture with `color` at object pixels and black elsewhere.
fn draw(maps: &Maps, color: impl Fn(usize) -> [u8; 3]) -> RgbImage {
    let (width, height) = (maps.surface.width, maps.surface.height);
    RgbImage::from_fn(width, height, |x, y| {
        let at = y as usize * width as usize + x as usize;
        Rgb(if maps.types[at] == PixelType::Background { BLACK } else { color(at) })
    })
}

fn grey(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// A bright colour that neighbouring numbers do not share.
fn scatter(code: u32) -> [u8; 3] {
    // Murmur3's finaliser (Appleby 2011): every bit of the number moves every bit of the colour.
    let mut h = code;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 16;
    let [r, g, b, _] = h.to_le_bytes();
    [r, g, b].map(|channel| 64 + (u16::from(channel) * 191 / 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::maps::Surface;

    #[test]
    fn the_background_is_black_and_objects_are_not() {
        let surface = Surface {
            width: 2,
            height: 2,
            code: vec![0, 1, 2, 2],
            depth: vec![3.0, 1.0, 2.0, 2.0],
            normal: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            ..Surface::default()
        };
        let types =
            vec![PixelType::Background, PixelType::Edge, PixelType::Surface, PixelType::Surface];
        let maps =
            Maps { surface, types, sobel: vec![0.01; 4], visible: vec![1, 2], ..Maps::default() };
        let clustering = Clustering { clusters: Vec::new(), labels: vec![0, 1] };
        let pictures = [
            code(&maps),
            depth(&maps),
            edges(&maps, 0.02),
            self::types(&maps),
            normals(&maps),
            clusters(&maps, &clustering),
        ];
        for (i, picture) in pictures.iter().enumerate() {
            assert_eq!(picture.get_pixel(0, 0).0, BLACK);
            assert!(picture.pixels().skip(1).all(|p| p.0 != BLACK), "{i}");
            assert!(picture.get_pixel(1, 0) != picture.get_pixel(0, 1), "{i}");
            let read = image::load_from_memory(&png(picture).unwrap()).unwrap();
            assert_eq!(&read.to_rgb8(), picture);
        }
        assert_eq!(pictures[1].get_pixel(1, 0).0, [255; 3]);
        assert_eq!(pictures[4].get_pixel(1, 0).0, [128, 128, 255]);
    }

    #[test]
    fn neighbouring_codes_differ_clearly() {
        for number in 1..2000 {
            let (a, b) = (scatter(number), scatter(number + 1));
            let difference: u32 = a.iter().zip(b).map(|(&a, b)| u32::from(a.abs_diff(b))).sum();
            assert!(difference > 5, "{number}");
        }
    }
}
