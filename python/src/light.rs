//! Lights.

use crate::error::{OrRaise as _, refused};
use klieg::lighting::{self, Color, Cone, LightKind, Population, Role};
use klieg::report::json::LightRecord;
use klieg::scene::view::View;
use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

/// A light in the light frame; one of a result knows its place in the world.
#[pyclass(frozen, eq, module = "klieg._klieg", skip_from_py_object)]
#[derive(Clone, PartialEq)]
pub struct Light {
    /// The light.
    pub light: lighting::Light,
    position: Option<[f64; 3]>,
    axis: Option<[f64; 3]>,
    intensity: Option<f64>,
}

impl Light {
    /// The lights of a rig in the world of `view`.
    pub fn rig(rig: &[lighting::Light], view: &View) -> Vec<Self> {
        let light = |light: &lighting::Light| {
            let record = LightRecord::new(light, view);
            let place = light.to_world(&view.frame);
            let towards = |away: glam::DVec3| (-away).to_array();
            Self {
                light: *light,
                position: record.position.map(|position| position.to_array()),
                axis: match light.kind.parallel {
                    true => Some(towards(place.truncate())),
                    false => record.axis.map(|axis| axis.to_array()),
                },
                intensity: Some(light.intensity(&view.frame)),
            }
        };
        rig.iter().map(light).collect()
    }
}

/// The lights alone.
pub fn rig(lights: &[PyRef<'_, Light>]) -> lighting::Rig {
    lights.iter().map(|light| light.light).collect()
}

/// A role by its name.
pub fn role(name: &str) -> PyResult<Role> {
    Role::ALL.into_iter().find(|role| role.name() == name).ok_or_else(|| {
        let names = Role::ALL.map(Role::name).join(", ");
        refused(format!("'{name}' is no role of a light: there are {names}"))
    })
}

#[pymethods]
impl Light {
    /// Angles in degrees.
    #[new]
    #[expect(
        clippy::too_many_arguments,
        reason = "the values of a light, by position from one caller"
    )]
    fn new(
        elevation: f32,
        azimuth: f32,
        distance: f32,
        diffuse: f32,
        specular: f32,
        size: f32,
        color: &str,
        kind: &str,
        role: &str,
        cone: (f32, f32),
    ) -> PyResult<Self> {
        let light = lighting::Light {
            role: self::role(role)?,
            kind: LightKind::named(kind).or_raise()?,
            elevation: elevation.to_radians(),
            azimuth: azimuth.to_radians(),
            distance,
            diffuse,
            specular,
            color: color.parse::<Color>().map_err(refused)?,
            size,
            cone: Cone { inner: cone.0.to_radians(), outer: cone.1.to_radians() },
            aim: None,
        };
        klieg::session::rig::check(&light).map_err(|fault| refused(format!("a light: {fault}")))?;
        Ok(Self { light, position: None, axis: None, intensity: None })
    }

    #[getter]
    fn role(&self) -> &'static str {
        self.light.role.name()
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.light.kind.name
    }

    #[getter]
    fn color(&self) -> String {
        self.light.color.to_string()
    }

    #[getter]
    fn color_rgb(&self) -> (f32, f32, f32) {
        self.light.color.linear().into()
    }

    #[getter]
    fn elevation_deg(&self) -> f32 {
        self.light.elevation.to_degrees()
    }

    #[getter]
    fn azimuth_deg(&self) -> f32 {
        self.light.azimuth.to_degrees()
    }

    #[getter]
    fn distance(&self) -> Option<f32> {
        self.light.reach()
    }

    #[getter]
    fn diffuse(&self) -> f32 {
        self.light.diffuse
    }

    #[getter]
    fn specular(&self) -> f32 {
        self.light.specular
    }

    #[getter]
    fn size(&self) -> f32 {
        self.light.size
    }

    #[getter]
    fn cone_deg(&self) -> Option<(f32, f32)> {
        let Cone { inner, outer } = self.light.cone;
        self.light.kind.cone.then(|| (inner.to_degrees(), outer.to_degrees()))
    }

    #[getter]
    fn position(&self) -> Option<[f64; 3]> {
        self.position
    }

    #[getter]
    fn axis(&self) -> Option<[f64; 3]> {
        self.axis
    }

    #[getter]
    fn intensity(&self) -> Option<f64> {
        self.intensity
    }
}

/// The columns of an array of lights: five to begin with, then the size, then linear RGB.
const COLUMNS: [usize; 3] = [5, 6, 9];

/// The rigs of `float32[rigs, lights, columns]`, each with the lights that are `kept`.
pub fn population(
    array: &PyReadonlyArray3<'_, f32>,
    (kind, roles): (&str, Option<Vec<String>>),
    kept: &[lighting::Light],
) -> PyResult<Population> {
    let kind = LightKind::named(kind).or_raise()?;
    let array = array.as_array();
    let &[_, lights, columns] = array.shape() else {
        return Err(refused("lights have three axes"));
    };
    if !COLUMNS.contains(&columns) {
        return Err(refused(format!("{columns} columns of lights: there must be 5, 6 or 9")));
    }
    let roles = match roles {
        Some(names) if names.len() == lights => {
            names.iter().map(|name| role(name)).collect::<PyResult<Vec<_>>>()?
        }
        Some(names) => return Err(refused(format!("{} roles for {lights} lights", names.len()))),
        None => (0..lights).map(|i| if i == 0 { Role::Key } else { Role::Fill }).collect(),
    };
    let mut population = Population::new(lights + kept.len()).or_raise()?;
    for rig in array.outer_iter() {
        let light = |(values, role): (numpy::ndarray::ArrayView1<'_, f32>, &Role)| {
            let at = |i: usize| values.get(i).copied();
            let rgb = at(8).map(|blue| [values[6], values[7], blue]);
            let color = rgb.map_or(Some(Color::WHITE), Color::of_linear);
            let light = lighting::Light {
                role: *role,
                kind,
                elevation: values[0].to_radians(),
                azimuth: values[1].to_radians(),
                distance: values[2],
                diffuse: values[3],
                specular: values[4],
                size: at(5).unwrap_or(0.0),
                color: color.ok_or_else(|| refused("a light is black, or of no colour"))?,
                ..lighting::Light::default()
            };
            let fault = |fault| refused(format!("a light: {fault}"));
            klieg::session::rig::check(&light).map_err(fault).map(|()| light)
        };
        let rig = rig.outer_iter().zip(&roles).map(light).collect::<PyResult<Vec<_>>>()?;
        population.push(&[&rig, kept].concat()).or_raise()?;
    }
    Ok(population)
}
