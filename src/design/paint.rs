//! Lights that make a given picture: *Painting with Light* (Schoeneman, Dorsey, Smits, Arvo and Greenberg 1993). What
//! a surface shows is linear in the lights' intensities, so that those of lights in given places are a problem of
//! non-negative least squares, which is solved exactly, one for each channel. The places are searched around it, as in
//! *Lighting with Paint* (Pellacini, Battaglia, Morley and Finkelstein 2007).

use super::{Outcome, Progress};
use crate::cpu::population;
use crate::lighting::genome::Genome;
use crate::lighting::shading::Shading;
use crate::lighting::{Color, Light, LightRecord, Rig, Role};
use crate::math::color::{LUMINANCE, luminance, srgb_decode};
use crate::math::nnls::nnls;
use crate::objective::maps::{Maps, PixelType};
use crate::optimize::Optimizer;
use crate::scene::TextureLevel;
use crate::scene::view::View;
use crate::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Most pixels that are compared.
const MAX_SAMPLES: usize = 1 << 12;
/// Channels from here on may be any brighter, encoded 0..=255.
const CLIPPED: u8 = 254;

/// A view and the picture that it is to show.
pub struct Canvas<'a> {
    maps: &'a Maps,
    view: &'a View,
    shading: &'a Shading,
    /// Pixels that are compared.
    pixels: Vec<usize>,
    /// What the lights have to add in each: the picture, linear, without what is there without them. NaN for channels that
    /// the picture does not tell.
    wanted: Vec<Vec3>,
}

impl<'a> Canvas<'a> {
    /// The picture, of the view's size, told where it is opaque: its sRGB colours are what the object is to show.
    /// Pixels at edges, which final pictures blend, are left out, and of the others every n-th is compared, 4,096 at
    /// most. `fixed` are lights that shine besides.
    ///
    /// # Errors
    /// [`Error::Argument`] for a picture of another size, or one that tells nothing of the object.
    pub fn new(
        (maps, view, shading): (&'a Maps, &'a View, &'a Shading),
        picture: &TextureLevel,
        fixed: &[Light],
    ) -> Result<Self> {
        let (width, height) = (view.width, view.height);
        if [picture.width, picture.height] != [width, height] {
            return Err(Error::Argument(format!(
                "the target picture has {}x{} pixels, and the view {width}x{height}",
                picture.width, picture.height
            )));
        }
        let told =
            |&at: &usize| maps.types[at] == PixelType::Surface && picture.texels[at][3] == u8::MAX;
        let all: Vec<usize> = (0..picture.texels.len()).filter(told).collect();
        if all.is_empty() {
            return Err(Error::Argument("the target picture tells no pixel of the object".into()));
        }
        let pixels: Vec<usize> =
            all.iter().copied().step_by(all.len().div_ceil(MAX_SAMPLES)).collect();
        let records: Vec<LightRecord> = fixed.iter().map(Light::record).collect();
        let wanted = |&at: &usize| {
            let there = population::radiance(maps, view, shading, &records, at);
            let [r, g, b, _] = picture.texels[at];
            let channel = |byte: u8| match byte {
                CLIPPED.. => f32::NAN,
                _ => srgb_decode(f32::from(byte) / 255.0),
            };
            Vec3::new(channel(r), channel(g), channel(b)) - there.unwrap_or(Vec3::ZERO)
        };
        let wanted = pixels.par_iter().map(wanted).collect();
        Ok(Self { maps, view, shading, pixels, wanted })
    }

    /// The lights with the intensities and colours that come nearest to the picture, and the root mean square distance
    /// that is left, linear luminance. Each light has one intensity then, and what it had of both does not count.
    pub fn solve(&self, lights: &[Light]) -> (Rig, f32) {
        let n = lights.len();
        let responses: Vec<Vec<Vec3>> = lights.iter().map(|light| self.response(light)).collect();
        let mut colors = vec![Vec3::ZERO; n];
        for channel in 0..3 {
            let told = || (0..self.pixels.len()).filter(|&p| !self.wanted[p][channel].is_nan());
            let dot = |i: usize, of: &dyn Fn(usize) -> f32| {
                let term = |p: usize| f64::from(responses[i][p][channel]) * f64::from(of(p));
                told().map(term).sum::<f64>()
            };
            let mut gram = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..=i {
                    let both = dot(i, &|p| responses[j][p][channel]);
                    (gram[i * n + j], gram[j * n + i]) = (both, both);
                }
            }
            let moments: Vec<f64> = (0..n).map(|i| dot(i, &|p| self.wanted[p][channel])).collect();
            for (color, strength) in colors.iter_mut().zip(nnls(&gram, &moments)) {
                color[channel] = strength as f32;
            }
        }
        let rig = std::iter::zip(lights, &colors).map(|(light, color)| colored(light, *color));
        (rig.collect(), self.distance(&responses, &colors))
    }

