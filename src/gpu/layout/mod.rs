//! What host and shaders share: the blocks' layouts and the numbers of the bindings. Other numbers are
//! in `src/constants.rs`. The other side is `shaders/include/`; a test compares the
//! two by reflection.

mod bindings;
mod statistics;

pub use crate::constants::{DOUBLE_SIDED, EMPTY_TILE, MATERIAL_TEXTURES, NORMAL_MAPPED};
use crate::constants::{MEAN_OF_SCENE, NO_BACKGROUND};
use crate::lighting::shading::Shading;
use crate::objective::terms::TERMS;
use crate::objective::{Example, HISTOGRAM_BINS, MAX_TERMS, MeanTarget, Objective};
use crate::scene::view::View;
pub use bindings::{binding, bindings, pixel_binding, pixel_bindings, written_images};
use bytemuck::{Pod, Zeroable};
pub use statistics::{AppearancePart, Detail, GradientPart, MomentPart, ShapePart, ViewStatistics};

/// Uniform block `Parameters`: the view and the settings.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Parameters {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Whether all view rays are parallel (0 or 1).
    pub orthographic: u32,
    /// [`Objective::mean_stops`].
    pub mean_stops: f32,
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
    /// [`Objective::mean_target`], or `MEAN_OF_SCENE`.
    pub mean_target: f32,
    /// [`Objective::background`], or `NO_BACKGROUND`.
    pub background: f32,
    /// [`Objective::spread_target`].
    pub spread_target: f32,
    /// Of klieg's own terms, in the order of [`TERMS`]; 0 beyond.
    pub weights: [f32; MAX_TERMS],
    /// [`Example::cumulative`], with the gradient in place of the last entry, which is 1; 0 without an example.
    pub example: [f32; HISTOGRAM_BINS],
}

impl Parameters {
    /// Of a view and its settings.
    pub fn new(view: &View, objective: &Objective, shading: &Shading) -> Self {
        Self {
            size: [view.width, view.height],
            orthographic: view.is_orthographic().into(),
            mean_stops: objective.mean_stops,
            eye: view.eye.to_array(),
            ambient: shading.ambient,
            dielectric: shading.dielectric,
            max_shininess: shading.max_shininess,
            edge_sobel: objective.edge_sobel,
            edge_laplace: objective.edge_laplace,
            edge_contrast: objective.edge_contrast,
            mean_target: mean_target(objective.mean_target),
            background: objective.background.unwrap_or(NO_BACKGROUND),
            spread_target: objective.spread_target,
            weights: weights(objective),
            example: objective.example.map_or([0.0; HISTOGRAM_BINS], example),
        }
    }
}

/// As devices read it.
fn mean_target(target: MeanTarget) -> f32 {
    match target {
        MeanTarget::Value(value) => value,
        MeanTarget::Scene => MEAN_OF_SCENE,
    }
}

fn example(example: Example) -> [f32; HISTOGRAM_BINS] {
    let mut entries = example.cumulative();
    entries[HISTOGRAM_BINS - 1] = example.gradient;
    entries
}

/// The weights of klieg's own terms, in the order of [`TERMS`]; 0 for what is not measured.
fn weights(objective: &Objective) -> [f32; MAX_TERMS] {
    let (mut weights, measured) = ([0.0; MAX_TERMS], objective.measured());
    for (weight, term) in weights.iter_mut().zip(TERMS) {
        *weight = measured.get(term.name).unwrap_or(0.0);
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
