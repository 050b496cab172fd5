//! Materials and the textures that they use.

use super::document::Document;
use super::texture::Key;
use super::{Parsed, quoted};
use crate::scene::assemble::{DEFAULT, label, warn};
use crate::scene::{Material, TextureRef, Wrap};
use gltf::json::Index;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode, Material as Json};
use gltf::json::texture::{Info, Texture, WrappingMode};
use gltf::json::validation::Checked;
use std::collections::HashMap;

/// Most textures in a scene.
const MAX_TEXTURES: usize = 1 << 14;

/// The materials that meshes use, collected as they come.
pub struct Materials<'a> {
    document: &'a Document,
    /// By glTF material and by the coordinate sets of the mesh, as a texture needs its set.
    known: HashMap<(usize, [bool; 2]), u32>,
    /// Collected materials.
    pub list: Vec<Material>,
    /// The textures that they use, by index.
    pub textures: Vec<Key>,
}

/// A use of a texture, whichever kind it is.
struct Use<'a> {
    /// For messages.
    what: &'a str,
    texture: Index<Texture>,
    tex_coord: u32,
    transform: Option<&'a TextureTransform>,
    srgb: bool,
}

impl<'a> Materials<'a> {
    /// No material yet.
    pub fn new(document: &'a Document) -> Self {
        Self { document, known: HashMap::new(), list: Vec::new(), textures: Vec::new() }
    }

    /// The number of a glTF material on a mesh with the texture coordinate sets `uv_sets`, or
    /// [`DEFAULT`].
    pub fn number(
        &mut self,
        index: Option<Index<Json>>,
        uv_sets: [bool; 2],
        warnings: &mut Vec<String>,
    ) -> Parsed<u32> {
        let Some(index) = index.map(|index| index.value()) else { return Ok(DEFAULT) };
        if let Some(&number) = self.known.get(&(index, uv_sets)) {
            return Ok(number);
        }
        let json = self.document.root.materials.get(index).ok_or("its material is not there")?;
        let title = match &json.name {
            Some(name) => format!("material {}", quoted(name)),
            None => format!("material {index}"),
        };
        let material = self
            .convert(index, json, uv_sets, &title, warnings)
            .map_err(|fault| format!("{title}: {fault}"))?;
        let number = self.list.len() as u32;
        self.list.push(material);
        self.known.insert((index, uv_sets), number);
        Ok(number)
    }

    /// A collected material; `None` for [`DEFAULT`].
    pub fn get(&self, number: u32) -> Option<&Material> {
        self.list.get(number as usize)
    }

