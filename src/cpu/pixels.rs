//! The object's pixels in a list, without the background.

use super::neighbourhood;
use crate::objective::maps::PixelType;

/// A pixel of the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pixel {
    /// Its place in the picture, `y·width + x`.
    pub place: u32,
    /// SURFACE or EDGE.
    pub kind: PixelType,
    /// Places in the list of the nine pixels around it, row after row; its own where a neighbour is
    /// outside the object or the picture.
    pub neighbours: [u32; 9],
}

/// The object pixels of a picture of `width`·`height` pixels, row after row from the top.
pub fn pixels(types: &[PixelType], width: u32, height: u32) -> Vec<Pixel> {
    let object = |&at: &usize| types[at] != PixelType::Background;
    let places: Vec<usize> = (0..types.len()).filter(object).collect();
    let number = |at: usize| places.partition_point(|&place| place < at) as u32;
    let pixel = |&at: &usize| Pixel {
        place: at as u32,
        kind: types[at],
        neighbours: neighbourhood::within_object(types, width, height, at).map(number),
    };
    places.iter().map(pixel).collect()
}
