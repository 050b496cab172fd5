//! One pixel of a final picture: its samples under all lights.

use super::{Settings, Stage, pattern};
use crate::lighting::LightRecord;
use crate::lighting::shading::{self, LightSample, Place, Reflectance, Response};
use crate::math::color::{srgb_decode, srgb_encode};
use crate::objective::maps::Surface;
use crate::objective::{BURNT, UNLIT};
use crate::scene::occluders::{self, Packet, RAYS};
use glam::{Vec2, Vec3, Vec3A};
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

    /// Colour and alpha of pixel `at` of the picture under each rig with these samples on objects.
    pub fn pixel(
        &self,
        at: [u32; 2],
        samples: &[Sample],
        rigs: &[&[LightRecord]],
    ) -> impl Iterator<Item = ([u8; 4], Counts)> {
        let unlit = self.unlit(at, samples);
        rigs.iter().map(move |rig| {
            let mut lit = unlit.clone();
            for (number, light) in (AMBIENT + 1..).zip(*rig) {
                self.add(light, pattern::shift(at, number), samples, &mut lit);
            }
            self.resolve(&lit)
        })
    }

    /// Colour, alpha and counts of what the samples of a pixel show.
    fn resolve(&self, lit: &[Response]) -> ([u8; 4], Counts) {
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

    /// What samples show without any light: what they emit, and the ambient light that reaches them.
    fn unlit(&self, pixel: [u32; 2], samples: &[Sample]) -> Vec<Response> {
        let respond = |radiance| Response { radiance, irradiance: 0.0 };
        if self.stage.shading.ambient == 0.0 {
            return samples.iter().map(|sample| respond(sample.emissive)).collect();
        }
        let shift = pattern::shift(pixel, AMBIENT);
        let rays = samples.iter().map(|sample| {
            let square = pattern::even(sample.index, shift);
            Ray::new(sample, pattern::cosine(square, sample.place.normal), f32::INFINITY)
        });
        let mut seen = vec![0; samples.len()];
        self.count_free(rays, &mut seen);
        let radiance = |(sample, seen): (&Sample, u32)| match seen {
            0 => sample.emissive,
            _ => sample.looks.unlit,
        };
        samples.iter().zip(seen).map(radiance).map(respond).collect()
    }

    /// Adds what a light does to every sample.
    fn add(&self, light: &LightRecord, shift: Vec2, samples: &[Sample], lit: &mut [Response]) {
        let respond = |s: &Sample| self.stage.shading.response(light, &s.place, &s.looks);
        let responses: Vec<Response> = samples.iter().map(respond).collect();
        let reached =
            |response: &Response| response.irradiance > 0.0 || response.radiance != Vec3::ZERO;
        let reached: Vec<usize> =
            (0..samples.len()).filter(|&at| reached(&responses[at])).collect();
        let mut seen = vec![0u32; reached.len()];
        let mut round = |number: u32| {
            let rays = reached.iter().map(|&at| {
                let index = number * self.settings.samples + samples[at].index;
                self.to_light(&samples[at], light, pattern::disc(pattern::even(index, shift)))
            });
            self.count_free(rays, &mut seen);
            seen.iter().filter(|&&seen| seen > 0).count()
        };
        let first = round(0);
        let mut rays = 1;
        if light.size > 0.0 && (1..reached.len()).contains(&first) {
            rays = PENUMBRA_RAYS;
            for number in 1..rays {
                round(number);
            }
        }
        for (seen, at) in seen.into_iter().zip(reached) {
            let visibility = seen as f32 / rays as f32;
            lit[at].radiance += responses[at].radiance * visibility;
            lit[at].irradiance += responses[at].irradiance * visibility;
        }
    }

    /// The ray from a sample to the point `disc` of a light, whose own disc has the radius 1.
    fn to_light(&self, sample: &Sample, light: &LightRecord, disc: Vec2) -> Ray {
        let LightSample { towards, .. } = shading::sample(light, sample.place.position);
        let is_point = light.radius2 > 0.0;
        let distance =
            if is_point { sample.place.position.distance(light.position.into()) } else { 1.0 };
        // Of three lanes compilers make vectors of four, whose last one may hold what is slow to calculate with.
        let towards = Vec3A::from(towards);
        let (x, y) = towards.any_orthonormal_pair();
        let way = towards * distance + (x * disc.x + y * disc.y) * light.size;
        let length = way.length();
        Ray::new(sample, (way / length).into(), if is_point { length } else { f32::INFINITY })
    }

    /// Adds 1 to the count of every ray that nothing blocks.
    fn count_free(&self, mut rays: impl Iterator<Item = Ray>, counts: &mut [u32]) {
        let Some(occluders) = self.stage.occluders else {
            return counts.iter_mut().for_each(|count| *count += 1);
        };
        for counts in counts.chunks_mut(RAYS) {
            let mut packet = Packet::default();
            for Ray { from, direction, distance } in rays.by_ref().take(counts.len()) {
                packet.push(from, direction, distance);
            }
            let blocked = occluders.blocked_rays(&packet);
            for (ray, count) in counts.iter_mut().enumerate() {
                *count += 1 ^ (blocked >> ray & 1);
            }
        }
    }
}

/// A ray that looks for what blocks light.
#[derive(Debug, Clone, Copy)]
struct Ray {
    from: Vec3,
    direction: Vec3,
    distance: f32,
}

impl Ray {
    /// From a sample in a unit direction. What points below the sample's own polygon, where the smooth normal
    /// alone still sees the light, is looked for along the polygon: so a smooth terminator stays smooth, and what
    /// something else shadows stays dark.
    fn new(sample: &Sample, direction: Vec3, distance: f32) -> Self {
        let Sample { place, face, .. } = *sample;
        let above = face.dot(direction);
        let direction = match above > 0.0 {
            true => direction,
            false => (direction - above * face).normalize_or(face),
        };
        Self { from: occluders::leave(place.position, face), direction, distance }
    }
}
