//! The file's cameras and how one is chosen, and cameras of engines.

use super::Scene;
use super::view::{Camera, DesignedView, Projection};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3, DVec4};
use gltf::json::camera::{Camera as Json, Type};
use gltf::json::validation::Checked;

/// The camera of `scene` that `selector` names, or else numbers from 0.
///
/// # Errors
/// [`Error::Argument`] that lists the cameras when there is no such one.
pub fn choose(scene: &Scene, selector: &str) -> Result<Camera> {
    let by_name = || scene.cameras.iter().find(|camera| camera.name == selector);
    let by_index = || scene.cameras.get(selector.parse::<usize>().ok()?);
    by_name().or_else(by_index).cloned().ok_or_else(|| {
        let names = scene.cameras.iter().enumerate();
        let names: Vec<_> = names.map(|(i, camera)| format!("{i} '{}'", camera.name)).collect();
        let path = scene.path.display();
        Error::Argument(match names.is_empty() {
            true => format!("there is no camera '{selector}': {path} has none"),
            false => {
                format!("there is no camera '{selector}': {path} has {}", names.join(", "))
            }
        })
    })
}

/// A glTF camera that stands at `world`, with the clipping planes that klieg designed for; the fault where it
/// cannot be used.
pub(super) fn convert(
    json: &Json,
    name: String,
    world: &DMat4,
    designed: Option<DesignedView>,
) -> std::result::Result<Camera, String> {
    let (projection, near, far) = lens(json)?;
    let judged = designed.and_then(|designed| designed.planes());
    let usable = judged.filter(|&(near, far)| check_lens(&projection, near, far).is_ok());
    let (near, far) = usable.unwrap_or((near, far));
    let (right, up, back) = axes(world).ok_or("its node has no orientation")?;
    let eye = world.w_axis.truncate();
    Ok(Camera { name, eye, right, up, back, projection, near, far, designed })
}

/// Lens, near and far plane (glTF 2.0, 3.10.3).
fn lens(json: &Json) -> std::result::Result<(Projection, f64, Option<f64>), String> {
    let (projection, near, far) = match (json.type_, &json.perspective, &json.orthographic) {
        (Checked::Valid(Type::Perspective), Some(lens), _) => {
            let projection = Projection::Perspective { yfov: f64::from(lens.yfov) };
            (projection, lens.znear, lens.zfar)
        }
        (Checked::Valid(Type::Orthographic), _, Some(lens)) => {
            let projection = Projection::Orthographic { ymag: f64::from(lens.ymag) };
            (projection, lens.znear, Some(lens.zfar))
        }
        _ => return Err("it is neither perspective nor orthographic".into()),
    };
    let (near, far) = (f64::from(near), far.map(f64::from));
    check_lens(&projection, near, far)?;
    Ok((projection, near, far))
}

/// The fault of a lens that shows nothing.
fn check_lens(
    projection: &Projection,
    near: f64,
    far: Option<f64>,
) -> std::result::Result<(), String> {
    let positive = |name: &str, value: f64| match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(format!("its {name} is {value}, which is not positive")),
    };
    match *projection {
        Projection::Perspective { yfov } => {
            positive("yfov", yfov)?;
            if yfov >= std::f64::consts::PI {
                return Err(format!("its yfov is {yfov}, which is not below π"));
            }
            positive("znear", near)?;
        }
        Projection::Orthographic { ymag } => {
            positive("ymag", ymag)?;
            if !(near.is_finite() && near >= 0.0) {
                return Err(format!("its znear is {near}, which is negative or not finite"));
            }
        }
    }
    let Some(far) = far else { return Ok(()) };
    positive("zfar", far)?;
    if far <= near {
        return Err(format!("its zfar {far} is not beyond its znear {near}"));
    }
    Ok(())
}

/// Orthonormal right, up and back axes of a node that looks along its −Z axis; `None` where the
/// node is flat.
pub(super) fn axes(world: &DMat4) -> Option<(DVec3, DVec3, DVec3)> {
    basis(world.y_axis.truncate(), world.z_axis.truncate())
}

/// Orthonormal right, up and back axes of what has `back` behind it and `up` above; `None` where
/// these are parallel or have no length.
fn basis(up: DVec3, back: DVec3) -> Option<(DVec3, DVec3, DVec3)> {
    let back = back.try_normalize()?;
    let right = up.try_normalize()?.cross(back).try_normalize()?;
    Some((right, back.cross(right), back))
}

/// Sine of the angle between two directions below which they count as parallel.
const PARALLEL: f64 = 1e-6;

