//! What extensions of a material make of its base colour, metallic and roughness, as far as these can tell it.

use crate::scene::Material;
use glam::{Vec3, Vec4};
use gltf::json::texture::Info;
use serde::Deserialize;

/// Reflectance of a dielectric at normal incidence, as glTF has it without an extension.
const DIELECTRIC: f32 = 0.04;
/// Share of the light that sheen takes from what it covers, at its strongest (its directional albedo over all
/// directions, as three.js has it).
const SHEEN: f32 = 0.157;
/// A material through which more than this goes is not drawn.
pub const SEE_THROUGH: f32 = 0.5;

/// The extensions of a material that are read.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Appearance {
    /// In place of metallic and roughness.
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_ior")]
    ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular")]
    specular: Option<Specular>,
    #[serde(rename = "KHR_materials_clearcoat")]
    clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_transmission")]
    transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_sheen")]
    sheen: Option<Sheen>,
}

/// KHR_materials_pbrSpecularGlossiness.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct SpecularGlossiness {
    /// Linear, with alpha.
    pub diffuse_factor: [f32; 4],
    /// sRGB diffuse colour and linear alpha.
    pub diffuse_texture: Option<Info>,
    /// Linear, at normal incidence.
    pub specular_factor: [f32; 3],
    /// 0..1: 1 less the roughness.
    pub glossiness_factor: f32,
    /// sRGB specular colour; glossiness in alpha.
    pub specular_glossiness_texture: Option<Info>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(default)]