    fn convert(
        &mut self,
        index: usize,
        json: &'a Json,
        uv_sets: [bool; 2],
        title: &str,
        warnings: &mut Vec<String>,
    ) -> Parsed<Material> {
        let pbr = &json.pbr_metallic_roughness;
        let mut texture = |what, info: Option<&'a Info>, srgb| match info {
            Some(info) => {
                let extensions = info.extensions.as_ref();
                let transform = extensions.and_then(|e| e.texture_transform.as_ref());
                let (texture, tex_coord) = (info.index, info.tex_coord);
                let using = Use { what, texture, tex_coord, transform, srgb };
                self.texture(using, uv_sets, title, warnings)
            }
            None => Ok(None),
        };
        let base_color_texture = texture("base colour", pbr.base_color_texture.as_ref(), true)?;
        let metallic_roughness_texture =
            texture("metallic-roughness", pbr.metallic_roughness_texture.as_ref(), false)?;
        let emissive_texture = texture("emissive", json.emissive_texture.as_ref(), true)?;
        let normal_texture = match &json.normal_texture {
            Some(info) => {
                let using = Use {
                    what: "normal",
                    texture: info.index,
                    tex_coord: info.tex_coord,
                    transform: self.document.extensions.normal_transforms.get(&index),
                    srgb: false,
                };
                self.texture(using, uv_sets, title, warnings)?
            }
            None => None,
        };
        let extensions = json.extensions.as_ref();
        if extensions.is_some_and(|extensions| extensions.unlit.is_some()) {
            warn(warnings, format!("{title} is unlit: drawn lit"));
        }
        let strength = extensions
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let material = Material {
            name: label(json.name.as_deref()),
            base_color: pbr.base_color_factor.0,
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            emissive: json.emissive_factor.0.map(|channel| channel * strength),
            base_color_texture,
            metallic_roughness_texture,
            normal_texture,
            normal_scale: json.normal_texture.as_ref().map_or(1.0, |info| info.scale),
            emissive_texture,
            alpha_cutoff: alpha_cutoff(json, title, warnings)?,
            double_sided: json.double_sided,
        };
        material.checked()
    }

    /// Registers a texture; `None`, with a warning, where it cannot be used.
    fn texture(
        &mut self,
        using: Use,
        uv_sets: [bool; 2],
        title: &str,
        warnings: &mut Vec<String>,
    ) -> Parsed<Option<TextureRef>> {
        let Use { what, texture, tex_coord, transform, srgb } = using;
        let root = &self.document.root;
        let json = root.get(texture).ok_or_else(|| format!("its {what} texture is not there"))?;
        // The model marks a texture without a source so.
        let own = Some(json.source.value()).filter(|&image| image != u32::MAX as usize);
        let image = own.or_else(|| self.document.extensions.images.get(&texture.value()).copied());
        let uv_set = transform.and_then(|transform| transform.tex_coord).unwrap_or(tex_coord);
        let fault = match uv_sets.get(uv_set as usize) {
            _ if image.is_none() => Some("has no image that klieg reads".to_owned()),
            Some(true) => None,
            Some(false) => Some(format!("needs TEXCOORD_{uv_set}, which a mesh lacks")),
            None => Some(format!("uses TEXCOORD_{uv_set}; klieg reads sets 0 and 1")),
        };
        if let Some(fault) = fault {
            warn(warnings, format!("{title}: its {what} texture {fault}: left out"));
            return Ok(None);
        }
        let image = image.unwrap_or_default();
        if image >= root.images.len() {
            return Err(format!("the image of its {what} texture is not there"));
        }
        let sampler = json.sampler.and_then(|sampler| root.get(sampler));
        let wrap = match sampler {
            Some(sampler) => [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?],
            None => [Wrap::Repeat; 2],
        };
        let key = Key { image, srgb, wrap };
        let known = self.textures.iter().position(|other| *other == key);
        if known.is_none() && self.textures.len() == MAX_TEXTURES {
            return Err(format!("the scene uses more than {MAX_TEXTURES} textures"));
        }
        let texture = known.unwrap_or_else(|| {
            self.textures.push(key);
            self.textures.len() - 1
        });
        let transform = transform.map_or(TextureRef::UNMOVED, rows);
        if !transform.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(format!("the transform of its {what} texture is not finite"));
        }
        Ok(Some(TextureRef { texture: texture as u32, uv_set, transform }))
    }
}

/// KHR_texture_transform: scaled, then turned counter-clockwise as seen with v downwards, then
/// moved.
fn rows(transform: &TextureTransform) -> [[f32; 3]; 2] {
    let ([sx, sy], [ox, oy]) = (transform.scale.0, transform.offset.0);
    let (sin, cos) = transform.rotation.0.sin_cos();
    [[sx * cos, sy * sin, ox], [-sx * sin, sy * cos, oy]]
}

fn wrap(mode: Checked<WrappingMode>) -> Parsed<Wrap> {
    match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::Mirror),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::Clamp),
        Checked::Invalid => Err("a sampler's wrapping mode is none of glTF's".into()),
    }
}

/// A hair below the file's number, so that rounding in interpolation punches no holes into what has
/// just that alpha.
fn alpha_cutoff(json: &Json, title: &str, warnings: &mut Vec<String>) -> Parsed<f32> {
    match json.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => Ok(0.0),
        Checked::Valid(AlphaMode::Mask) => Ok(json.alpha_cutoff.unwrap_or_default().0 - HAIR),
        Checked::Valid(AlphaMode::Blend) => {
            let fault = "is blended: drawn solid where its alpha is at least 0.5";
            warn(warnings, format!("{title} {fault}"));
            Ok(0.5 - HAIR)
        }
        Checked::Invalid => Err("its alpha mode is none of glTF's".into()),
    }
}

/// More than the rounding of an interpolated alpha, less than a step of 8 bits.
const HAIR: f32 = 1e-4;
