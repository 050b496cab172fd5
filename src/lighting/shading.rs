//! Local illumination without shadows, as in Shacked and Lischinski (2001), section 3; materials are
//! glTF metallic-roughness (glTF 2.0 specification, appendix B, simplified to a Blinn-Phong lobe of
//! the same width). The reconstruction is ours: `docs/METHOD.md`.

use super::LightRecord;
use crate::Result;
use crate::error::within;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Constants of the shading model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shading {
    /// Share of the base colour that is seen without any light.
    pub ambient: f32,
    /// Specular reflectance of dielectrics at normal incidence.
    pub dielectric: f32,
    /// Largest Blinn-Phong exponent, 1 or more; the smallest is 1.
    pub max_shininess: f32,
}

impl Default for Shading {
    fn default() -> Self {
        Self { ambient: 0.03, dielectric: 0.04, max_shininess: 4096.0 }
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
    /// Blinn-Phong exponent `s = 2/α² − 2` in 1..=4096, with `α = roughness²`.
    pub shininess: f32,
    /// `0.03·base + emissive`, linear RGB.
    pub unlit: Vec3,
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
        let specular = Vec3::splat(self.dielectric).lerp(base, metallic);
        Reflectance {
            diffuse: base * (1.0 - metallic),
            specular: specular * ((shininess + 8.0) / 8.0),
            shininess,
            unlit: base * self.ambient + emissive,
        }
    }
}

/// How strongly one light acts on the diffuse and on the specular reflectance at `p`:
/// `falloff·(n·l)·Id` and `falloff·(n·l)·Is·(n·h)^s`; both 0 unless `n·l > 0`.
///
/// `p` position, `n` unit normal turned to the viewer, `v` unit vector to the viewer; light frame.
pub fn light_response(
    light: &LightRecord,
    p: Vec3,
    n: Vec3,
    v: Vec3,
    shininess: f32,
) -> (f32, f32) {
    let position = Vec3::from(light.position);
    let (l, falloff) = if light.radius2 > 0.0 {
        let to_light = position - p;
        let d2 = to_light.length_squared();
        (to_light / d2.sqrt(), light.radius2 / d2)
    } else {
        (position, 1.0)
    };
    let n_l = n.dot(l);
    if n_l.is_nan() || n_l <= 0.0 {
        return (0.0, 0.0);
    }
    let n_h = n.dot((l + v).normalize_or_zero()).max(0.0);
    let strength = falloff * n_l;
    (strength * light.diffuse, strength * light.specular * n_h.powf(shininess))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_matt_surface_facing_a_light_at_its_distance_shows_its_intensity() {
        let light = LightRecord {
            position: [0.0, 0.0, 2.0],
            radius2: 4.0,
            diffuse: 0.7,
            specular: 0.5,
            padding: [0.0; 2],
        };
        let (diffuse, specular) = light_response(&light, Vec3::ZERO, Vec3::Z, Vec3::Z, 100.0);
        assert_eq!((diffuse, specular), (0.7, 0.5));
        let behind = light_response(&light, Vec3::ZERO, -Vec3::Z, -Vec3::Z, 100.0);
        assert_eq!(behind, (0.0, 0.0));
        let near = light_response(&light, Vec3::Z, Vec3::Z, Vec3::Z, 100.0);
        assert_eq!(near.0, 4.0 * 0.7);
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
