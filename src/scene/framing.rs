//! The default view: the whole scene, seen from a direction.

use super::Scene;
use super::view::{Camera, Projection, bounds};
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
    check(framing, aspect)?;
    let (center, radius) = bounds(scene)?;
    let (right, up, back) = axes(framing.azimuth, framing.elevation);
    let points = Points { scene, center, camera: DMat3::from_cols(right, up, back).transpose() };
    let half = (framing.fov / 2.0).tan() * framing.fill;
    let slopes = [half * aspect, half];
    let support = points.support(slopes);
    let distance = |axis: usize| support[axis].sum().0 / (2.0 * slopes[axis]);
    let (low, high) = points.depths();
    // No nearer than a little before the scene: one without width or height is seen from there.
    let distance = distance(0).max(distance(1)).max(high + CLOSEST * radius);
    let offset = points.offsets(slopes, distance);
    Ok(Camera {
        name: NAME.into(),
        eye: center + right * offset[0] + up * offset[1] + back * distance,
        right,
        up,
        back,
        projection: Projection::Perspective { yfov: framing.fov },
        near: 0.9 * (distance - high),
        far: Some(1.1 * (distance - low)),
        designed: None,
    })
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

/// A scene's vertices in the camera's axes, about the scene's centre.
struct Points<'a> {
    scene: &'a Scene,
    center: DVec3,
    camera: DMat3,
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
        let instance = |instance: &super::Instance| {
            let mesh = &self.scene.meshes[instance.mesh as usize];
            let matrix = DMat4::from_mat3(self.camera)
                * DMat4::from_translation(-self.center)
                * instance.world;
            let add = |sum, &index: &u32| {
                let position = Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
                add(sum, matrix.transform_point3(position))
            };
            let chunk = |indices: &[u32]| indices.iter().fold(start, add);
            mesh.indices.par_chunks(1 << 14).map(chunk).reduce(|| start, &join)
        };
        self.scene.instances.par_iter().map(instance).reduce(|| start, &join)
    }

    /// Support along the horizontal and the vertical axis for slopes `k`.
    fn support(&self, k: [f64; 2]) -> [Support; 2] {
        self.fold(
            [Support::NONE; 2],
            |[x, y], p| [x.with(p.x, p.z, k[0]), y.with(p.y, p.z, k[1])],
            |a, b| [a[0].max(b[0]), a[1].max(b[1])],
        )
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
mod tests {
    use super::*;
    use crate::scene::{Instance, Material, Mesh, Vertex};
    use bytemuck::Zeroable;
    use proptest::prelude::*;

    /// A scene whose triangles are the points three by three.
    fn scene(points: &[[f32; 3]], world: DMat4) -> Scene {
        let vertex = |&position: &[f32; 3]| Vertex { position, ..Vertex::zeroed() };
        let mesh = Mesh {
            vertices: points.iter().map(vertex).collect(),
            indices: (0..points.len() as u32 / 3 * 3).collect(),
            ..Mesh::default()
        };
        let instance = Instance { name: String::new(), mesh: 0, world, first_polygon: 1 };
        Scene {
            meshes: vec![mesh],
            materials: vec![Material::default()],
            instances: vec![instance],
            ..Scene::default()
        }
    }

    /// Smallest and largest picture coordinates, −1..1 across the picture.
    fn projected(scene: &Scene, camera: &Camera, aspect: f64) -> [[f64; 2]; 2] {
        let Projection::Perspective { yfov } = camera.projection else { unreachable!() };
        let half = (yfov / 2.0).tan();
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let mesh = &scene.meshes[0];
        for &index in &mesh.indices {
            let position = Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
            let p = scene.instances[0].world.transform_point3(position) - camera.eye;
            let depth = -p.dot(camera.back);
            assert!(depth > camera.near && depth < camera.far.unwrap_or(f64::INFINITY));
            let at =
                [p.dot(camera.right) / (depth * half * aspect), p.dot(camera.up) / (depth * half)];
            for (bound, at) in bounds.iter_mut().zip(at) {
                *bound = [bound[0].min(at), bound[1].max(at)];
            }
        }
        bounds
    }

    fn assert_framed(scene: &Scene, framing: &Framing, aspect: f64) {
        let camera = frame(scene, framing, aspect).expect("the scene has extent");
        let limits = projected(scene, &camera, aspect);
        let sizes = limits.map(|[low, high]| (high - low) / 2.0);
        let largest = sizes[0].max(sizes[1]);
        let (_, radius) = bounds(scene).expect("the scene has extent");
        let closest = camera.near < 0.901 * CLOSEST * radius;
        let fills = (largest - framing.fill).abs() < 1e-3;
        assert!(fills || closest && largest < framing.fill, "{limits:?}");
        for [low, high] in limits {
            assert!((low + high).abs() < 1e-3, "{limits:?}");
        }
        let axes = DMat3::from_cols(camera.right, camera.up, camera.back);
        assert!((axes.determinant() - 1.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn scenes_fill_the_picture_and_stand_in_its_middle(
            points in prop::collection::vec(prop::array::uniform3(-1f32..1.0), 6..40),
            flat in prop::option::of(0usize..3),
            azimuth in -7.0..7.0,
            elevation in prop_oneof![Just(-90.0), Just(90.0), -90.0..90.0],
            fov in 1.0..150.0,
            fill in 0.1..1.0,
            aspect in 0.2..5.0,
            exponent in -12i32..12,
            shift in prop::array::uniform3(-3.0..3.0),
        ) {
            let mut points = points;
            if let Some(axis) = flat {
                points.iter_mut().for_each(|p| p[axis] = 0.25);
            }
            let unit = 10f64.powi(exponent);
            let world = DMat4::from_scale(DVec3::splat(unit)) * DMat4::from_translation(shift.into());
            let (elevation, fov) = (f64::to_radians(elevation), f64::to_radians(fov));
            let framing = Framing { azimuth, elevation, fov, fill };
            assert_framed(&scene(&points, world), &framing, aspect);
        }
    }

    #[test]
    fn azimuth_turns_to_the_right_and_elevation_up() {
        let cube = [[-1., -1., -1.], [1., 1., 1.], [1., -1., 1.]];
        let scene = scene(&cube, DMat4::IDENTITY);
        let back = |azimuth: f64, elevation: f64| {
            let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
            let framing = Framing { azimuth, elevation, ..Framing::default() };
            frame(&scene, &framing, 1.0).expect("the scene has extent").back
        };
        assert!(back(0.0, 0.0).abs_diff_eq(DVec3::Z, 1e-12));
        assert!(back(90.0, 0.0).abs_diff_eq(DVec3::X, 1e-12));
        assert!(back(45.0, 90.0).abs_diff_eq(DVec3::Y, 1e-12));
    }

    #[test]
    fn a_line_along_the_view_is_seen_from_before_it() {
        let line = [[0., 0., -1.], [0., 0., 0.], [0., 0., 1.]];
        let framing = Framing { azimuth: 0.0, elevation: 0.0, ..Framing::default() };
        let camera = frame(&scene(&line, DMat4::IDENTITY), &framing, 1.0).expect("it has extent");
        assert!(camera.eye.z > 1.0 && camera.near > 0.0);
    }

    #[test]
    fn values_out_of_range_are_refused() {
        let triangle = scene(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], DMat4::IDENTITY);
        let default = Framing::default();
        for framing in [
            Framing { azimuth: f64::NAN, ..default },
            Framing { elevation: 2.0, ..default },
            Framing { fov: 0.0, ..default },
            Framing { fov: 3.2, ..default },
            Framing { fill: 1.1, ..default },
        ] {
            assert!(matches!(frame(&triangle, &framing, 1.0), Err(Error::Argument(_))));
        }
        assert!(frame(&triangle, &default, 0.0).is_err());
        assert!(frame(&Scene::default(), &default, 1.0).is_err());
    }
}
