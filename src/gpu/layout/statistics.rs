//! What is measured: of a view, of parts of a picture, and of an individual.

use crate::objective::maps::{self, Maps, PixelCounts, Shape};
use crate::objective::{HISTOGRAM_BINS, Irradiance, Statistics};
use bytemuck::{Pod, Zeroable};

/// Storage block `ViewStatistics`: the view in a few numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct ViewStatistics {
    /// SURFACE pixels.
    pub surface: u32,
    /// EDGE pixels.
    pub edge: u32,
    /// `G_n`.
    pub normal_detail: f32,
    /// The background's depth: the largest object depth + 1, scene radii.
    pub background_depth: f32,
    /// [`Shape::normal_mean`].
    pub normal_mean: [f32; 2],
    /// [`Shape::normal_covariance`].
    pub normal_xx: f32,
    /// See `normal_xx`.
    pub normal_xy: f32,
    /// See `normal_xx`.
    pub normal_yy: f32,
    /// [`Shape::detail_weight`].
    pub detail_weight: f32,
    /// [`Shape::base_luminance`].
    pub base_luminance: f32,
    /// Pixels that the target picture tells.
    pub target: u32,
}

impl From<&Maps> for ViewStatistics {
    fn from(maps: &Maps) -> Self {
        let [normal_xx, normal_xy, normal_yy] = maps.shape.normal_covariance;
        Self {
            surface: maps.counts.surface,
            edge: maps.counts.edge,
            normal_detail: maps.normal_detail,
            background_depth: 0.0,
            normal_mean: maps.shape.normal_mean,
            normal_xx,
            normal_xy,
            normal_yy,
            detail_weight: maps.shape.detail_weight,
            base_luminance: maps.shape.base_luminance,
            target: maps.told() as u32,
        }
    }
}

impl From<&ViewStatistics> for maps::ViewStatistics {
    fn from(view: &ViewStatistics) -> Self {
        Self {
            counts: PixelCounts { surface: view.surface, edge: view.edge },
            normal_detail: view.normal_detail,
            shape: Shape {
                normal_mean: view.normal_mean,
                normal_covariance: [view.normal_xx, view.normal_xy, view.normal_yy],
                detail_weight: view.detail_weight,
                base_luminance: view.base_luminance,
            },
        }
    }
}

impl ViewStatistics {
    /// Object pixels.
    pub fn objects(&self) -> u32 {
        self.surface + self.edge
    }
}

/// Element of the storage block `Partials`: a strip of the surface
/// ([`Shape`] and [`Maps::normal_detail`]).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct ShapePart {
    /// Sum over SURFACE of `|∇n|`.
    pub gradient: f32,
    /// Sum over SURFACE of the weight of the detail.
    pub weight: f32,
    /// Sum over the object of `n_x`.
    pub x: f32,
    /// Sum of `n_y`.
    pub y: f32,
    /// Sum of `n_x²`.
    pub xx: f32,
    /// Sum of `n_x·n_y`.
    pub xy: f32,
    /// Sum of `n_y²`.
    pub yy: f32,
    /// Sum of the base colour's luminance.
    pub base: f32,
}

/// Element of the storage block `MomentParts`: a column of a strip of a picture.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MomentPart {
    /// Object pixels.
    pub count: u32,
    /// Their mean.
    pub mean: f32,
    /// Sum of their squared distances from the mean.
    pub deviation: f32,
}

/// Element of the storage block `GradientParts`: a column of a strip of a picture.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct GradientPart {
    /// Sum over SURFACE of `|∇I|`.
    pub surface: f32,
    /// Sum over EDGE of `min(1, |∇I| / edge_contrast)`.
    pub edge: f32,
}

/// Element of the storage block `AppearanceParts`: what the lights do in a part of a picture, of the
/// encoded irradiance `e` and the normals.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct AppearancePart {
    /// Object pixels.
    pub count: u32,
    /// Mean of `e`.
    pub mean: f32,
    /// Sum of its squared distances from the mean.
    pub deviation: f32,
    /// Sum of `e` times the distance of `n_x` from its mean over the object.
    pub covariance_x: f32,
    /// As `covariance_x`, of `n_y`.
    pub covariance_y: f32,
    /// Pixels with a channel that is burnt out.
    pub burnt: u32,
    /// Pixels of too little irradiance.
    pub unlit: u32,
    /// Sum of the squared distances from the target picture.
    pub residual: f32,
    /// Sum over SURFACE of the weight of the detail that is seen.
    pub detail: f32,
    /// Pixels beside the background.
    pub outline_count: u32,
    /// Sum over them of `1 − min(1, |I − B| / 0.2)`.
    pub outline: f32,
}

/// Element of the storage block `Details`: [`Statistics`] of an individual.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Detail {
    /// [`Statistics::edge_contrast`].
    pub edge_contrast: f32,
    /// [`Statistics::mean`].
    pub mean: f32,
    /// [`Statistics::variance`].
    pub variance: f32,
    /// [`Statistics::gradient`].
    pub gradient: f32,
    /// [`Statistics::detail`].
    pub detail: f32,
    /// [`Statistics::burnt`].
    pub burnt: f32,
    /// [`Statistics::unlit`].
    pub unlit: f32,
    /// [`Statistics::residual`].
    pub residual: f32,
    /// [`Statistics::outline`].
    pub outline: f32,
    /// [`Irradiance::mean`].
    pub irradiance_mean: f32,
    /// [`Irradiance::variance`].
    pub irradiance_variance: f32,
    /// [`Irradiance::covariance`].
    pub covariance_x: f32,
    /// See `covariance_x`.
    pub covariance_y: f32,
    /// [`Statistics::key`].
    pub key_x: f32,
    /// See `key_x`.
    pub key_y: f32,
    /// See `key_x`.
    pub key_z: f32,
    /// [`Statistics::entropy`].
    pub entropy: f32,
    /// [`Statistics::histogram`].
    pub histogram: [u32; HISTOGRAM_BINS],
}

impl Detail {
    /// The statistics.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            edge_contrast: self.edge_contrast,
            mean: self.mean,
            variance: self.variance,
            gradient: self.gradient,
            histogram: self.histogram,
            detail: self.detail,
            burnt: self.burnt,
            unlit: self.unlit,
            irradiance: Irradiance {
                mean: self.irradiance_mean,
                variance: self.irradiance_variance,
                covariance: [self.covariance_x, self.covariance_y],
            },
            residual: self.residual,
            outline: self.outline,
            key: [self.key_x, self.key_y, self.key_z],
            entropy: self.entropy,
        }
    }
}
