//! Lights, the frame that they stand in, and where they are in the world.

use super::edge::{Fault, Outcome, array, choice, free_call, given, put, room};
use super::error::klieg_status;
use crate::lighting::presets::Preset;
use crate::lighting::{Light, LightKind, MAX_LIGHTS, Population, Rig, Role};
use crate::math::frame::Frame;
use bytemuck::Zeroable;
use glam::DVec3;

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

/// How a light reaches the scene: one of `KLIEG_LIGHT_...`.
pub type klieg_light_kind = i32;
/// From a point at the distance R from the scene's centre, with falloff (R/d)².
pub const KLIEG_LIGHT_POINT: klieg_light_kind = 0;
/// Parallel, without falloff.
pub const KLIEG_LIGHT_DIRECTIONAL: klieg_light_kind = 1;

/// A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii.
#[repr(C)]
#[derive(Clone, Copy, Zeroable)]
pub struct klieg_light {
    /// What it is for.
    pub role: klieg_role,
    /// Point or directional.
    pub kind: klieg_light_kind,
    /// Elevation above the camera's horizontal plane, radians.
    pub elevation: f32,
    /// Azimuth, radians: 0 from the viewer, positive to the viewer's right.
    pub azimuth: f32,
    /// Distance R of a point light from the scene's centre, scene radii; a directional light ignores it.
    pub distance: f32,
    /// Diffuse intensity, 0 or more: the radiance that a white matt surface shows which faces the light
    /// at the scene's centre. 1 is the brightest that is shown.
    pub diffuse: f32,
    /// Specular intensity, 0 or more, of which a highlight is made.
    pub specular: f32,
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
    /// Point or directional.
    pub kind: klieg_light_kind,
    /// Where a point light stands, world units; the scene's centre for a directional one.
    pub position: [f64; 3],
    /// Unit vector along which light reaches the scene's centre.
    pub direction: [f64; 3],
    /// Distance R of a point light from the scene's centre, world units; 0 for a directional one.
    pub distance: f64,
    /// Physical intensity of the diffuse part: candela of a point light, lux of a directional one, for
    /// world units of a metre. A white matt surface that faces it at the scene's centre has the
    /// radiance `diffuse`.
    pub intensity: f64,
    /// Diffuse intensity, relative: that of a point light at the distance d is `diffuse`·(R/d)².
    pub diffuse: f32,
    /// Specular intensity, relative in the same way.
    pub specular: f32,
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

const ROLES: [Role; 3] = [Role::Key, Role::Fill, Role::Rim];
const KINDS: [LightKind; 2] = [LightKind::Point, LightKind::Directional];

fn role(role: Role) -> klieg_role {
    match role {
        Role::Key => KLIEG_ROLE_KEY,
        Role::Fill => KLIEG_ROLE_FILL,
        Role::Rim => KLIEG_ROLE_RIM,
    }
}

fn kind(kind: LightKind) -> klieg_light_kind {
    match kind {
        LightKind::Point => KLIEG_LIGHT_POINT,
        LightKind::Directional => KLIEG_LIGHT_DIRECTIONAL,
    }
}

pub(super) fn as_role(role: klieg_role) -> Outcome<Role> {
    choice(&ROLES, role, "role")
}

pub(super) fn as_kind(kind: klieg_light_kind) -> Outcome<LightKind> {
    choice(&KINDS, kind, "light kind")
}

pub(super) fn as_rig(lights: &[klieg_light]) -> Outcome<Rig> {
    let light = |light: &klieg_light| {
        let &klieg_light { elevation, azimuth, distance, diffuse, specular, .. } = light;
        let (role, kind) = (as_role(light.role)?, as_kind(light.kind)?);
        Ok(Light { role, kind, elevation, azimuth, distance, diffuse, specular })
    };
    lights.iter().map(light).collect()
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
        let &Light { elevation, azimuth, distance, diffuse, specular, .. } = light;
        let (role, kind) = (role(light.role), kind(light.kind));
        *to = klieg_light { role, kind, elevation, azimuth, distance, diffuse, specular };
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
    let (position, towards, distance) = match light.kind {
        LightKind::Point => (place, place - frame.center, f64::from(light.distance) * frame.radius),
        LightKind::Directional => (frame.center, place, 0.0),
    };
    klieg_world_light {
        role: role(light.role),
        kind: kind(light.kind),
        position: position.to_array(),
        direction: (-towards).normalize_or_zero().to_array(),
        distance,
        intensity: light.intensity(frame),
        diffuse: light.diffuse,
        specular: light.specular,
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
