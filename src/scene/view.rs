//! Cameras, the light frame and the view that everything is drawn and measured in.

use super::Scene;
use crate::math::frame::{Frame, RADII};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};
use rayon::prelude::*;

/// Most pixels of a picture's side.
pub const MAX_SIDE: u32 = 1 << 14;
/// Most pixels of a picture: 8192 x 8192. A view takes 100 to 250 bytes a pixel.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A camera in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Name, for people and for choosing it.
    pub name: String,
    /// Position, world units.
    pub eye: DVec3,
    /// Unit axes: to the right, up, and from the scene to the viewer.
    pub right: DVec3,
    /// See `right`.
    pub up: DVec3,
    /// See `right`.
    pub back: DVec3,
    /// Lens.
    pub projection: Projection,
    /// Distance of the near clipping plane along the view axis, world units.
    pub near: f64,
    /// Distance of the far clipping plane; infinite where `None`.
    pub far: Option<f64>,
    /// Whether klieg put it there to say which view a rig was designed for.
    pub designed: Option<DesignedView>,
}

/// What klieg writes beside the camera of a lit scene, so that the view can be had again.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DesignedView {
    /// Width and height of the picture that was judged, in pixels.
    pub size: [u32; 2],
    /// Distance of the near clipping plane of the picture that was judged, world units, where the camera in
    /// the file has another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Distance of its far clipping plane where there is such a near one; infinite where `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f64>,
}

impl DesignedView {
    /// The clipping planes of the picture that was judged, where the camera in the file has others.
    pub fn planes(&self) -> Option<(f64, Option<f64>)> {
        self.near.map(|near| (near, self.far))
    }
}

/// A camera's lens. The picture's own aspect ratio decides the width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Vertical field of view, radians.
    Perspective {
        /// Full angle.
        yfov: f64,
    },
    /// Half of the picture's height, world units.
    Orthographic {
        /// Half height.
        ymag: f64,
    },
}

/// A camera, the light frame it gives, and the picture's size. Lengths are scene radii.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The camera.
    pub camera: Camera,
    /// The light frame.
    pub frame: Frame,
    /// The viewer's position in the light frame.
    pub eye: Vec3,
    /// Vulkan clip space (y down, depth 1 at the near plane and 0 at the far one) from the light frame.
    pub clip_from_frame: Mat4,
}

impl View {
    /// The view of `scene` through `camera`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture without pixels or with more than [`MAX_SIDE`] a side or
    /// [`MAX_PIXELS`] in all, [`Error::Input`] for a scene without extent or of a radius outside
    /// [`RADII`], and as [`Scene::check`].
    pub fn new(scene: &Scene, camera: Camera, width: u32, height: u32) -> Result<Self> {
        check_size(width, height)?;
        let (center, radius) = bounds(scene)?;
        if !RADII.contains(&radius) {
            let (least, most) = (RADII.start(), RADII.end());
            let fault = format!("its radius of {radius:e} is outside {least:e}..{most:e}");
            return Err(Error::input(&scene.path, fault));
        }
        let (right, up, back) = (camera.right, camera.up, camera.back);
        let frame = Frame { center, radius, right, up, back };
        let eye = frame.from_world().transform_point3(camera.eye);
        let aspect = f64::from(width) / f64::from(height);
        let clip = clip_from_eye(&camera, radius, aspect) * DMat4::from_translation(-eye);
        Ok(Self {
            width,
            height,
            camera,
            frame,
            eye: eye.as_vec3(),
            clip_from_frame: clip.as_mat4(),
        })
    }

    /// The same view of the scene in pictures whose longer side has so many pixels at most.
    ///
    /// # Errors
    /// As [`View::new`].
    pub fn shrunk(&self, scene: &Scene, longest: u32) -> Result<Self> {
        let [width, height] = shrunk([self.width, self.height], longest);
        Self::new(scene, self.camera.clone(), width, height)
    }

    /// The view in pictures of every `step`-th pixel along both sides, of one at least: what is left at the end of a row
    /// or column falls away. What it draws is all of the view in so many pixels.
    ///
    /// # Panics
    /// For a step of 0.
    pub fn subsampled(&self, step: u32) -> Self {
        let [width, height] = [self.width, self.height].map(|side| (side / step).max(1));
        Self { width, height, ..self.clone() }
    }

    /// Whether the fields are within their bounds: the picture's size as for [`View::new`], a light frame
    /// with a radius in [`RADII`], and finite numbers. Whatever draws or measures a view asks for it.
    ///
    /// # Errors
    /// [`Error::Argument`] with what is out of its bounds.
    pub fn check(&self) -> Result<()> {
        check_size(self.width, self.height)?;
        self.frame.check()?;
        if !(self.eye.is_finite() && self.clip_from_frame.is_finite()) {
            let fault = "a view needs a finite eye and a finite clip_from_frame";
            return Err(Error::Argument(fault.into()));
        }
        Ok(())
    }

    /// Whether all view rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.camera.projection, Projection::Orthographic { .. })
    }

    /// Unit vector from `p` (light frame) to the viewer.
    pub fn towards_viewer(&self, p: Vec3) -> Vec3 {
        if self.is_orthographic() { Vec3::Z } else { (self.eye - p).normalize_or(Vec3::Z) }
    }

    /// Light frame from an instance's mesh space, computed in double precision.
    pub fn frame_from_mesh(&self, world: &DMat4) -> DMat4 {
        self.frame.from_world() * *world
    }

    /// What turns normals of an instance's mesh into the light frame, and whether the instance
    /// mirrors, so that fronts are wound the other way. It is a positive multiple of the inverse
    /// transpose with a longest column of unit length, made of the cofactors, which flat transforms
    /// have too.
    pub fn normal_from_mesh(&self, world: &DMat4) -> (DMat3, bool) {
        let linear = DMat3::from_mat4(self.frame_from_mesh(world));
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let longest = cofactors.map(DVec3::length).into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let mirrored = linear.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let [x, y, z] = cofactors.map(|column| column * (sign / longest));
        (DMat3::from_cols(x, y, z), mirrored)
    }
}

