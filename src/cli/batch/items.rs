//! From folders, lists and files to the designs of a batch.

use super::record::Files;
use crate::cli::config::{CameraKey, Settings, ViewSettings};
use crate::cli::input;
use crate::cli::values::{Lights, Size};
use crate::lighting::LightKind;
use crate::{Error, Result};
use serde::Deserialize;
use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};
use toml::Spanned;

/// Most bytes of a name; file systems allow 255.
const MAX_NAME: usize = 120;

/// Most bytes of a list.
const MAX_LIST: u64 = 256 << 20;

/// A design to make.
#[derive(Debug)]
pub struct Item {
    /// Name of its folder.
    pub name: String,
    /// The scene's file.
    pub scene: PathBuf,
    /// All settings, those of the list among them.
    pub settings: Settings,
}

/// A `[[item]]` of a list; what it leaves out is as the batch's settings have it.
#[derive(Debug, Default, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// Relative to the list's folder.
    scene: PathBuf,
    name: Option<String>,
    camera: Option<CameraKey>,
    azimuth: Option<f64>,
    elevation: Option<f64>,
    fov: Option<f64>,
    fill: Option<f64>,
    size: Option<Size>,
    lights: Option<Lights>,
    kind: Option<LightKind>,
    seed: Option<u64>,
}

/// A list of designs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    item: Vec<Spanned<Entry>>,
}

/// All designs that `inputs` (folders, lists, scenes) ask for, each once, in their order.
///
/// # Errors
/// [`Error::Input`] for folders and lists that cannot be used or name no scene. Scenes are not
/// looked at.
pub fn gather(inputs: &[PathBuf], out: &Path, settings: &Settings) -> Result<Vec<Item>> {
    let mut gathered = Gathered::new(settings);
    for given in inputs {
        if input::is_standard(given) {
            gathered.text(given)?;
        } else if given.is_dir() {
            gathered.folder(given, out)?;
        } else if is_scene(given) {
            gathered.scene(given, given);
        } else if has_extension(given, &["toml"]) {
            gathered.toml(given)?;
        } else if has_extension(given, &["txt"]) {
            gathered.text(given)?;
        } else if given.exists() {
            let fault = "is neither a folder, a scene (.gltf, .glb, .ply, .stl or .obj), nor a list (.toml or .txt)";
            return Err(Error::input(given, fault));
        } else {
            return Err(Error::input(given, "file not found"));
        }
    }
    Ok(gathered.items)
}

/// The designs so far.
struct Gathered<'a> {
    settings: &'a Settings,
    items: Vec<Item>,
    /// Names in lower case: some file systems do not tell cases apart.
    names: HashSet<String>,
    /// Scenes with what their entries change.
    known: HashSet<(PathBuf, String)>,
}

impl<'a> Gathered<'a> {
    fn new(settings: &'a Settings) -> Self {
        let names = HashSet::from(Files::default().names());
        Self { settings, items: Vec::new(), names, known: HashSet::new() }
    }

    /// A scene with the batch's settings, named after `label`.
    fn scene(&mut self, path: &Path, label: &Path) {
        let entry = Entry { scene: path.into(), ..Entry::default() };
        self.add(entry, label, self.settings.clone());
    }

    /// An entry, unless the same is there already.
    fn add(&mut self, entry: Entry, label: &Path, settings: Settings) {
        let changes = entry.changes();
        let name = entry.name.clone().unwrap_or_else(|| named(label, &changes));
        let real = entry.scene.canonicalize().unwrap_or_else(|_| entry.scene.clone());
        if !self.known.insert((real, format!("{:?}{changes:?}", entry.name))) {
            return;
        }
        let mut unique = name.clone();
        for number in 2.. {
            if self.names.insert(unique.to_lowercase()) {
                break;
            }
            unique = format!("{name}-{number}");
        }
        self.items.push(Item { name: unique, scene: entry.scene, settings });
    }

