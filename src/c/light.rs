//! Lights, the frame that they stand in, and where they are in the world.

use super::edge::{Fault, Outcome, array, choice, free_call, given, put, room};
use super::error::klieg_status;
use crate::lighting::presets::Preset;
use crate::lighting::{Color, Cone, Light, LightKind, MAX_LIGHTS, Population, Rig, Role};
use crate::math::frame::Frame;
use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Lights that a rig can have at most; the least is 1.
pub const KLIEG_MAX_LIGHTS: usize = 16;
const _: () = assert!(KLIEG_MAX_LIGHTS == MAX_LIGHTS);

/// What a light is for, which decides the values that a search may give it: one of `KLIEG_ROLE_...`.
pub type klieg_role = i32;
/// The main light, in front and above.
pub const KLIEG_ROLE_KEY: klieg_role = 0;
/// Softens the key's shadows, from the front.
pub const KLIEG_ROLE_FILL: klieg_role = 1;
/// From behind, to draw the outline.
pub const KLIEG_ROLE_RIM: klieg_role = 2;
/// Stands in the scene already: it can be evaluated, but no search changes it.
pub const KLIEG_ROLE_SCENE: klieg_role = 3;

/// How a light reaches the scene: one of `KLIEG_LIGHT_...`.
pub type klieg_light_kind = i32;
/// From a point at the distance R from the scene's centre, with falloff (R/d)².
pub const KLIEG_LIGHT_POINT: klieg_light_kind = 0;
/// Parallel, without falloff.
pub const KLIEG_LIGHT_DIRECTIONAL: klieg_light_kind = 1;
/// As a point light, within a cone.
pub const KLIEG_LIGHT_SPOT: klieg_light_kind = 2;

/// A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii. From
/// `color` on, 0 is the default of each.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_light {
    /// What it is for.
    pub role: klieg_role,
    /// Point, directional or spot.
    pub kind: klieg_light_kind,
    /// Elevation above the camera's horizontal plane, radians.
    pub elevation: f32,
    /// Azimuth, radians: 0 from the viewer, positive to the viewer's right.
    pub azimuth: f32,
    /// Distance R from the scene's centre, scene radii; a directional light ignores it.
    pub distance: f32,
    /// Diffuse intensity, 0 or more: the radiance that a white matt surface shows which faces the light
    /// at the scene's centre. 1 is the brightest that is shown.
    pub diffuse: f32,
    /// Specular intensity, 0 or more, of which a highlight is made.
    pub specular: f32,
    /// Colour, linear RGB, 0 or more, whose brightness does not count; as klieg gives it its luminance is 1.
    /// All 0: white.
    pub color: [f32; 3],
    /// Radius of the light itself, scene radii, 0 or more.
    pub size: f32,
    /// Half angle of a spot's fully bright inner cone, radians, 0 or more.
    pub cone_inner: f32,
    /// Half angle of a spot's whole cone, radians, more than `cone_inner`, π/2 at most. 0: π/4.
    pub cone_outer: f32,
    /// Axis of a spot's cone, away from the light. All 0: towards the scene's centre.
    pub aim: [f32; 3],
}

/// The light frame of a view: the camera's unit axes in the world, at the scene's centre.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_frame {
    /// Centre of the scene, world units.
    pub center: [f64; 3],
    /// Radius of the scene around it, world units.
    pub radius: f64,
    /// To the viewer's right.
    pub right: [f64; 3],
    /// Up.
    pub up: [f64; 3],
    /// From the scene to the viewer.
    pub back: [f64; 3],
}

/// A light in the world, as an engine applies it.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_world_light {
    /// What it is for.
    pub role: klieg_role,
    /// Point, directional or spot.
    pub kind: klieg_light_kind,
    /// Where it stands, world units; the scene's centre for a directional light.
    pub position: [f64; 3],
    /// Unit vector along which light reaches the scene's centre.
    pub direction: [f64; 3],
    /// Unit axis of a spot's cone, away from the light; all 0 for other lights.
    pub axis: [f64; 3],
    /// Distance R from the scene's centre, world units; 0 for a directional light.
    pub distance: f64,
    /// Physical intensity of the diffuse part: lux of a directional light, candela of any other, for
    /// world units of a metre. A white matt surface that faces it at the scene's centre has the
    /// radiance `diffuse`.
    pub intensity: f64,
    /// Diffuse intensity, relative: that of a point light at the distance d is `diffuse`·(R/d)².
    pub diffuse: f32,
    /// Specular intensity, relative in the same way.
    pub specular: f32,
    /// Colour, linear RGB of luminance 1, which all intensities are multiplied with.
    pub color: [f32; 3],
    /// Half angle of a spot's fully bright inner cone, radians; 0 for other lights.
    pub cone_inner: f32,
    /// Half angle of a spot's whole cone, radians; 0 for other lights. Between the two the light falls off
    /// as KHR_lights_punctual has it.
    pub cone_outer: f32,
    /// Radius of the light itself, world units.
    pub size: f64,
}

