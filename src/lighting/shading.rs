//! Local illumination without shadows, as in Shacked and Lischinski (2001), section 3; materials are
//! glTF metallic-roughness (glTF 2.0 specification, appendix B, simplified to a Blinn-Phong lobe of
//! the same width). The reconstruction is ours: `docs/METHOD.md`.

use super::LightRecord;
use crate::Result;
pub use crate::constants::MIN_ROUGHNESS;
use crate::constants::{
    BRDF_GLTF_SCATTERING, SCATTERED_LEAST, SCATTERING_0, SCATTERING_1, SCATTERING_2,
};
use crate::error::within;
use crate::math::color::luminance;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// How surfaces reflect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Brdf {
    /// Lambert, and a normalised Blinn-Phong lobe of the material's width.
    #[default]
    BlinnPhong,
    /// That of the glTF 2.0 specification, appendix B: a metal and a dielectric, mixed; GGX, the
    /// height-correlated Smith masking-shadowing function, Schlick's Fresnel term, and Lambert below the
    /// dielectric's surface.
    Gltf,
    /// The same with what rough surfaces scatter more than once, as path tracers and viewers add it to the
    /// specification: the specular part is multiplied with `1 + F0·(1/E − 1)`, `E` the share that a white metal
    /// reflects at once (Turquin 2019, *Practical multiple scattering compensation for microfacet models*).
    GltfScattering,
}

impl Brdf {
    /// Its number in shaders.
    pub fn number(self) -> u32 {
        match self {
            Self::BlinnPhong => 0,
            Self::Gltf => 1,
            Self::GltfScattering => BRDF_GLTF_SCATTERING,
        }
    }

    /// Whether it is that of glTF, in either form.
    pub fn is_gltf(self) -> bool {
        self != Self::BlinnPhong
    }
}

/// The shading model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shading {
    /// How surfaces reflect.
    pub brdf: Brdf,
    /// Share of the base colour that is seen without any light.
    pub ambient: f32,
    /// Specular reflectance of dielectrics at normal incidence.
    pub dielectric: f32,
    /// Largest Blinn-Phong exponent, 1 or more; the smallest is 1.
    pub max_shininess: f32,
}

impl Default for Shading {
    fn default() -> Self {
        Self { brdf: Brdf::default(), ambient: 0.03, dielectric: 0.04, max_shininess: 4096.0 }
    }
}

/// How a point of a surface reflects light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflectance {
    /// `Kd = base·(1−metallic)`, linear RGB.
    pub diffuse: Vec3,
    /// `Ks·(s+8)/8` with `Ks = mix(0.04, base, metallic)`, linear RGB: the lobe's normalisation is
    /// part of it.
    pub specular: Vec3,
    /// Reflectance at normal incidence `F0 = mix(0.04, base, metallic)`, linear RGB.
    pub normal_incidence: Vec3,
    /// `diffuse·(1−0.04)`: what is left of it below a dielectric's surface that is seen at normal incidence.
    pub covered: Vec3,
    /// Width of the GGX lobe, `α = max(roughness, 0.0525)²`.
    pub alpha: f32,
    /// Blinn-Phong exponent `s = 2/α² − 2` in 1..=4096, with `α = roughness²`.
    pub shininess: f32,
    /// `0.03·base + emissive`, linear RGB.
    pub unlit: Vec3,
}

/// What the two parts of a BRDF are computed from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Of the diffuse part, linear RGB.
    pub diffuse: Vec3,
    /// Of the specular part, linear RGB: with the normalisation of Blinn-Phong, else at normal incidence.
    pub specular: Vec3,
    /// Width of the lobe: `s/2` of Blinn-Phong, else `α²`.
    pub lobe: f32,
}

impl Reflectance {
    /// What `brdf` is computed from, seen at the cosine `n_v` from the normal.
    pub fn coefficients(&self, brdf: Brdf, n_v: f32) -> Coefficients {
        let (diffuse, specular, lobe) = match brdf {
            Brdf::BlinnPhong => (self.diffuse, self.specular, 0.5 * self.shininess),
            Brdf::Gltf => (self.covered, self.normal_incidence, self.alpha * self.alpha),
            Brdf::GltfScattering => {
                let f0 = self.normal_incidence;
                let more = 1.0 / scattered_once(self.alpha.sqrt(), n_v.max(0.0)) - 1.0;
                (self.covered, f0 + f0 * f0 * more, self.alpha * self.alpha)
            }
        };
        Coefficients { diffuse, specular, lobe }
    }
}

