//! The default view: the whole scene, seen from a direction.

use super::Scene;
use super::view::{Camera, Projection, bounds, corners};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3, Vec3};
use rayon::prelude::*;

/// Name of the cameras that [`frame`] makes; nothing of the scene is beyond their clipping planes.
pub const NAME: &str = "framing";

/// Least distance from the eye to the scene, in scene radii.
const CLOSEST: f64 = 1e-4;

/// From where, how wide and how closely the scene is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// Towards the scene's right (+X) from its front (+Z), radians.
    pub azimuth: f64,
    /// Upwards (+Y), radians.
    pub elevation: f64,
    /// Vertical field of view, radians.
    pub fov: f64,
    /// Share of the picture's height or width, whichever binds, that the scene takes.
    pub fill: f64,
}

impl Default for Framing {
    fn default() -> Self {
        Self {
            azimuth: 30f64.to_radians(),
            elevation: 15f64.to_radians(),
            fov: 35f64.to_radians(),
            fill: 0.85,
        }
    }
}

/// The camera that shows all of `scene` in the middle of a picture whose width is `aspect` times
/// its height.
///
/// Seen along an axis, the scene fits between two planes through the eye whose slopes are `±k` when
/// the eye's distance is `D(k) = (A(k) + B(k)) / 2k`, with `A` and `B` the scene's largest `x + kz`
/// and `−x + kz`. So the binding axis gives the distance at once; the other one's `k`, and with it
/// the eye's offset that centres the scene, is the root of the convex function
/// `A(k) + B(k) − 2kD`, which Newton's method reaches from below without overshooting.
///
/// # Errors
/// [`Error::Argument`] for values out of range, [`Error::Input`] for a scene without extent.
pub fn frame(scene: &Scene, framing: &Framing, aspect: f64) -> Result<Camera> {
    let mut cameras = around(&[scene], framing, aspect, 1)?;
    Ok(cameras.swap_remove(0))
}

/// Cameras that all of `scenes` stay in sight of, such as the moments of one animation: `count` of them, evenly around
/// the vertical axis through their middle, from the framing's azimuth on. Several stand at one height and distance and
/// look at that axis, as if the scenes stood on a turntable; a single one shows them in the middle of the picture.
///
/// # Errors
/// As [`frame`]; no scene at all is an [`Error::Argument`].
pub fn around(
    scenes: &[&Scene],
    framing: &Framing,
    aspect: f64,
    count: usize,
) -> Result<Vec<Camera>> {
    check(framing, aspect)?;
    let (center, radius) = ball(scenes)?;
    let turn = |step: usize| std::f64::consts::TAU * step as f64 / count as f64;
    let sides: Vec<_> =
        (0..count).map(|step| axes(framing.azimuth + turn(step), framing.elevation)).collect();
    let into = |&(right, up, back): &_| DMat3::from_cols(right, up, back).transpose();
    let cameras = sides.iter().map(into).collect();
    let points = Points { scenes, center, cameras };
    let half = (framing.fov / 2.0).tan() * framing.fill;
    let slopes = [half * aspect, half];
    let support = points.support(slopes);
    let distance = |axis: usize| support[axis].sum().0 / (2.0 * slopes[axis]);
    let (low, high) = points.depths();
    // No nearer than a little before the scene: one without width or height is seen from there.
    let distance = distance(0).max(distance(1)).max(high + CLOSEST * radius);
    let offset = points.offsets(slopes, distance);
    let camera = |&(right, up, back): &(DVec3, DVec3, DVec3)| Camera {
        name: NAME.into(),
        eye: center + right * offset[0] + up * offset[1] + back * distance,
        right,
        up,
        back,
        projection: Projection::Perspective { yfov: framing.fov },
        near: 0.9 * (distance - high),
        far: Some(1.1 * (distance - low)),
        designed: None,
    };
    Ok(sides.iter().map(camera).collect())
}

/// Centre of the bounding box of all scenes, and the radius of the largest.
fn ball(scenes: &[&Scene]) -> Result<(DVec3, f64)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut middle, mut reach) = (DVec3::ZERO, 0f64);
    for scene in scenes {
        let (center, radius) = bounds(scene)?;
        let (l, h) = corners(scene);
        (low, high) = (low.min(l), high.max(h));
        (middle, reach) = (center, reach.max(radius));
    }
    match scenes.len() {
        0 => Err(Error::Argument("there is no scene to look at".into())),
        1 => Ok((middle, reach)),
        _ => Ok(((low + high) / 2.0, reach)),
    }
}

fn check(framing: &Framing, aspect: f64) -> Result<()> {
    let Framing { azimuth, elevation, fov, fill } = *framing;
    let fault = |text: &str, value: f64| Err(Error::Argument(format!("{text}, not {value}")));
    if !azimuth.is_finite() {
        return fault("the azimuth must be a number", azimuth);
    }
    if elevation.is_nan() || elevation.abs() > std::f64::consts::FRAC_PI_2 + 1e-9 {
        return fault("the elevation must be from -90 to 90 degrees", elevation.to_degrees());
    }
    if !(fov > 0.0 && fov < std::f64::consts::PI) {
        return fault("the field of view must be between 0 and 180 degrees", fov.to_degrees());
    }
    if !(fill > 0.0 && fill <= 1.0) {
        return fault("the share of the picture to fill must be above 0 and at most 1", fill);
    }
    if !(aspect.is_finite() && aspect > 0.0) {
        return fault("the picture's aspect ratio must be positive", aspect);
    }
    Ok(())
}

