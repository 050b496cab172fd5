//! What host and shaders share: the blocks' layouts and the numbers of the bindings. Other numbers are
//! in `src/constants.rs`. The other side is `shaders/include/`; a test compares the
//! two by reflection.

use super::vulkan::pipeline::Binding;
pub use crate::constants::{DOUBLE_SIDED, EMPTY_TILE, MATERIAL_TEXTURES, NORMAL_MAPPED};
use crate::lighting::shading::Shading;
use crate::objective::maps::{self, Maps, PixelCounts, Shape};
use crate::objective::terms::TERMS;
use crate::objective::{HISTOGRAM_BINS, Irradiance, MAX_TERMS, Objective, Statistics};
use crate::scene::view::View;
use ash::vk;
use bytemuck::{Pod, Zeroable};

/// Uniform block `Parameters`: the view and the settings.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Parameters {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Whether all view rays are parallel (0 or 1).
    pub orthographic: u32,
    /// To a multiple of 16 bytes.
    pub padding: u32,
    /// The viewer's position in the light frame, scene radii.
    pub eye: [f32; 3],
    /// [`Shading::ambient`].
    pub ambient: f32,
    /// [`Shading::dielectric`].
    pub dielectric: f32,
    /// [`Shading::max_shininess`].
    pub max_shininess: f32,
    /// [`Objective::edge_sobel`].
    pub edge_sobel: f32,
    /// [`Objective::edge_laplace`].
    pub edge_laplace: f32,
    /// [`Objective::edge_contrast`].
    pub edge_contrast: f32,
    /// [`Objective::mean_target`].
    pub mean_target: f32,
    /// To a multiple of 16 bytes.
    pub padding_middle: [f32; 2],
    /// Of klieg's own terms, in the order of [`TERMS`]; 0 beyond.
    pub weights: [f32; MAX_TERMS],
}

impl Parameters {
    /// Of a view and its settings.
    pub fn new(view: &View, objective: &Objective, shading: &Shading) -> Self {
        Self {
            size: [view.width, view.height],
            orthographic: view.is_orthographic().into(),
            padding: 0,
            eye: view.eye.to_array(),
            ambient: shading.ambient,
            dielectric: shading.dielectric,
            max_shininess: shading.max_shininess,
            edge_sobel: objective.edge_sobel,
            edge_laplace: objective.edge_laplace,
            edge_contrast: objective.edge_contrast,
            mean_target: objective.mean_target,
            padding_middle: [0.0; 2],
            weights: weights(objective),
        }
    }
}

/// The weights of klieg's own terms, in the order of [`TERMS`].
fn weights(objective: &Objective) -> [f32; MAX_TERMS] {
    let mut weights = [0.0; MAX_TERMS];
    for (weight, term) in weights.iter_mut().zip(TERMS) {
        *weight = objective.weights.get(term.name).unwrap_or(0.0);
    }
    weights
}

/// Push constants of a view's stages: the part of a population that is measured at once.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Chunk {
    /// Its first individual.
    pub first: u32,
    /// Partial histograms of each picture.
    pub histogram_entries: u32,
    /// Partial moments and gradients of each picture.
    pub entries: u32,
    /// Block of individuals within the chunk.
    pub block: u32,
    /// The block's first light within the window of lights.
    pub light: u32,
    /// Lights of an individual; 0 where they are not known.
    pub lights: u32,
}

/// Element of the storage block `Tiles`: a tile of the picture with an object pixel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Tile {
    /// Of tiles.
    pub column: u32,
    /// Of tiles.
    pub row: u32,
    /// Place of an object pixel in the tile with its border, rows from the top; [`EMPTY_TILE`] in a
    /// tile without.
    pub origin: u32,
}

/// Uniform block `EngineSurface`: how the stage `surface` reads an engine's images.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct EngineSurface {
    /// Light frame from the engine's clip space, column by column.
    pub frame_from_clip: [[f32; 4]; 4],
    /// Light frame from the space of the normals: a rotation.
    pub frame_from_normals: [[f32; 4]; 4],
    /// The viewer in the light frame; then 1 where all view rays are parallel.
    pub eye: [f32; 4],
    /// Linear base colour and roughness where no image tells.
    pub base_color_roughness: [f32; 4],
    /// Metallic factor where no image tells.
    pub metallic: f32,
    /// Depth of the background.
    pub cleared_depth: f32,
    /// Which images there are, and how they are coded.
    pub flags: u32,
    /// Component of the roughness, and of the metallic factor times 4.
    pub channels: u32,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// To a multiple of 16 bytes.
    pub padding: [u32; 2],
}

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
            key: [self.key_x, self.key_y, self.key_z],
        }
    }
}