impl Shading {
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) that names the first constant out of its range.
    pub fn check(&self) -> Result<()> {
        within("shading.ambient", self.ambient, 0.0, f32::MAX)?;
        within("shading.dielectric", self.dielectric, 0.0, 1.0)?;
        within("shading.max_shininess", self.max_shininess, 1.0, f32::MAX)
    }

    /// The reflectance of a metallic-roughness surface.
    pub fn reflectance(
        &self,
        base: Vec3,
        metallic: f32,
        roughness: f32,
        emissive: Vec3,
    ) -> Reflectance {
        let alpha = roughness * roughness;
        let shininess = (2.0 / (alpha * alpha) - 2.0).min(self.max_shininess).max(1.0);
        let normal_incidence = Vec3::splat(self.dielectric).lerp(base, metallic);
        let diffuse = base * (1.0 - metallic);
        let wide = roughness.max(MIN_ROUGHNESS);
        Reflectance {
            diffuse,
            specular: normal_incidence * ((shininess + 8.0) / 8.0),
            normal_incidence,
            covered: diffuse * (1.0 - self.dielectric),
            alpha: wide * wide,
            shininess,
            unlit: base * self.ambient + emissive,
        }
    }
}

/// What arrives of a light at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSample {
    /// Unit vector to the light.
    pub towards: Vec3,
    /// Radiance of a white matt surface that faces a light of intensity 1, linear RGB: colour, falloff
    /// with the distance and falloff with the angle.
    pub radiance: Vec3,
}

/// What arrives of `light` at `p`, light frame.
pub fn sample(light: &LightRecord, p: Vec3) -> LightSample {
    let position = Vec3::from(light.position);
    let (towards, falloff) = if light.radius2 > 0.0 {
        let to_light = position - p;
        let d2 = to_light.length_squared();
        (to_light / d2.sqrt(), light.radius2 / d2)
    } else {
        (position, 1.0)
    };
    let cosine = -towards.dot(light.axis.into());
    let cone = (cosine * light.cone_scale + light.cone_offset).clamp(0.0, 1.0);
    LightSample { towards, radiance: Vec3::from(light.color) * (falloff * cone * cone) }
}

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Position, light frame.
    pub position: Vec3,
    /// Unit normal, turned to the viewer.
    pub normal: Vec3,
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
}

/// What one light adds at a place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Radiance to the viewer, linear RGB.
    pub radiance: Vec3,
    /// Diffuse irradiance `E`: 1 where a white matt surface would show white.
    pub irradiance: f32,
}

impl Shading {
    /// What `light` adds at a place of that reflectance.
    pub fn response(&self, light: &LightRecord, at: &Place, looks: &Reflectance) -> Response {
        let LightSample { towards: l, radiance } = sample(light, at.position);
        let n_l = at.normal.dot(l);
        if n_l.is_nan() || n_l <= 0.0 {
            return Response::default();
        }
        let received = radiance * n_l;
        let (diffuse, specular) = match self.brdf {
            Brdf::BlinnPhong => blinn_phong(at, l, looks),
            Brdf::Gltf | Brdf::GltfScattering => gltf(at, l, n_l, looks, self.brdf),
        };
        Response {
            radiance: received * (diffuse * light.diffuse + specular * light.specular),
            irradiance: luminance(received) * light.diffuse,
        }
    }
}

/// What microfacets of a perceptual roughness reflect at once of the light that a white metal reflects, seen at
/// the cosine `n_v` from the normal.
fn scattered_once(roughness: f32, n_v: f32) -> f32 {
    let powers = Vec3::new(1.0, n_v, n_v * n_v);
    let of = |row: [f32; 3]| Vec3::from(row).dot(powers);
    let by_roughness = Vec3::new(of(SCATTERING_0), of(SCATTERING_1), of(SCATTERING_2));
    let square = roughness * roughness;
    let lost = square * by_roughness.dot(Vec3::new(1.0, roughness, square));
    (1.0 - lost).clamp(SCATTERED_LEAST, 1.0)
}

/// Lambert's and Blinn-Phong's reflectances, both times π.
fn blinn_phong(at: &Place, l: Vec3, looks: &Reflectance) -> (Vec3, Vec3) {
    let n_h = at.normal.dot((l + at.to_viewer).normalize_or_zero()).max(0.0);
    (looks.diffuse, looks.specular * n_h.powf(looks.shininess))
}

