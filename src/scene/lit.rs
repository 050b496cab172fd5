//! Writes the lit scene: the original with a rig's lights (KHR_lights_punctual) and the camera that
//! they were designed for.

mod cameras;
mod document;
mod strip;

use super::framing;
use super::lights::LightExtras;
use super::load::LoadOptions;
use super::view::{DesignedView, Projection, View};
use crate::lighting::{Color, Light, Role, Stand};
use crate::{Error, Result};
use document::{Document, array, object};
use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;
use std::path::Path;

/// The extension that holds lights.
const EXTENSION: &str = "KHR_lights_punctual";
/// Name of the block of a node's `extras` that marks it as klieg's.
const EXTRAS: &str = "klieg";
/// How far an orthographic camera without a far plane sees, scene radii; as [`View::new`] has it.
const FAR: f64 = 1e4;

/// Writes the scene in the file `source` to `out` as one self-contained GLB, with the lights of `rig` and
/// the camera of `view` appended as nodes. What klieg appended to it before is replaced. Files that
/// `source` names, and that anything in it uses, are taken in where `options` allow them; files that unknown
/// extensions alone name stay outside.
///
/// A PLY, STL or OBJ file becomes glTF, placed as `options` say.
///
/// A viewer shows what was scored: the scene's own lights stay where `rig` has them ([`Role::Scene`]), and
/// are taken out where it has none of them. All else of the scene is unchanged.
///
/// Intensities are physical, as [`Light::intensity`] says; a colour has its largest channel at 1. What glTF
/// has no place for stands in the `extras` of the light's node as
/// `{"klieg": {"light": {"role", "diffuse", "specular"}}}`, and `"size"` (scene radii) where there is one; a
/// light with a size has its radius in world units in its own `extras` too, as `{"klieg": {"radius"}}`.
///
/// The camera is the first of the file's cameras and its node the first of the scene's, so that viewers open
/// the file through it. Its clipping planes leave room to move round the scene, unless they may cut something
/// of it off; those of `view` stand in the node's `extras`, and are read back.
///
/// # Errors
/// [`Error::Input`] when `source` or a file that it names cannot be used, [`Error::Argument`] for a
/// light that glTF cannot express, [`Error::Output`] when `out` cannot be written.
pub fn write(
    source: &Path,
    options: impl Into<LoadOptions>,
    view: &View,
    rig: &[Light],
    out: &Path,
) -> Result<()> {
    write_standing(source, options, (view, rig, Stand::World), out)
}

/// As [`write()`], of a rig that stands in the world or goes with the camera: there its nodes are children of the camera's.
///
/// # Errors
/// As [`write()`].
pub fn write_standing(
    source: &Path,
    options: impl Into<LoadOptions>,
    (view, rig, stand): (&View, &[Light], Stand),
    out: &Path,
) -> Result<()> {
    lit(source, options.into(), (view, rig, stand))?.write(out)
}

/// As [`write()`], into memory.
///
/// # Errors
/// As [`write()`], without `out`.
pub fn glb(
    source: &Path,
    options: impl Into<LoadOptions>,
    view: &View,
    rig: &[Light],
) -> Result<Vec<u8>> {
    lit(source, options.into(), (view, rig, Stand::World))?.glb()
}

/// Writes the bytes of [`glb`] to a file: whole under its name, or not at all.
///
/// # Errors
/// [`Error::Output`].
pub fn save(glb: &[u8], out: &Path) -> Result<()> {
    document::save(out, |to| to.write_all(glb))
}

/// The lit scene.
fn lit(
    source: &Path,
    options: LoadOptions,
    (view, rig, stand): (&View, &[Light], Stand),
) -> Result<Document> {
    let (scene_lights, rig): (Vec<Light>, Vec<Light>) =
        rig.iter().copied().partition(|light| light.role == Role::Scene);
    rig.iter().try_for_each(check)?;
    let mut document = Document::read(source, &options.orientation, options.access)?;
    strip::strip(&mut document.root);
    if scene_lights.is_empty() {
        strip::strip_lights(&mut document.root);
    }
    document.embed_files(options.access)?;
    let scene = drawn_scene(&mut document)?;
    let mut on_camera = Vec::new();
    for (light, name) in rig.iter().zip(names(&rig)) {
        let index = add_light(&mut document, light_json(light, view, &name))?;
        let node = light_node((light, stand), view, &name, index);
        match stand {
            Stand::World => add_node(&mut document, scene, node, Vec::push)?,
            Stand::Camera => {
                let nodes = document.array("nodes")?;
                on_camera.push(nodes.len());
                nodes.push(node);
            }
        }
    }
    let index = cameras::add(&mut document.root, camera_json(view))
        .ok_or_else(|| document.fault("'cameras' is not an array"))?;
    let to_front = |roots: &mut Vec<Value>, node| roots.insert(0, node);
    add_node(&mut document, scene, camera_node(view, index, &on_camera), to_front)?;
    Ok(document)
}

