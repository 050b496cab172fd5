//! What an engine says of what it has drawn: its camera, and how its images are to be read.

use super::view::{Camera, Projection, View, check_size};
use crate::error::within;
use crate::math::frame::{Frame, RADII};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};

/// Far from a rotation, a view matrix scales, shears or mirrors.
const RIGID: f64 = 1e-3;

/// The camera that an engine has drawn with, and the bounds of its scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngineCamera {
    /// Eye space from world space: a rotation and a translation. In eye space the viewer is at the
    /// origin, x goes to the right, y up, and the view goes along −z.
    pub view: DMat4,
    /// Clip space from eye space, as the engine draws with it: depth 0 to 1 or reversed, far plane
    /// finite or not, perspective or parallel.
    pub projection: DMat4,
    /// Centre of the scene in the world: lights are placed around it.
    pub center: DVec3,
    /// Radius of the scene around it, world units: the unit of all lengths of lights.
    pub radius: f64,
}

impl EngineCamera {
    /// The view of a picture of `width` by `height` pixels.
    ///
    /// # Errors
    /// [`Error::Argument`] for a matrix that is not finite, a view matrix that is not rigid, a
    /// projection that is neither perspective nor parallel, a radius outside [`RADII`], and a
    /// picture of an impossible size.
    pub fn view(&self, width: u32, height: u32) -> Result<View> {
        check_size(width, height)?;
        self.check()?;
        let world_from_eye = self.view.inverse();
        let [right, up, back] =
            [world_from_eye.x_axis, world_from_eye.y_axis, world_from_eye.z_axis]
                .map(|axis| axis.truncate().normalize());
        let eye = world_from_eye.w_axis.truncate();
        let camera = Camera {
            name: "engine".into(),
            eye,
            right,
            up,
            back,
            projection: self.lens()?,
            near: self.radius * 1e-3,
            far: None,
            designed: None,
        };
        let frame = Frame { center: self.center, radius: self.radius, right, up, back };
        let clip_from_world = self.own_projection() * self.view;
        Ok(View {
            width,
            height,
            camera,
            frame,
            eye: frame.from_world().transform_point3(eye).as_vec3(),
            clip_from_frame: (clip_from_world * frame.from_world().inverse()).as_mat4(),
        })
    }

    /// Light frame from the engine's clip space.
    pub fn frame_from_clip(&self, frame: &Frame) -> DMat4 {
        frame.from_world() * (self.projection * self.view).inverse()
    }

    /// The projection as klieg draws with it: y down, depth falling from the viewer on.
    fn own_projection(&self) -> DMat4 {
        let [x, mut y, mut z, w] = [0, 1, 2, 3].map(|row| self.projection.row(row));
        if self.projection.y_axis.y > 0.0 {
            y = -y;
        }
        let depth = |distance: f64| {
            let p = DVec4::new(0.0, 0.0, -distance, 1.0);
            z.dot(p) / w.dot(p)
        };
        if depth(2.0 * self.radius) > depth(self.radius) {
            z = w - z;
        }
        DMat4::from_cols(x, y, z, w).transpose()
    }

    fn check(&self) -> Result<()> {
        let fault = |fault: &str| Err(Error::Argument(format!("the engine's camera: {fault}")));
        if !(self.view.is_finite() && self.projection.is_finite() && self.center.is_finite()) {
            return fault("a number is not finite");
        }
        let rotation = DMat3::from_mat4(self.view);
        let product = rotation * rotation.transpose();
        let off = (product - DMat3::IDENTITY).to_cols_array().map(f64::abs);
        if off.into_iter().any(|x| x > RIGID) || rotation.determinant() < 0.0 {
            return fault("its view matrix is not a rotation with a translation");
        }
        if !RADII.contains(&self.radius) {
            return fault(&format!("the scene's radius of {:e} is out of range", self.radius));
        }
        if self.projection.determinant().abs() < f64::MIN_POSITIVE {
            return fault("its projection has no inverse");
        }
        Ok(())
    }

    fn lens(&self) -> Result<Projection> {
        let w = self.projection.row(3).to_array();
        let y = self.projection.y_axis.y.abs();
        let is = |expected: [f64; 4]| w.iter().zip(expected).all(|(a, b)| (a - b).abs() < RIGID);
        if is([0.0, 0.0, -1.0, 0.0]) {
            Ok(Projection::Perspective { yfov: 2.0 * (1.0 / y).atan() })
        } else if is([0.0, 0.0, 0.0, 1.0]) {
            Ok(Projection::Orthographic { ymag: 1.0 / y })
        } else {
            let fault = "the engine's camera: its projection is neither perspective nor parallel \
                         along -z";
            Err(Error::Argument(fault.into()))
        }
    }
}

