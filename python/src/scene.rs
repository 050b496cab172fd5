//! Scenes, of files and of arrays.

use crate::error::{OrRaise as _, refused};
use crate::settings::Settings;
use bytemuck::cast_slice;
use glam::{DMat4, DVec3};
use klieg::lighting::{Cone, LightKind};
use klieg::scene;
use klieg::scene::build::{MeshData, TextureData};
use klieg::scene::{Material, SceneLight, TextureRef};
use klieg::session::Loaded;
use numpy::{Element, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use std::f32::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// A scene.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct Scene {
    /// The scene.
    pub loaded: Loaded,
    /// How its file was loaded, which the lit scene is made of; none of a scene of arrays.
    pub options: Option<scene::load::LoadOptions>,
    /// Holds the file of a scene that was given as bytes.
    pub folder: Option<Arc<TempDir>>,
}

#[pymethods]
impl Scene {
    /// Loads a file as the settings say.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, settings: &Settings) -> PyResult<Self> {
        py.detach(|| Self::read(&path, settings, None)).or_raise()
    }

    /// Loads the bytes of a file that would have this ending.
    #[staticmethod]
    fn from_bytes(
        py: Python<'_>,
        data: &[u8],
        ending: &str,
        settings: &Settings,
    ) -> PyResult<Self> {
        py.detach(|| -> anyhow::Result<Self> {
            let folder = tempfile::Builder::new().prefix("klieg-").tempdir()?;
            let path = folder.path().join("scene").with_extension(ending);
            std::fs::write(&path, data)?;
            Ok(Self::read(&path, settings, Some(Arc::new(folder)))?)
        })
        .or_raise()
    }

    /// The file, or the name of a scene of arrays.
    #[getter]
    fn path(&self) -> PathBuf {
        self.loaded.scene.path.clone()
    }

    /// Whether there is a file of which a lit scene can be made.
    #[getter]
    fn has_file(&self) -> bool {
        self.options.is_some()
    }

    /// Triangles that are drawn.
    #[getter]
    fn polygons(&self) -> u32 {
        self.loaded.scene.polygons()
    }

    /// Names of the cameras.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        self.loaded.scene.cameras.iter().map(|camera| camera.name.clone()).collect()
    }

    /// Number of the scene's own lights.
    #[getter]
    fn own_lights(&self) -> usize {
        scene::lights::own(&self.loaded.scene).count()
    }

    /// What was left out or replaced in loading.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.loaded.scene.warnings.clone()
    }

    /// Centre and radius of what is drawn, world units.
    fn bounds(&self, py: Python<'_>) -> PyResult<([f64; 3], f64)> {
        let (center, radius) = py.detach(|| scene::view::bounds(&self.loaded.scene)).or_raise()?;
        Ok((center.to_array(), radius))
    }
}

impl Scene {
    fn read(
        path: &std::path::Path,
        Settings(settings): &Settings,
        folder: Option<Arc<TempDir>>,
    ) -> klieg::Result<Self> {
        let options = settings.loading();
        let loaded = Loaded::read(path, &options)?;
        klieg::session::warn(&loaded.scene.warnings);
        Ok(Self { loaded, options: Some(options), folder })
    }
}

/// Makes a scene of arrays.
#[pyclass(module = "klieg._klieg")]
#[derive(Default)]
pub struct SceneBuilder {
    builder: scene::build::SceneBuilder,
    lights: Vec<SceneLight>,
}

/// The rows of an array of `N` columns.
fn rows<'a, T: Element + bytemuck::Pod, const N: usize>(
    array: &'a PyReadonlyArray2<'_, T>,
    what: &str,
) -> PyResult<&'a [[T; N]]>
where
    [T; N]: bytemuck::Pod,
{
    let columns = array.as_array().ncols();
    if columns != N {
        return Err(refused(format!("{what} have {columns} columns: they must have {N}")));
    }
    let slice = array.as_slice().map_err(|_| refused(format!("{what} are not contiguous")))?;
    Ok(cast_slice(slice))
}

type Floats<'py> = PyReadonlyArray2<'py, f32>;

#[pymethods]
impl SceneBuilder {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Adds a texture of `uint8[rows, columns, 4]`; gives its number.
    fn texture(
        &mut self,
        name: &str,
        texels: PyReadonlyArray3<'_, u8>,
        srgb: bool,
    ) -> PyResult<u32> {
        let [height, width, 4] = *texels.as_array().shape() else {
            return Err(refused("texels must be of the shape [rows, columns, 4]"));
        };
        let slice = texels.as_slice().map_err(|_| refused("texels are not contiguous"))?;
        let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        let (width, height) = (side(width), side(height));
        let (texels, wrap) = (cast_slice(slice), Default::default());
        let data = TextureData { name, width, height, texels, srgb, wrap };
        self.builder.add_texture(&data).or_raise()
    }

