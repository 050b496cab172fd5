//! Light like that of a picture: its statistics become the targets of a search (Ha and Olivier 2007).

use crate::lighting::genome::Boxes;
use crate::lighting::{Color, KELVIN};
use crate::math::color::{luminance, srgb_decode, srgb_encode};
use crate::objective::{Example, HISTOGRAM_BINS, Objective, Term};
use crate::scene::TextureLevel;
use crate::{Error, Result};
use glam::{DVec3, Vec3};

/// Weight of the example.
const WEIGHT: f32 = 2.0;
/// Factor of the weights of all terms that say nothing of it.
const OTHERS: f32 = 0.2;
/// Terms whose targets are the example's then.
const REPLACED: [&str; 6] = ["mean", "grad", "var", "hist", "range", "spread"];
/// Alpha from which on a pixel belongs to the object.
const COVERED: u8 = 128;
/// Least relative difference of red and blue that is more than noise.
const TINTED: f32 = 0.04;

/// What is taken of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Brightnesses and gradients.
    pub example: Example,
    /// Colour of its lights beside that of its shadows.
    pub light: Color,
    /// Colour of its shadows beside that of its lights.
    pub shadow: Color,
}

impl Look {
    /// Of a picture: of its pixels with an alpha of a half or more. Where it has other sizes than a view whose longest side
    /// is `side`, gradients are those that it would have there.
    ///
    /// Colours are those of the brightest and of the darkest quarter beside each other: what both have in common may
    /// be the object's own colour or the camera's white balance.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture of which nothing can be seen.
    pub fn of(picture: &TextureLevel, side: u32) -> Result<Self> {
        let seen = Seen::new(picture);
        if seen.object.is_empty() {
            return Err(Error::Argument("the picture is transparent everywhere".into()));
        }
        let mut counts = [0u32; HISTOGRAM_BINS];
        for &at in &seen.object {
            let bin = (seen.brightness[at] * HISTOGRAM_BINS as f32) as usize;
            counts[bin.min(HISTOGRAM_BINS - 1)] += 1;
        }
        let histogram = counts.map(|count| (f64::from(count) / seen.object.len() as f64) as f32);
        let scale = picture.width.max(picture.height) as f32 / side.max(1) as f32;
        let gradient = (seen.gradient() * scale).min(1.0);
        let (light, shadow) = seen.colors();
        Ok(Self { example: Example { histogram, gradient }, light, shadow })
    }

    /// Makes the statistics the targets of a search, and the colours those of its lights.
    ///
    /// # Errors
    /// As [`crate::objective::Terms::set`].
    pub fn steer(&self, objective: &mut Objective, boxes: &mut Boxes) -> Result<()> {
        objective.weights = objective
            .weights
            .map(|term, weight| if REPLACED.contains(&term.name) { 0.0 } else { OTHERS * weight });
        objective.weights.set(Term::named("example")?, WEIGHT)?;
        objective.example = Some(self.example);
        boxes.key.color = self.light;
        (boxes.fill.color, boxes.rim.color) = (self.shadow, self.shadow);
        Ok(())
    }
}

/// A picture as it is seen.
struct Seen<'a> {
    picture: &'a TextureLevel,
    /// Encoded luminance of each pixel.
    brightness: Vec<f32>,
    /// The object's pixels.
    object: Vec<usize>,
}

fn linear([r, g, b, _]: [u8; 4]) -> Vec3 {
    Vec3::from([r, g, b].map(|channel| srgb_decode(f32::from(channel) / 255.0)))
}

impl<'a> Seen<'a> {
    fn new(picture: &'a TextureLevel) -> Self {
        let brightness =
            picture.texels.iter().map(|&texel| srgb_encode(luminance(linear(texel)))).collect();
        let covered = |&at: &usize| picture.texels[at][3] >= COVERED;
        let object = (0..picture.texels.len()).filter(covered).collect();
        Self { picture, brightness, object }
    }