    /// What the light adds in each pixel where it is white and of intensity 1.
    fn response(&self, light: &Light) -> Vec<Vec3> {
        let white = Light { diffuse: 1.0, specular: 1.0, color: Color::WHITE, ..*light }.record();
        let one = |&at: &usize| population::added(self.maps, self.view, self.shading, &white, at);
        self.pixels.iter().map(one).collect()
    }

    fn distance(&self, responses: &[Vec<Vec3>], colors: &[Vec3]) -> f32 {
        let apart = |p: usize| {
            let made: Vec3 = std::iter::zip(responses, colors).map(|(r, c)| r[p] * *c).sum();
            let apart =
                (made - self.wanted[p]).map(|off| if off.is_nan() { 0.0 } else { off * off });
            f64::from(apart.dot(LUMINANCE))
        };
        let sum: f64 = (0..self.pixels.len()).map(apart).sum();
        (sum / self.pixels.len() as f64).sqrt() as f32
    }
}

/// A light of that colour, whose brightness is the intensity.
fn colored(light: &Light, color: Vec3) -> Light {
    let strength = luminance(color);
    let color = Color::of_linear(color.to_array()).unwrap_or_default();
    Light { diffuse: strength, specular: strength, color, ..*light }
}

/// The genome with the places of its lights alone: intensities and colours are solved for.
///
/// # Errors
/// As [`Genome::hold`].
pub fn places(mut genome: Genome) -> Result<Genome> {
    for at in 0..genome.lights() {
        let names: Vec<_> = genome.alleles(at).map(|allele| allele.name).collect();
        for name in ["diffuse", "specular"].into_iter().filter(|name| names.contains(name)) {
            genome = genome.hold(at, &Light::default(), Some(name))?;
        }
    }
    Ok(genome)
}

/// Lets the brightest light be the first key: the picture does not say which of two boxes a light is from.
fn lead(rig: &mut [Light]) {
    let brightest = (0..rig.len()).max_by(|&a, &b| rig[a].diffuse.total_cmp(&rig[b].diffuse));
    let key = rig.iter().position(|light| light.role == Role::Key);
    if let Some((key, brightest)) = key.zip(brightest) {
        let roles = (rig[key].role, rig[brightest].role);
        rig.swap(key, brightest);
        (rig[key].role, rig[brightest].role) = roles;
    }
}

/// Searches the lights that make the picture. `search` asks for chromosomes of `genome`, which is one of [`places`];
/// scores are the distances of [`Canvas::solve`], and so is the outcome's.
///
/// # Errors
/// [`Error::Argument`] for a search that ends without a score.
pub fn paint(
    canvas: &Canvas,
    genome: &Genome,
    search: &mut dyn Optimizer,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Outcome> {
    let searched = genome.lights();
    let solve = |chromosome: &[f32]| canvas.solve(&genome.decode(chromosome)[..searched]);
    let (mut history, mut stopped) = (Vec::<Progress>::new(), false);
    while !search.ask().is_empty() && !stopped {
        let scores: Vec<f32> =
            search.ask().par_iter().map(|chromosome| solve(chromosome).1).collect();
        search.tell(&scores);
        let before = history.last().map_or(0, |last| last.evaluations);
        let counts = (history.len() + 1, before + scores.len());
        let progress = super::progress(search, counts, 1);
        history.push(progress);
        stopped = observe(&progress).is_break();
    }
    let (chromosome, score) = search.best().ok_or_else(|| super::without_score(search))?;
    let mut rig = solve(chromosome).0;
    lead(&mut rig);
    rig.extend_from_slice(&genome.decode(chromosome)[searched..]);
    Ok(Outcome { rig, score, history, stopped })
}
