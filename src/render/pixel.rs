//! One pixel of a final picture: its samples under all lights.

use super::{Settings, Stage, pattern};
use crate::lighting::LightRecord;
use crate::lighting::shading::{self, LightSample, Place, Reflectance, Response};
use crate::math::color::{srgb_decode, srgb_encode};
use crate::objective::maps::Surface;
use crate::objective::{BURNT, UNLIT};
use crate::scene::occluders;
use glam::{Vec2, Vec3};
use std::ops::AddAssign;

/// Rays of a sample to a light with a size, where some of its pixel's rays reach the light and others do not.
const PENUMBRA_RAYS: u32 = 8;

/// What shifts the directions of ambient light; lights have the numbers from 1 on.
const AMBIENT: u32 = 0;

/// A sample of the visible surface.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    place: Place,
    /// Unit normal of the polygon, turned to the viewer.
    face: Vec3,
    looks: Reflectance,
    /// Emitted radiance, linear RGB.
    emissive: Vec3,
    /// Its number among the samples of its pixel.
    index: u32,
}

/// Numbers of samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// On objects.
    pub object: u64,
    /// With a burnt-out channel.
    pub burnt: u64,
    /// That no light reaches.
    pub unlit: u64,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.object += other.object;
        self.burnt += other.burnt;
        self.unlit += other.unlit;
    }
}

/// Paints the pixels of a surface that was drawn with several samples a pixel.
pub struct Painter<'a> {
    pub stage: &'a Stage<'a>,
    pub rig: &'a [LightRecord],
    pub settings: &'a Settings,
    pub surface: &'a Surface,
}

impl Painter<'_> {
    /// Puts the samples of a pixel of the surface that lie on objects into `samples`.
    pub fn samples(&self, [x, y]: [u32; 2], samples: &mut Vec<Sample>) {
        let side = self.settings.side();
        samples.clear();
        for index in 0..side * side {
            let (column, row) = (x * side + index % side, y * side + index / side);
            let at = row as usize * self.surface.width as usize + column as usize;
            if self.surface.code[at] != 0 {
                samples.push(self.sample(at, index));
            }
        }
    }

    fn sample(&self, at: usize, index: u32) -> Sample {
        let surface = self.surface;
        let (position, normal) = (Vec3::from(surface.position[at]), Vec3::from(surface.normal[at]));
        let to_viewer = self.stage.view.towards_viewer(position);
        Sample {
            place: Place { position, normal, to_viewer },
            face: surface.face[at].into(),
            looks: surface.reflectance(self.stage.shading, at),
            emissive: surface.emissive[at].into(),
            index,
        }
    }

    /// Colour and alpha of pixel `at` of the picture with these samples on objects.
    pub fn pixel(&self, at: [u32; 2], samples: &[Sample]) -> ([u8; 4], Counts) {
        let mut lit: Vec<Response> = samples.iter().map(|sample| self.unlit(at, sample)).collect();
        for (number, light) in (AMBIENT + 1..).zip(self.rig) {
            self.add(light, pattern::shift(at, number), samples, &mut lit);
        }
        let burnt = srgb_decode(BURNT);
        let count = |counted: &dyn Fn(&Response) -> bool| {
            lit.iter().filter(|response| counted(response)).count() as u64
        };
        let counts = Counts {
            object: lit.len() as u64,
            burnt: count(&|response| response.radiance.max_element() >= burnt),
            unlit: count(&|response| response.irradiance < UNLIT),
        };
        let sum: Vec3 = lit.iter().map(|response| response.radiance).sum();
        let radiance = sum / lit.len().max(1) as f32;
        let coverage = lit.len() as f32 / self.settings.samples as f32;
        let object = self.settings.tone_mapping.apply(radiance);
        let background = self.settings.background.unwrap_or_default();
        let [r, g, b, alpha] = background.behind(object, coverage).to_array();
        let byte = |value: f32| (value * 255.0).round() as u8;
        let [r, g, b] = [r, g, b].map(|channel| byte(srgb_encode(channel)));
        ([r, g, b, byte(alpha)], counts)
    }

    /// What a sample shows without any light: what it emits, and the ambient light that reaches it.
    fn unlit(&self, pixel: [u32; 2], sample: &Sample) -> Response {
        let ambient = sample.looks.unlit - sample.emissive;
        let square = pattern::even(sample.index, pattern::shift(pixel, AMBIENT));
        let seen = ambient != Vec3::ZERO
            && self.sees(sample, pattern::cosine(square, sample.place.normal), f32::INFINITY);
        let radiance = if seen { sample.looks.unlit } else { sample.emissive };
        Response { radiance, irradiance: 0.0 }
    }

    /// Adds what a light does to every sample.
    fn add(&self, light: &LightRecord, shift: Vec2, samples: &[Sample], lit: &mut [Response]) {
        let respond = |s: &Sample| self.stage.shading.response(light, &s.place, &s.looks);
        let responses: Vec<Response> = samples.iter().map(respond).collect();
        let reached =
            |response: &Response| response.irradiance > 0.0 || response.radiance != Vec3::ZERO;
        let reached: Vec<usize> =
            (0..samples.len()).filter(|&at| reached(&responses[at])).collect();
        let ray = |at: usize, round: u32| {
            let index = round * self.settings.samples + samples[at].index;
            self.sees_light(&samples[at], light, pattern::disc(pattern::even(index, shift)))
        };
        let mut seen: Vec<u32> = reached.iter().map(|&at| u32::from(ray(at, 0))).collect();
        let mut rays = 1;
        let first: usize = seen.iter().filter(|&&seen| seen > 0).count();
        if light.size > 0.0 && (1..reached.len()).contains(&first) {
            rays = PENUMBRA_RAYS;
            for (seen, &at) in seen.iter_mut().zip(&reached) {
                *seen += (1..rays).map(|round| u32::from(ray(at, round))).sum::<u32>();
            }
        }
        for (seen, at) in seen.into_iter().zip(reached) {
            let visibility = seen as f32 / rays as f32;
            lit[at].radiance += responses[at].radiance * visibility;
            lit[at].irradiance += responses[at].irradiance * visibility;
        }
    }

    /// Whether a sample sees the point `disc` of a light, whose own disc has the radius 1.
    fn sees_light(&self, sample: &Sample, light: &LightRecord, disc: Vec2) -> bool {
        let LightSample { towards, .. } = shading::sample(light, sample.place.position);
        let is_point = light.radius2 > 0.0;
        let distance =
            if is_point { sample.place.position.distance(light.position.into()) } else { 1.0 };
        let (x, y) = towards.any_orthonormal_pair();
        let way = towards * distance + (x * disc.x + y * disc.y) * light.size;
        let length = way.length();
        self.sees(sample, way / length, if is_point { length } else { f32::INFINITY })
    }

    /// Whether nothing stands within `distance` of a sample in that unit direction. What points below the
    /// sample's own polygon, where the smooth normal alone still sees the light, is looked for along the polygon:
    /// so a smooth terminator stays smooth, and what something else shadows stays dark.
    fn sees(&self, sample: &Sample, direction: Vec3, distance: f32) -> bool {
        let Some(occluders) = self.stage.occluders else { return true };
        let Sample { place, face, .. } = *sample;
        let above = face.dot(direction);
        let direction = match above > 0.0 {
            true => direction,
            false => (direction - above * face).normalize_or(face),
        };
        !occluders.blocked(occluders::leave(place.position, face), direction, distance)
    }
}
