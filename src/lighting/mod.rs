//! Lights, rigs of lights, and how a surface looks under them.

pub mod clusters;
pub mod genome;
pub mod presets;
pub mod shading;

use crate::constants;
use crate::math::frame::Frame;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::{DVec4, Vec3};
use serde::{Deserialize, Serialize};

/// Lights that a rig can have at most.
pub const MAX_LIGHTS: usize = constants::MAX_LIGHTS as usize;

/// What a light is for; it decides the box of values that the search may give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// The main light, in front and above.
    Key,
    /// Softens the key's shadows, from the front.
    Fill,
    /// From behind, to draw the outline.
    Rim,
}

/// How a light reaches the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightKind {
    /// From a point at distance `R`, with falloff `(R/d)²`.
    #[default]
    Point,
    /// Parallel, without falloff.
    Directional,
}

/// A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// What it is for.
    pub role: Role,
    /// Point or directional.
    pub kind: LightKind,
    /// Elevation θ above the camera's horizontal plane, radians.
    pub elevation: f32,
    /// Azimuth φ, radians: 0 from the viewer, positive to the viewer's right.
    pub azimuth: f32,
    /// Distance `R` of a point light from the scene's centre, scene radii; a directional light has
    /// none and ignores it.
    pub distance: f32,
    /// Diffuse intensity `Id`.
    pub diffuse: f32,
    /// Specular intensity `Is`.
    pub specular: f32,
}

impl Light {
    /// Unit vector `u = (cosθ·sinφ, sinθ, cosθ·cosφ)` from the scene's centre towards the light.
    pub fn direction(&self) -> Vec3 {
        direction(self.elevation, self.azimuth)
    }

    /// Where the light is in the world: `(position, 1)` of a point light, `(unit direction towards it, 0)`
    /// of a directional one. A point light's falloff is 1 at [`Light::distance`] times the frame's radius.
    pub fn to_world(&self, frame: &Frame) -> DVec4 {
        let direction = self.direction().as_dvec3();
        match self.kind {
            LightKind::Point => {
                frame.point_to_world(direction * f64::from(self.distance)).extend(1.0)
            }
            LightKind::Directional => frame.direction_to_world(direction).extend(0.0),
        }
    }

    /// Physical intensity of the diffuse part: a white diffuse surface that faces the light at the scene's
    /// centre has the radiance `E/π = Id`, so it is `π·Id` lux of a directional light and `π·Id·R²` candela
    /// of a point light, `R` in world units.
    pub fn intensity(&self, frame: &Frame) -> f64 {
        let area = match self.kind {
            LightKind::Point => (f64::from(self.distance) * frame.radius).powi(2),
            LightKind::Directional => 1.0,
        };
        std::f64::consts::PI * f64::from(self.diffuse) * area
    }

    /// The light of the frame `from` in the frame `to`: a point light keeps its place in the world, a
    /// directional one its direction there. The intensities stay as they are; a point light at the very
    /// centre of `to` keeps its angles.
    pub fn moved(&self, from: &Frame, to: &Frame) -> Self {
        let place = (to.from_world() * self.to_world(from)).truncate();
        let distance = match self.kind {
            LightKind::Point => place.length() as f32,
            LightKind::Directional => self.distance,
        };
        let towards = place.try_normalize().unwrap_or(self.direction().as_dvec3());
        let (elevation, azimuth) = angles(towards.as_vec3());
        Self { elevation, azimuth, distance, ..*self }
    }

    /// What the evaluators read.
    pub fn record(&self) -> LightRecord {
        let (reach, radius2) = match self.kind {
            LightKind::Point => (self.distance, self.distance * self.distance),
            LightKind::Directional => (1.0, 0.0),
        };
        LightRecord {
            position: (self.direction() * reach).to_array(),
            radius2,
            diffuse: self.diffuse,
            specular: self.specular,
            key: if self.role == Role::Key { 1.0 } else { 0.0 },
            ..LightRecord::DARK
        }
    }
}

/// Unit vector of an elevation and an azimuth, radians, in the light frame.
pub fn direction(elevation: f32, azimuth: f32) -> Vec3 {
    let (sin_el, cos_el) = elevation.sin_cos();
    let (sin_az, cos_az) = azimuth.sin_cos();
    Vec3::new(cos_el * sin_az, sin_el, cos_el * cos_az)
}

/// Elevation and azimuth, radians, of a direction in the light frame.
pub fn angles(direction: Vec3) -> (f32, f32) {
    let elevation = direction.y.atan2(direction.x.hypot(direction.z));
    (elevation, direction.x.atan2(direction.z))
}

/// The lights of one individual.
pub type Rig = Vec<Light>;

/// A light as both evaluators read it, 64 bytes: four `vec4` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LightRecord {
    /// Where a light stands, or the unit direction towards a directional one; light frame.
    pub position: [f32; 3],
    /// `R²` of a light that stands somewhere, so that its falloff is `radius2 / d²`; 0 marks a
    /// directional light.
    pub radius2: f32,
    /// `Id`.
    pub diffuse: f32,
    /// `Is`.
    pub specular: f32,
    /// A spot's angular falloff is `clamp(cosine·cone_scale + cone_offset, 0, 1)²` with the cosine
    /// between its axis and the way to the point (KHR_lights_punctual); 0 and 1 without a cone.
    pub cone_scale: f32,
    /// See `cone_scale`.
    pub cone_offset: f32,
    /// Linear RGB that both intensities are multiplied with; its luminance is 1.
    pub color: [f32; 3],
    /// Radius of the light itself, scene radii: its softness.
    pub size: f32,
    /// Unit vector along a spot's axis, away from the light; light frame.
    pub axis: [f32; 3],
    /// 1 for a key light, 0 for all others.
    pub key: f32,
}