/// Which space an engine's normals are in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum NormalSpace {
    /// The world's.
    #[default]
    World,
    /// The eye's, of [`EngineCamera::view`].
    Eye,
}

/// How an engine's normals are coded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum NormalCode {
    /// Three components −1..1, of any length.
    #[default]
    Signed,
    /// Three components 0..1, `(n + 1) / 2`.
    Unsigned,
    /// Two components −1..1, octahedral (Cigolle et al. 2014).
    Octahedral,
    /// Two components 0..1, octahedral.
    OctahedralUnsigned,
}

/// How the images of an engine's surface are to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFormat {
    /// Space of the normals.
    pub normal_space: NormalSpace,
    /// Code of the normals. Normals that face away from the viewer are mirrored to face it.
    pub normal_code: NormalCode,
    /// Whether base colours come out of the image sRGB-encoded. An image of an sRGB format decodes them
    /// itself: then they do not.
    pub base_color_encoded: bool,
    /// Component of the roughness (perceptual, as glTF has it), 0 to 3.
    pub roughness_channel: u32,
    /// Component of the metallic factor, 0 to 3.
    pub metallic_channel: u32,
    /// Depth of pixels where nothing is drawn; without ids these are the background.
    pub cleared_depth: f32,
    /// Whether the first row of the images is at clip space's `y = 1`, as where an engine draws with a
    /// viewport of negative height; by Vulkan's own rule it is at `y = −1`.
    pub flipped: bool,
    /// Linear base colour where there is no image of it.
    pub base_color: [f32; 3],
    /// Roughness where there is no image of it, 0..=1.
    pub roughness: f32,
    /// Metallic factor where there is no image of it, 0..=1.
    pub metallic: f32,
}

impl Default for SurfaceFormat {
    /// World-space signed normals, roughness in G and metallic factor in B as in glTF's textures, depth
    /// cleared to 1, rows by Vulkan's rule, and a light grey matt material.
    fn default() -> Self {
        Self {
            normal_space: NormalSpace::World,
            normal_code: NormalCode::Signed,
            base_color_encoded: false,
            roughness_channel: 1,
            metallic_channel: 2,
            cleared_depth: 1.0,
            flipped: false,
            base_color: [0.8; 3],
            roughness: 1.0,
            metallic: 0.0,
        }
    }
}

impl SurfaceFormat {
    /// # Errors
    /// [`Error::Argument`] that names the first value out of its range.
    pub fn check(&self) -> Result<()> {
        for (name, channel) in
            [("roughness", self.roughness_channel), ("metallic", self.metallic_channel)]
        {
            if channel > 3 {
                let fault = format!("component {channel} of {name}: an image has 0 to 3");
                return Err(Error::Argument(fault));
            }
        }
        within("the surface's cleared depth", self.cleared_depth, 0.0, 1.0)?;
        within("the surface's roughness", self.roughness, 0.0, 1.0)?;
        within("the surface's metallic factor", self.metallic, 0.0, 1.0)?;
        self.base_color
            .into_iter()
            .try_for_each(|c| within("the surface's base color", c, 0.0, f32::MAX))
    }
}

/// How the colours of an engine's pictures are encoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PictureEncoding {
    /// Linear radiance, of which 1 is the brightest that is shown: what float images hold, and what images
    /// of an sRGB format give.
    #[default]
    Linear,
    /// sRGB-encoded: what 8-bit images of a plain format hold.
    Encoded,
}

/// Which components of an engine's pictures count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PictureChannels {
    /// Red, green and blue, with Rec. 709 primaries.
    #[default]
    Rgb,
    /// The first alone, a luminance.
    Red,
}

/// How an engine's pictures are to be read: linear colours unless said otherwise.
///
/// klieg judges them as its own, by the sRGB-encoded luminance of each pixel, 0..=1. What is below 0 or
/// not a number counts as 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PictureFormat {
    /// What a texel fetch gives.
    pub encoding: PictureEncoding,
    /// What of it counts.
    pub channels: PictureChannels,
}

