//! Materials and the textures that they use.

use super::appearance::{SEE_THROUGH, SpecularGlossiness};
use super::document::Document;
use super::glossiness::{Conversion, Part};
use super::texture::{Content, Key};
use super::{Parsed, quoted};
use crate::scene::assemble::{DEFAULT, label, warn};
use crate::scene::{Material, TextureRef, Wrap};
use glam::Vec4;
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
    /// What some of the textures are made by.
    pub conversions: Vec<Conversion>,
    /// Numbers of the materials that are unlit.
    unlit: Vec<u32>,
    /// Numbers of those that one sees through.
    see_through: Vec<u32>,
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

impl<'a> Use<'a> {
    /// A use by a texture information.
    fn of(what: &'a str, info: &'a Info, srgb: bool) -> Self {
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.as_ref());
        Self { what, texture: info.index, tex_coord: info.tex_coord, transform, srgb }
    }
}

/// Where a texture comes from.
#[derive(Clone, Copy)]
struct Found {
    image: usize,
    wrap: [Wrap; 2],
    uv_set: u32,
    transform: [[f32; 3]; 2],
}

impl<'a> Materials<'a> {
    /// No material yet.
    pub fn new(document: &'a Document) -> Self {
        Self {
            document,
            known: HashMap::new(),
            list: Vec::new(),
            textures: Vec::new(),
            conversions: Vec::new(),
            unlit: Vec::new(),
            see_through: Vec::new(),
        }
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
        if json.extensions.as_ref().is_some_and(|extensions| extensions.unlit.is_some()) {
            self.unlit.push(number);
        }
        if !matches!(json.alpha_mode, Checked::Valid(AlphaMode::Mask))
            && material.alpha_cutoff > material.base_color[3]
        {
            self.see_through.push(number);
        }
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
            Some(info) => self.texture(Use::of(what, info, srgb), uv_sets, title, warnings),
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
        let strength = extensions
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let mut material = Material {
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
            alpha_cutoff: 0.0,
            double_sided: json.double_sided,
        };
        let mut through = 0.0;
        if let Some(appearance) = self.document.extensions.appearances.get(&index) {
            if let Some(glossiness) = &appearance.specular_glossiness {
                self.convert_glossiness(glossiness, &mut material, uv_sets, title, warnings)?;
            }
            appearance.apply(&mut material);
            through = appearance.transmission();
        }
        material.alpha_cutoff = alpha_cutoff(json, through, title, warnings)?;
        material.checked()
    }