/// What the visibility draw needs of an instance (`shaders/include/visibility.glsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct InstanceRecord {
    /// Light frame from mesh space, column by column.
    pub frame_from_mesh: [[f32; 4]; 4],
    /// A positive multiple of the inverse transpose of its linear part.
    pub normal_from_mesh: [[f32; 4]; 3],
    /// Colour code of the first triangle.
    pub first_polygon: u32,
    /// Index into the materials.
    pub material: u32,
    /// 1 where the transform turns the winding round.
    pub mirrored: u32,
    /// To a multiple of 16 bytes.
    pub padding: u32,
}

/// A material's use of a texture: the rows of its transform, the coordinate set in `u[3]`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TextureUse {
    /// Gives `u'`.
    pub u: [f32; 4],
    /// Gives `v'`.
    pub v: [f32; 4],
}

/// What the visibility draw needs of a material (`shaders/include/visibility.glsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// Linear, with alpha.
    pub base_color: [f32; 4],
    /// Linear; then the scale of the normal texture's x and y.
    pub emissive_normal_scale: [f32; 4],
    /// Factor.
    pub metallic: f32,
    /// Factor.
    pub roughness: f32,
    /// Least alpha that is drawn.
    pub alpha_cutoff: f32,
    /// [`DOUBLE_SIDED`] and [`NORMAL_MAPPED`].
    pub flags: u32,
    /// Base colour, metallic-roughness, normal, emissive.
    pub textures: [TextureUse; MATERIAL_TEXTURES as usize],
}

/// Push constants of the draws of the scene (`shaders/include/visibility.glsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// Clip space from the light frame, column by column.
    pub clip_from_frame: [[f32; 4]; 4],
    /// The viewer; then 1 where all view rays are parallel.
    pub eye: [f32; 4],
    /// [`Shading`]: ambient, dielectric, largest shininess. From here on for populations alone.
    pub shading: [f32; 3],
    /// The chunk's first light.
    pub first_light: u32,
    /// First instance of a draw.
    pub first_instance: u32,
    /// Instances of a draw in each picture.
    pub instances_of_picture: u32,
}

/// Numbers of the bindings of the view's descriptor set, which all of its stages share.
pub mod binding {
    /// Uniform block `Parameters`.
    pub const PARAMETERS: u32 = 0;
    /// Sampled, R32_UINT: colour code.
    pub const CODE: u32 = 1;
    /// Sampled, RGBA32_SFLOAT: position in the light frame; roughness.
    pub const POSITION_ROUGHNESS: u32 = 2;
    /// Sampled, RGBA32_SFLOAT: unit normal; metallic factor.
    pub const NORMAL_METALLIC: u32 = 3;
    /// Sampled, RGBA32_SFLOAT: linear base colour.
    pub const BASE_COLOR: u32 = 4;
    /// Sampled, RGBA32_SFLOAT: linear emitted radiance.
    pub const EMISSIVE: u32 = 5;
    /// Storage, R32_SFLOAT: depth.
    pub const DEPTH: u32 = 6;
    /// Storage, R32_SFLOAT: length of the depth's Sobel pair.
    pub const SOBEL: u32 = 7;
    /// Storage, R32_SFLOAT: the depth's Laplacian.
    pub const LAPLACE: u32 = 8;
    /// Storage, R32_UINT: pixel types.
    pub const TYPES: u32 = 9;
    /// Storage, RGBA32_SFLOAT, write: record 0.
    pub const RECORD_0: u32 = 10;
    /// Storage, RGBA32_SFLOAT, write: record 1.
    pub const RECORD_1: u32 = 11;
    /// Storage, RGBA32_SFLOAT, write: record 2.
    pub const RECORD_2: u32 = 12;
    /// Sampled: record 0, position and shininess.
    pub const SURFACE_0: u32 = 13;
    /// Sampled: record 1, normal and diffuse reflectance.
    pub const SURFACE_1: u32 = 14;
    /// Sampled: record 2, specular reflectance, unlit luminance and pixel type.
    pub const SURFACE_2: u32 = 15;
    /// Storage block `ViewStatistics`.
    pub const VIEW_STATISTICS: u32 = 16;
    /// Sampled array, R32_SFLOAT: the population's pictures.
    pub const PICTURES: u32 = 17;
    /// Storage block: `LightRecord[N·L]`.
    pub const LIGHTS: u32 = 18;
    /// Storage block: partial histograms.
    pub const HISTOGRAM: u32 = 19;
    /// Storage block: partial moments.
    pub const MOMENTS: u32 = 20;
    /// Storage block: partial gradients.
    pub const GRADIENT: u32 = 21;
    /// Storage block: `F` of each individual.
    pub const SCORES: u32 = 22;
    /// Storage block: statistics of each individual.
    pub const DETAILS: u32 = 23;
    /// Storage block: partial appearances.
    pub const APPEARANCE: u32 = 24;
    /// Storage array, RGBA32_SFLOAT, write: the records for shading in colour.
    pub const COLOR_RECORDS: u32 = 25;
    /// Sampled array: the same; diffuse reflectance and lobe, specular reflectance and `|∇n|`, unlit
    /// radiance and target picture.
    pub const COLOR_SURFACE: u32 = 26;
}