/// The unit vector of an octahedral code, components −1..1.
pub fn octahedral(code: [f32; 2]) -> Vec3 {
    let [x, y] = code;
    let z = 1.0 - x.abs() - y.abs();
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let n = match z >= 0.0 {
        true => Vec3::new(x, y, z),
        false => Vec3::new((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y), z),
    };
    n.normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dcamera::rh::{proj, view};

    fn camera() -> EngineCamera {
        EngineCamera {
            view: view::look_at_mat4(DVec3::new(3.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y),
            projection: proj::vulkan::perspective_infinite_reverse(0.8, 1.5, 0.1),
            center: DVec3::new(0.1, 0.0, 0.2),
            radius: 2.0,
        }
    }

    #[test]
    fn the_view_looks_where_the_engine_looks() {
        let camera = camera();
        let view = camera.view(30, 20).unwrap();
        let eye = DVec3::new(3.0, 2.0, 4.0);
        assert!(view.camera.eye.distance(eye) < 1e-12 && view.camera.right.y.abs() < 1e-12);
        assert!(view.camera.back.dot(eye.normalize()) > 1.0 - 1e-12);
        let Projection::Perspective { yfov } = view.camera.projection else { panic!("{view:?}") };
        assert!((yfov - 0.8).abs() < 1e-12);
        let p = DVec3::new(0.3, -0.2, 0.5);
        let clip = camera.projection * camera.view * p.extend(1.0);
        let back = camera.frame_from_clip(&view.frame) * (clip / clip.w);
        let expected = view.frame.from_world().transform_point3(p);
        assert!((back.truncate() / back.w).distance(expected) < 1e-9);
    }

    #[test]
    fn any_projection_draws_the_same_view() {
        let good = camera();
        let view = good.view(30, 20).unwrap();
        let flip = DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
        for projection in [
            proj::vulkan::perspective_infinite(0.8, 1.5, 0.1),
            proj::vulkan::perspective(0.8, 1.5, 0.1, 50.0),
            flip * proj::vulkan::perspective(0.8, 1.5, 0.1, 50.0),
            flip * good.projection,
        ] {
            let other = EngineCamera { projection, ..good }.view(30, 20).unwrap();
            let mut nearer = f32::INFINITY;
            for p in [Vec3::new(0.2, 0.3, 0.4), Vec3::new(-0.3, 0.1, -0.2), Vec3::NEG_Z] {
                let [a, b] = [&view, &other].map(|v| v.clip_from_frame.project_point3(p));
                assert!(a.truncate().abs_diff_eq(b.truncate(), 1e-5), "{a} {b}");
                assert!((0.0..=1.0).contains(&b.z) && b.z < nearer, "{projection}: {b}");
                nearer = b.z;
            }
        }
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let good = camera();
        let said = |camera: EngineCamera| camera.view(4, 4).unwrap_err().to_string();
        let scaled = EngineCamera { view: DMat4::from_scale(DVec3::splat(2.0)), ..good };
        assert!(said(scaled).contains("not a rotation"));
        let mirrored = EngineCamera { view: DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)), ..good };
        assert!(said(mirrored).contains("not a rotation"));
        assert!(said(EngineCamera { view: DMat4::NAN, ..good }).contains("not finite"));
        assert!(said(EngineCamera { radius: 0.0, ..good }).contains("radius"));
        assert!(said(EngineCamera { projection: DMat4::ZERO, ..good }).contains("no inverse"));
        let left = glam::dcamera::lh::proj::vulkan::perspective(0.8, 1.0, 0.1, 9.0);
        assert!(said(EngineCamera { projection: left, ..good }).contains("neither"));
        let parallel = proj::vulkan::orthographic(-2.0, 2.0, -1.0, 1.0, 0.1, 9.0);
        let view = EngineCamera { projection: parallel, ..good }.view(8, 4).unwrap();
        assert!(view.is_orthographic());
        assert!(good.view(0, 4).is_err());
    }

    #[test]
    fn formats_out_of_range_are_refused() {
        let good = SurfaceFormat::default();
        good.check().unwrap();
        for bad in [
            SurfaceFormat { roughness_channel: 4, ..good },
            SurfaceFormat { metallic: 1.5, ..good },
            SurfaceFormat { cleared_depth: f32::NAN, ..good },
            SurfaceFormat { base_color: [0.0, -1.0, 0.0], ..good },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn octahedral_codes_cover_the_sphere() {
        assert_eq!(octahedral([0.0, 0.0]), Vec3::Z);
        assert_eq!(octahedral([1.0, 0.0]), Vec3::X);
        assert_eq!(octahedral([0.0, -1.0]), Vec3::NEG_Y);
        assert_eq!(octahedral([1.0, 1.0]), Vec3::NEG_Z);
        assert!(
            octahedral([-0.75, 0.75]).abs_diff_eq(Vec3::new(-1.0, 1.0, -2.0).normalize(), 1e-6)
        );
    }
}