    /// Mean length of the Sobel pair over the object's pixels whose neighbours are all the object's.
    fn gradient(&self) -> f32 {
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        let (mut sum, mut count) = (0.0, 0usize);
        for &at in &self.object {
            let (x, y) = (at % width, at / width);
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                continue;
            }
            let tap = |dx: usize, dy: usize| at + dx + dy * width - 1 - width;
            let taps: [usize; 9] = std::array::from_fn(|i| tap(i % 3, i / 3));
            if taps.iter().any(|&tap| self.picture.texels[tap][3] < COVERED) {
                continue;
            }
            let i = taps.map(|tap| self.brightness[tap]);
            let across = (i[2] - i[0] + 2.0 * (i[5] - i[3]) + i[8] - i[6]) / 8.0;
            let down = (i[6] - i[0] + 2.0 * (i[7] - i[1]) + i[8] - i[2]) / 8.0;
            (sum, count) = (sum + f64::from(across.hypot(down)), count + 1);
        }
        (sum / count.max(1) as f64) as f32
    }

    /// Colours of light and shadow: their ratio, half of it to either side of white.
    fn colors(&self) -> (Color, Color) {
        let mut order = self.object.clone();
        order.sort_by(|&a, &b| self.brightness[a].total_cmp(&self.brightness[b]));
        let quarter = order.len().div_ceil(4);
        let sum = |part: &[usize]| -> Vec3 {
            let texels = part.iter().map(|&at| linear(self.picture.texels[at]).as_dvec3());
            texels.sum::<DVec3>().as_vec3()
        };
        let (dark, bright) = (sum(&order[..quarter]), sum(&order[order.len() - quarter..]));
        if dark.min_element() <= 0.0 || bright.min_element() <= 0.0 {
            return (Color::WHITE, Color::WHITE);
        }
        let ratio = (bright / luminance(bright)) / (dark / luminance(dark));
        if (ratio.x / ratio.z).ln().abs() < TINTED {
            return (Color::WHITE, Color::WHITE);
        }
        let half = ratio.map(f32::sqrt);
        (temperature(half), temperature(half.recip()))
    }
}

/// The temperature whose red and blue are to each other as a colour's are.
fn temperature(color: Vec3) -> Color {
    let (mut low, mut high) = (*KELVIN.start(), *KELVIN.end());
    let ratio = |color: Color| {
        let [r, _, b] = color.linear();
        r / b.max(f32::MIN_POSITIVE)
    };
    // The ratio falls with the temperature.
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        let warmer = Color::of_kelvin(middle).is_some_and(|c| ratio(c) > color.x / color.z);
        (low, high) = if warmer { (middle, high) } else { (low, middle) };
    }
    Color::of_kelvin((0.5 * (low + high)).round()).unwrap_or(Color::WHITE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, texels: Vec<[u8; 4]>) -> TextureLevel {
        TextureLevel { width, height: texels.len() as u32 / width, texels }
    }

    #[test]
    fn statistics_are_those_of_what_is_not_transparent() {
        // Columns of 0, 51, 102 and 153, behind a frame that is transparent.
        let texel = |at: u32| match (at % 6, at / 6) {
            (0 | 5, _) | (_, 0 | 5) => [255, 0, 0, 0],
            (x, _) => [[51 * (x as u8 - 1); 3].as_slice(), &[255]].concat().try_into().unwrap(),
        };
        let picture = picture(6, (0..36).map(texel).collect());
        let look = Look::of(&picture, 6).unwrap();
        let full: Vec<_> =
            (0..HISTOGRAM_BINS).filter(|&bin| look.example.histogram[bin] > 0.0).collect();
        assert_eq!(full, [0, 6, 12, 19]);
        assert!(full.iter().all(|&bin| (look.example.histogram[bin] - 0.25).abs() < 1e-6));
        // A fifth of the range a pixel; half of the size has twice as much.
        assert!((look.example.gradient - 0.2).abs() < 1e-3, "{look:?}");
        assert!((Look::of(&picture, 3).unwrap().example.gradient - 0.4).abs() < 2e-3);
        assert_eq!((look.light, look.shadow), (Color::WHITE, Color::WHITE));
        look.example.check().unwrap();
        let nothing = self::picture(1, vec![[9, 9, 9, 0]]);
        assert!(Look::of(&nothing, 6).unwrap_err().to_string().contains("transparent"));
    }

    #[test]
    fn shares_of_many_pixels_add_up() {
        let texels = (0..1 << 20).map(|at: u32| [if at.is_multiple_of(3) { 40 } else { 90 }; 3]);
        let texels = texels.map(|[r, g, b]| [r, g, b, 255]).collect();
        let look = Look::of(&picture(1024, texels), 512).unwrap();
        look.example.check().unwrap();
        assert!((look.example.histogram.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_warm_light_beside_a_cool_shadow_is_told_whatever_the_object_s_colour() {
        let (warm, cool) = (Color::of_kelvin(4000.0).unwrap(), Color::of_kelvin(10_000.0).unwrap());
        let shade = |color: Color, strength: f32, base: Vec3| {
            let [r, g, b] = (Vec3::from(color.linear()) * base * strength)
                .to_array()
                .map(|channel| (srgb_encode(channel) * 255.0).round() as u8);
            [r, g, b, 255]
        };
        for base in [Vec3::ONE, Vec3::new(0.9, 0.5, 0.3)] {
            let texels =
                [vec![shade(warm, 0.4, base); 8], vec![shade(cool, 0.1, base); 8]].concat();
            let look = Look::of(&picture(4, texels), 4).unwrap();
            let ratio = |color: Color| color.linear()[0] / color.linear()[2];
            let (found, made) = (ratio(look.light) / ratio(look.shadow), ratio(warm) / ratio(cool));
            assert!((found / made - 1.0).abs() < 0.1, "{look:?}");
            assert!(ratio(look.light) > 1.0 && ratio(look.shadow) < 1.0, "{look:?}");
        }
    }
}
