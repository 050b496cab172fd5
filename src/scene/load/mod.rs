//! glTF 2.0 files (`.gltf` and `.glb`), and PLY, STL and OBJ as the glTF that they amount to, to a [`Scene`].
//!
//! Files are not trusted: every index, offset and count is checked before it is used, and what a
//! file may take of memory and time is bounded.

mod accessor;
mod animate;
mod appearance;
mod budget;
pub mod contents;
mod document;
mod draco;
mod elements;
mod extensions;
pub(crate) mod files;
mod glossiness;
mod guard;
mod instancing;
mod material;
mod mesh;
mod meshopt;
pub(super) mod models;
mod nodes;
pub(super) mod picture;
mod pose;
mod punctual;
pub(super) mod resources;
mod texture;
pub(super) mod used;
mod views;

use super::assemble::{DEFAULT, label, quoted, warn};
use super::view::DesignedView;
use super::{Parsed, Scene, camera};
use crate::{Error, Result};
use accessor::Accessors;
pub use animate::Moment;
use budget::Budget;
use document::Document;
use files::Buffer;
use glam::DMat4;
use glossiness::Conversion;
use gltf::json::Root;
use gltf::json::extras::RawValue;
use material::Materials;
pub use models::{Orientation, Up};
use nodes::Nodes;
pub use picture::read as read_picture;
use pose::Pose;
pub use resources::FileAccess;
use resources::Resources;
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// How a file is loaded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// The files that it may name.
    pub access: FileAccess,
    /// How a PLY, STL or OBJ file stands in the world.
    pub orientation: Orientation,
    /// The moment of its animations that is shown.
    pub moment: Moment,
    /// Whether it may take much more memory and time than files of its size do; what the machine has is the
    /// limit always.
    pub large: bool,
}

impl From<FileAccess> for LoadOptions {
    fn from(access: FileAccess) -> Self {
        Self { access, ..Self::default() }
    }
}

/// Loads the default scene of a glTF file with the default options: it may name files in its own folder alone.
///
/// # Errors
/// As [`load_with`].
pub fn load(path: &Path) -> Result<Scene> {
    load_with(path, FileAccess::SceneFolder)
}

/// Loads the default scene of a glTF file, or the triangles of a PLY, STL or OBJ file, as `options` say;
/// [`FileAccess`] alone does for them.
///
/// Meshes stand in the pose of the moment that is asked for. What cannot be drawn as the file says is listed
/// in [`Scene::warnings`].
///
/// # Errors
/// [`Error::Input`] names the file and its fault.
pub fn load_with(path: &Path, options: impl Into<LoadOptions>) -> Result<Scene> {
    let fault = |fault| Error::input(path, fault);
    let mut scene = parse(path, &options.into()).map_err(fault)?;
    scene.path = path.to_owned();
    // Says whether there is any extent to look at.
    super::view::bounds(&scene)?;
    Ok(scene)
}

fn parse(path: &Path, options: &LoadOptions) -> Parsed<Scene> {
    let mut warnings = Vec::new();
    let mut libraries = Vec::new();
    let (json, bin) = match models::read(path, &options.orientation, options.access)? {
        Some(model) => {
            let json = model.json();
            (warnings, libraries) = (model.warnings, model.files);
            (json, Some(Buffer::Memory(model.bin)))
        }
        None => {
            let (json, bin) = files::open(path)?;
            (json, bin.map(Buffer::File))
        }
    };
    let document = document::parse(&json, &mut warnings)?;
    let used = json.len() as u64 + bin.as_ref().map_or(0, Buffer::len);
    drop(json);
    let mut resources = Resources::new(path, options.access, used);
    let buffers = buffers(&document, bin, &mut resources)?;
    let accessors = Accessors::new(&document, &buffers);
    let bytes = used + buffers.iter().map(Buffer::len).sum::<u64>();
    let budget = Budget::new(bytes, options.large);
    let moved = animate::at(&document, &accessors, &options.moment, &mut warnings)?;
    let nodes = nodes::place(&document, moved)?;
    // Before the first of them takes memory.
    budget.check_drawn(drawings(&document.root, &nodes), 0)?;
    let scene = Scene { warnings, ..Scene::default() };
    let mut loader = Loader::new(&document, &accessors, &nodes, &budget, scene);
    for &node in &nodes.in_scene {
        loader
            .add(node)
            .map_err(|fault| format!("{}: {fault}", node_label(&document.root, node)))?;
    }
    let (mut scene, textures, conversions) = loader.finish()?;
    let source = texture::Source {
        root: &document.root,
        extensions: &document.extensions,
        buffers: &buffers,
        resources: &mut resources,
        conversions: &conversions,
    };
    let textures = texture::load(source, &textures, &budget, &mut scene.warnings)?;
    scene.textures = texture::give(textures, &mut scene.materials);
    scene.named = resources.named(&document.root);
    scene.files = resources.files;
    scene.files.extend(libraries);
    Ok(scene)
}