/// Numbers of the bindings of set 1 of the stages that visit object pixels alone.
pub mod pixel_binding {
    /// Storage block: object pixels of each row.
    pub const ROW_COUNTS: u32 = 0;
    /// Storage block: the object pixels' places in the picture.
    pub const PLACES: u32 = 1;
    /// Storage texels: where each object pixel's neighbours are in the list.
    pub const TAPS_OUT: u32 = 2;
    /// Storage texels: position and shininess of each.
    pub const POSITIONS_OUT: u32 = 3;
    /// Storage texels: normal and diffuse reflectance of each.
    pub const NORMALS_OUT: u32 = 4;
    /// Storage block: specular reflectance and unlit luminance, a `vec2` for each.
    pub const LOOKS_OUT: u32 = 5;
    /// Storage texels: a chunk's brightnesses, a texel for each pixel of each block.
    pub const BRIGHTNESS_OUT: u32 = 6;
    /// What was written as [`TAPS_OUT`] and, in this order, the others.
    pub const TAPS: u32 = 7;
    /// As [`TAPS`].
    pub const POSITIONS: u32 = 8;
    /// As [`TAPS`].
    pub const NORMALS: u32 = 9;
    /// As [`TAPS`].
    pub const LOOKS: u32 = 10;
    /// As [`TAPS`].
    pub const BRIGHTNESS: u32 = 11;
    /// Uniform block with a dynamic offset: a block's lights.
    pub const WINDOW: u32 = 12;
}

/// Every binding of that set.
pub fn pixel_bindings() -> Vec<Binding> {
    use pixel_binding::{
        BRIGHTNESS, BRIGHTNESS_OUT, LOOKS_OUT, PLACES, ROW_COUNTS, TAPS, TAPS_OUT,
    };
    let kind = |number| match number {
        ROW_COUNTS | PLACES | LOOKS_OUT => vk::DescriptorType::STORAGE_BUFFER,
        TAPS_OUT..=BRIGHTNESS_OUT => vk::DescriptorType::STORAGE_TEXEL_BUFFER,
        TAPS..=BRIGHTNESS => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        _ => vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC,
    };
    let stages = vk::ShaderStageFlags::COMPUTE;
    (0..=pixel_binding::WINDOW).map(|number| (number, kind(number), stages)).collect()
}

/// Every binding of the view's descriptor set.
pub fn bindings() -> Vec<Binding> {
    use vk::DescriptorType as Kind;
    use vk::ShaderStageFlags as Stage;
    let all = Stage::COMPUTE | Stage::FRAGMENT;
    let kind = |number| match number {
        binding::PARAMETERS => (Kind::UNIFORM_BUFFER, all),
        binding::LIGHTS => (Kind::STORAGE_BUFFER, Stage::VERTEX | all),
        binding::COLOR_RECORDS => (Kind::STORAGE_IMAGE, Stage::COMPUTE),
        binding::COLOR_SURFACE => (Kind::SAMPLED_IMAGE, all),
        binding::DEPTH..=binding::RECORD_2 => (Kind::STORAGE_IMAGE, Stage::COMPUTE),
        binding::CODE..=binding::EMISSIVE => (Kind::SAMPLED_IMAGE, all),
        binding::SURFACE_0..=binding::SURFACE_2 => (Kind::SAMPLED_IMAGE, all),
        binding::PICTURES => (Kind::SAMPLED_IMAGE, Stage::COMPUTE),
        _ => (Kind::STORAGE_BUFFER, Stage::COMPUTE),
    };
    (0..=binding::COLOR_SURFACE)
        .map(|number| {
            let (kind, stages) = kind(number);
            (number, kind, stages)
        })
        .collect()
}
