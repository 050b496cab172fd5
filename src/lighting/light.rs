//! A light.

use super::{Color, LightKind, LightRecord};
use crate::math::frame::Frame;
use glam::{DVec4, Vec3};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_PI_4;
use std::str::FromStr;

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
    /// Stands in the scene already: no search changes it.
    Scene,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Key, Self::Fill, Self::Rim, Self::Scene];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Key => "key",
            Self::Fill => "fill",
            Self::Rim => "rim",
            Self::Scene => "scene",
        }
    }
}

/// What a rig stands in while the view changes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stand {
    /// The world: lights stay in their places.
    #[default]
    World,
    /// The camera: lights go with it, as they stand in each view's light frame.
    Camera,
}

impl FromStr for Stand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = [Self::World, Self::Camera];
        let named = all.into_iter().find(|one| one.name() == text);
        named.ok_or_else(|| format!("'{text}' is neither {} nor {}", all[0].name(), all[1].name()))
    }
}

impl Stand {
    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::World => "world",
            Self::Camera => "camera",
        }
    }
}

/// The cone of a spot light: half angles from its axis, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Up to here it is fully bright; 0 or more.
    pub inner: f32,
    /// From here on there is no light; more than `inner`, π/2 at most.
    pub outer: f32,
}

impl Cone {
    /// Scale and offset of the angular falloff `clamp(cosine·scale + offset, 0, 1)²`
    /// (KHR_lights_punctual).
    pub fn falloff(&self) -> (f32, f32) {
        let (inner, outer) = (self.inner.cos(), self.outer.cos());
        let scale = 1.0 / (inner - outer).max(0.001);
        (scale, -outer * scale)
    }
}

impl Default for Cone {
    /// That of KHR_lights_punctual.
    fn default() -> Self {
        Self { inner: 0.0, outer: FRAC_PI_4 }
    }
}

/// A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// What it is for.
    pub role: Role,
    /// How it reaches the scene.
    pub kind: LightKind,
    /// Elevation θ above the camera's horizontal plane, radians.
    pub elevation: f32,
    /// Azimuth φ, radians: 0 from the viewer, positive to the viewer's right.
    pub azimuth: f32,
    /// Distance `R` from the scene's centre, scene radii; a parallel light has none and ignores it.
    pub distance: f32,
    /// Diffuse intensity `Id`.
    pub diffuse: f32,
    /// Specular intensity `Is`.
    pub specular: f32,
    /// Its colour, which both intensities are multiplied with.
    pub color: Color,
    /// Radius of the light itself, scene radii: 0 for hard shadows.
    pub size: f32,
    /// Where it shines, of a kind with a cone.
    pub cone: Cone,
    /// Unit axis of that cone, away from the light; `None` for towards the scene's centre.
    pub aim: Option<Vec3>,
}

impl Default for Light {
    /// A white key light of intensity 1, a scene radius from the centre towards the viewer.
    fn default() -> Self {
        Self {
            role: Role::Key,
            kind: LightKind::POINT,
            elevation: 0.0,
            azimuth: 0.0,
            distance: 1.0,
            diffuse: 1.0,
            specular: 1.0,
            color: Color::WHITE,
            size: 0.0,
            cone: Cone::default(),
            aim: None,
        }
    }
}

impl Light {
    /// Unit vector `u = (cosθ·sinφ, sinθ, cosθ·cosφ)` from the scene's centre towards the light.
    pub fn direction(&self) -> Vec3 {
        direction(self.elevation, self.azimuth)
    }

    /// Unit axis of its cone, away from the light.
    pub fn axis(&self) -> Vec3 {
        self.aim.unwrap_or(-self.direction())
    }

    /// Distance from the scene's centre, scene radii; none of a parallel light.
    pub fn reach(&self) -> Option<f32> {
        (!self.kind.parallel).then_some(self.distance)
    }

    /// Where the light is in the world: `(position, 1)`, or `(unit direction towards it, 0)` of a parallel
    /// one. The falloff with the distance is 1 at [`Light::distance`] times the frame's radius.
    pub fn to_world(&self, frame: &Frame) -> DVec4 {
        let direction = self.direction().as_dvec3();
        match self.reach() {
            Some(reach) => frame.point_to_world(direction * f64::from(reach)).extend(1.0),
            None => frame.direction_to_world(direction).extend(0.0),
        }
    }

