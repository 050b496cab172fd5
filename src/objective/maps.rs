//! What is known of a view before any light is chosen: plain data, one entry a pixel, rows from the
//! top. `n = width · height` below.

use super::shadows::Shadows;
use crate::constants::{BACKGROUND, EDGE, NORMAL_RIDGE, SURFACE};
use crate::lighting::shading::{Reflectance, Shading};
use crate::{Error, Result};
use glam::Vec3;

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
    /// Unit normal of the polygon in the light frame, turned to the viewer, `n`.
    pub face: Vec<[f32; 3]>,
    /// Linear base colour, `n`.
    pub base_color: Vec<[f32; 3]>,
    /// Metallic factor, `n`.
    pub metallic: Vec<f32>,
    /// Perceptual roughness, `n`.
    pub roughness: Vec<f32>,
    /// Linear emitted radiance, `n`.
    pub emissive: Vec<[f32; 3]>,
}

impl Surface {
    /// How pixel `at` reflects.
    pub fn reflectance(&self, shading: &Shading, at: usize) -> Reflectance {
        shading.reflectance(
            self.base_color[at].into(),
            self.metallic[at],
            self.roughness[at],
            self.emissive[at].into(),
        )
    }

    /// The first map with a pixel whose value is not finite, and that pixel; all have an entry a pixel.
    fn not_finite(&self) -> Option<(&'static str, usize)> {
        let numbers =
            [("depth", &self.depth), ("metallic", &self.metallic), ("roughness", &self.roughness)];
        let vectors = [
            ("position", &self.position),
            ("normal", &self.normal),
            ("face", &self.face),
            ("base_color", &self.base_color),
            ("emissive", &self.emissive),
        ];
        let numbers = numbers.into_iter().filter_map(|(name, map)| {
            Some((name, map.iter().position(|value| !value.is_finite())?))
        });
        let vectors = vectors.into_iter().filter_map(|(name, map)| {
            Some((name, map.iter().position(|value| !Vec3::from(*value).is_finite())?))
        });
        numbers.chain(vectors).next()
    }
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
    /// Of a view's pixel types.
    pub fn of(types: &[PixelType]) -> Self {
        let count = |kind| types.iter().filter(|&&t| t == kind).count() as u32;
        Self { surface: count(PixelType::Surface), edge: count(PixelType::Edge) }
    }

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
    /// The shadow table; without it lights cast no shadows.
    pub shadows: Option<Shadows>,
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

    /// How pixel `at` reflects; where there are shadows, ambient light is occluded.
    pub fn reflectance(&self, shading: &Shading, at: usize) -> Reflectance {
        let looks = self.surface.reflectance(shading, at);
        let number = |shadows: &Shadows| Some(shadows.openness()[shadows.number(at)?]);
        match self.shadows.as_ref().and_then(number) {
            Some(open) => {
                let ambient = Vec3::from(self.surface.base_color[at]) * (shading.ambient * open);
                Reflectance { unlit: ambient + Vec3::from(self.surface.emissive[at]), ..looks }
            }
            None => looks,
        }
    }

    /// What terms read.
    pub fn statistics(&self) -> ViewStatistics {
        let &Self { counts, normal_detail, shape, .. } = self;
        ViewStatistics { counts, normal_detail, shape }
    }
}

impl Maps {
    /// Whether the maps are finite and fit each other: every one has `n` entries, the types tell the background as the
    /// codes do, the counts are those of the types, and the visible codes ascend. Evaluators that take
    /// maps ask for it. The values of the numbers are not looked at.
    ///
    /// # Errors
    /// [`Error::Argument`] with what does not fit.
    pub fn check(&self) -> Result<()> {
        let fault = |what: String| Err(Error::Argument(format!("maps of a view: {what}")));
        let (width, height) = (self.surface.width, self.surface.height);
        let n = u64::from(width) * u64::from(height);
        if n > u32::MAX.into() {
            return fault(format!("{width}x{height} pixels are more than can be counted"));
        }
        if !self.target.is_empty() && self.target.len() as u64 != n {
            return fault(format!("the target has {} entries for {n} pixels", self.target.len()));
        }
        if let Some((name, has)) = self.lengths().into_iter().find(|&(_, has)| has as u64 != n) {
            return fault(format!("{name} has {has} entries for {width}x{height} pixels"));
        }
        let background = |kind| kind == PixelType::Background;
        let mut pixels = self.types.iter().zip(&self.surface.code);
        if let Some(at) = pixels.position(|(&kind, &code)| background(kind) != (code == 0)) {
            let (kind, code) = (self.types[at], self.surface.code[at]);
            return fault(format!("pixel {at} is {kind:?} with the colour code {code}"));
        }
        if let Some((name, at)) = self.surface.not_finite() {
            return fault(format!("{name} of pixel {at} is not finite"));
        }
        let counts = PixelCounts::of(&self.types);
        if counts != self.counts {
            return fault(format!("the types make {counts:?}, not {:?}", self.counts));
        }
        if !self.visible.is_sorted_by(|a, b| a < b) || self.visible.first() == Some(&0) {
            return fault("the visible colour codes do not ascend from 1 on".into());
        }
        Ok(())
    }

