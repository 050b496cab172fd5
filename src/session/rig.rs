//! Rigs that klieg wrote as JSON.

use super::input;
use crate::lighting::{Color, Cone, Light, LightKind, Rig, Role, check_number};
use crate::scene::view::View;
use crate::{Error, Result};
use glam::DVec3;
use serde::Deserialize;
use std::path::Path;

/// Most bytes of a rig's file.
const MAX_BYTES: u64 = 16 << 20;

/// A result with lights in it, or the lights alone.
#[derive(Deserialize)]
#[serde(untagged)]
enum File {
    Result { lights: Vec<Entry>, camera: Option<Axes> },
    Lights(Vec<Entry>),
}

/// The axes of the camera that world directions in a result are told beside.
#[derive(Deserialize)]
struct Axes {
    right: DVec3,
    up: DVec3,
    back: DVec3,
}

/// A light as [`crate::report::json::LightRecord`] writes it. Whatever else it has follows from this.
#[derive(Deserialize)]
struct Entry {
    elevation_deg: f32,
    azimuth_deg: f32,
    diffuse: f32,
    specular: Option<f32>,
    distance: Option<f32>,
    role: Option<Role>,
    kind: Option<LightKind>,
    color: Option<Color>,
    color_rgb: Option<[f32; 3]>,
    size: Option<f32>,
    cone_deg: Option<[f32; 2]>,
    axis: Option<DVec3>,
}

/// The rig in the file at `path`, in the light frame of `view`.
///
/// # Errors
/// [`Error::Input`] for a file that cannot be read, holds no lights, or one with a value out of its range, and
/// [`Error::Argument`] for more lights than a rig can have.
pub fn read(path: &Path, view: &View) -> Result<Rig> {
    let fault = |fault: &dyn std::fmt::Display| Error::input(input::name(path), fault);
    let text = input::text(path, MAX_BYTES)?;
    let file = serde_json::from_str(&text).map_err(|error: serde_json::Error| {
        fault(&format!("is neither a result of klieg nor an array of its lights: {error}"))
    })?;
    let (lights, camera) = match file {
        File::Result { lights, camera } => (lights, camera),
        File::Lights(lights) => (lights, None),
    };
    check_number(lights.len())?;
    let frame = &view.frame;
    let axes = camera.unwrap_or(Axes { right: frame.right, up: frame.up, back: frame.back });
    let light = |(index, entry): (usize, Entry)| {
        entry.light(index, &axes).map_err(|error| fault(&format!("lights[{index}]: {error}")))
    };
    lights.into_iter().enumerate().map(light).collect()
}

impl Entry {
    fn light(self, index: usize, axes: &Axes) -> Result<Light, String> {
        let kind = self.kind.unwrap_or_default();
        let distance = match (kind.parallel, self.distance) {
            (true, _) => 1.0,
            (false, Some(distance)) => distance,
            (false, None) => return Err("it has no distance".into()),
        };
        let [inner, outer] = self.cone_deg.map_or_else(
            || [Cone::default().inner, Cone::default().outer],
            |cone| cone.map(f32::to_radians),
        );
        let aim = self.axis.filter(|_| kind.cone).map(|axis| {
            DVec3::new(axis.dot(axes.right), axis.dot(axes.up), axis.dot(axes.back)).as_vec3()
        });
        let role = if index == 0 { Role::Key } else { Role::Fill };
        let light = Light {
            role: self.role.unwrap_or(role),
            kind,
            elevation: self.elevation_deg.to_radians(),
            azimuth: self.azimuth_deg.to_radians(),
            distance,
            diffuse: self.diffuse,
            specular: self.specular.unwrap_or(self.diffuse),
            color: self.color_rgb.and_then(Color::of_linear).or(self.color).unwrap_or_default(),
            size: self.size.unwrap_or(0.0),
            cone: Cone { inner, outer },
            aim,
        };
        check(&light).map(|()| light)
    }
}

/// # Errors
/// The first value out of its range.
pub fn check(light: &Light) -> Result<(), String> {
    let Light { elevation, azimuth, distance, diffuse, specular, size, cone, .. } = *light;
    let finite = |value: f32| value.is_finite();
    let positive = |value: f32| value.is_finite() && value >= 0.0;
    let right_angle = std::f32::consts::FRAC_PI_2 * (1.0 + 1e-6);
    let open = cone.inner >= 0.0 && cone.inner < cone.outer && cone.outer <= right_angle;
    for (name, valid) in [
        ("elevation_deg", finite(elevation)),
        ("azimuth_deg", finite(azimuth)),
        ("distance", finite(distance) && distance > 0.0),
        ("diffuse", positive(diffuse)),
        ("specular", positive(specular)),
        ("size", positive(size)),
        ("cone_deg", open),
        ("axis", light.aim.is_none_or(|aim| (aim.length() - 1.0).abs() < 1e-3)),
    ] {
        if !valid {
            return Err(format!("its {name} is out of its range"));
        }
    }
    Ok(())
}