    /// All scenes below a folder, in the order of their paths; not those in `out`.
    fn folder(&mut self, root: &Path, out: &Path) -> Result<()> {
        let out = out.canonicalize().ok();
        if out.is_some() && root.canonicalize().ok() == out {
            let fault =
                format!("the scenes are in {} itself: choose another --out", root.display());
            return Err(Error::Argument(fault));
        }
        let mut found = Vec::new();
        walk(root, &mut out.into_iter().collect(), &mut found)?;
        if found.is_empty() {
            return Err(Error::input(
                root,
                "there is no .gltf, .glb, .ply, .stl or .obj file in it",
            ));
        }
        for path in found {
            self.scene(&path, path.strip_prefix(root).unwrap_or(&path));
        }
        Ok(())
    }

    /// A list with a path in each line; empty lines and those that begin with `#` count for nothing.
    fn text(&mut self, list: &Path) -> Result<()> {
        let text = read(list)?;
        let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
        let before = self.items.len();
        for line in lines.filter(|line| !line.is_empty() && !line.starts_with('#')) {
            self.scene(&beside(list, Path::new(line)), Path::new(line));
        }
        if self.items.len() == before {
            return Err(Error::input(input::name(list), "it names no scene"));
        }
        Ok(())
    }

    /// A list of `[[item]]` tables.
    fn toml(&mut self, list: &Path) -> Result<()> {
        let text = read(list)?;
        let List { item } = toml::from_str(&text)
            .map_err(|fault| Error::input(list, fault.to_string().trim_end()))?;
        if item.is_empty() {
            return Err(Error::input(list, "it names no scene"));
        }
        for entry in item {
            let line = text[..entry.span().start].matches('\n').count() + 1;
            let fault = |fault: Error| Error::input(list, format!("item at line {line}: {fault}"));
            let mut entry = entry.into_inner();
            entry.check().map_err(fault)?;
            let mut settings = self.settings.clone();
            entry.apply(&mut settings);
            settings.check().and_then(|()| settings.genome()).map_err(fault)?;
            let label = std::mem::take(&mut entry.scene);
            entry.scene = beside(list, &label);
            self.add(entry, &label, settings);
        }
        Ok(())
    }
}

impl Entry {
    fn view(&self) -> ViewSettings {
        ViewSettings {
            size: self.size,
            camera: self.camera.clone(),
            azimuth: self.azimuth,
            elevation: self.elevation,
            fov: self.fov,
            fill: self.fill,
        }
    }

    fn apply(&self, settings: &mut Settings) {
        settings.view.overlay(&self.view());
        if let Some(lights) = &self.lights {
            settings.lights.roles = lights.clone();
        }
        settings.lights.kind = self.kind.unwrap_or(settings.lights.kind);
        settings.seed = self.seed.unwrap_or(settings.seed);
    }

    /// A given name must be that of a folder of its own.
    fn check(&self) -> Result<()> {
        match &self.name {
            Some(name) if clean(name) != *name || name.len() > MAX_NAME => {
                let fault = format!(
                    "name '{}': letters, digits, '-', '_' and '.' make a name, the last not at \
                     either end, {MAX_NAME} bytes at most",
                    name.escape_debug()
                );
                Err(Error::Argument(fault))
            }
            _ => Ok(()),
        }
    }

    /// What differs from the batch's settings, in words.
    fn changes(&self) -> Vec<String> {
        let number = |name, value: Option<f64>| value.map(|value| format!("{name}{value}"));
        let roles = |lights: &Lights| {
            let names: Vec<_> = lights.0.iter().map(|role| format!("{role:?}")).collect();
            names.join("-").to_lowercase()
        };
        let changes = [
            self.camera.as_ref().map(CameraKey::text),
            number("azimuth", self.azimuth),
            number("elevation", self.elevation),
            number("fov", self.fov),
            number("fill", self.fill),
            self.size.map(|size| size.to_string()),
            self.lights.as_ref().map(roles),
            self.kind.map(|kind| format!("{kind:?}").to_lowercase()),
            self.seed.map(|seed| format!("seed{seed}")),
        ];
        changes.into_iter().flatten().collect()
    }
}

