//! Between what messages say and what klieg computes with.

use super::messages::{Camera, Light, Look, Targets};
use crate::lighting::{self, Color, Cone, MAX_LIGHTS, Rig, angles};
use crate::objective::{MeanTarget, Objective};
use crate::scene::view::{self, Projection};
use crate::scene::{Scene, camera};
use crate::session::rig::check;
use crate::{Error, Result};
use glam::{DVec3, Vec3};

/// Elevations nearer to the poles leave no way upwards, degrees.
const STEEPEST: f64 = 89.99;

/// Nearest that an orbit comes to its target, scene radii.
const CLOSEST: f64 = 1e-3;

impl Light {
    /// A light as messages say it.
    pub fn of(light: &lighting::Light) -> Self {
        Self {
            role: light.role,
            kind: light.kind,
            direction: light.direction().to_array(),
            distance: light.distance,
            diffuse: light.diffuse,
            specular: light.specular,
            color: light.color.linear(),
            size: light.size,
            cone: [light.cone.inner, light.cone.outer].map(f32::to_degrees),
            aim: light.aim.map(|aim| aim.to_array()),
            locked: false,
        }
    }

    /// All lights of a rig.
    pub fn all(rig: &[lighting::Light]) -> Vec<Self> {
        rig.iter().map(Self::of).collect()
    }

    /// The light.
    ///
    /// # Errors
    /// The first value out of its range.
    fn light(&self) -> Result<lighting::Light, String> {
        let direction = Vec3::from(self.direction).try_normalize();
        let (elevation, azimuth) = angles(direction.ok_or("its direction has no length")?);
        let [inner, outer] = self.cone.map(f32::to_radians);
        let aim = match self.aim.map(Vec3::from).filter(|_| self.kind.cone) {
            Some(aim) => Some(aim.try_normalize().ok_or("its aim has no length")?),
            None => None,
        };
        let light = lighting::Light {
            role: self.role,
            kind: self.kind,
            elevation,
            azimuth,
            distance: self.distance,
            diffuse: self.diffuse,
            specular: self.specular,
            color: Color::of_linear(self.color).ok_or("its color is black or out of its range")?,
            size: self.size,
            cone: Cone { inner, outer },
            aim,
        };
        check(&light).map(|()| light)
    }
}

/// The rig of the lights.
///
/// # Errors
/// [`Error::Argument`] that names the first light that cannot be, and for none or too many.
pub fn rig(lights: &[Light]) -> Result<Rig> {
    let count = lights.len();
    if !(1..=MAX_LIGHTS).contains(&count) {
        return Err(Error::Argument(format!("{count} lights: there must be 1 to {MAX_LIGHTS}")));
    }
    let light = |(index, light): (usize, &Light)| {
        light.light().map_err(|fault| Error::Argument(format!("lights[{index}]: {fault}")))
    };
    lights.iter().enumerate().map(light).collect()
}

/// The light of that number.
///
/// # Errors
/// [`Error::Argument`] where there is none.
pub fn chosen(rig: &[lighting::Light], number: u32) -> Result<lighting::Light> {
    let fault = || Error::Argument(format!("there is no light {number} among {}", rig.len()));
    rig.get(number as usize).copied().ok_or_else(fault)
}

impl Targets {
    /// Those of an objective.
    pub fn of(objective: &Objective) -> Self {
        let mean = match objective.mean_target {
            MeanTarget::Value(value) => Some(value),
            MeanTarget::Scene => None,
        };
        Self { mean, stops: objective.mean_stops, spread: objective.spread_target }
    }
}

impl Look {
    /// What pictures are judged by: `usual` with the weights and targets of this.
    ///
    /// # Errors
    /// As [`Objective::check`] and [`Intent::check`](crate::design::Intent::check), and for weights of terms that need a
    /// target picture.
    pub fn objective(&self, usual: &Objective) -> Result<Objective> {
        let Targets { mean, stops, spread } = self.targets;
        let objective = Objective {
            weights: self.weights,
            mean_target: mean.map_or(MeanTarget::Scene, MeanTarget::Value),
            mean_stops: stops,
            spread_target: spread,
            ..*usual
        };
        self.intent.check()?;
        objective.check()?;
        objective.check_without_target()?;
        Ok(objective)
    }
}

/// The camera of a scene with these bounds: its centre and its radius.
///
/// # Errors
/// [`Error::Argument`] for a camera that is not there or shows nothing.
pub fn camera_of(
    said: &Camera,
    scene: &Scene,
    (center, radius): (DVec3, f64),
) -> Result<view::Camera> {
    if let Some(name) = &said.named {
        return camera::choose(scene, name);
    }
    let target = DVec3::from(said.target);
    let distance = said.distance.max(CLOSEST) * radius;
    let elevation = said.elevation.clamp(-STEEPEST, STEEPEST).to_radians();
    let (sin, cos) = said.azimuth.to_radians().sin_cos();
    let (rise, level) = elevation.sin_cos();
    let back = DVec3::new(level * sin, rise, level * cos);
    let yfov = said.yfov.to_radians();
    if !said.orthographic {
        let lens = Projection::Perspective { yfov };
        return view::Camera::look_at(target + back * distance, target, DVec3::Y, lens);
    }
    // From outside of the scene, so that nothing of it is behind the eye.
    let away = radius + target.distance(center) + distance;
    let lens = Projection::Orthographic { ymag: distance * (0.5 * yfov).tan() };
    view::Camera::look_at(target + back * away, target, DVec3::Y, lens)
}

