//! Numbers that host and shaders both count on, each written once: `build/glsl.rs` makes `constants.glsl` of
//! this file. A value is a `u32`, an `f32` or an `[f32; 3]`.

constants! {
    /// Bins of the brightness histogram, as a power of two.
    HISTOGRAM_BIN_BITS: u32 = 5;
    /// Bins of the brightness histogram.
    HISTOGRAM_BINS: u32 = 1 << HISTOGRAM_BIN_BITS;

    /// Encoded value from which on a channel counts as burnt out.
    BURNT: f32 = 0.985;
    /// Diffuse irradiance below which a pixel counts as unlit; at 1 a white surface shows white.
    UNLIT: f32 = 0.05;
    /// Share of the normals' gradient that the picture's has to reach for a detail to be seen.
    DETAIL_SHARE: f32 = 0.35;
    /// Least gradient of the picture at which a detail is seen, encoded units a pixel.
    DETAIL_LEAST: f32 = 0.004;
    /// Gradient of the normals above which a detail weighs no more.
    DETAIL_MOST: f32 = 0.5;
    /// Added to both variances of the normals, so that a cylinder's covariance matrix has an inverse.
    NORMAL_RIDGE: f32 = 1e-4;

    /// Target of the mean brightness that a scene sets itself: share of the mean base luminance, linear.
    SCENE_MEAN_SHARE: f32 = 0.5;
    /// The same: its least, sRGB-encoded.
    SCENE_MEAN_LEAST: f32 = 0.25;
    /// The same: its most, sRGB-encoded.
    SCENE_MEAN_MOST: f32 = 0.72;
    /// Least mean brightness that is aimed at where stops move it, sRGB-encoded.
    MEAN_LEAST: f32 = 0.1;
    /// The same: the most.
    MEAN_MOST: f32 = 0.9;
    /// `mean_target` of a scene that sets the target itself.
    MEAN_OF_SCENE: f32 = -1.0;

    /// `F_grad`: mean gradient of the normals below which the geometry counts as flat and the term is 0.
    GRAD_FLAT: f32 = 1e-6;
    /// `F_range`: standard deviation of the brightness that is enough.
    RANGE_ENOUGH: f32 = 0.2;
    /// `F_spread`: largest standard deviation of values in 0..1.
    SPREAD_MOST: f32 = 0.5;
    /// `F_example`: mean distance of the percentiles that makes their part 1.
    EXAMPLE_RANGE: f32 = 0.25;
    /// `F_example`: share of the gradient's part.
    EXAMPLE_GRADIENT: f32 = 0.25;
    /// `F_burnt`: share of the object that may burn out.
    BURNT_TOLERATED: f32 = 0.005;
    /// `F_burnt`: share beyond it that makes the term 1.
    BURNT_RANGE: f32 = 0.1;
    /// `F_unlit`: share of the object that makes the term 1.
    UNLIT_RANGE: f32 = 0.25;
    /// `F_relief`: coefficient of determination that is enough.
    RELIEF_ENOUGH: f32 = 0.6;
    /// `F_relief`: variance of the irradiance below which there is no shading to speak of.
    RELIEF_LEAST: f32 = 1e-5;
    /// `F_direction`: unit vector 30° up and 35° to the right, light frame.
    DIRECTION_PREFERRED: [f32; 3] = [0.49673176, 0.5, 0.7094065];
    /// `F_direction`: angle within which the term is 0, radians (15°).
    DIRECTION_FREE: f32 = 0.2617994;
    /// `F_direction`: angle from which on the term is 1, radians (75°).
    DIRECTION_MOST: f32 = 1.3089969;
    /// `F_target`: root mean square distance that makes the term 0.625; that of black from white makes it 1.
    TARGET_RANGE: f32 = 0.25;
    /// `F_entropy`: gradient of the normals from which on a pixel counts no more, as a multiple of its mean.
    CURVATURE_MOST: f32 = 4.0;
    /// `F_entropy`: what such a pixel counts, a whole number. A tile of 32² of them fits 16 bits.
    CURVATURE_LEVELS: u32 = 63;
    /// `F_outline`: distance of the brightness from the background's that is enough, encoded units.
    OUTLINE_ENOUGH: f32 = 0.2;
    /// Luminance of a background that is not known.
    NO_BACKGROUND: f32 = -1.0;

    /// Pixel type: nothing is drawn there.
    BACKGROUND: u32 = 0;
    /// Pixel type: inside an object.
    SURFACE: u32 = 1;
    /// Pixel type: an object pixel at a jump of depth.
    EDGE: u32 = 2;
    /// Brightness of a target picture where it tells nothing.
    NO_TARGET: f32 = -1.0;
    /// Least perceptual roughness of the BRDF of glTF: below it a highlight would be smaller than any pixel.
    /// The value is that of three.js up to r186.
    MIN_ROUGHNESS: f32 = 0.0525;
    /// Number of the BRDF of glTF with multiple scattering.
    BRDF_GLTF_SCATTERING: u32 = 2;
    /// What microfacets of the roughness `r`, seen at the cosine `c`, scatter more than once, as a polynomial:
    /// `r²·(S₀ + r·S₁ + r²·S₂)` with `Sᵢ` of `1`, `c` and `c²`. A fit to the exact integral, within 0.03 for `c` > 0.15.
    SCATTERING_0: [f32; 3] = [2.4077258, -6.163342, 2.870002];
    /// See `SCATTERING_0`.
    SCATTERING_1: [f32; 3] = [-5.2246656, 18.160208, -9.560413];
    /// See `SCATTERING_0`.
    SCATTERING_2: [f32; 3] = [3.0177583, -11.153302, 6.3410854];
    /// Least share that is scattered once.
    SCATTERED_LEAST: f32 = 0.3;
    /// Brightness of a picture where no object is.
    NO_OBJECT: f32 = -1.0;

    /// How far above its polygon a ray to a light starts, scene radii.
    SHADOW_OFFSET: f32 = 5e-4;
    /// Mark of a triangle that blocks light everywhere.
    OPAQUE: u32 = u32::MAX;

    /// Object pixels that stand side by side in the shadow table.
    SHADOW_BLOCK: u32 = 16;
    /// Number of a pixel that shows no object.
    NO_PIXEL: u32 = u32::MAX;

    /// Most lights of a rig.
    MAX_LIGHTS: u32 = 16;

    /// Rec. 709 luminance weights of linear RGB.
    LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
    /// sRGB (IEC 61966-2-1): the largest linear value that is encoded linearly.
    SRGB_LINEAR_END: f32 = 0.0031308;
    /// sRGB: the encoding of the largest value that is encoded linearly.
    SRGB_ENCODED_END: f32 = 0.04045;
    /// sRGB: slope of the linear part.
    SRGB_SLOPE: f32 = 12.92;
    /// sRGB: scale of the power.
    SRGB_SCALE: f32 = 1.055;
    /// sRGB: what is taken off the power.
    SRGB_OFFSET: f32 = 0.055;
    /// sRGB: exponent of the decoding.
    SRGB_GAMMA: f32 = 2.4;

    /// Flag of a material whose back faces are drawn.
    DOUBLE_SIDED: u32 = 1;
    /// Flag of a material with a normal texture.
    NORMAL_MAPPED: u32 = 2;
    /// Textures that a material can have: base colour, metallic-roughness, normal, emissive.
    MATERIAL_TEXTURES: u32 = 4;
    /// Least squared pixel step of a texture lookup, texels²: its logarithm stays finite.
    MIN_TEXEL_STEP2: f32 = 1e-30;

    /// Flag of an engine's surface: it has an image of normals.
    HAS_NORMAL: u32 = 1;
    /// Flag of an engine's surface: it has an image of base colours.
    HAS_BASE_COLOR: u32 = 2;
    /// Flag of an engine's surface: it has an image of roughness and metallic factors.
    HAS_ROUGHNESS_METALLIC: u32 = 4;
    /// Flag of an engine's surface: it has an image of emitted radiance.
    HAS_EMISSIVE: u32 = 8;
    /// Flag of an engine's surface: it has an image of object numbers.
    HAS_IDS: u32 = 16;
    /// Flag of an engine's surface: rows of the picture run against the y axis of clip space.
    FLIPPED: u32 = 32;
    /// Flag of an engine's surface: normals are coded as `(n + 1) / 2`.
    NORMAL_UNSIGNED: u32 = 64;
    /// Flag of an engine's surface: normals are coded as octahedra.
    NORMAL_OCTAHEDRAL: u32 = 128;
    /// Flag of an engine's surface: base colours are sRGB-encoded.
    BASE_COLOR_ENCODED: u32 = 256;

    /// Pixels, one below the other, of an invocation of the stages that make a view's maps.
    MAP_STRIP: u32 = 16;
    /// Rows of a strip of `histogram`; at most 255, as it counts in bytes.
    HISTOGRAM_ROWS: u32 = 128;
    /// Rows of a strip of `moments` and `gradient`.
    SUM_ROWS: u32 = 32;

    /// Individuals that share a pass of `shading` and `statistics` over the object pixels.
    RUNS_BLOCK: u32 = 4;
    /// Lights of such a block, at most, behind those that only alignment brings along.
    LIGHT_WINDOW: u32 = RUNS_BLOCK * MAX_LIGHTS + 8;
    /// Invocations of a work group of `statistics`; each has a run of pixels.
    STATISTICS_GROUP: u32 = 32;
    /// Pixels of a run; at most 255, as it is counted in bytes.
    RUN_PIXELS: u32 = 128;

    /// Invocations of a work group of `tiles`.
    TILES_GROUP: u32 = 256;
    /// Individuals that share a pass of `tiles` over the surface. Drivers shade them side by side: the more there
    /// are, the more registers an invocation takes.
    TILES_BLOCK: u32 = 2;
    /// The same in colour, where each takes more.
    TILES_COLOR_BLOCK: u32 = 1;
    /// Pixels of a tile's side.
    TILE_SIDE: u32 = 32;
    /// Origin of a tile without object pixels.
    EMPTY_TILE: u32 = u32::MAX;

    /// Invocations of a work group of `fitness`; a power of two, at least [`HISTOGRAM_BINS`].
    FITNESS_GROUP: u32 = 128;
}
