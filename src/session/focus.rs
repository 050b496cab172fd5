//! Objects that light is wanted for most, by their names.

use super::config::Settings;
use super::device::Opened;
use super::engine::{Engine, evaluator_of};
use crate::cpu::objects::of_objects;
use crate::design::Focused;
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use std::ops::Range;

/// Names that a message shows at most.
const SHOWN: usize = 20;

/// The evaluator that judges the objects which the settings name besides the `whole` view; `whole` itself where they
/// name none, and nothing where none of them is seen.
///
/// # Errors
/// [`Error::Input`] for a name that no object has, and what the device reports.
pub fn focused(
    mut whole: Engine,
    device: &Opened,
    (scene, view): (&Scene, &View),
    settings: &Settings,
) -> Result<Option<Engine>> {
    if settings.focus.is_empty() {
        return Ok(Some(whole));
    }
    let ranges = polygons(scene, &settings.focus)?;
    let maps = of_objects(whole.maps()?, |code| ranges.iter().any(|range| range.contains(&code)));
    if maps.counts.object() == 0 {
        return Ok(None);
    }
    let part = evaluator_of(device, (maps, view), settings)?;
    Ok(Some(Engine::Focused(Box::new(Focused::new(whole, part)))))
}

/// The fault of a focus that the picture does not show.
pub fn out_of_view(scene: &Scene, view: &View, names: &[String]) -> Error {
    let (camera, names) = (&view.camera.name, names.join(", "));
    Error::input(&scene.path, format!("camera '{camera}' does not see what is in focus: {names}"))
}

/// Colour codes of the objects of these names: of nodes or meshes of exactly one, or else of those that contain it, upper
/// and lower case alike.
fn polygons(scene: &Scene, names: &[String]) -> Result<Vec<Range<u32>>> {
    let mut ranges = Vec::new();
    for name in names {
        let wanted = name.to_lowercase();
        let having = |test: &dyn Fn(&str) -> bool| -> Vec<_> {
            let instances = scene.instances.iter();
            let named = instances.filter(|instance| {
                let mesh = &scene.meshes[instance.mesh as usize].name;
                [&instance.name, mesh].into_iter().any(|name| test(&name.to_lowercase()))
            });
            named.map(|instance| scene.polygon_range(instance)).collect()
        };
        let mut found = having(&|name| name == wanted);
        if found.is_empty() {
            found = having(&|name| name.contains(&wanted));
        }
        if found.is_empty() || wanted.is_empty() {
            return Err(Error::input(&scene.path, unknown(scene, name)));
        }
        ranges.append(&mut found);
    }
    Ok(ranges)
}

/// What is said of a name that no object has.
fn unknown(scene: &Scene, name: &str) -> String {
    let mut names: Vec<_> = scene.instances.iter().map(|instance| instance.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names.retain(|name| !name.is_empty());
    let more = if names.len() > SHOWN { " and others" } else { "" };
    names.truncate(SHOWN);
    match names.is_empty() {
        true => format!("no object is named '{name}': its objects have no names"),
        false => format!("no object is named '{name}': there are {}{more}", names.join(", ")),
    }
}