/// All buffers; those that nothing uses, and those that stand in for compressed ones, are empty, whatever
/// they name.
fn buffers(
    document: &Document,
    mut bin: Option<Buffer>,
    resources: &mut Resources,
) -> Parsed<Vec<Buffer>> {
    let mut open = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let fallback = document.extensions.fallbacks.contains(&index);
        if fallback || !document.used.buffers.contains(&index) {
            return Ok(Buffer::Memory(Vec::new()));
        }
        let content = match (&buffer.uri, index) {
            (Some(uri), _) => resources.open(uri).map(Some),
            (None, 0) => Ok(bin.take()),
            _ => Ok(None),
        };
        let missing = || "it has neither a URI nor a GLB chunk".to_owned();
        let content = content.and_then(|content| content.ok_or_else(missing));
        let content = content.map_err(|fault| format!("buffers[{index}]: {fault}"))?;
        match content.len().cmp(&buffer.byte_length.0) {
            std::cmp::Ordering::Less => Err(format!(
                "buffers[{index}]{} has {} of its {} bytes",
                buffer.uri.as_deref().map_or(String::new(), |uri| format!(" {}", quoted(uri))),
                content.len(),
                buffer.byte_length.0
            )),
            _ => Ok(content),
        }
    };
    document.root.buffers.iter().enumerate().map(&mut open).collect()
}

/// Drawings that the scene's nodes ask for; instances of one node count once.
fn drawings(root: &Root, nodes: &Nodes) -> usize {
    let mesh = |&node: &usize| root.nodes[node].mesh.and_then(|mesh| root.get(mesh));
    let primitives = nodes.in_scene.iter().filter_map(mesh).map(|mesh| mesh.primitives.len());
    primitives.fold(0, usize::saturating_add)
}

/// What tells the meshes made from one glTF mesh apart: its morph weights, as bits, and the node
/// whose skin moves it.
type Variant = (usize, Vec<u32>, Option<usize>);

/// Builds a scene node by node.
struct Loader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    nodes: &'a Nodes,
    budget: &'a Budget,
    materials: Materials<'a>,
    /// For each variant its meshes, and whether they stand in the world already.
    known: HashMap<Variant, Arc<[(u32, bool)]>>,
    joints: HashMap<usize, Arc<[DMat4]>>,
    without_triangles: usize,
    scene: Scene,
}

impl<'a> Loader<'a> {
    fn new(
        document: &'a Document,
        accessors: &'a Accessors<'a>,
        nodes: &'a Nodes,
        budget: &'a Budget,
        scene: Scene,
    ) -> Self {
        Self {
            document,
            accessors,
            nodes,
            budget,
            materials: Materials::new(document),
            known: HashMap::new(),
            joints: HashMap::new(),
            without_triangles: 0,
            scene,
        }
    }

    /// Adds what a node holds: a mesh, a camera, a light.
    fn add(&mut self, node: usize) -> Parsed<()> {
        let root = &self.document.root;
        let json = &root.nodes[node];
        let world = self.nodes.world[node];
        if let Some(mesh) = json.mesh {
            self.add_instances(node, mesh.value())?;
        }
        if let Some(index) = json.camera {
            let lens = root.get(index).ok_or("its camera is not there")?;
            let name = json.name.as_deref().or(lens.name.as_deref()).map(|name| label(Some(name)));
            let name = name.unwrap_or_else(|| format!("camera {}", self.scene.cameras.len()));
            let designed = klieg(json.extras.as_deref())
                .and_then(|value| serde_json::from_value(value.get("camera")?.clone()).ok())
                .filter(|view: &DesignedView| !view.size.contains(&0));
            let camera = camera::convert(lens, name, &world, designed);
            self.scene.cameras.push(camera.map_err(|fault| format!("camera: {fault}"))?);
        }
        let extension = json.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(extension) = extension {
            let light = root.get(extension.light).ok_or("its light is not there")?;
            let klieg = klieg(json.extras.as_deref());
            let light = punctual::convert(light, json.name.as_deref(), &world, klieg);
            self.scene.lights.push(light.map_err(|fault| format!("light: {fault}"))?);
        }
        Ok(())
    }

    fn add_instances(&mut self, node: usize, mesh: usize) -> Parsed<()> {
        let meshes = self.meshes(node, mesh)?;
        let name = label(self.document.root.nodes[node].name.as_deref());
        let places = match self.document.extensions.instancing.get(&node) {
            Some(attributes) => instancing::places(self.accessors, attributes)
                .map_err(|fault| format!("EXT_mesh_gpu_instancing: {fault}"))?,
            None => vec![DMat4::IDENTITY],
        };
        for &(mesh, in_world) in meshes.iter() {
            let worlds = match in_world {
                // A skin's joints place the mesh, whatever its node says.
                true => vec![DMat4::IDENTITY],
                false => places.iter().map(|place| self.nodes.world[node] * *place).collect(),
            };
            for world in worlds {
                let title = || node_label(&self.document.root, node);
                self.scene.place(&name, mesh, world, title)?;
            }
        }
        self.budget.check_drawn(self.scene.instances.len(), self.scene.polygons())?;
        Ok(())
    }