/// The nearest that an orbit has to a camera: it looks at the point on the camera's axis that is nearest to the scene's
/// centre.
pub fn orbit(camera: &view::Camera, (center, radius): (DVec3, f64)) -> Camera {
    let back = camera.back;
    let along = (camera.eye - center).dot(back).max(CLOSEST * radius);
    let (yfov, distance) = match camera.projection {
        Projection::Perspective { yfov } => (yfov, along),
        Projection::Orthographic { ymag } => {
            let yfov = 35f64.to_radians();
            (yfov, ymag / (0.5 * yfov).tan())
        }
    };
    Camera {
        target: (camera.eye - back * along).to_array(),
        azimuth: back.x.atan2(back.z).to_degrees(),
        elevation: back.y.clamp(-1.0, 1.0).asin().to_degrees(),
        distance: distance / radius,
        yfov: yfov.to_degrees(),
        orthographic: matches!(camera.projection, Projection::Orthographic { .. }),
        named: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::{LightKind, Role};
    use crate::scene::framing::{Framing, frame};
    use crate::scene::load::load;
    use crate::scene::view::{View, bounds};
    use std::path::Path;

    fn scene() -> Scene {
        load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb")).unwrap()
    }

    #[test]
    fn lights_go_out_and_come_back() {
        let light = lighting::Light {
            role: Role::Rim,
            kind: LightKind::SPOT,
            elevation: 0.4,
            azimuth: -2.0,
            distance: 3.0,
            diffuse: 0.5,
            specular: 0.7,
            color: Color::of_linear([1.0, 0.5, 0.2]).unwrap(),
            size: 0.1,
            cone: Cone { inner: 0.2, outer: 0.6 },
            aim: Some(Vec3::NEG_Y),
        };
        let back = rig(&[Light::of(&light)]).unwrap()[0];
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
        assert!(near(back.elevation, light.elevation) && near(back.azimuth, light.azimuth));
        assert!(near(back.cone.outer, light.cone.outer) && back.aim == light.aim);
        assert!(near(back.color.linear()[0], light.color.linear()[0]) && back.role == light.role);
    }

    #[test]
    fn lights_that_cannot_be_are_refused() {
        let good = Light::of(&lighting::Light::default());
        type Spoil = fn(&mut Light);
        let faults: [(&str, Spoil); 5] = [
            ("direction", |light| light.direction = [0.0; 3]),
            ("color", |light| light.color = [0.0; 3]),
            ("distance", |light| light.distance = -1.0),
            ("diffuse", |light| light.diffuse = f32::NAN),
            ("cone", |light| light.cone = [50.0, 40.0]),
        ];
        for (word, spoil) in faults {
            let mut light = good.clone();
            spoil(&mut light);
            let fault = rig(&[good.clone(), light]).unwrap_err().to_string();
            assert!(fault.contains("lights[1]") && fault.contains(word), "{fault}");
        }
        assert!(rig(&[]).is_err() && rig(&vec![good; MAX_LIGHTS + 1]).is_err());
    }

    #[test]
    fn an_orbit_is_the_framing_that_it_was_made_of() {
        let scene = scene();
        let bounds = bounds(&scene).unwrap();
        let framed = frame(&scene, &Framing::default(), 1.0).unwrap();
        let said = orbit(&framed, bounds);
        let camera = camera_of(&said, &scene, bounds).unwrap();
        assert!(camera.eye.abs_diff_eq(framed.eye, 1e-9) && camera.up.abs_diff_eq(framed.up, 1e-9));
        assert!((said.azimuth - 30.0).abs() < 1e-9 && (said.elevation - 15.0).abs() < 1e-9);
        let flat = Camera { orthographic: true, ..said };
        let flat = camera_of(&flat, &scene, bounds).unwrap();
        assert!(View::new(&scene, flat, 8, 8).unwrap().is_orthographic());
    }

    #[test]
    fn cameras_that_show_nothing_are_refused() {
        let scene = scene();
        let bounds = bounds(&scene).unwrap();
        let said = orbit(&frame(&scene, &Framing::default(), 1.0).unwrap(), bounds);
        for spoiled in [
            Camera { yfov: 180.0, ..said.clone() },
            Camera { target: [f64::NAN, 0.0, 0.0], ..said.clone() },
            Camera { named: Some("nobody".into()), ..said.clone() },
        ] {
            assert!(camera_of(&spoiled, &scene, bounds).unwrap_err().is_input());
        }
        // From straight above there is a way upwards still.
        camera_of(&Camera { elevation: 90.0, ..said }, &scene, bounds).unwrap();
    }
}
