//! What is known of a view before any light is chosen: plain data, one entry a pixel, rows from the
//! top. `n = width · height` below.

use crate::constants::{BACKGROUND, EDGE, NORMAL_RIDGE, SURFACE};

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

/// The shape that a view shows, in a few numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shape {
    /// Means of the normals' components `n_x` and `n_y` over the object, light frame.
    pub normal_mean: [f32; 2],
    /// Their covariance matrix: `xx`, `xy`, `yy`.
    pub normal_covariance: [f32; 3],
    /// Sum over SURFACE of `w = min(|∇n|, 0.5)`.
    pub detail_weight: f32,
    /// Mean luminance of the base colour over the object, linear.
    pub base_luminance: f32,
}

impl Shape {
    /// The inverse of the normals' covariance matrix: `xx`, `xy`, `yy`; `None` on flat geometry.
    pub fn normal_precision(&self) -> Option<[f32; 3]> {
        let [xx, xy, yy] = self.normal_covariance;
        if xx + yy < NORMAL_RIDGE {
            return None;
        }
        let (xx, yy) = (xx + NORMAL_RIDGE, yy + NORMAL_RIDGE);
        let determinant = xx * yy - xy * xy;
        Some([yy / determinant, -xy / determinant, xx / determinant])
    }
}

/// What terms read of a view.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ViewStatistics {
    /// Pixels of each kind.
    pub counts: PixelCounts,
    /// `G_n`, see [`Maps::normal_detail`].
    pub normal_detail: f32,
    /// The shape.
    pub shape: Shape,
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
    /// `|∇n|`, `n`: Frobenius length of the Sobel pair on the unit normals at SURFACE pixels, 0 elsewhere; a
    /// tap outside the object or the picture takes the centre's value.
    pub normal_gradient: Vec<f32>,
    /// `G_n`: mean of [`Maps::normal_gradient`] over SURFACE.
    pub normal_detail: f32,
    /// The shape in a few numbers.
    pub shape: Shape,
    /// A target picture's encoded luminance, `n`, negative where it tells nothing; empty without a target.
    pub target: Vec<f32>,
}

impl Maps {
    /// Object pixels that the target picture tells.
    pub fn told(&self) -> usize {
        let pixels = std::iter::zip(&self.types, &self.target);
        pixels.filter(|&(&kind, &t)| kind != PixelType::Background && t >= 0.0).count()
    }

    /// What terms read.
    pub fn statistics(&self) -> ViewStatistics {
        let &Self { counts, normal_detail, shape, .. } = self;
        ViewStatistics { counts, normal_detail, shape }
    }
}