    /// Physical intensity of the diffuse part: a white diffuse surface that faces the light at the scene's
    /// centre has the radiance `E/π = Id`, so it is `π·Id` lux of a parallel light and `π·Id·R²` candela
    /// of any other, `R` in world units.
    pub fn intensity(&self, frame: &Frame) -> f64 {
        let area = self.reach().map_or(1.0, |reach| (f64::from(reach) * frame.radius).powi(2));
        std::f64::consts::PI * f64::from(self.diffuse) * area
    }

    /// The light of the frame `from` in the frame `to`: it keeps its place and its axis in the world, a
    /// parallel one its direction there. The intensities stay as they are; a light at the very centre of
    /// `to` keeps its angles, and one that is aimed at the centre stays so.
    pub fn moved(&self, from: &Frame, to: &Frame) -> Self {
        let into = to.from_world();
        let place = (into * self.to_world(from)).truncate();
        let distance = self.reach().map_or(self.distance, |_| place.length() as f32);
        let towards = place.try_normalize().unwrap_or(self.direction().as_dvec3());
        let (elevation, azimuth) = angles(towards.as_vec3());
        let turned = |axis: Vec3| {
            let axis = into.transform_vector3(from.direction_to_world(axis.as_dvec3()));
            axis.normalize_or_zero().as_vec3()
        };
        let size = (f64::from(self.size) * (from.radius / to.radius)) as f32;
        Self { elevation, azimuth, distance, size, aim: self.aim.map(turned), ..*self }
    }

    /// The light on its way `towards` from a place, a unit vector and light frame, at its own distance from the scene's
    /// centre; one that cannot be there stands in that direction from the centre. What is aimed is aimed at the place.
    #[must_use]
    pub fn seen_from(&self, place: Vec3, towards: Vec3) -> Self {
        let stands = match self.reach() {
            None => towards,
            Some(reach) => {
                // |place + t·towards| = R, the farther one of both.
                let along = place.dot(towards);
                let root = along * along - place.length_squared() + reach * reach;
                if root > 0.0 { place + towards * (root.sqrt() - along) } else { towards }
            }
        };
        let (elevation, azimuth) = angles(stands);
        let aim = self.aim.map(|_| (place - stands).normalize_or(-towards));
        Self { elevation, azimuth, aim, ..*self }
    }

    /// What the evaluators read.
    pub fn record(&self) -> LightRecord {
        let (reach, radius2) = self.reach().map_or((1.0, 0.0), |reach| (reach, reach * reach));
        let plain = LightRecord {
            position: (self.direction() * reach).to_array(),
            radius2,
            diffuse: self.diffuse,
            specular: self.specular,
            color: self.color.linear(),
            size: self.size,
            key: if self.role == Role::Key { 1.0 } else { 0.0 },
            ..LightRecord::DARK
        };
        if !self.kind.cone {
            return plain;
        }
        let (cone_scale, cone_offset) = self.cone.falloff();
        LightRecord { cone_scale, cone_offset, axis: self.axis().to_array(), ..plain }
    }
}

