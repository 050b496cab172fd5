//! Views.

use crate::error::{OrRaise as _, refused};
use crate::scene::Scene;
use crate::settings::Settings;
use glam::DMat4;
use klieg::scene::view::{self, Camera, Projection};
use klieg::session;
use pyo3::prelude::*;

/// A camera and a picture's size in a scene.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct View(pub view::View);

#[pymethods]
impl View {
    /// The view that the settings ask for.
    #[staticmethod]
    fn of_settings(py: Python<'_>, scene: &Scene, settings: &Settings) -> PyResult<Self> {
        let (scene, settings) = (&scene.loaded.scene, &settings.0.view);
        py.detach(|| session::view(scene, settings)).or_raise().map(Self)
    }

    /// The view of a matrix from world to eye space, and either an angle in radians or half a height in world units.
    #[staticmethod]
    #[expect(
        clippy::too_many_arguments,
        reason = "the values of a camera, by position from one caller"
    )]
    fn of_matrix(
        py: Python<'_>,
        scene: &Scene,
        matrix: [[f64; 4]; 4],
        yfov: Option<f64>,
        ymag: Option<f64>,
        near: f64,
        far: Option<f64>,
        size: (u32, u32),
    ) -> PyResult<Self> {
        let projection = match (yfov, ymag) {
            (Some(yfov), None) => Projection::Perspective { yfov },
            (None, Some(ymag)) => Projection::Orthographic { ymag },
            _ => return Err(refused("a camera has either a field of view or a half height")),
        };
        let matrix = DMat4::from_cols_array_2d(&matrix).transpose();
        let camera = Camera::from_view(&matrix, projection, near, far).or_raise()?;
        let scene = &scene.loaded.scene;
        py.detach(|| view::View::new(scene, camera, size.0, size.1)).or_raise().map(Self)
    }

    /// Width and height, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    /// The camera's name.
    #[getter]
    fn camera(&self) -> &str {
        &self.0.camera.name
    }

    /// Centre of the light frame, world units.
    #[getter]
    fn center(&self) -> [f64; 3] {
        self.0.frame.center.to_array()
    }

    /// Radius of the scene, world units.
    #[getter]
    fn radius(&self) -> f64 {
        self.0.frame.radius
    }

    /// Eye, and the axes to the right, up and back, world space.
    #[getter]
    fn pose(&self) -> ([f64; 3], [f64; 3], [f64; 3], [f64; 3]) {
        let Camera { eye, right, up, back, .. } = &self.0.camera;
        (eye.to_array(), right.to_array(), up.to_array(), back.to_array())
    }

    /// Field of view in radians, or nothing; half a height in world units, or nothing; near and far plane.
    #[getter]
    fn lens(&self) -> (Option<f64>, Option<f64>, f64, Option<f64>) {
        let camera = &self.0.camera;
        let (yfov, ymag) = match camera.projection {
            Projection::Perspective { yfov } => (Some(yfov), None),
            Projection::Orthographic { ymag } => (None, Some(ymag)),
        };
        (yfov, ymag, camera.near, camera.far)
    }
}