/// Both parts of the BRDF of glTF 2.0, appendix B.3, times π. Metal and dielectric share the distribution of
/// their microfacets, so that mixing their reflectances is mixing them; what the dielectric's surface lets
/// pass does not depend on the metal.
fn gltf(at: &Place, l: Vec3, n_l: f32, looks: &Reflectance, brdf: Brdf) -> (Vec3, Vec3) {
    let (n, v) = (at.normal, at.to_viewer);
    let h = (l + v).normalize_or_zero();
    let alpha2 = looks.alpha * looks.alpha;
    let (n_v, n_h) = (n.dot(v).max(1e-4), n.dot(h).max(0.0));
    let grazing = (1.0 - v.dot(h).clamp(0.0, 1.0)).powi(5);
    let f0 = looks.coefficients(brdf, n.dot(v)).specular;
    let fresnel = f0 + (Vec3::ONE - f0) * grazing;
    // (n·h)²·(α² − 1) + 1, by way of the sine: it keeps the precision that 1 − cosine² would lose.
    let spread = n_h * n_h * alpha2 + n.cross(h).length_squared();
    let distribution = alpha2 / (spread * spread);
    let masking = |a: f32, b: f32| a * (b * b * (1.0 - alpha2) + alpha2).sqrt();
    let visibility = 0.5 / (masking(n_l, n_v) + masking(n_v, n_l));
    (looks.covered * (1.0 - grazing), fresnel * (distribution * visibility))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_white_matt_surface_facing_a_light_at_its_distance_shows_its_intensity() {
        let light = LightRecord {
            position: [0.0, 0.0, 2.0],
            radius2: 4.0,
            diffuse: 0.7,
            specular: 0.5,
            ..LightRecord::DARK
        };
        let shading = Shading::default();
        let white = shading.reflectance(Vec3::ONE, 0.0, 1.0, Vec3::ZERO);
        let matt = Reflectance { specular: Vec3::ZERO, ..white };
        let respond = |position, normal| {
            let at = Place { position, normal, to_viewer: normal };
            shading.response(&light, &at, &matt)
        };
        let facing = respond(Vec3::ZERO, Vec3::Z);
        assert_eq!(facing, Response { radiance: Vec3::splat(0.7), irradiance: 0.7 });
        assert_eq!(respond(Vec3::ZERO, -Vec3::Z), Response::default());
        assert_eq!(respond(Vec3::Z, Vec3::Z).radiance, Vec3::splat(4.0 * 0.7));
    }

    #[test]
    fn gltf_mixes_the_reflections_of_metal_and_dielectric() {
        let shading = Shading { brdf: Brdf::Gltf, ambient: 0.0, ..Shading::default() };
        let light = LightRecord { diffuse: 0.7, specular: 0.7, ..LightRecord::DARK };
        let to_viewer = Vec3::new(0.6, 0.0, 0.8);
        let at = Place { position: Vec3::ZERO, normal: Vec3::Z, to_viewer };
        let seen = |metallic: f32| {
            let looks = shading.reflectance(Vec3::new(0.9, 0.4, 0.1), metallic, 0.5, Vec3::ZERO);
            shading.response(&light, &at, &looks).radiance
        };
        for metallic in [0.25, 0.5, 0.75] {
            let (found, expected) = (seen(metallic), seen(0.0).lerp(seen(1.0), metallic));
            assert!(found.abs_diff_eq(expected, 1e-6), "{metallic}: {found}, not {expected}");
        }
    }

    /// In double precision: Blinn-Phong's, and glTF's by Smith's masking as Heitz 2014 writes it, equation 99.
    #[test]
    fn reflections_are_those_of_their_formulas() {
        let (base, metallic, n) = (Vec3::new(0.9, 0.4, 0.1), 0.25, DVec3::Z);
        let intensities = (0.7, 0.3);
        for (l, v, roughness) in [
            (DVec3::new(0.5, 0.2, 0.8), DVec3::new(-0.6, 0.1, 0.5), 0.5),
            (DVec3::new(0.1, -0.3, 0.9), DVec3::new(0.2, 0.1, 0.9), 0.3),
            (DVec3::new(-0.9, 0.1, 0.3), DVec3::new(0.8, 0.0, 0.4), 0.9f32),
        ] {
            let (l, v) = (l.normalize(), v.normalize());
            let h = (l + v).normalize();
            let [n_l, n_v, n_h] = [l, v, h].map(|direction| n.dot(direction));
            let alpha2 = f64::from(roughness).powi(4);
            let hidden = |c: f64| ((1.0 + alpha2 * (1.0 / (c * c) - 1.0)).sqrt() - 1.0) / 2.0;
            let masking = 1.0 / (1.0 + hidden(n_l) + hidden(n_v));
            let distribution = alpha2 / (n_h * n_h * (alpha2 - 1.0) + 1.0).powi(2);
            let lobe = distribution * masking / (4.0 * n_l * n_v);
            let grazing = (1.0 - v.dot(h)).powi(5);
            let shininess = (2.0 / alpha2 - 2.0).max(1.0);
            let exact = |base: f64, brdf| {
                let f0 = 0.04 + f64::from(metallic) * (base - 0.04);
                let diffuse = base * (1.0 - f64::from(metallic));
                let (diffuse, specular) = match brdf {
                    Brdf::BlinnPhong => {
                        (diffuse, f0 * (shininess + 8.0) / 8.0 * n_h.powf(shininess))
                    }
                    _ => (diffuse * 0.96 * (1.0 - grazing), (f0 + (1.0 - f0) * grazing) * lobe),
                };
                n_l * (intensities.0 * diffuse + intensities.1 * specular)
            };
            let (diffuse, specular) = (intensities.0 as f32, intensities.1 as f32);
            let position = l.as_vec3().to_array();
            let light = LightRecord { position, diffuse, specular, ..LightRecord::DARK };
            let to_viewer = v.as_vec3();
            let at = Place { position: Vec3::ZERO, normal: n.as_vec3(), to_viewer };
            for brdf in [Brdf::BlinnPhong, Brdf::Gltf] {
                let shading = Shading { brdf, ..Shading::default() };
                let looks = shading.reflectance(base, metallic, roughness, Vec3::ZERO);
                let found = shading.response(&light, &at, &looks).radiance;
                let expected = base.as_dvec3().to_array().map(|base| exact(base, brdf) as f32);
                let apart = (found - Vec3::from(expected)).abs().max_element();
                assert!(apart < 1e-5, "{brdf:?} {roughness}: {found}, not {expected:?}");
            }
        }
    }

    /// The exact share at the roughness 1, seen at normal incidence, is 1 − ln 2.
    #[test]
    fn rough_metals_get_back_what_they_scatter_more_than_once() {
        let exact = [(1.0, 1.0, 1.0 - 2f32.ln()), (0.5, 1.0, 0.9156), (0.5, 0.3, 0.838)];
        for (roughness, n_v, share) in exact {
            let found = scattered_once(roughness, n_v);
            assert!((found - share).abs() < 0.03, "{roughness} {n_v}: {found}, not {share}");
        }
        let white = Shading::default().reflectance(Vec3::ONE, 1.0, 1.0, Vec3::ZERO);
        let seen = |brdf| white.coefficients(brdf, 1.0).specular.x;
        assert!(seen(Brdf::GltfScattering) > 3.0 * seen(Brdf::Gltf));
        // f₀ + f₀²·(1/E − 1), E the share that comes back at once.
        let (once, metal) = (scattered_once(1.0, 1.0), Vec3::new(1.0, 0.5, 0.25));
        let coloured = Shading::default().reflectance(metal, 1.0, 1.0, Vec3::ZERO);
        let expected = metal + metal * metal * (1.0 / once - 1.0);
        let found = coloured.coefficients(Brdf::GltfScattering, 1.0).specular;
        assert!(found.abs_diff_eq(expected, 1e-5), "{found}, not {expected}");
    }

    #[test]
    fn two_of_three_models_are_gltf_s() {
        let all = [Brdf::BlinnPhong, Brdf::Gltf, Brdf::GltfScattering];
        assert_eq!(all.map(Brdf::is_gltf), [false, true, true]);
    }

    #[test]
    fn reflectance_of_the_extremes() {
        let shading = Shading::default();
        let base = Vec3::new(0.8, 0.4, 0.2);
        let matt = shading.reflectance(base, 0.0, 1.0, Vec3::ZERO);
        assert_eq!((matt.diffuse, matt.shininess), (base, 1.0));
        assert_eq!(matt.specular, Vec3::splat(0.04 * 9.0 / 8.0));
        let mirror = shading.reflectance(base, 1.0, 0.0, Vec3::ONE);
        assert_eq!((mirror.diffuse, mirror.shininess), (Vec3::ZERO, 4096.0));
        assert_eq!(mirror.specular, base * (4104.0 / 8.0));
        assert_eq!(mirror.unlit, base * 0.03 + 1.0);
    }
}