/// Largest difference of a view matrix from a rigid one: the rounding of single precision.
const RIGID: f64 = 1e-3;

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` above; right handed, world units. Its near
    /// plane stands at a thousandth of the distance (an orthographic one's at the eye), and there is no
    /// far plane; both can be set.
    ///
    /// # Errors
    /// [`Error::Argument`] when something is not finite, `eye` is `target`, `up` is parallel to the
    /// view, or the lens shows nothing.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, projection: Projection) -> Result<Self> {
        let fault = |fault: &str| Error::Argument(format!("camera: {fault}"));
        if ![eye, target, up].iter().all(|v| v.is_finite()) {
            return Err(fault("eye, target and up must be finite"));
        }
        let distance = eye.distance(target);
        let back = (eye - target).try_normalize().ok_or_else(|| fault("eye and target are one"))?;
        let side = up.try_normalize().map_or(0.0, |up| up.cross(back).length());
        if side < PARALLEL {
            return Err(fault("up has no length or is parallel to the view"));
        }
        let near = match projection {
            Projection::Perspective { .. } => distance / 1000.0,
            Projection::Orthographic { .. } => 0.0,
        };
        Self::standing(eye, up, back, projection, near, None)
    }

    /// The camera of an engine's view matrix: eye from world space, right handed, looking along −Z,
    /// without scale. `near` and `far` are distances of the clipping planes, world units.
    ///
    /// # Errors
    /// [`Error::Argument`] when the matrix is not finite, scales, skews or mirrors, or the lens shows
    /// nothing.
    pub fn from_view(
        view: &DMat4,
        projection: Projection,
        near: f64,
        far: Option<f64>,
    ) -> Result<Self> {
        let linear = DMat3::from_mat4(*view);
        let rigid = (linear * linear.transpose()).abs_diff_eq(DMat3::IDENTITY, RIGID)
            && view.row(3).abs_diff_eq(DVec4::W, RIGID)
            && linear.determinant() > 0.0;
        if !(view.is_finite() && rigid) {
            let fault = "camera: the view matrix is not a rotation and a translation";
            return Err(Error::Argument(fault.into()));
        }
        let eye = -(linear.inverse() * view.w_axis.truncate());
        Self::standing(eye, linear.row(1), linear.row(2), projection, near, far)
    }

    fn standing(
        eye: DVec3,
        up: DVec3,
        back: DVec3,
        projection: Projection,
        near: f64,
        far: Option<f64>,
    ) -> Result<Self> {
        let fault = |fault: String| Error::Argument(format!("camera: {fault}"));
        check_lens(&projection, near, far).map_err(fault)?;
        let (right, up, back) =
            basis(up, back).ok_or_else(|| fault("it has no orientation".into()))?;
        let (name, designed) = ("engine".to_owned(), None);
        Ok(Self { name, eye, right, up, back, projection, near, far, designed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dcamera::rh::view::look_at_mat4;

    const LENS: Projection = Projection::Perspective { yfov: 0.7 };

    #[test]
    fn a_camera_looks_at_its_target_and_gives_its_view_matrix_back() {
        let (eye, target) = (DVec3::new(3.0, 4.0, -5.0), DVec3::new(1.0, -2.0, 0.5));
        let up = DVec3::new(0.1, 2.0, 0.3);
        let camera = Camera::look_at(eye, target, up, LENS).unwrap();
        // The same by another hand: glam's.
        let view = look_at_mat4(eye, target, up);
        let same = |camera: &Camera, view: &DMat4| {
            let rows = [camera.right, camera.up, camera.back];
            rows.iter().enumerate().all(|(i, row)| {
                view.row(i).truncate().abs_diff_eq(*row, 1e-12)
                    && (view.w_axis[i] + row.dot(camera.eye)).abs() < 1e-12
            })
        };
        assert!(same(&camera, &view));
        assert!(!same(&camera, &look_at_mat4(eye, target, DVec3::X)));
        assert_eq!((camera.near, camera.far), (eye.distance(target) / 1000.0, None));
        let again = Camera::from_view(&view, LENS, 0.1, Some(9.0)).unwrap();
        assert!(same(&again, &view) && (again.near, again.far) == (0.1, Some(9.0)));
    }

    #[test]
    fn cameras_that_see_nothing_are_refused() {
        let refused = |camera: Result<Camera>, words: &str| {
            let fault = camera.unwrap_err();
            assert!(matches!(fault, Error::Argument(_)), "{fault}");
            assert!(fault.to_string().contains(words), "{fault}");
        };
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        refused(Camera::look_at(x, x, y, LENS), "one");
        refused(Camera::look_at(y, o, y * 3.0, LENS), "parallel");
        refused(Camera::look_at(x, o, o, LENS), "parallel");
        refused(Camera::look_at(DVec3::NAN, o, y, LENS), "finite");
        refused(Camera::look_at(x, o, y, Projection::Perspective { yfov: 3.2 }), "yfov");
        refused(Camera::look_at(x, o, y, Projection::Orthographic { ymag: 0.0 }), "ymag");
        let view = |matrix| Camera::from_view(&matrix, LENS, 0.1, None);
        view(DMat4::IDENTITY).unwrap();
        refused(view(DMat4::from_scale(DVec3::splat(2.0))), "rotation");
        refused(view(DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0))), "rotation");
        refused(view(DMat4::NAN), "rotation");
        refused(Camera::from_view(&DMat4::IDENTITY, LENS, 0.0, None), "znear");
        refused(Camera::from_view(&DMat4::IDENTITY, LENS, 1.0, Some(1.0)), "zfar");
    }
}