    /// Every map with an entry a pixel, and how many it has.
    fn lengths(&self) -> [(&'static str, usize); 13] {
        let Surface {
            code, depth, position, normal, face, base_color, metallic, roughness, ..
        } = &self.surface;
        [
            ("code", code.len()),
            ("depth", depth.len()),
            ("position", position.len()),
            ("normal", normal.len()),
            ("face", face.len()),
            ("base_color", base_color.len()),
            ("metallic", metallic.len()),
            ("roughness", roughness.len()),
            ("emissive", self.surface.emissive.len()),
            ("sobel", self.sobel.len()),
            ("laplace", self.laplace.len()),
            ("types", self.types.len()),
            ("normal_gradient", self.normal_gradient.len()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> Maps {
        let (scalar, vector) = (vec![0.5; 6], vec![[0.5; 3]; 6]);
        let surface = Surface {
            width: 3,
            height: 2,
            code: vec![0, 7, 7, 9, 9, 0],
            depth: scalar.clone(),
            position: vector.clone(),
            normal: vector.clone(),
            face: vector.clone(),
            base_color: vector.clone(),
            metallic: scalar.clone(),
            roughness: scalar.clone(),
            emissive: vector,
        };
        let types = [0, 1, 1, 1, 2, 0].map(|kind| match kind {
            0 => PixelType::Background,
            1 => PixelType::Surface,
            _ => PixelType::Edge,
        });
        Maps {
            surface,
            sobel: scalar.clone(),
            laplace: scalar.clone(),
            types: types.to_vec(),
            normal_gradient: scalar,
            shape: Shape::default(),
            target: Vec::new(),
            counts: PixelCounts { surface: 3, edge: 1 },
            visible: vec![7, 9],
            normal_detail: 0.1,
            shadows: None,
        }
    }

    #[test]
    fn maps_that_do_not_fit_each_other_are_refused() {
        maps().check().expect("maps that fit");
        Maps::default().check().expect("maps of nothing");
        type Fault = fn(&mut Maps);
        let faults: [(&str, Fault); 18] = [
            ("normal_gradient has 7", |m| m.normal_gradient.push(0.0)),
            ("target has 1", |m| m.target.push(0.0)),
            ("code has 5", |m| m.surface.code.truncate(5)),
            ("depth has 5", |m| m.surface.depth.truncate(5)),
            ("position has 5", |m| m.surface.position.truncate(5)),
            ("normal has 7", |m| m.surface.normal.push([0.0; 3])),
            ("base_color has 5", |m| m.surface.base_color.truncate(5)),
            ("metallic has 5", |m| m.surface.metallic.truncate(5)),
            ("roughness has 5", |m| m.surface.roughness.truncate(5)),
            ("emissive has 5", |m| m.surface.emissive.truncate(5)),
            ("sobel has 0", |m| m.sobel.clear()),
            ("laplace has 5", |m| m.laplace.truncate(5)),
            ("types has 5", |m| m.types.truncate(5)),
            ("3x4294967295 pixels", |m| m.surface.height = u32::MAX),
            ("pixel 1 is Background", |m| m.types[1] = PixelType::Background),
            ("surface: 3, edge: 1", |m| m.counts.surface = u32::MAX),
            ("ascend", |m| m.visible = vec![9, 7]),
            ("ascend", |m| m.visible = vec![0, 7]),
        ];
        for (expected, break_it) in faults {
            let mut broken = maps();
            break_it(&mut broken);
            let error = broken.check().expect_err(expected);
            assert!(error.is_input() && error.to_string().contains(expected), "{error}");
        }
    }

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