/// Right, up and back axes of a camera that looks from a direction; right stays level.
fn axes(azimuth: f64, elevation: f64) -> (DVec3, DVec3, DVec3) {
    let (sin, cos) = azimuth.sin_cos();
    let (rise, level) = elevation.sin_cos();
    let right = DVec3::new(cos, 0.0, -sin);
    let back = DVec3::new(level * sin, rise, level * cos);
    (right, back.cross(right), back)
}

/// Scenes' vertices in the axes of each camera, about the scenes' centre. Several cameras stand around the vertical axis
/// through it: there each vertex stands for its mirror image too, so that the axis is in the middle.
struct Points<'a> {
    scenes: &'a [&'a Scene],
    center: DVec3,
    cameras: Vec<DMat3>,
}

/// The largest `x + kz` and `−x + kz` along an axis, each with the `z` of its point.
#[derive(Clone, Copy)]
struct Support([(f64, f64); 2]);

impl Support {
    const NONE: Self = Self([(f64::NEG_INFINITY, 0.0); 2]);

    fn with(self, x: f64, z: f64, k: f64) -> Self {
        self.max(Self([(x + k * z, z), (k * z - x, z)]))
    }

    fn max(self, other: Self) -> Self {
        let greater = |i: usize| if other.0[i].0 > self.0[i].0 { other.0[i] } else { self.0[i] };
        Self([greater(0), greater(1)])
    }

    /// With the mirror images of all points.
    fn mirrored(self) -> Self {
        let Self([a, b]) = self;
        self.max(Self([b, a]))
    }

    /// `A + B` and its derivative by `k`.
    fn sum(self) -> (f64, f64) {
        let [(a, za), (b, zb)] = self.0;
        (a + b, za + zb)
    }

    /// The eye's offset that centres the scene.
    fn offset(self) -> f64 {
        (self.0[0].0 - self.0[1].0) / 2.0
    }
}

impl Points<'_> {
    /// Folds all drawn vertices, in parallel; `join` must not depend on order.
    fn fold<T: Copy + Send + Sync>(
        &self,
        start: T,
        add: impl Fn(T, DVec3) -> T + Sync,
        join: impl Fn(T, T) -> T + Sync,
    ) -> T {
        let instance = |scene: &Scene, instance: &super::Instance, camera: &DMat3| {
            let mesh = &scene.meshes[instance.mesh as usize];
            let matrix =
                DMat4::from_mat3(*camera) * DMat4::from_translation(-self.center) * instance.world;
            let add = |sum, &index: &u32| {
                let position = Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
                add(sum, matrix.transform_point3(position))
            };
            let chunk = |indices: &[u32]| indices.iter().fold(start, add);
            mesh.indices.par_chunks(1 << 14).map(chunk).reduce(|| start, &join)
        };
        let seen = |camera: &DMat3| {
            let scene = |scene: &&Scene| {
                let all = scene.instances.par_iter().map(|one| instance(scene, one, camera));
                all.reduce(|| start, &join)
            };
            self.scenes.iter().map(scene).fold(start, &join)
        };
        self.cameras.iter().map(seen).fold(start, &join)
    }

    /// Support along the horizontal and the vertical axis for slopes `k`.
    fn support(&self, k: [f64; 2]) -> [Support; 2] {
        let support = self.fold(
            [Support::NONE; 2],
            |[x, y], p| [x.with(p.x, p.z, k[0]), y.with(p.y, p.z, k[1])],
            |a, b| [a[0].max(b[0]), a[1].max(b[1])],
        );
        let [x, y] = support;
        if self.cameras.len() > 1 { [x.mirrored(), y] } else { support }
    }

    /// The smallest and the largest `z`.
    fn depths(&self) -> (f64, f64) {
        self.fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), p| (low.min(p.z), high.max(p.z)),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        )
    }

    /// The eye's offsets along both axes that centre the scene at `distance`.
    fn offsets(&self, slopes: [f64; 2], distance: f64) -> [f64; 2] {
        let mut k = [0.0; 2];
        let mut support = self.support(k);
        // The functions are piecewise linear: a few steps reach the root itself.
        for _ in 0..32 {
            let before = k;
            for axis in 0..2 {
                let (sum, slope) = support[axis].sum();
                let (value, derivative) = (sum - 2.0 * k[axis] * distance, slope - 2.0 * distance);
                if value > 0.0 && derivative < 0.0 {
                    k[axis] = (k[axis] - value / derivative).min(slopes[axis]);
                }
            }
            if k == before {
                break;
            }
            support = self.support(k);
        }
        support.map(Support::offset)
    }
}

#[cfg(test)]
mod tests;