/// Rigs that people use without looking at the scene: one of `KLIEG_PRESET_...`.
pub type klieg_preset = i32;
/// One light from the viewer.
pub const KLIEG_PRESET_HEADLIGHT: klieg_preset = 0;
/// VTK's `vtkLightKit` with its default angles and ratios, white.
pub const KLIEG_PRESET_LIGHT_KIT: klieg_preset = 1;
/// The photographer's key, fill and back light.
pub const KLIEG_PRESET_THREE_POINT: klieg_preset = 2;

/// Gives the lights of a preset, all directional, and their number. `capacity` is the number of lights
/// that `lights` has room for: `KLIEG_MAX_LIGHTS` are enough. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_preset_lights(
    preset: klieg_preset,
    lights: *mut klieg_light,
    capacity: u32,
    count: *mut u32,
) -> klieg_status {
    free_call(|| {
        let rig = choice(&Preset::ALL, preset, "preset")?.rig();
        // SAFETY: the caller's pointers.
        unsafe {
            put(count, rig.len() as u32, "count")?;
            write_lights(fitting(lights, capacity, rig.len())?, &rig);
        }
        Ok(())
    })
}

/// Gives `count` lights of a frame, such as `klieg_evaluator_frame` gives, as they stand in the world.
/// Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_lights_in_world(
    frame: *const klieg_frame,
    lights: *const klieg_light,
    count: u32,
    world: *mut klieg_world_light,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        let (frame, lights, world) = unsafe {
            let count = count as usize;
            let frame = as_frame(given(frame, "frame")?);
            (frame, as_rig(array(lights, count, "lights")?)?, room(world, count, "world")?)
        };
        frame.check()?;
        for (to, light) in world.iter_mut().zip(lights) {
            *to = world_light(&light, &frame);
        }
        Ok(())
    })
}

const ROLES: [Role; 4] = [Role::Key, Role::Fill, Role::Rim, Role::Scene];
const KINDS: [LightKind; 3] = [LightKind::POINT, LightKind::DIRECTIONAL, LightKind::SPOT];

fn role(role: Role) -> klieg_role {
    match role {
        Role::Key => KLIEG_ROLE_KEY,
        Role::Fill => KLIEG_ROLE_FILL,
        Role::Rim => KLIEG_ROLE_RIM,
        Role::Scene => KLIEG_ROLE_SCENE,
    }
}

pub(super) fn kind(kind: LightKind) -> klieg_light_kind {
    // A kind of another crate is the one that shines as it does.
    match (kind.parallel, kind.cone) {
        (true, _) => KLIEG_LIGHT_DIRECTIONAL,
        (false, true) => KLIEG_LIGHT_SPOT,
        (false, false) => KLIEG_LIGHT_POINT,
    }
}

pub(super) fn as_role(role: klieg_role) -> Outcome<Role> {
    choice(&ROLES, role, "role")
}

pub(super) fn as_kind(kind: klieg_light_kind) -> Outcome<LightKind> {
    choice(&KINDS, kind, "light kind")
}

pub(super) fn as_rig(lights: &[klieg_light]) -> Outcome<Rig> {
    lights.iter().map(as_light).collect()
}

fn as_light(light: &klieg_light) -> Outcome<Light> {
    let &klieg_light { elevation, azimuth, distance, diffuse, specular, size, aim, .. } = light;
    let (role, kind) = (as_role(light.role)?, as_kind(light.kind)?);
    let (color, cone) = (as_color(light.color)?, as_cone(light)?);
    let aim =
        match aim {
            [0.0, 0.0, 0.0] => None,
            _ => Some(Vec3::from(aim).try_normalize().ok_or_else(|| {
                Fault::argument(format!("a light's aim {aim:?} is not a direction"))
            })?),
        };
    Ok(Light {
        role,
        kind,
        elevation,
        azimuth,
        distance,
        diffuse,
        specular,
        color,
        size,
        cone,
        aim,
    })
}

