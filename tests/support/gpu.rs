//! A watched Vulkan device, and maps made without any scene.

use glam::{DVec3, Mat4, Vec3};
use klieg::gpu::{Context, ContextOptions, Tuning};
use klieg::lighting::{Light, LightKind, Population, Role};
use klieg::math::frame::Frame;
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, Surface};
use klieg::scene::view::{Camera, Projection, View};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// From here to its thread's end, keeps other tests from validation layers: some (1.3.239) look up what
/// they know of instances and devices without a lock, and crash where two threads make them at once
/// (KhronosGroup/Vulkan-ValidationLayers#4391).
pub fn alone() {
    static LAYER: Mutex<()> = Mutex::new(());
    thread_local! {
        static HELD: MutexGuard<'static, ()> = LAYER.lock().unwrap_or_else(PoisonError::into_inner);
    }
    HELD.with(|_| ());
}

/// The best Vulkan device with the validation layer on; a machine without either fails the test.
pub fn context() -> Arc<Context> {
    with_tuning(Tuning::default())
}

/// The same with other tuning.
pub fn with_tuning(tuning: Tuning) -> Arc<Context> {
    let options = ContextOptions { tuning, ..Default::default() };
    watched(options).expect("a Vulkan device and the validation layer")
}

/// A context with the validation layer on.
///
/// # Errors
/// What [`Context::new`] says.
pub fn watched(options: ContextOptions) -> klieg::Result<Arc<Context>> {
    alone();
    Context::new(&ContextOptions { validation: true, ..options })
}

/// Fails when the validation layer has said anything.
pub fn assert_valid(context: &Context) {
    let messages = context.validation_messages();
    assert!(messages.is_empty(), "{}", messages.join("\n\n"));
}

/// A view from four scene radii in front.
pub fn view(width: u32, height: u32, orthographic: bool) -> View {
    let eye = DVec3::Z * 4.0;
    let (right, up, back) = (DVec3::X, DVec3::Y, DVec3::Z);
    let projection = match orthographic {
        true => Projection::Orthographic { ymag: 1.0 },
        false => Projection::Perspective { yfov: 0.6 },
    };
    let name = "test".into();
    let camera =
        Camera { name, eye, right, up, back, projection, near: 0.1, far: None, designed: None };
    let frame = Frame { center: DVec3::ZERO, radius: 1.0, right, up, back };
    View { width, height, camera, frame, eye: eye.as_vec3(), clip_from_frame: Mat4::IDENTITY }
}

/// What is seen of a scene without triangles: which points of the picture (−1.1..1.1, y up) the
/// object covers, and how far it comes forward there.
pub fn maps(width: u32, height: u32, height_at: impl Fn(f32, f32) -> Option<f32>) -> Maps {
    let mut surface = Surface { width, height, ..Default::default() };
    for i in 0..width * height {
        let x = 2.2 * ((i % width) as f32 + 0.5) / width as f32 - 1.1;
        let y = 1.1 - 2.2 * ((i / width) as f32 + 0.5) / height as f32;
        let at = height_at(x, y);
        let z = at.unwrap_or(0.0);
        let slope = |dx: f32, dy: f32| {
            let (a, b) = (height_at(x - dx, y - dy), height_at(x + dx, y + dy));
            (b.unwrap_or(z) - a.unwrap_or(z)) / 2e-2
        };
        let normal = Vec3::new(-slope(1e-2, 0.0), -slope(0.0, 1e-2), 1.0).normalize();
        // Materials of every kind, in patches.
        let patch = ((x * 5.0).floor() * 7.0 + (y * 5.0).floor() * 3.0).rem_euclid(11.0) / 10.0;
        let keep = |v: [f32; 3]| if at.is_some() { v } else { [0.0; 3] };
        surface.code.push(at.is_some().into());
        surface.depth.push(4.0 - z);
        surface.position.push(keep([x, y, z]));
        surface.normal.push(keep(normal.to_array()));
        surface.face.push(keep(normal.to_array()));
        surface.base_color.push(keep([0.3 + 0.6 * patch, 0.7, 0.9 - 0.7 * patch]));
        surface.metallic.push(keep([(patch * 3.0).fract(); 3])[0]);
        surface.roughness.push(keep([0.1 + 0.9 * (1.0 - patch); 3])[0]);
        surface.emissive.push(keep([(0.3 * patch - 0.2).max(0.0), 0.0, 0.0]));
    }
    klieg::cpu::maps(surface, &Objective::default())
}

/// A bumpy ball before nothing, with a step across it.
pub fn ball(width: u32, height: u32) -> Maps {
    maps(width, height, |x, y| {
        let r2 = x * x + y * y;
        let bumps = 0.05 * (9.0 * x).sin() * (8.0 * y).cos() + if x > 0.3 { 0.2 } else { 0.0 };
        (r2 < 1.0).then(|| (1.0 - r2).sqrt() + bumps)
    })
}

/// `count` random rigs, drawn from the whole sphere of directions.
pub fn rigs(seed: u64, count: usize, lights: usize, kind: LightKind) -> Vec<Vec<Light>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut light = || Light {
        role: Role::Key,
        kind,
        elevation: random.random_range(-0.5..1.5),
        azimuth: random.random_range(-3.1..3.1),
        distance: random.random_range(1.5..5.0),
        diffuse: random.random_range(0.0..2.0) / (lights as f32).sqrt(),
        specular: random.random_range(0.0..2.0) / (lights as f32).sqrt(),
        ..Light::default()
    };
    (0..count).map(|_| (0..lights).map(|_| light()).collect()).collect()
}

/// The rigs as a population.
pub fn population(rigs: &[Vec<Light>]) -> Population {
    Population::of(rigs.iter().map(Vec::as_slice)).expect("rigs of one size")
}
