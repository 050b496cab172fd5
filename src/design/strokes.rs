//! Where highlights and shadows are to lie, drawn on the picture: *Lights from Highlights and Shadows* (Poulin and
//! Fournier 1992), as in *Sketching Shadows and Highlights to Position Lights* (Poulin, Ratib and Jacques 1997). The
//! place of a highlight decides where its light stands, `L = 2(n·v)n − v`; a shadow is a dark place of a target picture,
//! which the term `target` compares with.

use crate::lighting::genome::Genome;
use crate::lighting::{Light, Rig, mirrored};
use crate::math::range::Range;
use crate::objective::maps::{Maps, PixelType};
use crate::scene::TextureLevel;
use crate::scene::view::View;
use crate::{Error, Result};
use glam::Vec3;

/// Weight of the term `target` where shadows are drawn.
pub const SHADOW_WEIGHT: f32 = 1.0;

/// The brightness that is asked for there, sRGB-encoded luminance: dark, with the shape still to be seen.
pub const SHADOW_BRIGHTNESS: f32 = 0.12;

/// A texel belongs to a stroke from this alpha on, and to that of a highlight from this mean of its channels on.
const HALF: u8 = 128;

/// Strokes on the object of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Strokes {
    /// Pixels of each highlight's stroke, the largest first.
    highlights: Vec<Vec<usize>>,
    /// Pixels of all shadows' strokes.
    shadows: Vec<usize>,
}

impl Strokes {
    /// Those of a picture of the view, of any size: bright ones are highlights, dark ones shadows, and what is transparent
    /// is none.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture of other proportions, and for one without a stroke on the object.
    pub fn of(picture: &TextureLevel, maps: &Maps) -> Result<Self> {
        let [width, height] = [maps.surface.width, maps.surface.height];
        let [across, down] = [picture.width, picture.height].map(u64::from);
        let apart = (u64::from(width) * down).abs_diff(u64::from(height) * across);
        if apart > across.max(down).max(u64::from(width.max(height))) {
            return Err(Error::Argument(format!(
                "the strokes have {across}x{down} pixels: they must have the proportions of the view, {width}x{height}"
            )));
        }
        let texel = |at: usize| {
            let (x, y) = (at as u64 % u64::from(width), at as u64 / u64::from(width));
            let column = (2 * x + 1) * across / (2 * u64::from(width));
            let row = (2 * y + 1) * down / (2 * u64::from(height));
            picture.texels[(row * across + column) as usize]
        };
        let drawn = |&at: &usize| maps.types[at] != PixelType::Background && texel(at)[3] >= HALF;
        let bright = |&at: &usize| {
            let [r, g, b, _] = texel(at).map(u32::from);
            r + g + b >= 3 * u32::from(HALF)
        };
        let (bright, shadows): (Vec<usize>, Vec<usize>) =
            (0..maps.types.len()).filter(drawn).partition(bright);
        if bright.is_empty() && shadows.is_empty() {
            return Err(Error::Argument("there is no stroke on the object".into()));
        }
        Ok(Self { highlights: connected(&bright, width as usize, maps.types.len()), shadows })
    }

    /// Whether any shadow is drawn.
    pub fn has_shadows(&self) -> bool {
        !self.shadows.is_empty()
    }

    /// The target picture of the shadows, of so many pixels, as [`Maps::set_target`] takes it; none where none is drawn.
    pub fn target(&self, pixels: usize) -> Option<Vec<f32>> {
        let mut target = vec![-1.0; pixels];
        self.shadows.iter().for_each(|&at| target[at] = SHADOW_BRIGHTNESS);
        self.has_shadows().then_some(target)
    }

    /// The genome with the lights of the highlights in their places, at the middle of the distances that they may have: the
    /// first light has the largest stroke.
    ///
    /// # Errors
    /// [`Error::Argument`] for more strokes than lights that are searched, and as [`Genome::hold`].
    pub fn hold(&self, mut genome: Genome, maps: &Maps, view: &View) -> Result<Genome> {
        let (strokes, lights) = (self.highlights.len(), genome.lights());
        if strokes > lights {
            return Err(Error::Argument(format!(
                "{strokes} highlights are drawn for {lights} lights: strokes of one highlight must touch, or --lights \
                 asks for more lights"
            )));
        }
        let middle: Vec<f32> = genome.bounds().iter().map(Range::middle).collect();
        let rig: Rig = genome.decode(&middle);
        for (at, stroke) in self.highlights.iter().enumerate() {
            let light = placed(&rig[at], stroke, maps, view);
            let names: Vec<_> = genome.alleles(at).map(|allele| allele.name).collect();
            for name in ["elevation", "azimuth", "distance"] {
                if names.contains(&name) {
                    genome = genome.hold(at, &light, Some(name))?;
                }
            }
        }
        Ok(genome)
    }
}