pub(super) fn as_color(color: [f32; 3]) -> Outcome<Color> {
    if color == [0.0; 3] {
        return Ok(Color::WHITE);
    }
    Color::of_linear(color)
        .ok_or_else(|| Fault::argument(format!("{color:?} is not the colour of a light")))
}

fn as_cone(light: &klieg_light) -> Outcome<Cone> {
    let &klieg_light { cone_inner: inner, cone_outer: outer, .. } = light;
    if outer == 0.0 {
        return Ok(Cone::default());
    }
    if inner >= 0.0 && inner < outer && outer <= FRAC_PI_2 {
        return Ok(Cone { inner, outer });
    }
    Err(Fault::argument(format!("{inner} and {outer} are not the half angles of a cone")))
}

/// The cone of a spot, 0 for other lights.
fn cone(light: &Light) -> [f32; 2] {
    let Cone { inner, outer } = light.cone;
    if light.kind.cone { [inner, outer] } else { [0.0; 2] }
}

/// Rigs of `lights` each, one after the other.
///
/// # Safety
/// `pointer` is `NULL` or points to all of them.
pub(super) unsafe fn population(
    pointer: *const klieg_light,
    rigs: u32,
    lights: u32,
) -> Outcome<Population> {
    let (rigs, lights) = (rigs as usize, lights as usize);
    let mut population = Population::new(lights)?;
    let count = rigs.checked_mul(lights).ok_or_else(|| Fault::argument("too many lights"))?;
    // SAFETY: the caller's promise.
    for rig in unsafe { array(pointer, count, "lights") }?.chunks_exact(lights) {
        population.push(&as_rig(rig)?)?;
    }
    Ok(population)
}

pub(super) fn write_lights(to: &mut [klieg_light], rig: &[Light]) {
    for (to, light) in to.iter_mut().zip(rig) {
        let &Light { elevation, azimuth, distance, diffuse, specular, size, .. } = light;
        let [cone_inner, cone_outer] = cone(light);
        *to = klieg_light {
            role: role(light.role),
            kind: kind(light.kind),
            elevation,
            azimuth,
            distance,
            diffuse,
            specular,
            color: light.color.linear(),
            size,
            cone_inner,
            cone_outer,
            aim: light.aim.unwrap_or_default().to_array(),
        };
    }
}

/// Room for `count` lights where the caller has room for `capacity`.
///
/// # Safety
/// As [`room`].
pub(super) unsafe fn fitting<'a>(
    lights: *mut klieg_light,
    capacity: u32,
    count: usize,
) -> Outcome<&'a mut [klieg_light]> {
    if count > capacity as usize {
        let fault = format!("room for {capacity} lights: there are {count}");
        return Err(Fault::argument(fault));
    }
    // SAFETY: the caller's promise.
    unsafe { room(lights, count, "lights") }
}

fn world_light(light: &Light, frame: &Frame) -> klieg_world_light {
    let place = light.to_world(frame).truncate();
    let (position, towards, distance) = match light.reach() {
        Some(reach) => (place, place - frame.center, f64::from(reach) * frame.radius),
        None => (frame.center, place, 0.0),
    };
    let axis = light.kind.cone.then(|| frame.direction_to_world(light.axis().as_dvec3()));
    let [cone_inner, cone_outer] = cone(light);
    klieg_world_light {
        role: role(light.role),
        kind: kind(light.kind),
        position: position.to_array(),
        direction: (-towards).normalize_or_zero().to_array(),
        distance,
        intensity: light.intensity(frame),
        axis: axis.unwrap_or_default().to_array(),
        diffuse: light.diffuse,
        specular: light.specular,
        color: light.color.linear(),
        cone_inner,
        cone_outer,
        size: f64::from(light.size) * frame.radius,
    }
}

pub(super) fn as_frame(frame: &klieg_frame) -> Frame {
    Frame {
        center: DVec3::from(frame.center),
        radius: frame.radius,
        right: DVec3::from(frame.right),
        up: DVec3::from(frame.up),
        back: DVec3::from(frame.back),
    }
}

pub(super) fn frame(frame: &Frame) -> klieg_frame {
    klieg_frame {
        center: frame.center.to_array(),
        radius: frame.radius,
        right: frame.right.to_array(),
        up: frame.up.to_array(),
        back: frame.back.to_array(),
    }
}
