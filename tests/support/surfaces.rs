//! Visible surfaces made in code, and what compares the native evaluator with the plain stages on
//! them.

use crate::shapes::{camera, matt, rectangle, scene, view};
use glam::{DMat4, DVec3, Vec3};
use klieg::cpu::{CpuEvaluator, fitness};
use klieg::evaluate::Evaluator;
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Role};
use klieg::objective::maps::{Maps, Surface};
use klieg::objective::{Objective, Terms};
use klieg::scene::view::{Projection, View};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest difference of a term between the fast evaluator and the plain stages. Highlights of the
/// largest exponent magnify the last bit of `n·h` four thousand times.
pub const TOLERANCE: f32 = 1e-4;

pub fn rig(random: &mut ChaCha8Rng, lights: usize, strength: f32) -> Vec<Light> {
    let kinds = [LightKind::POINT, LightKind::DIRECTIONAL];
    let mut light = || Light {
        role: Role::Key,
        kind: kinds[random.random_range(0..2)],
        elevation: random.random_range(-0.5..1.5),
        azimuth: random.random_range(-3.0..3.0),
        distance: random.random_range(1.5..5.0),
        diffuse: strength * random.random_range(0.0..1.0f32),
        specular: strength * random.random_range(0.0..1.0f32),
        ..Light::default()
    };
    (0..lights).map(|_| light()).collect()
}

/// A wavy surface with all kinds of materials, where `object` says so.
pub fn surface(width: u32, height: u32, object: impl Fn(u32, u32) -> bool) -> Surface {
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(width * 1000 + height));
    let mut s = Surface { width, height, ..Surface::default() };
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let inside = object(x, y);
        let (u, v) = (x as f32 / width as f32 - 0.5, y as f32 / height as f32 - 0.5);
        let waves = Vec3::new((20.0 * u).sin() * 0.7, (15.0 * v).cos() * 0.7, 0.6);
        let keep = |v: Vec3| if inside { v.to_array() } else { [0.0; 3] };
        let keep1 = |v: f32| if inside { v } else { 0.0 };
        let jump = if u > 0.2 { 0.3 } else { 0.0 };
        let position = Vec3::new(u, -v, 0.1 * waves.x - jump);
        s.code.push(u32::from(inside) * (1 + x / 3));
        s.depth.push(4.0 - position.z);
        s.position.push(keep(position));
        s.normal.push(keep(waves.normalize()));
        s.face.push(keep(waves.normalize()));
        s.base_color.push(keep(Vec3::new(0.9, 0.5 + u, 0.5 + 0.5 * v)));
        s.metallic.push(keep1(if v > 0.3 { 1.0 } else { 0.0 }));
        s.roughness.push(keep1(random.random_range(0.02..1.0)));
        s.emissive.push(keep(Vec3::splat(if u < -0.45 { 0.2 } else { 0.0 })));
    }
    s
}

/// Any view through which such a surface can be seen: what counts is the eye.
pub fn any_view(eye: DVec3) -> View {
    let scene = scene([(rectangle(0.7, 0.7), matt(0.5), DMat4::IDENTITY)]);
    view(&scene, camera(eye, Projection::Perspective { yfov: 0.6 }), 8, 8)
}

pub fn worst(a: &Terms, b: &Terms) -> f32 {
    assert!(a.names().eq(b.names()), "{a:?} {b:?}");
    let pairs = a.values().zip(b.values());
    pairs
        .map(|(a, b)| if a == b { 0.0 } else { (a - b).abs() })
        .fold(0.0, |worst, d| if d.is_nan() || d > worst { d } else { worst })
}

pub struct Bench {
    pub view: View,
    pub objective: Objective,
    pub shading: Shading,
}

impl Bench {
    pub fn new() -> Self {
        Self {
            view: any_view(DVec3::new(0.1, 0.2, 4.0)),
            objective: Objective::default(),
            shading: Shading::default(),
        }
    }

    pub fn evaluator(&self, maps: &Maps) -> CpuEvaluator {
        CpuEvaluator::new(maps.clone(), &self.view, self.objective, self.shading).unwrap()
    }

    pub fn plain(&self, maps: &Maps, rig: &[Light]) -> Terms {
        let records: Vec<_> = rig.iter().map(Light::record).collect();
        fitness::fitness(maps, &self.view, &self.objective, &self.shading, &records).terms
    }

    /// Largest difference of a term for one rig.
    pub fn difference(&self, maps: &Maps, rig: &[Light]) -> f32 {
        let fast = self.evaluator(maps).inspect(rig).expect("a rig").terms;
        worst(&fast, &self.plain(maps, rig))
    }
}