    /// Gives a material the factors and textures that stand for KHR_materials_pbrSpecularGlossiness.
    fn convert_glossiness(
        &mut self,
        json: &'a SpecularGlossiness,
        material: &mut Material,
        uv_sets: [bool; 2],
        title: &str,
        warnings: &mut Vec<String>,
    ) -> Parsed<()> {
        let mut find = |what, info: &'a Option<Info>| match info {
            Some(info) => self.find(Use::of(what, info, true), uv_sets, title, warnings),
            None => Ok(None),
        };
        let diffuse = find("diffuse", &json.diffuse_texture)?;
        let specular = find("specular-glossiness", &json.specular_glossiness_texture)?;
        let conversion = Conversion {
            diffuse: diffuse.map(|found| found.image),
            specular: specular.map(|found| found.image),
            diffuse_factor: json.diffuse_factor,
            specular_factor: json.specular_factor,
            glossiness: json.glossiness_factor,
        };
        if let (Some(one), Some(other)) = (diffuse, specular)
            && (one.uv_set, one.transform) != (other.uv_set, other.transform)
        {
            let fault = "has its specular-glossiness texture in another place than its diffuse one";
            warn(warnings, format!("{title} {fault}: read as if in the same"));
        }
        let Some(Found { wrap, uv_set, transform, .. }) = diffuse.or(specular) else {
            let (base, metallic, roughness) = conversion.converted(Vec4::ONE, Vec4::ONE);
            material.base_color = base.to_array();
            (material.metallic, material.roughness) = (metallic, roughness);
            (material.base_color_texture, material.metallic_roughness_texture) = (None, None);
            return Ok(());
        };
        self.conversions.push(conversion);
        let index = self.conversions.len() - 1;
        let mut texture = |part, srgb| {
            let key = Key { content: Content::Converted(index, part), srgb, wrap };
            Ok::<_, String>(Some(TextureRef { texture: self.register(key)?, uv_set, transform }))
        };
        material.base_color_texture = texture(Part::BaseColor, true)?;
        material.metallic_roughness_texture = texture(Part::MetallicRoughness, false)?;
        material.base_color = [1.0; 4];
        (material.metallic, material.roughness) = (1.0, 1.0);
        Ok(())
    }

    /// Once all are collected: what is unlit shines by itself, and what one sees through is not drawn, unless
    /// there is nothing else; `has_default` says whether the default material is used too.
    pub fn settle(&mut self, has_default: bool, warnings: &mut Vec<String>) {
        let others = |few: &[u32]| has_default || few.len() < self.list.len();
        let (lit, solid) = (others(&self.unlit), others(&self.see_through));
        for &number in &self.unlit {
            let material = &mut self.list[number as usize];
            let title = quoted(&material.name);
            if !lit {
                let text = "is unlit: drawn lit, though viewers will show no light on it";
                warn(warnings, format!("material {title} {text}"));
                continue;
            }
            warn(warnings, format!("material {title} is unlit: it shines by itself"));
            let [r, g, b, alpha] = material.base_color;
            material.emissive = [r, g, b];
            material.emissive_texture = material.base_color_texture;
            material.base_color = [0.0, 0.0, 0.0, alpha];
            material.metallic_roughness_texture = None;
            (material.metallic, material.roughness) = (0.0, 1.0);
        }
        for &number in self.see_through.iter().filter(|_| !solid) {
            let material = &mut self.list[number as usize];
            material.alpha_cutoff = 0.0;
            let text = "is transparent as all else: drawn solid";
            warn(warnings, format!("material {} {text}", quoted(&material.name)));
        }
    }

    /// Registers a texture; `None`, with a warning, where it cannot be used.
    fn texture(
        &mut self,
        using: Use,
        uv_sets: [bool; 2],
        title: &str,
        warnings: &mut Vec<String>,
    ) -> Parsed<Option<TextureRef>> {
        let srgb = using.srgb;
        let Some(found) = self.find(using, uv_sets, title, warnings)? else { return Ok(None) };
        let Found { image, wrap, uv_set, transform } = found;
        let texture = self.register(Key { content: Content::Image(image), srgb, wrap })?;
        Ok(Some(TextureRef { texture, uv_set, transform }))
    }

    /// The number of a texture.
    fn register(&mut self, key: Key) -> Parsed<u32> {
        let known = self.textures.iter().position(|other| *other == key);
        if known.is_none() && self.textures.len() == MAX_TEXTURES {
            return Err(format!("the scene uses more than {MAX_TEXTURES} textures"));
        }
        let texture = known.unwrap_or_else(|| {
            self.textures.push(key);
            self.textures.len() - 1
        });
        Ok(texture as u32)
    }

    /// Where a texture comes from; `None`, with a warning, where it cannot be used.
    fn find(
        &self,
        using: Use,
        uv_sets: [bool; 2],
        title: &str,
        warnings: &mut Vec<String>,
    ) -> Parsed<Option<Found>> {
        let Use { what, texture, tex_coord, transform, .. } = using;
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
        let transform = transform.map_or(TextureRef::UNMOVED, rows);
        if !transform.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(format!("the transform of its {what} texture is not finite"));
        }
        Ok(Some(Found { image, wrap, uv_set, transform }))
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
/// just that alpha. `through` is the share of light that the material transmits.
fn alpha_cutoff(json: &Json, through: f32, title: &str, warnings: &mut Vec<String>) -> Parsed<f32> {
    match json.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) if through > SEE_THROUGH => {
            let fault = "lets light through: left out, with its shadow";
            warn(warnings, format!("{title} {fault}"));
            Ok(SEE_THROUGH - HAIR)
        }
        Checked::Valid(AlphaMode::Opaque) => Ok(0.0),
        Checked::Valid(AlphaMode::Mask) => Ok(json.alpha_cutoff.unwrap_or_default().0 - HAIR),
        Checked::Valid(AlphaMode::Blend) => {
            let fault = "is blended: drawn solid where its alpha is at least 0.5";
            warn(warnings, format!("{title} {fault}"));
            Ok(SEE_THROUGH - HAIR)
        }
        Checked::Invalid => Err("its alpha mode is none of glTF's".into()),
    }
}

/// More than the rounding of an interpolated alpha, less than a step of 8 bits.
const HAIR: f32 = 1e-4;