/// The light where its highlight lies in the middle of a stroke: in the direction that mirrors the viewer's, from there.
fn placed(light: &Light, stroke: &[usize], maps: &Maps, view: &View) -> Light {
    let mean = |of: &[[f32; 3]]| {
        stroke.iter().map(|&at| Vec3::from(of[at])).sum::<Vec3>() / stroke.len() as f32
    };
    let position = mean(&maps.surface.position);
    let to_viewer = view.towards_viewer(position);
    let normal = mean(&maps.surface.normal).try_normalize().unwrap_or(to_viewer);
    light.seen_from(position, mirrored(normal, to_viewer))
}

/// Ascending pixels of a picture so wide in parts that touch, corners included; the largest first.
fn connected(pixels: &[usize], width: usize, count: usize) -> Vec<Vec<usize>> {
    let mut waiting = vec![false; count];
    pixels.iter().for_each(|&at| waiting[at] = true);
    let mut parts = Vec::new();
    for &first in pixels {
        if !std::mem::take(&mut waiting[first]) {
            continue;
        }
        let (mut part, mut next) = (vec![first], 0);
        while let Some(&at) = part.get(next) {
            next += 1;
            let (x, y) = (at % width, at / width);
            for row in y.saturating_sub(1)..=(y + 1).min(count / width - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let other = row * width + column;
                    if std::mem::take(&mut waiting[other]) {
                        part.push(other);
                    }
                }
            }
        }
        parts.push(part);
    }
    parts.sort_by_key(|part: &Vec<usize>| std::cmp::Reverse(part.len()));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::lighting::direction;
    use crate::lighting::genome::Boxes;
    use crate::lighting::{LightKind, Role};
    use crate::objective::Objective;
    use crate::objective::shadows::ShadowSettings;
    use crate::scene::build::{MeshData, SceneBuilder};
    use crate::scene::view::{Camera, Projection};
    use glam::{DMat4, DVec3};
    use std::f32::consts::PI;

    const SIDE: u32 = 128;

    /// A ball in perspective.
    fn ball() -> (Maps, View) {
        const ACROSS: u32 = 96;
        let corner = |at: u32| {
            let [turn, rise] =
                [at % (ACROSS + 1), at / (ACROSS + 1)].map(|x| x as f32 / ACROSS as f32);
            direction(PI * (rise - 0.5), 2.0 * PI * turn).to_array()
        };
        let positions: Vec<[f32; 3]> = (0..(ACROSS + 1).pow(2)).map(corner).collect();
        let quad = |at: u32| {
            let a = at / ACROSS * (ACROSS + 1) + at % ACROSS;
            [a, a + 1, a + ACROSS + 2, a, a + ACROSS + 2, a + ACROSS + 1]
        };
        let indices: Vec<u32> = (0..ACROSS.pow(2)).flat_map(quad).collect();
        let mut builder = SceneBuilder::default();
        let mesh = MeshData {
            positions: &positions,
            normals: Some(&positions),
            indices: Some(&indices),
            ..MeshData::default()
        };
        let mesh = builder.add_mesh(&mesh).unwrap();
        builder.add_instance("ball", mesh, DMat4::IDENTITY).unwrap();
        let scene = builder.finish("ball").unwrap();
        let lens = Projection::Perspective { yfov: 0.6 };
        let camera =
            Camera::look_at(DVec3::new(0.5, 1.0, 4.0), DVec3::ZERO, DVec3::Y, lens).unwrap();
        let view = View::new(&scene, camera, SIDE, SIDE).unwrap();
        let shadows = ShadowSettings::default();
        (cpu::draw(&scene, &view, &Objective::default(), (&shadows, None)).unwrap(), view)
    }

    /// A transparent picture with a disc of that colour around each of the pixels.
    fn drawn(discs: &[([u32; 2], f32, u8)]) -> TextureLevel {
        let mut texels = vec![[0; 4]; (SIDE * SIDE) as usize];
        for (at, texel) in texels.iter_mut().enumerate() {
            let [x, y] = [at as u32 % SIDE, at as u32 / SIDE].map(|x| x as f32);
            for &([u, v], radius, grey) in discs {
                if (x - u as f32).hypot(y - v as f32) <= radius {
                    *texel = [grey, grey, grey, 255];
                }
            }
        }
        TextureLevel { width: SIDE, height: SIDE, texels }
    }

    /// Pixels of the ball off its outline.
    fn places(maps: &Maps) -> Vec<[u32; 2]> {
        let inside = |&[x, y]: &[u32; 2]| {
            [[x - 6, y], [x + 6, y], [x, y - 6], [x, y + 6]]
                .map(|[u, v]| maps.types[(v * SIDE + u) as usize])
                .iter()
                .all(|&kind| kind == PixelType::Surface)
        };
        let rows = (8..SIDE - 8).step_by(9);
        let all = rows.flat_map(|y| (8..SIDE - 8).step_by(9).map(move |x| [x, y]));
        let places: Vec<_> = all.filter(inside).collect();
        assert!(places.len() > 20, "{places:?}");
        places
    }

    #[test]
    fn the_middle_of_a_highlight_lies_within_two_pixels_of_its_stroke() {
        let (maps, view) = ball();
        let places = places(&maps);
        for kind in [LightKind::POINT, LightKind::DIRECTIONAL] {
            let genome = Genome::new(&[Role::Key, Role::Fill], kind, &Boxes::default()).unwrap();
            for &[x, y] in &places {
                let strokes = Strokes::of(&drawn(&[([x, y], 2.0, 255)]), &maps).unwrap();
                let held = strokes.hold(genome.clone(), &maps, &view).unwrap();
                let middle: Vec<f32> = held.bounds().iter().map(Range::middle).collect();
                let key = held.decode(&middle)[0].record();
                // Where the half vector comes nearest to the normal, of what lies around.
                let along = |at: usize| {
                    let p = Vec3::from(maps.surface.position[at]);
                    let l =
                        Vec3::from(key.position) - if key.radius2 > 0.0 { p } else { Vec3::ZERO };
                    let half = l.normalize() + view.towards_viewer(p);
                    half.normalize().dot(maps.surface.normal[at].into())
                };
                let around = (y - 4..=y + 4).flat_map(|v| (x - 4..=x + 4).map(move |u| [u, v]));
                let [u, v] = around
                    .max_by(|a, b| {
                        let [a, b] = [a, b].map(|[u, v]| along((v * SIDE + u) as usize));
                        a.total_cmp(&b)
                    })
                    .unwrap();
                let apart = (u as f32 - x as f32).hypot(v as f32 - y as f32);
                assert!(apart <= 2.0, "{kind:?}: {x} {y} became {u} {v}");
            }
        }
    }

    #[test]
    fn strokes_that_touch_are_one_and_the_largest_is_the_first_lights() {
        let (maps, view) = ball();
        let places = places(&maps);
        let (first, last) = (places[0], places[places.len() - 1]);
        let picture =
            drawn(&[(first, 1.0, 255), (last, 3.0, 250), (places[places.len() / 2], 2.0, 0)]);
        let strokes = Strokes::of(&picture, &maps).unwrap();
        let [large, small] = &strokes.highlights[..] else { panic!("{:?}", strokes.highlights) };
        assert!(large.len() > small.len() && strokes.shadows.len() > 8);
        let middle = (last[1] * SIDE + last[0]) as usize;
        assert!(large.contains(&middle));
        let target = strokes.target(maps.types.len()).unwrap();
        let dark = |&&t: &&f32| t == SHADOW_BRIGHTNESS;
        assert_eq!(target.iter().filter(dark).count(), strokes.shadows.len());
        assert!(target.iter().all(|&t| t == SHADOW_BRIGHTNESS || t == -1.0));

        let one = Genome::new(&[Role::Key], LightKind::POINT, &Boxes::default()).unwrap();
        let fault = strokes.hold(one, &maps, &view).unwrap_err();
        assert!(fault.is_input() && fault.to_string().contains("2 highlights"), "{fault}");
    }

    #[test]
    fn pictures_without_strokes_or_of_other_proportions_are_refused() {
        let (maps, _) = ball();
        let fault = Strokes::of(&drawn(&[([1, 1], 1.0, 255)]), &maps).unwrap_err();
        assert!(fault.to_string().contains("no stroke on the object"), "{fault}");
        let wide = TextureLevel { width: 4, height: 2, texels: vec![[255; 4]; 8] };
        let fault = Strokes::of(&wide, &maps).unwrap_err();
        assert!(fault.to_string().contains("proportions"), "{fault}");
        let coarse = TextureLevel { width: 2, height: 2, texels: vec![[255; 4]; 4] };
        let strokes = Strokes::of(&coarse, &maps).unwrap();
        assert_eq!(strokes.highlights[0].len(), maps.counts.object() as usize);
        assert_eq!(strokes.target(maps.types.len()), None);
    }
}
