//! Texture lookup: trilinear at an explicit level of detail (Vulkan 1.3 specification, section 16.5,
//! with exact weights).

use crate::constants::MIN_TEXEL_STEP2;
use crate::math::color::srgb_decode;
use crate::scene::{Texture, TextureLevel, Wrap};
use glam::{Vec2, Vec4};
use std::sync::LazyLock;

static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| decoding(srgb_decode));
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| decoding(|x| x));

fn decoding(curve: impl Fn(f32) -> f32) -> [f32; 256] {
    std::array::from_fn(|byte| curve(byte as f32 / 255.0))
}

/// Linear RGBA at `uv`, where one step in the picture is `dx` or `dy` long in texture coordinates;
/// the longer of the two, measured in texels, decides the mip level.
pub fn sample(texture: &Texture, uv: Vec2, dx: Vec2, dy: Vec2) -> Vec4 {
    let full = &texture.levels[0];
    let size = Vec2::new(full.width as f32, full.height as f32);
    let longer2 = (dx * size).length_squared().max((dy * size).length_squared());
    let last = texture.levels.len() - 1;
    let lod = (0.5 * longer2.max(MIN_TEXEL_STEP2).log2()).clamp(0.0, last as f32);
    let level = lod as usize;
    let fine = bilinear(texture, &texture.levels[level], uv);
    let rest = lod - level as f32;
    if rest == 0.0 {
        return fine;
    }
    fine.lerp(bilinear(texture, &texture.levels[level + 1], uv), rest)
}

fn bilinear(texture: &Texture, level: &TextureLevel, uv: Vec2) -> Vec4 {
    // Beyond this the coordinates of a wild file have no fraction left to blend with.
    const FAR: Vec2 = Vec2::splat(1e9);
    let at = (uv * Vec2::new(level.width as f32, level.height as f32) - 0.5).clamp(-FAR, FAR);
    let corner = at.floor();
    let (x, y) = (corner.x as i64, corner.y as i64);
    let weight = at - corner;
    let row = |y| {
        let left = texel(texture, level, x, y);
        left.lerp(texel(texture, level, x.saturating_add(1), y), weight.x)
    };
    row(y).lerp(row(y.saturating_add(1)), weight.y)
}

fn texel(texture: &Texture, level: &TextureLevel, x: i64, y: i64) -> Vec4 {
    let x = wrapped(texture.wrap[0], x, level.width);
    let y = wrapped(texture.wrap[1], y, level.height);
    let [r, g, b, a] = level.texels[y * level.width as usize + x].map(usize::from);
    let color = if texture.srgb { &*SRGB } else { &*LINEAR };
    Vec4::new(color[r], color[g], color[b], LINEAR[a])
}

fn wrapped(wrap: Wrap, at: i64, size: u32) -> usize {
    let size = i64::from(size);
    let inside = match wrap {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Clamp => at.clamp(0, size - 1),
        Wrap::Mirror => {
            let at = at.rem_euclid(2 * size);
            at.min(2 * size - 1 - at)
        }
    };
    inside as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(wrap: Wrap) -> Texture {
        let level = |texels: &[u8]| TextureLevel {
            width: texels.len() as u32,
            height: 1,
            texels: texels.iter().map(|&t| [t, 0, 0, 255]).collect(),
        };
        Texture {
            name: String::new(),
            srgb: false,
            wrap: [wrap; 2],
            levels: vec![level(&[0, 51, 102, 255]), level(&[25, 178]), level(&[101])],
        }
    }

    fn red(texture: &Texture, u: f32, step: f32) -> f32 {
        255.0 * sample(texture, Vec2::new(u, 0.5), Vec2::new(step, 0.0), Vec2::ZERO).x
    }

    #[test]
    fn texels_stand_at_their_centres_and_blend_between_them() {
        let texture = ramp(Wrap::Clamp);
        for (u, value) in [(0.125, 0.0), (0.375, 51.0), (0.25, 25.5), (0.875, 255.0)] {
            assert!((red(&texture, u, 0.0) - value).abs() < 1e-3, "{u}");
        }
    }

    #[test]
    fn wraps() {
        let cases = [(Wrap::Clamp, [0.0, 255.0]), (Wrap::Repeat, [255.0, 0.0])];
        for (wrap, [before, after]) in cases {
            assert!((red(&ramp(wrap), -0.125, 0.0) - before).abs() < 1e-3);
            assert!((red(&ramp(wrap), 1.125, 0.0) - after).abs() < 1e-3);
        }
        let mirror = ramp(Wrap::Mirror);
        for u in [0.1, 0.4, 0.8] {
            assert!((red(&mirror, -u, 0.0) - red(&mirror, u, 0.0)).abs() < 1e-3);
            assert!((red(&mirror, 2.0 - u, 0.0) - red(&mirror, u, 0.0)).abs() < 1e-3);
        }
        assert!(red(&mirror, f32::MAX, 0.0).is_finite());
    }

    #[test]
    fn the_pixel_step_chooses_the_level() {
        let texture = ramp(Wrap::Clamp);
        assert!((red(&texture, 0.25, 0.5) - 25.0).abs() < 1e-3);
        assert!((red(&texture, 0.25, 100.0) - 101.0).abs() < 1e-3);
        let between = red(&texture, 0.25, 2f32.sqrt() / 2.0);
        assert!((between - (25.0 + 101.0) / 2.0).abs() < 1e-2, "{between}");
    }

    #[test]
    fn srgb_is_decoded_before_it_is_blended() {
        let mut texture = ramp(Wrap::Clamp);
        texture.srgb = true;
        let expected = 255.0 * (srgb_decode(0.0) + srgb_decode(0.2)) / 2.0;
        assert!((red(&texture, 0.25, 0.0) - expected).abs() < 1e-3);
    }
}
