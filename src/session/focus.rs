//! Objects that light is wanted for most, and objects that are to stay dim, by their names.

use super::config::Settings;
use super::device::Opened;
use super::engine::{Engine, evaluator_of};
use super::strokes::weigh_target;
use crate::cpu::objects::of_objects;
use crate::design::dim::{self, DIM_BRIGHTNESS, DIM_WEIGHT};
use crate::design::{Dimmed, Focused};
use crate::scene::view::View;
use crate::scene::{Instance, Scene};
use crate::{Error, Result};
use std::ops::Range;

/// Names that a message shows at most.
const SHOWN: usize = 20;

/// The evaluator that judges a view as the settings ask for, with their wishes for objects: `whole` itself where there are
/// none, and nothing where none of the named objects is seen, or nothing beside those that are to stay dim.
///
/// # Errors
/// [`Error::Input`] for a name that no object has, and what the device reports.
pub fn wished(
    mut whole: Engine,
    device: &Opened,
    (scene, view): (&Scene, &View),
    settings: &Settings,
) -> Result<Option<Engine>> {
    if settings.dim.is_empty() {
        return focused(whole, device, (scene, view), settings);
    }
    let named = named(scene, &settings.dim)?;
    let maps = whole.maps()?;
    let (lit, mut dim) = (of_objects(maps, |code| !named(code)), of_objects(maps, &named));
    if lit.counts.object() == 0 || dim.counts.object() == 0 {
        return Ok(None);
    }
    let pixels = dim.types.len();
    dim.set_target(vec![DIM_BRIGHTNESS; pixels])?;
    let mut others = settings.clone();
    weigh_target(&mut others.objective, 0.0)?;
    let lit = evaluator_of(device, (lit, view), &others)?;
    let Some(lit) = focused(lit, device, (scene, view), &others)? else { return Ok(None) };
    let objective = dim::objective(&settings.objective)?;
    let dim = evaluator_of(device, (dim, view), &Settings { objective, ..settings.clone() })?;
    Ok(Some(Engine::Dimmed(Box::new(Dimmed::new(whole, lit, dim)))))
}

impl Settings {
    /// Has the objective say what objects that are to stay dim count for.
    ///
    /// # Errors
    /// None in practice: the term is klieg's own.
    pub(super) fn weigh_dim(&mut self) -> Result<()> {
        if self.dim.is_empty() {
            return Ok(());
        }
        weigh_target(&mut self.objective, DIM_WEIGHT)
    }
}

/// As [`wished`], where wishes for objects that are not seen do not count, nor those for objects to stay dim beside which
/// nothing is seen.
///
/// # Errors
/// The same.
pub fn wished_in_view(
    mut whole: Engine,
    device: &Opened,
    (scene, view): (&Scene, &View),
    settings: &Settings,
) -> Result<Engine> {
    let settings = settings.seen_by(scene, &whole.maps()?.visible)?;
    let judged = wished(whole, device, (scene, view), &settings)?;
    judged.ok_or_else(|| out_of_view(scene, view, &settings))
}

/// The names of the objects that some names are of, each once.
///
/// # Errors
/// [`Error::Input`] for a name that no object has.
pub fn objects(scene: &Scene, names: &[String]) -> Result<Vec<String>> {
    let named = named(scene, names)?;
    let wanted = scene.instances.iter().filter(|one| named(one.first_polygon));
    let mut found: Vec<String> = Vec::new();
    for name in wanted.map(|instance| object_name(scene, instance)) {
        if !name.is_empty() && !found.iter().any(|known| known == name) {
            found.push(name.into());
        }
    }
    Ok(found)
}

/// The name of an object's node, else of its mesh.
pub fn object_name<'a>(scene: &'a Scene, instance: &'a Instance) -> &'a str {
    match instance.name.as_str() {
        "" => &scene.meshes[instance.mesh as usize].name,
        name => name,
    }
}

impl Settings {
    /// The settings with those of their wishes that objects of these colour codes are of.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no object has.
    pub fn seen_by(&self, scene: &Scene, codes: &[u32]) -> Result<Self> {
        let mut seen = self.clone();
        let dim = named(scene, &self.dim)?;
        if !codes.iter().any(|&code| dim(code)) || codes.iter().all(|&code| dim(code)) {
            seen.dim.clear();
        }
        let dim = named(scene, &seen.dim)?;
        let focus = named(scene, &self.focus)?;
        if !codes.iter().any(|&code| focus(code) && !dim(code)) {
            seen.focus.clear();
        }
        Ok(seen)
    }
}

/// The evaluator that judges the objects which the settings name besides the `whole` view; `whole` itself where they
/// name none, and nothing where none of them is seen.
///
/// # Errors
/// [`Error::Input`] for a name that no object has, and what the device reports.
fn focused(
    mut whole: Engine,
    device: &Opened,
    (scene, view): (&Scene, &View),
    settings: &Settings,
) -> Result<Option<Engine>> {
    if settings.focus.is_empty() {
        return Ok(Some(whole));
    }
    let maps = of_objects(whole.maps()?, named(scene, &settings.focus)?);
    if maps.counts.object() == 0 {
        return Ok(None);
    }
    let part = evaluator_of(device, (maps, view), settings)?;
    Ok(Some(Engine::Focused(Box::new(Focused::new(whole, part)))))
}

/// The fault of wishes for objects that the picture does not show.
pub fn out_of_view(scene: &Scene, view: &View, settings: &Settings) -> Error {
    let camera = &view.camera.name;
    let wish = |words: &str, names: &[String]| match names.is_empty() {
        true => String::new(),
        false => format!(" {words}: {};", names.join(", ")),
    };
    let focus = wish("what is in focus", &settings.focus);
    let dim = wish("what is to stay dim and something beside it", &settings.dim);
    let all = format!("camera '{camera}' does not see{focus}{dim}");
    Error::input(&scene.path, all.trim_end_matches(';'))
}

/// Whether a colour code is of an object of these names: of nodes or meshes of exactly one, or else of those that contain it, upper
/// and lower case alike.
fn named(scene: &Scene, names: &[String]) -> Result<impl Fn(u32) -> bool + use<>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
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
    Ok(move |code| ranges.iter().any(|range| range.contains(&code)))
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