pub(super) fn check_size(width: u32, height: u32) -> Result<()> {
    let fault = if width == 0 || height == 0 {
        "has no pixels".to_owned()
    } else if width.max(height) > MAX_SIDE {
        format!("has more than {MAX_SIDE} pixels a side")
    } else if u64::from(width) * u64::from(height) > MAX_PIXELS {
        format!("has more than {MAX_PIXELS} pixels")
    } else {
        return Ok(());
    };
    Err(Error::Argument(format!("picture size {width}x{height} {fault}")))
}

/// Centre of the bounding box of everything drawn and the largest distance of a vertex from it.
///
/// # Errors
/// [`Error::Input`] when nothing is drawn, or all of it in one point, and as [`Scene::check`].
pub fn bounds(scene: &Scene) -> Result<(DVec3, f64)> {
    scene.check()?;
    let (low, high) = corners(scene);
    let center = (low + high) / 2.0;
    let square = vertices(scene).map(|p| p.distance_squared(center));
    let radius = square.fold(|| 0.0, f64::max).reduce(|| 0.0, f64::max).sqrt();
    if !(radius.is_finite() && radius > 0.0) {
        return Err(Error::input(&scene.path, "nothing to draw has any extent"));
    }
    Ok((center, radius))
}

/// Corners of the bounding box of everything drawn, world units; infinite where nothing is.
pub(super) fn corners(scene: &Scene) -> (DVec3, DVec3) {
    // The least and the greatest do not depend on the order.
    let nothing = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
    vertices(scene)
        .fold(nothing, |(low, high), p| (low.min(p), high.max(p)))
        .reduce(nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// All drawn vertices in the world, each as often as triangles use it.
fn vertices(scene: &Scene) -> impl ParallelIterator<Item = DVec3> {
    scene.instances.par_iter().flat_map(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        mesh.indices.par_iter().map(move |&index| {
            let position = Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
            instance.world.transform_point3(position)
        })
    })
}

/// Width and height of the same proportions, of which the longer is `longest` and none is 0.
pub fn proportional([width, height]: [u32; 2], longest: u32) -> [u32; 2] {
    let scale = f64::from(longest) / f64::from(width.max(height));
    [width, height].map(|side| ((f64::from(side) * scale).round() as u32).max(1))
}

/// The same, but never larger than they are.
pub fn shrunk(size: [u32; 2], longest: u32) -> [u32; 2] {
    proportional(size, longest.min(size[0].max(size[1])))
}

/// Clip space from eye space (axes of the light frame, scene radii), depth reversed.
fn clip_from_eye(camera: &Camera, radius: f64, aspect: f64) -> DMat4 {
    let near = camera.near / radius;
    let far = camera.far.map(|far| far / radius);
    let row_z; // z_clip = row_z.0 · z + row_z.1
    let (x, y, w);
    match camera.projection {
        Projection::Perspective { yfov } => {
            y = 1.0 / (yfov / 2.0).tan();
            x = y / aspect;
            row_z = match far {
                Some(far) => (near / (far - near), near * far / (far - near)),
                None => (0.0, near),
            };
            w = true;
        }
        Projection::Orthographic { ymag } => {
            y = radius / ymag;
            x = y / aspect;
            let far = far.unwrap_or(near + 1e4);
            row_z = (1.0 / (far - near), far / (far - near));
            w = false;
        }
    }
    let (zw, ww) = if w { (-1.0, 0.0) } else { (0.0, 1.0) };
    DMat4::from_cols_array_2d(&[
        [x, 0.0, 0.0, 0.0],
        [0.0, -y, 0.0, 0.0],
        [0.0, 0.0, row_z.0, zw],
        [0.0, 0.0, row_z.1, ww],
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_beyond_all_bounds_are_refused() {
        for (width, height) in [(0, 5), (5, 0), (16385, 1), (8193, 8192), (u32::MAX, u32::MAX)] {
            let fault = check_size(width, height).unwrap_err();
            assert!(fault.is_input() && fault.to_string().contains(&format!("{width}x{height}")));
        }
        for (width, height) in [(16384, 4096), (8192, 8192), (1, 1)] {
            check_size(width, height).unwrap();
        }
    }

    #[test]
    fn views_with_fields_out_of_their_bounds_are_refused() {
        let (center, radius) = (DVec3::ZERO, 1.0);
        let lens = Projection::Perspective { yfov: 0.6 };
        let camera = Camera::look_at(DVec3::Z * 4.0, center, DVec3::Y, lens).expect("a camera");
        let Camera { right, up, back, .. } = camera;
        let view = || View {
            width: 8,
            height: 8,
            camera: camera.clone(),
            frame: Frame { center, radius, right, up, back },
            eye: Vec3::Z * 4.0,
            clip_from_frame: Mat4::IDENTITY,
        };
        view().check().expect("a view");
        let faults: [fn(&mut View); 6] = [
            |v| v.width = 0,
            |v| v.height = u32::MAX,
            |v| v.frame.radius = 0.0,
            |v| v.frame.up.x = f64::NAN,
            |v| v.eye.y = f32::INFINITY,
            |v| v.clip_from_frame.w_axis.x = f32::NAN,
        ];
        for break_it in faults {
            let mut broken = view();
            break_it(&mut broken);
            assert!(broken.check().is_err_and(|error| error.is_input()), "{broken:?}");
        }
    }
}
