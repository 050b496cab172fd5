//! What an engine has drawn, as the visibility draw would have left it. Reference of `shaders/surface.comp`.

use crate::Result;
use crate::math::color::srgb_decode;
use crate::objective::maps::Surface;
use crate::scene::engine::{EngineCamera, NormalCode, NormalSpace, SurfaceFormat, octahedral};
use crate::scene::view::View;
use glam::{Mat3, Mat4, Vec3, Vec4};

/// An engine's images as they come out of a texel fetch, one entry a pixel, rows from the top.
#[derive(Debug, Clone, Default)]
pub struct EngineImages {
    /// Depth, `n`.
    pub depth: Vec<f32>,
    /// Coded normals, `n`; without them they are made of the depth.
    pub normal: Option<Vec<[f32; 4]>>,
    /// Base colours, `n`.
    pub base_color: Option<Vec<[f32; 4]>>,
    /// Roughness and metallic factor in the components that the format names, `n`.
    pub roughness_metallic: Option<Vec<[f32; 4]>>,
    /// Linear emitted radiance, `n`.
    pub emissive: Option<Vec<[f32; 4]>>,
    /// Numbers of objects or polygons, 0 in the background, `n`.
    pub ids: Option<Vec<u32>>,
}

/// Looks at the engine's images pixel by pixel.
struct Reader<'a> {
    images: &'a EngineImages,
    format: &'a SurfaceFormat,
    view: &'a View,
    frame_from_clip: Mat4,
    frame_from_normals: Mat3,
}

/// The surface that the images of `width` by `height` pixels show; the depth of the background is 0.
///
/// # Errors
/// As [`EngineCamera::view`].
pub fn surface(
    images: &EngineImages,
    format: &SurfaceFormat,
    camera: &EngineCamera,
    [width, height]: [u32; 2],
) -> Result<Surface> {
    let view = camera.view(width, height)?;
    let frame = &view.frame;
    let rotation = match format.normal_space {
        NormalSpace::World => {
            Mat3::from_cols(frame.right.as_vec3(), frame.up.as_vec3(), frame.back.as_vec3())
                .transpose()
        }
        NormalSpace::Eye => Mat3::IDENTITY,
    };
    let reader = Reader {
        images,
        format,
        view: &view,
        frame_from_clip: camera.frame_from_clip(frame).as_mat4(),
        frame_from_normals: rotation,
    };
    let mut surface = Surface { width, height, ..Surface::default() };
    for at in 0..width as usize * height as usize {
        reader.read(at, &mut surface);
    }
    Ok(surface)
}

impl Reader<'_> {
    fn read(&self, at: usize, surface: &mut Surface) {
        let SurfaceFormat { base_color, roughness, metallic, .. } = *self.format;
        let p = self.position(at);
        let object = self.is_object(at) && p.is_finite();
        let keep = |v: [f32; 3]| if object { v } else { [0.0; 3] };
        let texel = |image: &Option<Vec<[f32; 4]>>| image.as_ref().map(|image| image[at]);
        let rm = texel(&self.images.roughness_metallic);
        let channel = |channel: u32, other| rm.map_or(other, |texel| texel[channel as usize]);
        let decode = |c: f32| if self.format.base_color_encoded { srgb_decode(c) } else { c };
        let base = texel(&self.images.base_color)
            .map_or(base_color, |[r, g, b, _]| [decode(r), decode(g), decode(b)]);
        let emissive = texel(&self.images.emissive).map_or([0.0; 3], |[r, g, b, _]| [r, g, b]);
        let code = self.images.ids.as_ref().map_or(1, |ids| ids[at]);
        let normal = if object { self.normal(at, p) } else { Vec3::ZERO };
        surface.code.push(if object { code } else { 0 });
        surface.depth.push(if object { self.view.eye.z - p.z } else { 0.0 });
        surface.position.push(keep(p.to_array()));
        let face = if object { self.face(at, p) } else { Vec3::ZERO };
        surface.normal.push(normal.to_array());
        surface.face.push(face.to_array());
        surface.base_color.push(keep(base));
        let roughness = channel(self.format.roughness_channel, roughness).clamp(0.0, 1.0);
        let metallic = channel(self.format.metallic_channel, metallic).clamp(0.0, 1.0);
        surface.roughness.push(keep([roughness; 3])[0]);
        surface.metallic.push(keep([metallic; 3])[0]);
        surface.emissive.push(keep(emissive));
    }

    fn is_object(&self, at: usize) -> bool {
        match &self.images.ids {
            Some(ids) => ids[at] != 0,
            None => self.images.depth[at] != self.format.cleared_depth,
        }
    }

    fn position(&self, at: usize) -> Vec3 {
        let (width, height) = (self.view.width as usize, self.view.height as usize);
        let x = 2.0 * ((at % width) as f32 + 0.5) / width as f32 - 1.0;
        let y = 2.0 * ((at / width) as f32 + 0.5) / height as f32 - 1.0;
        let y = if self.format.flipped { -y } else { y };
        let p = self.frame_from_clip * Vec4::new(x, y, self.images.depth[at], 1.0);
        p.truncate() / p.w
    }

    /// Unit normal turned to the viewer.
    fn normal(&self, at: usize, p: Vec3) -> Vec3 {
        let v = self.view.towards_viewer(p);
        let n = match &self.images.normal {
            Some(normals) => {
                let [x, y, z, _] = normals[at];
                let signed = |c: f32| 2.0 * c - 1.0;
                self.frame_from_normals
                    * match self.format.normal_code {
                        NormalCode::Signed => Vec3::new(x, y, z),
                        NormalCode::Unsigned => Vec3::new(signed(x), signed(y), signed(z)),
                        NormalCode::Octahedral => octahedral([x, y]),
                        NormalCode::OctahedralUnsigned => octahedral([signed(x), signed(y)]),
                    }
            }
            None => return self.face(at, p),
        };
        let n = if n.length_squared() > 0.0 { n / n.length() } else { v };
        n - 2.0 * n.dot(v).min(0.0) * v
    }

    /// Unit normal of what lies between the pixel and its neighbours, turned to the viewer.
    fn face(&self, at: usize, p: Vec3) -> Vec3 {
        let v = self.view.towards_viewer(p);
        let n = self.tangent(at, p, [1, 0]).cross(self.tangent(at, p, [0, 1]));
        let n = if n.dot(v) < 0.0 { -n } else { n };
        if n.length_squared() > 0.0 { n / n.length() } else { v }
    }

    /// The step along an axis to the neighbour whose depth is nearer, or none.
    fn tangent(&self, at: usize, p: Vec3, [dx, dy]: [i64; 2]) -> Vec3 {
        let (width, height) = (i64::from(self.view.width), i64::from(self.view.height));
        let (x, y) = (at as i64 % width, at as i64 / width);
        let step = |sign: i64| {
            let (x, y) = (x + sign * dx, y + sign * dy);
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let tap = (y * width + x) as usize;
            let found = inside && self.is_object(tap);
            let step = found.then(|| (self.position(tap) - p) * sign as f32);
            (step.unwrap_or(Vec3::ZERO), step.map_or(f32::MAX, |s| s.z.abs()))
        };
        let (before, after) = (step(-1), step(1));
        if before.1 < after.1 { before.0 } else { after.0 }
    }
}
