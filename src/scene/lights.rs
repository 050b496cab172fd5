//! A scene's own lights (KHR_lights_punctual) as a rig.

use super::view::View;
use super::{Scene, SceneLight};
use crate::lighting::{Color, Cone, Light, MAX_LIGHTS, Rig, Role, angles};
use crate::math::color::luminance;
use crate::{Error, Result};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;
use std::f64::consts::PI;

/// Lights of which none is klieg's: those further round than this stand behind and are rims.
const BEHIND: f32 = 100.0;
/// Relative change of an intensity up to which the pair in the extras holds as it stands.
const EDITED: f64 = 1e-3;
/// Distance of unit vectors up to which a spot counts as aimed at the scene's centre.
const CENTRED: f32 = 1e-4;

/// What klieg writes beside a light of a lit scene, as glTF has no place for it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct LightExtras {
    pub role: Role,
    pub diffuse: f32,
    pub specular: f32,
    #[serde(default, skip_serializing_if = "is_zero")]
    pub size: f32,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f32) -> bool {
    *value == 0.0
}

/// The lights of a scene that klieg did not write.
pub fn own(scene: &Scene) -> impl Iterator<Item = &SceneLight> {
    scene.lights.iter().filter(|light| klieg_block(light).is_none())
}

/// All lights of `scene` in the light frame of `view`, and what the rig could not take over, for people to
/// read.
///
/// The lights that klieg wrote come first, and the scene's own follow as [`Role::Scene`]. The diffuse
/// intensity undoes the one of [`lit::write`](super::lit::write); the specular one comes from the light's
/// extras, or is the same. Where a light that klieg wrote has another intensity, distance or colour by now,
/// both of its intensities scale with it. Where none is klieg's, all take their roles from where they
/// stand: the brightest is the key, those behind are rims, the rest fills.
///
/// # Errors
/// [`Error::Input`] when the scene has no lights or one without a meaning,
/// [`Error::Argument`] when it has more than [`MAX_LIGHTS`].
pub fn rig(scene: &Scene, view: &View) -> Result<(Rig, Vec<String>)> {
    if scene.lights.is_empty() {
        return Err(Error::input(&scene.path, "has no lights"));
    }
    if scene.lights.len() > MAX_LIGHTS {
        let (path, count) = (scene.path.display(), scene.lights.len());
        return Err(Error::Argument(format!(
            "{path} has {count} lights: there may be at most {MAX_LIGHTS}"
        )));
    }
    let written = scene.lights.iter().filter(|light| klieg_block(light).is_some());
    let (mut rig, mut warnings) = read_all(scene, view, written)?;
    let (own, more) = own_rig(scene, view)?;
    let has_written = !rig.is_empty();
    rig.extend(own);
    warnings.extend(more);
    if !has_written {
        assign_roles(&mut rig);
    }
    for light in rig.iter_mut().filter(|light| light.role == Role::Rim && light.azimuth < 0.0) {
        light.azimuth += TAU; // a rim's azimuths run from one side round the back to the other
    }
    Ok((rig, warnings))
}

/// The lights of [`own`] as [`Role::Scene`], none where there are none, and warnings as [`rig`] has them.
///
/// # Errors
/// [`Error::Input`] for a light without a meaning.
pub fn own_rig(scene: &Scene, view: &View) -> Result<(Rig, Vec<String>)> {
    read_all(scene, view, own(scene))
}

fn read_all<'a>(
    scene: &Scene,
    view: &View,
    lights: impl Iterator<Item = &'a SceneLight>,
) -> Result<(Rig, Vec<String>)> {
    let mut warnings = Vec::new();
    let mut rig = Rig::new();
    for light in lights {
        let fault = |fault: String| Error::input(&scene.path, format!("{} {fault}", title(light)));
        rig.push(read(light, view).map_err(fault)?);
        if let Some(range) = light.range {
            warnings.push(format!(
                "{} has a range of {range}: klieg's falloff has no end",
                title(light)
            ));
        }
    }
    Ok((rig, warnings))
}

