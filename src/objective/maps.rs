//! What is known of a view before any light is chosen: plain data, one entry a pixel, rows from the
//! top. `n = width · height` below.

use crate::constants::{BACKGROUND, EDGE, SURFACE};

/// The visible surface: what the visibility stage draws. Background entries are 0, save `depth`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Colour code, `n`: the polygon's number, 0 for the background.
    pub code: Vec<u32>,
    /// Distance along the view axis, scene radii, `n`; background: the largest object depth + 1.
    pub depth: Vec<f32>,
    /// Position in the light frame, scene radii, `n`.
    pub position: Vec<[f32; 3]>,
    /// Unit shading normal in the light frame, turned to the viewer, `n`.
    pub normal: Vec<[f32; 3]>,
    /// Linear base colour, `n`.
    pub base_color: Vec<[f32; 3]>,
    /// Metallic factor, `n`.
    pub metallic: Vec<f32>,
    /// Perceptual roughness, `n`.
    pub roughness: Vec<f32>,
    /// Linear emitted radiance, `n`.
    pub emissive: Vec<[f32; 3]>,
}

/// What kind of place a pixel is. The numbers are those of the pixel-type map.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PixelType {
    /// Nothing is drawn there; takes no part in the terms.
    #[default]
    Background = BACKGROUND as u8,
    /// Inside an object.
    Surface = SURFACE as u8,
    /// An object pixel at a jump of depth.
    Edge = EDGE as u8,
}

/// Pixels of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PixelCounts {
    /// SURFACE pixels.
    pub surface: u32,
    /// EDGE pixels.
    pub edge: u32,
}

impl PixelCounts {
    /// Object pixels, the set `M`.
    pub fn object(&self) -> u32 {
        self.surface + self.edge
    }
}

/// The maps of a view.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Maps {
    /// The visible surface.
    pub surface: Surface,
    /// Length of the depth's Sobel pair, scene radii a pixel, `n`.
    pub sobel: Vec<f32>,
    /// Laplacian of the depth, scene radii, `n`.
    pub laplace: Vec<f32>,
    /// Pixel types, `n`.
    pub types: Vec<PixelType>,
    /// Pixels of each kind.
    pub counts: PixelCounts,
    /// Colour codes that occur, ascending.
    pub visible: Vec<u32>,
    /// `G_n`: mean over SURFACE of the Frobenius length of the Sobel pair on the unit normals, a tap
    /// outside the object or the picture taking the centre's value.
    pub normal_detail: f32,
}
