//! Textures of KHR_materials_pbrSpecularGlossiness made into those of metallic and roughness, texel by texel.

use super::appearance::metallic_of;
use crate::math::color::{srgb_decode, srgb_encode};
use crate::scene::TextureLevel;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// A material whose textures are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    /// The image of the diffuse texture.
    pub diffuse: Option<usize>,
    /// The image of the specular-glossiness texture.
    pub specular: Option<usize>,
    /// Linear, with alpha.
    pub diffuse_factor: [f32; 4],
    /// Linear.
    pub specular_factor: [f32; 3],
    /// 0..1.
    pub glossiness: f32,
}

/// Which of the material's textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// sRGB base colour and linear alpha.
    BaseColor,
    /// Roughness in green, metallic in blue.
    MetallicRoughness,
}

impl Conversion {
    /// A texture's full picture, of the pictures of its images where there are any: as large as the larger.
    pub fn level(
        &self,
        diffuse: Option<&TextureLevel>,
        specular: Option<&TextureLevel>,
        part: Part,
    ) -> TextureLevel {
        let given = [diffuse, specular].into_iter().flatten();
        let size = given.fold([1, 1], |[w, h], l| [l.width.max(w), l.height.max(h)]);
        let [width, height] = size;
        let linear: [f32; 256] = std::array::from_fn(|byte| srgb_decode(byte as f32 / 255.0));
        let at = |level: Option<&TextureLevel>, x: u32, y: u32| {
            let Some(level) = level else { return Vec4::ONE };
            let near = |at: u32, of: u32, to: u32| u64::from(at) * u64::from(of) / u64::from(to);
            let (x, y) = (near(x, level.width, width), near(y, level.height, height));
            let [r, g, b, a] = level.texels[(y * u64::from(level.width) + x) as usize];
            let [r, g, b] = [r, g, b].map(|byte| linear[usize::from(byte)]);
            Vec4::new(r, g, b, f32::from(a) / 255.0)
        };
        let mut texels = vec![[0; 4]; width as usize * height as usize];
        texels.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            for (x, texel) in row.iter_mut().enumerate() {
                let place = (x as u32, y as u32);
                let [diffuse, specular] = [diffuse, specular].map(|l| at(l, place.0, place.1));
                *texel = self.texel(diffuse, specular, part);
            }
        });
        TextureLevel { width, height, texels }
    }

    fn texel(&self, diffuse: Vec4, specular: Vec4, part: Part) -> [u8; 4] {
        let (base, metallic, roughness) = self.converted(diffuse, specular);
        let byte = |value: f32| (value * 255.0).round() as u8;
        match part {
            Part::BaseColor => {
                let [r, g, b] = base.truncate().to_array().map(|value| byte(srgb_encode(value)));
                [r, g, b, byte(base.w)]
            }
            Part::MetallicRoughness => [0, byte(roughness), byte(metallic), 255],
        }
    }

    /// Base colour, metallic and roughness of linear texels.
    pub fn converted(&self, diffuse: Vec4, specular: Vec4) -> (Vec4, f32, f32) {
        let one = |color: Vec4| color.clamp(Vec4::ZERO, Vec4::ONE);
        let diffuse = one(diffuse * Vec4::from(self.diffuse_factor));
        let factor = Vec3::from(self.specular_factor).extend(self.glossiness);
        let specular = one(specular * factor);
        let (base, metallic) = metallic_of(diffuse.truncate(), specular.truncate());
        (base.extend(diffuse.w), metallic, 1.0 - specular.w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_of_different_sizes_meet() {
        let level = |width, height, texels: &[[u8; 4]]| TextureLevel {
            width,
            height,
            texels: texels.to_vec(),
        };
        let conversion = Conversion {
            diffuse: Some(0),
            specular: Some(1),
            diffuse_factor: [1.0; 4],
            specular_factor: [1.0; 3],
            glossiness: 0.5,
        };
        // On the left a red plastic, on the right a metal of that colour.
        let diffuse = level(2, 1, &[[200, 30, 30, 99], [0, 0, 0, 255]]);
        let dark = (srgb_encode(0.04) * 255.0).round() as u8;
        let specular = level(
            2,
            2,
            &[[dark, dark, dark, 255], [200, 30, 30, 255], [dark, dark, dark, 0], [200, 30, 30, 0]],
        );
        let base = conversion.level(Some(&diffuse), Some(&specular), Part::BaseColor);
        let rest = conversion.level(Some(&diffuse), Some(&specular), Part::MetallicRoughness);
        assert_eq!((base.width, base.height, base.texels.len()), (2, 2, 4));
        let [plastic, metal] = [base.texels[0], base.texels[1]];
        assert!(plastic[0].abs_diff(200) <= 1 && metal[0].abs_diff(200) <= 2, "{base:?}");
        assert_eq!((plastic[3], metal[3]), (99, 255));
        assert!(rest.texels[0][2] < 8 && rest.texels[1][2] > 245, "{rest:?}");
        assert_eq!([rest.texels[0][1], rest.texels[2][1]], [128, 255]);
        let white = conversion.level(None, None, Part::BaseColor);
        assert_eq!((white.width, white.texels.len()), (1, 1));
    }
}
