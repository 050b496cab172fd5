//! What is known of a view before any light is chosen: plain data, one entry a pixel, rows from the
//! top. `n = width · height` below.

use crate::{Error, Result};

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
    Background = 0,
    /// Inside an object.
    Surface = 1,
    /// An object pixel at a jump of depth.
    Edge = 2,
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
    /// Added to both variances, so that a cylinder's covariance matrix has an inverse.
    pub const RIDGE: f32 = 1e-4;

    /// The inverse of the normals' covariance matrix: `xx`, `xy`, `yy`; `None` on flat geometry.
    pub fn normal_precision(&self) -> Option<[f32; 3]> {
        let [xx, xy, yy] = self.normal_covariance;
        if xx + yy < Self::RIDGE {
            return None;
        }
        let (xx, yy) = (xx + Self::RIDGE, yy + Self::RIDGE);
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

    /// Sets the target picture, for the evaluators that are made of these maps: its encoded
    /// luminance 0..=1, `n`, negative where it tells nothing.
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of pixels, a value that is not a number or above 1, and a
    /// target that tells no object pixel.
    pub fn set_target(&mut self, luminance: Vec<f32>) -> Result<()> {
        let [width, height] = [self.surface.width, self.surface.height];
        if luminance.len() != self.types.len() {
            return Err(Error::Argument(format!(
                "a target picture of {} pixels for a view of {width}x{height}",
                luminance.len()
            )));
        }
        if let Some(at) = luminance.iter().position(|t| t.is_nan() || *t > 1.0) {
            return Err(Error::Argument(format!(
                "the target picture has the luminance {} at pixel {at}: it must be 0 to 1, or negative \
                 where the picture tells nothing",
                luminance[at]
            )));
        }
        let before = std::mem::replace(&mut self.target, luminance);
        if self.told() == 0 {
            self.target = before;
            return Err(Error::Argument("the target picture tells no pixel of the object".into()));
        }
        Ok(())
    }

    /// What terms read.
    pub fn statistics(&self) -> ViewStatistics {
        let &Self { counts, normal_detail, shape, .. } = self;
        ViewStatistics { counts, normal_detail, shape }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_fits_the_view_and_tells_something() {
        let types = vec![PixelType::Background, PixelType::Surface, PixelType::Edge];
        let surface = Surface { width: 3, height: 1, ..Surface::default() };
        let mut maps = Maps { surface, types, ..Maps::default() };
        maps.set_target(vec![0.5, -1.0, 1.0]).unwrap();
        assert_eq!(maps.told(), 1);
        for (wrong, said) in [
            (vec![0.5; 2], "2 pixels for a view of 3x1"),
            (vec![0.5, f32::NAN, 0.5], "NaN at pixel 1"),
            (vec![0.5, 0.5, 1.5], "1.5 at pixel 2"),
            (vec![0.5, -1.0, -1.0], "no pixel of the object"),
        ] {
            let fault = maps.set_target(wrong).unwrap_err();
            assert!(fault.is_input() && fault.to_string().contains(said), "{fault}");
            assert_eq!(maps.target, [0.5, -1.0, 1.0]);
        }
    }
}