/// Where light comes from whose highlight falls on a surface of the unit normal `n`, seen along the unit vector `v` towards
/// the viewer: `2(n·v)n − v` (Poulin and Fournier 1992).
pub fn mirrored(n: Vec3, v: Vec3) -> Vec3 {
    2.0 * n.dot(v) * n - v
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::shading::sample;
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
        let light =
            Light { azimuth: std::f32::consts::FRAC_PI_2, distance: 2.0, ..Light::default() };
        let expected = DVec4::new(1.0, 2.0, -17.0, 1.0);
        assert!(light.to_world(&frame).abs_diff_eq(expected, 1e-5));
        let parallel = Light { kind: LightKind::DIRECTIONAL, ..light };
        let pi = std::f64::consts::PI;
        assert_eq!([light, parallel].map(|light| light.intensity(&frame)), [pi * 400.0, pi]);
        assert!(parallel.to_world(&frame).abs_diff_eq(DVec4::NEG_Z, 1e-6));
        let above = Light { elevation: std::f32::consts::FRAC_PI_2, ..parallel };
        assert!(above.to_world(&frame).abs_diff_eq(DVec4::Y, 1e-6));
    }

    #[test]
    fn a_spot_lights_its_cone_alone() {
        let light = Light {
            kind: LightKind::SPOT,
            distance: 2.0,
            color: Color::of_linear([1.0, 0.5, 0.0]).unwrap(),
            cone: Cone { inner: 0.3, outer: 0.5 },
            ..Light::default()
        };
        let arriving = |light: &Light, angle: f32| {
            let p = Vec3::new(angle.tan(), 0.0, 0.0) * 2.0;
            sample(&light.record(), p).radiance * (p.length_squared() / 4.0 + 1.0)
        };
        let full = Vec3::from(light.color.linear());
        for (angle, share) in [(0.0, 1.0), (0.29, 1.0), (0.51, 0.0), (1.2, 0.0)] {
            let found = arriving(&light, angle);
            assert!(found.abs_diff_eq(full * share, 1e-5), "{angle}: {found}");
        }
        let between = arriving(&light, 0.4).x / full.x;
        let linear = (0.4f32.cos() - 0.5f32.cos()) / (0.3f32.cos() - 0.5f32.cos());
        assert!((between - linear * linear).abs() < 1e-4, "{between}");
        // Turned by 0.4 to the viewer's right, it lights there what it lit in the middle.
        let aim = Some(Vec3::new(0.4f32.sin(), 0.0, -0.4f32.cos()));
        let turned = Light { aim, ..light };
        assert!(arriving(&turned, 0.4).abs_diff_eq(full, 1e-5));
        assert!(arriving(&turned, 0.0).abs_diff_eq(arriving(&light, 0.4), 1e-5));
        // A point light has no cone, and a hard edge no quotient by nothing.
        let point = Light { kind: LightKind::POINT, ..light };
        assert!(arriving(&point, 1.2).abs_diff_eq(full, 1e-4));
        let hard = Light { cone: Cone { inner: 0.5, outer: 0.5 }, ..light };
        assert!(arriving(&hard, 0.49).is_finite() && arriving(&hard, 0.51) == Vec3::ZERO);
    }

    #[test]
    fn a_moved_light_stays_where_it_is_in_the_world() {
        let axes = |center, radius| Frame {
            center,
            radius,
            right: DVec3::X,
            up: DVec3::Y,
            back: DVec3::Z,
        };
        let from = axes(DVec3::ZERO, 2.0);
        let turned = Frame { right: DVec3::NEG_Z, back: DVec3::X, ..axes(DVec3::ONE, 4.0) };
        let aim = Some(Vec3::new(0.6, 0.0, -0.8));
        let kind = LightKind::SPOT;
        let light = Light { kind, azimuth: 0.5, distance: 3.0, size: 0.5, aim, ..Light::default() };
        let moved = light.moved(&from, &turned);
        assert!(moved.to_world(&turned).abs_diff_eq(light.to_world(&from), 1e-5));
        let world =
            |light: &Light, frame: &Frame| frame.direction_to_world(light.axis().as_dvec3());
        assert!(world(&moved, &turned).abs_diff_eq(world(&light, &from), 1e-6));
        assert_eq!(moved.size, 0.25);
        assert_eq!(Light { aim: None, ..light }.moved(&from, &turned).aim, None);
    }

    #[test]
    fn a_light_is_seen_from_a_place_in_the_direction_that_is_asked_for() {
        let (place, towards) = (Vec3::new(0.3, -0.2, 0.4), Vec3::new(0.6, 0.0, 0.8));
        let aim = Some(Vec3::NEG_Z);
        let light = Light { kind: LightKind::SPOT, distance: 3.0, aim, ..Light::default() };
        let seen = light.seen_from(place, towards);
        let stands = Vec3::from(seen.record().position);
        assert!((stands.length() - 3.0).abs() < 1e-5, "{stands}");
        assert!((stands - place).normalize().abs_diff_eq(towards, 1e-5), "{stands}");
        assert!(seen.axis().abs_diff_eq(-towards, 1e-5), "{}", seen.axis());
        let sun = Light { kind: LightKind::DIRECTIONAL, ..light }.seen_from(place, towards);
        assert!(sun.direction().abs_diff_eq(towards, 1e-6));
        // From outside of the sphere that it stands on, it may be in no such direction.
        let within = Light { distance: 0.4, ..light }.seen_from(0.9 * Vec3::Y, towards);
        assert!(within.direction().abs_diff_eq(towards, 1e-6));
    }
}