struct Ior {
    ior: f32,
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Specular {
    specular_factor: f32,
    specular_color_factor: [f32; 3],
}

impl Default for Specular {
    fn default() -> Self {
        Self { specular_factor: 1.0, specular_color_factor: [1.0; 3] }
    }
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Clearcoat {
    clearcoat_factor: f32,
    clearcoat_roughness_factor: f32,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Transmission {
    transmission_factor: f32,
    transmission_texture: Option<serde::de::IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Sheen {
    sheen_color_factor: [f32; 3],
}

impl Appearance {
    /// Changes the factors of a material of metallic and roughness. Textures of these extensions count as
    /// white.
    pub fn apply(&self, material: &mut Material) {
        let plain = material.metallic_roughness_texture.is_none();
        if let Some(sheen) = &self.sheen {
            let color = Vec3::from(sheen.sheen_color_factor).clamp(Vec3::ZERO, Vec3::ONE);
            let own =
                if material.base_color_texture.is_none() { color * SHEEN } else { Vec3::ZERO };
            let kept = 1.0 - SHEEN * color.max_element();
            set(material, rgb(material) * kept + own);
        }
        if plain {
            self.reflect(material);
        }
        if let Some(coat) = self.clearcoat.as_ref().filter(|_| plain && material.metallic < 0.5) {
            let share = coat.clearcoat_factor.clamp(0.0, 1.0);
            let rougher = coat.clearcoat_roughness_factor.clamp(0.0, 1.0) - material.roughness;
            material.roughness += share * rougher;
        }
        let through = self.transmission();
        if through > SEE_THROUGH {
            material.base_color[3] *= 1.0 - through;
        } else if through > 0.0 {
            set(material, rgb(material) * (1.0 - through * (1.0 - material.metallic)));
        }
    }

    /// The share of light that goes through the material everywhere.
    pub fn transmission(&self) -> f32 {
        let transmission = self.transmission.as_ref();
        let even = transmission.filter(|transmission| transmission.transmission_texture.is_none());
        even.map_or(0.0, |transmission| transmission.transmission_factor.clamp(0.0, 1.0))
    }

    /// KHR_materials_ior and KHR_materials_specular: a dielectric that reflects more than glTF's is in part a
    /// metal.
    fn reflect(&self, material: &mut Material) {
        let ior = self.ior.as_ref().map_or(1.5, |ior| ior.ior);
        // An index of 0 stands for an infinite one.
        let normal = if ior >= 1.0 { ((ior - 1.0) / (ior + 1.0)).powi(2) } else { 1.0 };
        let default = Specular::default();
        let Specular { specular_factor, specular_color_factor } =
            self.specular.as_ref().unwrap_or(&default);
        let specular = Vec3::from(*specular_color_factor) * normal * *specular_factor;
        let specular = specular.clamp(Vec3::ZERO, Vec3::ONE);
        if specular.max_element() <= DIELECTRIC * 1.01 || !specular.is_finite() {
            return;
        }
        let (base, metallic) = metallic_of(rgb(material), specular);
        let own = material.metallic;
        set(material, rgb(material).lerp(base, 1.0 - own));
        material.metallic = own + (1.0 - own) * metallic;
    }
}

fn rgb(material: &Material) -> Vec3 {
    Vec4::from(material.base_color).truncate()
}

fn set(material: &mut Material, rgb: Vec3) {
    let alpha = material.base_color[3];
    material.base_color = rgb.clamp(Vec3::ZERO, Vec3::ONE).extend(alpha).to_array();
}

/// Base colour and metallic of what reflects `diffuse` and, at normal incidence, `specular`: the conversion
/// that Khronos gives with KHR_materials_pbrSpecularGlossiness.
pub fn metallic_of(diffuse: Vec3, specular: Vec3) -> (Vec3, f32) {
    const EPSILON: f32 = 1e-6;
    let brightness = |color: Vec3| (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt();
    let rest = 1.0 - specular.max_element();
    let (d, s) = (brightness(diffuse), brightness(specular));
    let metallic = if s < DIELECTRIC {
        0.0
    } else {
        let a = DIELECTRIC;
        let b = d * rest / (1.0 - a) + s - 2.0 * a;
        let c = a - s;
        ((-b + (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a)).clamp(0.0, 1.0)
    };
    let of_diffuse = diffuse * (rest / (1.0 - DIELECTRIC) / (1.0 - metallic).max(EPSILON));
    let of_specular = (specular - DIELECTRIC * (1.0 - metallic)) * (1.0 / metallic.max(EPSILON));
    let base = of_diffuse.lerp(of_specular, metallic * metallic);
    (base.clamp(Vec3::ZERO, Vec3::ONE), metallic)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a base colour and metallic reflect diffusely and at normal incidence.
    fn reflected(base: Vec3, metallic: f32) -> [Vec3; 2] {
        [base * (1.0 - metallic), Vec3::splat(DIELECTRIC).lerp(base, metallic)]
    }

    #[test]
    fn metals_and_dielectrics_come_back() {
        for (base, metallic) in [
            (Vec3::new(0.8, 0.3, 0.1), 0.0),
            (Vec3::new(0.9, 0.7, 0.3), 1.0),
            (Vec3::new(0.2, 0.2, 0.2), 1.0),
        ] {
            let [diffuse, specular] = reflected(base, metallic);
            // The extension's diffuse part is dimmed by what is reflected.
            let diffuse = diffuse * ((1.0 - DIELECTRIC) / (1.0 - specular.max_element()));
            let (base_again, metallic_again) = metallic_of(diffuse, specular);
            assert!((metallic - metallic_again).abs() < 1e-3, "{metallic} {metallic_again}");
            assert!(base.abs_diff_eq(base_again, 1e-3), "{base} {base_again}");
        }
        let (black, _) = metallic_of(Vec3::ZERO, Vec3::ZERO);
        assert_eq!(black, Vec3::ZERO);
    }

    fn applied(json: serde_json::Value, material: Material) -> Material {
        let mut material = material;
        serde_json::from_value::<Appearance>(json).expect("extensions").apply(&mut material);
        material
    }

    fn plastic() -> Material {
        Material { base_color: [0.5, 0.5, 0.5, 1.0], metallic: 0.0, ..Material::default() }
    }

    #[test]
    fn each_extension_changes_what_it_should() {
        let same = applied(serde_json::json!({"KHR_materials_ior": {"ior": 1.5}}), plastic());
        assert_eq!((same.base_color, same.metallic), (plastic().base_color, 0.0));
        let glossy = applied(serde_json::json!({"KHR_materials_ior": {"ior": 2.4}}), plastic());
        assert!(glossy.metallic > 0.05 && glossy.metallic < 0.5, "{}", glossy.metallic);
        // What is not reflected at once is what the base colour has a share of.
        for (ior, specular) in [(1.508, 0.041_f32), (1.8, 0.0816), (2.4, 0.1696)] {
            let ior = serde_json::json!({"KHR_materials_ior": {"ior": ior}});
            let Material { base_color: [base, ..], metallic, .. } = applied(ior, plastic());
            let [diffuse, at_once] = reflected(Vec3::splat(base), metallic).map(|color| color.x);
            let expected = 0.5 * (1.0 - specular) / (1.0 - DIELECTRIC);
            assert!((diffuse - expected).abs() < 0.02, "{specular}: {diffuse} {expected}");
            assert!((at_once - specular).abs() < 0.02, "{specular}: {at_once}");
        }
        let coat = serde_json::json!({"KHR_materials_clearcoat":
            {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.1}});
        assert!((applied(coat.clone(), plastic()).roughness - 0.1).abs() < 1e-6);
        assert_eq!(applied(coat, Material::default()).roughness, 1.0, "a metal keeps its own");
        let sheen = serde_json::json!({"KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0]}});
        let [r, g, ..] = applied(sheen, plastic()).base_color;
        assert!(r > 0.5 && g < 0.5);
        let through = |factor| serde_json::json!({"KHR_materials_transmission": {"transmissionFactor": factor}});
        assert_eq!(applied(through(0.9), plastic()).base_color[3], 1.0 - 0.9);
        assert_eq!(applied(through(0.4), plastic()).base_color, [0.3, 0.3, 0.3, 1.0]);
    }
}