/// What klieg wrote beside a light.
fn klieg_block(light: &SceneLight) -> Option<&serde_json::Value> {
    light.klieg.as_ref()?.get("light")
}

fn title(light: &SceneLight) -> String {
    format!("light '{}'", light.name)
}

/// One light; its role is [`Role::Scene`] where klieg did not write it.
fn read(light: &SceneLight, view: &View) -> Result<Light, String> {
    let into_frame = view.frame.from_world();
    let kind = light.kind;
    let (towards, distance) = if kind.parallel {
        (into_frame.transform_vector3(-light.direction), 1.0)
    } else {
        let position = into_frame.transform_point3(light.position);
        (position, position.length())
    };
    let nowhere =
        if kind.parallel { "has no direction" } else { "stands at the scene's very centre" };
    let towards = towards.try_normalize().ok_or(nowhere)?.as_vec3();
    let (elevation, azimuth) = angles(towards);
    let area = if kind.parallel { 1.0 } else { (distance * view.frame.radius).powi(2) };
    let measured =
        f64::from(light.intensity) * f64::from(luminance(Vec3::from(light.color))) / (PI * area);
    if !(measured.is_finite() && measured >= 0.0) {
        return Err(format!("has the intensity {}", light.intensity));
    }
    let extras = match klieg_block(light) {
        Some(block) => scaled(parse(block)?, measured),
        None => {
            let intensity = measured as f32;
            LightExtras { role: Role::Scene, diffuse: intensity, specular: intensity, size: 0.0 }
        }
    };
    let LightExtras { role, diffuse, specular, size } = extras;
    let axis = into_frame.transform_vector3(light.direction).normalize_or_zero().as_vec3();
    Ok(Light {
        role,
        kind,
        elevation,
        azimuth,
        distance: distance as f32,
        diffuse,
        specular,
        // A black light has no colour, and no intensity either.
        color: Color::of_linear(light.color).unwrap_or_default(),
        size,
        cone: if kind.cone { light.cone } else { Cone::default() },
        aim: Some(axis).filter(|axis| kind.cone && axis.distance(-towards) > CENTRED),
    })
}

fn parse(block: &serde_json::Value) -> Result<LightExtras, String> {
    let extras = LightExtras::deserialize(block)
        .map_err(|error| format!("has extras that klieg did not write so: {error}"))?;
    let valid = |value: f32| value.is_finite() && value >= 0.0;
    if valid(extras.diffuse) && valid(extras.specular) && valid(extras.size) {
        Ok(extras)
    } else {
        Err("has a negative or infinite intensity or size in its extras".into())
    }
}

/// The written pair, scaled where the light's own intensity no longer agrees with it. A pair without
/// diffuse light has nothing to scale by and keeps its specular intensity.
fn scaled(written: LightExtras, measured: f64) -> LightExtras {
    let diffuse = f64::from(written.diffuse);
    if (measured - diffuse).abs() <= EDITED * diffuse {
        return written;
    }
    let factor = if diffuse > 0.0 { measured / diffuse } else { 1.0 };
    let specular = (f64::from(written.specular) * factor) as f32;
    LightExtras { diffuse: measured as f32, specular, ..written }
}