    /// Adds a material; gives its number. `textures`: base colour, metallic and roughness, normals, emitted light.
    #[expect(
        clippy::too_many_arguments,
        reason = "the values of a material, by position from one caller"
    )]
    fn material(
        &mut self,
        name: String,
        base_color: [f32; 4],
        metallic: f32,
        roughness: f32,
        emissive: [f32; 3],
        textures: [Option<u32>; 4],
        alpha_cutoff: f32,
        double_sided: bool,
    ) -> PyResult<u32> {
        let [base, surface, normal, emitted] = textures.map(|number| number.map(TextureRef::new));
        let material = Material {
            name,
            base_color,
            metallic,
            roughness,
            emissive,
            base_color_texture: base,
            metallic_roughness_texture: surface,
            normal_texture: normal,
            emissive_texture: emitted,
            alpha_cutoff,
            double_sided,
            ..Material::default()
        };
        self.builder.add_material(material).or_raise()
    }

    /// Adds a mesh; gives its number.
    #[expect(
        clippy::too_many_arguments,
        reason = "the arrays of a mesh, by position from one caller"
    )]
    fn mesh(
        &mut self,
        name: &str,
        positions: Floats<'_>,
        indices: Option<PyReadonlyArray2<'_, u32>>,
        normals: Option<Floats<'_>>,
        uvs: Option<Floats<'_>>,
        colors: Option<PyReadonlyArray2<'_, u8>>,
        material: Option<u32>,
    ) -> PyResult<u32> {
        let indices = indices.as_ref().map(|i| rows::<u32, 3>(i, "faces")).transpose()?;
        let data = MeshData {
            name,
            positions: rows(&positions, "positions")?,
            normals: normals.as_ref().map(|n| rows(n, "normals")).transpose()?,
            uvs: [uvs.as_ref().map(|uv| rows(uv, "uvs")).transpose()?, None],
            colors: colors.as_ref().map(|c| rows(c, "colors")).transpose()?,
            indices: indices.map(<[[u32; 3]]>::as_flattened),
            material,
            ..MeshData::default()
        };
        self.builder.add_mesh(&data).or_raise()
    }

    /// Draws a mesh by a matrix from its space into the world.
    fn instance(&mut self, name: &str, mesh: u32, world: [[f64; 4]; 4]) -> PyResult<()> {
        let world = DMat4::from_cols_array_2d(&world).transpose();
        self.builder.add_instance(name, mesh, world).or_raise()
    }

    /// Adds a light of the scene's own: place and direction in the world, linear colour, candela or lux, and the inner and
    /// outer half angle of a spot, degrees.
    #[expect(
        clippy::too_many_arguments,
        reason = "the values of a light, by position from one caller"
    )]
    fn light(
        &mut self,
        name: String,
        kind: &str,
        position: [f64; 3],
        direction: [f64; 3],
        color: [f32; 3],
        intensity: f32,
        cone: (f32, f32),
    ) -> PyResult<()> {
        let fault = |fault: &str| refused(format!("light '{name}': {fault}"));
        let towards = DVec3::from(direction).try_normalize();
        let finite = position.iter().all(|x| x.is_finite());
        let strong = color.iter().chain([&intensity]).all(|x| x.is_finite() && *x >= 0.0);
        let (inner, outer) = (cone.0.to_radians(), cone.1.to_radians());
        if !(finite && strong && inner >= 0.0 && inner < outer && outer <= FRAC_PI_2) {
            return Err(fault("a value of it is out of its range"));
        }
        let direction = towards.ok_or_else(|| fault("its direction has no length"))?;
        let kind = LightKind::named(kind).or_raise()?;
        let (position, cone) = (position.into(), Cone { inner, outer });
        let (range, klieg) = (None, None);
        self.lights.push(SceneLight {
            name,
            position,
            direction,
            kind,
            cone,
            color,
            intensity,
            range,
            klieg,
        });
        Ok(())
    }

    /// The scene; the builder is empty afterwards.
    fn finish(&mut self, name: &str) -> PyResult<Scene> {
        let mut scene = std::mem::take(&mut self.builder).finish(name).or_raise()?;
        scene.lights = std::mem::take(&mut self.lights);
        klieg::session::warn(&scene.warnings);
        let loaded = Loaded { scene: Arc::new(scene), load: 0.0 };
        Ok(Scene { loaded, options: None, folder: None })
    }
}
