//! The numbers of the bindings, and what stands there.

use crate::gpu::vulkan::pipeline::Binding;
use ash::vk;

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
    /// Sampled array, RGBA32_SFLOAT: linear base colour; linear emitted radiance.
    pub const MATERIAL: u32 = 4;
    /// Sampled, R32_UINT: pixel types.
    pub const TYPES: u32 = 5;
    /// Sampled: record 0, position and shininess.
    pub const SURFACE_0: u32 = 6;
    /// Sampled: record 1, normal and diffuse reflectance.
    pub const SURFACE_1: u32 = 7;
    /// Sampled: record 2, specular reflectance, unlit luminance and pixel type.
    pub const SURFACE_2: u32 = 8;
    /// Sampled array: the records for shading in colour; diffuse reflectance and lobe, specular reflectance
    /// and `|∇n|`, unlit radiance and target picture, with shadows the polygon's normal and the ambient
    /// occlusion.
    pub const COLOR_SURFACE: u32 = 9;
    /// Sampled array, R32_UINT: the shadow table, a layer for each word of a pixel.
    pub const SHADOW_TABLE: u32 = 10;
    /// Storage block: `Node[]` of the occluders.
    pub const NODES: u32 = 11;
    /// Storage block: `Triangle[]` of the occluders.
    pub const TRIANGLES: u32 = 12;
    /// Storage block: opacity of the occluders, words.
    pub const OPACITY: u32 = 13;
    /// Uniform block: the occluders' frame from the light frame, a matrix.
    pub const OCCLUDERS_FRAME: u32 = 14;
    /// Storage block `ViewStatistics`.
    pub const VIEW_STATISTICS: u32 = 15;
    /// Sampled array, R32_SFLOAT: the population's pictures.
    pub const PICTURES: u32 = 16;
    /// Storage block: `LightRecord[N·L]`.
    pub const LIGHTS: u32 = 17;
    /// Storage block: partial histograms.
    pub const HISTOGRAM: u32 = 18;
    /// Storage block: partial moments.
    pub const MOMENTS: u32 = 19;
    /// Storage block: partial gradients.
    pub const GRADIENT: u32 = 20;
    /// Storage block: partial appearances.
    pub const APPEARANCE: u32 = 21;
    /// Storage block: `F` of each individual.
    pub const SCORES: u32 = 22;
    /// Storage block: statistics of each individual.
    pub const DETAILS: u32 = 23;
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

/// Every binding of the view's descriptor set. No stage writes images of it: those that some stage writes are
/// in sets of that stage's own, as devices allow few storage images in a pipeline's layout.
pub fn bindings() -> Vec<Binding> {
    use vk::DescriptorType as Kind;
    use vk::ShaderStageFlags as Stage;
    let all = Stage::COMPUTE | Stage::FRAGMENT;
    let kind = |number| match number {
        binding::PARAMETERS | binding::OCCLUDERS_FRAME => (Kind::UNIFORM_BUFFER, all),
        binding::CODE..=binding::SHADOW_TABLE => (Kind::SAMPLED_IMAGE, all),
        binding::NODES..=binding::OPACITY => (Kind::STORAGE_BUFFER, all),
        binding::PICTURES => (Kind::SAMPLED_IMAGE, Stage::COMPUTE),
        binding::LIGHTS => (Kind::STORAGE_BUFFER, Stage::VERTEX | all),
        _ => (Kind::STORAGE_BUFFER, Stage::COMPUTE),
    };
    (0..=binding::DETAILS)
        .map(|number| {
            let (kind, stages) = kind(number);
            (number, kind, stages)
        })
        .collect()
}

/// Bindings from `first` on for so many images that compute stages write.
pub fn written_images(first: u32, count: u32) -> impl Iterator<Item = Binding> {
    let kind = vk::DescriptorType::STORAGE_IMAGE;
    (first..first + count).map(move |number| (number, kind, vk::ShaderStageFlags::COMPUTE))
}
