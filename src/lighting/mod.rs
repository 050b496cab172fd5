//! Lights, rigs of lights, and how a surface looks under them.

pub mod clusters;
mod color;
pub mod genome;
pub mod kinds;
mod light;
pub mod presets;
pub mod shading;

pub use color::{Color, KELVIN};
pub use kinds::LightKind;
pub use light::{Cone, Light, Role, Stand, angles, direction, mirrored};

use crate::constants;
use crate::math::frame::Change;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Lights that a rig can have at most.
pub const MAX_LIGHTS: usize = constants::MAX_LIGHTS as usize;

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

    /// The same light in another light frame: it keeps its place, its direction and what it sends out in the world, so
    /// that it lights there what it lit here.
    #[must_use]
    pub fn moved(&self, change: &Change) -> Self {
        let turned = |v: [f32; 3]| (change.turn * Vec3::from(v).as_dvec3()).as_vec3().to_array();
        let turned = Self { position: turned(self.position), axis: turned(self.axis), ..*self };
        if self.radius2 == 0.0 {
            return turned;
        }
        let scaled = |value: f32, factor: f64| (f64::from(value) * factor) as f32;
        Self {
            position: change.point(Vec3::from(self.position).as_dvec3()).as_vec3().to_array(),
            radius2: scaled(self.radius2, change.scale * change.scale),
            size: scaled(self.size, change.scale),
            ..turned
        }
    }

    /// Whether it stands within the scene's ball, so that geometry may lie behind it too.
    pub fn is_near(&self) -> bool {
        let [x, y, z] = self.position;
        self.radius2 > 0.0 && x * x + y * y + z * z < 1.0
    }

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
        Err(Error::Argument(format!("{lights} lights: there must be 1 to {MAX_LIGHTS}")))
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
    use glam::{DMat3, DVec3};

    const POINT: LightRecord = LightRecord {
        position: [1.0, 2.0, 3.0],
        radius2: 9.0,
        size: 0.5,
        axis: [0.0, 0.0, -1.0],
        ..LightRecord::DARK
    };

    #[test]
    fn a_moved_light_keeps_its_place_and_what_it_sends_out_in_the_world() {
        // A quarter turn about the vertical: what was to the right is in front.
        let turn = DMat3::from_cols(-DVec3::Z, DVec3::Y, DVec3::X);
        let change = Change { turn, scale: 2.0, shift: DVec3::new(10.0, 20.0, 30.0) };
        let moved = POINT.moved(&change);
        let expected = LightRecord {
            position: [16.0, 24.0, 28.0],
            radius2: 36.0,
            size: 1.0,
            axis: [-1.0, 0.0, 0.0],
            ..POINT
        };
        assert_eq!(moved, expected);
        let sun = LightRecord { radius2: 0.0, ..POINT };
        let expected = LightRecord { position: [3.0, 2.0, -1.0], axis: [-1.0, 0.0, 0.0], ..sun };
        assert_eq!(sun.moved(&change), expected);
    }

    #[test]
    fn lights_within_the_ball_are_near_unless_they_come_from_a_direction() {
        let at = |position| LightRecord { position, ..POINT };
        for near in [[0.6, 0.0, 0.0], [0.0, -0.6, 0.0], [0.0, 0.0, 0.6], [0.5, 0.5, -0.5]] {
            assert!(at(near).is_near(), "{near:?}");
            assert!(!LightRecord { radius2: 0.0, ..at(near) }.is_near());
        }
        for far in [[0.8, 0.8, 0.0], [0.8, 0.0, 0.8], [0.0, -0.8, 0.8], [1.0, 0.0, 0.0]] {
            assert!(!at(far).is_near(), "{far:?}");
        }
    }

    #[test]
    fn white_lights_without_cones_are_plain() {
        assert!(POINT.is_plain());
        let warm = LightRecord { color: [1.0, 1.0, 0.9], ..POINT };
        let spot = LightRecord { cone_scale: 2.0, ..POINT };
        assert!(!warm.is_plain() && !spot.is_plain());
        let of = |records| Population::of_records(2, records).unwrap();
        assert!(of(vec![POINT, POINT]).is_plain());
        assert!(!of(vec![POINT, POINT, POINT, warm]).is_plain());
    }

    #[test]
    fn a_record_has_the_intensities_of_its_light() {
        let light = Light { diffuse: 0.3, specular: 0.6, role: Role::Key, ..Light::default() };
        let LightRecord { diffuse, specular, key, .. } = light.record();
        assert_eq!((diffuse, specular, key), (0.3, 0.6, 1.0));
        assert_eq!(Light { role: Role::Fill, ..light }.record().key, 0.0);
    }

    #[test]
    fn a_population_has_rigs_of_one_number_of_lights() {
        let mut population = Population::new(2).unwrap();
        assert!(population.is_empty() && population.rigs().next().is_none());
        let rig = [Light::default(), Light { distance: 4.0, ..Light::default() }];
        for _ in 0..3 {
            population.push(&rig).unwrap();
        }
        assert_eq!((population.len(), population.lights(), population.records().len()), (3, 2, 6));
        assert!(!population.is_empty());
        let records = rig.map(|light| light.record());
        assert!(population.rigs().all(|found| found == records));
        assert!(population.push(&rig[..1]).is_err());
        assert_eq!(population.len(), 3);
        assert_eq!(Population::of([&rig[..], &rig[..]]).unwrap().len(), 2);
        population.clear();
        assert!(population.is_empty() && population.lights() == 2);

        assert!(Population::of_records(2, vec![POINT; 3]).is_err());
        assert_eq!(Population::of_records(2, vec![POINT; 4]).unwrap().len(), 2);
        assert!(Population::new(0).is_err() && Population::new(MAX_LIGHTS + 1).is_err());
        assert_eq!(Population::new(MAX_LIGHTS).unwrap().lights(), MAX_LIGHTS);
        assert!(Population::of(Vec::<&[Light]>::new()).is_err());
    }
}