    /// The meshes of a node's primitives, built unless another node has them already.
    fn meshes(&mut self, node: usize, mesh: usize) -> Parsed<Arc<[(u32, bool)]>> {
        let root = &self.document.root;
        let (json, json_mesh) = (&root.nodes[node], &root.meshes[mesh]);
        let moved = self.nodes.weights.get(&node);
        let weights = moved.or(json.weights.as_ref()).or(json_mesh.weights.as_ref());
        let morphs = json_mesh.primitives.iter().any(|p| p.targets.is_some());
        let weights = weights.filter(|_| morphs).cloned().unwrap_or_default();
        let bits = weights.iter().map(|weight| weight.to_bits()).collect();
        let variant = (mesh, bits, json.skin.map(|_| node));
        if let Some(meshes) = self.known.get(&variant) {
            return Ok(meshes.clone());
        }
        let title = match &json_mesh.name {
            Some(name) => format!("mesh {}", quoted(name)),
            None => format!("mesh {mesh}"),
        };
        let mut joints = None;
        if let Some(skin) = json.skin {
            if !self.joints.contains_key(&skin.value()) {
                let matrices = pose::joints(root, self.accessors, skin, &self.nodes.world)?;
                self.joints.insert(skin.value(), matrices);
            }
            joints = self.joints.get(&skin.value()).cloned();
        }
        let pose = Pose { weights, joints };
        let mut meshes = Vec::new();
        for index in 0..json_mesh.primitives.len() {
            let fault = |fault| format!("{title}, primitive {index}: {fault}");
            meshes.extend(self.primitive(mesh, index, &pose).map_err(fault)?);
        }
        let meshes: Arc<[_]> = meshes.into();
        self.known.insert(variant, meshes.clone());
        Ok(meshes)
    }

    /// Builds one primitive; `None` where it has no triangles.
    fn primitive(&mut self, mesh: usize, index: usize, pose: &Pose) -> Parsed<Option<(u32, bool)>> {
        let json_mesh = &self.document.root.meshes[mesh];
        let primitive = &json_mesh.primitives[index];
        if !mesh::has_triangles(primitive)? {
            self.without_triangles += 1;
            return Ok(None);
        }
        let compressed = self.document.extensions.draco.contains_key(&(mesh, index));
        if !self.budget.take_mesh(&self.document.root, primitive, compressed)? {
            let title = format!("mesh {mesh}, primitive {index}");
            let fault = "its positions or indices have no data: left out";
            warn(&mut self.scene.warnings, format!("{title}: {fault}"));
            return Ok(None);
        }
        self.accessors.decompress(mesh, index, self.document)?;
        let uv_sets = mesh::uv_sets(primitive);
        let warnings = &mut self.scene.warnings;
        let material = self.materials.number(primitive.material, uv_sets, warnings)?;
        let normal_texture = self.materials.get(material).and_then(|m| m.normal_texture);
        let normal_uv = normal_texture.map(|texture| texture.uv_set);
        let (mut mesh, in_world) = mesh::build(self.accessors, primitive, pose, normal_uv)?;
        if mesh.indices.is_empty() {
            return Ok(None);
        }
        mesh.name = label(json_mesh.name.as_deref());
        mesh.material = material;
        self.scene.meshes.push(mesh);
        Ok(Some((self.scene.meshes.len() as u32 - 1, in_world)))
    }

    /// The scene but for its textures, and what these are.
    fn finish(mut self) -> Parsed<(Scene, Vec<texture::Key>, Vec<Conversion>)> {
        let mut scene = self.scene;
        if self.without_triangles > 0 {
            let count = self.without_triangles;
            warn(
                &mut scene.warnings,
                format!("{count} primitives of points or lines are left out"),
            );
        }
        if scene.instances.is_empty() {
            return Err("its scene has no triangles".into());
        }
        let has_default = scene.meshes.iter().any(|mesh| mesh.material == DEFAULT);
        self.materials.settle(has_default, &mut scene.warnings);
        scene.materials = self.materials.list;
        scene.add_default_material();
        Ok((scene, self.materials.textures, self.materials.conversions))
    }
}

/// The `klieg` object of a node's extras.
fn klieg(extras: Option<&RawValue>) -> Option<Value> {
    let mut extras: Value = serde_json::from_str(extras?.get()).ok()?;
    extras.get_mut("klieg").filter(|value| value.is_object()).map(Value::take)
}

/// A node for messages.
fn node_label(root: &Root, node: usize) -> String {
    match root.nodes.get(node).and_then(|node| node.name.as_deref()) {
        Some(name) => format!("node {node} {}", quoted(name)),
        None => format!("node {node}"),
    }
}