/// Refuses a light that glTF cannot express.
fn check(light: &Light) -> Result<()> {
    let Light { elevation, azimuth, diffuse, specular, size, cone, .. } = *light;
    let reach = light.reach().unwrap_or(1.0);
    let values = [elevation, azimuth, diffuse, specular, size, reach];
    let finite = values.iter().all(|value| value.is_finite()) && light.axis().is_normalized();
    let open = cone.inner >= 0.0 && cone.inner < cone.outer && cone.outer <= FRAC_PI_2;
    let positive = reach > 0.0 && diffuse >= 0.0 && specular >= 0.0 && size >= 0.0;
    if finite && positive && (open || !light.kind.cone) {
        Ok(())
    } else {
        Err(Error::Argument(format!("{light:?} cannot be written as a glTF light")))
    }
}

/// Names of the lights' nodes: `klieg` and the role, numbered where a role has several lights.
fn names(rig: &[Light]) -> impl Iterator<Item = String> {
    rig.iter().enumerate().map(|(index, light)| {
        let of_role = |lights: &[Light]| lights.iter().filter(|l| l.role == light.role).count();
        let role = light.role.name();
        if of_role(rig) == 1 {
            format!("klieg {role}")
        } else {
            format!("klieg {role} {}", of_role(&rig[..=index]))
        }
    })
}

/// Index of the scene that is drawn; made of all root nodes where the file has no scenes.
fn drawn_scene(document: &mut Document) -> Result<usize> {
    if document.array("scenes")?.is_empty() {
        let nodes = document.array("nodes")?;
        let mut is_root = vec![true; nodes.len()];
        let children = nodes.iter().filter_map(|node| node["children"].as_array()).flatten();
        for child in children.filter_map(Value::as_u64) {
            if let Some(is_root) = is_root.get_mut(child as usize) {
                *is_root = false;
            }
        }
        let roots: Vec<_> = (0..nodes.len()).filter(|&index| is_root[index]).collect();
        document.array("scenes")?.push(json!({ "nodes": roots }));
        document.root.insert("scene".into(), 0.into());
    }
    let scene = document.root.get("scene").and_then(Value::as_u64).unwrap_or(0) as usize;
    if document.array("scenes")?.get(scene).is_none_or(|scene| !scene.is_object()) {
        return Err(document.fault(format!("scene {scene} is missing")));
    }
    Ok(scene)
}

/// Appends a node to the file, and has `place` put it among the roots of its scene.
fn add_node(
    document: &mut Document,
    scene: usize,
    node: Value,
    place: impl Fn(&mut Vec<Value>, Value),
) -> Result<()> {
    let nodes = document.array("nodes")?;
    nodes.push(node);
    let index = nodes.len() - 1;
    let scene = document.array("scenes")?[scene].as_object_mut();
    match scene.and_then(|scene| array(scene, "nodes")) {
        Some(roots) => place(roots, index.into()),
        None => return Err(document.fault("a scene's 'nodes' is not an array")),
    }
    Ok(())
}

/// Appends a light object and gives its index.
fn add_light(document: &mut Document, light: Value) -> Result<usize> {
    let used = document.array("extensionsUsed")?;
    if used.iter().all(|name| name != EXTENSION) {
        used.push(EXTENSION.into());
    }
    let lights = object(&mut document.root, "extensions")
        .and_then(|extensions| object(extensions, EXTENSION))
        .and_then(|extension| array(extension, "lights"));
    match lights {
        Some(lights) => {
            lights.push(light);
            Ok(lights.len() - 1)
        }
        None => Err(document.fault(format!("the lights of {EXTENSION} are not an array"))),
    }
}

fn light_json(light: &Light, view: &View, name: &str) -> Value {
    // A kind that glTF does not know is the one of its kinds that shines as it does.
    let kind = match (light.kind.parallel, light.kind.cone) {
        (true, _) => "directional",
        (false, true) => "spot",
        (false, false) => "point",
    };
    let (color, factor) = light.color.scaled();
    let intensity = light.intensity(&view.frame) * f64::from(factor);
    let mut json = json!({ "name": name, "type": kind, "intensity": intensity });
    if light.color != Color::WHITE {
        json["color"] = json!(color);
    }
    if kind == "spot" {
        // In double precision, as the single one nearest to π/2 is above it.
        let outer = f64::from(light.cone.outer).min(std::f64::consts::FRAC_PI_2);
        json["spot"] = json!({ "innerConeAngle": light.cone.inner, "outerConeAngle": outer });
    }
    if light.size > 0.0 {
        let radius = f64::from(light.size) * view.frame.radius;
        json["extras"] = json!({ EXTRAS: { "radius": radius } });
    }
    json
}