/// Roles for lights that have none: the brightest is the key, those behind are rims.
fn assign_roles(rig: &mut Rig) {
    for light in rig.iter_mut() {
        let behind = light.azimuth.abs() > BEHIND.to_radians();
        light.role = if behind { Role::Rim } else { Role::Fill };
    }
    // The first of several equally bright ones.
    let brightest = rig.iter_mut().rev().max_by(|a, b| a.diffuse.total_cmp(&b.diffuse));
    if let Some(brightest) = brightest {
        brightest.role = Role::Key;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::LightKind;
    use crate::math::frame::Frame;
    use crate::scene::view::{Camera, Projection};
    use glam::{DVec3, Mat4};
    use serde_json::json;

    /// A view along −X with the light frame at (1, 2, 3), two units to a radius.
    fn view() -> View {
        let (right, up, back) = (-DVec3::Z, DVec3::Y, DVec3::X);
        View {
            width: 4,
            height: 3,
            camera: Camera {
                name: String::new(),
                eye: DVec3::new(9.0, 2.0, 3.0),
                right,
                up,
                back,
                projection: Projection::Perspective { yfov: 0.6 },
                near: 0.1,
                far: None,
                designed: None,
            },
            frame: Frame { center: DVec3::new(1.0, 2.0, 3.0), radius: 2.0, right, up, back },
            eye: Vec3::new(0.0, 0.0, 4.0),
            clip_from_frame: Mat4::IDENTITY,
        }
    }

    fn light(kind: LightKind, position: DVec3, intensity: f64) -> SceneLight {
        SceneLight {
            name: "Lamp".into(),
            position,
            direction: -DVec3::X,
            kind,
            cone: Cone { inner: 0.25, outer: 0.5 },
            color: [1.0; 3],
            intensity: intensity as f32,
            range: None,
            klieg: None,
        }
    }

    fn written(diffuse: f32, specular: f32) -> Option<serde_json::Value> {
        Some(json!({ "light": { "role": "rim", "diffuse": diffuse, "specular": specular } }))
    }

    fn read_one(light: SceneLight) -> Light {
        let scene = Scene { lights: vec![light], ..Scene::default() };
        let (rig, warnings) = rig(&scene, &view()).expect("a rig");
        assert_eq!((rig.len(), warnings.len()), (1, 0), "{warnings:?}");
        rig[0]
    }

    /// Four units from the centre to the viewer's right: `R` = 2, φ = 90°.
    const BESIDE: DVec3 = DVec3::new(1.0, 2.0, -1.0);

    #[test]
    fn a_point_light_is_read_in_the_light_frame() {
        let light = read_one(light(LightKind::POINT, BESIDE, PI * 0.5 * 16.0));
        assert_eq!((light.role, light.kind), (Role::Key, LightKind::POINT));
        let values = [light.elevation, light.azimuth, light.distance, light.diffuse];
        let expected = [0.0, std::f32::consts::FRAC_PI_2, 2.0, 0.5];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{values:?}");
        assert_eq!(light.specular, light.diffuse);
    }

    #[test]
    fn a_directional_light_comes_from_where_it_does_not_shine() {
        let light = read_one(light(LightKind::DIRECTIONAL, BESIDE, PI));
        assert_eq!(
            (light.kind, light.elevation, light.azimuth),
            (LightKind::DIRECTIONAL, 0.0, 0.0)
        );
        assert!((light.diffuse - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_written_pair_holds_until_the_light_is_edited() {
        let with = |id: f64, klieg| {
            let light = light(LightKind::POINT, BESIDE, PI * id * 16.0);
            let light = read_one(SceneLight { klieg, ..light });
            assert_eq!(light.role, Role::Rim);
            (light.diffuse, light.specular)
        };
        assert_eq!(with(0.5, written(0.5, 0.7)), (0.5, 0.7));
        assert_eq!(with(0.5004, written(0.5, 0.7)), (0.5, 0.7));
        assert_eq!(with(0.0, written(0.0, 0.7)), (0.0, 0.7));
        let close = |a: (f32, f32), b: (f32, f32)| (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-5;
        assert!(close(with(1.0, written(0.5, 0.7)), (1.0, 1.4)));
        assert!(close(with(0.3, written(0.0, 0.7)), (0.3, 0.7)));
        assert_eq!(with(0.0, written(0.5, 0.7)), (0.0, 0.0));
    }

    #[test]
    fn klieg_s_lights_come_first_and_the_scene_s_own_follow() {
        let original = light(LightKind::POINT, BESIDE, 1e6);
        let klieg = SceneLight { klieg: written(0.0, 0.2), ..light(LightKind::POINT, BESIDE, 0.0) };
        let scene = Scene { lights: vec![original, klieg], ..Scene::default() };
        let (both, _) = rig(&scene, &view()).expect("a rig");
        let roles: Vec<_> = both.iter().map(|light| light.role).collect();
        assert_eq!(roles, [Role::Rim, Role::Scene]);
        assert_eq!(both[0].specular, 0.2);
        let (own, _) = own_rig(&scene, &view()).expect("a rig");
        assert_eq!(own, both[1..]);
        assert_eq!(own_rig(&Scene::default(), &view()).expect("a rig").0, []);
    }

    #[test]
    fn roles_of_unknown_lights_follow_from_their_places() {
        let at = |position, id: f64| light(LightKind::POINT, position, id);
        let behind = DVec3::new(-3.0, 2.0, 4.0);
        let lights = vec![at(BESIDE, 1.0), at(behind, 1.0), at(BESIDE, 9.0), at(BESIDE, 9.0)];
        let scene = Scene { lights, ..Scene::default() };
        let (rig, _) = rig(&scene, &view()).expect("a rig");
        let roles: Vec<_> = rig.iter().map(|light| light.role).collect();
        assert_eq!(roles, [Role::Fill, Role::Rim, Role::Key, Role::Fill]);
        assert!(rig[1].azimuth > 0.0 && (rig[1].direction().x + 0.242_535).abs() < 1e-5);
    }

    #[test]
    fn colours_and_cones_are_read() {
        let spot = light(LightKind::SPOT, BESIDE, PI * 16.0);
        let red = read_one(SceneLight { color: [1.0, 0.0, 0.0], ..spot.clone() });
        assert_eq!((red.kind, red.cone), (LightKind::SPOT, spot.cone));
        assert!((red.diffuse - 0.2126).abs() < 1e-5);
        assert_eq!(Some(red.color), Color::of_linear([0.5, 0.0, 0.0]));
        // It stands at the viewer's right and shines along −X, away from the viewer.
        let aim = red.aim.expect("an aim");
        assert!(aim.abs_diff_eq(Vec3::NEG_Z, 1e-6), "{aim}");
        let centred = read_one(SceneLight { direction: DVec3::Z, ..spot.clone() });
        assert_eq!((centred.aim, centred.axis()), (None, -centred.direction()));
        let black = read_one(SceneLight { color: [0.0; 3], ..spot });
        assert_eq!((black.diffuse, black.color), (0.0, Color::WHITE));
        let point = read_one(light(LightKind::POINT, BESIDE, 1.0));
        assert_eq!((point.aim, point.cone), (None, Cone::default()));
    }

    #[test]
    fn a_range_is_warned_of() {
        let lamp = SceneLight { range: Some(5.0), ..light(LightKind::POINT, BESIDE, 1.0) };
        let scene = Scene { lights: vec![lamp], ..Scene::default() };
        let (_, warnings) = rig(&scene, &view()).expect("a rig");
        assert!(warnings[0].contains("'Lamp' has a range of 5"), "{warnings:?}");
    }

    #[test]
    fn scenes_without_a_rig_are_refused() {
        let point = || light(LightKind::POINT, BESIDE, 1.0);
        let fails = |lights: Vec<SceneLight>, message: &str| {
            let scene = Scene { path: "a.glb".into(), lights, ..Scene::default() };
            let error = rig(&scene, &view()).expect_err(message);
            let text = error.to_string();
            assert!(error.is_input() && text.contains("a.glb") && text.contains(message), "{text}");
        };
        fails(vec![], "has no lights");
        fails(vec![point(); MAX_LIGHTS + 1], "17 lights");
        fails(vec![SceneLight { position: DVec3::new(1.0, 2.0, 3.0), ..point() }], "very centre");
        fails(vec![SceneLight { intensity: -1.0, ..point() }], "intensity -1");
        fails(vec![SceneLight { intensity: f32::INFINITY, ..point() }], "intensity inf");
        fails(vec![SceneLight { klieg: written(-1.0, 0.0), ..point() }], "negative");
        fails(vec![SceneLight { klieg: Some(json!({ "light": {} })), ..point() }], "role");
    }
}