impl LightRecord {
    /// A white directional light without intensity, from the viewer.
    pub const DARK: Self = Self {
        position: [0.0, 0.0, 1.0],
        radius2: 0.0,
        diffuse: 0.0,
        specular: 0.0,
        cone_scale: 0.0,
        cone_offset: 1.0,
        color: [1.0; 3],
        size: 0.0,
        axis: [0.0, 0.0, -1.0],
        key: 0.0,
    };

    /// Whether it is white and has no cone, so that luminances alone tell the picture's brightness.
    pub fn is_plain(&self) -> bool {
        self.color == [1.0; 3] && self.cone_scale == 0.0
    }
}

/// # Errors
/// [`Error::Argument`] unless `lights` is 1..=[`MAX_LIGHTS`].
pub(crate) fn check_number(lights: usize) -> Result<()> {
    if (1..=MAX_LIGHTS).contains(&lights) {
        Ok(())
    } else {
        Err(Error::Argument(format!("{lights} lights: a rig has 1 to {MAX_LIGHTS} of them")))
    }
}

/// Rigs to be evaluated together, all with the same number of lights.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    lights: usize,
    records: Vec<LightRecord>,
}

impl Population {
    /// An empty population of rigs of `lights` lights.
    ///
    /// # Errors
    /// [`Error::Argument`] unless `lights` is 1..=[`MAX_LIGHTS`].
    pub fn new(lights: usize) -> Result<Self> {
        check_number(lights)?;
        Ok(Self { lights, records: Vec::new() })
    }

    /// A population of the given rigs.
    ///
    /// # Errors
    /// As [`Population::new`] and [`Population::push`]; no rigs at all are an error too.
    pub fn of<'a>(rigs: impl IntoIterator<Item = &'a [Light]>) -> Result<Self> {
        let mut rigs = rigs.into_iter().peekable();
        let lights = rigs.peek().map_or(0, |rig| rig.len());
        let mut population = Self::new(lights)?;
        for rig in rigs {
            population.push(rig)?;
        }
        Ok(population)
    }

    /// A population of rigs of `lights` lights each, in the form that evaluators read.
    ///
    /// # Errors
    /// As [`Population::new`]; a number of records that makes no whole rigs is an error too.
    pub fn of_records(lights: usize, records: Vec<LightRecord>) -> Result<Self> {
        check_number(lights)?;
        if !records.len().is_multiple_of(lights) {
            let fault = format!("{} lights do not make rigs of {lights}", records.len());
            return Err(Error::Argument(fault));
        }
        Ok(Self { lights, records })
    }

    /// Adds a rig.
    ///
    /// # Errors
    /// [`Error::Argument`] when it has another number of lights than the population.
    pub fn push(&mut self, rig: &[Light]) -> Result<()> {
        if rig.len() != self.lights {
            return Err(Error::Argument(format!(
                "a rig of {} lights in a population of rigs of {}",
                rig.len(),
                self.lights
            )));
        }
        self.records.extend(rig.iter().map(Light::record));
        Ok(())
    }

    /// Takes all rigs out, keeping the memory.
    pub fn clear(&mut self) {
        self.records.clear();
    }

    /// Lights of each rig.
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// Number of rigs.
    pub fn len(&self) -> usize {
        self.records.len() / self.lights
    }

    /// Whether there is no rig.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// All lights, rig after rig: `len() · lights()` records.
    pub fn records(&self) -> &[LightRecord] {
        &self.records
    }

    /// Whether all lights are white and none has a cone ([`LightRecord::is_plain`]).
    pub fn is_plain(&self) -> bool {
        self.records.iter().all(LightRecord::is_plain)
    }

    /// The lights of each rig.
    pub fn rigs(&self) -> std::slice::ChunksExact<'_, LightRecord> {
        self.records.chunks_exact(self.lights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn lights_stand_in_the_world_where_their_frame_says() {
        // A viewer on the x axis, whose right is −z.
        let frame = Frame {
            center: DVec3::new(1.0, 2.0, 3.0),
            radius: 10.0,
            right: DVec3::NEG_Z,
            up: DVec3::Y,
            back: DVec3::X,
        };
        let light = Light {
            role: Role::Key,
            kind: LightKind::Point,
            elevation: 0.0,
            azimuth: std::f32::consts::FRAC_PI_2,
            distance: 2.0,
            diffuse: 1.0,
            specular: 1.0,
        };
        let expected = DVec4::new(1.0, 2.0, -17.0, 1.0);
        assert!(light.to_world(&frame).abs_diff_eq(expected, 1e-5));
        let parallel = Light { kind: LightKind::Directional, ..light };
        let pi = std::f64::consts::PI;
        assert_eq!([light, parallel].map(|light| light.intensity(&frame)), [pi * 400.0, pi]);
        assert!(parallel.to_world(&frame).abs_diff_eq(DVec4::NEG_Z, 1e-6));
        let above = Light { elevation: std::f32::consts::FRAC_PI_2, ..parallel };
        assert!(above.to_world(&frame).abs_diff_eq(DVec4::Y, 1e-6));
    }
}