/// The name of a scene's folder: its path, as it was given, in one word, and what its entry changes.
fn named(label: &Path, changes: &[String]) -> String {
    let stem = if is_scene(label) { label.with_extension("") } else { label.into() };
    let parts = stem.components().filter_map(|part| match part {
        Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
        _ => None,
    });
    let words: Vec<String> = parts.chain(changes.iter().cloned()).collect();
    let name = words.join("-");
    let fits = |&(at, c): &(usize, char)| at + c.len_utf8() <= MAX_NAME;
    clean(&name.char_indices().take_while(fits).map(|(_, c)| c).collect::<String>())
}

/// A name without what file systems or shells treat in their own way.
fn clean(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    let name = name.trim_matches('.');
    if name.is_empty() { "scene".into() } else { name.into() }
}

fn read(list: &Path) -> Result<String> {
    input::text(list, MAX_LIST)
}

/// A path that a list names.
fn beside(list: &Path, path: &Path) -> PathBuf {
    list.parent().unwrap_or(Path::new("")).join(path)
}

fn is_scene(path: &Path) -> bool {
    has_extension(path, &["gltf", "glb", "ply", "stl", "obj"])
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str);
    extension.is_some_and(|own| extensions.iter().any(|known| own.eq_ignore_ascii_case(known)))
}

/// Finds the scenes in and below a folder, without hidden ones. Links are followed; folders whose
/// real paths are in `seen` are left out, so that no loop is endless.
fn walk(folder: &Path, seen: &mut HashSet<PathBuf>, found: &mut Vec<PathBuf>) -> Result<()> {
    let fault = |fault| Error::input(folder, fault);
    if !seen.insert(folder.canonicalize().map_err(fault)?) {
        return Ok(());
    }
    let entries = std::fs::read_dir(folder).map_err(fault)?.map(|entry| Ok(entry?.path()));
    let mut paths = entries.collect::<std::io::Result<Vec<_>>>().map_err(fault)?;
    paths.sort();
    for path in paths {
        let hidden = path.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(b"."));
        if hidden {
            continue;
        }
        if path.is_dir() {
            walk(&path, seen, found)?;
        } else if is_scene(&path) {
            found.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(path: &str, changes: &[&str]) -> String {
        let changes: Vec<String> = changes.iter().map(|&change| change.into()).collect();
        named(Path::new(path), &changes)
    }

    #[test]
    fn names_follow_from_paths_and_changes() {
        assert_eq!(name("oak.glb", &[]), "oak");
        assert_eq!(name("chairs/oak.v2.GLTF", &["azimuth-60"]), "chairs-oak.v2-azimuth-60");
        assert_eq!(name("/a/../b c/.d/x.glb", &["Camera: 1"]), "a-b_c-.d-x-Camera__1");
        assert_eq!(name("Stühle/eiche.glb", &[]), "Stühle-eiche");
        assert_eq!(name("...glb", &[]), "scene");
        assert_eq!(name(&"椅".repeat(400), &[]).len(), MAX_NAME);
    }

    #[test]
    fn a_taken_name_gets_a_number() {
        let settings = Settings::default();
        let mut gathered = Gathered::new(&settings);
        for path in ["x.glb", "X.gltf", "x-2.glb", "x.glb", "batch.json.glb"] {
            gathered.scene(Path::new(path), Path::new(path));
        }
        let names: Vec<_> = gathered.items.iter().map(|item| &item.name[..]).collect();
        assert_eq!(names, ["x", "X-2", "x-2-2", "batch.json-2"]);
    }

    #[test]
    fn an_item_goes_before_the_batch_s_settings() {
        let mut settings = Settings::default();
        settings.view.camera = Some(CameraKey::Index(1));
        settings.view.size = Some(Size([8, 8]));
        let entry = Entry { azimuth: Some(5.0), seed: Some(3), ..Entry::default() };
        entry.apply(&mut settings);
        assert_eq!((settings.view.camera.as_ref(), settings.view.azimuth), (None, Some(5.0)));
        assert_eq!((settings.view.size, settings.seed), (Some(Size([8, 8])), 3));
        let entry = Entry { camera: Some(CameraKey::Index(0)), ..Entry::default() };
        entry.apply(&mut settings);
        assert!(!settings.view.framed() && settings.check().is_ok());
    }
}