/// A light's node: a child of the camera's where it goes with the camera, whose axes are those of the light frame.
fn light_node((light, stand): (&Light, Stand), view: &View, name: &str, index: usize) -> Value {
    let frame = &view.frame;
    let local = |v: DVec3| DVec3::new(v.dot(frame.right), v.dot(frame.up), v.dot(frame.back));
    let (place, turned): (&dyn Fn(DVec3) -> DVec3, &dyn Fn(DVec3) -> DVec3) = match stand {
        Stand::World => (&|world| world, &|world| world),
        Stand::Camera => (&|world| local(world - view.camera.eye), &local),
    };
    let (sin_el, cos_el) = f64::from(light.elevation).sin_cos();
    let (sin_az, cos_az) = f64::from(light.azimuth).sin_cos();
    let direction = DVec3::new(cos_el * sin_az, sin_el, cos_el * cos_az);
    let mut node = json!({ "name": name });
    if let Some(reach) = light.reach() {
        let position = view.frame.point_to_world(direction * f64::from(reach));
        node["translation"] = json!(place(position).to_array());
    }
    if light.kind.parallel || light.kind.cone {
        // It shines along its node's −Z axis.
        let aim = light.aim.filter(|_| light.kind.cone).map_or(-direction, |aim| aim.as_dvec3());
        let back = turned(view.frame.direction_to_world(-aim)).normalize();
        node["rotation"] = json!(DQuat::from_rotation_arc(DVec3::Z, back).to_array());
    }
    let Light { role, diffuse, specular, size, .. } = *light;
    let extras = LightExtras { role, diffuse, specular, size };
    node["extensions"] = json!({ EXTENSION: { "light": index } });
    node["extras"] = json!({ EXTRAS: { "light": extras } });
    node
}

/// Distance of a roomy near plane, as a share of the distance to the scene's centre.
const ROOMY_NEAR: f64 = 0.01;
/// How far beyond the scene's centre a roomy far plane stands, scene radii.
const ROOMY_FAR: f64 = 10.0;

/// Clipping planes that leave room to move round the scene; `None` where those of the view may cut something
/// of the scene off, which then has to stay so.
fn roomy_planes(view: &View) -> Option<(f64, Option<f64>)> {
    let camera = &view.camera;
    let radius = view.frame.radius;
    let distance = (camera.eye - view.frame.center).dot(camera.back);
    let outside =
        camera.near <= distance - radius && camera.far.is_none_or(|far| far >= distance + radius);
    let widened = camera.designed.is_some_and(|designed| designed.planes().is_some());
    if !(outside || widened || camera.name == framing::NAME) {
        return None;
    }
    let far = camera.far.map(|far| far.max(distance + ROOMY_FAR * radius));
    Some((camera.near.min(ROOMY_NEAR * distance), far))
}

fn camera_json(view: &View) -> Value {
    let camera = &view.camera;
    let (near, far) = roomy_planes(view).unwrap_or((camera.near, camera.far));
    let aspect = f64::from(view.width) / f64::from(view.height);
    match camera.projection {
        Projection::Perspective { yfov } => {
            let mut lens = json!({ "aspectRatio": aspect, "yfov": yfov, "znear": near });
            if let Some(far) = far {
                lens["zfar"] = far.into();
            }
            json!({ "type": "perspective", "perspective": lens })
        }
        Projection::Orthographic { ymag } => {
            let far = far.unwrap_or(near + FAR * view.frame.radius);
            let lens = json!({ "xmag": ymag * aspect, "ymag": ymag, "znear": near, "zfar": far });
            json!({ "type": "orthographic", "orthographic": lens })
        }
    }
}

fn camera_node(view: &View, index: usize, children: &[usize]) -> Value {
    let camera = &view.camera;
    let axes = DMat3::from_cols(camera.right, camera.up, camera.back);
    let planes = roomy_planes(view).is_some();
    let designed = DesignedView {
        size: [view.width, view.height],
        near: planes.then_some(camera.near),
        far: camera.far.filter(|_| planes),
    };
    let mut node = json!({
        "name": "klieg camera",
        "translation": camera.eye.to_array(),
        "rotation": DQuat::from_mat3(&axes).normalize().to_array(),
        "camera": index,
        "extras": { EXTRAS: { "camera": designed } },
    });
    if !children.is_empty() {
        node["children"] = json!(children);
    }
    node
}
